//! What was decided of a plant's colours, in sentences.

use crate::Plant;
use crate::color::MaterialColor;

/// Share of a material's area that is scaled down before that is worth a word.
const WORTH_A_WORD: f64 = 5e-4;

/// Colours of the materials of a plant that are leaf or wood, by name.
pub fn of_materials(plant: &Plant) -> impl Iterator<Item = (&str, &MaterialColor)> {
    let materials = plant.classed.mesh.materials.iter().zip(&plant.colors);
    materials.filter_map(|(material, color)| Some((material.name.as_str(), color.as_ref()?)))
}

/// Requests on colours that were not followed, a sentence each.
pub fn warnings(plant: &Plant) -> Vec<String> {
    let told = |(name, color): (&str, &MaterialColor)| {
        color.warning.as_ref().map(|warning| format!("material {name:?}: {warning}"))
    };
    of_materials(plant).filter_map(told).collect()
}

/// Decisions that are not the common ones, a sentence each.
pub fn decisions(plant: &Plant) -> Vec<String> {
    let mut told = Vec::new();
    for (name, color) in of_materials(plant) {
        if color.is_surprise {
            let [kind, key] =
                if color.is_leaf { ["leaves reflect", "leaf"] } else { ["wood reflects", "wood"] };
            told.push(format!(
                "material {name:?} has the colour {}, measured {kind} {}: its texels are taken for what it \
                 reflects; --{key}-colour measured (in a species file {key}_colour = \"measured\") makes them a tint \
                 of the measured colour",
                shares(&color.texture.unwrap_or_default()),
                shares(&color.measured)
            ));
        }
        if let Some(note) = &color.note {
            told.push(format!("material {name:?}: {note}"));
        }
        if color.clamped >= WORTH_A_WORD {
            told.push(format!(
                "{:.1} % of the area of material {name:?} would reflect and transmit more than all light, and is \
                 scaled down to 1",
                100.0 * color.clamped
            ));
        }
    }
    told
}

/// Shares of light: "0.112 0.169 0.035".
pub fn shares(shares: &[f64]) -> String {
    shares.iter().map(|share| format!("{share:.3}")).collect::<Vec<_>>().join(" ")
}
