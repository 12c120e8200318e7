use flb_fixtures::{PlantKind, grow};

use super::*;
use crate::import::uses::fill;
use crate::mesh::testing::soup;
use crate::mesh::{AlphaMode, Part};
use crate::{Mesh, PlantReader};

mod exports;

type Point = [f64; 3];

/// A tube from one point to another, as four sides of two triangles; its ends are open.
fn tube(from: Point, to: Point, radius_m: f64) -> Vec<foot::Triangle> {
    let axis = (0..3).max_by(|a, b| (to[*a] - from[*a]).abs().total_cmp(&(to[*b] - from[*b]).abs()));
    let axis = axis.expect("three axes");
    let ring = |middle: Point| {
        [[1.0, 1.0], [-1.0, 1.0], [-1.0, -1.0], [1.0, -1.0]].map(|[u, v]| {
            let mut point = middle;
            point[(axis + 1) % 3] += radius_m * u;
            point[(axis + 2) % 3] += radius_m * v;
            point
        })
    };
    let (low, high) = (ring(from), ring(to));
    (0..4)
        .flat_map(|a| [[low[a], low[(a + 1) % 4], high[a]], [low[(a + 1) % 4], high[(a + 1) % 4], high[a]]])
        .collect()
}

/// A leaf of 0.2 m about a point.
fn leaf([x, y, z]: Point) -> foot::Triangle {
    [[x - 0.1, y - 0.1, z], [x + 0.1, y - 0.1, z], [x, y + 0.1, z]]
}

/// A plant of these triangles, turned by `turn`.
fn plant(wood: &[foot::Triangle], leaves: &[foot::Triangle], turn: impl Fn(Point) -> Point) -> ClassedMesh {
    let all: Vec<[[f32; 3]; 3]> =
        wood.iter().chain(leaves).map(|t| t.map(|corner| turn(corner).map(|c| c as f32))).collect();
    let mut mesh = soup(&all);
    mesh.triangle_material = (0..all.len()).map(|i| u32::from(i < wood.len())).collect();
    ClassedMesh { mesh, classes: vec![MaterialClass::Leaf, MaterialClass::Wood] }
}

/// A tree 10 m high: a trunk that tapers in three pieces, four boughs, leaves around their ends.
fn tree() -> [Vec<foot::Triangle>; 2] {
    let mut wood = tube([0.0, 0.0, 0.0], [0.1, 3.0, 0.0], 0.3);
    wood.extend(tube([0.1, 3.0, 0.0], [0.0, 6.0, 0.1], 0.15));
    wood.extend(tube([0.0, 6.0, 0.1], [0.0, 9.8, 0.0], 0.03));
    let mut leaves = Vec::new();
    for end in [[4.0, 7.0, 0.2], [-4.0, 6.0, 0.0], [0.3, 6.5, 4.0], [0.0, 7.0, -4.0], [0.0, 9.8, 0.0]] {
        wood.extend(tube([0.0, 5.0, 0.0], end, 0.02));
        leaves.extend([leaf(end), leaf(end.map(|c| c + 0.1)), leaf(end.map(|c| 0.9 * c))]);
    }
    [wood, leaves]
}

/// Doubts about size and stand.
fn found(plant: &ClassedMesh, up: Up) -> Vec<Doubt> {
    let is_of_box = |doubt: &Doubt| ["size", "foot", "high-wood"].contains(&doubt.name());
    all_found(plant, up).into_iter().filter(is_of_box).collect()
}

fn all_found(plant: &ClassedMesh, up: Up) -> Vec<Doubt> {
    doubts(plant, &ImportSettings { up: Some(up), ..ImportSettings::default() })
}

fn foot(axis: usize, is_upper: bool, up: Option<Up>) -> Vec<Doubt> {
    vec![Doubt::Foot { at: Side { axis, is_upper }, up }]
}

