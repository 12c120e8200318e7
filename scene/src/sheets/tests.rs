use glam::{DVec3, Vec3};

use super::find;
use crate::MaterialClass::{self, Leaf, Neither, Wood};
use crate::mesh::sides::Side;
use crate::mesh::testing::{identity, image, soup};
use crate::mesh::{AlphaMode, Material, Mesh, Wrap};
use crate::rays::{Ray, RayMesh};
use crate::sampling::hash;

const CLASSES: [MaterialClass; 2] = [Leaf, Wood];

/// 0..1, of a seed.
fn chance(seed: u32) -> f32 {
    (hash(seed) >> 8) as f32 / (1u32 << 24) as f32
}

/// Leaves of 10 x 10 cm in a plant of 2 m: corner and two edges of each.
fn leaves(count: u32) -> Vec<[Vec3; 3]> {
    let vector = |seed: u32| Vec3::from_array([0, 1, 2].map(|axis| chance(seed + axis) - 0.5));
    let leaf = |i: u32| {
        let along = vector(100 * i + 3).normalize();
        let across = along.cross(vector(100 * i + 6)).normalize();
        [2.0 * vector(100 * i), 0.1 * along, 0.1 * across]
    };
    (0..count).map(leaf).collect()
}

/// Two triangles per leaf, cut along one diagonal or the other, `lift` metres before it, wound as said.
fn quads(leaves: &[[Vec3; 3]], other_diagonal: bool, turned: bool, lift: f32) -> Vec<[[f32; 3]; 3]> {
    let mut all = Vec::new();
    for &[at, along, across] in leaves {
        let from = at + lift * along.cross(across).normalize();
        let corners = [from, from + along, from + along + across, from + across];
        let triangles = if other_diagonal { [[1, 2, 3], [1, 3, 0]] } else { [[0, 1, 2], [0, 2, 3]] };
        for [a, b, c] in triangles {
            let order = if turned { [a, c, b] } else { [a, b, c] };
            all.push(order.map(|corner: usize| corners[corner].to_array()));
        }
    }
    all
}

/// With other materials for the triangles from one on.
fn mesh(triangles: &[[[f32; 3]; 3]]) -> Mesh {
    soup(triangles)
}

fn counted_m2(mesh: &Mesh, classes: &[MaterialClass], class: MaterialClass) -> f64 {
    let of_class = (0..mesh.triangles.len())
        .filter(|&triangle| classes[mesh.triangle_material[triangle] as usize] == class);
    of_class
        .map(|triangle| {
            let [a, b, c] = super::corners(mesh, triangle as u32);
            (b - a).cross(c - a).length() / 2.0 * mesh.sheets.side(triangle).share()
        })
        .sum()
}

/// How often parallel rays along a direction, and against it, meet leaves of the mesh.
fn meetings(mesh: &Mesh, towards: Vec3) -> [u32; 2] {
    let rays = RayMesh::new(mesh, false).unwrap();
    let across = towards.any_orthonormal_vector();
    let other = towards.cross(across);
    let mut met = [0; 2];
    for (way, direction) in [towards, -towards].into_iter().enumerate() {
        for i in 0..64 * 64 {
            let place = [i % 64, i / 64].map(|at| (at as f32 + 0.5) / 64.0 * 3.0 - 1.5);
            let mut origin = across * place[0] + other * place[1] - direction * 4.0;
            let mut except = None;
            while let Some(found) = rays.find(Ray { origin, direction }, f32::INFINITY, except) {
                met[way] += 1;
                except = Some(found.triangle);
                origin += direction * (found.distance + 1e-5);
            }
        }
    }
    met
}

const AWAY: Vec3 = Vec3::new(0.48, 0.6, 0.64);

#[test]
fn plain_leaves_stay_as_they_are() {
    let mut plant = mesh(&quads(&leaves(200), false, false, 0.0));
    let before = plant.clone();
    find(&mut plant, &CLASSES);
    assert_eq!(plant, before);
}

