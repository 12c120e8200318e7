//! One function from a plant to the light fields of its species.
//!
//! ```text
//! physical Plant -voxelise-> Occupancy -downsample-> Medium -measure_crown-> TurbidMedium -ordinates-> Field per basis
//! paper    Plant -voxelise-> Occupancy -downsample-> Medium -lattice::solve-> Field per basis
//! ```
//!
//! Every stage can be called by itself; [`bake`] calls them in order, keeps their results in a [`Store`], and tells a
//! [`BakeObserver`] how far it is. What it returns is what `flb_packer::encode_species` takes. [`bake_scene`] does the
//! same for what the plants of a scene do to each other's light.
//!
//! The same plant and settings give the same fields, whatever the number of threads and whatever the store held.

mod error;
mod job;
mod judge;
pub mod key;
mod light;
mod observer;
mod paper;
mod physical;
mod received;
#[cfg(test)]
pub(crate) use received::{on_matter, received_by};
mod scene;
mod settings;
mod store;
#[cfg(test)]
mod tests;

use flb_format::progress::Progress;
use flb_format::{Field, SpeciesFields};
use flb_scene::{Plant, Step};
use flb_transport::ordinates::{OrdinatesSettings, OrdinatesSolution, SiteAlbedos};
use flb_transport::turbid::BandScatter;

pub use error::BakeError;
pub use key::Key;
pub use light::{LightSource, converged, error_of};
pub use observer::{BakeObserver, Event, SolveSummary, base_list, why_whole};
pub use paper::{paper_solves, solver_name};
pub use scene::{
    BakedAlone, BakedScene, PlantedScene, ScenePlant, SceneSettings, SceneTransport, bake_scene,
};
pub use settings::{
    BakeSettings, ModelSettings, PaperSettings, PhysicalSettings, SunChoice, Wanted, unsolved_light,
};
pub use store::{NoStore, Store, digest};

use job::Start;

/// A species before coding.
#[derive(Debug, Clone, PartialEq)]
pub struct Baked {
    /// Metadata, medium and fields.
    pub fields: SpeciesFields,
    /// Whether every solve met its tolerance. If not, the fields are what it had by then.
    pub converged: bool,
    /// Bands that the plant could have had.
    pub bands: usize,
    /// Solves that made the fields, and those of a bake of all bases and bands.
    pub solves: [u32; 2],
    /// Light of the medium, of a `physical` bake that was asked for it.
    pub cloud: Option<Cloud>,
}

/// Light that the solver found in the medium and Monte Carlo judges, in place of what surfaces receive.
#[derive(Debug, Clone, PartialEq)]
pub struct Cloud {
    /// Bases of the mean fluence of each site.
    pub fields: Vec<(u8, Field)>,
    /// Albedos that the sites scattered with, `[band]`.
    pub albedos: Vec<SiteAlbedos>,
}

/// Bakes a plant.
///
/// Takes the plant by value. Its mesh is held until the light on its surfaces is known.
///
/// # Errors
/// Settings out of range; a mesh without leaf and wood, or of no usable size; bands that the plant does not have;
/// metadata that no file can hold; [`BakeError::Cancelled`].
///
/// # Examples
/// ```
/// use flb_baker::bake::{BakeSettings, NoStore, bake};
/// use flb_format::Quality;
/// use flb_scene::{MaterialClass, Mesh, Plant, Unobserved, mesh::Material};
///
/// // A leaf: the unit square, two triangles.
/// let mesh = Mesh {
///     positions: vec![[0.0, 0.0, 0.0], [1.0, 0.0, 0.0], [1.0, 1.0, 0.0], [0.0, 1.0, 0.0]],
///     normals: vec![[0.0, 0.0, 1.0]; 4],
///     uvs: vec![[0.0, 0.0]; 4],
///     triangles: vec![[0, 1, 2], [0, 2, 3]],
///     triangle_material: vec![0, 0],
///     materials: vec![Material::opaque("leaf")],
///     ..Mesh::default()
/// };
/// let plant = Plant::new("card", mesh, vec![MaterialClass::Leaf]);
/// let settings = BakeSettings { lattice: 16, voxels: 64, ..BakeSettings::of(Quality::Draft) };
/// let baked = bake(plant, &settings, &NoStore, &Unobserved)?;
/// assert!(baked.converged);
/// assert_eq!(baked.fields.bases.len(), 8); // what `sh1s` needs
/// # Ok::<(), flb_baker::bake::BakeError>(())
/// ```
pub fn bake(
    plant: Plant,
    settings: &BakeSettings,
    store: &dyn Store,
    observer: &dyn BakeObserver,
) -> Result<Baked, BakeError> {
    let name = plant.name.clone();
    let work = Work { store, observer, species: &name };
    let start = Start::new(plant, settings, store);
    match &settings.model {
        ModelSettings::Physical(physical) => physical::bake(start, settings, physical, &work),
        ModelSettings::Paper(paper) => paper::bake(start, settings, paper, &work),
    }
}

/// The light of a medium that was made elsewhere, of a scene for one: solved, or taken from the store, which is given
/// only what converged. The flag says which. `name` is what the observer is told.
///
/// # Errors
/// As [`flb_transport::ordinates::solve_among`]; [`BakeError::Cancelled`].
pub fn solve_light(
    name: &str,
    source: &LightSource,
    bands: &[BandScatter],
    settings: &OrdinatesSettings,
    store: &dyn Store,
    observer: &dyn BakeObserver,
) -> Result<(OrdinatesSolution, bool), BakeError> {
    let work = Work { store, observer, species: name };
    light::solve(&work, source, bands, settings)
}

/// What every stage is given.
struct Work<'a> {
    store: &'a dyn Store,
    observer: &'a dyn BakeObserver,
    species: &'a str,
}

impl Work<'_> {
    /// Runs a step, unless the observer says stop before.
    fn run<T>(
        &self,
        step: Step,
        work: impl FnOnce(&Progress<'_>) -> Result<T, BakeError>,
    ) -> Result<T, BakeError> {
        match self.observer.is_cancelled() {
            true => Err(BakeError::Cancelled),
            false => step.run(self.observer, self.species, work),
        }
    }

    fn hear(&self, event: Event) {
        self.observer.hear(&event);
    }
}
