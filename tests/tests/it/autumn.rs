//! A plant whose texture says what its leaves reflect: an oak in autumn, from the mesh to the picture.
//!
//! `FLB_WRITE_GOLDEN=1 cargo test -p flb-tests --test it autumn` writes the golden picture anew.

use std::sync::LazyLock;

use flb_fixtures::{PlantKind, autumn, grow};
use flb_format::material_surface::Texel;
use flb_format::sun::towards_sun;
use flb_scene::color::{law, mean_colors};
use flb_scene::rays::{RayMesh, uv};
use flb_scene::surface_points::surface_points;
use flb_scene::texture::{SrgbTable, color};
use flb_scene::{ClassedMesh, MaterialClass, PlantReader};
use flb_tests::default_bake::DefaultBake;
use flb_tests::pipeline::{SEED, import_glb};
use flb_tests::portrait::light_of;
use glam::Vec3;

use crate::beside_paths::{check_golden, relit_and_traced};

static OAK: LazyLock<DefaultBake> = LazyLock::new(|| {
    let glb = autumn(grow(PlantKind::Oak, SEED, 6_000).expect("a good count")).to_glb();
    let reader = PlantReader::default();
    let (classed, _) = reader.class(import_glb("oak", &glb)).expect("the fixtures' names are known");
    DefaultBake::of_plant(reader.plant("red oak".to_owned(), classed))
});

/// Reflectance and transmittance of each leaf point, as every renderer has them.
fn leaf_shares(bake: &DefaultBake) -> Vec<[Vec3; 2]> {
    let ClassedMesh { mesh, classes } = &bake.mesh;
    let all = bake.surfaces();
    let leaf = [all.leaf_reflectance, all.leaf_transmittance].map(Vec3::from);
    let means = mean_colors(mesh, &RayMesh::new(mesh, false).expect("a good mesh").coverage);
    let table = SrgbTable::new();
    let points = surface_points(&bake.mesh, 20_000, false).expect("good textures");
    let shares = points.iter().filter_map(|point| {
        let material = mesh.triangle_material[point.triangle as usize] as usize;
        let at = uv(mesh, point.triangle as usize, point.weights);
        let law = law(&mesh.materials[material], classes[material], leaf, means[material]);
        let shares = law.at(color(&mesh.materials[material], &mesh.images, &table, at).to_array());
        let shares = [shares.reflectance, shares.transmittance].map(Vec3::from);
        (classes[material] == MaterialClass::Leaf).then_some(shares)
    });
    shares.collect()
}

/// Two ways to spread thousands of points over the same leaves.
const SAMPLING: f32 = 0.02;

#[test]
fn the_bake_uses_the_mean_of_what_the_renderer_shows() {
    let all = OAK.surfaces();
    let shares = leaf_shares(&OAK);
    let mean = |of: usize| shares.iter().map(|shares| shares[of]).sum::<Vec3>() / shares.len() as f32;
    for (of, used) in [all.leaf_reflectance, all.leaf_transmittance].into_iter().enumerate() {
        let shown = mean(of).to_array();
        for band in 0..3 {
            let apart = (shown[band] / used[band] - 1.0).abs();
            assert!(apart < SAMPLING, "band {band}: shown {shown:?}, used {used:?}");
        }
    }
}

#[test]
fn red_leaves_are_red_and_none_sends_out_more_than_it_gets() {
    let bake = &*OAK;
    let surface = bake.mesh.mesh.materials.iter().find_map(|material| material.surface.as_ref());
    assert_eq!(surface.expect("the leaves' own").texel, Texel::Albedo);
    let stored = bake.library().container().species()[0].meta.material_surfaces();
    let stored = stored.expect("what the bake wrote").expect("the leaves' own");
    assert_eq!(stored.iter().flatten().next(), surface);
    let shares = leaf_shares(bake);
    assert!(shares.iter().all(|[r, t]| (*r + *t).max_element() <= 1.0 + 1e-5));
    let [red, green, blue] = bake.surfaces().leaf_reflectance;
    assert!(red > 5.0 * green && green > blue, "{:?}", bake.surfaces().leaf_reflectance);
}

#[test]
fn green_leaves_are_those_that_were_measured_and_the_file_says_nothing() {
    let plant = flb_tests::default_bake::grown(PlantKind::Oak, 6_000);
    assert_eq!(plant.surfaces, flb_scene::leaf::knapp_carter());
    assert!(plant.classed.mesh.materials.iter().all(|material| material.surface.is_none()));
}

/// Means of the relit over the traced picture: lattice 32 is coarse.
const MAX_OFF: f64 = 0.15;

#[test]
fn a_relit_red_oak_is_golden_and_as_red_as_the_traced_one() {
    let pictures = relit_and_traced(&OAK, towards_sun(135.0, 40.0));
    let [ours, truth] = pictures.each_ref().map(light_of);
    for band in 0..3 {
        assert!((ours[band] / truth[band] - 1.0).abs() < MAX_OFF, "relit {ours:?}, traced {truth:?}");
    }
    // The hue of the texture: red far above green, green above blue.
    assert!(ours[0] > 2.0 * ours[1] && ours[1] > ours[2], "{ours:?}");
    check_golden("red-oak", &pictures);
}
