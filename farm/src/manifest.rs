//! The manifest of a library: which species there are, and how each is baked.
//!
//! ```toml
//! output = "library"             # folder of all that is built [default: library]
//! merge = true                   # also one file of all species, library.flb [default: true]
//! include = ["shrubs.toml"]      # other manifests, whose species are added
//!
//! [bake]                         # settings of all species of this file: flags of `flb bake`
//! quality = "standard"
//!
//! [[species]]
//! name = "oak"                   # default: the mesh's file name
//! mesh = "oak.glb"               # or a pattern, "trees/*.glb": a species for each file
//! species_file = "oak.toml"      # or "trees/{name}.toml"
//! gltf_mesh = "Oak"              # the one mesh of a glTF to read
//! plant = { leaf = ["leaves*"] } # keys of a species file, which go before those of `species_file`
//! bake = { lattice = 64 }        # before those of [bake]
//! budget = { bytes = 3e6, suns_error = 0.02, seconds = 60 }
//!
//! [[species.variant]]            # a species more, "oak-autumn", which says only what differs
//! name = "autumn"
//! plant = { leaf_model = { chlorophyll_ug_cm2 = 8.0, anthocyanins_ug_cm2 = 3.0 } }
//! ```

pub(crate) mod glob;
pub(crate) mod nearest;
mod raw;
mod source;
#[cfg(test)]
mod tests;

use std::collections::HashMap;
use std::path::{Path, PathBuf};

use flb_format::text::is_hidden;
use flb_scene::ImportError;
use flb_scene::import::read_text;
use flb_scene::plant::file_name;

use crate::recipe::Recipe;
use raw::{Raw, RawSpecies, RawVariant};
use source::{Checked, Source};

/// Bytes of a manifest.
pub const MAX_MANIFEST_BYTES: u64 = 64 << 20;
/// Species of a manifest and of all that it includes.
pub const MAX_SPECIES: usize = 1 << 20;
/// Manifests that include each other, one in the other.
const MAX_DEPTH: usize = 16;
/// Bytes of a species' name.
pub(crate) const MAX_NAME_BYTES: usize = 200;
/// Characters that file names cannot have everywhere.
pub(crate) const NOT_IN_NAMES: &str = "/\\:*?\"<>|";
/// Folder of results, unless the manifest names one.
pub const OUTPUT: &str = "library";

/// Species to bake, and where to.
#[derive(Debug, Clone, PartialEq)]
pub struct Manifest {
    /// File that it was read from.
    pub path: PathBuf,
    /// Folder of all that is built.
    pub output: PathBuf,
    /// Whether one file of all species is written.
    pub merge: bool,
    /// Species, in the order of the text; no two of one name.
    pub species: Vec<Entry>,
}

/// A species of a manifest.
#[derive(Debug, Clone, PartialEq)]
pub struct Entry {
    /// Name of the species, and of its file.
    pub name: String,
    /// Mesh file.
    pub mesh: PathBuf,
    /// The one mesh of a glTF to read.
    pub gltf_mesh: Option<String>,
    /// Species file.
    pub species_file: Option<PathBuf>,
    /// Keys of a species file that go before those of `species_file`.
    pub plant: toml::Table,
    /// Settings of its bake.
    pub recipe: Recipe,
    /// Limits of what it may cost.
    pub budget: Budget,
    /// Name of the species that it is a variant of.
    pub variant_of: Option<String>,
    /// Place in a manifest, for messages: "library.toml: line 12".
    pub place: String,
}

/// Limits of what a species may cost; `None`: none.
#[derive(Debug, Clone, Copy, PartialEq, Default, serde::Deserialize)]
#[serde(deny_unknown_fields)]
pub struct Budget {
    /// Bytes of its file.
    pub bytes: Option<f64>,
    /// Error of the fit over suns, of the mean total fluence.
    pub suns_error: Option<f64>,
    /// Seconds of its bake.
    pub seconds: Option<f64>,
}

