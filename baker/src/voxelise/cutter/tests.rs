use proptest::prelude::*;

use super::*;
use crate::voxelise::Scene;
use crate::voxelise::overlap::{Overlap, SQUARE};
use crate::voxelise::tests::*;
use flb_scene::Mesh;
use flb_scene::mesh::testing::{identity, image, soup};
use flb_scene::mesh::{AlphaMode, Image, Texture, Wrap};

/// The comparison walks every texel: few cases, unless `PROPTEST_CASES` asks for more.
fn few_cases() -> ProptestConfig {
    match std::env::var_os("PROPTEST_CASES") {
        Some(_) => ProptestConfig::default(),
        None => ProptestConfig::with_cases(40),
    }
}

/// Voxels of which a shortcut and the clip say different things.
fn disagreements(mesh: &Mesh) -> Vec<[i64; 3]> {
    let scene = Scene::new(mesh, &LEAF_WOOD, &settings(48, 16)).expect("a good mesh");
    let (mut wrong, mut clips) = (Vec::new(), Clips::new());
    for triangle in (0..mesh.triangles.len()).filter_map(|triangle| scene.snapped(triangle)) {
        let Some(cut) = &triangle.cut else { continue };
        let overlap = Overlap::new(&triangle.vertices);
        let along = overlap.along();
        let cutter = Cutter::new(&triangle, cut, along, &mut clips);
        overlap.for_each(
            [0, 47],
            |_| false,
            |voxel, candidate| {
                if candidate.touched() {
                    let there =
                        cutter.touches(voxel, |piece, within| cut.cut.touches_by_every_texel(piece, within));
                    let column = [1, 2].map(|i| voxel[(along + i) % 3]);
                    // A square whose corner it is, and one whose last it is.
                    let squares = [[0, 0], [0, SQUARE - 1], [SQUARE - 1, 0]];
                    let absent = |[before, after]: [i64; 2]| {
                        cutter.absent_in(column.map(|at| [at - before, at + after]))
                    };
                    if cutter.present_in(voxel) != there || (there && squares.into_iter().any(absent)) {
                        wrong.push(voxel);
                    }
                }
            },
        );
    }
    wrong
}

/// Squares of `blob` texels, a quarter of them present.
fn blobs(seed: u64, blob: u64) -> Image {
    image(300, 180, |x, y| {
        let place = u64::from(x) / blob * 31 + u64::from(y) / blob;
        place.wrapping_add(seed).wrapping_mul(0x9e37_79b9_7f4a_7c15) >> 62 == 0
    })
}

proptest! {
    #![proptest_config(few_cases())]

    #[test]
    fn shortcuts_answer_as_the_clip_does(mut mesh in cut_soup(), seed: u64, blob in 1u64..60) {
        prop_assume!(has_extent(&mesh));
        // Many texels in a voxel, so that every shortcut and every leftover occurs.
        mesh.images = vec![blobs(seed, blob)];
        let wrong = disagreements(&mesh);
        prop_assert!(wrong.is_empty(), "{wrong:?}");
    }

    #[test]
    fn shortcuts_answer_as_the_clip_does_for_nasty_triangles(
        mut mesh in nasty_soup(), seed: u64, blob in 1u64..60,
    ) {
        prop_assume!(has_extent(&mesh));
        mesh.images = vec![blobs(seed, blob)];
        let wrong = disagreements(&mesh);
        prop_assert!(wrong.is_empty(), "{wrong:?}");
    }
}

/// Cut triangles that are hard on shortcuts: almost parallel to an axis or a plane, thin, with texture
/// coordinates on one line, in one point, or almost so.
fn nasty_soup() -> impl Strategy<Value = Mesh> {
    let tiny = || prop_oneof![Just(0.0f32), Just(1e-6), Just(-3e-5), Just(1e-3), -1e-4f32..1e-4];
    let like = |from: [f32; 3], along: f32, add: [f32; 3]| -> [f32; 3] {
        std::array::from_fn(|axis| from[axis] * along + add[axis])
    };
    let position =
        ([coordinate(), coordinate(), coordinate()], coordinate(), [tiny(), tiny(), tiny()], 0usize..4);
    let uvs = (prop::array::uniform3(uv()), -2.0f32..2.0, [tiny(), tiny()], 0usize..4);
    (prop::collection::vec((position, uvs, coordinate()), 1..5), [wrap(), wrap()]).prop_map(
        move |(parts, wrap)| {
            let mut triangles = Vec::new();
            let mut mesh_uvs = Vec::new();
            for ((edge, along, add, kind), ([a, b, c], share, near, uv_kind), start) in parts {
                let first = [start; 3];
                let second = like(edge, 1.0, first);
                let third = match kind {
                    // A sliver.
                    0 => like(edge, along, like(add, 1.0, first)),
                    // Almost in a plane across an axis.
                    1 => [first[0] + add[0], second[1] + along, first[2] - along],
                    // Almost along an axis.
                    2 => [second[0] + along, second[1] + add[1], second[2] + add[2]],
                    _ => [first[0] + along, first[1] - edge[2], first[2] + edge[1]],
                };
                triangles.push([first, second, third]);
                let on_line: [f32; 2] = std::array::from_fn(|i| a[i] + share * (b[i] - a[i]) + near[i]);
                mesh_uvs.extend(match uv_kind {
                    0 => [a, b, on_line],
                    1 => [a, a, a.map(|c| c + near[0])],
                    2 => [a, [b[0], a[1] + near[0]], [c[0], a[1] + near[1]]],
                    _ => [a, b, c],
                });
            }
            let mut mesh = soup(&triangles);
            mesh.uvs = mesh_uvs;
            mesh.images = vec![image(2, 2, |x, _| x == 0)];
            mesh.materials[0].color_texture = Some(Texture { wrap, ..identity(0, Wrap::Repeat) });
            mesh.materials[0].alpha_mode = AlphaMode::Cut { cutoff: 0.5 };
            mesh
        },
    )
}

#[test]
fn texture_coordinates_on_one_line_do_not_lead_samples_out_of_the_voxel() {
    // Texels grow along u and fall along v by the same steps: the ways towards more of either cancel.
    let mut mesh =
        soup(&[[[-1.0, 0.5975594, -0.125], [-0.875, -0.34877118, 0.125], [0.625, -0.5890261, -0.5]]]);
    mesh.uvs = vec![[37.5, -40.25], [-0.75, 0.25], [37.5, -40.25]];
    mesh.images = vec![blobs(18_057_677_138_100_898_427, 29)];
    let texture = Texture { wrap: [Wrap::Clamp, Wrap::Repeat], ..identity(0, Wrap::Repeat) };
    mesh.materials[0].color_texture = Some(texture);
    mesh.materials[0].alpha_mode = AlphaMode::Cut { cutoff: 0.5 };
    for corner in [[-1.0, 1.0, -1.0], [0.72812617, -0.6701459, 0.93925947]] {
        mesh.positions.push(corner);
        mesh.normals.push([0.0, 1.0, 0.0]);
        mesh.uvs.push([0.0; 2]);
    }
    mesh.triangles.push([3, 3, 4]);
    mesh.triangle_material.push(1);
    assert_eq!(disagreements(&mesh), [[0i64; 3]; 0]);
}
