//! Exit codes of pictures: of renderers, of the stage, of the window, of GPUs that draw.

#[cfg(any(feature = "gpu", feature = "view"))]
use flb_gpu::DeviceError;
use flb_render::RenderError;
#[cfg(feature = "gpu")]
use flb_render_gpu::ForestError;
#[cfg(feature = "gpu")]
use flb_runtime::gpu::GpuError as LightError;
use flb_stage::StageError;
#[cfg(feature = "view")]
use flb_view::ViewError;

use super::{Failure, INTERNAL, INTERRUPTED, LIMIT, UNSUPPORTED, USAGE, VERDICT};

impl From<RenderError> for Failure {
    fn from(error: RenderError) -> Failure {
        if let RenderError::Setting { name: name @ ("sky" | "indirect_scale"), found, expected } = &error {
            let flag = if *name == "sky" { "--ambient" } else { "--indirect-scale" };
            return Failure::new(USAGE, format!("{flag} is {found}, expected {expected}"));
        }
        let code = match &error {
            RenderError::Setting { .. } => USAGE,
            RenderError::Sheet(_) => LIMIT,
            RenderError::Cancelled(_) => INTERRUPTED,
            RenderError::Alpha(_)
            | RenderError::NoTriangles
            | RenderError::Triangle { .. }
            | RenderError::NotFinite { .. } => VERDICT,
            RenderError::NoInstances
            | RenderError::Instance { .. }
            | RenderError::Shadings { .. }
            | RenderError::Underwater { .. } => USAGE,
            _ => INTERNAL,
        };
        Failure::new(code, error)
    }
}

#[cfg(feature = "gpu")]
impl From<ForestError> for Failure {
    fn from(error: ForestError) -> Failure {
        let code = match error {
            ForestError::Render(error) => return error.into(),
            ForestError::Runtime(error) => return error.into(),
            ForestError::Device(ref error) => code_of_device(error),
            ForestError::Unlit { .. } => UNSUPPORTED,
            ForestError::Light(
                LightError::Full { .. } | LightError::NoRoom { .. } | LightError::Budget { .. },
            )
            | ForestError::TooLarge { .. }
            | ForestError::TooMany { .. } => LIMIT,
            ForestError::Light(LightError::Bands { .. }) => UNSUPPORTED,
            ForestError::NoBase { .. } => USAGE,
            _ => INTERNAL,
        };
        Failure::new(code, error)
    }
}

impl From<StageError> for Failure {
    fn from(error: StageError) -> Failure {
        let usage = |message: &str| Failure::new(USAGE, message);
        match error {
            StageError::Render(error) => error.into(),
            StageError::Runtime(error) => error.into(),
            StageError::Import(error) => error.into(),
            StageError::Sky(error) => error.into(),
            #[cfg(feature = "gpu")]
            StageError::Forest(error) => error.into(),
            #[cfg(feature = "gpu")]
            StageError::Device(ref device) => Failure::new(code_of_device(device), error),
            StageError::At { path, source } => Failure::from(*source).at(&path),
            StageError::Format(error) => Failure::from(*error),
            StageError::MaterialCount { .. } => {
                usage(&format!("{error}; {MESH_DIFFERS} shows it all the same"))
            }
            StageError::OtherMesh(message) => {
                usage(&format!("{message}; bake this mesh, or show it all the same with {MESH_DIFFERS}"))
            }
            StageError::Metadata { .. } => Failure::new(VERDICT, error),
            StageError::NoSkyLight { library } => usage(NO_SKY_LIGHT).at(&library),
            StageError::WholeSunPath => usage(
                "the scene's sun has a path: take --frames N of it, or name one with --sun AZIMUTH,ELEVATION",
            ),
            StageError::NoSun => usage(
                "the scene has no suns of its own: name one with --sun AZIMUTH,ELEVATION, or --sun-path",
            ),
            StageError::ManySpecies { count, found } => {
                usage(&format!("holds {count} species; choose one with --species: {found}"))
            }
            StageError::Bands(error) => error.into(),
            StageError::GpuCount { found, expected } => {
                let message = format!("--gpus {expected}: found {}: {}", found.len(), found.join(", "));
                Failure::new(UNSUPPORTED, message)
            }
            StageError::NoGpuBuilt | StageError::Unlit | StageError::Libraries(_) => {
                Failure::new(UNSUPPORTED, error)
            }
            StageError::LayerPixels { .. } => Failure::new(LIMIT, error),
            StageError::Scene(_)
            | StageError::NoMesh { .. }
            | StageError::NoSpecies { .. }
            | StageError::NoTriangles
            | StageError::OtherScene { .. }
            | StageError::OtherPlant { .. }
            | StageError::Shows(_)
            | StageError::NoBase { .. }
            | StageError::HighlightOfPhysical
            | StageError::NoSceneLight
            | StageError::Models { .. }
            | StageError::OnCpuAlone => Failure::new(USAGE, error),
            StageError::UnevenSkyOverPaper => {
                let mend =
                    "--backdrop FILE, or `backdrop` of a scene's sky, draws an image and lights nothing";
                Failure::new(USAGE, format!("{error}; {mend}"))
            }
            _ => Failure::new(INTERNAL, error),
        }
    }
}

/// The flag that lets any mesh pass.
const MESH_DIFFERS: &str = "--mesh-differs";

/// A sky over a file that was made without its light.
const NO_SKY_LIGHT: &str = "the file has no light of the sky (base 0 was left out); --ambient 0 goes without";

#[cfg(feature = "view")]
impl From<ViewError> for Failure {
    fn from(error: ViewError) -> Failure {
        let code = match error {
            ViewError::Stage(error) => return error.into(),
            ViewError::Device(ref error) => code_of_device(error),
            ViewError::Size { .. } => LIMIT,
            _ => UNSUPPORTED,
        };
        Failure::new(code, error)
    }
}

#[cfg(any(feature = "gpu", feature = "view"))]
fn code_of_device(error: &DeviceError) -> u8 {
    match error {
        DeviceError::NoAdapter { .. } | DeviceError::Refused { .. } => UNSUPPORTED,
        DeviceError::OutOfMemory { .. } => LIMIT,
        DeviceError::Failed { .. } => INTERNAL,
    }
}
