//! The error that a coding may make, and what missed it.

use std::fmt;

use crate::PackError;

/// Target that files are coded to unless asked otherwise: dark places are where an eye that has adapted looks for
/// errors.
pub const DEFAULT_TARGET: Target = Target::Both { psnr_db: 45.0, relative: 0.06 };

/// Decibels better than the mean error asked for up to which a relative one is pursued.
pub(super) const PURSUIT_DB: f64 = 12.0;
/// Darker places, relative to the peak, are taken to be this bright: a relative error is not seen there.
pub(super) const DARKEST: f32 = 1.0 / 256.0;

/// The error that a coding may make.
#[derive(Debug, Clone, Copy, PartialEq)]
pub enum Target {
    /// Peak signal to noise of samples at surfaces, dB, to the base's largest sample.
    Psnr(f64),
    /// 99th percentile of the relative error over the darkest tenth of the samples. Steps become finer in dark blocks.
    Relative(f64),
    /// Target for both errors, of which one may be better.
    Both {
        /// Peak signal to noise, dB, as of [`Target::Psnr`].
        psnr_db: f64,
        /// Relative error, as of [`Target::Relative`].
        relative: f64,
    },
}

impl Target {
    /// Mean and relative error, where they are asked for.
    pub fn errors(self) -> (Option<f64>, Option<f64>) {
        match self {
            Target::Psnr(db) => (Some(db), None),
            Target::Relative(share) => (None, Some(share)),
            Target::Both { psnr_db, relative } => (Some(psnr_db), Some(relative)),
        }
    }

    /// Least square error of a point, summed over so many bands and relative to the peak, that a coding is driven to.
    pub(super) fn most_pursued(self, bands: usize) -> f64 {
        let square = |db: f64| bands as f64 * libm::exp10(-db / 10.0);
        match self {
            Target::Psnr(db) => square(db),
            Target::Both { psnr_db, .. } => square(psnr_db + PURSUIT_DB),
            Target::Relative(share) => {
                let least = share * f64::from(DARKEST);
                least * least
            }
        }
    }

    /// Checks that a coding can be asked for the target.
    ///
    /// # Errors
    /// [`PackError::Setting`].
    pub fn check(self) -> Result<(), PackError> {
        let (psnr_db, relative) = self.errors();
        let setting = |what, found: String, expected| Err(PackError::Setting { what, found, expected });
        if let Some(db) = psnr_db.filter(|db| !(10.0..=80.0).contains(db)) {
            return setting("the target PSNR", format!("{db} dB"), "10 to 80 dB");
        }
        if let Some(share) = relative.filter(|share| !(0.005..=0.5).contains(share)) {
            return setting("the target relative error", share.to_string(), "0.005 to 0.5");
        }
        Ok(())
    }
}

impl fmt::Display for Target {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        match self {
            Target::Psnr(db) => write!(f, "{db} dB"),
            Target::Relative(share) => write!(f, "a relative error of {share}"),
            Target::Both { psnr_db, relative } => {
                write!(f, "{psnr_db} dB and a relative error of {relative}")
            }
        }
    }
}

/// Decibels that a base may be off its target; a relative error may be twice as much (2.3 %) below what was asked for,
/// and never above. Where the error jumps over the target, as it does in small fields, a base may be better.
pub const SLACK_DB: f64 = 0.1;
/// A base (of several that are judged together the first) whose error is off the target: it is coded as near to it as
/// could be, but for a relative error no more than 12 dB better than the mean error that is asked for beside it.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Missed {
    /// Index of the base.
    pub base: u8,
    /// Error of samples at surfaces, dB.
    pub psnr_db: f64,
    /// Relative error of the darkest tenth of them.
    pub dark_error: f64,
    /// Target that was asked for.
    pub target: Target,
}

impl Missed {
    /// Whether the mean error, or the only one that was asked for, is missed.
    pub fn is_loss(&self) -> bool {
        self.target.errors().0.is_none_or(|db| self.psnr_db < db - SLACK_DB)
    }
}

impl fmt::Display for Missed {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        let Missed { base, psnr_db, dark_error, target } = self;
        write!(
            f,
            "base {base} has {psnr_db:.1} dB and a relative error of {dark_error:.3} in dark places, expected {target}"
        )
    }
}
