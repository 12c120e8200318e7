//! Whether a crown is a few cones or bowls about its trunk, as firs of games are: shells that hold no leaves.

use glam::DVec3;

use super::Doubt;
use super::hull::normal_m2;
use super::leaves::Leaves;
use crate::sheets::{corners, pieces};
use crate::{ClassedMesh, Mesh};

/// A tier is so wide both ways, as a share of the crown's width..
const MIN_WIDE: f64 = 0.25;
/// ..as deep as wide, at least in this share..
const MIN_ROUND: f64 = 0.6;
/// ..and has its middle over that of the crown, up to this share of its own width.
const MAX_ASIDE: f64 = 0.15;
/// It has so many triangles.
const MIN_TRIANGLES: u32 = 6;
/// The normals of its triangles lean from the vertical, as a mean sine..
const MIN_LEANING: f64 = 0.2;
/// ..and over the ground look away from its middle, as a mean cosine: those of leaves look anywhere, 0.64.
const MIN_OUTWARDS: f64 = 0.9;
/// Tiers are so many, and so much of the leaf area.
const MIN_TIERS: usize = 2;
const MIN_SHARE: f64 = 0.25;
/// One tier alone is this share of the leaf area, and the crown so high, metres.
const MIN_SINGLE: f64 = 0.5;
const MIN_SINGLE_M: f64 = 1.0;
/// A tier is narrower than this share of the one below.
const MAX_OF_LOWER: f64 = 0.98;

/// Triangles that hold together.
#[derive(Clone, Copy)]
struct Sheet {
    low: DVec3,
    high: DVec3,
    triangles: u32,
    area_m2: f64,
}

impl Sheet {
    const NONE: Sheet = Sheet { low: DVec3::INFINITY, high: DVec3::NEG_INFINITY, triangles: 0, area_m2: 0.0 };

    /// Sheets of triangles that have one number each; some numbers have none.
    fn all(mesh: &Mesh, triangles: &[u32], numbers: &[u32]) -> Vec<Sheet> {
        let count = numbers.iter().max().map_or(0, |last| *last as usize + 1);
        let mut sheets = vec![Sheet::NONE; count];
        for (&triangle, &number) in triangles.iter().zip(numbers) {
            let sheet = &mut sheets[number as usize];
            for point in corners(mesh, triangle) {
                (sheet.low, sheet.high) = (sheet.low.min(point), sheet.high.max(point));
            }
            sheet.triangles += 1;
            sheet.area_m2 += normal_m2(mesh, triangle).length();
        }
        sheets
    }

    /// Whether it lies about the middle of a crown with these corners.
    fn is_about(&self, [low, high]: [DVec3; 2]) -> bool {
        let (size, crown) = (self.high - self.low, high - low);
        let (wide, narrow) = (size.x.max(size.z), size.x.min(size.z));
        let aside = self.low.midpoint(self.high) - low.midpoint(high);
        self.triangles >= MIN_TRIANGLES
            && size.x >= MIN_WIDE * crown.x
            && size.z >= MIN_WIDE * crown.z
            && narrow >= MIN_ROUND * wide
            && libm::hypot(aside.x, aside.z) <= MAX_ASIDE * wide
    }
}

