//! From the settings of a bake to those of its solve.

use flb_baker::bake::{BakeSettings, ModelSettings, PaperSettings, PhysicalSettings, SunChoice, Wanted};
use flb_baker::voxelise::MAX_VOXELS;
use flb_format::Quality;
use flb_format::light::FieldKind;
use flb_transport::lattice::{DEFAULT_MAX_SWEEPS, SolverKind, Steps};
use flb_transport::monte_carlo::judge::MAX_SUNS;
use flb_transport::ordinates::{Backend, MAX_RAYS, Ordinates};

use super::{Recipe, RecipeError, SolverName};

/// Light transport model, by its name.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum ModelName {
    /// Extinction measured on the mesh, surfaces from data, directions marched through the plant.
    Physical,
    /// The lattice-Boltzmann model of Steele and Geist (2009).
    Paper,
}

impl ModelName {
    /// All names.
    pub const ALL: [ModelName; 2] = [ModelName::Physical, ModelName::Paper];

    /// "physical" or "paper".
    pub fn name(self) -> &'static str {
        match self {
            ModelName::Physical => "physical",
            ModelName::Paper => "paper",
        }
    }
}

/// Machine that solves.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default)]
pub enum Machine {
    /// Every core.
    #[default]
    Cpu,
    /// GPUs of one kind.
    Gpu {
        /// Most GPUs that share a solve.
        most: usize,
    },
}

impl Recipe {
    /// The model that is asked for, else that of the preset.
    pub fn model(&self) -> ModelName {
        self.model.unwrap_or(match ModelSettings::of(self.quality()) {
            ModelSettings::Physical(_) => ModelName::Physical,
            ModelSettings::Paper(_) => ModelName::Paper,
        })
    }

    /// How a plant is baked: as the settings ask, and as the preset does where they do not. All bases and bands are
    /// wanted.
    ///
    /// # Errors
    /// A setting out of its range, or of the other model.
    pub fn bake_settings(&self, machine: Machine) -> Result<BakeSettings, RecipeError> {
        self.check_preset()?;
        let preset = self.purpose.map_or_else(|| BakeSettings::of(self.quality()), BakeSettings::of_purpose);
        let voxels = self.voxels.unwrap_or(preset.voxels);
        let lattice = self.lattice.unwrap_or(preset.lattice);
        check_lattice(lattice)?;
        if !(voxels.is_multiple_of(lattice) && (1..=MAX_VOXELS).contains(&voxels)) {
            return Err(RecipeError::new(format!(
                "`voxels` is {voxels}, expected a multiple of the lattice, {lattice}, up to {MAX_VOXELS}"
            )));
        }
        Ok(BakeSettings {
            lattice,
            voxels,
            ignore_alpha: self.ignore_alpha.unwrap_or(preset.ignore_alpha),
            wanted: Wanted::default(),
            model: self.model_settings(machine)?,
        })
    }

    /// The model and how it is solved.
    ///
    /// # Errors
    /// As [`Recipe::bake_settings`].
    pub fn model_settings(&self, machine: Machine) -> Result<ModelSettings, RecipeError> {
        Ok(match self.model() {
            ModelName::Physical => ModelSettings::Physical(self.physical(machine)?),
            ModelName::Paper => ModelSettings::Paper(self.paper(machine)?),
        })
    }