#[test]
fn a_second_sheet_counts_half_and_every_ray_meets_each_leaf_once() {
    let leaves = leaves(200);
    let one = mesh(&quads(&leaves, false, false, 0.0));
    let [once, back] = meetings(&one, AWAY);
    assert_eq!(once, back);
    for other_diagonal in [false, true] {
        for turned in [false, true] {
            for lift in [0.0, 1e-7, 1e-5, 2e-4, -2e-4] {
                if lift == 0.0 && !other_diagonal {
                    continue; // Import drops exact copies within one material.
                }
                let mut both = quads(&leaves, false, false, 0.0);
                both.extend(quads(&leaves, other_diagonal, turned, lift));
                let mut plant = mesh(&both);
                find(&mut plant, &CLASSES);
                let case = format!("other diagonal {other_diagonal}, turned {turned}, lift {lift}");
                assert_eq!(plant.triangles.len(), 800, "{case}");
                assert!((counted_m2(&plant, &CLASSES, Leaf) - 2.0).abs() < 1e-4, "{case}");
                assert_eq!(plant.sheets.pairs.triangles, 800, "{case}");
                let found = meetings(&plant, AWAY);
                // An edge is met by one sheet more or less.
                let off = found.map(|met| (f64::from(met) / f64::from(once) - 1.0).abs());
                assert!(off[0] < 0.02 && off[1] < 0.02, "{case}: {found:?} for {once}");
            }
        }
    }
}

#[test]
fn sheets_look_away_from_each_other() {
    // Some of so many cross each other.
    let leaves = leaves(1000);
    for turned in [false, true] {
        let mut both = quads(&leaves, false, false, 0.0);
        both.extend(quads(&leaves, true, turned, 2e-4));
        let mut plant = mesh(&both);
        find(&mut plant, &CLASSES);
        // The second sheet lies before the first.
        assert!(plant.sheets.sides[..2000].iter().all(|side| *side == Side::Back));
        let outer = if turned { Side::Back } else { Side::Front };
        assert!(plant.sheets.sides[2000..].iter().all(|side| *side == outer));
    }
}

#[test]
fn a_back_that_is_cut_into_other_triangles_is_found() {
    let leaves = leaves(100);
    let mut both = quads(&leaves, false, false, 0.0);
    for &[at, along, across] in &leaves {
        let (along, across) = (along / 3.0, across / 3.0);
        let parts: Vec<[Vec3; 3]> = (0..9u8)
            .map(|i| [at + along * f32::from(i % 3) + across * f32::from(i / 3), along, across])
            .collect();
        both.extend(quads(&parts, true, true, 1e-5));
    }
    let mut plant = mesh(&both);
    find(&mut plant, &CLASSES);
    assert!((counted_m2(&plant, &CLASSES, Leaf) - 1.0).abs() < 1e-3);
}

#[test]
fn a_third_sheet_is_dropped() {
    let leaves = leaves(100);
    let mut three = quads(&leaves, false, false, 0.0);
    three.extend(quads(&leaves, true, false, 0.0));
    three.extend(quads(&leaves, true, true, 1e-5));
    let mut plant = mesh(&three);
    find(&mut plant, &CLASSES);
    assert_eq!((plant.triangles.len(), plant.sheets.dropped, plant.sheets.further), (400, 0, 200));
    let notes = plant.sheets.notes();
    assert!(
        notes[0].starts_with("dropped 200 triangles of third and further sheets of one leaf"),
        "{notes:?}"
    );
    assert!((counted_m2(&plant, &CLASSES, Leaf) - 1.0).abs() < 1e-3);
}

#[test]
fn leaves_that_lie_near_each_other_are_two_leaves() {
    let leaves = leaves(100);
    let mut both = quads(&leaves, false, false, 0.0);
    // Farther than sheets of one leaf lie apart; and half over each other only.
    both.extend(quads(&leaves, false, false, 4e-3));
    let half: Vec<[Vec3; 3]> =
        leaves.iter().map(|&[at, along, across]| [at + 0.5 * along, along, across]).collect();
    both.extend(quads(&half, false, false, 1e-5));
    let mut plant = mesh(&both);
    let before = plant.clone();
    find(&mut plant, &CLASSES);
    assert_eq!(plant, before);
}

/// A front and a back under two materials.
fn two_materials(classes: &[MaterialClass]) -> Mesh {
    let leaves = leaves(100);
    let mut both = quads(&leaves, false, false, 0.0);
    both.extend(quads(&leaves, false, false, 0.0));
    let mut plant = mesh(&both);
    plant.triangle_material = (0..400).map(|triangle| u32::from(triangle >= 200)).collect();
    find(&mut plant, classes);
    plant
}

#[test]
fn two_leaf_materials_over_the_same_points_are_two_sides() {
    let plant = two_materials(&[Leaf, Leaf]);
    assert_eq!(plant.triangles.len(), 400);
    assert!((counted_m2(&plant, &[Leaf, Leaf], Leaf) - 1.0).abs() < 1e-4);
    assert!(plant.sheets.sides[..200].iter().all(|side| *side == Side::Front));
    assert!(plant.sheets.sides[200..].iter().all(|side| *side == Side::Back));
}

