//! Second sheets that lie too far behind their leaves to be taken for the other side: whether the leaf area is stated
//! twice, only the maker of the mesh knows.
//!
//! Some leaf triangles are looked at, spread over all. One is doubled where other parallel leaves lie before each of
//! its points that are looked at, or behind each, all about as far away: either sheet may be cut into triangles in its
//! own way. What lies nearer than [`crate::sheets`] looks for is one leaf already.

use glam::{DVec3, I64Vec3};
use rayon::prelude::*;

use super::Doubt;
use crate::mesh::sides::Side;
use crate::{ClassedMesh, MaterialClass, Mesh};

/// Leaf triangles that are looked at.
const LOOKED_AT: usize = 1024;
/// Points of a triangle that are looked at: weights of its corners. They lie off its edges, so that a second sheet may
/// be a little smaller or turned.
const POINTS: [[f64; 3]; 3] = [[0.7, 0.15, 0.15], [0.15, 0.7, 0.15], [0.15, 0.15, 0.7]];
/// How far a second sheet lies at most, as a share of the longest edge and of the least height of a triangle: a leaf
/// beside a leaf, or the far side of a needle, lies farther.
const APART: [f64; 2] = [0.06, 0.25];
/// That distance is at most so many times the mean over the leaf area.
const MAX_REACH: f64 = 4.0;
/// Gaps at the points of one triangle differ by no more than this factor.
const ALIKE: f64 = 1.5;
/// Least cosine between the normals of two sheets.
const PARALLEL: f64 = 0.9;
/// A gap is more than what coordinates are rounded by, as a share of the plant's longest edge.
const ROUNDING: f64 = 1e-6;
/// Least share of the leaf area that is worth a doubt.
const MIN_SHARE: f64 = 0.05;
/// Cubes that the surroundings of a triangle may meet: one that meets more is compared with all points.
const MAX_CUBES: i64 = 512;
/// Cubes along the plant's longest edge.
const MAX_ACROSS: f64 = 64.0;

/// A triangle that is looked at.
struct Flat {
    triangle: u32,
    normal: DVec3,
    area_m2: f64,
    reach_m: f64,
}

impl Flat {
    fn of(mesh: &Mesh, triangle: u32) -> Option<Flat> {
        let [a, b, c] = corners(mesh, triangle);
        let cross = (b - a).cross(c - a);
        let longest = a.distance(b).max(b.distance(c)).max(c.distance(a));
        let (twice, normal) = (cross.length(), cross.try_normalize()?);
        let reach_m = (APART[0] * longest).min(APART[1] * twice / longest);
        let is_flat = reach_m > 0.0 && reach_m.is_finite();
        is_flat.then_some(Flat { triangle, normal, area_m2: 0.5 * twice, reach_m })
    }

    fn points(&self, mesh: &Mesh) -> [DVec3; 3] {
        let [a, b, c] = corners(mesh, self.triangle);
        POINTS.map(|[of_a, of_b, of_c]| of_a * a + of_b * b + of_c * c)
    }
}

fn corners(mesh: &Mesh, triangle: u32) -> [DVec3; 3] {
    mesh.triangles[triangle as usize]
        .map(|vertex| DVec3::from_array(mesh.positions[vertex as usize].map(f64::from)))
}

/// A leaf triangle that may be a second sheet.
struct Other {
    triangle: u32,
    corners: [DVec3; 3],
    /// Of twice its area.
    cross: DVec3,
}

impl Other {
    fn of(mesh: &Mesh, triangle: u32) -> Other {
        let corners = corners(mesh, triangle);
        let cross = (corners[1] - corners[0]).cross(corners[2] - corners[0]);
        Other { triangle, corners, cross }
    }

    /// How far before a point of `flat` this triangle lies, if it is parallel, near and neither the same nor beside it.
    fn gap(&self, flat: &Flat, point: DVec3) -> Option<f64> {
        let facing = flat.normal.dot(self.cross);
        if self.triangle == flat.triangle || facing.abs() < PARALLEL * self.cross.length() {
            return None;
        }
        let gap = (self.corners[0] - point).dot(self.cross) / facing;
        if gap.abs() > flat.reach_m {
            return None;
        }
        let at = point + gap * flat.normal;
        let [a, b, c] = self.corners.map(|corner| corner - at);
        let sides = [a.cross(b), b.cross(c), c.cross(a)].map(|side| side.dot(self.cross));
        sides.iter().all(|side| *side >= 0.0).then_some(gap)
    }
}

