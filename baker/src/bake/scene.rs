//! One function from the plants of a scene to its light: every species by itself, then all of the scene.

use flb_format::bases::BaseSet;
use flb_format::light::{FieldKind, Light, SunBasis};
use flb_format::matter::{BandOptics, BandSurfaces, Optics, Surfaces, TurbidMedium};
use flb_format::scene_light::{PLANT, Role, paper_plant_digest, plant_digest};
use flb_format::{Medium, Placement, SpeciesFields, provenance};
use flb_scene::Step;
use flb_scene::scene::{Scene, SceneSpecies, light_digest};
use flb_transport::ordinates::{Backend, Ordinates, OrdinatesSettings, OrdinatesSolution, rays_for};
use flb_transport::turbid::scatter;
use serde_json::{Value, json};

use super::key::hex;
use super::light::{self, LightSource, converged, error_of};
use super::observer::BakeObserver;
use super::settings::unsolved_light;
use super::store::{self, Store};
use super::{BakeError, Key, Work};
use crate::crown::Crown;
use crate::scene_light::{
    Entry, Ground, Plant, SceneLightError, Scenery, Stand, entry, extinction, luminance, matter_digest,
    mean_optics, optics_in_luminance, stand_digest,
};

mod lattice;

/// Settings of the bake of a scene's light. The default is that of `flb bake-scene`.
#[derive(Debug, Clone, PartialEq)]
pub struct SceneSettings {
    /// Sites along each edge of the lattice over the scene: a power of two, 16 to 256.
    pub lattice: u32,
    /// Dependence of the fields on the sun. Plants of the model `paper` have their own.
    pub suns: SunBasis,
    /// Directions that light is marched along. Plants of the model `paper` have their own.
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
            suns: SunBasis::Harmonics { degree: 1, single: false, leaning: true },
            ordinates: Ordinates::Lebedev50,
            tolerance: 2e-3,
            max_passes: 200,
        }
    }
}

impl SceneSettings {
    /// Fields of an entry.
    pub fn items(&self, transport: SceneTransport) -> usize {
        match transport {
            SceneTransport::Ordinates(field) => self.solve(self.lattice, field).items().len(),
            SceneTransport::Lattice => BaseSet::ALL.len(),
        }
    }

    /// The solve by ordinates on a lattice, of fields that hold this.
    pub fn solve(&self, lattice: u32, field: FieldKind) -> OrdinatesSettings {
        OrdinatesSettings {
            ordinates: self.ordinates,
            rays: rays_for(lattice, 1),
            parts: 1,
            suns: self.suns.clone().of_field(field),
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
    scatters: Scatters,
    /// Digest of the medium and what it scatters in all bands.
    digest: String,
}

/// What a plant does to light, in luminance.
#[derive(Debug, Clone)]
enum Scatters {
    /// As surfaces do, with fields of a kind.
    Surfaces(BandSurfaces, FieldKind),
    /// By collisions on a lattice, as the papers have it.
    Collisions(BandOptics),
}

/// How light is carried through a scene: all of its species are of one model.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum SceneTransport {
    /// By ordinates, into fields of a kind (model `physical`).
    Ordinates(FieldKind),
    /// By the papers' lattice (model `paper`).
    Lattice,
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
        let scatters = Scatters::Surfaces(luminance(name, surfaces)?, field);
        Ok(ScenePlant { name: name.to_owned(), turbid, scatters, digest })
    }

    /// Makes a species from a library of the model `paper`: its medium and its optics.
    ///
    /// # Errors
    /// [`SceneLightError::Bands`] unless red, green and blue are among the bands of the optics.
    pub fn of_paper(name: &str, medium: &Medium, optics: &Optics) -> Result<ScenePlant, SceneLightError> {
        let digest = paper_plant_digest(optics, medium);
        let scatters = Scatters::Collisions(optics_in_luminance(name, optics)?);
        Ok(ScenePlant { name: name.to_owned(), turbid: extinction(medium), scatters, digest })
    }

    /// Name of the species in the scene.
    pub fn name(&self) -> &str {
        &self.name
    }

