//! Second sheets of leaves of our own, and leaves without.

use flb_fixtures::{PlantKind, grow};
use glam::DQuat;

use super::*;
use crate::PlantReader;
use crate::mesh::testing::soup;
use crate::mesh::{AlphaMode, Filter, Image, Texture, Wrap};

/// A sheet of a square leaf of 0.1 m.
#[derive(Clone, Copy)]
struct Sheet {
    /// Metres before the leaf.
    gap_m: f64,
    /// Of the leaf's edge.
    size: f64,
    /// To the side, in edges of the leaf.
    aside: f64,
    /// Cells along the edge, of two triangles each.
    cells: u32,
}

const LEAF: Sheet = Sheet { gap_m: 0.0, size: 1.0, aside: 0.0, cells: 1 };

/// 300 leaves in a plant of 2 m, of which every `one_of`th has second sheets. Cells of sheets before or behind are cut
/// along the other diagonal.
fn plant(leaf: Sheet, one_of: usize, second: &[Sheet]) -> ClassedMesh {
    let mut triangles = Vec::new();
    for number in 0..300usize {
        let place = |step: f64| (number as f64 * step).fract();
        let middle = DVec3::new(place(0.618), 2.0 * place(0.414), place(0.732));
        let turn = DQuat::from_rotation_y(7.0 * place(0.123)) * DQuat::from_rotation_x(1.4 * place(0.377));
        let mut sheet = |Sheet { gap_m, size, aside, cells }: Sheet| {
            let corner = |x: u32, y: u32| {
                let along = |c: u32| 0.1 * size * (f64::from(c) / f64::from(cells) - 0.5);
                (middle + turn * DVec3::new(0.1 * aside + along(x), gap_m, along(y))).as_vec3().to_array()
            };
            for (x, y) in (0..cells).flat_map(|y| (0..cells).map(move |x| (x, y))) {
                let [a, b, c, d] =
                    [[x, y], [x + 1, y], [x + 1, y + 1], [x, y + 1]].map(|[x, y]| corner(x, y));
                triangles.extend(if gap_m == 0.0 { [[a, b, c], [a, c, d]] } else { [[a, d, b], [b, d, c]] });
            }
        };
        sheet(leaf);
        if number % one_of == 0 {
            second.iter().copied().for_each(&mut sheet);
        }
    }
    let mut mesh = soup(&triangles);
    mesh.triangle_material.fill(0);
    ClassedMesh::of(mesh, vec![MaterialClass::Leaf; 2])
}

fn doubt_of(plant: &ClassedMesh, longest_m: f64) -> Option<Doubt> {
    doubt(plant, &Leaves::of(plant), longest_m)
}

/// Area with a second sheet, area of leaf, gap; zeros without a doubt.
fn found(plant: &ClassedMesh) -> [f64; 3] {
    match doubt_of(plant, 2.0) {
        Some(Doubt::SecondSheets { sheets_m2, leaf_m2, gap_m }) => [sheets_m2, leaf_m2, gap_m],
        None => [0.0; 3],
        other => panic!("{other:?}"),
    }
}

/// That for leaves of which each has this second sheet.
fn with(second: Sheet) -> [f64; 3] {
    found(&plant(LEAF, 1, &[second]))
}

fn assert_near(found: [f64; 3], expected: [f64; 3], tolerance: f64) {
    let is_near = |(found, expected): (f64, f64)| (found - expected).abs() <= tolerance * expected;
    assert!(found.into_iter().zip(expected).all(is_near), "{found:?}, expected {expected:?}");
}

#[test]
fn second_sheets_of_one_outline_are_a_doubt_with_their_area() {
    for gap_m in [0.001, -0.003, 0.005] {
        assert_near(with(Sheet { gap_m, ..LEAF }), [6.0, 6.0, gap_m.abs()], 0.05);
    }
    let one_of_three = found(&plant(LEAF, 3, &[Sheet { gap_m: 0.002, ..LEAF }]));
    assert_near(one_of_three, [2.0, 4.0, 0.002], 0.05);
    for size in [0.95, 1.04] {
        assert!(with(Sheet { gap_m: 0.001, size, ..LEAF })[0] > 1.0, "{size}");
    }
    let doubt = doubt_of(&plant(LEAF, 1, &[Sheet { gap_m: 0.002, ..LEAF }]), 2.0);
    let text = doubt.map(|doubt| doubt.to_string()).unwrap_or_default();
    assert!(text.contains("of 6 m2 of leaf have a second sheet 0.002 m"), "{text}");
}

