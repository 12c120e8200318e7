//! Models of light transport that are tried, and what differs between them: nothing else of a trade tells them apart.

use flb_baker::bake::{ModelSettings, PaperSettings, PhysicalSettings, SunChoice};
use flb_format::Quality;
use flb_format::light::{FieldKind, SunBasis};
use flb_scene::Plant;
use flb_scene::extents::Walls;
use flb_transport::lattice::{SolverKind, Steps};
use flb_transport::ordinates::{NamedSuns, Ordinates, rays_for};

/// Model of light transport with its settings.
#[derive(Debug, Clone, Copy, PartialEq)]
pub enum Transport {
    /// The model `paper`.
    Paper {
        /// Change of light at which sweeps end.
        tolerance: f64,
        /// Steps of the papers' own iteration, in place of sweeps to a tolerance.
        steps: Option<u32>,
    },
    /// The model `physical`.
    Physical(Marched),
}

/// Settings of a solve by discrete ordinates.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Marched {
    /// Dependence of the fields on the sun.
    pub suns: NamedSuns,
    /// Directions that light is marched along.
    pub ordinates: Ordinates,
    /// Rays per site edge.
    pub rays: u32,
    /// Parts of a site along each edge: 1, or 2 where sites are cut.
    pub parts: u32,
    /// Light that a field holds.
    pub field: FieldKind,
    /// Change of light at which passes end.
    pub tolerance: f64,
}

/// Changes of light at which sweeps of the papers' model end that are tried, the finest first: the others are compared
/// with it.
pub(super) const PAPERS: [Transport; 3] = [swept(1e-5), swept(1e-4), swept(1e-2)];

/// Steps as the papers count them, by the lattice.
pub(super) const COUNTED: Transport = Transport::Paper { tolerance: 1e-4, steps: Some(0) };

const fn swept(tolerance: f64) -> Transport {
    Transport::Paper { tolerance, steps: None }
}

impl Marched {
    /// Scattered light of these suns along these directions; else as by default.
    pub(super) fn new(suns: NamedSuns, ordinates: Ordinates) -> Marched {
        let (field, tolerance) = (FieldKind::Scattered, PhysicalSettings::default().tolerance);
        Marched { suns, ordinates, rays: 1, parts: 1, field, tolerance }
    }

    /// What a preset bakes.
    pub(super) fn of_preset(quality: Quality) -> Marched {
        let preset = PhysicalSettings::of(quality);
        Marched {
            suns: NamedSuns::of(&preset.suns.basis(Walls::None)).expect("a test goes through all"),
            ordinates: preset.ordinates,
            rays: 1,
            parts: preset.parts,
            field: preset.field,
            tolerance: preset.tolerance,
        }
    }
}

impl From<Marched> for Transport {
    fn from(marched: Marched) -> Transport {
        Transport::Physical(marched)
    }
}

impl Transport {
    /// The same with as many rays as a lattice gets where none are asked for, and as many steps as the papers do.
    pub(super) fn on(self, lattice: u32) -> Transport {
        match self {
            Transport::Paper { tolerance, steps } => {
                Transport::Paper { tolerance, steps: steps.map(|_| Steps::PAPERS.count(lattice)) }
            }
            Transport::Physical(marched) => {
                Transport::Physical(Marched { rays: rays_for(lattice, marched.parts), ..marched })
            }
        }
    }

    /// "paper" or "physical", as in files.
    pub(super) fn name(&self) -> &'static str {
        match self {
            Transport::Paper { .. } => "paper",
            Transport::Physical(_) => "physical",
        }
    }

    /// Settings of a solve that marches light along directions; `None` where light goes from site to site.
    pub(super) fn marched(&self) -> Option<&Marched> {
        match self {
            Transport::Paper { .. } => None,
            Transport::Physical(marched) => Some(marched),
        }
    }

    /// Change of light at which a solve ends.
    pub(super) fn tolerance(&self) -> f64 {
        match self {
            Transport::Paper { tolerance, .. } => *tolerance,
            Transport::Physical(marched) => marched.tolerance,
        }
    }

    /// Whether its rows are compared with the finest of their own model, too.
    pub(super) fn has_finest_of_its_own(&self) -> bool {
        self.marched().is_none()
    }

    /// Steps of the papers' own iteration, where these are counted.
    pub(super) fn steps(&self) -> Option<u32> {
        match self {
            Transport::Paper { steps, .. } => *steps,
            Transport::Physical(_) => None,
        }
    }

    /// Dependence of the fields on the sun.
    pub(super) fn suns(&self) -> SunBasis {
        self.marched().map_or(SunBasis::Lattice18, |marched| marched.suns.basis().of_field(marched.field))
    }

    /// Light that a field holds.
    pub(super) fn field(&self) -> FieldKind {
        self.marched().map_or(FieldKind::Total, |marched| marched.field)
    }

    /// Fields of a band.
    pub(super) fn items(&self) -> u64 {
        u64::from(self.suns().items())
    }

    /// Whether its light fills the whole lattice: scattered light alone is nothing in most of it.
    pub(super) fn is_all_over(&self) -> bool {
        self.marched().is_none()
    }

    /// The model of a bake.
    pub(super) fn settings(&self) -> ModelSettings {
        match *self {
            Transport::Paper { tolerance, steps } => {
                let default = PaperSettings::default();
                let solver = if steps.is_some() { SolverKind::Explicit } else { default.solver };
                let steps = steps.map(Steps::Count);
                ModelSettings::Paper(PaperSettings { solver, steps, tolerance, ..default })
            }
            Transport::Physical(Marched { suns, ordinates, rays, parts, field, tolerance }) => {
                ModelSettings::Physical(PhysicalSettings {
                    suns: SunChoice::Fixed(suns.basis()),
                    ordinates,
                    rays: Some(rays),
                    parts,
                    field,
                    tolerance,
                    ..PhysicalSettings::default()
                })
            }
        }
    }
}

/// Names of the bands that each model gives a plant.
pub(super) struct BandNames {
    paper: Vec<String>,
    physical: Vec<String>,
}

impl BandNames {
    pub(super) fn of(plant: &Plant) -> BandNames {
        BandNames {
            paper: plant.optics.bands.iter().map(|band| band.name.clone()).collect(),
            physical: plant.surfaces.bands.iter().map(|band| band.name.clone()).collect(),
        }
    }

    /// Bands of the model that has more of them.
    pub(super) fn most(&self) -> u64 {
        self.physical.len().max(self.paper.len()) as u64
    }

    /// Why light of a transport cannot be compared with that of the finest solve, where it has other bands.
    pub(super) fn why_not_compared(&self, transport: &Transport) -> Option<String> {
        let (paper, physical) = (self.paper.join(" "), self.physical.join(" "));
        match transport {
            Transport::Paper { .. } if self.paper != self.physical => Some(format!(
                "its bands are {paper}, those of the physical model {physical}: they cannot be compared"
            )),
            _ => None,
        }
    }
}