    fn as_plant(&self) -> Plant<'_> {
        Plant { name: &self.name, turbid: &self.turbid }
    }

    fn transport(&self) -> SceneTransport {
        match self.scatters {
            Scatters::Surfaces(_, field) => SceneTransport::Ordinates(field),
            Scatters::Collisions(_) => SceneTransport::Lattice,
        }
    }

    fn surfaces(&self) -> Option<&BandSurfaces> {
        match &self.scatters {
            Scatters::Surfaces(surfaces, _) => Some(surfaces),
            Scatters::Collisions(_) => None,
        }
    }

    fn optics(&self) -> Option<&BandOptics> {
        match &self.scatters {
            Scatters::Surfaces(..) => None,
            Scatters::Collisions(optics) => Some(optics),
        }
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

    /// How light is carried among all species of the scene; by ordinates without any.
    ///
    /// # Errors
    /// [`SceneLightError::Fields`] where the content of their fields differs, [`SceneLightError::Models`] where their
    /// models do.
    pub fn transport(&self) -> Result<SceneTransport, SceneLightError> {
        use SceneTransport::{Lattice, Ordinates};
        let Some(first) = self.plants.first() else { return Ok(Ordinates(FieldKind::Scattered)) };
        let all = first.transport();
        let Some(other) = self.plants.iter().find(|one| one.transport() != all) else { return Ok(all) };
        let [first_name, other_name] = [first, other].map(|one| one.name.clone());
        Err(match (all, other.transport()) {
            (Ordinates(field), Ordinates(others)) => {
                SceneLightError::Fields { first: (first_name, field), other: (other_name, others) }
            }
            (Lattice, _) => SceneLightError::Models { paper: first_name, physical: other_name },
            (_, Lattice) => SceneLightError::Models { paper: other_name, physical: first_name },
        })
    }

    /// Whether the light of the scene has its ground: that of the model `paper` knows plants alone.
    pub fn is_ground_left_out(&self) -> bool {
        self.ground.is_some() && self.transport().is_ok_and(|all| all == SceneTransport::Lattice)
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
    /// Largest root mean square error of a fit over the suns that were held out, of the mean total fluence; `None` of
    /// the model `paper`, which fits none.
    pub suns_rms: Option<f64>,
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
    /// Edge of a site, in widths of the crown: the longer of its extents along x and z. Sites of a tenth of a width are
    /// fine enough; within a site nothing is known of what neighbours do.
    pub site_widths: f64,
    /// Whether the store had the species' light.
    pub cached: bool,
}

/// Bakes what the plants of a scene do to each other's light.
///
/// What it returns is what `flb_packer::encode_species` takes, entry by entry. The same scene and settings give the
/// same fields, whatever the number of threads and whatever the store held.
///
/// # Errors
/// [`BakeError::Scene`] for a scene that fits no lattice, without instances, or with a species without matter, with
/// fields of another kind or of the other model; settings out of range; metadata that no store can hold;
/// [`BakeError::Cancelled`].
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
    let transport = scene.transport()?;
    let mut baking = Baking { settings, store, observer, suns_rms: None, converged: true };
    let plants: Vec<Plant> = scene.plants.iter().map(ScenePlant::as_plant).collect();
    let ground = scene.ground.as_ref().filter(|_| transport != SceneTransport::Lattice);
    let scenery =
        baking.merge("", || Ok(Scenery::new(&plants, &scene.instances, ground, settings.lattice)?))?;
    let mut species = Vec::new();
    for (index, plant) in scene.plants.iter().enumerate() {
        let crown = baking.crown(plant, &scenery, index)?;
        let (fields, cached) = baking.alone(plant, &crown)?;
        let site_widths = crown.turbid.grid.spacing_m / width_m(&plant.turbid);
        species.push(BakedAlone { fields, factor: crown.factor, site_widths, cached });
    }
    let factors: Vec<f64> = species.iter().map(|alone| alone.factor).collect();
    let (stand, ground_sites) = match transport {
        SceneTransport::Ordinates(field) => {
            let surfaces: Vec<BandSurfaces> =
                scene.plants.iter().filter_map(ScenePlant::surfaces).cloned().collect();
            let stand = baking.merge("", || Ok(scenery.stand(&factors, &surfaces)))?;
            let ground_sites = stand.is_ground.iter().filter(|is_ground| **is_ground).count();
            (baking.stand(&stand, field, &scene.digest)?, ground_sites)
        }
        SceneTransport::Lattice => {
            let turbid = baking.merge("", || Ok(scenery.matter(&factors)))?;
            let optics: Vec<BandOptics> =
                scene.plants.iter().filter_map(ScenePlant::optics).cloned().collect();
            let optics = mean_optics(&optics, &scenery.areas_m2(&factors));
            let role = Role::Scene { digest: scene.digest.clone() };
            (baking.solve_lattice(&role, &turbid, optics, &[])?.0, 0)
        }
    };
    let Baking { suns_rms, converged, .. } = baking;
    Ok(BakedScene { species, stand, ground_sites, suns_rms, converged })
}

