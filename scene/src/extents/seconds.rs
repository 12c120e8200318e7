//! Second sheets that lie too far behind their leaves to be taken for the other side: whether the leaf area is stated
//! twice, only the maker of the mesh knows.
//!
//! Some leaf triangles are looked at, spread over all. One is doubled where each of its corners has a corner of another
//! parallel leaf before it, or each has one behind it, all about as far away and hardly aside: the outlines are equal,
//! however either is cut into triangles. What lies nearer than [`crate::sheets`] looks for is one leaf already.

use glam::DVec3;
use rayon::prelude::*;

use super::Doubt;
use crate::mesh::sides::Side;
use crate::{ClassedMesh, MaterialClass, Mesh};

/// Leaf triangles that are looked at.
const LOOKED_AT: usize = 1024;
/// How far a second sheet lies at most, as a share of the longest edge and of the least height of a triangle: a leaf
/// beside a leaf, or the far side of a needle, lies farther.
const APART: [f64; 2] = [0.06, 0.25];
/// How far a corner may lie aside of the one that it doubles, as a share of how far it lies before it..
const ASIDE: f64 = 0.5;
/// ..or, if that is more, of the longest edge and of the least height: second sheets may be a little smaller or turned.
const SKEWED: [f64; 2] = [0.08, 0.15];
/// Gaps at the corners of one triangle differ by no more than this factor.
const ALIKE: f64 = 1.5;
/// Least cosine between the normals of two sheets.
const PARALLEL: f64 = 0.9;
/// A gap is more than what coordinates are rounded by, as a share of the plant's longest edge.
const ROUNDING: f64 = 1e-6;
/// Least share of the leaf area that is worth a doubt.
const MIN_SHARE: f64 = 0.05;
/// Cubes that the surroundings of a corner may meet: larger triangles among small ones are not looked at.
const MAX_CUBES: i64 = 512;

/// A triangle that is looked at.
struct Flat {
    triangle: u32,
    corners: [DVec3; 3],
    normal: DVec3,
    area_m2: f64,
    reach_m: f64,
    aside_m: f64,
}

impl Flat {
    fn of(mesh: &Mesh, triangle: u32) -> Option<Flat> {
        let corners = corners(mesh, triangle);
        let [a, b, c] = corners;
        let cross = (b - a).cross(c - a);
        let longest = a.distance(b).max(b.distance(c)).max(c.distance(a));
        let (twice, normal) = (cross.length(), cross.try_normalize()?);
        let least = |[of_edge, of_height]: [f64; 2]| (of_edge * longest).min(of_height * twice / longest);
        let [reach_m, aside_m] = [APART, SKEWED].map(least);
        (reach_m > 0.0 && reach_m.is_finite()).then_some(Flat {
            triangle,
            corners,
            normal,
            area_m2: 0.5 * twice,
            reach_m,
            aside_m,
        })
    }

    /// How far before a corner of this triangle another point lies, if it may double that corner.
    fn gap(&self, corner: usize, point: DVec3) -> Option<f64> {
        let off = point - self.corners[corner];
        let gap = off.dot(self.normal);
        let aside_m = self.aside_m.max(ASIDE * gap.abs());
        let is_near = gap.abs() <= self.reach_m && (off - gap * self.normal).length() <= aside_m;
        is_near.then_some(gap)
    }
}

fn corners(mesh: &Mesh, triangle: u32) -> [DVec3; 3] {
    mesh.triangles[triangle as usize]
        .map(|vertex| DVec3::from_array(mesh.positions[vertex as usize].map(f64::from)))
}

/// A corner of a triangle that was looked at, numbered over all, and the gap to a point that may double it.
type Met = (u32, f64);

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
    let flats: Vec<Flat> = some.collect();
    if flats.is_empty() {
        return None;
    }
    let near = Near::of(&flats);
    let rounding_m = ROUNDING * longest_m;
    let met_by = |&triangle: &u32| {
        let points = corners(mesh, triangle);
        let mut met: Vec<Met> = Vec::new();
        for point in points {
            for &(_, number) in near.list(point) {
                let (flat, corner) = (&flats[number as usize / 3], number as usize % 3);
                let Some(gap) = flat.gap(corner, point).filter(|gap| gap.abs() > rounding_m) else {
                    continue;
                };
                let normal = (points[1] - points[0]).cross(points[2] - points[0]);
                let is_parallel = flat.normal.dot(normal).abs() >= PARALLEL * normal.length();
                if is_parallel && triangle != flat.triangle {
                    met.push((number, gap));
                }
            }
        }
        met
    };
    let mut met: Vec<Met> = leaves.par_iter().with_min_len(1024).flat_map_iter(met_by).collect();
    met.par_sort_unstable_by(|a, b| a.0.cmp(&b.0).then(a.1.total_cmp(&b.1)));
    met.dedup();
    let (mut sheets_m2, mut gaps) = (0.0, 0.0);
    for of_flat in met.chunk_by(|a, b| a.0 / 3 == b.0 / 3) {
        if let Some(gap_m) = common_gap(of_flat) {
            let area_m2 = flats[of_flat[0].0 as usize / 3].area_m2;
            sheets_m2 += area_m2;
            gaps += gap_m * area_m2;
        }
    }
    let looked_m2: f64 = flats.iter().map(|flat| flat.area_m2).sum();
    if sheets_m2 <= MIN_SHARE * looked_m2 {
        return None;
    }
    let leaf_m2: f64 =
        leaves.iter().filter_map(|&triangle| Flat::of(mesh, triangle)).map(|flat| flat.area_m2).sum();
    Some(Doubt::SecondSheets { sheets_m2: leaf_m2 * sheets_m2 / looked_m2, leaf_m2, gap_m: gaps / sheets_m2 })
}

