//! Two containers to what differs between them: species, metadata, media and light, with numbers.
//!
//! Species are paired by name. What decides the verdict `equal` is content: which species and bases there
//! are, metadata, media and field values. How it is stored (codec, pages, compression, order of species)
//! is only listed. Without a tolerance every value must be the same; with one see [`Settings::tolerance`].

use std::collections::{BTreeMap, BTreeSet};

use flb_format::container::Species;
use flb_format::error::Place;
use flb_format::matter::{Class, TurbidMedium};
use flb_format::model::Model;
use flb_format::{Codec, Container, Field, Medium, Source, room};
use serde::Serialize;
use serde_json::Value;

use crate::InspectError;
use crate::diff::values::{ValueDiff, compare_values};

pub mod values;

/// Metadata that tell how a species was made, or sum up what its bases say.
const HISTORY: [&str; 6] = ["mean_light", "mesh_blake3", "settings", "sky_averages", "sources", "tool"];

/// Strictness of a comparison.
#[derive(Debug, Clone, Copy, PartialEq, Default)]
pub struct Settings {
    /// `None`: everything must be the same. `Some(t)`: a base or an array of the medium passes if its
    /// largest difference is at most `t` times the largest magnitude in A; and metadata that only tell how
    /// a species was made (`mesh_blake3`, `settings`, `sources`, `tool`) or sum up what its bases say
    /// (`mean_light`, `sky_averages`) are listed without deciding the verdict.
    pub tolerance: Option<f64>,
}

/// Values of A and B where they differ.
#[derive(Debug, Clone, PartialEq, Serialize)]
pub struct Change<T> {
    /// Value in the first file.
    pub a: T,
    /// Value in the second file.
    pub b: T,
}

/// The outcome.
#[derive(Debug, Clone, PartialEq, Serialize)]
pub struct Diff {
    /// The verdict.
    pub equal: bool,
    /// The tolerance that it was reached with.
    pub tolerance: Option<f64>,
    /// Format versions `major.minor`, if they differ; does not decide.
    pub format_version: Option<Change<String>>,
    /// Names of species that only the first file has.
    pub species_only_in_a: Vec<String>,
    /// Names of species that only the second file has.
    pub species_only_in_b: Vec<String>,
    /// Species of both files, by name.
    pub species: Vec<SpeciesDiff>,
    /// Notes for a reader of the numbers.
    pub notes: Vec<String>,
}

/// One species of both files.
#[derive(Debug, Clone, PartialEq, Serialize)]
pub struct SpeciesDiff {
    /// Name of the species.
    pub name: String,
    /// Whether nothing that decides the verdict differs.
    pub equal: bool,
    /// Metadata that differ, by key path.
    pub metadata: Vec<MetadataDiff>,
    /// Every array of the medium; empty if the lattices differ.
    pub medium: Vec<ArrayDiff>,
    /// Bases that only the first file has.
    pub bases_only_in_a: Vec<u8>,
    /// Bases that only the second file has.
    pub bases_only_in_b: Vec<u8>,
    /// Bases of both files; empty if the lattices or the bands differ.
    pub bases: Vec<BaseDiff>,
    /// Notes for a reader of the numbers.
    pub notes: Vec<String>,
}

/// One value of the metadata; an absent side is `None`.
#[derive(Debug, Clone, PartialEq, Serialize)]
pub struct MetadataDiff {
    /// Keys joined by `.`, list positions as `[2]`: `optics[0].leaf.g`.
    pub path: String,
    /// Value in the first file.
    pub a: Option<Value>,
    /// Value in the second file.
    pub b: Option<Value>,
    /// Whether the value takes part in the verdict.
    pub decides: bool,
}

/// One array of the medium.
#[derive(Debug, Clone, PartialEq, Serialize)]
pub struct ArrayDiff {
    /// `density`, `class`, `leaf_area_density`, `wood_area_density`; of the model `physical` also `leaf_extinction` and
    /// `wood_extinction`.
    pub name: &'static str,
    /// Whether the array passes.
    pub equal: bool,
    /// The numbers.
    #[serde(flatten)]
    pub values: ValueDiff,
}