#[test]
fn an_upright_tree_is_believed_and_one_that_lies_is_told_where_its_foot_is() {
    let [wood, leaves] = tree();
    let turned = |turn: fn(Point) -> Point| plant(&wood, &leaves, turn);
    assert_eq!(found(&turned(|p| p), Up::Y), []);
    // A file with +Z up that was read with +Y up, and one with +Y up that was read with +Z up.
    assert_eq!(found(&turned(|[x, y, z]| [x, -z, y]), Up::Y), foot(2, false, Some(Up::Z)));
    assert_eq!(found(&turned(|[x, y, z]| [x, z, -y]), Up::Z), foot(2, true, Some(Up::Y)));
    // No flag turns these.
    assert_eq!(found(&turned(|[x, y, z]| [x, z, -y]), Up::Y), foot(2, true, None));
    assert_eq!(found(&turned(|[x, y, z]| [y, -x, z]), Up::Y), foot(0, false, None));
    assert_eq!(found(&turned(|[x, y, z]| [x, -y, -z]), Up::Y), foot(1, true, None));
    let text = found(&turned(|[x, y, z]| [x, -z, y]), Up::Y)[0].to_string();
    assert_eq!(text, "the plant's foot (its thickest wood) is on its side -z, expected at its bottom, -y");
}

#[test]
fn twigs_that_hang_below_the_foot_and_a_trunk_that_does_not_taper_are_believed() {
    let [mut wood, mut leaves] = tree();
    for i in 0..24 {
        let (x, z) = (4.0 * libm::cos(f64::from(i)), 4.0 * libm::sin(f64::from(i)));
        wood.extend(tube([x, 6.0, z], [x, -0.3, z], 0.01));
        leaves.push(leaf([x, 0.0, z]));
    }
    assert_eq!(found(&plant(&wood, &leaves, |p| p), Up::Y), [], "it weeps");

    let palm = tube([0.0; 3], [0.0, 8.0, 0.0], 0.2);
    let fronds: Vec<_> =
        (0..9).map(|i| leaf([libm::cos(f64::from(i)), 8.0, libm::sin(f64::from(i))])).collect();
    assert_eq!(found(&plant(&palm, &fronds, |p| p), Up::Y), []);
    // Both ends are alike: the fronds tell which is the foot.
    let lies = plant(&palm, &fronds, |[x, y, z]| [x, -z, y]);
    assert_eq!(found(&lies, Up::Y), foot(2, false, Some(Up::Z)));
    assert_eq!(found(&plant(&palm, &[], |[x, y, z]| [x, -z, y]), Up::Y), [], "without fronds it is a log");
}

#[test]
fn the_flank_of_a_trunk_and_the_end_of_a_hedge_are_no_feet() {
    // As games have them: a trunk without boughs, leaves above.
    let trunk = tube([0.0; 3], [0.0, 3.0, 0.0], 0.2);
    let around =
        |i: i32| [2.0 * libm::cos(f64::from(i)), 3.0 + 0.15 * f64::from(i), 2.0 * libm::sin(f64::from(i))];
    let crown: Vec<_> = (0..40).map(|i| leaf(around(i))).collect();
    let turned = |turn: fn(Point) -> Point| plant(&trunk, &crown, turn);
    assert_eq!(found(&turned(|p| p), Up::Y), []);
    assert_eq!(found(&turned(|[x, y, z]| [x, -z, y]), Up::Y), foot(2, false, Some(Up::Z)));
    assert_eq!(found(&turned(|[x, y, z]| [z, x, y]), Up::Y), foot(2, false, Some(Up::Z)));
    // A hedge 10 m long has no more wood at its ends than anywhere.
    let stem = |i: i32| {
        let (x, z) = (0.2 * f64::from(i), 0.4 * libm::sin(f64::from(7 * i)));
        let twig = |k: i32| tube([x, 0.1 * f64::from(k), z], [x + 0.2, 0.12 * f64::from(k), 0.5], 0.01);
        [tube([x, 0.0, z], [x, 1.0, -z], 0.02), (1..9).flat_map(twig).collect()].concat()
    };
    let stems: Vec<_> = (0..50).flat_map(stem).collect();
    let leaves: Vec<_> = (0..100).map(|i| leaf([0.1 * f64::from(i), 0.5, 0.0])).collect();
    assert_eq!(found(&plant(&stems, &leaves, |p| p), Up::Y), []);
}

