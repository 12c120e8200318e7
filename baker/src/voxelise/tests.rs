use flb_format::Medium;
use flb_format::matter::Class;
use flb_scene::mesh::sides::Side;
use proptest::prelude::*;

use super::*;
use crate::downsample::downsample;
use flb_scene::mesh::testing::{card, identity, image, soup};
use flb_scene::mesh::{AlphaMode, Image, Texture, Wrap};

pub(crate) const LEAF_WOOD: [MaterialClass; 2] = [MaterialClass::Leaf, MaterialClass::Wood];

pub(crate) fn settings(voxels: u32, lattice: u32) -> VoxelSettings {
    VoxelSettings { voxels, lattice, ignore_alpha: false }
}

pub(crate) fn quiet(mesh: &Mesh, classes: &[MaterialClass], settings: &VoxelSettings) -> Occupancy {
    voxelise(mesh, classes, settings, &|_| Ok(())).expect("a good mesh")
}

/// Coordinates on a coarse raster as often as anywhere, so that faces, edges and corners are met exactly.
pub(crate) fn coordinate() -> impl Strategy<Value = f32> {
    prop_oneof![(-8i32..=8).prop_map(|c| c as f32 / 8.0), -1.0f32..1.0]
}

pub(crate) fn triangles(most: usize) -> impl Strategy<Value = Vec<[[f32; 3]; 3]>> {
    let point = [coordinate(), coordinate(), coordinate()];
    prop::collection::vec(prop::array::uniform3(point), 1..most)
}

pub(crate) fn uv() -> impl Strategy<Value = [f32; 2]> {
    prop_oneof![
        prop::array::uniform2((-8i32..=8).prop_map(|c| c as f32 / 4.0)),
        [-2.0f32..2.0, -2.0f32..2.0],
        Just([37.5, -40.25]),
    ]
}

pub(crate) fn wrap() -> impl Strategy<Value = Wrap> {
    prop_oneof![Just(Wrap::Repeat), Just(Wrap::Mirror), Just(Wrap::Clamp)]
}

/// A soup of leaf and wood with a cut image on the leaf.
pub(crate) fn cut_soup() -> impl Strategy<Value = Mesh> {
    let image_bits = (1u32..40, 1u32..24, any::<u64>(), 1u64..9);
    let uvs = prop::collection::vec(uv(), 24);
    let materials = prop::collection::vec(0u32..2, 8);
    (triangles(8), uvs, materials, image_bits, [wrap(), wrap()]).prop_map(
        |(triangles, uvs, materials, (width, height, seed, blob), wrap)| {
            let mut mesh = soup(&triangles);
            mesh.uvs = uvs[..mesh.positions.len()].to_vec();
            mesh.triangle_material = materials[..mesh.triangles.len()].to_vec();
            let bit = |x: u32, y: u32| {
                let place = u64::from(x) / blob * 31 + u64::from(y) / blob;
                place.wrapping_add(seed).wrapping_mul(0x9e37_79b9_7f4a_7c15) >> 62 == 0
            };
            mesh.images = vec![image(width, height, bit)];
            mesh.materials[0].color_texture = Some(Texture { wrap, ..identity(0, Wrap::Repeat) });
            mesh.materials[0].alpha_mode = AlphaMode::Cut { cutoff: 0.5 };
            mesh
        },
    )
}

pub(crate) fn has_extent(mesh: &Mesh) -> bool {
    mesh.bounds().is_some_and(|b| (0..3).any(|axis| b.max[axis] > b.min[axis]))
}

