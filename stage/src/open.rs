//! Reading what a scene names: meshes and their light.

use std::path::Path;
use std::sync::Arc;

use flb_format::light::FieldKind;
use flb_render::Shading;
use flb_runtime::Library;
use flb_runtime::scene_light::SceneLight;
use flb_scene::scene::{Scene, SceneSpecies};
use flb_scene::{ClassRules, ClassedMesh, ImportSettings, Observer, PlantReader, SpeciesFile};

use crate::mesh_of_light::MeshOfLight;
use crate::plant::{PlantLight, ScenePlant};
use crate::read::read_classed;
use crate::{Stage, StageError};

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

impl PlantLight {
    /// Opens the light that a species of a scene names, in the bands that are shown; `None` where it names none.
    ///
    /// # Errors
    /// [`StageError`] with the file that it is about.
    pub fn open(species: &SceneSpecies, settings: &OpenSettings) -> Result<Option<PlantLight>, StageError> {
        let Some(file) = &species.light else { return Ok(None) };
        let library = Library::open(file)?;
        let number = scene_species(&library, species).map_err(|error| error.at(file))?;
        PlantLight::shown(library, number, &settings.bands).map(Some)
    }

    /// The light of a species, its bands in the place of red, green and blue, as [`OpenSettings::bands`].
    ///
    /// # Errors
    /// [`StageError::At`] the library: [`StageError::Bands`].
    pub fn shown(library: Library, species: usize, bands: &[String]) -> Result<PlantLight, StageError> {
        let file = library.path().to_owned();
        let library = library.with_picture_bands(species, bands);
        let library = library.map_err(|error| StageError::from(error).at(&file))?;
        Ok(PlantLight { library: Arc::new(library), species })
    }

    /// Tells the observer where shadow rays add what the fields hold already.
    pub fn tell_of_beam(&self, observer: &dyn Observer) {
        let meta = self.meta();
        if meta.physical().is_some_and(|(_, fields)| fields.field == FieldKind::Total) {
            observer.note(&format!(
                "warning: {}: the fields hold the sun's beam, which shadow rays add again: the sun counts twice",
                meta.name
            ));
        }
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
        ScenePlant::with_light(species, PlantLight::open(species, settings)?, settings, observer)
    }

    /// Reads the mesh that a species of a scene names, to be seen in a light, or without any.
    ///
    /// # Errors
    /// As [`Stage::open`].
    ///
    /// # Panics
    /// As [`ScenePlant::lit`].
    pub fn with_light(
        species: &SceneSpecies,
        light: Option<PlantLight>,
        settings: &OpenSettings,
        observer: &dyn Observer,
    ) -> Result<ScenePlant, StageError> {
        let mesh = mesh_file(species)?;
        let Some(light) = light else {
            let reader = scene_reader(species)?;
            let classed = read_classed(mesh, &reader, observer)?;
            return Ok(ScenePlant::unlit(classed, reader.settings));
        };
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
        let meta = light.meta();
        let MeshOfLight { mesh, read_as, matched } =
            MeshOfLight::read(mesh, meta, gltf_mesh, mesh_may_differ, observer)?;
        light.tell_of_beam(observer);
        let shading = Shading::of(meta);
        Ok(ScenePlant { mesh, read_as, shading, matched: Some(matched), light: Some(light) })
    }

    /// A plant that no light is baked for: the sun and the sky alone light it. `read_as` is how its mesh was read.
    pub fn unlit(mesh: ClassedMesh, read_as: ImportSettings) -> ScenePlant {
        ScenePlant { mesh, read_as, shading: Shading::UNLIT, light: None, matched: None }
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

/// Reader of the mesh of a scene's species, by the species file that the scene names.
///
/// # Errors
/// [`StageError::Import`] for a species file that cannot be used.
pub fn scene_reader(species: &SceneSpecies) -> Result<PlantReader, StageError> {
    let rules = species.species_file.as_deref().map(SpeciesFile::read).transpose()?;
    let settings = ImportSettings { gltf_mesh: species.gltf_mesh.clone(), ..ImportSettings::default() };
    Ok(PlantReader::new(rules, settings, ClassRules::default()))
}

/// The number of a species in its library: the one of a name, which the library has to have; without a name the only
/// one, or the one that `hint` names.
///
/// # Errors
/// [`StageError::NoSpecies`], [`StageError::ManySpecies`].
pub fn find_species(library: &Library, name: Option<&str>, hint: Option<&str>) -> Result<usize, StageError> {
    let all = library.container().species();
    let found = || all.iter().map(|one| one.meta.name.as_str()).collect::<Vec<_>>().join(", ");
    let find = |wanted: &str| library.find_species(wanted);
    match (name, all.len()) {
        (Some(wanted), _) => {
            let missing = || StageError::NoSpecies { wanted: wanted.to_owned(), found: found() };
            find(wanted).ok_or_else(missing)
        }
        (None, 1) => Ok(0),
        (None, count) => hint.and_then(find).ok_or_else(|| StageError::ManySpecies { count, found: found() }),
    }
}

/// The number of a scene's species in its library: by its name, unless it is the only one there.
///
/// # Errors
/// [`StageError::NoSpecies`].
pub fn scene_species(library: &Library, species: &SceneSpecies) -> Result<usize, StageError> {
    let name = &species.name;
    find_species(library, species.light_species.as_deref(), Some(name)).map_err(|error| match error {
        StageError::ManySpecies { found, .. } => StageError::NoSpecies { wanted: name.clone(), found },
        error => error,
    })
}
