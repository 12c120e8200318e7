//! What is said of a plant's size, and of what is odd about it: by `bake`, `materials` and `scatter`, and of every mesh
//! that is read without light. The doubts are [`flb_scene::extents`]'; the flags that mend them are named here.

use std::path::Path;

use flb_scene::extents::{Doubt, Extents, doubts, number};
use flb_scene::{ClassedMesh, ImportSettings};
use serde::Serialize;

use crate::exit::{Failure, VERDICT};
use crate::print::say;

/// Where the unit and the up axis of a mesh are said.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(crate) enum Mend {
    /// By flags of the command that runs.
    Flags,
    /// By flags of the bake that made the light, or in a species file that the scene names.
    Bake,
    /// In the species file that a scene names.
    SpeciesFile,
}

/// A plant's size and the doubts about it, as summaries tell them.
#[derive(Debug, Clone, Serialize)]
pub(crate) struct Measured {
    /// Width along x, height along y, depth along z.
    pub size_m: [f64; 3],
    pub doubts: Vec<DoubtSaid>,
}

/// A doubt, and what mends it.
#[derive(Debug, Clone, PartialEq, Serialize)]
pub(crate) struct DoubtSaid {
    kind: &'static str,
    pub message: String,
}

impl Measured {
    /// Of a plant whose mesh was read as `read_as` says.
    pub(crate) fn of(plant: &ClassedMesh, read_as: &ImportSettings, mend: Mend) -> Measured {
        Measured::new(Extents::of(plant), doubts(plant, read_as), mend)
    }

    /// Of a box alone: where classes are not known, and of a mesh that only its light tells of.
    pub(crate) fn of_box(extents: Option<Extents>, read_as: &ImportSettings, mend: Mend) -> Measured {
        Measured::new(extents, extents.and_then(|extents| extents.doubt(read_as)).into_iter().collect(), mend)
    }

    fn new(extents: Option<Extents>, doubts: Vec<Doubt>, mend: Mend) -> Measured {
        let size_m = extents.map_or([0.0; 3], |extents| extents.size_m());
        Measured { size_m, doubts: doubts.iter().map(|doubt| mend.said(doubt)).collect() }
    }

    /// Says the doubts on stderr.
    pub(crate) fn say(&self, path: &Path) {
        self.doubts.iter().for_each(|doubt| say!("warning: {}: {}", path.display(), doubt.message));
    }

    /// For `--strict`: an error where there is a doubt, or a warning about the mesh.
    pub(crate) fn strict(&self, warnings: &[String], path: &Path) -> Result<(), Failure> {
        let doubts = self.doubts.iter().map(|doubt| &doubt.message);
        let all: Vec<&String> = doubts.chain(warnings).collect();
        match all.as_slice() {
            [] => Ok(()),
            [first, rest @ ..] => {
                let more =
                    if rest.is_empty() { String::new() } else { format!(" (and {} more)", rest.len()) };
                Err(Failure::new(VERDICT, format!("--strict: {first}{more}")).at(path))
            }
        }
    }

    /// "12.5 x 11.9 x 11.8 m".
    pub(crate) fn text(&self) -> String {
        format!("{} m", size_text(self.size_m))
    }
}

/// "12.5 x 11.9 x 11.8".
pub(crate) fn size_text(size_m: [f64; 3]) -> String {
    size_m.map(number).join(" x ")
}

