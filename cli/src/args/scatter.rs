//! The words of `flb scatter`.

use std::path::PathBuf;

use clap::{ArgAction, Args};
use flb_files::Existing;

use super::values::existing;

#[derive(Args)]
#[command(group(clap::ArgGroup::new("amount").required(true).args(["count", "spacing"])))]
pub(crate) struct ScatterArgs {
    /// A species: its name, its mesh, the library with its light, and how often it stands beside the others; repeat it
    /// for more
    #[arg(long, required = true, value_name = "NAME=MESH[,LIGHT.flb][*WEIGHT]", value_parser = species)]
    pub species: Vec<SpeciesArg>,
    /// How many plants
    #[arg(long, value_name = "N")]
    pub count: Option<usize>,
    /// As many plants as keep this distance from each other, metres
    #[arg(long, value_name = "METRES")]
    pub spacing: Option<f64>,
    /// Edges of the rectangle along x and z, metres; its middle is the origin
    #[arg(long, default_value = "100,100", value_name = "X,Z", value_parser = area)]
    pub area: [f64; 2],
    /// Grey PNG over the rectangle: white is where plants stand most densely, black where none does; north (-Z) is up
    #[arg(long, value_name = "MAP.png")]
    pub density: Option<PathBuf>,
    /// Grey PNG of the ground's height, its border pixels on the border of the rectangle; a plane without it
    #[arg(long, value_name = "MAP.png", requires = "height")]
    pub height_map: Option<PathBuf>,
    /// Heights of the map's black and white, metres
    #[arg(long, value_name = "LOW..HIGH", value_parser = range, allow_hyphen_values = true, requires = "height_map")]
    pub height: Option<[f64; 2]>,
    /// Sizes of the plants, each drawn between these
    #[arg(long, default_value = "0.8..1.2", value_name = "LOW..HIGH", value_parser = range)]
    pub scale: [f64; 2],
    /// Turn every plant by one of N yaws, north the first, clockwise: 8 or 16 let an engine keep the whole light of a
    /// species in as many volumes [default: any yaw]
    #[arg(long, value_name = "N", value_parser = clap::value_parser!(u32).range(1..=3600))]
    pub yaws: Option<u32>,
    /// Another seed, another stand
    #[arg(long, default_value_t = 1, value_name = "N")]
    pub seed: u64,
    /// The scene to write; its camera stands in the south and looks over all of it
    #[arg(short, long, value_name = "SCENE.toml")]
    pub output: PathBuf,
    /// Overwrite the output if it is there already
    #[arg(long = "force", action = ArgAction::SetTrue, value_parser = existing())]
    pub existing: Existing,
    /// Print what was scattered as JSON (schema: cli/schema/scatter.json)
    #[arg(long)]
    pub json: bool,
}

/// A species of a scene to be.
#[derive(Debug, Clone, PartialEq)]
pub(crate) struct SpeciesArg {
    pub name: String,
    pub mesh: PathBuf,
    pub light: Option<PathBuf>,
    /// Above 0.
    pub weight: f64,
}

/// `NAME=MESH[,LIGHT][*WEIGHT]`.
fn species(text: &str) -> Result<SpeciesArg, String> {
    let expected =
        || format!("expected NAME=MESH[,LIGHT.flb][*WEIGHT], such as oak=oak.glb,oak.flb*2; found {text:?}");
    let (name, files) = text.split_once('=').ok_or_else(expected)?;
    // A file's name may hold an asterisk; a weight is a number.
    let (files, weight) = match files.rsplit_once('*').map(|(files, weight)| (files, weight.parse::<f64>())) {
        Some((files, Ok(weight))) => (files, weight),
        _ => (files, 1.0),
    };
    let (mesh, light) = files.split_once(',').map_or((files, None), |(mesh, light)| (mesh, Some(light)));
    if name.trim().is_empty() || mesh.is_empty() || light.is_some_and(str::is_empty) {
        return Err(expected());
    }
    if !(weight.is_finite() && weight > 0.0) {
        return Err(format!("weight {weight} of {name:?}, expected a number above 0"));
    }
    Ok(SpeciesArg { name: name.to_owned(), mesh: mesh.into(), light: light.map(PathBuf::from), weight })
}

/// "X,Z" in metres.
pub(super) fn area(text: &str) -> Result<[f64; 2], String> {
    pair(text, ",").ok_or_else(|| format!("expected X,Z in metres, such as 200,150; found {text:?}"))
}

/// "LOW..HIGH", or a single number for both.
pub(super) fn range(text: &str) -> Result<[f64; 2], String> {
    let expected = || format!("expected LOW..HIGH, such as 0.8..1.2; found {text:?}");
    let single = || text.trim().parse::<f64>().ok().map(|value| [value; 2]);
    let range = pair(text, "..").or_else(single).ok_or_else(expected)?;
    match range[0] <= range[1] && range.iter().all(|value| value.is_finite()) {
        true => Ok(range),
        false => Err(expected()),
    }
}

fn pair(text: &str, between: &str) -> Option<[f64; 2]> {
    let (a, b) = text.split_once(between)?;
    Some([a.trim().parse().ok()?, b.trim().parse().ok()?])
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_species_may_have_light_and_a_weight() {
        let of = |text: &str| species(text).expect(text);
        let plain = SpeciesArg { name: "oak".into(), mesh: "a/oak.glb".into(), light: None, weight: 1.0 };
        assert_eq!(of("oak=a/oak.glb"), plain);
        assert_eq!(of("oak=a/oak.glb*2.5"), SpeciesArg { weight: 2.5, ..plain.clone() });
        let light = Some(PathBuf::from("all.flb"));
        assert_eq!(of("oak=a/oak.glb,all.flb*3"), SpeciesArg { light, weight: 3.0, ..plain.clone() });
        assert_eq!(of("oak=odd*name.glb").mesh, PathBuf::from("odd*name.glb"));
        for text in ["oak", "=oak.glb", "oak=", "oak=oak.glb,", "oak=oak.glb*0", "oak=oak.glb*-1"] {
            assert!(species(text).unwrap_err().contains("expected"), "{text}");
        }
    }

    #[test]
    fn a_range_goes_up_and_one_number_is_a_range() {
        assert_eq!((range("0.5..2"), range("1")), (Ok([0.5, 2.0]), Ok([1.0, 1.0])));
        for text in ["2..1", "x", "1..", "nan..1", "0..inf"] {
            assert!(range(text).unwrap_err().contains("LOW..HIGH"), "{text}");
        }
        assert!(area("3").unwrap_err().contains("X,Z"));
    }
}