proptest! {
    #![proptest_config(ProptestConfig::with_cases(150))]

    #[test]
    fn occupancy_equals_the_brute_force_oracle(mesh in cut_soup(), voxels in prop_oneof![Just(16u32), Just(32)]) {
        prop_assume!(has_extent(&mesh));
        let settings = settings(voxels, 16);
        let expected = oracle::clusters(&mesh, &LEAF_WOOD, &settings).expect("a good mesh");
        let found = quiet(&mesh, &LEAF_WOOD, &settings);
        prop_assert_eq!(found.clusters(), &expected[..]);
    }

    #[test]
    fn neither_triangle_order_nor_vertex_order_nor_threads_matter(mesh in cut_soup(), turn in 0usize..3, flip: bool) {
        prop_assume!(has_extent(&mesh));
        let mut shuffled = mesh.clone();
        shuffled.triangles.reverse();
        shuffled.triangle_material.reverse();
        for triangle in &mut shuffled.triangles {
            triangle.rotate_left(turn);
            if flip {
                triangle.swap(0, 1);
            }
        }
        let settings = settings(64, 16);
        let pool = |threads| rayon::ThreadPoolBuilder::new().num_threads(threads).build().expect("a pool");
        let one = pool(1).install(|| quiet(&mesh, &LEAF_WOOD, &settings));
        let three = pool(3).install(|| quiet(&shuffled, &LEAF_WOOD, &settings));
        prop_assert_eq!(one, three);
    }

    #[test]
    fn half_of_the_area_of_one_side_counts(triangles in triangles(12)) {
        let mut mesh = soup(&triangles);
        prop_assume!(has_extent(&mesh));
        let whole = quiet(&mesh, &LEAF_WOOD, &settings(64, 16));
        mesh.sheets.sides = vec![Side::Front; mesh.triangles.len()];
        let half = quiet(&mesh, &LEAF_WOOD, &settings(64, 16));
        prop_assert!((half.area_m2()[0] / whole.area_m2()[0] - 0.5).abs() < 1e-6);
        prop_assert_eq!(half.clusters(), whole.clusters());
    }

    #[test]
    fn opaque_area_is_conserved(triangles in triangles(12)) {
        let mesh = soup(&triangles);
        prop_assume!(has_extent(&mesh));
        let occupancy = quiet(&mesh, &LEAF_WOOD, &settings(64, 16));
        let expected: f64 = triangles.iter().map(area_m2).sum();
        // Snapping moves a vertex by at most 2^-17 voxel along each axis; a triangle's edges (at most 2 sqrt 3 m)
        // bound what that changes.
        let voxel_m = occupancy.grid().spacing_m / 4.0;
        let bound = triangles.len() as f64 * 12.0 * voxel_m / f64::from(1 << 16) + 1e-9;
        let found = occupancy.area_m2()[0];
        prop_assert!((found - expected).abs() <= bound, "{} against {}", found, expected);
    }

    #[test]
    fn a_site_with_area_has_density_and_the_outer_layers_are_empty(mesh in cut_soup()) {
        prop_assume!(has_extent(&mesh));
        for voxels in [16, 48, 64] {
            let occupancy = quiet(&mesh, &LEAF_WOOD, &settings(voxels, 16));
            let medium = downsample(&occupancy).expect("a good occupancy");
            for area in occupancy.areas() {
                prop_assert!(medium.density[area.site as usize] > 0.0, "site {}", area.site);
            }
            prop_assert!(nothing_in_the_outer_two_layers(&medium));
        }
    }
}

fn nothing_in_the_outer_two_layers(medium: &Medium) -> bool {
    let n = medium.grid.lattice;
    let outer = |c: u32| c < 2 || c >= n - 2;
    (0..medium.grid.sites()).all(|site| {
        let inside = !medium.grid.site(site).into_iter().any(outer);
        inside || medium.class[site] == Class::Empty
    })
}

fn area_m2(triangle: &[[f32; 3]; 3]) -> f64 {
    let [a, b, c] = triangle.map(|p| p.map(f64::from));
    let edge = |to: [f64; 3]| -> [f64; 3] { std::array::from_fn(|axis| to[axis] - a[axis]) };
    piece::cross(edge(b), edge(c)).map(|c| c * c).iter().sum::<f64>().sqrt() / 2.0
}

