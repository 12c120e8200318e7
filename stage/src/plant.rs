//! A species of a scene with its mesh and its light.

use std::sync::Arc;

use flb_format::SpeciesMeta;
use flb_format::mesh::MeshMatch;
use flb_render::shading::Units;
use flb_render::{Shading, Species};
use flb_runtime::Library;
use flb_scene::{ClassedMesh, ImportSettings};

/// The light of a species: where it is.
#[derive(Clone)]
pub struct PlantLight {
    /// Library of the light. Species of one library share it.
    pub library: Arc<Library>,
    /// Index of the species in the library.
    pub species: usize,
}

impl PlantLight {
    /// Metadata of the species.
    pub fn meta(&self) -> &SpeciesMeta {
        &self.library.container().species()[self.species].meta
    }
}

/// A species of a scene, as its files have it.
pub struct ScenePlant {
    /// Mesh as it was baked.
    pub mesh: ClassedMesh,
    /// Units, axes and parts that the mesh was read by.
    pub read_as: ImportSettings,
    /// Shading by the light; [`Shading::UNLIT`] without any.
    pub shading: Shading,
    /// Light of the plant; `None` where no light is baked for it.
    pub light: Option<PlantLight>,
    /// Relation of the mesh to the light.
    pub matched: Option<MeshMatch>,
}

/// Puts one library in the place of those that are of one file and show the same bands.
pub(crate) fn share(plants: &mut [ScenePlant]) {
    let mut known: Vec<PlantLight> = Vec::new();
    for light in plants.iter_mut().filter_map(|plant| plant.light.as_mut()) {
        let bands =
            |library: &Library| library.container().chosen_bands(light.species).map(<[usize]>::to_vec);
        let is_same = |other: &&PlantLight| {
            let [one, other] = [&light.library, &other.library];
            let is_file = one.path() == other.path() && one.container().root() == other.container().root();
            is_file && bands(one) == bands(other)
        };
        match known.iter().find(is_same) {
            Some(other) => light.library = Arc::clone(&other.library),
            None => known.push(light.clone()),
        }
    }
}

impl ScenePlant {
    /// Units of a picture of plants.
    pub fn units(plants: &[ScenePlant]) -> Units {
        Units::of(plants.iter().map(|plant| plant.shading))
    }

    /// Returns the plant as a renderer takes it.
    pub fn as_species(&self) -> Species<'_> {
        Species { mesh: &self.mesh.mesh, classes: &self.mesh.classes, shading: self.shading }
    }

    /// Library of the plant's light, and the index of the species there.
    pub fn library(&self) -> Option<(&Library, usize)> {
        self.light.as_ref().map(|light| (&*light.library, light.species))
    }

    /// Whether its fields are harmonics, all of which each sun needs. Of others a stream brings what the sun needs
    /// alone.
    pub(crate) fn is_of_harmonics(&self) -> bool {
        self.light.as_ref().is_some_and(|light| light.meta().model.suns().has_near_beam())
    }

    /// Number of its bases; 0 without light.
    pub(crate) fn bases(&self) -> usize {
        self.library().map_or(0, |(library, index)| library.container().species()[index].bases.len())
    }

    /// Suns that its light depends on.
    #[cfg(feature = "gpu")]
    pub(crate) fn suns(&self) -> Option<&flb_format::light::SunBasis> {
        Some(self.light.as_ref()?.meta().model.suns())
    }

    /// The name of the model of its light.
    pub fn model(&self) -> Option<&'static str> {
        Some(self.light.as_ref()?.meta().model.name())
    }
}
