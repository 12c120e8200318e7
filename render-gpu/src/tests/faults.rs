//! What does not fit, is not there or breaks: errors with both numbers, and nothing else.

use flb_fixtures::PlantKind;
use flb_gpu::{DeviceError, Gpu};
use flb_render::forest::{Forest, Search};
use flb_render::{Lighting, Look, RenderError, Shading, Species};
use flb_scene::mesh::Material;
use flb_testkit::scenes::{CLASSES, plane, plant, stand, view};

use super::gpu;
use super::traced::{dark, meshes, settings, two};
use crate::strips::StripPlan;
use crate::{ForestError, ForestSettings, GpuForest, LightSet, LightSource};

#[track_caller]
fn assert_says(error: &ForestError, parts: &[&str]) {
    for part in parts {
        assert!(error.to_string().contains(part), "{:?} should contain {part:?}", error.to_string());
    }
}

#[test]
fn a_lost_gpu_is_an_error() {
    let meshes = meshes();
    let forest = two(&meshes, Shading::Paper, &stand(3, 8.0, [0.0; 3]), Some(plane()));
    let gpu = gpu();
    let mut lights = dark(&gpu, 2);
    let mut on_gpu = GpuForest::new(&gpu, &forest, &lights, settings()).unwrap();
    let view = view([32, 32], 1, 20.0);
    on_gpu.trace(&view).unwrap();
    gpu.device.destroy();
    let is_lost = |error: ForestError| {
        assert!(matches!(error, ForestError::Device(DeviceError::Failed { .. })), "{error:?}");
    };
    // A GPU is asked without waiting; who waits hears of the loss first.
    is_lost(on_gpu.wait().unwrap_err());
    is_lost(on_gpu.relight(&mut lights, &Lighting::default(), &Look::default()).unwrap_err());
    is_lost(on_gpu.trace(&view).unwrap_err());
    is_lost(on_gpu.fragments().unwrap_err());
}

#[test]
fn a_forest_that_does_not_fit_the_buffers_is_refused_with_both_numbers() {
    let meshes = meshes();
    let forest = two(&meshes, Shading::Paper, &stand(3, 8.0, [0.0; 3]), None);
    let gpu = Gpu::open_alike(wgpu::Features::empty(), 512 << 10, 1).unwrap().remove(0);
    // Light's own buffers are larger, so they are made elsewhere: refused before they are bound.
    let lights = dark(&super::gpu(), 2);
    let error = GpuForest::new(&gpu, &forest, &lights, settings()).err().unwrap();
    assert!(
        matches!(error, ForestError::TooLarge { limit: 524_288, needed, .. } if needed > 524_288),
        "{error:?}"
    );
    assert_says(&error, &["on the GPU", "524288", "render on the CPU"]);
}

#[test]
fn more_species_or_materials_than_the_shaders_have_room_for_are_refused() {
    let gpu = gpu();
    let mut mesh = plant(PlantKind::Shrub, 300);
    let none = Material { color_texture: None, ..mesh.materials[0].clone() };
    mesh.materials.resize(600, none);
    let classes = vec![flb_scene::MaterialClass::Leaf; 600];
    let species = [Species { mesh: &mesh, classes: &classes, shading: Shading::Paper }];
    let mut instances = stand(1, 1.0, [0.0; 3]);
    let forest = Forest::prepare(&species, &instances, None, Search::default()).unwrap();
    let error = GpuForest::new(&gpu, &forest, &dark(&gpu, 1), settings()).err().unwrap();
    assert_says(&error, &["600 materials", "at most 512"]);

    let mut small = plant(PlantKind::Shrub, 300);
    small.materials.iter_mut().for_each(|material| material.color_texture = None);
    small.images.clear();
    small.materials.iter_mut().for_each(|m| m.alpha_mode = flb_scene::mesh::AlphaMode::Opaque);
    small.triangles.truncate(4);
    small.triangle_material.truncate(4);
    let many: Vec<Species> =
        (0..257).map(|_| Species { mesh: &small, classes: &CLASSES, shading: Shading::Paper }).collect();
    instances[0].species = 256;
    let forest = Forest::prepare(&many, &instances, None, Search::default()).unwrap();
    let error = GpuForest::new(&gpu, &forest, &dark(&gpu, 1), settings()).err().unwrap();
    assert_says(&error, &["at most"]);
    assert!(matches!(error, ForestError::TooMany { .. }), "{error:?}");
}

