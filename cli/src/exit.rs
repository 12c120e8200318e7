//! Exit codes, and the error that carries one to `main`.

mod farm;
mod pictures;

use std::error::Error;
use std::fmt::Display;
use std::path::Path;

use flb_baker::BakeError;
use flb_baker::artefact::ArtefactError;
use flb_baker::crown::CrownError;
use flb_baker::plan::PlanError;
use flb_baker::scene_light::SceneLightError;
use flb_baker::voxelise::VoxelError;
use flb_eval::EvalError;
use flb_files::FileError;
use flb_fixtures::GrowError;
use flb_format::FormatError;
use flb_format::colors::BandsError;
use flb_format::error::ErrorClass;
use flb_inspector::InspectError;
use flb_packer::PackError;
use flb_render::RenderError;
use flb_runtime::source::is_replaced;
use flb_runtime::{LocationError, RuntimeError};
use flb_scene::ImportError;
use flb_scene::import::Fault;
use flb_scene::scene::scatter::ScatterError;
use flb_scene::sky::SkyError;
use flb_transport::lattice::{GpuError, SolveError};
use flb_transport::monte_carlo::MonteCarloError;
use flb_transport::ordinates::OrdinatesError;

use crate::clean::one_line;

/// Negative verdict: invalid, differs.
pub(crate) const VERDICT: u8 = 1;
/// Wrong flags, patterns or settings.
pub(crate) const USAGE: u8 = 2;
/// Finished, with loss.
pub(crate) const LOSS: u8 = 3;
/// A file cannot be read or written.
pub(crate) const INPUT_OUTPUT: u8 = 4;
/// Unsupported version, feature or extension.
pub(crate) const UNSUPPORTED: u8 = 5;
/// A limit was hit.
pub(crate) const LIMIT: u8 = 6;
/// A task was stopped before its end and should be run again: EX_TEMPFAIL of sysexits.h.
pub(crate) const AGAIN: u8 = 75;
/// A fault of ours.
pub(crate) const INTERNAL: u8 = 70;

/// Ended by SIGINT, SIGTERM or SIGHUP: 128 + SIGINT, as shells count.
pub(crate) const INTERRUPTED: u8 = 130;

/// Why a command ended early.
#[derive(Debug)]
pub(crate) struct Failure {
    /// Exit code.
    pub code: u8,
    /// One or more lines for stderr, without the leading "flb: ".
    pub message: String,
    /// Nothing is printed: the reader of our stdout has gone away.
    pub quiet: bool,
    /// A file was replaced while it was read: another try may read the new one.
    pub replaced: bool,
}

impl Failure {
    /// A failure with a message.
    pub(crate) fn new(code: u8, message: impl Display) -> Failure {
        Failure { code, message: message.to_string(), quiet: false, replaced: false }
    }

