//! Flags that say how closely a file keeps the fields.

use clap::Args;
use flb_format::{Codec, Quality};
use flb_packer::rate::Target;
use flb_packer::{EncodeSettings, StoredBlocks};

use crate::exit::{Failure, USAGE};

#[derive(Args, Clone)]
pub(crate) struct CodingArgs {
    /// Codec of the light [default: classed; haar-paper where --threshold or --quality papers is given]
    #[arg(long, value_enum)]
    pub codec: Option<Codec>,
    /// Code to this peak signal to noise of samples at surfaces, of each base to its own peak; of classed and haar
    /// [default: the preset's, and its relative error]
    #[arg(long, value_name = "DB")]
    pub target_psnr: Option<f64>,
    /// Code to this relative error of the darkest tenth of samples at surfaces, of which 99 in 100 are better; of
    /// classed and haar; both errors are met where both are given
    #[arg(long, value_name = "REL")]
    pub target_error: Option<f64>,
    /// Store blocks away from geometry too; of classed and haar (haar-paper does unless told otherwise)
    #[arg(long)]
    pub all_blocks: bool,
    /// Store no block away from geometry, as the papers say; of haar-paper (classed and haar never do unless told
    /// otherwise)
    #[arg(long, conflicts_with = "all_blocks")]
    pub near_geometry: bool,
    /// Drop block coefficients up to T, in units of the light that enters (0 keeps all); of haar-paper [default: the
    /// preset's]
    #[arg(long, value_name = "T", conflicts_with_all = ["target_psnr", "target_error"])]
    pub threshold: Option<f32>,
    /// Compress every page with zstd where that makes it smaller [default: true for classed and haar]
    #[arg(long, value_name = "BOOL", num_args = 0..=1, require_equals = true, default_missing_value = "true")]
    pub compress: Option<bool>,
}

impl CodingArgs {
    /// Whether any flag asks for another coding.
    pub(crate) fn is_asked(&self) -> bool {
        self.codec.is_some()
            || self.target_psnr.is_some()
            || self.target_error.is_some()
            || self.all_blocks
            || self.near_geometry
            || self.threshold.is_some()
            || self.compress.is_some()
    }

    /// Whether a flag asks for an error: then missing it is a loss. That of a preset is a wish, and missing it worth a
    /// warning.
    pub(crate) fn asks_for_error(&self) -> bool {
        self.target_psnr.is_some() || self.target_error.is_some()
    }

    /// The codec that the flags ask for.
    pub(crate) fn codec(&self, quality: Quality) -> Codec {
        let is_papers = self.threshold.is_some() || quality == Quality::Papers;
        let usual = if is_papers { Codec::HaarPaper } else { Codec::Classed };
        self.codec.unwrap_or(usual)
    }

    /// What the flags ask for, and the preset where they do not.
    pub(crate) fn settings(&self, quality: Quality) -> Result<EncodeSettings, Failure> {
        let codec = self.codec(quality);
        let preset = EncodeSettings::of(quality, codec);
        let refuse = |message: String| Err(Failure::new(USAGE, message));
        if codec != Codec::HaarPaper && self.threshold.is_some() {
            return refuse(format!("--threshold is for --codec haar-paper, not for {}", codec.name()));
        }
        let near = [
            ("--target-psnr", self.target_psnr.is_some()),
            ("--target-error", self.target_error.is_some()),
            ("--all-blocks", self.all_blocks),
        ];
        if let Some((flag, _)) = near.iter().find(|(_, given)| *given && !codec.is_near_geometry()) {
            return refuse(format!("{flag} is for --codec classed and haar, not for {}", codec.name()));
        }
        if self.near_geometry && codec != Codec::HaarPaper {
            return refuse(format!("--near-geometry is for --codec haar-paper, not for {}", codec.name()));
        }
        let threshold = self.threshold.unwrap_or(preset.threshold);
        if !(threshold.is_finite() && threshold >= 0.0) {
            return refuse(format!("--threshold is {threshold}, expected a number from 0 up"));
        }
        let target = match (self.target_psnr, self.target_error) {
            (Some(psnr_db), Some(relative)) => Target::Both { psnr_db, relative },
            (Some(db), None) => Target::Psnr(db),
            (None, Some(share)) => Target::Relative(share),
            (None, None) => preset.target,
        };
        target.check().map_err(|error| Failure::new(USAGE, error))?;
        let compress = self.compress.unwrap_or(preset.compress);
        let blocks = match (self.all_blocks, self.near_geometry) {
            (true, _) => StoredBlocks::All,
            (false, true) => StoredBlocks::NearGeometry,
            (false, false) => StoredBlocks::Usual,
        };
        Ok(EncodeSettings { threshold, target, blocks, compress, ..preset })
    }
}