    /// The setting that asks for light without a part that was scattered alone, if one does.
    pub fn without_scattered_light(&self) -> Option<&'static str> {
        match self.model() {
            ModelName::Paper => Some("model paper"),
            ModelName::Physical => (self.field == Some(FieldKind::Total)).then_some("field total"),
        }
    }

    /// Whether the light depends on the colours of the plant's textures.
    pub fn follows_colors(&self) -> bool {
        self.model() == ModelName::Physical
    }

    /// The setting that ends a solve of `quality papers` by a tolerance, in place of the papers' 2N steps, if one does.
    pub fn in_place_of_steps(&self, machine: Machine) -> Option<&'static str> {
        let has_steps = PaperSettings::of(self.quality()).steps.is_some();
        self.end_by_tolerance(machine).filter(|_| has_steps && self.model() == ModelName::Paper)
    }

    /// The setting by which a solve of the papers' model ends when a tolerance is met, if one is given.
    fn end_by_tolerance(&self, machine: Machine) -> Option<&'static str> {
        match machine {
            Machine::Gpu { .. } => Some("backend gpu"),
            Machine::Cpu if self.tolerance.is_some() => Some("tolerance"),
            Machine::Cpu => (self.solver == Some(SolverName::Sweep)).then_some("solver sweep"),
        }
    }

    fn max_sweeps(&self) -> u32 {
        self.max_sweeps.unwrap_or(DEFAULT_MAX_SWEEPS)
    }

    fn paper(&self, machine: Machine) -> Result<PaperSettings, RecipeError> {
        let refuse = |text: String| Err(RecipeError::new(text));
        if let Some(key) = self.physical_setting() {
            return refuse(format!("`{key}` is for `model physical`; the paper model has no such choice"));
        }
        let preset = PaperSettings::of(self.quality());
        let end = self.end_by_tolerance(machine);
        let steps = self.steps.map(Steps::Count).or(preset.steps.filter(|_| end.is_none()));
        if self.steps == Some(0) {
            return refuse("`steps` is 0, expected 1 or more".to_owned());
        }
        if let Some(found) = end.filter(|_| self.steps.is_some()) {
            return refuse(format!(
                "`steps` with `{found}`, which goes until the tolerance is met: expected `solver explicit` or literal"
            ));
        }
        let tolerance = self.tolerance.unwrap_or(preset.tolerance);
        check_end(tolerance, self.max_sweeps())?;
        Ok(PaperSettings {
            steps,
            solver: match (self.solver, machine) {
                (None, Machine::Gpu { most }) => SolverKind::Gpu { most },
                (None, Machine::Cpu) if steps.is_some() => SolverKind::Explicit,
                (None | Some(SolverName::Sweep), _) => SolverKind::Sweep,
                (Some(SolverName::Explicit), _) => SolverKind::Explicit,
                (Some(SolverName::Literal), _) => SolverKind::Literal,
            },
            tolerance,
            max_sweeps: self.max_sweeps(),
        })
    }

    fn physical(&self, machine: Machine) -> Result<PhysicalSettings, RecipeError> {
        let refuse = |text: String| Err(RecipeError::new(text));
        if self.solver.is_some() {
            return refuse("`solver` is for `model paper`; the physical model has one solver".to_owned());
        }
        if self.steps.is_some() {
            return refuse(
                "`steps` is for `model paper`; the physical model goes until its tolerance is met".to_owned(),
            );
        }
        if self.quality == Some(Quality::Papers) {
            return refuse("`quality papers` is of the papers' model, not of `model physical`".to_owned());
        }
        let preset = PhysicalSettings::of(self.quality());
        let ordinates = self.ordinates.map_or(Ok(preset.ordinates), ordinates_of)?;
        if let Some(rays) = self.rays.filter(|rays| !(1..=MAX_RAYS).contains(rays)) {
            return refuse(format!("`rays` is {rays}, expected 1 to {MAX_RAYS}"));
        }
        let monte_carlo_suns = self.monte_carlo.map_or(preset.monte_carlo_suns, usize::from);
        if monte_carlo_suns > MAX_SUNS {
            return refuse(format!("`monte_carlo` is {monte_carlo_suns}, expected 0 to {MAX_SUNS}"));
        }
        let tolerance = self.tolerance.unwrap_or(preset.tolerance);
        check_end(tolerance, self.max_sweeps())?;
        Ok(PhysicalSettings {
            suns: self.suns.map_or(preset.suns, |suns| SunChoice::Fixed(suns.basis())),
            ordinates,
            rays: self.rays,
            parts: self.cut_sites.map_or(preset.parts, |cut| if cut { 2 } else { 1 }),
            field: self.field.unwrap_or(preset.field),
            leaf_angles: self.leaf_angles.unwrap_or(preset.leaf_angles),
            tolerance,
            max_passes: self.max_sweeps(),
            monte_carlo_suns,
            backend: match machine {
                Machine::Cpu => Backend::Cpu,
                Machine::Gpu { most } => Backend::Gpu { most },
            },
            keep_cloud: false,
        })
    }

    /// The first setting that only the `physical` model has.
    fn physical_setting(&self) -> Option<&'static str> {
        let settings = [
            ("suns", self.suns.is_some()),
            ("ordinates", self.ordinates.is_some()),
            ("rays", self.rays.is_some()),
            ("cut_sites", self.cut_sites.is_some()),
            ("field", self.field.is_some()),
            ("leaf_angles", self.leaf_angles.is_some()),
            ("monte_carlo", self.monte_carlo.is_some_and(|suns| suns > 0)),
        ];
        settings.into_iter().find(|(_, given)| *given).map(|(key, _)| key)
    }
}

/// Refuses a lattice that no format has.
///
/// # Errors
/// Another number than a power of two from 16 to 256.
pub fn check_lattice(lattice: u32) -> Result<(), RecipeError> {
    match lattice.is_power_of_two() && (16..=256).contains(&lattice) {
        true => Ok(()),
        false => Err(RecipeError::new(format!("`lattice` is {lattice}, expected a power of two, 16 to 256"))),
    }
}

/// Directions by their number.
///
/// # Errors
/// Another number than 18, 50 or 110.
pub fn ordinates_of(count: u32) -> Result<Ordinates, RecipeError> {
    let refuse = || RecipeError::new(format!("`ordinates` is {count}, expected 18, 50 or 110"));
    Ordinates::of_count(count).ok_or_else(refuse)
}

/// Refuses a solve that would never end, or never begin.
///
/// # Errors
/// A tolerance that is not between 0 and 1; no sweeps.
pub fn check_end(tolerance: f64, max_sweeps: u32) -> Result<(), RecipeError> {
    if !(tolerance > 0.0 && tolerance < 1.0) {
        let text = format!("`tolerance` is {tolerance}, expected a number between 0 and 1");
        return Err(RecipeError::new(text));
    }
    if max_sweeps == 0 {
        return Err(RecipeError::new("`max_sweeps` is 0, expected 1 or more"));
    }
    Ok(())
}
