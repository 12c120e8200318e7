//! What `--quality` stands for on the command line: a word, and in `--help` every flag that it sets.

use flb_baker::bake::{BakeSettings, PaperSettings, PhysicalSettings};
use flb_format::{Purpose, Quality};
use flb_packer::CodingPreset;
use flb_scene::extents::Walls;
use flb_transport::lattice::Steps;
use flb_transport::ordinates::NamedSuns;

/// A quality as the values of flags.
pub(crate) struct Preset {
    pub lattice: u32,
    pub voxels: u32,
    /// dB.
    pub psnr_db: f64,
    /// Relative error of dark samples.
    pub dark_error: f64,
    /// Of `haar-paper`.
    pub threshold: f32,
    pub suns: NamedSuns,
    pub ordinates: u32,
    pub cut_sites: bool,
    pub tolerance: f64,
    pub paper_tolerance: f64,
}

/// What a quality sets each flag to.
fn preset(quality: Quality) -> Preset {
    let physical = PhysicalSettings::of(quality);
    let CodingPreset { psnr_db, dark_error, threshold } = CodingPreset::of(quality);
    let BakeSettings { lattice, voxels, .. } = BakeSettings::of(quality);
    Preset {
        lattice,
        voxels,
        psnr_db,
        dark_error,
        threshold,
        suns: NamedSuns::of(&physical.suns.basis(Walls::None)).expect("a test goes through all"),
        ordinates: physical.ordinates.count(),
        cut_sites: physical.parts > 1,
        tolerance: physical.tolerance,
        paper_tolerance: PaperSettings::of(quality).tolerance,
    }
}

impl Preset {
    /// Every value as it is written on a command line, in the order of the fields but that both tolerances stand behind
    /// the threshold.
    fn words(&self) -> [String; 10] {
        [
            self.lattice.to_string(),
            self.voxels.to_string(),
            self.psnr_db.to_string(),
            self.dark_error.to_string(),
            self.threshold.to_string(),
            format!("{:e}", self.tolerance),
            format!("{:e}", self.paper_tolerance),
            self.suns.name().to_owned(),
            self.ordinates.to_string(),
            self.cut_sites.to_string(),
        ]
    }
}

/// What `--help` says of `--quality papers`.
fn papers() -> String {
    let BakeSettings { lattice, voxels, .. } = BakeSettings::of(Quality::Papers);
    let CodingPreset { threshold, .. } = CodingPreset::of(Quality::Papers);
    format!(
        " papers: --model paper --lattice {lattice} --voxels {voxels} --ignore-alpha --solver explicit --steps {} --codec \
         haar-paper --threshold {threshold}",
        Steps::PAPERS.count(lattice)
    )
}

/// What `--help` says of `--quality`: every preset as the flags that it stands for.
pub(super) fn help() -> String {
    let mut text = "What these flags are unless they are given (a plan's lattice goes first):".to_owned();
    for quality in Quality::ALL {
        let [lattice, voxels, psnr, error, threshold, tolerance, paper, suns, ordinates, cut] =
            preset(quality).words();
        text += &format!(
            " {quality}: --lattice {lattice} --voxels {voxels} --target-psnr {psnr} --target-error {error} (haar-paper: --threshold \
             {threshold}) --tolerance {tolerance} (paper: {paper}) --suns {suns} --ordinates {ordinates} \
             --cut-sites={cut};"
        );
    }
    text + &papers() + " [default: standard]"
}

/// What `--help` says of `--for`: every purpose as the flags that it stands for.
pub(super) fn purposes() -> String {
    let of = |purpose: Purpose| {
        let BakeSettings { lattice, .. } = BakeSettings::of_purpose(purpose);
        format!("{purpose}: --quality {} --lattice {lattice}", purpose.quality())
    };
    let all: Vec<String> = Purpose::ALL.into_iter().map(of).collect();
    format!("Choose settings by what the file is for, in place of --quality: {}", all.join("; "))
}

#[cfg(test)]
mod tests {
    use super::*;
    use clap::ValueEnum;

    #[test]
    fn the_table_of_the_book_is_this_one() {
        let page = include_str!("../../../docs/book/src/settings.md");
        for quality in Quality::ALL {
            let [lattice, voxels, psnr, error, threshold, tolerance, paper, suns, ordinates, cut] =
                preset(quality).words();
            let row = format!(
                " | {lattice} | {voxels} | {psnr} | {error} | {threshold} | {tolerance} ({paper}) | `{suns}` | {ordinates} | `{cut}` |"
            );
            let begins = format!("| `{}`", quality.name());
            let fits = |line: &str| line.starts_with(&begins) && line.ends_with(&row);
            assert!(page.lines().any(fits), "docs/book/src/settings.md has no row {begins}{row}");
        }
    }

    #[test]
    fn the_papers_preset_is_in_the_help_and_in_the_book() {
        let flags = "--model paper --lattice 128 --voxels 1024 --ignore-alpha --solver explicit --steps 256 --codec haar-paper --threshold 0.05";
        assert!(help().contains(&format!(" papers: {flags} [default: standard]")), "{}", help());
        let page = include_str!("../../../docs/book/src/settings.md");
        assert!(page.replace('\n', " ").contains(flags), "docs/book/src/settings.md lacks {flags}");
    }

    #[test]
    fn a_finer_preset_is_coded_more_closely() {
        for pair in Quality::ALL.windows(2) {
            let [coarse, fine] = [preset(pair[0]), preset(pair[1])];
            assert!(coarse.psnr_db < fine.psnr_db && coarse.dark_error > fine.dark_error, "{pair:?}");
            assert!(coarse.threshold > fine.threshold, "{pair:?}");
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
