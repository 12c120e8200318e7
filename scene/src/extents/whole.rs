//! Whether a file holds one whole plant: not several, not one in several levels of detail, with leaves and wood, all of
//! which is there.

use std::collections::BTreeMap;

use flb_format::meta::Bounds;

use super::plan::{MAX_FOOT, middle, over_ground, width};
use super::{Doubt, Extents, alpha, card, number, painted, plan};
use crate::classify::words::parts_of_name;
use crate::import::area;
use crate::mesh::{Part, around};
use crate::{ClassedMesh, MaterialClass};

/// Cells along the longer edge of the plant's ground plan.
const CELLS: usize = 64;
/// What stands apart has an empty strip around it, this many cells wide at least.
const GAP: usize = 4;
/// What is no more than this of the plant's area is no plant: fallen leaves, a stray triangle.
const MIN_SHARE: f64 = 0.05;
/// Boxes of two levels of detail differ by no more than this, as a share of their longest edge.
const SAME_BOX: f64 = 0.02;
/// Boxes of two levels that are a plant each.
const LIKE_BOX: f64 = 0.15;
/// Ends of two levels over the ground differ by no more than this, as a share of the height of the higher one.
const AS_HIGH: f64 = 0.3;
/// One level has so many times the triangles of the next.
const FEWER: f64 = 1.5;
/// The same where names tell levels.
const SOME_FEWER: f64 = 1.1;
/// Parts that are a plant each are so high at least, as a share of the height of all..
const MIN_HEIGHT: f64 = 0.5;
/// ..and have their middles so many widths apart. Stems of one shrub stand nearer to each other.
const BESIDE: f64 = 0.6;
/// Feet of stems of one shrub are nearer to each other than this share of the distance of their crowns.
const NEAR_FEET: f64 = 0.5;
/// Names that a doubt lists.
const LISTED: usize = 8;
/// Parts that are compared with each other.
const COMPARED: usize = 256;

/// Doubts of that kind.
pub(super) fn doubts(plant: &ClassedMesh, extents: &Extents) -> Vec<Doubt> {
    let mut found = Vec::new();
    found.extend(levels(plant, extents));
    found.extend(apart(plant, extents));
    let counts = plant.triangle_counts();
    match (counts.leaf, counts.wood) {
        (1.., 0) => found.push(Doubt::NoWood),
        (0, 1..) => found.push(Doubt::NoLeaf),
        _ => {}
    }
    let triangles = by_material(plant);
    found.extend(alpha::doubts(plant, &triangles));
    found.extend(painted::doubts(plant, &triangles));
    found.extend(card::doubt(plant, extents));
    found
}

/// Triangles of each material of leaf or wood.
fn by_material(plant: &ClassedMesh) -> Vec<Vec<u32>> {
    let mut triangles = vec![Vec::new(); plant.mesh.materials.len()];
    for (triangle, &material) in (0..).zip(&plant.mesh.triangle_material) {
        if plant.classes[material as usize] != MaterialClass::Neither {
            triangles[material as usize].push(triangle);
        }
    }
    triangles
}

