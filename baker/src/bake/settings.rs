//! How to bake: by one word, or setting by setting.

use flb_format::bases::BaseSet;
use flb_format::light::{FieldKind, Light, LightError, SunBasis};
use flb_format::matter::LeafAngles;
use flb_format::sample::SOLID_OFFSET;
use flb_format::{Purpose, Quality};
use flb_scene::PlantReader;
use flb_scene::extents::Walls;
use flb_transport::lattice::{DEFAULT_MAX_SWEEPS, SolveSettings, SolverKind, Steps};
use flb_transport::ordinates::{Backend, Ordinates, OrdinatesSettings, rays_for};

use serde_json::{Value, json};

use super::key;
use crate::crown::LeafAngleChoice;
use crate::plan::{Plan, PlanError};

/// Settings of a bake of a species. The default is that of `flb bake`.
#[derive(Debug, Clone, PartialEq)]
pub struct BakeSettings {
    /// Sites along each edge: a power of two, 16 to 256.
    pub lattice: u32,
    /// Voxels along each edge of the fine grid: a multiple of `lattice`, up to
    /// [`MAX_VOXELS`](crate::voxelise::MAX_VOXELS).
    pub voxels: u32,
    /// Take every texel of a leaf card for present. A plant may say so, too.
    pub ignore_alpha: bool,
    /// Bases and bands that are wanted.
    pub wanted: Wanted,
    /// Light transport model, and how it is solved.
    pub model: ModelSettings,
}

/// Bases and bands that a scene needs; all of them by default.
#[derive(Debug, Clone, PartialEq)]
pub struct Wanted {
    /// Bases to keep. Where the suns are harmonics or a list of directions, all are baked.
    pub bases: BaseSet,
    /// Names of bands to keep; `None`: all.
    pub bands: Option<Vec<String>>,
    /// Reason why the rest is left out, for the file.
    pub reason: String,
}

impl Default for Wanted {
    fn default() -> Wanted {
        Wanted { bases: BaseSet::ALL, bands: None, reason: String::new() }
    }
}

impl Wanted {
    /// Bases and bands that a plan wants of a species.
    ///
    /// # Errors
    /// A species that is not in the plan.
    pub fn by_plan(plan: &Plan, species: &str) -> Result<Wanted, PlanError> {
        let share = plan.share(species)?;
        Ok(Wanted { bases: share.bases, bands: plan.bands.clone(), reason: plan.reason.clone() })
    }

    /// Places of the wanted bands among `names`, in their order, and the names of the others.
    pub(super) fn choose(
        &self,
        names: &[&str],
        species: &str,
    ) -> Result<(Vec<usize>, Vec<String>), PlanError> {
        let Some(wanted) = &self.bands else {
            return Ok(((0..names.len()).collect(), Vec::new()));
        };
        if let Some(unknown) = wanted.iter().find(|name| !names.contains(&name.as_str())) {
            let known = names.iter().map(|name| (*name).to_owned()).collect();
            return Err(PlanError::UnknownBand { name: unknown.clone(), species: species.to_owned(), known });
        }
        let is_wanted = |place: &usize| wanted.iter().any(|name| name == names[*place]);
        let (kept, others): (Vec<usize>, Vec<usize>) = (0..names.len()).partition(is_wanted);
        Ok((kept, others.into_iter().map(|place| names[place].to_owned()).collect()))
    }
}

/// Settings of a model.
#[derive(Debug, Clone, PartialEq)]
pub enum ModelSettings {
    /// Extinction measured on the mesh, surfaces from data, discrete ordinates. The default.
    Physical(PhysicalSettings),
    /// Steele and Geist's lattice-Boltzmann model.
    Paper(PaperSettings),
}

impl ModelSettings {
    /// Settings of a quality, of its model: the default one but for [`Quality::Papers`].
    pub fn of(quality: Quality) -> ModelSettings {
        match quality {
            Quality::Papers => ModelSettings::Paper(PaperSettings::of(quality)),
            _ => ModelSettings::Physical(PhysicalSettings::of(quality)),
        }
    }

    /// Has a bake return what it solved as well, where the model can: [`Baked::cloud`](super::Baked::cloud).
    pub fn keep_cloud(&mut self) {
        if let ModelSettings::Physical(physical) = self {
            physical.keep_cloud = true;
        }
    }
}

