//! Flags that say how closely a file keeps the fields.

use clap::Args;
use flb_farm::Recipe;
use flb_format::{Codec, Quality};

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
    /// These flags as settings of a bake; the others are left out.
    pub(crate) fn recipe(&self, quality: Option<Quality>) -> Recipe {
        let CodingArgs { codec, target_psnr, target_error, all_blocks, near_geometry, threshold, compress } =
            *self;
        Recipe {
            quality,
            codec,
            target_psnr,
            target_error,
            all_blocks: all_blocks.then_some(true),
            near_geometry: near_geometry.then_some(true),
            threshold,
            compress,
            ..Recipe::default()
        }
    }
}
