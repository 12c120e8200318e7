//! How exact a bake is, or what it is for, in one word.

use std::fmt;

/// A word that bake and coding both follow. What it stands for is with those who use it: `flb_baker::BakeSettings::of`
/// for lattice and solve, `flb_packer::EncodeSettings::of` for the error of the coding.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Hash, Default)]
#[cfg_attr(feature = "clap", derive(clap::ValueEnum))]
pub enum Quality {
    /// For a try, in seconds and with a small file.
    Draft,
    /// For use.
    #[default]
    Standard,
    /// Coding errors hardly seen.
    #[cfg_attr(feature = "clap", value(alias = "high"))]
    Fine,
    /// Highest accuracy of a bake.
    #[cfg_attr(feature = "clap", value(alias = "lossless"))]
    Reference,
    /// The papers' own settings, which are not the most exact ones.
    Papers,
}

impl Quality {
    /// Qualities from the quickest to the most exact; [`Quality::Papers`] has no place among them.
    pub const ALL: [Quality; 4] = [Quality::Draft, Quality::Standard, Quality::Fine, Quality::Reference];

    /// Name of the quality on the command line.
    pub fn name(self) -> &'static str {
        match self {
            Quality::Draft => "draft",
            Quality::Standard => "standard",
            Quality::Fine => "fine",
            Quality::Reference => "reference",
            Quality::Papers => "papers",
        }
    }
}

impl fmt::Display for Quality {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        f.write_str(self.name())
    }
}

/// Use that a bake is for. What it stands for is with those who use it: a quality, and for some a lattice
/// (`flb_baker::BakeSettings::of_purpose`).
#[derive(Debug, Clone, Copy, PartialEq, Eq, Hash)]
#[cfg_attr(feature = "clap", derive(clap::ValueEnum))]
pub enum Purpose {
    /// Real time: many plants, little memory, a sun that moves.
    Games,
    /// Pictures: what is baked where nothing is said.
    Stills,
    /// Frames of a film: closer coding and more harmonics, which bright leaves need.
    Film,
}

impl Purpose {
    /// All purposes.
    pub const ALL: [Purpose; 3] = [Purpose::Games, Purpose::Stills, Purpose::Film];

    /// Name of the purpose on the command line.
    pub fn name(self) -> &'static str {
        match self {
            Purpose::Games => "games",
            Purpose::Stills => "stills",
            Purpose::Film => "film",
        }
    }

    /// The quality that it takes.
    pub fn quality(self) -> Quality {
        match self {
            Purpose::Games | Purpose::Stills => Quality::Standard,
            Purpose::Film => Quality::Fine,
        }
    }
}

impl fmt::Display for Purpose {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        f.write_str(self.name())
    }
}
