//! The materials of a mesh as a table: how much of the plant each makes up, and its class.

use glam::DVec3;
use serde::Serialize;

use crate::alpha::Coverage;
use crate::classify::{ClassRules, Classified, Found, found};
use crate::color::on_surface;
use crate::import::{ImportError, area, quoted};
use crate::mesh::{AlphaMode, Mesh, Part};

/// Row of one material.
#[derive(Debug, Clone, PartialEq, Serialize)]
pub struct MaterialRow {
    /// Name of the material in the file.
    pub name: String,
    /// Triangles after import.
    pub triangles: u64,
    /// Area of the triangles that counts, nothing cut away, square metres: half of that of triangles that stand for one
    /// side of a leaf ([`crate::sheets`]).
    pub area_m2: f64,
    /// Name of the colour image.
    pub texture: Option<String>,
    /// "opaque", "cut at 0.5", or "a share" where alpha tells how much is there; with the separate alpha image where
    /// there is one.
    pub alpha: String,
    /// Share of the area that alpha leaves, 0 to 1.
    pub left: f64,
    /// Mean linear R, G, B over what is left; `None` where nothing is.
    pub mean_colour: Option<[f64; 3]>,
    /// Labels of the nodes or groups that use it, at most 8; of an undecided material with what each is a part of.
    pub parts: Vec<String>,
    /// Number of parts.
    pub part_count: u64,
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

/// Makes one row per material of what [`found`] found.
pub fn rows(mesh: &Mesh, found: &[Found]) -> Vec<MaterialRow> {
    let counts = triangle_counts(mesh);
    let mut areas_m2 = vec![0.0f64; mesh.materials.len()];
    for (number, &material) in mesh.triangle_material.iter().enumerate() {
        areas_m2[material as usize] += mesh.sheets.side(number).share() * area(mesh.corners_m(number));
    }
    // What alpha cannot cut is refused when it is cut into voxels.
    let all = 0..mesh.materials.len();
    let coverage: Vec<Coverage> =
        all.map(|material| Coverage::of(mesh, material).unwrap_or(Coverage::Nothing)).collect();
    let mut left = vec![(0.0f64, DVec3::ZERO); mesh.materials.len()];
    on_surface(mesh, &coverage, |material, color, share| {
        left[material].0 += share;
        left[material].1 += color.as_dvec3() * share;
    });
    let mut parts: Vec<(u64, Vec<String>)> = vec![(0, Vec::new()); mesh.materials.len()];
    for part in &mesh.parts {
        for used in &part.uses {
            let (count, labels) = &mut parts[used.material as usize];
            *count += 1;
            if labels.len() < LISTED {
                let of = match (&found[used.material as usize], part.names.get(1..)) {
                    // Who has to decide sees the meshes, too.
                    (Found::Open(_), Some(of @ [_, ..])) => format!(" ({})", of.join(", ")),
                    _ => String::new(),
                };
                labels.push(part.label() + &of);
            }
        }
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
        let (left_m2, color) = left[index];
        let (part_count, parts) = parts[index].clone();
        MaterialRow {
            left: if areas_m2[index] > 0.0 { (left_m2 / areas_m2[index]).clamp(0.0, 1.0) } else { 0.0 },
            mean_colour: (left_m2 > 0.0).then(|| (color / left_m2).to_array()),
            parts,
            part_count,
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

/// Columns of the text.
const COLUMNS: usize = 10;

/// Parts that a row lists.
const LISTED: usize = 8;

/// The rows as lines of text with aligned columns, a head line first.
pub fn text_table(rows: &[MaterialRow]) -> String {
    let head =
        ["material", "triangles", "area m^2", "left", "colour", "texture", "alpha", "class", "rule", "parts"];
    let head = head.map(str::to_owned);
    let mut lines = vec![head];
    lines.extend(rows.iter().map(|row| {
        let texture = row.texture.clone().unwrap_or_else(|| "-".to_owned());
        let area = format!("{:.4}", row.area_m2);
        let rule = row.rule.clone();
        let left = format!("{:.1} %", 100.0 * row.left);
        let shares = |color: [f64; 3]| color.map(|share| format!("{share:.3}")).join(" ");
        let color = row.mean_colour.map_or_else(|| "-".to_owned(), shares);
        let more = if row.part_count > row.parts.len() as u64 { ", ..." } else { "" };
        let parts = format!("{}{more}", row.parts.join(", "));
        [
            row.name.clone(),
            row.triangles.to_string(),
            area,
            left,
            color,
            texture,
            row.alpha.clone(),
            row.class.to_owned(),
            rule,
            if parts.is_empty() { "-".to_owned() } else { parts },
        ]
        .map(|cell| quoted(&cell))
    }));
    let width = |column: usize| lines.iter().map(|line| line[column].chars().count()).max().unwrap_or(0);
    let widths: Vec<usize> = (0..COLUMNS).map(width).collect();
    let line = |cells: &[String; COLUMNS]| {
        let padded = cells.iter().zip(&widths).enumerate().map(|(column, (cell, &width))| match column {
            1..=3 => format!("{cell:>width$}"),
            _ => format!("{cell:<width$}"),
        });
        padded.collect::<Vec<_>>().join("  ").trim_end().to_owned()
    };
    lines.iter().map(line).collect::<Vec<_>>().join("\n")
}

/// Row of one node or group.
#[derive(Debug, Clone, PartialEq, Serialize)]
pub struct PartRow {
    /// The word that chooses it.
    pub node: String,
    /// The names of what it is a part of.
    pub of: Vec<String>,
    /// Triangles after import.
    pub triangles: u64,
    /// Area of the triangles, nothing cut away, square metres.
    pub area_m2: f64,
    /// Lowest and highest coordinates, model space, metres.
    pub bounds_m: [[f64; 3]; 2],
    /// Names of the part's materials.
    pub materials: Vec<String>,
}

/// The nodes or groups of a mesh, in the file's order.
pub fn parts(mesh: &Mesh) -> Vec<PartRow> {
    let row = |part: &Part| {
        let bounds = part.bounds_m()?;
        Some(PartRow {
            node: part.label(),
            of: part.names.iter().skip(1).cloned().collect(),
            triangles: part.uses.iter().map(|used| used.triangles).sum(),
            area_m2: part.uses.iter().map(|used| used.area_m2).sum(),
            bounds_m: [bounds.min, bounds.max],
            materials: part
                .uses
                .iter()
                .map(|used| mesh.materials[used.material as usize].name.clone())
                .collect(),
        })
    };
    mesh.parts.iter().filter_map(row).collect()
}
