//! What the texels of a mesh's materials mean, in words: for `bake` and `materials`.

use std::path::Path;

use flb_scene::color::MaterialColor;
use flb_scene::color::words::{self, shares};
use flb_scene::{ClassedMesh, Plant, PlantReader};
use serde::Serialize;

use crate::print::{self, say};

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

/// Of a mesh that a reader read, and its warnings, which go to stderr.
pub(crate) fn rows(path: &Path, reader: &PlantReader, classed: ClassedMesh) -> (Vec<ColorRow>, Vec<String>) {
    let plant = reader.plant(String::new(), classed);
    say_warnings(path, &plant);
    (of_plant(&plant), words::warnings(&plant))
}

/// Of a plant that is ready to be baked.
pub(crate) fn of_plant(plant: &Plant) -> Vec<ColorRow> {
    words::of_materials(plant).map(|(name, color)| ColorRow::of(name.to_owned(), color)).collect()
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
    words::decisions(plant).iter().for_each(|told| say!("{}: {told}", path.display()));
}

fn say_warnings(path: &Path, plant: &Plant) {
    words::warnings(plant).iter().for_each(|warning| say!("warning: {}: {warning}", path.display()));
}