/// Levels of detail by their names, else by what fills the same box with fewer triangles.
fn levels(plant: &ClassedMesh, extents: &Extents) -> Option<Doubt> {
    let mesh = &plant.mesh;
    let is_plant = |part: &Part| {
        part.uses.iter().any(|used| plant.classes[used.material as usize] != MaterialClass::Neither)
    };
    let parts = || mesh.parts.iter().filter(|part| is_plant(part));
    let mut by_stem: BTreeMap<String, BTreeMap<String, Vec<&Part>>> = BTreeMap::new();
    for part in parts() {
        let level = |name: &String| level_of(name).or_else(|| season_of(name));
        if let Some((stem, level)) = part.names.iter().find_map(level) {
            by_stem.entry(stem).or_default().entry(level).or_default().push(part);
        }
    }
    // `oak` beside `oak_lod1` is the finest of them.
    for part in parts() {
        let own = part.names.iter().map(|name| name.to_lowercase()).find(|name| by_stem.contains_key(name));
        if let Some(stem) = own {
            let levels = by_stem.get_mut(&stem).expect("it was found");
            levels.entry(String::new()).or_default().push(part);
        }
    }
    let several = by_stem.into_values().filter(|levels| levels.len() > 1 && are_levels(levels));
    let of_stems = several.flat_map(|levels| levels.into_values().flatten());
    let mut names: Vec<String> = of_stems.map(Part::label).take(LISTED).collect();
    if names.is_empty() {
        let used =
            mesh.materials.iter().zip(&plant.classes).filter(|(_, class)| **class != MaterialClass::Neither);
        let of_materials =
            used.filter_map(|(material, _)| Some((level_of(&material.name)?, material.name.clone())));
        let mut levels: BTreeMap<String, BTreeMap<String, String>> = BTreeMap::new();
        of_materials
            .for_each(|((stem, level), name)| _ = levels.entry(stem).or_default().insert(level, name));
        let several = levels.into_values().filter(|levels| levels.len() > 1);
        names = several.flat_map(BTreeMap::into_values).take(LISTED).collect();
    }
    if names.is_empty() {
        let all: Vec<&Part> = parts().take(COMPARED).collect();
        for (at, a) in all.iter().enumerate() {
            let is_level = |b: &&&Part| fill_the_same_box(a, b) || are_both_whole(plant, extents, a, b);
            let others: Vec<&&Part> = all[at + 1..].iter().filter(is_level).collect();
            if !others.is_empty() {
                names = std::iter::once(a).chain(others).map(|part| part.label()).take(LISTED).collect();
                break;
            }
        }
    }
    (!names.is_empty()).then_some(Doubt::Levels { names })
}

/// Whether parts are levels of one thing: by the number of a level, else by how high they are.
fn are_levels(by_level: &BTreeMap<String, Vec<&Part>>) -> bool {
    let is_number = |level: &String| !level.is_empty() && level.bytes().all(|byte| byte.is_ascii_digit());
    let box_of = |level: &Vec<&Part>| level.iter().filter_map(|part| part.bounds_m()).reduce(around);
    let triangles = |level: &Vec<&Part>| {
        level.iter().flat_map(|part| &part.uses).map(|used| used.triangles).sum::<u64>() as f64
    };
    // Storeys that are called high and low may overlap; a lower level has fewer triangles.
    let is_season = |level: &String| SEASONS.split_whitespace().any(|known| known == level);
    let any_count = by_level.keys().any(is_season);
    let of_level = |level: &Vec<&Part>| Some((box_of(level)?, triangles(level)));
    let all: Vec<(Bounds, f64)> = by_level.values().filter_map(of_level).collect();
    let is_level = |(at, (a, of_a)): (usize, &(Bounds, f64))| {
        let differs = |of_b: f64| any_count || of_a.max(of_b) >= SOME_FEWER * of_a.min(of_b);
        all[at + 1..].iter().any(|(b, of_b)| are_as_high(a, b) && differs(*of_b))
    };
    by_level.keys().any(is_number) || all.iter().enumerate().any(is_level)
}

/// Words of a level of detail.
const QUALITIES: &str = "
    high highest highpoly highres hipoly hires hi medium mid med low lowest lowpoly lowres lopoly lores lo
    billboard impostor imposter simplified decimated reduced proxy hd sd
    hoch mittel niedrig haut haute moyen moyenne bas basse alto alta medio media bajo baja
";

/// What a name says without its level of detail, and that level: `oak`, `1` of `Oak_LOD1`; `oak`, `low` of `oak-low`.
fn level_of(name: &str) -> Option<(String, String)> {
    let lower = name.to_lowercase();
    if let Some(at) = lower.rfind("lod") {
        let rest = lower[at + 3..].trim_start_matches(['_', '-', '.', ' ']);
        let digits = rest.len() - rest.trim_start_matches(|c: char| c.is_ascii_digit()).len();
        if digits > 0 {
            let before = lower[..at].trim_end_matches(['_', '-', '.', ' ']);
            return Some((format!("{before}{}", &rest[digits..]), rest[..digits].to_owned()));
        }
    }
    without(name, QUALITIES)
}