#[test]
fn what_is_ignored_takes_nothing_with_it_and_wood_goes_before_leaf() {
    for (classes, kept) in [
        ([Neither, Leaf], [0, 200]),
        ([Leaf, Neither], [200, 0]),
        ([Neither, Wood], [0, 200]),
        ([Leaf, Wood], [0, 200]),
        ([Wood, Leaf], [200, 0]),
        ([Wood, Wood], [200, 0]),
        ([Neither, Neither], [200, 0]),
    ] {
        let plant = two_materials(&classes);
        let count = |wanted: u32| plant.triangle_material.iter().filter(|&&of| of == wanted).count();
        assert_eq!([count(0), count(1)], kept, "{classes:?}");
        assert_eq!(plant.sheets.dropped, 200);
        assert!(plant.sheets.sides.is_empty());
        assert_eq!(plant.triangles.len(), plant.triangle_material.len());
    }
}

#[test]
fn halves_that_alpha_leaves_beside_each_other_are_no_two_sides() {
    let mut plant = two_materials(&[Leaf, Leaf]);
    for (material, is_left) in [(0, true), (1, false)] {
        let half = image(8, 8, |x, _| (x < 4) == is_left);
        plant.images.push(half);
        let mut cut = Material::opaque("leaf");
        cut.alpha_mode = AlphaMode::Cut { cutoff: 0.5 };
        cut.color_texture = Some(identity(material as u32, Wrap::Clamp));
        plant.materials[material] = cut;
    }
    plant.uvs = (0..plant.positions.len() / 6)
        .flat_map(|_| [[0.0, 0.0], [1.0, 0.0], [1.0, 1.0], [0.0, 0.0], [1.0, 1.0], [0.0, 1.0]])
        .collect();
    find(&mut plant, &[Leaf, Leaf]);
    assert!(plant.sheets.sides.is_empty());
    // The same half of both is a leaf of two sides.
    plant.images[1] = plant.images[0].clone();
    find(&mut plant, &[Leaf, Leaf]);
    assert_eq!(plant.sheets.pairs.triangles, 400);
}

/// Prisms with `sides` sides along the leaves' first edge, with or without their ends; every `n`th triangle is turned.
fn needles(leaves: &[[Vec3; 3]], sides: u32, radius: f32, has_ends: bool, turned: u32) -> Mesh {
    let mut all = Vec::new();
    for &[at, along, across] in leaves {
        let (x, y) = (across.normalize() * radius, along.cross(across).normalize() * radius);
        let corner = |side: u32, end: u32| {
            let (sin, cos) = libm::sincosf(std::f32::consts::TAU * (side % sides) as f32 / sides as f32);
            (at + x * cos + y * sin + along * end as f32).to_array()
        };
        for side in 0..sides {
            let [a, b] = [side, side + 1];
            all.push([corner(a, 1), corner(a, 0), corner(b, 0)]);
            all.push([corner(a, 1), corner(b, 0), corner(b, 1)]);
            if has_ends && side > 0 && side + 1 < sides {
                all.push([corner(0, 0), corner(b, 0), corner(a, 0)]);
                all.push([corner(0, 1), corner(a, 1), corner(b, 1)]);
            }
        }
    }
    for (number, triangle) in all.iter_mut().enumerate() {
        if turned > 0 && (number as u32).is_multiple_of(turned) {
            triangle.swap(1, 2);
        }
    }
    mesh(&all)
}

#[test]
fn needles_that_are_tubes_are_leaves_of_half_their_area() {
    let leaves = leaves(60);
    for (sides, has_ends, turned) in [(3, true, 0), (3, false, 0), (6, true, 1), (6, false, 3), (8, true, 2)]
    {
        let mut plant = needles(&leaves, sides, 1e-3, has_ends, turned);
        let all = counted_m2(&plant, &CLASSES, Leaf);
        find(&mut plant, &CLASSES);
        let case = format!("{sides} sides, ends {has_ends}, turned {turned}");
        assert_eq!(plant.sheets.shells.triangles as usize, plant.triangles.len(), "{case}");
        assert!((counted_m2(&plant, &CLASSES, Leaf) / all - 0.5).abs() < 1e-9, "{case}");
        // Outer sides: away from the axis.
        for triangle in 0..plant.triangles.len() as u32 {
            let [a, b, c] = super::corners(&plant, triangle);
            let [at, along, _] = leaves[triangle as usize * leaves.len() / plant.triangles.len()];
            let middle = (at + along / 2.0).as_dvec3();
            let outwards = (b - a).cross(c - a).dot((a + b + c) / 3.0 - middle) > 0.0;
            let side = plant.sheets.side(triangle as usize);
            assert_eq!(side, if outwards { Side::Front } else { Side::Back }, "{case}");
        }
    }
}