/// One base.
#[derive(Debug, Clone, PartialEq, Serialize)]
pub struct BaseDiff {
    /// Item of the base: 0 sky or ambient, then those of the sun.
    pub base: u8,
    /// Whether the base passes.
    pub equal: bool,
    /// Names of the codecs, if they differ; does not decide.
    pub codec: Option<Change<&'static str>>,
    /// Thresholds, if they differ; does not decide.
    pub threshold: Option<Change<f32>>,
    /// The numbers over all bands.
    #[serde(flatten)]
    pub values: ValueDiff,
}

/// Compares two containers. One base of each is held in memory at a time.
///
/// # Errors
/// A [`FormatError`](flb_format::FormatError) if a page of either file cannot be read.
pub fn diff(
    (a, a_source): (&Container, &dyn Source),
    (b, b_source): (&Container, &dyn Source),
    settings: &Settings,
) -> Result<Diff, InspectError> {
    let (a_index, b_index) = (by_name(a), by_name(b));
    let only = |these: &BTreeMap<String, usize>, those: &BTreeMap<String, usize>| -> Vec<String> {
        these.keys().filter(|name| !those.contains_key(*name)).cloned().collect()
    };
    let mut species = Vec::new();
    for (name, &i) in &a_index {
        if let Some(&j) = b_index.get(name) {
            species.push(diff_species((a, a_source, i), (b, b_source, j), settings)?);
        }
    }
    let mut diff = Diff {
        equal: false,
        tolerance: settings.tolerance,
        format_version: change(version(a), version(b)),
        species_only_in_a: only(&a_index, &b_index),
        species_only_in_b: only(&b_index, &a_index),
        species,
        notes: Vec::new(),
    };
    let order = |c: &Container, other: &BTreeMap<String, usize>| -> Vec<String> {
        let names = c.species().iter().map(|s| s.meta.name.clone());
        names.filter(|name| other.contains_key(name)).collect()
    };
    if order(a, &b_index) != order(b, &a_index) {
        diff.notes.push("the species that both files have are in another order".to_owned());
    }
    diff.equal = diff.species_only_in_a.is_empty()
        && diff.species_only_in_b.is_empty()
        && diff.species.iter().all(|s| s.equal);
    Ok(diff)
}