/// Words of a season. Materials of two seasons may be mixed in one crown; parts are one or the other.
const SEASONS: &str = "
    spring summer autumn fall winter snow snowy frühling fruehling sommer herbst winter printemps été ete automne hiver
    primavera verano otoño otono invierno estate autunno inverno
";

/// What a name says without its season, and that season: `leaves`, `autumn` of `Leaves_Autumn`.
fn season_of(name: &str) -> Option<(String, String)> {
    without(name, SEASONS)
}

/// A name's words without the last that is listed, and that one.
fn without(name: &str, listed: &str) -> Option<(String, String)> {
    let words = parts_of_name(name);
    let at = words.iter().rposition(|word| listed.split_whitespace().any(|known| known == word))?;
    let stem: Vec<&str> =
        words.iter().enumerate().filter(|(i, _)| *i != at).map(|(_, word)| word.as_str()).collect();
    Some((stem.join("_"), words[at].clone()))
}

/// Whether two parts of the same materials have one box, and clearly different numbers of triangles.
fn fill_the_same_box(a: &Part, b: &Part) -> bool {
    let [few, many] = triangles_of_both(a, b);
    few >= 8.0 && many >= FEWER * few && are_alike(a, b, SAME_BOX)
}

/// Whether two parts are a plant each, leaves and wood, of whatever materials: one box and any numbers of triangles, or
/// much the same box and clearly different numbers. Leaves of lower levels are larger, so that their box is, too.
fn are_both_whole(plant: &ClassedMesh, extents: &Extents, a: &Part, b: &Part) -> bool {
    let is_whole = |part: &Part| {
        let of_plant = Some(extents.bounds_m);
        has_both(plant, part) && off_by(part.bounds_m(), of_plant).is_some_and(|off| off <= LIKE_BOX)
    };
    let [few, many] = triangles_of_both(a, b);
    let tolerance = if many >= FEWER * few { LIKE_BOX } else { SAME_BOX };
    is_whole(a) && is_whole(b) && have_one_box(a, b, tolerance)
}

fn triangles_of_both(a: &Part, b: &Part) -> [f64; 2] {
    let [a, b] = [a, b].map(|part| part.uses.iter().map(|used| used.triangles).sum::<u64>() as f64);
    [a.min(b), a.max(b)]
}

/// Whether two parts have the same materials, and boxes that differ by no more than a share of their longest edge.
fn are_alike(a: &Part, b: &Part, tolerance: f64) -> bool {
    let materials = |part: &Part| {
        let mut all: Vec<u32> = part.uses.iter().map(|used| used.material).collect();
        all.sort_unstable();
        all
    };
    materials(a) == materials(b) && have_one_box(a, b, tolerance)
}

fn have_one_box(a: &Part, b: &Part, tolerance: f64) -> bool {
    off_by(a.bounds_m(), b.bounds_m()).is_some_and(|off| off <= tolerance)
}

/// Whether two boxes begin and end at the same heights, up to a share of the higher one's height. Levels of detail may
/// stand beside each other; twigs that are called low and high are one above the other.
fn are_as_high(a: &Bounds, b: &Bounds) -> bool {
    let height = (a.max[1] - a.min[1]).max(b.max[1] - b.min[1]);
    (a.min[1] - b.min[1]).abs().max((a.max[1] - b.max[1]).abs()) <= AS_HIGH * height
}

/// How far two boxes differ, as a share of the longest edge of the first.
fn off_by(first: Option<Bounds>, second: Option<Bounds>) -> Option<f64> {
    let (first, second) = (first?, second?);
    let longest = (0..3).map(|axis| first.max[axis] - first.min[axis]).fold(0.0, f64::max);
    let off = (0..3).map(|axis| {
        (first.min[axis] - second.min[axis]).abs().max((first.max[axis] - second.max[axis]).abs())
    });
    (longest > 0.0).then(|| off.fold(0.0, f64::max) / longest)
}