#[test]
fn needles_that_are_spikes_without_a_foot_are_leaves_of_half_their_area() {
    for (sides, count) in [(3, 60), (5, 60), (8, 1000)] {
        let mut all = Vec::new();
        for &[at, along, across] in &leaves(count) {
            let (x, y) = (across.normalize() * 1e-3, along.cross(across).normalize() * 1e-3);
            let corner = |side: u32| {
                let (sin, cos) = libm::sincosf(std::f32::consts::TAU * (side % sides) as f32 / sides as f32);
                (at + x * cos + y * sin).to_array()
            };
            all.extend((0..sides).map(|side| [(at + along).to_array(), corner(side), corner(side + 1)]));
        }
        let mut plant = mesh(&all);
        let area_m2 = counted_m2(&plant, &CLASSES, Leaf);
        find(&mut plant, &CLASSES);
        assert_eq!(plant.sheets.shells.triangles as usize, plant.triangles.len(), "{sides}");
        assert!((counted_m2(&plant, &CLASSES, Leaf) / area_m2 - 0.5).abs() < 1e-9, "{sides}");
    }
}

#[test]
fn a_blade_with_a_thickness_is_one_leaf() {
    let mut triangles = Vec::new();
    for &[at, along, across] in &leaves(60) {
        let up = along.cross(across).normalize() * 2e-3;
        let corner = |i: usize| {
            let part = |bit: usize, edge: Vec3| if i >> bit & 1 == 1 { edge } else { Vec3::ZERO };
            (at + part(0, along) + part(1, across) + part(2, up)).to_array()
        };
        for [a, b, c, d] in
            [[0, 2, 3, 1], [4, 5, 7, 6], [0, 1, 5, 4], [2, 6, 7, 3], [0, 4, 6, 2], [1, 3, 7, 5]]
        {
            triangles.extend([[a, b, c], [a, c, d]].map(|of| of.map(corner)));
        }
    }
    let mut plant = mesh(&triangles);
    find(&mut plant, &CLASSES);
    assert_eq!(plant.sheets.shells.triangles, 720);
    assert!(plant.sheets.sides.iter().all(|side| *side == Side::Front));
    let sheet = meetings(&mesh(&quads(&leaves(60), false, false, 1e-3)), AWAY)[0];
    for met in meetings(&plant, AWAY) {
        // Its narrow sides show, too.
        assert!((0.97..1.12).contains(&(f64::from(met) / f64::from(sheet))), "{met} for {sheet}");
    }
}

/// A ball of `rings` rings.
fn ball(at: Vec3, radius: f32, rings: u32) -> Vec<[[f32; 3]; 3]> {
    let point = |turn: u32, ring: u32| {
        let (sin, cos) = libm::sincosf(std::f32::consts::PI * ring as f32 / rings as f32);
        let (x, z) = libm::sincosf(std::f32::consts::PI * (turn % (2 * rings)) as f32 / rings as f32);
        let sin = if ring == 0 || ring == rings { 0.0 } else { sin };
        (at + radius * Vec3::new(sin * x, cos, sin * z)).to_array()
    };
    let mut all = Vec::new();
    for (turn, ring) in (0..2 * rings).flat_map(|turn| (0..rings).map(move |ring| (turn, ring))) {
        let [a, b, c, d] = [(turn, ring), (turn, ring + 1), (turn + 1, ring + 1), (turn + 1, ring)]
            .map(|(turn, ring)| point(turn, ring));
        if ring + 1 < rings {
            all.push([a, b, c]);
        }
        if ring > 0 {
            all.push([a, c, d]);
        }
    }
    all
}

#[test]
fn a_crown_that_is_a_ball_and_a_fruit_stay_and_are_told() {
    let mut triangles = ball(Vec3::ZERO, 1.0, 8);
    triangles.extend(ball(Vec3::new(0.0, 1.5, 0.0), 0.05, 6));
    let mut plant = mesh(&triangles);
    let all = counted_m2(&plant, &CLASSES, Leaf);
    find(&mut plant, &CLASSES);
    assert!(plant.sheets.sides.is_empty());
    let thick = plant.sheets.thick;
    assert!((thick.area_m2 / all - 1.0).abs() < 1e-9);
    assert!((thick.thickness_m - 2.0 / 3.0).abs() < 0.05, "{thick:?}");
}

