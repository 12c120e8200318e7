//! What mends a doubt, in the words of the place where a reader can say it.

use super::{Doubt, number};

/// Where the unit and the up axis of a mesh are said.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Mend {
    /// By flags of the command that runs.
    Flags,
    /// By flags of the bake that made the light, or in a species file that the scene names.
    Bake,
    /// In the species file that a scene names.
    SpeciesFile,
    /// In the table `plant` of the species in a library's manifest.
    Manifest,
}

impl Mend {
    /// The doubt, and what mends it.
    pub fn said(self, doubt: &Doubt) -> String {
        let mend = match doubt {
            Doubt::Size { units, .. } => self.unit(units, "it is"),
            Doubt::LeafSize { units, .. } => self.unit(units, "they are of"),
            Doubt::Foot { up: Some(up), .. } => self.up(up.name()),
            Doubt::Foot { up: None, .. } => {
                format!("{} does not mend that: turn the plant in its file", self.words("--up", "up"))
            }
            Doubt::Levels { .. } | Doubt::Apart { .. } | Doubt::OneSpot { .. } => {
                format!("{} chooses nodes or groups", self.words("--node", "`nodes`"))
            }
            Doubt::WoodInWood { .. } => {
                let words = self.words("--node", "`nodes`");
                format!("{words} chooses nodes or groups; what is joined must be parted in the mesh")
            }
            Doubt::CutAway { .. } => {
                let alpha = self.alpha();
                format!(
                    "look at the alpha of its image, of its vertices and its factor, or keep all of it ({alpha})"
                )
            }
            Doubt::WoodCut { .. } => {
                let alpha = self.alpha();
                format!("set its material's alphaMode to OPAQUE, or keep all of it ({alpha})")
            }
            Doubt::Scales { .. } | Doubt::Air { .. } | Doubt::Thin { .. } => {
                "look at the units and transforms of its parts, and export again".to_owned()
            }
            Doubt::Scrap { .. } => {
                format!("{} chooses nodes or groups; or delete it in the mesh", self.words("--node", "`nodes`"))
            }
            Doubt::Hull { .. } => {
                let words = self.words("--ignore", "`ignore`");
                format!("{words} leaves out a material; a crown's hull needs leaves of its own")
            }
            Doubt::Tiers { .. } => "a crown of shells needs leaves of its own".to_owned(),
            Doubt::Background { .. } => {
                "export the image with alpha, or name its opacity map in the material, and set alphaMode to MASK"
                    .to_owned()
            }
            Doubt::Uncut { .. } => "set its material's alphaMode to MASK and export again".to_owned(),
            Doubt::VertexColors { .. } => {
                let words = self.words("--ignore-vertex-colours", "`ignore_vertex_colours = true`");
                format!("{words} takes all vertices for white")
            }
            Doubt::Card { .. } => {
                let nodes = self.words("--node", "`nodes`");
                let ignored = self.words("--ignore", "`ignore`");
                format!("{nodes} chooses nodes or groups, {ignored} leaves out a material")
            }
            Doubt::Names { .. } => {
                let words = self.words("--wood and --leaf", "`wood` and `leaf`");
                format!("{words} say what each is, with MATERIAL@PART as here")
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
        format!("{doubt}; {mend}")
    }

    fn words(self, flag: &str, key: &str) -> String {
        match self {
            Mend::Flags => flag.to_owned(),
            Mend::Bake => format!("{flag} of flb bake"),
            Mend::SpeciesFile => format!("{key} of its species file"),
            Mend::Manifest => format!("{key} in its table `plant`"),
        }
    }

    fn alpha(self) -> &'static str {
        match self {
            Mend::Manifest => "`ignore_alpha` in its table `plant`",
            _ => "ignore_alpha of a species file",
        }
    }

    fn unit(self, units: &[(&'static str, f64)], what: &str) -> String {
        let words = self.words("--unit", "unit_m");
        let sizes: Vec<String> = units
            .iter()
            .map(|(unit, longest_m)| {
                let unit_m = crate::unit::parse_unit(unit)
                    .ok()
                    .filter(|_| matches!(self, Mend::SpeciesFile | Mend::Manifest));
                let unit = unit_m.map_or((*unit).to_owned(), |unit_m| unit_m.to_string());
                format!("with {unit} {what} {} m", number(*longest_m))
            })
            .collect();
        match sizes.is_empty() {
            true => format!("{words} says the unit of the mesh file"),
            false => format!("{words} says the unit of the mesh file: {}", sizes.join(", ")),
        }
    }

    fn up(self, axis: &str) -> String {
        format!("{} turns it upright", self.words(&format!("--up {axis}"), &format!("up = {axis:?}")))
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::extents::Side;
    use crate::import::Up;

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
            (
                Mend::Manifest,
                &size,
                "; unit_m in its table `plant` says the unit of the mesh file: with 0.01 it is 15 m",
            ),
            (Mend::Flags, &foot(Some(Up::Z)), "expected at its bottom, -y; --up z turns it upright"),
            (Mend::SpeciesFile, &foot(Some(Up::Z)), "; up = \"z\" of its species file turns it upright"),
            (Mend::Flags, &foot(None), "; --up does not mend that: turn the plant in its file"),
            (Mend::Flags, &shells, "; --wood and --ignore say what is no leaf; a crown's hull needs"),
            (Mend::Flags, &wood, "; --wood, --leaf and --ignore say what each material is"),
        ];
        for (mend, doubt, expected) in cases {
            let said = mend.said(doubt);
            assert!(said.contains(expected), "{said}");
        }
    }
}