/// Plants that stand beside each other, with empty ground between them.
fn apart(plant: &ClassedMesh, extents: &Extents) -> Option<Doubt> {
    let mesh = &plant.mesh;
    let [low, size] = [extents.bounds_m.min, extents.size_m()];
    let cell_m = size[0].max(size[2]) / CELLS as f64;
    if cell_m <= 0.0 {
        return None;
    }
    let cell = |x: f64, axis: usize| (((x - low[axis]) / cell_m) as usize).min(CELLS - 1);
    let mut areas = vec![0.0f64; CELLS * CELLS];
    let mut is_filled = vec![false; CELLS * CELLS];
    for (triangle, &material) in mesh.triangle_material.iter().enumerate() {
        if plant.classes[material as usize] == MaterialClass::Neither {
            continue;
        }
        let points = mesh.corners_m(triangle);
        let ends = |axis: usize| {
            let along = points.map(|point| point[axis]);
            let ends = [
                along.iter().copied().fold(f64::INFINITY, f64::min),
                along.into_iter().fold(f64::MIN, f64::max),
            ];
            ends.map(|x| cell(x, axis))
        };
        let ([west, east], [north, south]) = (ends(0), ends(2));
        for z in north..=south {
            is_filled[z * CELLS + west..=z * CELLS + east].fill(true);
        }
        areas[north * CELLS + west] += area(points);
    }
    let stands = stands(&is_filled);
    let count = stands.iter().copied().max().map_or(0, |most| most + 1);
    let mut sums = vec![0.0; count as usize];
    stands
        .iter()
        .zip(&areas)
        .filter(|(stand, _)| **stand >= 0)
        .for_each(|(stand, area)| sums[*stand as usize] += area);
    let all: f64 = sums.iter().sum();
    let large: Vec<i32> = (0..count).filter(|&stand| sums[stand as usize] >= MIN_SHARE * all).collect();
    if large.len() < 2 {
        return beside(plant, extents);
    }
    let stand_of = |part: &Part| {
        let bounds = part.bounds_m()?;
        let [x, z] = [0, 2].map(|axis| cell(0.5 * (bounds.min[axis] + bounds.max[axis]), axis));
        let spans =
            [0, 2].into_iter().any(|axis| bounds.max[axis] - bounds.min[axis] > 0.9 * size[axis].max(cell_m));
        (!spans).then(|| stands[z * CELLS + x])
    };
    let named = |stand: i32| {
        let part = mesh.parts.iter().find(|part| stand_of(part) == Some(stand));
        part.map_or_else(|| place_of(&stands, stand, low, cell_m), Part::label)
    };
    Some(Doubt::Apart { stands: large.into_iter().take(LISTED).map(named).collect() })
}

/// Parts that are a plant each, with leaves and wood, and stand beside each other, though their crowns meet.
fn beside(plant: &ClassedMesh, extents: &Extents) -> Option<Doubt> {
    let (bottom, height) = (extents.bounds_m.min[1], extents.size_m()[1]);
    let box_of = |part: &Part| {
        let bounds = part.bounds_m().filter(|_| has_both(plant, part))?;
        let is_high = bounds.max[1] - bounds.min[1] >= MIN_HEIGHT * height;
        (is_high && bounds.min[1] - bottom <= MAX_FOOT * height).then_some(bounds)
    };
    let mut stands: Vec<(Bounds, &Part)> = Vec::new();
    for part in plant.mesh.parts.iter().take(COMPARED) {
        let Some(bounds) = box_of(part) else { continue };
        let is_beside = |(other, of): &(Bounds, &Part)| {
            plan_apart(&bounds, other) >= BESIDE && !are_stems(plant, (&bounds, part), (other, of))
        };
        if stands.iter().all(is_beside) {
            stands.push((bounds, part));
        }
    }
    let names = stands.into_iter().take(LISTED).map(|(_, part)| part.label()).collect::<Vec<_>>();
    (names.len() > 1).then_some(Doubt::Apart { stands: names })
}

