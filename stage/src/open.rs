//! Reading what a scene names: meshes and their light.

use std::path::Path;
use std::sync::Arc;

use flb_format::FieldKind;
use flb_render::Shading;
use flb_runtime::Library;
use flb_runtime::scene_light::SceneLight;
use flb_scene::import::{ImportError, import};
use flb_scene::scene::{Scene, SceneSpecies};
use flb_scene::{ClassRules, ClassedMesh, ImportSettings, Mesh, Observer, PlantReader, SpeciesFile};

use crate::{MeshOfLight, PlantLight, ScenePlant, Stage, StageError};

/// Settings by which a scene is opened.
#[derive(Debug, Clone, Default)]
pub struct OpenSettings {
    /// Names of the bands that are shown as red, green and blue, or of one that is shown as grey; empty: R, G and B.
    pub bands: Vec<String>,
    /// Whether a mesh may be another than that which its light was baked for.
    pub mesh_may_differ: bool,
}

impl Stage {
    /// Reads the meshes, the libraries and the scene light that a scene names.
    ///
    /// # Errors
    /// [`StageError`] with the file that it is about.
    pub fn open(scene: Scene, settings: &OpenSettings, observer: &dyn Observer) -> Result<Stage, StageError> {
        let read = |species| ScenePlant::read(species, settings, observer);
        let plants = scene.species.iter().map(read).collect::<Result<Vec<_>, _>>()?;
        let light = scene.light.clone();
        let stage = Stage::new(scene, plants)?;
        let Some(file) = light else { return Ok(stage) };
        let light = SceneLight::load(&Library::open(&file)?)?;
        stage.with_scene_light(light).map_err(|error| error.at(&file))
    }
}

impl ScenePlant {
    /// Reads the mesh and the light that a species of a scene names.
    ///
    /// # Errors
    /// As [`Stage::open`].
    pub fn read(
        species: &SceneSpecies,
        settings: &OpenSettings,
        observer: &dyn Observer,
    ) -> Result<ScenePlant, StageError> {
        let mesh = mesh_file(species)?;
        let Some(file) = &species.light else {
            return Ok(ScenePlant::unlit(read_unlit(mesh, species, observer).map_err(|e| e.at(mesh))?));
        };
        let library = Library::open(file)?;
        let number = find_species(&library, species).map_err(|error| error.at(file))?;
        let library = library
            .with_picture_bands(number, &settings.bands)
            .map_err(|error| StageError::from(error).at(file))?;
        let light = PlantLight { library: Arc::new(library), species: number };
        let gltf_mesh = species.gltf_mesh.as_deref();
        ScenePlant::lit(mesh, light, gltf_mesh, settings.mesh_may_differ, observer)
    }

    /// A plant with its light, whose first three bands are shown.
    ///
    /// # Errors
    /// As [`MeshOfLight::read`].
    ///
    /// # Panics
    /// If the library has no such species, or that has fewer than three bands.
    pub fn lit(
        mesh: &Path,
        light: PlantLight,
        gltf_mesh: Option<&str>,
        mesh_may_differ: bool,
        observer: &dyn Observer,
    ) -> Result<ScenePlant, StageError> {
        let meta = &light.library.container().species()[light.species].meta;
        let MeshOfLight { mesh, matched } =
            MeshOfLight::read(mesh, meta, gltf_mesh, mesh_may_differ, observer)?;
        if meta.physical().is_some_and(|(_, fields)| fields.field == FieldKind::Total) {
            observer.note(&format!(
                "warning: {}: the fields hold the sun's beam, which shadow rays add again: the sun counts twice",
                meta.name
            ));
        }
        Ok(ScenePlant { mesh, shading: Shading::of(meta), matched: Some(matched), light: Some(light) })
    }

    /// A plant that no light is baked for: the sun and the sky alone light it.
    pub fn unlit(mesh: ClassedMesh) -> ScenePlant {
        ScenePlant { mesh, shading: Shading::UNLIT, light: None, matched: None }
    }
}

/// The mesh file of a species, which a picture needs.
///
/// # Errors
/// [`StageError::NoMesh`] where there is none, or a library in its place.
pub fn mesh_file(species: &SceneSpecies) -> Result<&Path, StageError> {
    let is_library = |path: &Path| path.extension().is_some_and(|e| e.eq_ignore_ascii_case("flb"));
    let file = species.file.as_deref().filter(|file| !is_library(file));
    file.ok_or_else(|| StageError::NoMesh { species: species.name.clone() })
}

/// The mesh of a file; the observer hears what import repaired or ignored.
///
/// # Errors
/// [`ImportError`].
pub fn read_mesh(
    path: &Path,
    settings: &ImportSettings,
    observer: &dyn Observer,
) -> Result<Mesh, ImportError> {
    let mesh = import(path, settings)?;
    // A warning names its file, which may be a texture; the folder is what it lacks.
    let told = mesh.warnings.iter().map(|warning| format!("warning: {warning}"));
    for note in told.chain(mesh.notes.iter().cloned()) {
        observer.note(&format!("{note} (reading {})", path.display()));
    }
    Ok(mesh)
}

fn read_unlit(
    file: &Path,
    species: &SceneSpecies,
    observer: &dyn Observer,
) -> Result<ClassedMesh, StageError> {
    let rules = species.species_file.as_deref().map(SpeciesFile::read).transpose()?;
    let settings = ImportSettings { gltf_mesh: species.gltf_mesh.clone(), ..ImportSettings::default() };
    let reader = PlantReader::new(rules, settings, ClassRules::default());
    let (mesh, decisions) = reader.class(read_mesh(file, &reader.settings, observer)?)?;
    for (material, decision) in mesh.mesh.materials.iter().zip(&decisions) {
        let (name, class) = (&material.name, decision.class.name());
        observer.note(&format!("{}: material {name:?} is {class}: {}", file.display(), decision.rule));
    }
    for note in mesh.mesh.sheets.notes() {
        observer.note(&format!("{}: {note}", file.display()));
    }
    Ok(mesh)
}

/// The number of a scene's species in its library: by its name, unless it is the only one there.
///
/// # Errors
/// [`StageError::NoSpecies`].
pub fn find_species(library: &Library, species: &SceneSpecies) -> Result<usize, StageError> {
    let all = library.container().species();
    let wanted = species.light_species.as_deref().unwrap_or(&species.name);
    match library.find_species(wanted) {
        Some(number) => Ok(number),
        None if all.len() == 1 && species.light_species.is_none() => Ok(0),
        None => Err(StageError::NoSpecies {
            wanted: wanted.to_owned(),
            found: all.iter().map(|one| one.meta.name.as_str()).collect::<Vec<_>>().join(", "),
        }),
    }
}
