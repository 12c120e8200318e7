//! The materials of a mesh as a table: how much of the plant each makes up, and its class.

use serde::Serialize;

use crate::classify::{ClassRules, Classified, Found, found};
use crate::import::{ImportError, area, quoted};
use crate::mesh::{AlphaMode, Mesh};

/// One material.
#[derive(Debug, Clone, PartialEq, Serialize)]
pub struct MaterialRow {
    /// As in the file.
    pub name: String,
    /// Triangles after import.
    pub triangles: u64,
    /// Their area that counts, nothing cut away, square metres: half of that of triangles that stand for one side of a
    /// leaf ([`crate::sheets`]).
    pub area_m2: f64,
    /// Name of the colour image.
    pub texture: Option<String>,
    /// "opaque", "cut at 0.5", or "a share" where alpha tells how much is there; with the separate alpha image where there is one.
    pub alpha: String,
    /// "leaf", "wood", "neither" or "undecided".
    pub class: &'static str,
    /// The rule that decided.
    pub rule: String,
}

/// All materials of `mesh` with the classes that `rules` give them; open ones say so.
///
/// # Errors
/// A pattern that is none or matches nothing.
pub fn table(mesh: &Mesh, rules: &ClassRules) -> Result<Vec<MaterialRow>, ImportError> {
    Ok(rows(mesh, &found(mesh, rules)?))
}

/// Triangles per material.
pub fn triangle_counts(mesh: &Mesh) -> Vec<u64> {
    let mut counts = vec![0; mesh.materials.len()];
    mesh.triangle_material.iter().for_each(|&material| counts[material as usize] += 1);
    counts
}

/// One row per material for what [`found`] found.
pub fn rows(mesh: &Mesh, found: &[Found]) -> Vec<MaterialRow> {
    let counts = triangle_counts(mesh);
    let mut areas_m2 = vec![0.0f64; mesh.materials.len()];
    for (number, (triangle, &material)) in mesh.triangles.iter().zip(&mesh.triangle_material).enumerate() {
        areas_m2[material as usize] += mesh.sheets.side(number).share()
            * area(triangle.map(|vertex| mesh.positions[vertex as usize].map(f64::from)));
    }
    let image_name = |image: u32| mesh.images.get(image as usize).map(|image| image.name.clone());
    let row = |index: usize| {
        let material = &mesh.materials[index];
        let mut alpha = match material.alpha_mode {
            AlphaMode::Opaque => "opaque".to_owned(),
            AlphaMode::Cut { cutoff } => format!("cut at {cutoff}"),
            AlphaMode::Blend => "a share".to_owned(),
        };
        if let Some(name) = material.alpha_texture.and_then(|texture| image_name(texture.image)) {
            alpha += &format!(" by {name}");
        }
        let (class, rule) = match &found[index] {
            Found::Class(Classified { class, rule }) => (class.name(), rule.clone()),
            Found::Unused => ("neither", "no triangles".to_owned()),
            Found::Open(why) => ("undecided", why.clone()),
        };
        MaterialRow {
            name: material.name.clone(),
            triangles: counts[index],
            area_m2: areas_m2[index],
            texture: material.color_texture.and_then(|texture| image_name(texture.image)),
            alpha,
            class,
            rule,
        }
    };
    (0..mesh.materials.len()).map(row).collect()
}

/// The rows as lines of text with aligned columns, a head line first.
pub fn text_table(rows: &[MaterialRow]) -> String {
    let head = ["material", "triangles", "area m^2", "texture", "alpha", "class", "rule"].map(str::to_owned);
    let mut lines = vec![head];
    lines.extend(rows.iter().map(|row| {
        let texture = row.texture.clone().unwrap_or_else(|| "-".to_owned());
        let area = format!("{:.4}", row.area_m2);
        let rule = row.rule.clone();
        [
            row.name.clone(),
            row.triangles.to_string(),
            area,
            texture,
            row.alpha.clone(),
            row.class.to_owned(),
            rule,
        ]
        .map(|cell| quoted(&cell))
    }));
    let width = |column: usize| lines.iter().map(|line| line[column].chars().count()).max().unwrap_or(0);
    let widths: Vec<usize> = (0..7).map(width).collect();
    let line = |cells: &[String; 7]| {
        let padded = cells.iter().zip(&widths).enumerate().map(|(column, (cell, &width))| match column {
            1 | 2 => format!("{cell:>width$}"),
            _ => format!("{cell:<width$}"),
        });
        padded.collect::<Vec<_>>().join("  ").trim_end().to_owned()
    };
    lines.iter().map(line).collect::<Vec<_>>().join("\n")
}
