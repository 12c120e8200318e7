//! Settings of a bake as people say them: each may be left out, and then a preset says it. Flags of `flb bake` and keys
//! of a manifest are one list.

mod coding;
mod solve;
#[cfg(test)]
mod tests;
mod words;

use flb_baker::crown::LeafAngleChoice;
use flb_format::light::FieldKind;
use flb_format::{Codec, Purpose, Quality};
use flb_transport::ordinates::NamedSuns;
use serde::{Deserialize, Serialize};

pub use solve::{Machine, ModelName, check_end, check_lattice, ordinates_of};

/// Solver of the model `paper` on the CPU, by its name.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum SolverName {
    /// Gauss-Seidel sweeps over non-empty sites.
    Sweep,
    /// The papers' iteration over the whole lattice, f32.
    Explicit,
    /// The papers' iteration over the whole lattice, f64.
    Literal,
}

/// Settings of a bake; `None` leaves a setting to the preset.
///
/// As TOML, keys are the names of the fields, and words are those of the command line.
#[derive(Debug, Clone, PartialEq, Default, Deserialize, Serialize)]
#[serde(deny_unknown_fields, default)]
pub struct Recipe {
    /// The preset. Default: [`Quality::Standard`].
    #[serde(with = "words::quality", skip_serializing_if = "Option::is_none")]
    pub quality: Option<Quality>,
    /// The use that the bake is for, in place of a preset.
    #[serde(rename = "for", with = "words::purpose", skip_serializing_if = "Option::is_none")]
    pub purpose: Option<Purpose>,
    /// Light transport model. Default: that of the preset.
    #[serde(with = "words::model", skip_serializing_if = "Option::is_none")]
    pub model: Option<ModelName>,
    /// Sites along each edge: a power of two, 16 to 256.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub lattice: Option<u32>,
    /// Voxels along each edge of the fine grid: a multiple of the lattice, up to 4096.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub voxels: Option<u32>,
    /// Whether leaf cards count whole, whatever the alpha of their textures is.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub ignore_alpha: Option<bool>,
    /// Estimated relative L2 error at which a solve has converged.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub tolerance: Option<f64>,
    /// A fixed number of iterations of the papers, in place of a tolerance; `paper` only.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub steps: Option<u32>,
    /// Sweeps after which a solve gives up. Default: 300.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub max_sweeps: Option<u32>,
    /// Solver on the CPU; `paper` only.
    #[serde(with = "words::solver", skip_serializing_if = "Option::is_none")]
    pub solver: Option<SolverName>,
    /// Dependence of the stored light on the sun; `physical` only.
    #[serde(with = "words::suns", skip_serializing_if = "Option::is_none")]
    pub suns: Option<NamedSuns>,
    /// Directions that light is marched along: 18, 50 or 110; `physical` only.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub ordinates: Option<u32>,
    /// Rays per site edge along each of them, 1 to 8; `physical` only.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub rays: Option<u32>,
    /// Whether light is marched through sites cut into 2x2x2 parts; `physical` only.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub cut_sites: Option<bool>,
    /// Content of a field of the sun's light; `physical` only.
    #[serde(with = "words::field", skip_serializing_if = "Option::is_none")]
    pub field: Option<FieldKind>,
    /// Assumed distribution of leaf inclinations; `physical` only.
    #[serde(with = "words::leaf_angles", skip_serializing_if = "Option::is_none")]
    pub leaf_angles: Option<LeafAngleChoice>,
    /// Suns, 0 to 22, that Monte Carlo traces in the same medium to judge the light by; `physical` only.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub monte_carlo: Option<u8>,
    /// Codec of the light. Default: `classed`; `haar-paper` with a threshold or the papers' preset.
    #[serde(with = "words::codec", skip_serializing_if = "Option::is_none")]
    pub codec: Option<Codec>,
    /// Peak signal to noise that `classed` and `haar` code to, in dB.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub target_psnr: Option<f64>,
    /// Relative error of the darkest tenth of samples that `classed` and `haar` code to.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub target_error: Option<f64>,
    /// Whether `classed` and `haar` store blocks away from geometry, too.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub all_blocks: Option<bool>,
    /// Whether `haar-paper` stores blocks near geometry alone.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub near_geometry: Option<bool>,
    /// Threshold of `haar-paper`, in units of the light that enters.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub threshold: Option<f32>,
    /// Whether pages are compressed by zstd where that makes them smaller.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub compress: Option<bool>,
}