#[test]
fn second_sheets_of_leaves_that_are_finely_cut_are_a_doubt() {
    for [cells, of_second] in [[5, 7], [8, 8], [12, 1]] {
        let second = Sheet { gap_m: 0.003, cells: of_second, ..LEAF };
        assert_near(found(&plant(Sheet { cells, ..LEAF }, 1, &[second])), [6.0, 6.0, 0.003], 0.3);
    }
    // A quarter of the leaves, and none.
    let second = Sheet { gap_m: 0.003, cells: 8, ..LEAF };
    let fine = Sheet { cells: 8, ..LEAF };
    assert_near(found(&plant(fine, 4, &[second])), [1.5, 3.75, 0.003], 0.3);
    assert_eq!(found(&plant(fine, 1, &[])), [0.0; 3]);
}

#[test]
fn sheets_that_cover_a_part_of_each_other_are_a_doubt() {
    // One in the other's plane, one beside it; and two leaves that only touch.
    assert_near(with(Sheet { size: 0.7, ..LEAF }), [2.94, 4.47, 0.0], 0.2);
    let doubt = doubt_of(&plant(LEAF, 1, &[Sheet { size: 0.7, ..LEAF }]), 2.0).map(|doubt| doubt.to_string());
    assert!(
        doubt.as_ref().is_some_and(|text| text.contains("m2 of leaf have a second sheet on them")),
        "{doubt:?}"
    );
    assert_near(with(Sheet { gap_m: 0.0001, aside: 0.5, ..LEAF }), [3.0, 6.0, 0.0001], 0.2);
    assert_eq!(with(Sheet { gap_m: 0.0001, aside: 1.0, ..LEAF }), [0.0; 3]);
}

#[test]
fn a_sheet_inside_of_a_flat_box_is_a_doubt() {
    // The box is a leaf, the sheet another.
    let [low, high] = [-0.001, 0.001].map(|gap_m| Sheet { gap_m, ..LEAF });
    let mut plant = plant(LEAF, 1, &[low, high]);
    plant.mesh.sheets.sides =
        (0..plant.mesh.triangles.len()).map(|at| if at % 6 < 2 { Side::Both } else { Side::Front }).collect();
    assert_near(found(&plant), [3.0, 6.0, 0.001], 0.01);
}

#[test]
fn leaves_beside_leaves_and_those_of_one_sheet_or_of_two_that_were_found_are_no_doubt() {
    assert_eq!(found(&plant(LEAF, 400, &[Sheet { gap_m: 0.02, ..LEAF }])), [0.0; 3]);
    assert_eq!(with(Sheet { gap_m: 0.03, ..LEAF }), [0.0; 3]);
    assert_eq!(with(Sheet { gap_m: 0.0002, ..LEAF }), [0.0; 3], "two sides of one leaf");
    for kind in [PlantKind::Oak, PlantKind::Spruce, PlantKind::Shrub] {
        let folder = tempfile::tempdir().expect("a folder");
        let path = folder.path().join("plant.glb");
        std::fs::write(&path, grow(kind, 7, 20_000).expect("a kind").to_glb()).expect("written");
        let (plant, _) = PlantReader::default().read(&path).expect("a plant");
        assert_eq!(doubt_of(&plant, 10.0), None, "{kind:?}");
    }
}

#[test]
fn sheets_of_which_alpha_leaves_one_at_a_place_are_no_doubt() {
    // The left half of the image is there, the right half is not.
    let with_second_at = |u: f32| {
        let mut plant = plant(LEAF, 1, &[Sheet { size: 0.7, ..LEAF }]);
        let mesh = &mut plant.mesh;
        let rgba = (0..16).flat_map(|at| [80, 160, 40, if at % 4 < 2 { 255 } else { 0 }]).collect();
        let (wrap, transform) = ([Wrap::Repeat; 2], [[1.0, 0.0, 0.0], [0.0, 1.0, 0.0]]);
        mesh.images = vec![Image { name: "a.png".to_owned(), width: 4, height: 4, rgba, has_cut: true }];
        mesh.materials[0].color_texture =
            Some(Texture { image: 0, wrap, transform, filter: Filter::Nearest });
        mesh.materials[0].alpha_mode = AlphaMode::Cut { cutoff: 0.5 };
        for (at, uv) in mesh.uvs.iter_mut().enumerate() {
            *uv = [if at / 6 % 2 == 0 { 0.25 } else { u }, 0.5];
        }
        found(&plant)
    };
    assert_eq!(with_second_at(0.75), [0.0; 3]);
    assert_near(with_second_at(0.25), [2.94, 4.47, 0.0], 0.2);
}
