//! Flags that say how closely a file keeps the fields.

use clap::Args;

use crate::preset::Quality;

#[derive(Args, Clone)]
pub struct CodingArgs {
    /// Drop block coefficients up to T, in units of the light that enters (0 keeps all) [default: the preset's]
    #[arg(long, value_name = "T")]
    pub threshold: Option<f32>,
    /// Compress every page with zstd
    #[arg(long)]
    pub compress: bool,
}

impl CodingArgs {
    /// The threshold that the flags ask for.
    pub fn threshold(&self, quality: Option<Quality>) -> f32 {
        self.threshold.unwrap_or(quality.unwrap_or(Quality::Standard).preset().threshold)
    }
}
