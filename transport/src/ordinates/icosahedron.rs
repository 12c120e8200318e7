//! Suns spread evenly over the sphere, with their triangulation: the corners of an icosahedron, and the middles of its
//! edges.
//!
//! Square roots and divisions alone make them, so they are the same bits on every machine.

use flb_format::sun::directions::SunDirections;

use super::SunBasis;

/// The 12 corners of an icosahedron, one straight up; 20 triangles.
pub fn ico12() -> SunBasis {
    let (directions, triangles) = icosahedron();
    listed(directions, triangles)
}

/// Returns the corners of an icosahedron and the middle of each edge, pushed out to the sphere: 42 directions, 80
/// triangles.
pub fn ico42() -> SunBasis {
    let (mut directions, triangles) = icosahedron();
    let mut edges: Vec<[u32; 2]> = triangles.iter().flat_map(|&[a, b, c]| [[a, b], [b, c], [c, a]]).collect();
    edges.retain(|[from, to]| from < to);
    edges.sort_unstable();
    for edge in &edges {
        let [a, b] = edge.map(|corner| directions[corner as usize]);
        directions.push(unit(std::array::from_fn(|i| a[i] + b[i])));
    }
    let middle = |a: u32, b: u32| {
        let at = edges.binary_search(&[a.min(b), a.max(b)]).expect("every edge of a triangle is listed");
        12 + at as u32
    };
    let parts = triangles.iter().flat_map(|&[a, b, c]| {
        let (ab, bc, ca) = (middle(a, b), middle(b, c), middle(c, a));
        [[a, ab, ca], [ab, b, bc], [ca, bc, c], [ab, bc, ca]]
    });
    let parts = parts.collect();
    listed(directions, parts)
}

/// Corners: the top, five above the horizon, five below it between them, the bottom.
fn icosahedron() -> (Vec<[f64; 3]>, Vec<[u32; 3]>) {
    let root = libm::sqrt;
    // Cosine and sine of 0, 72, 144, 216 and 288 degrees.
    let (cos_72, sin_72) = ((root(5.0) - 1.0) / 4.0, root((5.0 + root(5.0)) / 8.0));
    let (cos_144, sin_144) = (-(root(5.0) + 1.0) / 4.0, root((5.0 - root(5.0)) / 8.0));
    let around = [[1.0, 0.0], [cos_72, sin_72], [cos_144, sin_144], [cos_144, -sin_144], [cos_72, -sin_72]];
    let (height, across) = (1.0 / root(5.0), 2.0 / root(5.0));
    let mut directions = vec![[0.0, 1.0, 0.0]];
    directions.extend(around.map(|[cos, sin]| [across * cos, height, across * sin]));
    directions.extend(around.map(|[cos, sin]| [-across * cos, -height, -across * sin]));
    directions.push([0.0, -1.0, 0.0]);
    // Lower corner 6 + k is opposite upper corner 1 + k, so below the edge of 1 + (k + 2) mod 5 and 1 + (k + 3) mod 5.
    let triangles = (0..5).flat_map(|k| {
        let (upper, lower) = (|k: u32| 1 + k % 5, |k: u32| 6 + k % 5);
        [
            [0, upper(k + 1), upper(k)],
            [upper(k), upper(k + 1), lower(k + 3)],
            [upper(k + 1), lower(k + 4), lower(k + 3)],
            [11, lower(k), lower(k + 1)],
        ]
    });
    (directions, triangles.collect())
}

/// In the one order that a list of triangles has.
fn listed(directions: Vec<[f64; 3]>, mut triangles: Vec<[u32; 3]>) -> SunBasis {
    for triangle in &mut triangles {
        let smallest = (0..3).min_by_key(|&at| triangle[at]).expect("there are three");
        triangle.rotate_left(smallest);
    }
    triangles.sort_unstable();
    let list = SunDirections::new(directions, triangles).expect("an icosahedron covers the sphere once");
    SunBasis::Directions(list.into())
}

fn unit(v: [f64; 3]) -> [f64; 3] {
    let length = libm::sqrt(v.iter().map(|c| c * c).sum());
    v.map(|c| c / length)
}

#[cfg(test)]
mod tests {
    use super::*;

    /// Rounding of a few operations.
    const ROUNDING: f64 = 1e-15;

    fn list(suns: &SunBasis) -> &SunDirections {
        match suns {
            SunBasis::Directions(list) => list,
            other => panic!("{other:?} is no list"),
        }
    }

    #[test]
    fn they_are_spread_evenly_and_one_is_straight_up() {
        // Nearest neighbours of an icosahedron's corners are atan 2 apart, those of a corner and a middle half of that.
        let nearest =
            [(ico12(), 12, 20, 1.0 / libm::sqrt(5.0)), (ico42(), 42, 80, libm::cos(libm::atan(2.0) / 2.0))];
        for (suns, count, triangles, closest) in nearest {
            let list = list(&suns);
            assert_eq!((list.directions().len(), list.triangles().len()), (count, triangles));
            assert_eq!(list.directions()[0], [0.0, 1.0, 0.0]);
            for (at, a) in list.directions().iter().enumerate() {
                let cosine = |b: &[f64; 3]| a.iter().zip(b).map(|(a, b)| a * b).sum::<f64>();
                assert!((cosine(a) - 1.0).abs() < ROUNDING, "{a:?}");
                let others = list.directions().iter().enumerate().filter(|(other, _)| *other != at);
                let found = others.map(|(_, b)| cosine(b)).fold(-1.0, f64::max);
                assert!((found - closest).abs() < ROUNDING, "direction {at}: {found} for {closest}");
                let antipode = list.directions().iter().map(cosine).fold(1.0, f64::min);
                assert!((antipode + 1.0).abs() < ROUNDING, "direction {at} has no opposite");
            }
        }
    }

    /// Files hold these numbers, so a change of a bit is a change of files.
    #[test]
    fn they_are_the_same_bits_on_every_machine() {
        let digest = |suns: &SunBasis| {
            let list = list(suns);
            let bits = list.directions().iter().flatten().flat_map(|c| (c + 0.0).to_le_bytes());
            let bytes: Vec<u8> = bits.chain(list.triangles().iter().flatten().copied()).collect();
            blake3::hash(&bytes).to_hex()[..16].to_owned()
        };
        assert_eq!([digest(&ico12()), digest(&ico42())], ["e4a146f56320272f", "6a84fc56a8c0b0a0"]);
    }
}
