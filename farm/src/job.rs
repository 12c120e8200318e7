//! A species of a manifest, ready to be baked: its settings, how its mesh is read, and the parts that its file depends
//! on. No mesh is imported for that.

use flb_baker::bake::BakeSettings;
use flb_packer::EncodeSettings;
use flb_scene::color::words;
use flb_scene::extents::{Mend, doubts_of};
use flb_scene::import::{TEXT_BYTES, read_text};
use flb_scene::{ClassRules, ImportError, ImportSettings, Observer, Plant, PlantReader, SpeciesFile};
use flb_stage::read::read_classed;

use crate::FarmError;
use crate::digests::Digests;
use crate::manifest::Entry;
use crate::parts::Parts;
use crate::recipe::Machine;

/// A species, ready to be baked.
#[derive(Debug, Clone)]
pub struct Job {
    /// The species as the manifest has it.
    pub entry: Entry,
    /// Reader of its mesh.
    pub reader: PlantReader,
    /// Settings of the bake.
    pub bake: BakeSettings,
    /// Settings of the coding.
    pub coding: EncodeSettings,
    /// Inputs and settings that its file depends on.
    pub parts: Parts,
    /// Key of the parts.
    pub key: String,
}

impl Job {
    /// Reads the species file, checks the settings, and finds the digests of all files that the mesh names.
    ///
    /// # Errors
    /// [`FarmError::Recipe`] for settings that cannot be; [`FarmError::Import`] for files that cannot be read and for a
    /// species file that is none.
    pub fn new(entry: &Entry, digests: &Digests) -> Result<Job, FarmError> {
        let recipe = |error| FarmError::Recipe { place: entry.place.clone(), error };
        let bake = entry.recipe.bake_settings(Machine::Cpu).map_err(recipe)?;
        let coding = entry.recipe.encode_settings().map_err(recipe)?;
        let (species, table) = species_file(entry)?;
        let settings = ImportSettings { gltf_mesh: entry.gltf_mesh.clone(), ..ImportSettings::default() };
        let mut parts = Parts::default();
        parts.add("flb", env!("CARGO_PKG_VERSION"));
        parts.add("name", entry.name.clone());
        let mesh = digests.of_mesh(&entry.mesh)?;
        let file_name =
            |path: &std::path::Path| path.file_name().unwrap_or_default().to_string_lossy().into_owned();
        parts.add(format!("mesh {}", file_name(&entry.mesh)), mesh.blake3);
        for file in &mesh.named {
            parts.add(format!("file {}", file_name(file)), digests.of_file(file)?);
        }
        if let Some(mesh) = &entry.gltf_mesh {
            parts.add("gltf_mesh", mesh.clone());
        }
        if let Some(species) = &species {
            parts.add(format!("species_file {}", species.file), species.blake3.clone());
        }
        let table =
            serde_json::to_value(&table).expect("TOML of a species file has no value that JSON lacks");
        parts.add_table("plant", &table);
        bake.parts().into_iter().for_each(|(name, value)| parts.add_table(&format!("bake.{name}"), &value));
        add_coding(&mut parts, &coding);
        let key = parts.key();
        let reader = PlantReader::new(species, settings, ClassRules::default());
        Ok(Job { entry: entry.clone(), reader, bake, coding, parts, key })
    }
}

/// A plant that was read, and what is odd about it.
#[derive(Debug, Clone)]
pub struct Read {
    /// The plant.
    pub plant: Plant,
    /// Doubts about it, what import repaired or ignored, and what is said of colours and was not followed.
    pub warnings: Vec<String>,
}

impl Job {
    /// Reads the mesh and classes its materials, as the bake does.
    ///
    /// # Errors
    /// [`FarmError::Stage`].
    pub fn read(&self, observer: &dyn Observer) -> Result<Read, FarmError> {
        let mesh = read_classed(&self.entry.mesh, &self.reader, observer)?;
        let doubted = doubts_of(&mesh, &self.reader);
        let doubted = doubted.iter().map(|doubt| Mend::Manifest.said(doubt));
        let mut warnings: Vec<String> = doubted.chain(mesh.mesh.warnings.iter().cloned()).collect();
        let plant = self.reader.plant(self.entry.name.clone(), mesh);
        if self.follows_colors() {
            warnings.extend(words::warnings(&plant));
        }
        Ok(Read { plant, warnings })
    }

    /// Whether the bake follows the colours of the mesh.
    pub(crate) fn follows_colors(&self) -> bool {
        self.entry.recipe.follows_colors()
    }

    /// Number of the bands of its light.
    pub fn bands(&self) -> usize {
        self.bake.bands(&self.reader)
    }
}

/// The species file with the keys that the manifest sets before it, and both as one table.
fn species_file(entry: &Entry) -> Result<(Option<SpeciesFile>, toml::Table), ImportError> {
    let Some(path) = &entry.species_file else {
        if entry.plant.is_empty() {
            return Ok((None, toml::Table::new()));
        }
        let text = entry.plant.to_string();
        // Its name is in the file: one with a line would make other bytes where lines move.
        let parsed = SpeciesFile::parse(&entry.place, &text)?;
        let species = SpeciesFile { blake3: digest(&text), file: "plant".to_owned(), ..parsed };
        return Ok((Some(species), entry.plant.clone()));
    };
    let (file, text) = read_text(path, TEXT_BYTES)?;
    let own = text.strip_prefix('\u{feff}').unwrap_or(&text);
    let species = SpeciesFile { blake3: digest(&text), ..SpeciesFile::parse(&file, own)? };
    let mut table: toml::Table =
        toml::from_str(own).expect("the text of a species file that was read is a table");
    if entry.plant.is_empty() {
        return Ok((Some(species), table));
    }
    table.extend(entry.plant.clone());
    let text = table.to_string();
    let species = SpeciesFile { blake3: digest(&text), ..SpeciesFile::parse(&file, &text)? };
    Ok((Some(species), table))
}

fn digest(text: &str) -> String {
    blake3::hash(text.as_bytes()).to_hex().to_string()
}

fn add_coding(parts: &mut Parts, coding: &EncodeSettings) {
    let EncodeSettings { codec, threshold, target, blocks, compress, page_bytes } = coding;
    parts.add("coding.codec", codec.name());
    parts.add("coding.threshold", *threshold);
    parts.add("coding.target", format!("{target:?}"));
    parts.add("coding.blocks", format!("{blocks:?}"));
    parts.add("coding.compress", *compress);
    parts.add("coding.page_bytes", *page_bytes);
}