#[test]
fn a_herb_stands_as_it_likes_and_soil_is_no_foot() {
    let leaves = [leaf([0.0; 3]), leaf([3.0, 0.0, 1.0])];
    assert_eq!(found(&plant(&[], &leaves, |p| p), Up::Y), []);
    // A pot that counts as wood: much of it lies flat at the top.
    let mut pot = tube([0.0; 3], [0.0, 0.4, 0.0], 0.2);
    pot.extend([[[-0.2, 0.4, -0.2], [0.2, 0.4, -0.2], [0.2, 0.4, 0.2]]; 2]);
    assert_eq!(found(&plant(&pot, &[leaf([0.0, 0.3, 0.0])], |p| p), Up::Y), []);
}

#[test]
fn wood_that_begins_far_above_the_lowest_leaf_is_doubted() {
    let wood = tube([0.0, 6.0, 0.0], [0.0, 9.0, 0.0], 0.2);
    let [low, high] = [leaf([0.0, 0.1, 0.0]), leaf([0.0, 8.9, 0.5])];
    let doubts = found(&plant(&wood, &[low, high], |p| p), Up::Y);
    let text = "the wood begins 6 m above the lowest leaf of a plant 9 m high, expected at its bottom";
    assert_eq!(
        doubts.iter().map(|d| (d.name(), d.to_string())).collect::<Vec<_>>(),
        [("high-wood", text.into())]
    );
    let higher = leaf([0.0, 4.2, 0.0]);
    assert_eq!(found(&plant(&wood, &[higher, high], |p| p), Up::Y).len(), 1, "2 of 5 m");
    let highest = leaf([0.0, 5.0, 0.0]);
    assert_eq!(found(&plant(&wood, &[highest, high], |p| p), Up::Y), [], "1 of 4 m");
}

#[test]
fn the_built_in_plants_are_believed_upright_and_doubted_lying() {
    let folder = tempfile::tempdir().expect("a temporary folder");
    for (kind, seed, triangles) in PlantKind::ALL.into_iter().flat_map(|k| [(k, 1, 2000), (k, 2, 20_000)]) {
        let path = folder.path().join("plant.glb");
        std::fs::write(&path, grow(kind, seed, triangles).expect("a good kind").to_glb()).expect("it fits");
        let read = |up| {
            let settings = ImportSettings { up: Some(up), ..ImportSettings::default() };
            let reader = PlantReader { settings, ..PlantReader::default() };
            found(&reader.read(&path).expect("a sound mesh").0, up)
        };
        assert_eq!(read(Up::Y), [], "{} {seed}", kind.name());
        let lying = if kind == PlantKind::LeafCard { Vec::new() } else { foot(2, true, Some(Up::Y)) };
        assert_eq!(read(Up::Z), lying, "{} {seed}", kind.name());
    }
}