fn diff_species(
    (a, a_source, i): (&Container, &dyn Source, usize),
    (b, b_source, j): (&Container, &dyn Source, usize),
    settings: &Settings,
) -> Result<SpeciesDiff, InspectError> {
    let (a_species, b_species) = (&a.species()[i], &b.species()[j]);
    let (a_bases, b_bases) = (base_numbers(a_species), base_numbers(b_species));
    let mut diff = SpeciesDiff {
        name: a_species.meta.name.clone(),
        equal: false,
        metadata: compare_metadata(
            &json(&a_species.meta),
            &json(&b_species.meta),
            settings.tolerance.is_some(),
        ),
        medium: Vec::new(),
        bases_only_in_a: a_bases.difference(&b_bases).copied().collect(),
        bases_only_in_b: b_bases.difference(&a_bases).copied().collect(),
        bases: Vec::new(),
        notes: Vec::new(),
    };
    let lattices = [a_species, b_species].map(|s| s.meta.grid.lattice);
    let bands = [a_species, b_species].map(|s| s.meta.band_count());
    if lattices[0] != lattices[1] {
        diff.notes.push(lattice_note(lattices, [a_species, b_species].map(|s| &s.meta.model)));
    } else {
        let (a_medium, b_medium) = (a.read_medium(a_source, i)?, b.read_medium(b_source, j)?);
        let classes_bytes = 2 * a_medium.class.len() * size_of::<f32>();
        room::ask(Place::file(0), "classes as numbers", classes_bytes as u64)?;
        diff.medium = compare_media(&a_medium, &b_medium, settings.tolerance);
        if a_species.extinction.is_some() && b_species.extinction.is_some() {
            let (a, b) = (a.read_turbid(a_source, i)?, b.read_turbid(b_source, j)?);
            diff.medium.extend(compare_extinctions(&a, &b, settings.tolerance));
        }
    }
    if let Some(note) = meaning_note([a_species, b_species]) {
        diff.notes.push(note);
    }
    if bands[0] != bands[1] {
        diff.notes.push(format!("{} and {} bands: no base can be compared", bands[0], bands[1]));
    }
    if lattices[0] == lattices[1] && bands[0] == bands[1] {
        // What a codec leaves out away from geometry is no difference to a renderer.
        let near = |s: &Species| s.bases.iter().any(|base| base.codec.is_near_geometry());
        let empty = match settings.tolerance {
            Some(_) if lattices[0] == lattices[1] && (near(a_species) || near(b_species)) => {
                diff.notes.push("bases are compared at the sites that hold matter: blocks away from geometry are left out".to_owned());
                let (a, b) = (a.read_medium(a_source, i)?, b.read_medium(b_source, j)?);
                empty_sites(&a, &b)
            }
            _ => Vec::new(),
        };
        for &base in a_bases.intersection(&b_bases) {
            let mut fields = (a.read_field(a_source, i, base)?, b.read_field(b_source, j, base)?);
            blank(&mut fields.0, &empty);
            blank(&mut fields.1, &empty);
            let storage = (storage(a_species, base), storage(b_species, base));
            diff.bases.push(compare_base(base, (&fields.0, &fields.1), storage, settings.tolerance));
        }
    }
    diff.equal = lattices[0] == lattices[1]
        && bands[0] == bands[1]
        && diff.bases_only_in_a.is_empty()
        && diff.bases_only_in_b.is_empty()
        && diff.metadata.iter().all(|m| !m.decides)
        && diff.medium.iter().all(|m| m.equal)
        && diff.bases.iter().all(|b| b.equal);
    Ok(diff)
}

/// Sites without matter in either medium.
fn empty_sites(a: &Medium, b: &Medium) -> Vec<usize> {
    let is_empty = |site: &usize| [a.class[*site], b.class[*site]] == [Class::Empty; 2];
    (0..a.class.len()).filter(is_empty).collect()
}

fn blank(field: &mut Field, sites: &[usize]) {
    let all = field.len() / field.bands as usize;
    for band in field.values_mut().chunks_exact_mut(all) {
        sites.iter().for_each(|site| band[*site] = 0.0);
    }
}

/// Why two lattices cannot be compared.
fn lattice_note([a, b]: [u32; 2], models: [&Model; 2]) -> String {
    let mut note = format!("lattices of {a} and {b} sites: media and bases cannot be compared");
    if let Some(bound) = models.into_iter().find(|model| model.is_bound_to_lattice()) {
        let name = bound.name();
        note += &format!(
            "; under the model {name:?} they are different physics too, as its optical depth grows with the lattice"
        );
    }
    note
}

/// Why bases of one number do not mean the same light.
fn meaning_note(species: [&Species; 2]) -> Option<String> {
    let [a, b] = species.map(|s| &s.meta.model);
    if a.name() != b.name() {
        return Some(format!(
            "models {:?} and {:?}: bases of one number are light in other units under other physics",
            a.name(),
            b.name()
        ));
    }
    let [(_, a), (_, b)] = [species[0].meta.physical()?, species[1].meta.physical()?];
    if a.suns != b.suns {
        return Some("the suns are stored in another way: bases of one number mean other light".to_owned());
    }
    let other = a.field != b.field;
    other.then(|| "one file's light holds the beam of the sun, the other's does not".to_owned())
}