    /// A failure that remembers whether its error comes from a replaced file.
    fn of(code: u8, error: &(impl Error + 'static)) -> Failure {
        Failure { replaced: is_replaced(error), ..Failure::new(code, error) }
    }

    /// Puts the file's name before the message, unless the message already names it.
    pub(crate) fn at(mut self, path: &Path) -> Failure {
        let name = one_line(&path.display().to_string()).into_owned();
        let is_part = |c: Option<char>| c.is_some_and(|c| c.is_alphanumeric() || "._-/".contains(c));
        let is_named = self.message.match_indices(&name).any(|(at, _)| {
            let (before, after) = (&self.message[..at], &self.message[at + name.len()..]);
            !is_part(before.chars().next_back()) && !is_part(after.chars().next())
        });
        if !is_named {
            self.message = format!("{name}: {}", self.message);
        }
        self
    }
}

impl From<FormatError> for Failure {
    fn from(error: FormatError) -> Failure {
        Failure::of(format_code(&error), &error)
    }
}

/// The exit code of a broken promise.
fn format_code(error: &FormatError) -> u8 {
    match error.class() {
        ErrorClass::Invalid => VERDICT,
        ErrorClass::Unsupported => UNSUPPORTED,
        ErrorClass::Limit => LIMIT,
        ErrorClass::Io => INPUT_OUTPUT,
        ErrorClass::Request => USAGE,
    }
}

impl From<PackError> for Failure {
    fn from(error: PackError) -> Failure {
        Failure::of(pack_code(&error), &error)
    }
}

impl From<FileError> for Failure {
    fn from(error: FileError) -> Failure {
        Failure::of(file_code(&error), &error)
    }
}

fn file_code(error: &FileError) -> u8 {
    if error.is_usage() { USAGE } else { INPUT_OUTPUT }
}

fn pack_code(error: &PackError) -> u8 {
    match error {
        PackError::Format(error) => format_code(error),
        PackError::File(error) => file_code(error),
        PackError::SameName { .. } | PackError::Setting { .. } => USAGE,
        PackError::Limit { .. } => LIMIT,
        PackError::OfSpecies { source, .. } => pack_code(source),
        PackError::Cancelled(_) => INTERRUPTED,
        // The rooms before made these values; a user cannot cause them.
        _ => INTERNAL,
    }
}

impl From<PlanError> for Failure {
    fn from(error: PlanError) -> Failure {
        Failure::new(USAGE, error)
    }
}

impl From<RuntimeError> for Failure {
    fn from(error: RuntimeError) -> Failure {
        let code = match &error {
            RuntimeError::Io { .. } | RuntimeError::NotAFile { .. } => INPUT_OUTPUT,
            RuntimeError::Format { source, .. } => format_code(source),
            RuntimeError::NotStreamed { .. } => UNSUPPORTED,
            #[cfg(feature = "remote")]
            RuntimeError::Environment { .. } => USAGE,
            RuntimeError::NoSuchSpecies { .. }
            | RuntimeError::MissingBase { .. }
            | RuntimeError::LeftOut { .. }
            | RuntimeError::NoSceneLight { .. }
            | RuntimeError::SceneFactor
            | RuntimeError::UnevenSky { .. } => USAGE,
            _ => VERDICT,
        };
        Failure::of(code, &error)
    }
}

impl From<BandsError> for Failure {
    fn from(error: BandsError) -> Failure {
        match error {
            BandsError::Surfaces { .. } => Failure::new(VERDICT, error),
            BandsError::NoColors { ref found, .. } => {
                // The flag's names stand between commas.
                let named: Vec<&str> =
                    found.iter().map(String::as_str).filter(|name| !name.contains(',')).collect();
                let (some, shown) = match named.len() {
                    0 => return Failure::new(USAGE, error),
                    1 | 2 => (&named[..1], "grey"),
                    3.. => (&named[..3], "red, green and blue"),
                };
                let flag = format!("--show-bands {} shows those as {shown}", some.join(","));
                Failure::new(USAGE, format!("{error}; {flag}"))
            }
            error => Failure::new(USAGE, format!("--show-bands: {error}")),
        }
    }
}

impl From<EvalError> for Failure {
    fn from(error: EvalError) -> Failure {
        match error {
            EvalError::NoSurface => Failure::new(VERDICT, error),
            EvalError::NoSky | EvalError::NoReflectance | EvalError::TotalField => Failure::new(USAGE, error),
            EvalError::Memory { .. } => {
                let mend = "--memory-limit, or a coarser lattice of --lattices";
                Failure::new(LIMIT, format!("{error}: {mend}"))
            }
            EvalError::Bands(error) => error.into(),
            EvalError::Alpha(error) => RenderError::from(error).into(),
            EvalError::Render(error) => error.into(),
            EvalError::Runtime(error) => error.into(),
            EvalError::Pack(error) => error.into(),
            EvalError::Voxels(error) => error.into(),
            EvalError::Bake(error) => error.into(),
            error => Failure::new(INTERNAL, error),
        }
    }
}

impl From<SkyError> for Failure {
    fn from(error: SkyError) -> Failure {
        let code = match &error {
            SkyError::Read { .. } => INPUT_OUTPUT,
            SkyError::NoDirection { .. } | SkyError::Turbidity { .. } => USAGE,
            SkyError::Limit { .. } => LIMIT,
            // What the image holds.
            _ => VERDICT,
        };
        Failure::new(code, error)
    }
}

impl From<LocationError> for Failure {
    fn from(error: LocationError) -> Failure {
        let code = match &error {
            LocationError::NotBuilt { .. } => UNSUPPORTED,
            _ => USAGE,
        };
        Failure::new(code, error)
    }
}

impl From<InspectError> for Failure {
    fn from(error: InspectError) -> Failure {
        match error {
            InspectError::Format(error) => error.into(),
            error => Failure::new(INTERNAL, error),
        }
    }
}

impl From<ImportError> for Failure {
    fn from(error: ImportError) -> Failure {
        let code = match error.fault() {
            Fault::Io => INPUT_OUTPUT,
            Fault::Unsupported => UNSUPPORTED,
            Fault::Limit => LIMIT,
            Fault::Input => VERDICT,
            Fault::Usage => USAGE,
        };
        Failure::new(code, error)
    }
}

impl From<VoxelError> for Failure {
    fn from(error: VoxelError) -> Failure {
        let code = match &error {
            VoxelError::Lattice { .. } | VoxelError::Voxels { .. } => USAGE,
            VoxelError::Cancelled(_) => INTERRUPTED,
            _ => VERDICT,
        };
        Failure::new(code, error)
    }
}

impl From<BakeError> for Failure {
    fn from(error: BakeError) -> Failure {
        match error {
            BakeError::Voxels(error) => error.into(),
            BakeError::Crown(error) => error.into(),
            BakeError::Ordinates(error) => error.into(),
            BakeError::Solve(error) => error.into(),
            BakeError::MonteCarlo(error) => error.into(),
            BakeError::Plan(error) => error.into(),
            BakeError::Artefact(error) => error.into(),
            BakeError::Scene(error) => error.into(),
            BakeError::Extent { .. } => Failure::new(USAGE, format!("{error}; --unit sets metres per unit")),
            BakeError::Cancelled => Failure::new(INTERRUPTED, error),
            error => Failure::new(USAGE, error),
        }
    }
}

impl From<CrownError> for Failure {
    fn from(error: CrownError) -> Failure {
        Failure::new(USAGE, error)
    }
}

impl From<OrdinatesError> for Failure {
    fn from(error: OrdinatesError) -> Failure {
        let code = match &error {
            OrdinatesError::Gpu(error) => code_of_gpu(error),
            _ => USAGE,
        };
        Failure::new(code, error)
    }
}

/// No GPU that solves, one that is too small, or one that failed.
fn code_of_gpu(error: &GpuError) -> u8 {
    match error {
        GpuError::NotBuilt | GpuError::NoAdapter { .. } | GpuError::Refused { .. } => UNSUPPORTED,
        GpuError::TooLarge { .. } | GpuError::OutOfMemory { .. } => LIMIT,
        _ => INTERNAL,
    }
}

impl From<SceneLightError> for Failure {
    fn from(error: SceneLightError) -> Failure {
        match error {
            SceneLightError::Ground(error) => error.into(),
            SceneLightError::TooFine { .. } => Failure::new(LIMIT, error),
            SceneLightError::Fields { .. } => {
                Failure::new(USAGE, format!("{error}: bake them with one --field"))
            }
            SceneLightError::Models { .. } => {
                Failure::new(USAGE, format!("{error}: bake them with one --model"))
            }
            error => Failure::new(USAGE, error),
        }
    }
}

impl From<MonteCarloError> for Failure {
    fn from(error: MonteCarloError) -> Failure {
        let code = match &error {
            MonteCarloError::Trapped { .. } => LIMIT,
            MonteCarloError::Cancelled(_) => INTERRUPTED,
            // The solve before took the same medium and made the fields.
            _ => INTERNAL,
        };
        Failure::new(code, error)
    }
}

impl From<SolveError> for Failure {
    fn from(error: SolveError) -> Failure {
        let code = match &error {
            SolveError::Length { .. } | SolveError::Class { .. } | SolveError::Border { .. } => INTERNAL,
            SolveError::Gpu(error) => code_of_gpu(error),
            _ => USAGE,
        };
        Failure::new(code, error)
    }
}

impl From<ArtefactError> for Failure {
    fn from(error: ArtefactError) -> Failure {
        Failure::new(INTERNAL, error)
    }
}

impl From<ScatterError> for Failure {
    fn from(error: ScatterError) -> Failure {
        let code = match &error {
            ScatterError::Limit { .. } => LIMIT,
            _ => USAGE,
        };
        Failure::new(code, error)
    }
}

impl From<GrowError> for Failure {
    fn from(error: GrowError) -> Failure {
        Failure::new(USAGE, error)
    }
}