/// Mean over the area of triangles.
fn mean(flats: &[Flat], of: impl Fn(&Flat) -> f64) -> f64 {
    let areas_m2: f64 = flats.iter().map(|flat| flat.area_m2).sum();
    flats.iter().map(|flat| flat.area_m2 * of(flat)).sum::<f64>() / areas_m2
}

/// The least gaps to leaves before a point that was looked at, and behind it; infinite where there is none.
type Gaps = [f64; 2];

/// Doubts a plant of whose leaves a good part has a second sheet.
pub(super) fn doubt(plant: &ClassedMesh, longest_m: f64) -> Option<Doubt> {
    let mesh = &plant.mesh;
    let is_leaf = |&triangle: &u32| {
        plant.classes[mesh.triangle_material[triangle as usize] as usize] == MaterialClass::Leaf
            && mesh.sheets.side(triangle as usize) == Side::Both
    };
    let leaves: Vec<u32> = (0..mesh.triangles.len() as u32).filter(is_leaf).collect();
    let wanted = leaves.len().min(LOOKED_AT);
    let some = (0..wanted).filter_map(|at| Flat::of(mesh, leaves[at * leaves.len() / wanted]));
    let mut flats: Vec<Flat> = some.collect();
    if flats.is_empty() {
        return None;
    }
    // The reach of a few large triangles is not searched around all.
    let mean_reach_m = mean(&flats, |flat| flat.reach_m);
    flats.iter_mut().for_each(|flat| flat.reach_m = flat.reach_m.min(MAX_REACH * mean_reach_m));
    let points: Vec<DVec3> = flats.iter().flat_map(|flat| flat.points(mesh)).collect();
    let near = Near::of(&flats, &points, longest_m);
    let rounding_m = ROUNDING * longest_m;
    let nothing = || vec![[f64::INFINITY; 2]; points.len()];
    // The least gap on either side: however many sheets lie there, a point has one number for each.
    let meet = |mut gaps: Vec<Gaps>, &triangle: &u32| {
        let other = Other::of(mesh, triangle);
        near.each(&other.corners, |number| {
            let gap = other.gap(&flats[number as usize / POINTS.len()], points[number as usize]);
            if let Some(gap) = gap.filter(|gap| gap.abs() > rounding_m) {
                let least = &mut gaps[number as usize][usize::from(gap < 0.0)];
                *least = least.min(gap.abs());
            }
        });
        gaps
    };
    let of_both = |a: Vec<Gaps>, b: Vec<Gaps>| {
        a.into_iter().zip(b).map(|(a, b)| [a[0].min(b[0]), a[1].min(b[1])]).collect()
    };
    let gaps: Vec<Gaps> = leaves.par_iter().with_min_len(4096).fold(nothing, meet).reduce(nothing, of_both);
    let (mut sheets_m2, mut gap_sum) = (0.0, 0.0);
    for (flat, gaps) in flats.iter().zip(gaps.chunks_exact(POINTS.len())) {
        if let Some(gap_m) = common_gap(gaps) {
            sheets_m2 += flat.area_m2;
            gap_sum += gap_m * flat.area_m2;
        }
    }
    let looked_m2: f64 = flats.iter().map(|flat| flat.area_m2).sum();
    if sheets_m2 <= MIN_SHARE * looked_m2 {
        return None;
    }
    let leaf_m2: f64 =
        leaves.iter().filter_map(|&triangle| Flat::of(mesh, triangle)).map(|flat| flat.area_m2).sum();
    Some(Doubt::SecondSheets {
        sheets_m2: leaf_m2 * sheets_m2 / looked_m2,
        leaf_m2,
        gap_m: gap_sum / sheets_m2,
    })
}