/// The doubt, if much of the leaf is such tiers.
pub(super) fn doubt(plant: &ClassedMesh, leaves: &Leaves) -> Option<Doubt> {
    let mesh = &plant.mesh;
    let sheets = Sheet::all(mesh, &leaves.triangles, &leaves.blades);
    let all = |sheet: &Sheet| (sheet.low, sheet.high);
    let (low, high) = sheets.iter().map(all).reduce(|(a, b), (c, d)| (a.min(c), b.max(d)))?;
    let leaf_m2: f64 = sheets.iter().map(|sheet| sheet.area_m2).sum();
    let of_crown = leaves.triangles.iter().zip(&leaves.blades);
    let large: Vec<u32> = of_crown
        .filter(|(_, blade)| sheets[**blade as usize].is_about([low, high]))
        .map(|(triangle, _)| *triangle)
        .collect();
    // The leaves of a rosette hold together in one point; a tier does by its edges.
    let numbers = pieces(mesh, &large);
    let sheets = Sheet::all(mesh, &large, &numbers);
    // Of normals the parts over the ground, and of these what looks away from the sheet's middle.
    let mut leaning_m2 = vec![[0.0; 2]; sheets.len()];
    for (&triangle, &number) in large.iter().zip(&numbers) {
        let (sheet, [a, b, c]) = (&sheets[number as usize], corners(mesh, triangle));
        let normal = over_ground(normal_m2(mesh, triangle));
        let away = over_ground((a + b + c) / 3.0 - sheet.low.midpoint(sheet.high)).normalize_or_zero();
        let [leaning, outwards] = &mut leaning_m2[number as usize];
        *leaning += normal.length();
        *outwards += normal.dot(away).abs();
    }
    let is_tier = |(sheet, [leaning_m2, outwards_m2]): &(&Sheet, [f64; 2])| {
        sheet.is_about([low, high])
            && *leaning_m2 >= MIN_LEANING * sheet.area_m2
            && *outwards_m2 >= MIN_OUTWARDS * leaning_m2
    };
    let mut tiers: Vec<&Sheet> =
        sheets.iter().zip(leaning_m2).filter(is_tier).map(|(sheet, _)| sheet).collect();
    // A fir narrows upwards; bells and funnels of a herb are as wide as each other.
    tiers.sort_by(|a, b| a.high.y.total_cmp(&b.high.y));
    let width = |tier: &&Sheet| (tier.high.x - tier.low.x).max(tier.high.z - tier.low.z);
    let narrows = tiers.windows(2).all(|pair| width(&pair[1]) < MAX_OF_LOWER * width(&pair[0]));
    let is_tall = high.y - low.y >= MIN_SINGLE_M;
    let share = tiers.iter().map(|tier| tier.area_m2).sum::<f64>() / leaf_m2;
    let is_single = tiers.len() == 1 && is_tall && share >= MIN_SINGLE;
    let are_several = tiers.len() >= MIN_TIERS && narrows && share >= MIN_SHARE;
    (is_single || are_several).then_some(Doubt::Tiers { count: tiers.len() as u64, share })
}

fn over_ground(v: DVec3) -> DVec3 {
    DVec3::new(v.x, 0.0, v.z)
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::MaterialClass;
    use crate::mesh::testing::soup;

    type Triangles = Vec<[[f32; 3]; 3]>;

    /// A cone open below, its tip at this height.
    fn cone(x: f32, tip: f32, radius: f32) -> Triangles {
        let corner = |at: usize| {
            let turn = std::f64::consts::TAU * at as f64 / 8.0;
            let [sin, cos] = [libm::sin(turn) as f32, libm::cos(turn) as f32];
            [x + radius * sin, tip - 1.2 * radius, radius * cos]
        };
        (0..8).map(|at| [[x, tip, 0.0], corner(at), corner(at + 1)]).collect()
    }

    fn found(parts: &[Triangles]) -> Option<Doubt> {
        let mesh = soup(&parts.concat());
        let plant = ClassedMesh { mesh, classes: vec![MaterialClass::Leaf; 2] };
        doubt(&plant, &Leaves::of(&plant))
    }

    #[test]
    fn cones_about_a_trunk_are_a_doubt_and_leaves_are_not() {
        let fir = [cone(0.0, 2.0, 1.2), cone(0.0, 3.0, 0.9), cone(0.0, 3.8, 0.5)];
        match found(&fir) {
            Some(Doubt::Tiers { count, share, .. }) => assert!(count == 3 && (share - 1.0).abs() < 1e-9),
            other => panic!("{other:?}"),
        }
        assert!(matches!(found(&[cone(0.0, 2.0, 1.2)]), Some(Doubt::Tiers { count: 1, .. })));
        let bells = [cone(0.0, 2.0, 0.4), cone(0.0, 3.0, 0.4)];
        assert_eq!(found(&bells), None);
        // Leaves shaped as cones, here and there.
        let herbs: Vec<Triangles> = (0..9).map(|at| cone(0.5 * at as f32, 1.0, 0.2)).collect();
        assert_eq!(found(&herbs), None);
        // Fronds that hold together in one point, in two storeys.
        let storey = |up: f32| -> Triangles {
            (0..8)
                .map(|at| {
                    let turn = std::f64::consts::TAU * at as f64 / 8.0;
                    let [sin, cos] = [libm::sin(turn) as f32, libm::cos(turn) as f32];
                    let at = |far: f32, aside: f32, up: f32| {
                        [far * sin + aside * cos, up, far * cos - aside * sin]
                    };
                    [[0.0, up, 0.0], at(1.0, 0.1, up + 0.4), at(1.0, -0.1, up + 0.4)]
                })
                .collect()
        };
        assert_eq!(found(&[storey(0.0), storey(0.5)]), None);
    }
}