#[test]
fn leaves_that_are_thick_closed_shells_are_doubted_with_both_areas() {
    let boxed = |at: [f32; 3], size: f32| {
        let corner =
            |i: usize| std::array::from_fn(|axis| at[axis] + if i >> axis & 1 == 1 { size } else { 0.0 });
        [[0, 2, 3, 1], [4, 5, 7, 6], [0, 1, 5, 4], [2, 6, 7, 3], [0, 4, 6, 2], [1, 3, 7, 5]]
            .into_iter()
            .flat_map(move |[a, b, c, d]: [usize; 4]| [[a, b, c], [a, c, d]].map(|of| of.map(corner)))
            .collect::<Vec<[[f32; 3]; 3]>>()
    };
    let of = |leaves: &[[[f32; 3]; 3]]| {
        let plant = ClassedMesh::of(
            crate::mesh::testing::soup(leaves),
            vec![MaterialClass::Leaf, MaterialClass::Wood],
        );
        let found = doubts(&plant, &ImportSettings::default());
        found.into_iter().filter(|doubt| *doubt != Doubt::NoWood).collect::<Vec<_>>()
    };
    let blob = boxed([0.0; 3], 1.0);
    let text = "6 of 6 m2 of leaf are closed shells up to 0.333 m thick, expected single leaves: their insides count as \
                leaf, too";
    let found = of(&blob);
    assert_eq!(
        found.iter().map(|d| (d.name(), d.to_string())).collect::<Vec<_>>(),
        [("shells", text.into())]
    );
    // Fruit between leaves.
    let leaf = |y: f32| [[0.0, y, 0.0], [1.0, y, 0.0], [0.0, y, 1.0]];
    let mut fruit = boxed([0.2, 0.2, 0.2], 0.2);
    fruit.extend([0.0, 0.6, 0.8, 1.0].map(leaf));
    assert_eq!(of(&fruit), []);
}

#[test]
fn leaves_behind_walls_are_doubted_with_what_they_see() {
    // A box of wood around leaves, with or without its lid.
    let corner = |i: usize| std::array::from_fn(|axis| if i >> axis & 1 == 1 { 1.0 } else { 0.0 });
    let sides = [[0, 2, 3, 1], [4, 5, 7, 6], [0, 1, 5, 4], [0, 4, 6, 2], [1, 3, 7, 5], [2, 6, 7, 3]];
    let boxed = |sides: &[[usize; 4]]| -> Vec<[[f32; 3]; 3]> {
        sides.iter().flat_map(|&[a, b, c, d]| [[a, b, c], [a, c, d]].map(|of| of.map(corner))).collect()
    };
    let leaf = |y: f32| [[0.3, y, 0.3], [0.7, y, 0.3], [0.3, y, 0.7]];
    let of = |wood: &[[[f32; 3]; 3]], leaves: &[[[f32; 3]; 3]]| {
        let mut mesh = crate::mesh::testing::soup(&[leaves, wood].concat());
        let material = |triangle: usize| u32::from(triangle >= leaves.len());
        mesh.triangle_material = (0..mesh.triangles.len()).map(material).collect();
        let plant = ClassedMesh::of(mesh, vec![MaterialClass::Leaf, MaterialClass::Wood]);
        let doubts = doubts(&plant, &ImportSettings::default());
        doubts.into_iter().find(|doubt| doubt.name() == "enclosed")
    };
    let found = of(&boxed(&sides), &[leaf(0.2), leaf(0.6)]);
    let text = "100 % of the leaf area sees 0 % of the sky past wood, expected over 15 %: it stays dark, and the light \
                of suns there, a hundredth of open light, may be off by a third";
    assert_eq!(found.map(|doubt| doubt.to_string()).as_deref(), Some(text));
    // Deep in it, without the lid; and above it.
    let Some(Doubt::Enclosed(deep)) = of(&boxed(&sides[..5]), &[leaf(0.1)]) else { panic!("deep in a pot") };
    assert!(deep.share > 0.9 && (0.02..0.15).contains(&deep.open), "{deep:?}");
    assert_eq!(of(&boxed(&sides[..5]), &[leaf(1.2), leaf(1.4)]), None);
    // A room of which the leaves are a thousandth.
    let small = |y: f32| leaf(y).map(|corner| corner.map(|x| 0.5 + 0.05 * (x - 0.5)));
    let Some(Doubt::Enclosed(room)) = of(&boxed(&sides), &[small(0.2)]) else { panic!("in a room") };
    assert_eq!((room.share, room.open), (1.0, 0.0));
    // A floor alone.
    assert_eq!(of(&boxed(&sides[2..3]), &[leaf(0.2)]), None);
}

