//! Small pictures of a species in its own light, under three suns.

use flb_render::picture::contact_sheet;
use flb_render::{Look, Portrait, Shading};
use flb_runtime::Library;
use flb_scene::scene::Sunlight;
use flb_scene::{ClassedMesh, Unobserved};
use flb_stage::alone::{PlantLook, PlantRenderer};
use flb_stage::plant::PlantLight;
use flb_stage::{SceneShow, StageSky};

use crate::FarmError;

/// Azimuths and elevations of the suns, degrees: morning, noon, evening.
pub const SUNS_DEG: [[f64; 2]; 3] = [[100.0, 20.0], [180.0, 60.0], [250.0, 12.0]];
/// Pixels along an edge of each picture.
const EDGE_PX: u32 = 128;
const SAMPLES: u32 = 4;
/// Turbidity of the clear sky.
const TURBIDITY: f64 = 3.0;

/// A PNG file with a picture for each sun, from left to right; `None` for light that has no colours.
///
/// # Errors
/// Light that cannot be read or drawn.
pub fn thumbnails(mesh: &ClassedMesh, name: &str, file: &[u8]) -> Result<Option<Vec<u8>>, FarmError> {
    let library = Library::from_source(name, Box::new(file.to_vec()))?;
    let Ok(light) = PlantLight::shown(library, 0, &[]) else { return Ok(None) };
    let shading = Shading::of(light.meta());
    let units = shading.units();
    let sky = match shading.surfaces() {
        Some(_) => StageSky::clear(TURBIDITY).map_err(flb_stage::StageError::from)?,
        None => StageSky::EVEN,
    };
    let look = PlantLook {
        portrait: Portrait { width: EDGE_PX, height: EDGE_PX, samples: SAMPLES, ..Portrait::default() },
        look: Look::of_light([light.meta()]),
        ambient: None,
        sky,
        sunlight: Sunlight::default(),
        shows: vec![SceneShow::default()],
        is_path_traced: false,
    };
    let renderer = PlantRenderer::new(mesh, &light, look, &SUNS_DEG)?;
    let pictures = SUNS_DEG.map(|sun| renderer.picture(Some(sun), &Unobserved));
    let pictures = pictures.into_iter().collect::<Result<Vec<_>, _>>()?;
    let render = |error: flb_render::RenderError| FarmError::Stage(error.into());
    let sheet = contact_sheet(&pictures, 0).map_err(render)?;
    Ok(Some(sheet.to_png(units.default_exposure()).map_err(render)?))
}