impl BakeSettings {
    /// All settings that change what a bake of all bases and bands makes, each under its name. Which GPU solves, if one
    /// does, is not among them.
    pub fn parts(&self) -> Vec<(&'static str, Value)> {
        let BakeSettings { lattice, voxels, ignore_alpha, wanted: _, model } = self;
        let mut parts = vec![
            ("lattice", json!(lattice)),
            ("voxels", json!(voxels)),
            ("ignore_alpha", json!(ignore_alpha)),
        ];
        match model {
            ModelSettings::Physical(physical) => parts.extend(physical.parts()),
            ModelSettings::Paper(paper) => parts.extend(paper.parts(*lattice)),
        }
        parts
    }

    /// Number of fields of a bake of all bases, of a plant with these walls.
    pub fn items(&self, walls: Walls) -> u32 {
        match &self.model {
            ModelSettings::Physical(physical) => physical.suns.basis(walls).items().into(),
            ModelSettings::Paper(_) => SunBasis::Lattice18.items().into(),
        }
    }

    /// Number of directions that light is solved in; 0 for the model `paper`, which has its own.
    pub fn ordinates(&self) -> u32 {
        match &self.model {
            ModelSettings::Physical(physical) => physical.ordinates.count(),
            ModelSettings::Paper(_) => 0,
        }
    }

    /// Number of rays through a site along an ordinate, in all parts of it; 1 for the model `paper`, which has none.
    pub fn rays(&self) -> u32 {
        match &self.model {
            ModelSettings::Physical(physical) => {
                let solve = physical.solve(self.lattice, Walls::None, BaseSet::ALL);
                solve.rays.pow(2) * solve.parts.pow(3)
            }
            ModelSettings::Paper(_) => 1,
        }
    }

    /// Number of bands of a plant that is read so.
    pub fn bands(&self, reader: &PlantReader) -> usize {
        match &self.model {
            ModelSettings::Physical(_) => reader.surfaces().bands.len(),
            ModelSettings::Paper(_) => reader.optics().bands.len(),
        }
    }
}

/// Choice of how fields depend on the sun.
#[derive(Debug, Clone, PartialEq)]
pub enum SunChoice {
    /// One basis for every plant.
    Fixed(SunBasis),
    /// A basis for every plant but those whose leaves walls enclose. These get [`SunBasis::Lattice18`], as light
    /// through a narrow mouth changes more sharply with the sun than harmonics of a low degree do.
    ByWalls(SunBasis),
}

impl SunChoice {
    /// Basis for a plant with these walls.
    pub fn basis(&self, walls: Walls) -> SunBasis {
        match (self, walls) {
            (SunChoice::ByWalls(_), Walls::Enclosing(_)) => SunBasis::Lattice18,
            (SunChoice::Fixed(basis) | SunChoice::ByWalls(basis), _) => basis.clone(),
        }
    }
}

/// Settings of the solve of the `physical` model.
#[derive(Debug, Clone, PartialEq)]
pub struct PhysicalSettings {
    /// Dependence of the fields on the sun.
    pub suns: SunChoice,
    /// Directions that light is marched along.
    pub ordinates: Ordinates,
    /// Rays per site edge along each of them, 1 to 8; `None`: as many as the lattice needs ([`rays_for`]).
    pub rays: Option<u32>,
    /// Parts that a site is cut into along each edge, 1 or 2.
    pub parts: u32,
    /// Content of a field of the sun's light.
    pub field: FieldKind,
    /// Assumed distribution of leaf inclinations.
    pub leaf_angles: LeafAngleChoice,
    /// Estimated relative L2 error at which a solve has converged.
    pub tolerance: f64,
    /// Passes after which a solve is given up.
    pub max_passes: u32,
    /// Suns, 0 to 22, that are traced by Monte Carlo in the same medium to judge the fields by.
    pub monte_carlo_suns: usize,
    /// Machine that solves.
    pub backend: Backend,
    /// Whether the bake returns what it solved as well: [`Baked::cloud`](super::Baked::cloud).
    pub keep_cloud: bool,
}

/// Settings of the solve of the `paper` model.
#[derive(Debug, Clone, PartialEq)]
pub struct PaperSettings {
    /// Solver to use.
    pub solver: SolverKind,
    /// A fixed number of iterations, in place of a tolerance.
    pub steps: Option<Steps>,
    /// Estimated relative L2 error at which a solve has converged.
    pub tolerance: f64,
    /// Sweeps after which a solve is given up.
    pub max_sweeps: u32,
}