/// The gap that all points of a triangle have to one side, if they have.
fn common_gap(gaps: &[Gaps]) -> Option<f64> {
    let to_side = |side: usize| {
        let of_side = || gaps.iter().map(|gaps| gaps[side]);
        let (least, most) = (of_side().fold(f64::INFINITY, f64::min), of_side().fold(0.0, f64::max));
        (most.is_finite() && most <= ALIKE * least).then_some(least)
    };
    [0, 1].into_iter().filter_map(to_side).reduce(f64::min)
}

/// Points that are looked at, by the cubes of a lattice.
struct Near {
    cubes_per_m: f64,
    /// The farthest that a triangle lies from a point that it doubles.
    reach_m: f64,
    /// Number of places, a power of two.
    places: usize,
    /// `[place]`: where its list starts, and the end of the last.
    starts: Vec<u32>,
    /// `(place, number of the point)`, sorted.
    lists: Vec<(u32, u32)>,
    /// A bit each place: whether its list has an entry. Most have none, and bits stay in the fastest memory.
    is_filled: Vec<u64>,
}

impl Near {
    fn of(flats: &[Flat], points: &[DVec3], longest_m: f64) -> Near {
        let reach_m = flats.iter().map(|flat| flat.reach_m).fold(0.0, f64::max);
        // As large as most of the leaf's triangles, which so meet few cubes.
        let cube_m = (2.0 * mean(flats, |flat| flat.area_m2.sqrt())).max(longest_m / MAX_ACROSS);
        // Several times their entries: most leaves find an empty list.
        let places = (points.len() * 32).next_power_of_two();
        let mut near = Near {
            cubes_per_m: 1.0 / cube_m,
            reach_m,
            places,
            starts: vec![0; places + 1],
            lists: Vec::new(),
            is_filled: vec![0; places.div_ceil(64)],
        };
        let of_points = (0u32..).zip(points).map(|(number, point)| (near.place(near.cube(*point)), number));
        near.lists = of_points.collect();
        near.lists.sort_unstable();
        for (place, _) in &near.lists {
            near.starts[*place as usize + 1] += 1;
            near.is_filled[*place as usize / 64] |= 1 << (place % 64);
        }
        (0..places).for_each(|place| near.starts[place + 1] += near.starts[place]);
        near
    }

    /// Calls `meet` with the numbers of points that may be near to a triangle, some of them more than once.
    fn each(&self, corners: &[DVec3; 3], mut meet: impl FnMut(u32)) {
        let [a, b, c] = *corners;
        let low = self.cube(a.min(b).min(c) - self.reach_m);
        let high = self.cube(a.max(b).max(c) + self.reach_m);
        let cubes = high - low + 1;
        if cubes.x.saturating_mul(cubes.y).saturating_mul(cubes.z) > MAX_CUBES {
            return self.lists.iter().for_each(|(_, number)| meet(*number));
        }
        for z in low.z..=high.z {
            for y in low.y..=high.y {
                for x in low.x..=high.x {
                    let place = self.place(I64Vec3::new(x, y, z)) as usize;
                    if self.is_filled[place / 64] >> (place % 64) & 1 == 1 {
                        let list = self.starts[place] as usize..self.starts[place + 1] as usize;
                        self.lists[list].iter().for_each(|(_, number)| meet(*number));
                    }
                }
            }
        }
    }

    /// Without rounding down, which takes the time of all the rest: cubes around 0 are twice as wide.
    fn cube(&self, point: DVec3) -> I64Vec3 {
        (point * self.cubes_per_m).as_i64vec3()
    }

    fn place(&self, cube: I64Vec3) -> u32 {
        let mixed = (cube.x as u64)
            .wrapping_mul(0x9e37_79b9_7f4a_7c15)
            .wrapping_add((cube.y as u64).wrapping_mul(0xc2b2_ae3d_27d4_eb4f))
            .wrapping_add((cube.z as u64).wrapping_mul(0x1656_67b1_9e37_79f9));
        ((mixed ^ (mixed >> 29)).wrapping_mul(0xbf58_476d_1ce4_e5b9) >> 32) as u32 & (self.places as u32 - 1)
    }
}

#[cfg(test)]
mod tests {
    use flb_fixtures::{PlantKind, grow};
    use glam::DQuat;

