//! One function from the plants of a scene to its light: every species by itself, then all of the scene.

use flb_format::bases::BaseSet;
use flb_format::light::{FieldKind, Light, SunBasis};
use flb_format::matter::{BandSurfaces, Surfaces, TurbidMedium};
use flb_format::scene_light::{PLANT, Role, plant_digest};
use flb_format::{Placement, SpeciesFields, provenance};
use flb_scene::Step;
use flb_scene::scene::{Scene, SceneSpecies, light_digest};
use flb_transport::ordinates::{Backend, Ordinates, OrdinatesSettings, OrdinatesSolution, rays_for};
use flb_transport::turbid::scatter;
use serde_json::{Value, json};

use super::light::{self, LightSource, converged, error_of};
use super::observer::BakeObserver;
use super::settings::unsolved_light;
use super::store::{self, Store};
use super::{BakeError, Work};
use crate::crown::Crown;
use crate::scene_light::{
    Entry, Ground, Plant, SceneLightError, Scenery, Stand, entry, luminance, stand_digest,
};

/// Settings of the bake of a scene's light. The default is that of `flb bake-scene`.
#[derive(Debug, Clone, PartialEq)]
pub struct SceneSettings {
    /// Sites along each edge of the lattice over the scene: a power of two, 16 to 256.
    pub lattice: u32,
    /// Dependence of the fields on the sun.
    pub suns: SunBasis,
    /// Directions that light is marched along.
    pub ordinates: Ordinates,
    /// Estimated relative L2 error at which a solve has converged, between 0 and 1.
    pub tolerance: f64,
    /// Passes after which a solve is given up, 1 or more.
    pub max_passes: u32,
}

impl Default for SceneSettings {
    fn default() -> SceneSettings {
        SceneSettings {
            lattice: 64,
            suns: SunBasis::Harmonics { degree: 1, single: false },
            ordinates: Ordinates::Lebedev50,
            tolerance: 2e-3,
            max_passes: 200,
        }
    }
}

impl SceneSettings {
    /// The solve on a lattice, of fields that hold this.
    pub fn solve(&self, lattice: u32, field: FieldKind) -> OrdinatesSettings {
        OrdinatesSettings {
            ordinates: self.ordinates,
            rays: rays_for(lattice, 1),
            parts: 1,
            suns: self.suns.clone(),
            bases: BaseSet::ALL,
            field,
            tolerance: self.tolerance,
            max_passes: self.max_passes,
            backend: Backend::Cpu,
        }
    }
}

/// A species of a scene, of which its own bake made the medium: as its library has it.
#[derive(Debug, Clone)]
pub struct ScenePlant {
    name: String,
    turbid: TurbidMedium,
    /// In luminance.
    surfaces: BandSurfaces,
    field: FieldKind,
    /// [`plant_digest`] of the medium and the surfaces in all bands.
    digest: String,
}

impl ScenePlant {
    /// Makes a species from a library of the model `physical`: its surfaces, and what its fields hold.
    ///
    /// # Errors
    /// [`SceneLightError::Bands`] unless red, green and blue are among the bands of the surfaces.
    pub fn new(
        name: &str,
        turbid: TurbidMedium,
        surfaces: &Surfaces,
        field: FieldKind,
    ) -> Result<ScenePlant, SceneLightError> {
        let digest = plant_digest(surfaces, field, &turbid);
        let surfaces = luminance(name, surfaces)?;
        Ok(ScenePlant { name: name.to_owned(), turbid, surfaces, field, digest })
    }

    /// Name of the species in the scene.
    pub fn name(&self) -> &str {
        &self.name
    }

    fn as_plant(&self) -> Plant<'_> {
        Plant { name: &self.name, turbid: &self.turbid, surfaces: self.surfaces.clone() }
    }
}

/// Plants and ground that a scene's light is baked of.
#[derive(Debug)]
pub struct PlantedScene {
    /// Species of the scene.
    pub plants: Vec<ScenePlant>,
    /// Placements of the plants; their species are places in `plants`.
    pub instances: Vec<Placement>,
    /// Ground on which the plants stand.
    pub ground: Option<Ground>,
    /// [`flb_scene::scene::light_digest`], for readers to tell it from another: 64 hexadecimal digits.
    pub digest: String,
}