#[test]
fn open_sheets_are_no_shells() {
    // A bent leaf of many triangles, a half of a tube, and a leaf folded over.
    let strip = |turn: f32, steps: u32| -> Vec<[[f32; 3]; 3]> {
        let corner = |step: u32, end: u32| {
            let (sin, cos) = libm::sincosf(turn * step as f32 / steps as f32);
            [0.02 * cos, 0.02 * sin, 0.3 * end as f32]
        };
        (0..steps)
            .flat_map(|step| {
                let [a, b, c, d] =
                    [(step, 0), (step + 1, 0), (step + 1, 1), (step, 1)].map(|(s, e)| corner(s, e));
                [[a, b, c], [a, c, d]]
            })
            .collect()
    };
    for turn in [1.0, 3.2, 5.0] {
        let mut plant = mesh(&[strip(turn, 12), ball(Vec3::splat(1.0), 0.5, 4)].concat());
        let before = plant.clone();
        find(&mut plant, &CLASSES);
        assert_eq!((plant.sheets.sides.len(), plant.triangles.len()), (0, before.triangles.len()), "{turn}");
    }
}

#[test]
fn a_few_leaves_of_two_sheets_among_many_are_found() {
    let leaves = leaves(10_000);
    let mut both = quads(&leaves, false, false, 0.0);
    both.extend(quads(&leaves[..400], true, true, 1e-5));
    let mut plant = mesh(&both);
    find(&mut plant, &CLASSES);
    assert!(plant.sheets.pairs.triangles.abs_diff(1600) <= 4, "{:?}", plant.sheets.pairs);
    let mut plant = needles(&leaves[..4000], 3, 1e-3, true, 0);
    find(&mut plant, &CLASSES);
    assert_eq!(plant.sheets.shells.triangles, 32_000);
}

#[test]
fn many_leaves_in_one_place_take_no_time() {
    let one = leaves(1);
    let mut all = Vec::new();
    for layer in 0..20_000 {
        all.extend(quads(&one, false, false, layer as f32 * 1e-9));
    }
    all.extend(quads(&[[Vec3::ZERO, 2.0 * Vec3::X, 2.0 * Vec3::Y]], false, false, 0.0));
    let begin = std::time::Instant::now();
    find(&mut mesh(&all), &CLASSES);
    assert!(begin.elapsed().as_secs() < 20, "{:?}", begin.elapsed());
}

#[test]
fn what_is_no_mesh_is_left_to_those_who_read_it() {
    let whole = mesh(&quads(&leaves(3), false, false, 0.0));
    let spoil: [fn(&mut Mesh); 4] = [
        |mesh| mesh.positions[4][1] = f32::NAN,
        |mesh| mesh.triangles[2][0] = 999,
        |mesh| mesh.triangle_material[1] = 7,
        |mesh| _ = mesh.triangle_material.pop(),
    ];
    for spoil in spoil {
        let mut plant = whole.clone();
        spoil(&mut plant);
        find(&mut plant, &CLASSES);
        assert!(plant.sheets.sides.is_empty());
    }
    let mut plant = whole;
    find(&mut plant, &[Leaf]);
    assert!(plant.sheets.sides.is_empty());
    find(&mut Mesh::default(), &[]);
    let mut point = mesh(&[[[0.0; 3]; 3]]);
    find(&mut point, &CLASSES);
}

#[test]
fn a_side_is_met_from_its_own_side_alone() {
    let mut plant = mesh(&[[[0.0, 0.0, 0.0], [1.0, 0.0, 0.0], [0.0, 1.0, 0.0]]]);
    let meets = |plant: &Mesh, z: f32| {
        let rays = RayMesh::new(plant, false).unwrap();
        let ray = Ray { origin: Vec3::new(0.2, 0.2, z), direction: Vec3::new(0.0, 0.0, -z.signum()) };
        assert_eq!(rays.find(ray, f32::INFINITY, None).is_some(), rays.is_blocked(ray, None));
        rays.is_blocked(ray, None)
    };
    // Its front looks along +z.
    for (side, met) in [(Side::Both, [true, true]), (Side::Front, [true, false]), (Side::Back, [false, true])]
    {
        plant.sheets.sides = vec![side];
        assert_eq!([meets(&plant, 1.0), meets(&plant, -1.0)], met, "{side:?}");
    }
    let up = DVec3::Z;
    let [a, b, c] = super::corners(&plant, 0);
    assert!((b - a).cross(c - a).dot(up) > 0.0);
}
