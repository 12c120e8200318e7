//! From the settings of a bake to those of its coding.

use flb_format::{Codec, Quality};
use flb_packer::rate::Target;
use flb_packer::{EncodeSettings, StoredBlocks};

use super::{Recipe, RecipeError};

impl Recipe {
    /// Whether any setting asks for another coding.
    pub fn asks_for_coding(&self) -> bool {
        let Recipe {
            codec, target_psnr, target_error, all_blocks, near_geometry, threshold, compress, ..
        } = self;
        codec.is_some()
            || target_psnr.is_some()
            || target_error.is_some()
            || *all_blocks == Some(true)
            || *near_geometry == Some(true)
            || threshold.is_some()
            || compress.is_some()
    }

    /// Whether an error of the coding is asked for: then missing it is a loss. That of a preset is a wish, and missing
    /// it worth a warning.
    pub fn asks_for_error(&self) -> bool {
        self.target_psnr.is_some() || self.target_error.is_some()
    }

    /// The codec that is asked for.
    pub fn codec(&self) -> Codec {
        let is_papers = self.threshold.is_some() || self.quality() == Quality::Papers;
        let usual = if is_papers { Codec::HaarPaper } else { Codec::Classed };
        self.codec.unwrap_or(usual)
    }

    /// How the fields are coded: as the settings ask, and as the preset does where they do not.
    ///
    /// # Errors
    /// A setting out of its range, or of another codec.
    pub fn encode_settings(&self) -> Result<EncodeSettings, RecipeError> {
        self.check_preset()?;
        let codec = self.codec();
        let preset = EncodeSettings::of(self.quality(), codec);
        let refuse = |text: String| Err(RecipeError::new(text));
        if codec != Codec::HaarPaper && self.threshold.is_some() {
            return refuse(format!("`threshold` is for `codec haar-paper`, not for {}", codec.name()));
        }
        let (all_blocks, near_geometry) = (self.all_blocks == Some(true), self.near_geometry == Some(true));
        let near = [
            ("target_psnr", self.target_psnr.is_some()),
            ("target_error", self.target_error.is_some()),
            ("all_blocks", all_blocks),
        ];
        if let Some((key, _)) = near.iter().find(|(_, given)| *given && !codec.is_near_geometry()) {
            return refuse(format!("`{key}` is for `codec classed` and haar, not for {}", codec.name()));
        }
        if near_geometry && codec != Codec::HaarPaper {
            return refuse(format!("`near_geometry` is for `codec haar-paper`, not for {}", codec.name()));
        }
        let threshold = self.threshold.unwrap_or(preset.threshold);
        if !(threshold.is_finite() && threshold >= 0.0) {
            return refuse(format!("`threshold` is {threshold}, expected a number from 0 up"));
        }
        let target = match (self.target_psnr, self.target_error) {
            (Some(psnr_db), Some(relative)) => Target::Both { psnr_db, relative },
            (Some(db), None) => Target::Psnr(db),
            (None, Some(share)) => Target::Relative(share),
            (None, None) => preset.target,
        };
        target.check().map_err(|error| RecipeError::new(error.to_string()))?;
        let blocks = match (all_blocks, near_geometry) {
            (true, _) => StoredBlocks::All,
            (false, true) => StoredBlocks::NearGeometry,
            (false, false) => StoredBlocks::Usual,
        };
        let compress = self.compress.unwrap_or(preset.compress);
        Ok(EncodeSettings { threshold, target, blocks, compress, ..preset })
    }
}