#[test]
fn trees_deeper_than_a_ray_can_keep_in_mind_are_refused() {
    let meshes = meshes();
    let forest = two(&meshes, Shading::Paper, &stand(3, 8.0, [0.0; 3]), None);
    let error = crate::stand::Stand::new(&gpu(), &forest, 95).err().unwrap();
    assert_says(&error, &["boxes within each other", "at most 96"]);
}

#[test]
fn light_for_which_there_is_no_room_is_refused() {
    let error = LightSet::load(&gpu(), &[LightSource::Even([0.0; 3])], 1).map(|_| ());
    assert!(error.is_ok());
    let suns = flb_testkit::scenes::library(&[("oak", None)], flb_format::Codec::Classed);
    let sources = [LightSource::Library { library: &suns, species: 0 }];
    let error = LightSet::load(&gpu(), &sources, 1 << 26).err().unwrap();
    assert!(matches!(error, ForestError::Light(_)), "{error:?}");
    assert_says(&error, &["budget"]);
}

#[test]
fn pictures_that_do_not_fit_are_refused_with_both_numbers() {
    const BUFFER: u64 = 128 << 20;
    let whole = StripPlan::new([1920, 1080, 4], BUFFER, 1 << 30);
    assert!(whole.is_ok(), "{whole:?}");
    let budget = StripPlan::new([1920, 1080, 4], BUFFER, 100 << 20).unwrap_err();
    assert_says(&budget, &["fragments", "104857600", "fewer pixels or samples"]);
    let row = StripPlan::new([16_384, 8, 64], BUFFER, 1 << 34).unwrap_err();
    assert_says(&row, &["eight rows", "402653184", "134217728"]);
    let pixels = StripPlan::new([8192, 8192, 1], BUFFER, 1 << 34).unwrap_err();
    assert_says(&pixels, &["pixels", "1073741824", "134217728"]);
}

#[test]
fn what_is_no_view_no_daylight_or_not_traced_is_refused() {
    let meshes = meshes();
    let forest = two(&meshes, Shading::Paper, &stand(3, 8.0, [0.0; 3]), None);
    let gpu = gpu();
    let mut lights = dark(&gpu, 2);
    let small = ForestSettings { fragment_bytes: 1000, ..settings() };
    let mut on_gpu = GpuForest::new(&gpu, &forest, &lights, small).unwrap();
    let error = on_gpu.relight(&mut lights, &Lighting::default(), &Look::default()).unwrap_err();
    assert!(matches!(error, ForestError::NotTraced), "{error:?}");
    let error = on_gpu.trace(&view([0, 8], 1, 10.0)).unwrap_err();
    assert!(matches!(error, ForestError::Render(RenderError::Setting { name: "width", .. })), "{error:?}");
    assert_says(&on_gpu.trace(&view([64, 64], 1, 10.0)).unwrap_err(), &["expected at most 1000"]);
    let mut on_gpu = GpuForest::new(&gpu, &forest, &lights, settings()).unwrap();
    on_gpu.trace(&view([8, 8], 1, 10.0)).unwrap();
    let error = on_gpu.relight(&mut lights, &Lighting::towards([0.0; 3]), &Look::default()).unwrap_err();
    assert_says(&error, &["sun"]);
    let mut few = dark(&gpu, 1);
    let error = on_gpu.relight(&mut few, &Lighting::default(), &Look::default()).unwrap_err();
    assert_says(&error, &["light for 1 species, expected 2"]);
    let mut endless =
        LightSet::load(&gpu, &[LightSource::Even([f32::INFINITY; 3]), LightSource::Even([0.0; 3])], 1)
            .unwrap();
    on_gpu.trace(&view([48, 48], 1, 12.0)).unwrap();
    on_gpu.relight(&mut endless, &Lighting::default(), &Look::default()).unwrap();
    let error = on_gpu.picture().unwrap_err();
    assert!(matches!(error, ForestError::Render(RenderError::NotFinite { .. })), "{error:?}");
}