impl Manifest {
    /// Reads a manifest, those that it includes, and the names of the files that its patterns match. Meshes and species
    /// files are not read.
    ///
    /// # Errors
    /// [`ImportError::Io`]; [`ImportError::Limit`]; [`ImportError::Syntax`] with line and column for what is no TOML,
    /// of another type, or an unknown key; [`ImportError::Malformed`] with the line for a manifest that includes itself
    /// or is included twice, two species of one name, a name that no file can have, a pattern without a file, a variant
    /// that changes nothing, a budget that is no positive number.
    pub fn read(path: &Path) -> Result<Manifest, ImportError> {
        let mut reader = Reader::default();
        let root = reader.read(path, None)?;
        if reader.species.is_empty() {
            return Err(root.malformed(0, "species", "none", "one [[species]] or more"));
        }
        let folder = path.parent().unwrap_or(Path::new(""));
        Ok(Manifest {
            path: path.to_owned(),
            output: folder.join(reader.output.unwrap_or_else(|| OUTPUT.into())),
            merge: reader.merge.unwrap_or(true),
            species: reader.species,
        })
    }

    /// Checks the text of a manifest by itself: its keys, their types, words and numbers. `file` is for messages.
    ///
    /// # Errors
    /// [`ImportError::Syntax`].
    pub fn check_text(file: &str, text: &str) -> Result<(), ImportError> {
        let source = Source::new(file.to_owned(), text.to_owned());
        toml::from_str::<Raw>(text).map(drop).map_err(|error| source.syntax(&error))
    }

    /// The species of a name.
    pub fn find(&self, name: &str) -> Option<&Entry> {
        self.species.iter().find(|species| species.name == name)
    }
}

#[derive(Default)]
struct Reader {
    /// Of the outermost manifest.
    output: Option<PathBuf>,
    merge: Option<bool>,
    species: Vec<Entry>,
    /// Place of the species of each name, in lower case: names are file names, and some systems do not tell case apart.
    by_name: HashMap<String, String>,
    /// Manifests that were read, and those that are being read.
    included: Vec<PathBuf>,
    open: Vec<PathBuf>,
}

impl Reader {
    /// Adds the species of a file. `by` is the place that includes it.
    fn read(&mut self, path: &Path, by: Option<(&Source, usize)>) -> Checked<Source> {
        let (_, text) = read_text(path, MAX_MANIFEST_BYTES)?;
        let text = text.strip_prefix('\u{feff}').map(str::to_owned).unwrap_or(text);
        let source = Source::new(path.display().to_string(), text);
        let real = path.canonicalize().unwrap_or_else(|_| path.to_owned());
        if let Some((by, at)) = by {
            let found = |what: &str| format!("{:?}, {what}", path.display().to_string());
            if self.open.contains(&real) {
                return Err(by.malformed(at, "include", &found("which includes this file"), "no circle"));
            }
            if self.included.contains(&real) {
                return Err(by.malformed(at, "include", &found("a second time"), "each manifest once"));
            }
            if self.open.len() >= MAX_DEPTH {
                let found = format!("{} manifests, one in the other", self.open.len() + 1);
                return Err(by.malformed(at, "include", &found, &format!("{MAX_DEPTH} at most")));
            }
        }
        let raw: Raw = toml::from_str(&source.text).map_err(|error| source.syntax(&error))?;
        let folder = path.parent().unwrap_or(Path::new(""));
        if by.is_none() {
            (self.output, self.merge) = (raw.output.clone(), raw.merge);
        }
        self.open.push(real.clone());
        for include in &raw.include {
            let at = include.span().start;
            self.read(&folder.join(include.get_ref()), Some((&source, at))).map_err(|error| match error {
                ImportError::Io { path, source: reason } => {
                    let found = format!("{:?}, which cannot be read: {reason}", path.display().to_string());
                    source.malformed(at, "include", &found, "a manifest")
                }
                error => error,
            })?;
        }
        self.open.pop();
        self.included.push(real);
        for species in &raw.species {
            self.add(&source, folder, species.span().start, species.get_ref(), &raw.bake)?;
        }
        Ok(source)
    }