/// Makes a voxel 1 m (within 1e-7) with the origin on a corner: two specks of wood fix the placement.
fn voxel_metres(mesh: &mut Mesh, voxels: u32) {
    let far = (f64::from(voxels) * 12.0 / 16.0 / (1.0 + 1.0 / 1024.0) / 2.0) as f32;
    for corner in [-far, far] {
        let first = mesh.positions.len() as u32;
        mesh.positions.extend([[corner; 3]; 3]);
        mesh.normals.extend([[0.0, 1.0, 0.0]; 3]);
        mesh.uvs.extend([[0.0; 2]; 3]);
        mesh.triangles.push([first, first + 1, first + 2]);
        mesh.triangle_material.push(1);
    }
}

/// Voxels with leaf, counted from the middle of the grid.
fn leaf_voxels(occupancy: &Occupancy) -> Vec<[i64; 3]> {
    let half = i64::from(occupancy.voxels() / 2);
    let mut voxels = Vec::new();
    for cluster in occupancy.clusters() {
        for i in (0..512).filter(|i| cluster.leaf[i / 64] >> (i % 64) & 1 == 1) {
            let inner = [i % 8, i / 8 % 8, i / 64];
            voxels.push(std::array::from_fn(|axis| {
                i64::from(cluster.position[axis]) * 8 + inner[axis] as i64 - half
            }));
        }
    }
    voxels.sort_unstable();
    voxels
}

#[test]
fn a_triangle_in_a_face_occupies_the_voxels_on_both_sides() {
    let mut mesh = soup(&[[[0.2, 0.2, 0.0], [0.8, 0.2, 0.0], [0.2, 0.8, 0.0]]]);
    voxel_metres(&mut mesh, 16);
    let occupancy = quiet(&mesh, &LEAF_WOOD, &settings(16, 16));
    assert_eq!(leaf_voxels(&occupancy), [[0, 0, -1], [0, 0, 0]]);
    let leaf_sites = occupancy.areas().iter().filter(|area| area.leaf > 0).count();
    assert_eq!(leaf_sites, 1, "for area, the upper site has it");
}

#[test]
fn a_triangle_inside_one_voxel_occupies_that_voxel() {
    let mut mesh = soup(&[[[0.2, 1.2, -0.5], [0.8, 1.2, -0.5], [0.2, 1.8, -0.7]]]);
    voxel_metres(&mut mesh, 16);
    assert_eq!(leaf_voxels(&quiet(&mesh, &LEAF_WOOD, &settings(16, 16))), [[0, 1, -1]]);
}

#[test]
fn a_mirrored_plant_gives_a_mirrored_grid() {
    let triangle = [[0.25, 1.2, -2.5], [3.5, -1.25, 0.5], [-2.0, 1.75, 1.5]];
    let mut mesh = soup(&[triangle]);
    voxel_metres(&mut mesh, 16);
    let mut mirrored = soup(&[triangle.map(|[x, y, z]| [-x, y, z])]);
    voxel_metres(&mut mirrored, 16);
    let voxels = leaf_voxels(&quiet(&mesh, &LEAF_WOOD, &settings(16, 16)));
    let mut back = leaf_voxels(&quiet(&mirrored, &LEAF_WOOD, &settings(16, 16)));
    back.iter_mut().for_each(|voxel| voxel[0] = -1 - voxel[0]);
    back.sort_unstable();
    assert_eq!(voxels, back);
}

/// A round leaf that fills `share` of a card.
fn round_leaf(edge: u32, share: f64) -> Image {
    let radius = (share / std::f64::consts::PI).sqrt() * f64::from(edge);
    let from_middle = move |c: u32| f64::from(c) + 0.5 - f64::from(edge) / 2.0;
    image(edge, edge, move |x, y| libm::hypot(from_middle(x), from_middle(y)) < radius)
}