    use super::*;
    use crate::PlantReader;
    use crate::mesh::testing::soup;

    /// Square leaves of 0.1 m in a plant of 2 m, of which every `one_of`th has a second sheet so far before it, cut
    /// along the other diagonal.
    fn plant(one_of: usize, gap_m: f64) -> ClassedMesh {
        of_size(one_of, gap_m, 1.0)
    }

    /// The same with second sheets of another size.
    fn of_size(one_of: usize, gap_m: f64, size: f64) -> ClassedMesh {
        let mut triangles = Vec::new();
        for number in 0..300usize {
            let place = |step: f64| (number as f64 * step).fract();
            let middle = DVec3::new(place(0.618), 2.0 * place(0.414), place(0.732));
            let turn =
                DQuat::from_rotation_y(7.0 * place(0.123)) * DQuat::from_rotation_x(1.4 * place(0.377));
            let corner = |x: f64, y: f64, height: f64| {
                (middle + turn * DVec3::new(0.1 * x, height, 0.1 * y)).as_vec3().to_array()
            };
            let square = |height: f64, size: f64| {
                let of = |c: f64| 0.5 + size * (c - 0.5);
                [[0.0, 0.0], [1.0, 0.0], [1.0, 1.0], [0.0, 1.0]].map(|[x, y]| corner(of(x), of(y), height))
            };
            let [a, b, c, d] = square(0.0, 1.0);
            triangles.extend([[a, b, c], [a, c, d]]);
            if number % one_of == 0 {
                let [a, b, c, d] = square(gap_m, size);
                triangles.extend([[a, d, b], [b, d, c]]);
            }
        }
        let mut mesh = soup(&triangles);
        mesh.triangle_material.fill(0);
        ClassedMesh::of(mesh, vec![MaterialClass::Leaf; 2])
    }

    #[test]
    fn second_sheets_of_one_outline_are_a_doubt_with_their_area() {
        for gap_m in [0.001, -0.003, 0.005] {
            match doubt(&plant(1, gap_m), 2.0) {
                Some(Doubt::SecondSheets { sheets_m2, leaf_m2, gap_m: found_m }) => {
                    assert!((leaf_m2 - 6.0).abs() < 1e-4, "{leaf_m2}");
                    assert!(sheets_m2 > 0.99 * leaf_m2, "{sheets_m2}");
                    assert!((found_m / gap_m.abs() - 1.0).abs() < 0.05, "{found_m}");
                }
                other => panic!("{gap_m}: {other:?}"),
            }
        }
        let Some(Doubt::SecondSheets { sheets_m2, .. }) = doubt(&plant(3, 0.002), 2.0) else {
            panic!("a third")
        };
        assert!((sheets_m2 - 2.0).abs() < 0.1, "{sheets_m2}");
        for size in [0.95, 1.04] {
            let found = doubt(&of_size(1, 0.001, size), 2.0);
            assert!(matches!(found, Some(Doubt::SecondSheets { .. })), "{size}: {found:?}");
        }
        let text = doubt(&plant(1, 0.002), 2.0).map(|doubt| doubt.to_string()).unwrap_or_default();
        assert!(text.contains("of 6 m2 of leaf have a second sheet 0.002 m"), "{text}");
    }

    #[test]
    fn leaves_beside_leaves_and_those_of_one_sheet_or_of_two_that_were_found_are_no_doubt() {
        assert_eq!(doubt(&plant(400, 0.02), 2.0), None);
        assert_eq!(doubt(&plant(1, 0.03), 2.0), None);
        assert_eq!(doubt(&plant(1, 0.0002), 2.0), None, "two sides of one leaf");
        for kind in [PlantKind::Oak, PlantKind::Spruce, PlantKind::Shrub] {
            let folder = tempfile::tempdir().expect("a folder");
            let path = folder.path().join("plant.glb");
            std::fs::write(&path, grow(kind, 7, 20_000).expect("a kind").to_glb()).expect("written");
            let (plant, _) = PlantReader::default().read(&path).expect("a plant");
            assert_eq!(doubt(&plant, 10.0), None, "{kind:?}");
        }
    }
}
