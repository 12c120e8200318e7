//! The same bytes for any number of threads and any order of triangles.

use flb_baker::{downsample, voxelise};
use flb_fixtures::PlantKind;
use flb_render::Indirect;
use flb_tests::pipeline::{Recipe, bake, voxel_settings};
use flb_tests::portrait::{AMBIENT, Scene, portrait};

use crate::plants::{baked, with_threads};

#[test]
fn a_bake_is_the_same_for_1_2_and_3_threads() {
    for kind in PlantKind::ALL {
        // By one thread.
        let one = baked(kind);
        for threads in [2, 3] {
            let other = with_threads(threads, || bake(&Recipe::small(kind)));
            assert!(one.occupancy == other.occupancy, "{}: voxels, {threads} threads", kind.name());
            assert!(one.medium == other.medium, "{}: medium, {threads} threads", kind.name());
            assert!(one.solution == other.solution, "{}: fields, {threads} threads", kind.name());
            assert!(one.file == other.file, "{}: file, {threads} threads", kind.name());
        }
    }
}

#[test]
fn a_picture_is_the_same_for_1_2_and_3_threads() {
    let baked = baked(PlantKind::Shrub);
    let scene = Scene { sun: [120.0, 30.0], indirect: Indirect::On, ambient: AMBIENT, edge: 48, samples: 4 };
    let one = with_threads(1, || portrait(baked, &scene));
    for threads in [2, 3] {
        assert!(one == with_threads(threads, || portrait(baked, &scene)), "{threads} threads");
    }
}

#[test]
fn a_shuffled_mesh_gives_the_same_medium() {
    let recipe = Recipe::small(PlantKind::Oak);
    let baked = baked(recipe.kind);
    let mut mesh = baked.mesh.clone();
    // Fisher and Yates' shuffle by a small generator; corners of every other triangle turn too.
    let mut state = 12_345u64;
    for last in (1..mesh.triangles.len()).rev() {
        state = state.wrapping_mul(6_364_136_223_846_793_005).wrapping_add(1_442_695_040_888_963_407);
        let other = (state >> 33) as usize % (last + 1);
        mesh.triangles.swap(last, other);
        mesh.triangle_material.swap(last, other);
        mesh.triangles[last].rotate_left(last % 3);
    }
    assert_ne!(mesh.triangles, baked.mesh.triangles);
    let occupancy = voxelise(&mesh, &baked.classes(), &voxel_settings(&recipe), &|_| Ok(()))
        .expect("the mesh is the same plant");
    assert!(occupancy == baked.occupancy);
    assert!(downsample(&occupancy).expect("an occupancy of voxelise downsamples") == baked.medium);
    // Planted: one triangle less is another plant.
    mesh.triangles.pop();
    mesh.triangle_material.pop();
    let occupancy = voxelise(&mesh, &baked.classes(), &voxel_settings(&recipe), &|_| Ok(()))
        .expect("nearly the same plant");
    assert!(occupancy != baked.occupancy);
}
