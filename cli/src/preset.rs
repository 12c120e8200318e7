//! What `--quality` stands for: the settings of a bake by one word.

use clap::ValueEnum;
use flb_packer::rate::Target;
use flb_transport::ordinates::Ordinates;

use crate::args::SunsArg;

/// A named set of settings.
#[derive(Clone, Copy, PartialEq, Eq, Debug, ValueEnum)]
pub enum Quality {
    /// To try a plant: seconds, and a small file
    Draft,
    /// For use
    Standard,
    /// Coding errors hardly seen
    #[value(alias = "high")]
    Fine,
    /// As exact as a bake can be
    #[value(alias = "lossless")]
    Reference,
}

/// Settings of a bake that a preset chooses; each has a flag that overrides it.
#[derive(Clone, Copy, PartialEq, Debug)]
pub struct Preset {
    /// Sites along each edge; both models.
    pub lattice: u32,
    /// Error of samples at surfaces that bases are coded to, dB; both models.
    pub psnr_db: f64,
    /// Relative error of the darkest tenth of them that is met as well.
    pub dark_error: f64,
    /// The same as a threshold of `haar-paper`.
    pub threshold: f32,
    /// How the fields depend on the sun; `physical`, as all that follow but the last.
    pub suns: SunsArg,
    /// Directions that light is marched along.
    pub ordinates: Ordinates,
    /// Parts that sites are cut into along each edge.
    pub parts: u32,
    /// Estimated error at which a solve has converged.
    pub tolerance: f64,
    /// The same for `paper`.
    pub paper_tolerance: f64,
}

impl Preset {
    /// Errors that bases are coded to.
    pub fn target(&self) -> Target {
        Target::Both { psnr_db: self.psnr_db, relative: self.dark_error }
    }
}

impl Quality {
    /// From the quickest to the most exact.
    pub const ALL: [Quality; 4] = [Quality::Draft, Quality::Standard, Quality::Fine, Quality::Reference];

    /// As on the command line.
    pub fn name(self) -> &'static str {
        match self {
            Quality::Draft => "draft",
            Quality::Standard => "standard",
            Quality::Fine => "fine",
            Quality::Reference => "reference",
        }
    }

    /// The settings.
    pub fn preset(self) -> Preset {
        let standard = Preset {
            lattice: 128,
            psnr_db: 45.0,
            dark_error: 0.06,
            threshold: 0.02,
            suns: SunsArg::Sh2s, // the light scattered once brings more than harmonics do
            ordinates: Ordinates::Lebedev110,
            parts: 1,
            tolerance: 2e-3,
            paper_tolerance: 1e-4,
        };
        match self {
            Quality::Draft => Preset {
                lattice: 32,
                psnr_db: 38.0,
                dark_error: 0.15,
                threshold: 0.05,
                suns: SunsArg::Sh1s,
                ordinates: Ordinates::Lebedev50,
                tolerance: 1e-2,
                paper_tolerance: 1e-3,
                ..standard
            },
            Quality::Standard => standard,
            Quality::Fine => {
                Preset { psnr_db: 52.0, dark_error: 0.03, threshold: 0.005, suns: SunsArg::Sh3s, ..standard }
            }
            Quality::Reference => Preset {
                psnr_db: 60.0,
                dark_error: 0.01,
                threshold: 0.0,
                suns: SunsArg::Sh3s,
                parts: 2,
                tolerance: 1e-3,
                paper_tolerance: 1e-5,
                ..standard
            },
        }
    }
}

/// What `--help` says of `--quality`: every preset as the flags that it stands for.
pub fn help() -> String {
    let mut text = "What these flags are unless they are given (a plan's lattice goes first):".to_owned();
    for quality in Quality::ALL {
        let preset = quality.preset();
        text += &format!(
            " {}: --lattice {} --target-psnr {} --target-error {} (haar-paper: --threshold {}) --tolerance {:e} (paper: {:e}) --suns {} --ordinates {} --cut-sites={};",
            quality.name(),
            preset.lattice,
            preset.psnr_db,
            preset.dark_error,
            preset.threshold,
            preset.tolerance,
            preset.paper_tolerance,
            preset.suns.word(),
            preset.ordinates.count(),
            preset.parts > 1
        );
    }
    text.pop();
    text + " [default: standard]"
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_table_of_the_book_is_this_one() {
        let page = include_str!("../../docs/book/src/settings.md");
        for quality in Quality::ALL {
            let preset = quality.preset();
            let row = format!(
                " | {} | {} | {} | {} | {:e} ({:e}) | `{}` | {} | `{}` |",
                preset.lattice,
                preset.psnr_db,
                preset.dark_error,
                preset.threshold,
                preset.tolerance,
                preset.paper_tolerance,
                preset.suns.word(),
                preset.ordinates.count(),
                preset.parts > 1
            );
            let begins = format!("| `{}`", quality.name());
            let fits = |line: &str| line.starts_with(&begins) && line.ends_with(&row);
            assert!(page.lines().any(fits), "docs/book/src/settings.md has no row {begins}{row}");
        }
    }

    #[test]
    fn a_finer_preset_is_nowhere_coarser() {
        let fields = |preset: &Preset| preset.suns.suns().items();
        for pair in Quality::ALL.windows(2) {
            let [coarse, fine] = [pair[0].preset(), pair[1].preset()];
            assert!(coarse.lattice <= fine.lattice && coarse.threshold > fine.threshold, "{pair:?}");
            assert!(coarse.psnr_db < fine.psnr_db && coarse.dark_error > fine.dark_error, "{pair:?}");
            assert!(fields(&coarse) <= fields(&fine) && coarse.parts <= fine.parts, "{pair:?}");
            assert!(coarse.ordinates.count() <= fine.ordinates.count());
            assert!(coarse.tolerance >= fine.tolerance && coarse.paper_tolerance >= fine.paper_tolerance);
        }
    }

    #[test]
    fn every_preset_goes_by_its_name_and_two_by_their_former_ones() {
        for quality in Quality::ALL {
            assert_eq!(Quality::from_str(quality.name(), false), Ok(quality));
        }
        assert_eq!(Quality::from_str("high", false), Ok(Quality::Fine));
        assert_eq!(Quality::from_str("lossless", false), Ok(Quality::Reference));
    }
}
