//! Names of the usual bases of the sun's direction.

use flb_format::matter::LeafAngles;

use super::SunBasis;
use super::icosahedron::{ico12, ico42};

/// Usual basis of the sun's direction, by its name.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
#[cfg_attr(feature = "clap", derive(clap::ValueEnum))]
pub enum NamedSuns {
    /// A field for each of 18 directions, blended by three
    Lattice18,
    /// A field for each of 12 directions, corners of an icosahedron, blended by three
    Ico12,
    /// A field for each of 42 directions, blended by three: corners of an icosahedron, and middles of its edges
    Ico42,
    /// 4 harmonics of the sun's direction and the near beam: 9 fields
    Sh1,
    /// 4 harmonics, the near beam, and the light scattered once: 8 fields
    Sh1s,
    /// 9 harmonics and the near beam: 14 fields
    Sh2,
    /// 9 harmonics, the near beam, and the light scattered once: 13 fields
    Sh2s,
    /// 16 harmonics and the near beam: 21 fields
    Sh3,
    /// 16 harmonics, the near beam, and the light scattered once: 20 fields
    Sh3s,
}

impl NamedSuns {
    /// All names.
    pub const ALL: [NamedSuns; 9] = [
        NamedSuns::Lattice18,
        NamedSuns::Ico12,
        NamedSuns::Ico42,
        NamedSuns::Sh1,
        NamedSuns::Sh1s,
        NamedSuns::Sh2,
        NamedSuns::Sh2s,
        NamedSuns::Sh3,
        NamedSuns::Sh3s,
    ];

    /// Returns the basis; a near beam leans with the leaves' inclinations.
    pub fn basis(self) -> SunBasis {
        let harmonics = |degree, single| SunBasis::Harmonics { degree, single, leaning: true };
        match self {
            NamedSuns::Lattice18 => SunBasis::Lattice18,
            NamedSuns::Ico12 => ico12(),
            NamedSuns::Ico42 => ico42(),
            NamedSuns::Sh1 => harmonics(1, false),
            NamedSuns::Sh1s => harmonics(1, true),
            NamedSuns::Sh2 => harmonics(2, false),
            NamedSuns::Sh2s => harmonics(2, true),
            NamedSuns::Sh3 => harmonics(3, false),
            NamedSuns::Sh3s => harmonics(3, true),
        }
    }

    /// Returns the name of a basis that has one, whether its near beam leans or not.
    pub fn of(basis: &SunBasis) -> Option<NamedSuns> {
        let upright = |basis: SunBasis| basis.of_leaves(&LeafAngles::spherical());
        let basis = upright(basis.clone());
        NamedSuns::ALL.into_iter().find(|suns| upright(suns.basis()) == basis)
    }

    /// Returns the name: one lower-case word.
    pub fn name(self) -> &'static str {
        match self {
            NamedSuns::Lattice18 => "lattice18",
            NamedSuns::Ico12 => "ico12",
            NamedSuns::Ico42 => "ico42",
            NamedSuns::Sh1 => "sh1",
            NamedSuns::Sh1s => "sh1s",
            NamedSuns::Sh2 => "sh2",
            NamedSuns::Sh2s => "sh2s",
            NamedSuns::Sh3 => "sh3",
            NamedSuns::Sh3s => "sh3s",
        }
    }
}