    /// Adds a species, or those of a pattern, with their variants.
    fn add(
        &mut self,
        source: &Source,
        folder: &Path,
        at: usize,
        raw: &RawSpecies,
        bake: &Recipe,
    ) -> Checked<()> {
        let mesh_at = raw.mesh.span().start;
        let meshes = match glob::is_pattern(raw.mesh.get_ref()) {
            false => vec![folder.join(raw.mesh.get_ref())],
            true => glob::files(folder, raw.mesh.get_ref())
                .map_err(|error| source.malformed(mesh_at, "species.mesh", &error, "a pattern of files"))?,
        };
        if meshes.is_empty() {
            let found = format!("{:?}, which no file matches", raw.mesh.get_ref());
            return Err(source.malformed(
                mesh_at,
                "species.mesh",
                &found,
                "a pattern of files that are there",
            ));
        }
        if raw.name.is_some() && meshes.len() > 1 {
            let found = format!("a name for {} meshes", meshes.len());
            return Err(source.malformed(at, "species.name", &found, "none: each is named after its file"));
        }
        for mesh in meshes {
            let name = raw.name.clone().or_else(|| file_name(&mesh)).unwrap_or_default();
            let recipe = raw.bake.over(bake);
            let entry = Entry {
                species_file: raw
                    .species_file
                    .as_ref()
                    .map(|file| folder.join(file.replace("{name}", &name))),
                name,
                mesh,
                gltf_mesh: raw.gltf_mesh.clone(),
                plant: raw.plant.clone(),
                recipe,
                budget: raw.budget,
                variant_of: None,
                place: source.place(at),
            };
            check_budget(source, at, &entry.budget)?;
            self.push(source, at, entry.clone())?;
            for variant in &raw.variant {
                let at = variant.span().start;
                let variant = vary(&entry, variant.get_ref(), folder, source.place(at));
                check_budget(source, at, &variant.budget)?;
                if is_same(&entry, &variant) {
                    let found = format!("a variant that changes nothing of {:?}", entry.name);
                    return Err(source.malformed(
                        at,
                        "species.variant",
                        &found,
                        "a mesh, a key of `plant` or of `bake`",
                    ));
                }
                self.push(source, at, variant)?;
            }
        }
        Ok(())
    }

    fn push(&mut self, source: &Source, at: usize, entry: Entry) -> Checked<()> {
        let name = &entry.name;
        let is_fit = !name.trim().is_empty() && !name.starts_with('.') && name.len() <= MAX_NAME_BYTES;
        if !is_fit || name.chars().any(|c| is_hidden(c) || NOT_IN_NAMES.contains(c)) {
            let expected = "a printable name that a file can have: no / \\ : * ? \" < > |, no dot in front, 200 bytes at most";
            return Err(source.malformed(at, "species.name", &format!("{name:?}"), expected));
        }
        if self.species.len() >= MAX_SPECIES {
            let (file, what) = (source.file.clone(), "species".to_owned());
            let found = self.species.len() as u64 + 1;
            return Err(ImportError::Limit { file, what, found, limit: MAX_SPECIES as u64 });
        }
        if let Some(other) = self.by_name.insert(name.to_lowercase(), entry.place.clone()) {
            let found = format!("{name:?} again ({other} has it, too)");
            return Err(source.malformed(
                at,
                "species.name",
                &found,
                "each name once, in upper or lower case",
            ));
        }
        self.species.push(entry);
        Ok(())
    }
}

/// What a variant makes of its species.
fn vary(base: &Entry, raw: &RawVariant, folder: &Path, place: String) -> Entry {
    let mut plant = base.plant.clone();
    plant.extend(raw.plant.clone());
    let name = format!("{}-{}", base.name, raw.name);
    let path = |file: &String| folder.join(file.replace("{name}", &base.name));
    Entry {
        mesh: raw.mesh.as_ref().map_or_else(|| base.mesh.clone(), path),
        gltf_mesh: raw.gltf_mesh.clone().or_else(|| base.gltf_mesh.clone()),
        species_file: raw.species_file.as_ref().map(path).or_else(|| base.species_file.clone()),
        plant,
        recipe: raw.bake.over(&base.recipe),
        budget: Budget {
            bytes: raw.budget.bytes.or(base.budget.bytes),
            suns_error: raw.budget.suns_error.or(base.budget.suns_error),
            seconds: raw.budget.seconds.or(base.budget.seconds),
        },
        variant_of: Some(base.name.clone()),
        name,
        place,
    }
}

/// Whether two species are baked alike.
fn is_same(a: &Entry, b: &Entry) -> bool {
    let of = |entry: &Entry| {
        let Entry { mesh, gltf_mesh, species_file, plant, recipe, .. } = entry.clone();
        (mesh, gltf_mesh, species_file, plant, recipe)
    };
    of(a) == of(b)
}

fn check_budget(source: &Source, at: usize, budget: &Budget) -> Checked<()> {
    let Budget { bytes, suns_error, seconds } = budget;
    for (key, value) in [("bytes", bytes), ("suns_error", suns_error), ("seconds", seconds)] {
        if let Some(value) = value.filter(|value| !(value.is_finite() && *value > 0.0)) {
            let place = format!("species.budget.{key}");
            return Err(source.malformed(at, &place, &value.to_string(), "a number above 0"));
        }
    }
    Ok(())
}