fn compare_base(
    base: u8,
    (a, b): (&Field, &Field),
    (a_storage, b_storage): (Storage, Storage),
    tolerance: Option<f64>,
) -> BaseDiff {
    let values = compare_values(&a.values(), &b.values(), a.lattice);
    BaseDiff {
        base,
        equal: values.passes(tolerance),
        codec: change(a_storage.0.name(), b_storage.0.name()),
        threshold: change(a_storage.1, b_storage.1),
        values,
    }
}

fn compare_media(a: &Medium, b: &Medium, tolerance: Option<f64>) -> Vec<ArrayDiff> {
    let lattice = a.grid.lattice;
    let class = |m: &Medium| -> Vec<f32> { m.class.iter().map(|c| f32::from(*c as u8)).collect() };
    let arrays = [
        ("density", compare_values(&a.density, &b.density, lattice), tolerance),
        // A class has no size to be near in.
        ("class", compare_values(&class(a), &class(b), lattice), None),
        ("leaf_area_density", compare_values(&a.leaf_area_density, &b.leaf_area_density, lattice), tolerance),
        ("wood_area_density", compare_values(&a.wood_area_density, &b.wood_area_density, lattice), tolerance),
    ];
    arrays
        .into_iter()
        .map(|(name, values, tolerance)| ArrayDiff { name, equal: values.passes(tolerance), values })
        .collect()
}

fn compare_extinctions(a: &TurbidMedium, b: &TurbidMedium, tolerance: Option<f64>) -> [ArrayDiff; 2] {
    [("leaf_extinction", &a.leaf_per_m, &b.leaf_per_m), ("wood_extinction", &a.wood_per_m, &b.wood_per_m)]
        .map(|(name, a_values, b_values)| {
            let values = compare_values(a_values, b_values, a.grid.lattice);
            ArrayDiff { name, equal: values.passes(tolerance), values }
        })
}

/// Walks both trees of JSON and lists where they part.
fn compare_metadata(a: &Value, b: &Value, spare_history: bool) -> Vec<MetadataDiff> {
    let mut found = Vec::new();
    walk("", Some(a), Some(b), &mut found);
    for difference in &mut found {
        let first = difference.path.split(['.', '[']).next().unwrap_or_default();
        difference.decides = !(spare_history && HISTORY.contains(&first));
    }
    found
}

fn walk(path: &str, a: Option<&Value>, b: Option<&Value>, found: &mut Vec<MetadataDiff>) {
    match (a, b) {
        (Some(Value::Object(x)), Some(Value::Object(y))) => {
            for key in x.keys().chain(y.keys()).collect::<BTreeSet<_>>() {
                let inner = if path.is_empty() { key.clone() } else { format!("{path}.{key}") };
                walk(&inner, x.get(key), y.get(key), found);
            }
        }
        (Some(Value::Array(x)), Some(Value::Array(y))) => {
            for i in 0..x.len().max(y.len()) {
                walk(&format!("{path}[{i}]"), x.get(i), y.get(i), found);
            }
        }
        (a, b) if a != b => {
            found.push(MetadataDiff { path: path.to_owned(), a: a.cloned(), b: b.cloned(), decides: true });
        }
        _ => {}
    }
}

type Storage = (Codec, f32);

fn storage(species: &Species, base: u8) -> Storage {
    let entry = species.bases.iter().find(|e| e.base == base).expect("a base of this species");
    (entry.codec, entry.threshold)
}

fn by_name(container: &Container) -> BTreeMap<String, usize> {
    container.species().iter().enumerate().map(|(i, s)| (s.meta.name.clone(), i)).collect()
}

fn base_numbers(species: &Species) -> BTreeSet<u8> {
    species.bases.iter().map(|b| b.base).collect()
}

fn version(container: &Container) -> String {
    let (major, minor) = container.format_version();
    format!("{major}.{minor}")
}

fn change<T: PartialEq>(a: T, b: T) -> Option<Change<T>> {
    (a != b).then_some(Change { a, b })
}

fn json(meta: &flb_format::SpeciesMeta) -> Value {
    serde_json::to_value(meta).expect("metadata that were read from JSON go back to JSON")
}

#[cfg(test)]
mod tests;