impl PlantedScene {
    /// A scene whose ground and plants are read, these by `read`, but only where a species stands somewhere.
    ///
    /// # Errors
    /// [`SceneLightError::Ground`] for a height map that cannot be read; those of `read`.
    pub fn of<E: From<SceneLightError>>(
        scene: Scene,
        mut read: impl FnMut(&SceneSpecies) -> Result<ScenePlant, E>,
    ) -> Result<PlantedScene, E> {
        let digest = light_digest(&scene);
        let ground = scene.ground.as_ref().map(Ground::of).transpose()?;
        let mut instances = scene.instances;
        let mut stands = vec![false; scene.species.len()];
        instances.iter().for_each(|instance| stands[instance.species] = true);
        let (mut plants, mut numbers) = (Vec::new(), Vec::new());
        for (species, stands) in scene.species.iter().zip(stands) {
            numbers.push(plants.len());
            if stands {
                plants.push(read(species)?);
            }
        }
        instances.iter_mut().for_each(|instance| instance.species = numbers[instance.species]);
        Ok(PlantedScene { plants, instances, ground, digest })
    }

    /// Content of the fields of all species of the scene; [`FieldKind::Scattered`] without any.
    ///
    /// # Errors
    /// [`SceneLightError::Fields`] where they differ.
    pub fn field(&self) -> Result<FieldKind, SceneLightError> {
        let Some(first) = self.plants.first() else { return Ok(FieldKind::Scattered) };
        match self.plants.iter().find(|one| one.field != first.field) {
            None => Ok(first.field),
            Some(other) => Err(SceneLightError::Fields {
                first: (first.name.clone(), first.field),
                other: (other.name.clone(), other.field),
            }),
        }
    }
}

/// A scene's light before coding.
#[derive(Debug, Clone, PartialEq)]
pub struct BakedScene {
    /// The species alone, in the order of [`PlantedScene::plants`].
    pub species: Vec<BakedAlone>,
    /// The whole scene: its lattice lies in the scene's frame.
    pub stand: SpeciesFields,
    /// Sites of that lattice that are ground.
    pub ground_sites: usize,
    /// Largest root mean square error of a fit over the suns that were held out, of the mean total fluence.
    pub suns_rms: f64,
    /// Whether every solve met its tolerance. If not, the fields are what it had by then.
    pub converged: bool,
}

impl BakedScene {
    /// Entries of the library, in its order: the species, then the scene.
    pub fn entries(&self) -> impl Iterator<Item = &SpeciesFields> {
        self.species.iter().map(|alone| &alone.fields).chain([&self.stand])
    }
}

/// A species alone, on sites as coarse as the scene's.
#[derive(Debug, Clone, PartialEq)]
pub struct BakedAlone {
    /// Metadata, medium and fields.
    pub fields: SpeciesFields,
    /// Factor on the extinction of the species, so that it is as open as its fine medium.
    pub factor: f64,
    /// Whether the store had the species' light.
    pub cached: bool,
}

/// Bakes what the plants of a scene do to each other's light.
///
/// What it returns is what `flb_packer::encode_species` takes, entry by entry. The same scene and settings give the
/// same fields, whatever the number of threads and whatever the store held.
///
/// # Errors
/// [`BakeError::Scene`] for a scene that fits no lattice, without instances, or with a species without matter or with
/// fields of another kind; settings out of range; metadata that no store can hold; [`BakeError::Cancelled`].
///
/// # Examples
/// ```
/// use flb_baker::bake::{NoStore, PlantedScene, ScenePlant, SceneSettings, bake_scene};
/// use flb_scene::Unobserved;
/// use flb_format::light::FieldKind;
/// use flb_format::matter::{LeafAngles, TurbidMedium};
/// use flb_format::{Grid, Placement, Transform};
/// use flb_scene::leaf::knapp_carter;
///
/// // A bush: 8 sites of leaves along each edge of 1 m, in the middle of a lattice.
/// let grid = Grid { lattice: 16, origin_m: [-1.0; 3], spacing_m: 0.125 };
/// let is_bush = |site: usize| grid.site(site).iter().all(|c| (4..12).contains(c));
/// let leaf_per_m = (0..grid.sites()).map(|site| if is_bush(site) { 1.0 } else { 0.0 }).collect();
/// let wood_per_m = vec![0.0; grid.sites()];
/// let bush = TurbidMedium { grid, leaf_per_m, wood_per_m, angles: LeafAngles::spherical() };
///
/// // Two of them side by side.
/// let at = |x_m| Transform { position_m: [x_m, 0.0, 0.0], ..Transform::IDENTITY };
/// let stands = |x_m| Placement { species: 0, transform: at(x_m) };
/// let scene = PlantedScene {
///     plants: vec![ScenePlant::new("bush", bush, &knapp_carter(), FieldKind::Scattered)?],
///     instances: vec![stands(-0.6), stands(0.6)],
///     ground: None,
///     digest: "two bushes".to_owned(),
/// };
/// let settings = SceneSettings { lattice: 16, ..SceneSettings::default() };
/// let baked = bake_scene(&scene, &settings, &NoStore, &Unobserved)?;
/// assert!(baked.converged);
/// assert_eq!(baked.entries().count(), 2); // the bush alone, and the scene
/// # Ok::<(), flb_baker::bake::BakeError>(())
/// ```
pub fn bake_scene(
    scene: &PlantedScene,
    settings: &SceneSettings,
    store: &dyn Store,
    observer: &dyn BakeObserver,
) -> Result<BakedScene, BakeError> {
    let field = scene.field()?;
    let mut baking = Baking { settings, field, store, observer, suns_rms: 0.0, converged: true };
    let plants: Vec<Plant> = scene.plants.iter().map(ScenePlant::as_plant).collect();
    let (instances, ground) = (&scene.instances, scene.ground.as_ref());
    let scenery = baking.merge("", || Ok(Scenery::new(&plants, instances, ground, settings.lattice)?))?;
    let mut species = Vec::new();
    for (index, (plant, of)) in plants.iter().zip(&scene.plants).enumerate() {
        let crown = baking.merge(plant.name, || Ok(scenery.alone(index)?))?;
        species.push(baking.alone(plant, &crown, &of.digest)?);
    }
    let factors: Vec<f64> = species.iter().map(|alone| alone.factor).collect();
    let stand = baking.merge("", || Ok(scenery.stand(&factors)))?;
    let ground_sites = stand.is_ground.iter().filter(|is_ground| **is_ground).count();
    let stand = baking.stand(&stand, &scene.digest)?;
    let Baking { suns_rms, converged, .. } = baking;
    Ok(BakedScene { species, stand, ground_sites, suns_rms, converged })
}