/// The least gap that all three corners of a triangle have, to one side. `met` are those of its corners, ascending.
fn common_gap(met: &[Met]) -> Option<f64> {
    let of = |corner: u32| met.iter().filter(move |met| met.0 % 3 == corner).map(|met| met.1);
    let has = |corner: u32, gap: f64| {
        of(corner).any(|other| {
            other * gap > 0.0 && other.abs() <= ALIKE * gap.abs() && gap.abs() <= ALIKE * other.abs()
        })
    };
    of(0).filter(|&gap| has(1, gap) && has(2, gap)).map(f64::abs).reduce(f64::min)
}

/// Corners that are looked at, by the cubes of a lattice around them.
struct Near {
    cubes_per_m: f64,
    /// Number of places, a power of two.
    places: usize,
    /// `[place]`: where its list starts, and the end of the last.
    starts: Vec<u32>,
    /// `(place, number of the corner)`, sorted.
    lists: Vec<(u32, u32)>,
    /// A bit each place: whether its list has an entry. Most have none, and bits stay in the fastest memory.
    is_filled: Vec<u64>,
}

impl Near {
    fn of(flats: &[Flat]) -> Near {
        let cube_m =
            2.0 * flats.iter().map(|flat| flat.reach_m.max(flat.aside_m)).sum::<f64>() / flats.len() as f64;
        // Several times their entries: most leaves find an empty list.
        let places = (flats.len() * 128).next_power_of_two();
        let mut near = Near {
            cubes_per_m: 1.0 / cube_m,
            places,
            starts: vec![0; places + 1],
            lists: Vec::new(),
            is_filled: vec![0; places.div_ceil(64)],
        };
        for (number, flat) in (0u32..).zip(flats) {
            for (corner, point) in (0u32..).zip(flat.corners) {
                let reach_m = flat.reach_m + flat.aside_m.max(ASIDE * flat.reach_m);
                let [low, high] = [point - reach_m, point + reach_m].map(|end| near.cube(end));
                let cubes = high - low + 1;
                if cubes.x.saturating_mul(cubes.y).saturating_mul(cubes.z) > MAX_CUBES {
                    continue;
                }
                for z in low.z..=high.z {
                    for y in low.y..=high.y {
                        for x in low.x..=high.x {
                            near.lists.push((near.place([x, y, z]), 3 * number + corner));
                        }
                    }
                }
            }
        }
        near.lists.sort_unstable();
        near.lists.dedup();
        for (place, _) in &near.lists {
            near.starts[*place as usize + 1] += 1;
            near.is_filled[*place as usize / 64] |= 1 << (place % 64);
        }
        (0..places).for_each(|place| near.starts[place + 1] += near.starts[place]);
        near
    }

    /// Without rounding down, which takes the time of all the rest: cubes around 0 are twice as wide.
    fn cube(&self, point: DVec3) -> glam::I64Vec3 {
        (point * self.cubes_per_m).as_i64vec3()
    }

    fn list(&self, point: DVec3) -> &[(u32, u32)] {
        let place = self.place(self.cube(point).to_array()) as usize;
        match self.is_filled[place / 64] >> (place % 64) & 1 {
            0 => &[],
            _ => &self.lists[self.starts[place] as usize..self.starts[place + 1] as usize],
        }
    }

    fn place(&self, [x, y, z]: [i64; 3]) -> u32 {
        let mixed = (x as u64)
            .wrapping_mul(0x9e37_79b9_7f4a_7c15)
            .wrapping_add((y as u64).wrapping_mul(0xc2b2_ae3d_27d4_eb4f))
            .wrapping_add((z as u64).wrapping_mul(0x1656_67b1_9e37_79f9));
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
        assert!(text.contains("of 6 m2 of leaf have a second sheet of the same outline 0.002 m"), "{text}");
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