#[test]
fn thick_branches_are_no_walls_and_a_pot_below_open_leaves_is() {
    // Branches in three directions, 0.4 m apart: more wood than a box has surface, most of which sees wood.
    let mut branches = Vec::new();
    for (i, j) in (0..5).flat_map(|i| (0..5).map(move |j| (i, j))) {
        let [a, b] = [i, j].map(|step| -0.8 + 0.4 * f64::from(step));
        branches.extend(tube([a, -1.0, b], [a, 1.0, b], 0.06));
        branches.extend(tube([-1.0, a + 0.1, b], [1.0, a + 0.1, b], 0.06));
        branches.extend(tube([a, b + 0.1, -1.0], [a, b + 0.1, 1.0], 0.06));
    }
    let leaves = [leaf([0.2, 0.1, 0.2]), leaf([0.4, 0.9, 0.1])];
    assert_eq!(walls(&plant(&branches, &leaves, |p| p)), Walls::None);
    let mut pot = tube([0.0, -1.0, 0.0], [0.0, 0.0, 0.0], 0.5);
    let above = [leaf([0.0, 0.3, 0.0]), leaf([0.1, 0.4, 0.1])];
    assert_eq!(walls(&plant(&pot, &above, |p| p)), Walls::Beside);
    let deep = [leaf([0.0, -0.8, 0.0]), leaf([0.1, -0.7, 0.1])];
    pot.extend([[[-0.5, -1.0, -0.5], [0.5, -1.0, -0.5], [0.5, -1.0, 0.5]]]);
    pot.extend([[[-0.5, -1.0, -0.5], [0.5, -1.0, 0.5], [-0.5, -1.0, 0.5]]]);
    pot.extend(tube([0.0, 0.0, 0.0], [0.0, 1.0, 0.0], 0.5));
    assert!(matches!(walls(&plant(&pot, &deep, |p| p)), Walls::Enclosing(_)));
}

#[test]
fn sizes_beyond_those_of_plants_are_doubted_with_the_units_that_would_fit() {
    let of = |longest_m: f64, unit_m| {
        let bounds_m = Bounds { min: [0.0; 3], max: [longest_m / 2.0, longest_m, 0.0] };
        let extents = Extents::of_bounds(bounds_m).expect("finite");
        extents.doubt(&ImportSettings { unit_m, ..ImportSettings::default() })
    };
    assert_eq!([0.05, 1.0, 100.0].map(|size| of(size, None)), [None, None, None]);
    let Some(Doubt::Size { longest_m, units }) = of(1500.0, None) else { panic!("1500 m is doubted") };
    assert_eq!(longest_m, 1500.0);
    assert_eq!(units, [("cm", 15.0), ("mm", 1.5), ("in", 38.1)]);
    // 0.015 m of a file read in centimetres: it is in metres, inches or feet.
    let Some(Doubt::Size { units, .. }) = of(0.015, Some(0.01)) else { panic!("0.015 m is doubted") };
    assert_eq!(units.iter().map(|(unit, _)| *unit).collect::<Vec<_>>(), ["m", "ft"]);
    let text = of(1500.0, None).map(|doubt| doubt.to_string());
    assert_eq!(text.as_deref(), Some("the plant's longest edge is 1500 m, expected 0.05 to 100 m"));
    assert_eq!(of(0.049, None).map(|doubt| doubt.name()), Some("size"));
    assert!(of(f64::from(f32::MAX), None).is_some());
}

