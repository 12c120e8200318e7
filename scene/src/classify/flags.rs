//! The names by which a user can say what undecided materials are.

use super::Found;
use crate::mesh::Mesh;

/// Parts of a material that are listed.
const LISTED: usize = 8;
/// Letters of a prefix that says what several parts have in common, at least.
const MIN_PREFIX: usize = 3;

/// Patterns of the materials that no rule decides, each once: their names, or `NAME@PART` where a material of the same
/// name is known.
pub(super) fn undecided(mesh: &Mesh, found: &[Found]) -> Vec<String> {
    let is_known_elsewhere = |name: &str| {
        let mut all = mesh.materials.iter().zip(found);
        all.any(|(material, found)| material.name == name && matches!(found, Found::Class(_)))
    };
    let mut patterns: Vec<String> = Vec::new();
    for (index, material) in mesh.materials.iter().enumerate() {
        if !matches!(found[index], Found::Open(_)) {
            continue;
        }
        let of_it = match is_known_elsewhere(&material.name) {
            true => of_parts(mesh, index),
            false => Vec::new(),
        };
        let of_it = if of_it.is_empty() { vec![material.name.clone()] } else { of_it };
        of_it.into_iter().for_each(|pattern| {
            if !patterns.contains(&pattern) {
                patterns.push(pattern);
            }
        });
    }
    patterns
}

/// `NAME@PART` of the parts that use a material, or of what their names begin with and no others do.
fn of_parts(mesh: &Mesh, index: usize) -> Vec<String> {
    let name = &mesh.materials[index].name;
    let uses = |part: &crate::mesh::Part| part.uses.iter().any(|used| used.material as usize == index);
    let (own, others): (Vec<_>, Vec<_>) = mesh.parts.iter().partition(|part| uses(part));
    let labels: Vec<String> = own.iter().map(|part| part.label()).collect();
    let common = labels.iter().skip(1).fold(labels.first().cloned().unwrap_or_default(), |common, label| {
        common.chars().zip(label.chars()).take_while(|(a, b)| a == b).map(|(a, _)| a).collect()
    });
    let is_theirs = others.iter().flat_map(|part| &part.names).any(|name| name.starts_with(&common));
    match labels.len() > 1 && common.chars().count() >= MIN_PREFIX && !is_theirs {
        true => vec![format!("{name}@{common}*")],
        false => labels.iter().take(LISTED).map(|label| format!("{name}@{label}")).collect(),
    }
}