#[test]
fn a_card_with_a_third_of_its_texels_is_not_counted_as_full() {
    let mesh = card(round_leaf(256, 0.33), Wrap::Repeat);
    let classes = [MaterialClass::Leaf];
    let fine = settings(256, 16);
    let cut = quiet(&mesh, &classes, &fine);
    let full = quiet(&mesh, &classes, &VoxelSettings { ignore_alpha: true, ..fine });
    let share = cut.counts()[0] as f64 / full.counts()[0] as f64;
    // The rim of the leaf occupies its voxels whole: a few per cent at 192 voxels across.
    assert!((0.33..0.36).contains(&share), "{share}");
    let area_share = cut.area_m2()[0] / full.area_m2()[0];
    assert!((area_share - 0.33).abs() < 0.002, "{area_share}");
    assert!((full.area_m2()[0] - 1.0).abs() < 1e-5);
}

#[test]
fn cut_area_equals_the_area_of_present_texels() {
    /// The midpoint rule errs where the card's diagonal crosses borders of texels inside a site.
    const BOUND: f64 = 2e-3;
    for (edge, blob) in [(60, 7), (60, 1), (500, 60), (3, 1)] {
        let checks = image(edge, edge, |x, y| (x / blob + y / blob) % 2 == 0);
        let texels = checks.rgba.chunks_exact(4).filter(|texel| texel[3] > 0).count();
        let occupancy = quiet(&card(checks, Wrap::Clamp), &[MaterialClass::Leaf], &settings(64, 16));
        let expected = texels as f64 / f64::from(edge * edge);
        let found = occupancy.area_m2()[0];
        assert!((found - expected).abs() < BOUND * expected, "{edge}, {blob}: {found} against {expected}");
    }
}

#[test]
fn sites_under_absent_texels_stay_empty() {
    let mesh = card(image(64, 64, |x, _| x >= 32), Wrap::Repeat);
    let occupancy = quiet(&mesh, &[MaterialClass::Leaf], &settings(128, 16));
    assert!(!leaf_voxels(&occupancy).is_empty());
    // u = 0.5 lies in a face, at x = 0; the hair by which a voxel is grown lets the one below it see over it.
    assert!(leaf_voxels(&occupancy).iter().all(|voxel| voxel[0] >= -1));
    assert!(occupancy.areas().iter().all(|area| area.site % 16 >= 8));
}

#[test]
fn materials_of_class_neither_count_for_nothing() {
    let small = [[0.0; 3], [1.0, 0.0, 0.0], [0.0, 1.0, 0.0]];
    let mut mesh = soup(&[small, [[50.0; 3], [90.0, 0.0, 0.0], [0.0, 99.0, 7.0]]]);
    mesh.triangle_material[1] = 1;
    let occupancy = quiet(&mesh, &[MaterialClass::Leaf, MaterialClass::Neither], &settings(64, 16));
    assert_eq!(occupancy.grid().spacing_m, 1.0 / 12.0 * (1.0 + 1.0 / 1024.0));
    assert_eq!(occupancy.counts()[1], 0);
}

#[test]
fn the_plant_is_centred_and_clear_of_the_outer_layers() {
    let mesh = soup(&[[[1.0, 2.0, 3.0], [4.0, 3.0, 3.5], [1.0, 2.5, 5.0]]]);
    let grid = *quiet(&mesh, &LEAF_WOOD, &settings(64, 16)).grid();
    let low = grid.lattice_from_model([1.0, 2.0, 3.0]);
    let high = grid.lattice_from_model([4.0, 3.0, 5.0]);
    for axis in 0..3 {
        assert!((low[axis] + high[axis] - 16.0).abs() < 1e-9);
        assert!(low[axis] > 2.0 && high[axis] < 14.0);
    }
    assert!((high[0] - low[0] - 12.0).abs() < 0.02);
}

#[test]
fn one_giant_triangle_takes_no_more_than_its_voxels() {
    let mesh = soup(&[[[-1.0, -1.0, -1.0], [1.0, -0.9, 1.0], [-1.0, 1.0, 0.9]]]);
    let occupancy = quiet(&mesh, &LEAF_WOOD, &settings(2048, 128));
    let [_, _, voxels] = occupancy.counts();
    assert!((1 << 20..1 << 23).contains(&voxels), "{voxels}");
    assert!(occupancy.clusters().len() < 200_000);
}