#[test]
fn meshes_that_are_no_plant_are_no_panic() {
    let empty = ClassedMesh { mesh: Mesh::default(), classes: Vec::new() };
    assert_eq!((Extents::of(&empty), found(&empty, Up::Y)), (None, Vec::new()));
    for odd in [f32::NAN, f32::INFINITY, f32::NEG_INFINITY] {
        let mut classed = plant(&tube([0.0; 3], [0.0, 8.0, 0.0], 0.2), &[], |p| p);
        classed.mesh.positions[4][1] = odd;
        found(&classed, Up::Y);
        classed.mesh.positions.fill([odd; 3]);
        assert_eq!(found(&classed, Up::Y), []);
    }
    let large = f64::from(f32::MAX) / 2.0;
    let doubts = found(&plant(&tube([-large; 3], [large; 3], large / 9.0), &[], |p| p), Up::Y);
    assert_eq!(doubts[0].to_string(), "the plant's longest edge is 3.78e38 m, expected 0.05 to 100 m");
    let point = plant(&[[[1.0; 3]; 3]], &[], |p| p);
    assert_eq!(Extents::of(&point).map(|extents| extents.to_string()).as_deref(), Some("0 x 0 x 0 m"));
    found(&point, Up::Y);
}

#[test]
fn metres_are_shown_to_three_digits() {
    let shown = [12.5463, 1530.2, 0.03125, 99.96, 7.0, 0.0, 1e-9, 3.4e38].map(number);
    assert_eq!(shown, ["12.5", "1530", "0.0312", "100", "7", "0", "1.00e-9", "3.40e38"]);
}

/// A part of these triangles of `plant`.
fn part(plant: &ClassedMesh, names: &[&str], triangles: std::ops::Range<usize>) -> Part {
    let all = 0..plant.mesh.triangles.len();
    let is_other: Vec<u32> = all.map(|triangle| u32::from(!triangles.contains(&triangle))).collect();
    let mut parts = [Part::default(), Part::default()];
    fill(&plant.mesh, &is_other, &[], &mut parts);
    let [part, _] = parts;
    Part { names: names.iter().map(|&name| name.to_owned()).collect(), ..part }
}

#[test]
fn levels_of_detail_beside_each_other_are_a_doubt_that_names_them() {
    let [wood, leaves] = tree();
    let mut plant = plant(&wood, &leaves, |point| point);
    let count = wood.len();
    assert_eq!(all_found(&plant, Up::Y), []);
    let levels = |plant: &ClassedMesh| match all_found(plant, Up::Y).as_slice() {
        [Doubt::Levels { names }] => names.clone(),
        other => panic!("{other:?}"),
    };
    plant.mesh.parts =
        vec![part(&plant, &["Oak_LOD0"], 0..count / 2), part(&plant, &["x", "Oak_LOD1"], count / 2..count)];
    assert_eq!(levels(&plant), ["Oak_LOD0", "x"]);
    plant.mesh.parts =
        vec![part(&plant, &["Oak_LOD0"], 0..count), part(&plant, &["Leaves"], count..count + 3)];
    assert_eq!(all_found(&plant, Up::Y), [], "one level alone is no doubt");
    let clusters = |up: f64| {
        let mut parts = vec![part(&plant, &["Twigs_Low"], 0..count), part(&plant, &["Twigs_High"], 0..count)];
        let bounds_m = &mut parts[1].uses[0].bounds_m;
        [&mut bounds_m.min[1], &mut bounds_m.max[1]].into_iter().for_each(|y| *y += up);
        parts
    };
    let height = plant.mesh.positions.iter().map(|at| f64::from(at[1])).fold(0.0, f64::max);
    let [same, other] = [clusters(0.0), clusters(0.5 * height)];
    plant.mesh.parts = other;
    assert_eq!(all_found(&plant, Up::Y), [], "twigs of one plant, the lower and the higher ones");
    plant.mesh.parts = same;
    assert_eq!(all_found(&plant, Up::Y), [], "storeys that overlap");
    plant.mesh.parts[0].uses[0].triangles /= 2;
    assert_eq!(levels(&plant), ["Twigs_High", "Twigs_Low"]);
    plant.mesh.parts[0].names = vec!["TwigsLow".to_owned()];
    assert_eq!(levels(&plant), ["Twigs_High", "TwigsLow"]);
    plant.mesh.parts = vec![part(&plant, &["Elm_Summer"], 0..count), part(&plant, &["elm-autumn"], 0..count)];
    assert_eq!(levels(&plant), ["elm-autumn", "Elm_Summer"], "two seasons");
    plant.mesh.parts = vec![part(&plant, &["a"], 0..count), part(&plant, &["b"], 0..count)];
    plant.mesh.parts[1].uses[0].triangles /= 4;
    assert_eq!(levels(&plant), ["a", "b"], "they fill one box");
    plant.mesh.parts.clear();
    plant.mesh.materials[0].name = "leaf_lod0".to_owned();
    plant.mesh.materials[1].name = "leaf_lod1".to_owned();
    assert_eq!(levels(&plant), ["leaf_lod0", "leaf_lod1"]);
}

