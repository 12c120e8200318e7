//! How bases are coded and laid out.

use flb_format::{Codec, Quality};

use crate::rate::{DEFAULT_TARGET, Target};

/// Most bytes of a page before compression, unless asked for otherwise.
const PAGE_BYTES: u32 = 65_536;

/// Codec, targets and layout of the bases of a species.
#[derive(Debug, Clone, PartialEq)]
pub struct EncodeSettings {
    /// Codec of every base.
    pub codec: Codec,
    /// Relative threshold of `haar-paper`: a coefficient is kept above `threshold` times the base's value in empty
    /// space (1; 18 for base 0 of `paper`), or in the sun's fields of `physical` times the mean scattered light of the
    /// brightest band. Not used by the raw codecs.
    pub threshold: f32,
    /// Error that `classed` and `haar` may make, each base by itself. Not used by the others.
    pub target: Target,
    /// Blocks that `classed`, `haar` and `haar-paper` store.
    pub blocks: StoredBlocks,
    /// Whether pages are zstd-compressed where that makes them smaller.
    pub compress: bool,
    /// Largest size of a page before compression, in bytes; a multiple of 4096 from 20480 to 4194304.
    pub page_bytes: u32,
}

/// Blocks of the lattice that a codec of blocks stores.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default)]
pub enum StoredBlocks {
    /// Blocks near geometry of `classed` and `haar`; every block of `haar-paper`.
    #[default]
    Usual,
    /// Every block.
    All,
    /// Blocks alone that a renderer asks at matter, as the papers say. A `haar-paper` block elsewhere has mask 0, which
    /// reads as no light.
    NearGeometry,
}

/// What `flb bake` writes by default.
impl Default for EncodeSettings {
    fn default() -> EncodeSettings {
        EncodeSettings::of(Quality::Standard, Codec::Classed)
    }
}

/// Errors that a quality codes to.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct CodingPreset {
    /// PSNR of `classed` and `haar`, in dB.
    pub psnr_db: f64,
    /// Relative error of `classed` and `haar` in dark places.
    pub dark_error: f64,
    /// Threshold of `haar-paper`.
    pub threshold: f32,
}

impl CodingPreset {
    /// Returns the errors of a quality.
    pub fn of(quality: Quality) -> CodingPreset {
        let (psnr_db, dark_error, threshold) = match quality {
            Quality::Draft => (38.0, 0.15, 0.05),
            Quality::Standard => (45.0, 0.06, 0.02),
            Quality::Fine => (52.0, 0.03, 0.005),
            Quality::Reference => (60.0, 0.01, 0.0),
            // Other codecs than the papers' code as closely as by default.
            Quality::Papers => (45.0, 0.06, 0.05),
        };
        CodingPreset { psnr_db, dark_error, threshold }
    }
}

impl EncodeSettings {
    /// Settings by which a quality keeps the light, by one of the codecs.
    pub fn of(quality: Quality, codec: Codec) -> EncodeSettings {
        let CodingPreset { psnr_db, dark_error, threshold } = CodingPreset::of(quality);
        EncodeSettings {
            codec,
            threshold: if codec == Codec::HaarPaper { threshold } else { 0.0 },
            target: Target::Both { psnr_db, relative: dark_error },
            blocks: StoredBlocks::Usual,
            compress: codec.is_near_geometry(),
            page_bytes: PAGE_BYTES,
        }
    }

    /// Settings of `flb bake-scene`. Readers take quotients of what is stored, so its error is held far below that of
    /// light that is looked at.
    pub fn scene_light() -> EncodeSettings {
        EncodeSettings::of(Quality::Reference, Codec::Classed)
    }

    /// Whether blocks away from geometry are stored, too.
    pub fn has_all_blocks(&self) -> bool {
        match self.blocks {
            StoredBlocks::Usual => !self.codec.is_near_geometry(),
            StoredBlocks::All => true,
            StoredBlocks::NearGeometry => false,
        }
    }

    /// The papers' blocks, all of them, without any loss: for comparing.
    pub fn papers() -> EncodeSettings {
        EncodeSettings {
            codec: Codec::HaarPaper,
            threshold: 0.0,
            target: DEFAULT_TARGET,
            blocks: StoredBlocks::Usual,
            compress: false,
            page_bytes: PAGE_BYTES,
        }
    }
}
