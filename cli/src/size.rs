//! What is said of a plant's size, and of what is odd about it: by `bake`, `materials` and `scatter`, and of every mesh
//! that is read without light. The doubts are [`flb_scene::extents`]'; so are the words that mend them.

use std::path::Path;

use flb_format::Medium;
use flb_scene::extents::{Doubt, Extents, Mend, doubts, doubts_of, number};
use flb_scene::{ClassedMesh, ImportSettings, MaterialClass, PlantReader};
use serde::Serialize;

use crate::exit::{Failure, VERDICT};
use crate::print::say;

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

    /// Of a plant that a reader read, but for what its flags and its species file answer.
    pub(crate) fn of_reader(plant: &ClassedMesh, reader: &PlantReader, mend: Mend) -> Measured {
        Measured::new(Extents::of(plant), doubts_of(plant, reader), mend)
    }

    /// Of a box alone: where classes are not known, and of a mesh that only its light tells of.
    pub(crate) fn of_box(extents: Option<Extents>, read_as: &ImportSettings, mend: Mend) -> Measured {
        Measured::new(extents, extents.and_then(|extents| extents.doubt(read_as)).into_iter().collect(), mend)
    }

    fn new(extents: Option<Extents>, doubts: Vec<Doubt>, mend: Mend) -> Measured {
        let size_m = extents.map_or([0.0; 3], |extents| extents.size_m());
        let said = |doubt: &Doubt| DoubtSaid { kind: doubt.name(), message: mend.said(doubt) };
        Measured { size_m, doubts: doubts.iter().map(said).collect() }
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

/// Area of leaves, one side of each, and of wood, square metres, as summaries tell it.
#[derive(Debug, Clone, Copy, Serialize)]
pub(crate) struct Areas {
    leaf_m2: f64,
    leaf_left_m2: f64,
    wood_m2: f64,
    wood_left_m2: f64,
}

impl Areas {
    /// Of all triangles of a plant; nothing is left yet.
    pub(crate) fn of(plant: &ClassedMesh) -> Areas {
        let [leaf_m2, wood_m2] = [MaterialClass::Leaf, MaterialClass::Wood].map(|class| plant.area_m2(class));
        Areas { leaf_m2, leaf_left_m2: 0.0, wood_m2, wood_left_m2: 0.0 }
    }

    /// The same, with what alpha left of it in the medium.
    pub(crate) fn left(self, medium: &Medium) -> Areas {
        Areas { leaf_left_m2: medium.leaf_area_m2(), wood_left_m2: medium.wood_area_m2(), ..self }
    }

    /// Says them on stderr.
    pub(crate) fn say(&self, path: &Path) {
        let of_class = |all_m2: f64, left_m2: f64| {
            format!("{} m^2, of which alpha leaves {} m^2", number(all_m2), number(left_m2))
        };
        let (leaf, wood) =
            (of_class(self.leaf_m2, self.leaf_left_m2), of_class(self.wood_m2, self.wood_left_m2));
        say!("{}: leaf {leaf}; wood {wood}", path.display());
    }
}

/// "12.5 x 11.9 x 11.8".
pub(crate) fn size_text(size_m: [f64; 3]) -> String {
    size_m.map(number).join(" x ")
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_doubt_that_is_said_has_its_kind() {
        let size = Doubt::Size { longest_m: 1500.0, units: vec![("cm", 15.0), ("mm", 1.5)] };
        let all = [size, Doubt::HighWood { above_m: 3.0, height_m: 4.0 }, Doubt::NoLeaf];
        let said = Measured::new(None, all.to_vec(), Mend::Flags).doubts;
        assert_eq!(said.len(), all.len());
        for (said, doubt) in said.iter().zip(&all) {
            assert_eq!((said.kind, &said.message), (doubt.name(), &Mend::Flags.said(doubt)));
        }
    }
}
