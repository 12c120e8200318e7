//! Baked light against irradiance that is path traced on the mesh, as `flb judge` does it.

use flb_baker::bake::BakeSettings;
use flb_eval::figures::{MeshJudgement, compare};
use flb_format::Field;
use flb_render::Surfaces;
use flb_render::irradiance::irradiance;
use flb_runtime::{Daylight, InstanceLight, Library, SpeciesLight};
use flb_scene::Plant;
use flb_scene::surface_points::surface_points;
use flb_transport::monte_carlo::judge::suns;

use crate::default_bake::DefaultBake;

/// How finely light is judged.
#[derive(Debug, Clone, Copy)]
pub struct Fineness {
    /// Suns, besides the sky.
    pub suns: usize,
    /// Points on leaves and wood.
    pub points: u32,
    /// Paths from each side of each.
    pub samples: u32,
}

/// A plant's light, judged.
pub struct Judged {
    /// Against the truth.
    pub mesh: MeshJudgement,
    /// Of the file.
    pub bytes: usize,
    /// Light of the sky and of suns, before coding.
    pub fields: Vec<(u8, Field)>,
    /// The file, opened.
    pub library: Library,
    /// What its leaves and wood do with light.
    pub surfaces: Surfaces,
}

/// Bakes a plant, codes it as `flb bake` does, and judges what a reader finds.
///
/// # Panics
/// If a stage fails: plants and settings are known to be good.
pub fn judged(plant: Plant, settings: &BakeSettings, fineness: Fineness) -> Judged {
    let baked = DefaultBake::with(plant, settings);
    let (classed, library, surfaces) = (&baked.mesh, baked.library(), baked.surfaces());
    let points = surface_points(classed, fineness.points, settings.ignore_alpha).expect("good textures");
    let suns = suns(fineness.suns);
    let light = SpeciesLight::load(&library, 0).expect("a valid file");
    let of_suns = suns.iter().map(|&towards_sun| Daylight { towards_sun, sun: 1.0, sky: 0.0 });
    let of_sky = Daylight { towards_sun: [0.0, 1.0, 0.0], sun: 0.0, sky: 1.0 };
    let near = light.near();
    let lit: Vec<InstanceLight> = of_suns
        .chain([of_sky])
        .map(|daylight| light.lit_by_in_model(&daylight).expect("a direction").prepared_by(near.as_ref()))
        .collect();
    let on_mesh = (&classed.mesh, &classed.classes[..]);
    let truth =
        irradiance(on_mesh, surfaces, &points, &suns, fineness.samples, &|_| Ok(())).expect("a good mesh");
    let found = |source: usize, point: [f32; 3], phi: &mut [f32; 3]| lit[source].at(point, phi);
    let mesh = compare(&points, &truth, &surfaces, &found);
    drop(lit);
    drop(near);
    drop(light);
    Judged { mesh, bytes: baked.file.len(), fields: baked.baked.fields.bases, library, surfaces }
}