impl Default for BakeSettings {
    fn default() -> BakeSettings {
        BakeSettings::of(Quality::default())
    }
}

impl BakeSettings {
    /// Settings of a quality, with the `physical` model, but that [`Quality::Papers`] is of the papers'. Its coding is
    /// `flb_packer::EncodeSettings::of`.
    pub fn of(quality: Quality) -> BakeSettings {
        BakeSettings {
            lattice: if quality == Quality::Draft { 32 } else { 128 },
            // Light on the mesh is the same with more: `flb judge`.
            voxels: if quality == Quality::Draft { 512 } else { 1024 },
            ignore_alpha: quality == Quality::Papers,
            wanted: Wanted::default(),
            model: ModelSettings::of(quality),
        }
    }

    /// Settings of a purpose: those of its quality, on the lattice that `docs/measurements/uses.md` finds for it. Its
    /// coding is that of [`Purpose::quality`].
    pub fn of_purpose(purpose: Purpose) -> BakeSettings {
        let quality = BakeSettings::of(purpose.quality());
        match purpose {
            Purpose::Games => BakeSettings { lattice: 64, ..quality },
            Purpose::Stills | Purpose::Film => quality,
        }
    }
}

impl Default for PhysicalSettings {
    fn default() -> PhysicalSettings {
        PhysicalSettings::of(Quality::default())
    }
}

impl PhysicalSettings {
    /// Settings of a quality.
    pub fn of(quality: Quality) -> PhysicalSettings {
        // The light scattered once brings more than harmonics do.
        let degree = match quality {
            Quality::Draft => 1,
            Quality::Standard | Quality::Papers => 2,
            Quality::Fine | Quality::Reference => 3,
        };
        PhysicalSettings {
            suns: SunChoice::ByWalls(SunBasis::Harmonics { degree, single: true, leaning: true }),
            ordinates: if quality == Quality::Draft { Ordinates::Lebedev50 } else { Ordinates::Lebedev110 },
            rays: None,
            parts: if quality == Quality::Reference { 2 } else { 1 },
            field: FieldKind::Scattered,
            leaf_angles: LeafAngleChoice::Measured,
            tolerance: match quality {
                Quality::Draft => 1e-2,
                Quality::Standard | Quality::Fine | Quality::Papers => 2e-3,
                Quality::Reference => 1e-3,
            },
            max_passes: DEFAULT_MAX_SWEEPS,
            monte_carlo_suns: 0,
            backend: Backend::Cpu,
            keep_cloud: false,
        }
    }

    /// The solve on a lattice of a plant with these walls, of these bases.
    pub fn solve(&self, lattice: u32, walls: Walls, bases: BaseSet) -> OrdinatesSettings {
        OrdinatesSettings {
            ordinates: self.ordinates,
            rays: self.rays.unwrap_or_else(|| rays_for(lattice, self.parts)),
            parts: self.parts,
            suns: self.suns.basis(walls).of_field(self.field),
            bases,
            field: self.field,
            tolerance: self.tolerance,
            max_passes: self.max_passes,
            backend: self.backend,
        }
    }
}

impl PhysicalSettings {
    fn parts(&self) -> Vec<(&'static str, Value)> {
        let PhysicalSettings {
            suns, ordinates, rays, parts, field, leaf_angles, tolerance, max_passes, ..
        } = self;
        let PhysicalSettings { monte_carlo_suns, backend, keep_cloud: _, .. } = self;
        let (is_by_walls, suns) = match suns {
            SunChoice::Fixed(suns) => (false, suns),
            SunChoice::ByWalls(suns) => (true, suns),
        };
        vec![
            ("model", json!("physical")),
            ("suns", key::of_suns(suns)),
            ("suns_by_walls", json!(is_by_walls)),
            ("ordinates", json!(ordinates.count())),
            ("rays", json!(rays)),
            ("parts", json!(parts)),
            ("field", json!(field.name())),
            ("leaf_angles", json!(leaf_angles.name())),
            ("tolerance", json!(tolerance)),
            ("max_passes", json!(max_passes)),
            ("monte_carlo_suns", json!(monte_carlo_suns)),
            ("gpu", json!(*backend != Backend::Cpu)),
        ]
    }
}