#[test]
fn bad_input_is_refused_with_its_reason() {
    let good = soup(&[[[0.0; 3], [1.0, 0.0, 0.0], [0.0, 1.0, 0.0]]]);
    let message = |mesh: &Mesh, classes: &[MaterialClass], settings: VoxelSettings| {
        voxelise(mesh, classes, &settings, &|_| Ok(())).expect_err("bad input").to_string()
    };
    let mut far = good.clone();
    far.positions.iter_mut().for_each(|at| at[2] += f32::INFINITY);
    let point = soup(&[[[3.0; 3]; 3]]);
    let mut no_image = good.clone();
    no_image.materials[0].alpha_mode = AlphaMode::Cut { cutoff: 0.5 };
    no_image.materials[0].color_texture = Some(identity(4, Wrap::Repeat));
    let mut short_image = card(image(8, 8, |x, _| x > 3), Wrap::Repeat);
    short_image.images[0].rgba.pop();
    let fine = settings(64, 16);
    let cases = [
        (
            message(&good, &LEAF_WOOD, settings(1024, 48)),
            "lattice 48: expected a power of two from 16 to 256",
        ),
        (message(&good, &LEAF_WOOD, settings(1024, 512)), "lattice 512"),
        (
            message(&good, &LEAF_WOOD, settings(1000, 128)),
            "voxels 1000: expected a multiple of 8 and of the lattice (128)",
        ),
        (message(&good, &LEAF_WOOD, settings(8192, 128)), "from 128 to 4096"),
        (message(&good, &LEAF_WOOD, settings(0, 128)), "voxels 0"),
        (message(&good, &LEAF_WOOD[..1], fine), "1 material classes for a mesh of 2 materials"),
        (message(&good, &[MaterialClass::Neither; 2], fine), "no triangle is leaf or wood"),
        (message(&point, &LEAF_WOOD, fine), "expected finite bounds with an extent above 0"),
        (message(&far, &LEAF_WOOD, fine), "vertex 0 lies at [0.0, 0.0, inf]"),
        (message(&no_image, &LEAF_WOOD, fine), "material \"leaf\" uses image 4 of a mesh with 0 images"),
        (message(&short_image, &LEAF_WOOD[..1], fine), "image \"leaf\": 8 x 8 texels with 255 bytes"),
    ];
    for (found, expected) in cases {
        assert!(found.contains(expected), "{found:?} should contain {expected:?}");
    }
}

#[test]
fn an_occupancy_whose_parts_lie_is_refused() {
    let mesh = soup(&[[[0.0; 3], [1.0, 0.0, 0.0], [0.0, 1.0, 0.0]]]);
    let good = quiet(&mesh, &LEAF_WOOD, &settings(64, 16));
    let refused = |change: &dyn Fn(&mut Vec<Cluster>, &mut Vec<SiteArea>)| {
        let (mut clusters, mut areas) = (good.clusters().to_vec(), good.areas().to_vec());
        change(&mut clusters, &mut areas);
        Occupancy::from_parts(*good.grid(), 64, clusters, areas).expect_err("a lie").to_string()
    };
    let cases = [
        ("is stored before", refused(&|clusters, _| clusters.swap(0, 1))),
        ("is empty", refused(&|clusters, _| (clusters[0].leaf, clusters[0].wood) = ([0; 8], [0; 8]))),
        ("expected occupied voxels 8 to 55 only", refused(&|clusters, _| clusters[0].position = [0; 3])),
        ("site 1 is stored before site 0", refused(&|_, areas| (areas[0].site, areas[1].site) = (1, 0))),
        ("none in the outer two layers", refused(&|_, areas| areas[0].site = 0)),
    ];
    for (expected, found) in cases {
        assert!(found.contains(expected), "{found:?} should contain {expected:?}");
    }
}