/// Width of a plant's matter, metres.
fn width_m(turbid: &TurbidMedium) -> f64 {
    let [low, high] = turbid.grid.extent_m(&turbid.sites()).unwrap_or([[0.0; 3]; 2]);
    (high[0] - low[0]).max(high[2] - low[2])
}

/// A bake on its way.
struct Baking<'a> {
    settings: &'a SceneSettings,
    store: &'a dyn Store,
    observer: &'a dyn BakeObserver,
    /// The largest.
    suns_rms: Option<f64>,
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

    /// The matter of a species alone, as open as the plant is: measured or taken from the store. It stays as it is when
    /// plants of the scene move.
    fn crown(&self, plant: &ScenePlant, scenery: &Scenery, species: usize) -> Result<Crown, BakeError> {
        self.merge(&plant.name, || {
            let coarse = scenery.coarse(species)?;
            let grid = coarse.grid;
            let digest = hex(matter_digest(&coarse));
            let key = Key::new("alone").with("plant", json!(plant.digest)).with("coarse", digest);
            let make = || Ok(scenery.as_open(species, coarse));
            let check = |crown: &Crown| store::fits("grid", &crown.turbid.grid, &grid);
            store::reuse_or_make(&self.work(&plant.name), Step::Merge, &key, check, make)
        })
    }

    /// The fields of a species alone, and whether the store had them.
    fn alone(&mut self, plant: &ScenePlant, crown: &Crown) -> Result<(SpeciesFields, bool), BakeError> {
        let role = Role::Alone { species: plant.name.clone() };
        let said = [("scene.factor", json!(crown.factor)), (PLANT, json!(plant.digest))];
        match &plant.scatters {
            Scatters::Collisions(optics) => self.solve_lattice(&role, &crown.turbid, optics.clone(), &said),
            Scatters::Surfaces(surfaces, field) => {
                let digest = store::digest(self.store, crown)?;
                let source = LightSource { turbid: &crown.turbid, digest, surroundings: None };
                self.solve(&role, &source, surfaces, *field, &[], &said)
            }
        }
    }

    fn stand(&mut self, stand: &Stand, field: FieldKind, digest: &str) -> Result<SpeciesFields, BakeError> {
        let role = Role::Scene { digest: digest.to_owned() };
        let source = LightSource {
            turbid: &stand.turbid,
            digest: stand_digest(stand),
            surroundings: Some(stand.surroundings()),
        };
        let said = [("scene.below", json!(f64::from(stand.below)))];
        Ok(self.solve(&role, &source, &stand.surfaces, field, &stand.is_ground, &said)?.0)
    }

    /// The fields of a medium in a role, with what is `said` of it in the file; and whether the store had them.
    fn solve(
        &mut self,
        role: &Role,
        source: &LightSource,
        surfaces: &BandSurfaces,
        field: FieldKind,
        is_ground: &[bool],
        said: &[(&str, Value)],
    ) -> Result<(SpeciesFields, bool), BakeError> {
        let settings = self.settings.solve(source.turbid.grid.lattice, field);
        let name = role.name();
        let work = self.work(&name);
        let (solution, cached) = light::solve(&work, source, &[scatter(surfaces)], &settings)?;
        self.converged &= converged(&solution);
        let suns_rms = error_of(&solution).suns_rms;
        self.suns_rms = Some(self.suns_rms.map_or(suns_rms, |largest| largest.max(suns_rms)));
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