#[test]
fn whole_plants_in_much_the_same_box_are_levels_whatever_their_names() {
    let [wood, leaves] = tree();
    let mut plant = plant(&wood, &leaves, |point| point);
    let whole = |name: &str| {
        let mut both = part(&plant, &[name], 0..wood.len());
        both.uses.extend(part(&plant, &[], wood.len()..wood.len() + leaves.len()).uses);
        both
    };
    let [a, mut b] = ["Oak.L0", "Oak.L1"].map(whole);
    let branch = part(&plant, &["branch"], 0..wood.len());
    let mut doubts = |parts: &[&Part]| {
        plant.mesh.parts = parts.iter().map(|part| (*part).clone()).collect();
        all_found(&plant, Up::Y)
    };
    let levels =
        |doubts: Vec<Doubt>| matches!(doubts.as_slice(), [Doubt::Levels { names }] if names.len() == 2);
    assert!(levels(doubts(&[&a, &b])), "twice the same plant");
    let longest = (0..3).map(|k| a.uses[0].bounds_m.max[k] - a.uses[0].bounds_m.min[k]).fold(0.0, f64::max);
    b.uses.iter_mut().for_each(|used| {
        used.bounds_m.max[0] += 0.1 * longest;
        used.foot.middle_m[0] += 1.0;
    });
    assert_eq!(doubts(&[&a, &b]), [], "two stems of one shrub");
    b.uses.iter_mut().for_each(|used| used.triangles /= 4);
    assert!(levels(doubts(&[&a, &b])), "a coarse level with larger leaves");
    assert_eq!(doubts(&[&a, &branch]), []);
}

#[test]
fn a_plant_that_was_imported_twice_is_a_doubt_though_each_has_materials_of_its_own() {
    let [wood, leaves] = tree();
    let mut plant = plant(&wood, &leaves, |point| point);
    let count = plant.classes.len() as u32;
    let whole = |name: &str, first_material: u32| {
        let mut both = part(&plant, &[name], 0..wood.len());
        both.uses.extend(part(&plant, &[], wood.len()..wood.len() + leaves.len()).uses);
        both.uses.iter_mut().for_each(|used| used.material += first_material);
        both
    };
    let parts = vec![whole("Oak", 0), whole("Oak.001", count)];
    plant.classes.extend_from_within(..);
    plant.mesh.materials.extend_from_within(..);
    plant.mesh.parts = parts;
    let found = all_found(&plant, Up::Y);
    assert!(
        matches!(found.as_slice(), [Doubt::Levels { names }] if names == &["Oak", "Oak.001"]),
        "{found:?}"
    );
}

#[test]
fn plants_beside_each_other_are_a_doubt() {
    let [wood, leaves] = tree();
    let moved = |of: &[foot::Triangle]| {
        let copies = of.iter().map(|triangle| triangle.map(|[x, y, z]| [x + 14.0, y, z + 2.0]));
        of.iter().copied().chain(copies).collect::<Vec<_>>()
    };
    let mut plant = plant(&moved(&wood), &moved(&leaves), |point| point);
    let stands = |plant: &ClassedMesh| match all_found(plant, Up::Y).as_slice() {
        [Doubt::Apart { stands }] => stands.clone(),
        other => panic!("{other:?}"),
    };
    assert!(stands(&plant)[0].starts_with("at x "), "{:?}", stands(&plant));
    let (count, all) = (wood.len(), 2 * wood.len());
    plant.mesh.parts = vec![part(&plant, &["Oak"], 0..count), part(&plant, &["Pine"], count..all)];
    assert_eq!(stands(&plant), ["Oak", "Pine"]);
    let text = all_found(&plant, Up::Y)[0].to_string();
    assert_eq!(text, "2 parts stand apart, as 2 plants do: 'Oak', 'Pine'; expected one plant");
}