/// Whether two parts are stems of one shrub: their feet are much nearer to each other than their crowns.
fn are_stems(plant: &ClassedMesh, a: (&Bounds, &Part), b: (&Bounds, &Part)) -> bool {
    let foot = |part: &Part| Some(plan::foot(plant, part.uses.iter())?.middle_m);
    let (Some(foot), Some(other)) = (foot(a.1), foot(b.1)) else { return false };
    over_ground(foot, other) < NEAR_FEET * over_ground(middle(a.0), middle(b.0))
}

/// Distance of the middles of two boxes over the ground, in widths of the smaller one.
fn plan_apart(a: &Bounds, b: &Bounds) -> f64 {
    over_ground(middle(a), middle(b)) / width(a).min(width(b)).max(f64::MIN_POSITIVE)
}

/// Whether a part has leaves and wood.
fn has_both(plant: &ClassedMesh, part: &Part) -> bool {
    [MaterialClass::Leaf, MaterialClass::Wood]
        .into_iter()
        .all(|class| part.uses.iter().any(|used| plant.classes[used.material as usize] == class))
}

/// Where a stand is, in words.
fn place_of(stands: &[i32], stand: i32, low: [f64; 3], cell_m: f64) -> String {
    let cells: Vec<usize> = (0..stands.len()).filter(|&at| stands[at] == stand).collect();
    let mean = |of: &dyn Fn(usize) -> usize| {
        cells.iter().map(|&at| of(at) as f64 + 0.5).sum::<f64>() / cells.len() as f64
    };
    let [x, z] = [low[0] + cell_m * mean(&|at| at % CELLS), low[2] + cell_m * mean(&|at| at / CELLS)];
    format!("at x {}, z {} m", number(x), number(z))
}

/// Per cell, which stand it is of, or -1: filled cells less than [`GAP`] apart are of one.
fn stands(is_filled: &[bool]) -> Vec<i32> {
    let mut stands = vec![-1; is_filled.len()];
    let mut next = 0;
    for start in 0..is_filled.len() {
        if !is_filled[start] || stands[start] >= 0 {
            continue;
        }
        let mut open = vec![start];
        stands[start] = next;
        while let Some(at) = open.pop() {
            let around = |middle: usize| middle.saturating_sub(GAP)..=(middle + GAP).min(CELLS - 1);
            for z in around(at / CELLS) {
                for x in around(at % CELLS) {
                    let other = z * CELLS + x;
                    if is_filled[other] && stands[other] < 0 {
                        stands[other] = next;
                        open.push(other);
                    }
                }
            }
        }
        next += 1;
    }
    stands
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn levels_are_told_by_names_of_many_habits() {
        let of = |name: &str| level_of(name).map(|(stem, level)| format!("{stem} {level}"));
        let cases = [
            ("Oak_LOD0", Some("oak 0")),
            ("oak.lod-12", Some("oak 12")),
            ("LOD_1_oak", Some("_oak 1")),
            ("Oak-low", Some("oak low")),
            ("oak billboard", Some("oak billboard")),
            ("Baum_hoch", Some("baum hoch")),
            ("tree_lowest", Some("tree lowest")),
            ("oak_lod", None),
            ("Highland_Oak", None),
            ("clod3", Some("c 3")),
        ];
        for (name, expected) in cases {
            assert_eq!(of(name).as_deref(), expected, "{name}");
        }
    }

    #[test]
    fn cells_that_are_near_are_of_one_stand() {
        let mut is_filled = vec![false; CELLS * CELLS];
        for x in [0, GAP, 2 * GAP + 1, 40] {
            is_filled[x] = true;
        }
        let stands = stands(&is_filled);
        assert_eq!([0, GAP, 2 * GAP + 1, 40].map(|x| stands[x]), [0, 0, 1, 2]);
    }
}