impl Default for PaperSettings {
    fn default() -> PaperSettings {
        PaperSettings::of(Quality::default())
    }
}

impl PaperSettings {
    /// Settings of a quality.
    pub fn of(quality: Quality) -> PaperSettings {
        let tolerance = match quality {
            Quality::Draft => 1e-3,
            Quality::Standard | Quality::Fine | Quality::Papers => 1e-4,
            Quality::Reference => 1e-5,
        };
        let is_papers = quality == Quality::Papers;
        PaperSettings {
            solver: if is_papers { SolverKind::Explicit } else { SolverKind::Sweep },
            steps: is_papers.then_some(Steps::PAPERS),
            tolerance,
            max_sweeps: DEFAULT_MAX_SWEEPS,
        }
    }

    fn parts(&self, lattice: u32) -> Vec<(&'static str, Value)> {
        let PaperSettings { solver, steps, tolerance, max_sweeps } = self;
        vec![
            ("model", json!("paper")),
            ("solver", json!(super::solver_name(*solver))),
            ("steps", json!(steps.map(|steps| steps.count(lattice)))),
            ("tolerance", json!(tolerance)),
            ("max_sweeps", json!(max_sweeps)),
        ]
    }

    /// The solve of these bases.
    pub fn solve(&self, bases: BaseSet) -> SolveSettings {
        let PaperSettings { solver, steps, tolerance, max_sweeps } = *self;
        SolveSettings { solver, steps, tolerance, max_sweeps, bases }
    }
}

/// Metadata of the light before it is solved. [`Light::of_leaves`] says how the leaves are inclined; until then they
/// lie at random.
pub fn unsolved_light(solve: &OrdinatesSettings) -> Light {
    Light {
        field: solve.field,
        ordinates: solve.ordinates.count(),
        rays: solve.rays,
        suns: solve.suns.clone(),
        leaf_angles: LeafAngles::spherical(),
        error: LightError { suns_rms: 0.0, held_out: 0, solver: 0.0, monte_carlo: None },
        solid_offset: (solve.field == FieldKind::Scattered).then_some(SOLID_OFFSET),
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_finer_quality_is_nowhere_coarser() {
        for pair in Quality::ALL.windows(2) {
            let [coarse, fine] = [BakeSettings::of(pair[0]), BakeSettings::of(pair[1])];
            assert!(coarse.lattice <= fine.lattice, "{pair:?}");
            let [coarse, fine] = [PhysicalSettings::of(pair[0]), PhysicalSettings::of(pair[1])];
            let [few, many] = [&coarse, &fine].map(|of| of.suns.basis(Walls::None).items());
            assert!(few <= many && coarse.parts <= fine.parts, "{pair:?}");
            assert!(coarse.ordinates.count() <= fine.ordinates.count(), "{pair:?}");
            assert!(coarse.tolerance >= fine.tolerance, "{pair:?}");
            let [coarse, fine] = [PaperSettings::of(pair[0]), PaperSettings::of(pair[1])];
            assert!(coarse.tolerance >= fine.tolerance, "{pair:?}");
        }
    }

    #[test]
    fn the_default_is_the_product_s() {
        assert_eq!(BakeSettings::default(), BakeSettings::of(Quality::Standard));
        let papers = BakeSettings::of(Quality::Papers);
        assert!(papers.ignore_alpha && (papers.lattice, papers.voxels) == (128, 1024));
        let ModelSettings::Paper(paper) = papers.model else { panic!("the papers' model") };
        assert_eq!((paper.solver, paper.steps), (SolverKind::Explicit, Some(Steps::PAPERS)));
        let ModelSettings::Physical(physical) = BakeSettings::default().model else {
            panic!("the other model")
        };
        assert_eq!(
            physical.solve(128, Walls::None, BaseSet::ALL),
            OrdinatesSettings { max_passes: 300, ..Default::default() }
        );
    }

    #[test]
    fn bands_are_chosen_by_name_in_the_plant_s_order() {
        let wanted = Wanted { bands: Some(vec!["B".to_owned(), "R".to_owned()]), ..Wanted::default() };
        let (kept, left) = wanted.choose(&["R", "G", "B"], "oak").expect("known");
        assert_eq!((kept, left), (vec![0, 2], vec!["G".to_owned()]));
        let error = wanted.choose(&["R", "G"], "oak").unwrap_err();
        assert!(error.to_string().contains("\"B\""), "{error}");
    }
}