impl Mend {
    fn said(self, doubt: &Doubt) -> DoubtSaid {
        let mend = match doubt {
            Doubt::Size { units, .. } => self.unit(units),
            Doubt::Foot { up: Some(up), .. } => self.up(up.name()),
            Doubt::Foot { up: None, .. } => {
                format!("{} does not mend that: turn the plant in its file", self.words("--up", "up"))
            }
            Doubt::Levels { .. } | Doubt::Apart { .. } => {
                format!("{} chooses nodes or groups", self.words("--node", "`nodes`"))
            }
            Doubt::CutAway { .. } => {
                "look at its image's alpha channel, or keep all of it (ignore_alpha of a species file)"
                    .to_owned()
            }
            Doubt::WoodCut { .. } => {
                "set its material's alphaMode to OPAQUE, or keep all of it (ignore_alpha of a species file)"
                    .to_owned()
            }
            Doubt::Uncut { .. } => "set its material's alphaMode to MASK and export again".to_owned(),
            Doubt::Card { .. } => {
                let nodes = self.words("--node", "`nodes`");
                let ignored = self.words("--ignore", "`ignore`");
                format!("{nodes} chooses nodes or groups, {ignored} leaves out a material")
            }
            Doubt::HighWood { .. } | Doubt::NoWood | Doubt::NoLeaf => {
                let words = self.words("--wood, --leaf and --ignore", "`wood`, `leaf` and `ignore`");
                format!("{words} say what each material is")
            }
            Doubt::Enclosed(_) => {
                let words = self.words("--ignore", "`ignore`");
                format!("{words} leaves out a box that is none of the plant's")
            }
            Doubt::SecondSheets { .. } => {
                let words = self.words("--ignore", "`ignore`");
                format!(
                    "if they are the two sides of one leaf, leave one out: {words} of its material, or in the mesh"
                )
            }
            Doubt::Shells { .. } => {
                let words = self.words("--wood and --ignore", "`wood` and `ignore`");
                format!("{words} say what is no leaf; a crown's hull needs leaves of its own")
            }
        };
        DoubtSaid { kind: doubt.name(), message: format!("{doubt}; {mend}") }
    }

    fn words(self, flag: &str, key: &str) -> String {
        match self {
            Mend::Flags => flag.to_owned(),
            Mend::Bake => format!("{flag} of flb bake"),
            Mend::SpeciesFile => format!("{key} of its species file"),
        }
    }

    fn unit(self, units: &[(&'static str, f64)]) -> String {
        let words = self.words("--unit", "unit_m");
        let sizes: Vec<String> = units
            .iter()
            .map(|(unit, longest_m)| {
                let unit_m = flb_scene::unit::parse_unit(unit).ok().filter(|_| self == Mend::SpeciesFile);
                let unit = unit_m.map_or((*unit).to_owned(), |unit_m| unit_m.to_string());
                format!("with {unit} it is {} m", number(*longest_m))
            })
            .collect();
        match sizes.is_empty() {
            true => format!("{words} says the unit of the mesh file"),
            false => format!("{words} says the unit of the mesh file: {}", sizes.join(", ")),
        }
    }

    fn up(self, axis: &str) -> String {
        let words = match self {
            Mend::Flags => format!("--up {axis}"),
            Mend::Bake => format!("--up {axis} of flb bake"),
            Mend::SpeciesFile => format!("up = {axis:?} of its species file"),
        };
        format!("{words} turns it upright")
    }
}

#[cfg(test)]
mod tests {
    use flb_scene::extents::Side;
    use flb_scene::import::Up;

    use super::*;

    #[test]
    fn every_doubt_names_what_mends_it() {
        let size = Doubt::Size { longest_m: 1500.0, units: vec![("cm", 15.0), ("mm", 1.5)] };
        let foot = |up| Doubt::Foot { at: Side { axis: 2, is_upper: false }, up };
        let wood = Doubt::HighWood { above_m: 3.0, height_m: 4.0 };
        let shells = Doubt::Shells { shells_m2: 3.0, leaf_m2: 4.0, thickness_m: 0.5 };
        let cases = [
            (
                Mend::Flags,
                &size,
                "; --unit says the unit of the mesh file: with cm it is 15 m, with mm it is 1.5 m",
            ),
            (Mend::Bake, &size, "; --unit of flb bake says the unit of the mesh file: with cm it is 15 m"),
            (
                Mend::SpeciesFile,
                &size,
                "; unit_m of its species file says the unit of the mesh file: with 0.01 it is",
            ),
            (Mend::Flags, &foot(Some(Up::Z)), "expected at its bottom, -y; --up z turns it upright"),
            (Mend::SpeciesFile, &foot(Some(Up::Z)), "; up = \"z\" of its species file turns it upright"),
            (Mend::Flags, &foot(None), "; --up does not mend that: turn the plant in its file"),
            (Mend::Flags, &shells, "; --wood and --ignore say what is no leaf; a crown's hull needs"),
            (Mend::Flags, &wood, "; --wood, --leaf and --ignore say what each material is"),
        ];
        for (mend, doubt, expected) in cases {
            let said = mend.said(doubt);
            assert!(said.message.contains(expected), "{}", said.message);
            assert_eq!(said.kind, doubt.name());
        }
    }
}