/// Settings that cannot be. Names of settings stand in backticks, with the value behind a blank where one is meant:
/// "`suns` is for `model physical`".
#[derive(Debug, Clone, PartialEq, Eq)]
pub struct RecipeError {
    text: String,
}

impl RecipeError {
    fn new(text: impl Into<String>) -> RecipeError {
        RecipeError { text: text.into() }
    }

    /// The sentence, with each setting as `spell` writes it, which is given its name and the value that is meant, if
    /// one is.
    pub fn spelled(&self, spell: impl Fn(&str, Option<&str>) -> String) -> String {
        let words = self.text.split('`').enumerate().map(|(at, part)| match (at % 2, part.split_once(' ')) {
            (0, _) => part.to_owned(),
            (_, Some((key, value))) => spell(key, Some(value)),
            (_, None) => spell(part, None),
        });
        words.collect()
    }
}

/// As in a manifest: `suns`, `model = "physical"`.
impl std::fmt::Display for RecipeError {
    fn fmt(&self, f: &mut std::fmt::Formatter<'_>) -> std::fmt::Result {
        f.write_str(&self.spelled(|key, value| match value {
            Some(value) => format!("{key} = {value:?}"),
            None => key.to_owned(),
        }))
    }
}

impl std::error::Error for RecipeError {}

impl Recipe {
    /// The preset, that of the purpose, or the default one.
    pub fn quality(&self) -> Quality {
        self.quality.or(self.purpose.map(Purpose::quality)).unwrap_or_default()
    }

    /// Refuses two words for one choice.
    fn check_preset(&self) -> Result<(), RecipeError> {
        match (self.quality, self.purpose) {
            (Some(quality), Some(purpose)) => Err(RecipeError::new(format!(
                "`quality {quality}` with `for {purpose}`: expected one of them"
            ))),
            _ => Ok(()),
        }
    }

    /// Returns the settings, and those of `base` where they leave one out.
    pub fn over(&self, base: &Recipe) -> Recipe {
        let (quality, purpose) = match (self.quality, self.purpose) {
            (None, None) => (base.quality, base.purpose),
            own => own,
        };
        let Recipe { model, lattice, voxels, ignore_alpha, tolerance, steps, max_sweeps, .. } = *self;
        let Recipe { solver, suns, ordinates, rays, cut_sites, field, leaf_angles, monte_carlo, .. } = *self;
        let Recipe {
            codec, target_psnr, target_error, all_blocks, near_geometry, threshold, compress, ..
        } = *self;
        Recipe {
            quality,
            purpose,
            model: model.or(base.model),
            lattice: lattice.or(base.lattice),
            voxels: voxels.or(base.voxels),
            ignore_alpha: ignore_alpha.or(base.ignore_alpha),
            tolerance: tolerance.or(base.tolerance),
            steps: steps.or(base.steps),
            max_sweeps: max_sweeps.or(base.max_sweeps),
            solver: solver.or(base.solver),
            suns: suns.or(base.suns),
            ordinates: ordinates.or(base.ordinates),
            rays: rays.or(base.rays),
            cut_sites: cut_sites.or(base.cut_sites),
            field: field.or(base.field),
            leaf_angles: leaf_angles.or(base.leaf_angles),
            monte_carlo: monte_carlo.or(base.monte_carlo),
            codec: codec.or(base.codec),
            target_psnr: target_psnr.or(base.target_psnr),
            target_error: target_error.or(base.target_error),
            all_blocks: all_blocks.or(base.all_blocks),
            near_geometry: near_geometry.or(base.near_geometry),
            threshold: threshold.or(base.threshold),
            compress: compress.or(base.compress),
        }
    }
}
