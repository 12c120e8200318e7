//! What the texels of a mesh's materials mean, in words: for `bake` and `materials`.

use std::path::Path;

use flb_scene::color::MaterialColor;
use flb_scene::{ClassedMesh, Plant, PlantReader};
use serde::Serialize;

use crate::print::{self, say};

/// Share of a material's area that is clamped before a bake says so.
const WORTH_A_WORD: f64 = 5e-4;

/// One material that is leaf or wood.
#[derive(Debug, Clone, PartialEq, Serialize)]
pub(crate) struct ColorRow {
    /// Its name.
    material: String,
    /// Mean colour of its texture and base colour over the mesh, linear R, G, B; null where it has none.
    colour: Option<[f64; 3]>,
    /// Measured reflectance in the first three bands.
    measured: Vec<f64>,
    /// "albedo" or "tint".
    texel: &'static str,
    /// Who decided.
    rule: String,
    /// Share of its area that would reflect and transmit more than 1, and is scaled down.
    clamped: f64,
    /// What it reflects in the mean, per band.
    reflectance: Vec<f64>,
    /// What it transmits.
    transmittance: Vec<f64>,
}

impl ColorRow {
    fn of(material: String, color: &MaterialColor) -> ColorRow {
        ColorRow {
            material,
            colour: color.texture,
            measured: color.measured.clone(),
            texel: color.texel.name(),
            rule: color.rule.clone(),
            clamped: color.clamped,
            reflectance: color.shown.iter().map(|shares| shares.reflectance).collect(),
            transmittance: color.shown.iter().map(|shares| shares.transmittance).collect(),
        }
    }
}

/// Of a mesh that a reader read; its warnings go to stderr.
pub(crate) fn rows(path: &Path, reader: &PlantReader, classed: ClassedMesh) -> Vec<ColorRow> {
    let plant = reader.plant(String::new(), classed);
    say_warnings(path, &plant);
    of_plant(&plant)
}

/// Of a plant that is ready to be baked.
pub(crate) fn of_plant(plant: &Plant) -> Vec<ColorRow> {
    named(plant).map(|(name, color)| ColorRow::of(name.to_owned(), color)).collect()
}

/// One row a material.
pub(crate) fn table(rows: &[ColorRow]) -> String {
    let head = ["material", "colour", "measured", "texel is", "clamped", "rule"].map(str::to_owned).to_vec();
    let mut lines = vec![head];
    lines.extend(rows.iter().map(|row| {
        vec![
            row.material.clone(),
            row.colour.map_or("-".to_owned(), |colour| shares(&colour)),
            shares(&row.measured),
            row.texel.to_owned(),
            format!("{:.2} %", 100.0 * row.clamped),
            row.rule.clone(),
        ]
    }));
    print::table(&lines)
}

/// Says on stderr what a bake decides of the plant's colours, and what it could not follow.
pub(crate) fn say_colors(path: &Path, plant: &Plant) {
    say_warnings(path, plant);
    let path = path.display();
    for (name, color) in named(plant) {
        if color.is_surprise {
            say!(
                "{path}: material {name:?} has the colour {}, measured leaves reflect {}: its texels are taken for what it \
                 reflects; --leaf-colour measured makes them a tint of the measured colour",
                shares(&color.texture.unwrap_or_default()),
                shares(&color.measured)
            );
        }
        if let Some(note) = &color.note {
            say!("{path}: material {name:?}: {note}");
        }
        if color.clamped >= WORTH_A_WORD {
            say!(
                "{path}: {:.1} % of the area of material {name:?} would reflect and transmit more than all light, and is \
                 scaled down to 1",
                100.0 * color.clamped
            );
        }
    }
}

fn say_warnings(path: &Path, plant: &Plant) {
    for (name, color) in named(plant) {
        if let Some(warning) = &color.warning {
            say!("warning: {}: material {name:?}: {warning}", path.display());
        }
    }
}

fn named(plant: &Plant) -> impl Iterator<Item = (&str, &MaterialColor)> {
    let materials = plant.classed.mesh.materials.iter().zip(&plant.colors);
    materials.filter_map(|(material, color)| Some((material.name.as_str(), color.as_ref()?)))
}

fn shares(shares: &[f64]) -> String {
    shares.iter().map(|share| format!("{share:.3}")).collect::<Vec<_>>().join(" ")
}