#[test]
fn a_plant_without_wood_or_leaves_and_a_material_that_is_all_cut_are_doubts() {
    let [wood, leaves] = tree();
    let names = |plant: &ClassedMesh| all_found(plant, Up::Y).iter().map(Doubt::name).collect::<Vec<_>>();
    assert!(names(&plant(&[], &leaves, |point| point)).contains(&"no-wood"));
    assert!(names(&plant(&wood, &[], |point| point)).contains(&"no-leaf"));
    let mut cut = plant(&wood, &leaves, |point| point);
    cut.mesh.materials[0].alpha_mode = AlphaMode::Cut { cutoff: 0.5 };
    cut.mesh.materials[0].base_color[3] = 0.2;
    match all_found(&cut, Up::Y).as_slice() {
        [Doubt::CutAway { material, area_m2, left }] => {
            assert_eq!((material.as_str(), *left), ("leaf", 0.0));
            assert!((area_m2 - 15.0 * 0.02).abs() < 1e-6, "{area_m2}");
        }
        other => panic!("{other:?}"),
    }
}

#[test]
fn a_material_whose_triangles_show_next_to_nothing_of_its_image_is_a_doubt() {
    let [wood, leaves] = tree();
    let mut cut = plant(&wood, &leaves, |point| point);
    // Of 64 columns the upper half is there, and one of the others.
    let texel = |at: u32| [80, 160, 40, if at % 64 >= 32 || at % 64 == 3 { 255 } else { 0 }];
    let rgba = (0..64 * 64).flat_map(texel).collect();
    let name = "leaf.png".to_owned();
    cut.mesh.images = vec![crate::mesh::Image { name, width: 64, height: 64, rgba, has_cut: true }];
    let (wrap, transform) = ([crate::mesh::Wrap::Repeat; 2], [[1.0, 0.0, 0.0], [0.0, 1.0, 0.0]]);
    cut.mesh.materials[0].color_texture =
        Some(crate::mesh::Texture { image: 0, wrap, transform, filter: crate::mesh::Filter::Linear });
    cut.mesh.materials[0].alpha_mode = AlphaMode::Cut { cutoff: 0.5 };
    let mut found = |low: f32, high: f32| {
        let middle = 0.5 * (low + high);
        let corners = [[low, 0.1], [high, 0.1], [middle, 0.9]];
        cut.mesh.uvs = vec![[0.0; 2]; cut.mesh.positions.len()];
        for triangle in &cut.mesh.triangles {
            (0..3).for_each(|corner| cut.mesh.uvs[triangle[corner] as usize] = corners[corner]);
        }
        match all_found(&cut, Up::Y).as_slice() {
            [] => None,
            [doubt @ Doubt::CutAway { left, .. }] => Some((*left, doubt.to_string())),
            other => panic!("{other:?}"),
        }
    };
    assert_eq!(found(0.0, 1.0), None);
    // As where a file states no texture coordinates.
    let (left, text) = found(0.0, 0.0).expect("a doubt");
    assert_eq!(
        (left, text.contains("alpha leaves nothing of 0.3 m^2 of the material \"leaf\"")),
        (0.0, true),
        "{text}"
    );
    let (left, text) = found(0.0, 3.05 / 64.0).expect("a doubt");
    assert!(left < 0.01, "{left}");
    assert!(left == 0.0 || text.contains(" m^2 of the material \"leaf\""), "{text}");
}