/// A bake on its way.
struct Baking<'a> {
    settings: &'a SceneSettings,
    field: FieldKind,
    store: &'a dyn Store,
    observer: &'a dyn BakeObserver,
    /// The largest.
    suns_rms: f64,
    /// Whether all did.
    converged: bool,
}

impl Baking<'_> {
    fn work<'w>(&'w self, name: &'w str) -> Work<'w> {
        Work { store: self.store, observer: self.observer, species: name }
    }

    fn merge<T>(&self, name: &str, work: impl FnOnce() -> Result<T, BakeError>) -> Result<T, BakeError> {
        self.work(name).run(Step::Merge, |_| work())
    }

    fn alone(&mut self, plant: &Plant, crown: &Crown, digest: &str) -> Result<BakedAlone, BakeError> {
        let role = Role::Alone { species: plant.name.to_owned() };
        let digest_of_crown = store::digest(self.store, crown)?;
        let source = LightSource { turbid: &crown.turbid, digest: digest_of_crown, surroundings: None };
        let said = [("scene.factor", json!(crown.factor)), (PLANT, json!(digest))];
        let (fields, cached) = self.solve(&role, &source, &plant.surfaces, &[], &said)?;
        Ok(BakedAlone { fields, factor: crown.factor, cached })
    }

    fn stand(&mut self, stand: &Stand, digest: &str) -> Result<SpeciesFields, BakeError> {
        let role = Role::Scene { digest: digest.to_owned() };
        let source = LightSource {
            turbid: &stand.turbid,
            digest: stand_digest(stand),
            surroundings: Some(stand.surroundings()),
        };
        let said = [("scene.below", json!(f64::from(stand.below)))];
        Ok(self.solve(&role, &source, &stand.surfaces, &stand.is_ground, &said)?.0)
    }

    /// The fields of a medium in a role, with what is `said` of it in the file; and whether the store had them.
    fn solve(
        &mut self,
        role: &Role,
        source: &LightSource,
        surfaces: &BandSurfaces,
        is_ground: &[bool],
        said: &[(&str, Value)],
    ) -> Result<(SpeciesFields, bool), BakeError> {
        let settings = self.settings.solve(source.turbid.grid.lattice, self.field);
        let name = role.name();
        let work = self.work(&name);
        let (solution, cached) = light::solve(&work, source, &[scatter(surfaces)], &settings)?;
        self.converged &= converged(&solution);
        self.suns_rms = self.suns_rms.max(error_of(&solution).suns_rms);
        let solve = said_of_solve(&solution, &settings);
        let said = said.iter().chain(&solve).map(|(key, value)| ((*key).to_owned(), value.clone()));
        let light = Light { error: error_of(&solution), ..unsolved_light(&settings) };
        let Entry { meta, medium } = entry(role, source.turbid, is_ground, surfaces.clone(), light, said);
        let turbid = Some(source.turbid.clone());
        Ok((SpeciesFields { meta, medium, turbid, bases: solution.fields }, cached))
    }
}

fn said_of_solve(solution: &OrdinatesSolution, settings: &OrdinatesSettings) -> [(&'static str, Value); 4] {
    [
        (provenance::TOLERANCE.name(), json!(settings.tolerance)),
        (provenance::MAX_SWEEPS.name(), json!(settings.max_passes)),
        (provenance::PARTS.name(), json!(settings.parts)),
        (provenance::CONVERGED.name(), json!(converged(solution))),
    ]
}
