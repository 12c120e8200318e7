//! Light transport of the `physical` model: a turbid medium and its optics -> fields for every sun.
//!
//! Discrete ordinates along long characteristics: light is marched through the plant along the directions of a
//! quadrature ([`Ordinates`]), with the exact integral of the source over every crossing of a site. The beam of a sun
//! is followed apart, along its own direction, and feeds the first scattering; what is solved for is scattered light
//! only.
//!
//! ```text
//! TurbidMedium -beams of many suns-> first scattering -march, source iteration-> light of each sun
//!     -fit-> fields -spread-> Field
//! ```
//!
//! How the fields depend on the sun is the caller's choice ([`SunBasis`]):
//!
//! * `Lattice18`: one field per lattice direction, blended by three as in the `paper` model.
//! * `Harmonics`: the light of 26 or 50 suns is solved, and fitted at each site by harmonics of the sun's direction and
//!   by the near beam ([`flb_format::beam`]).
//! * `Directions`: one field per direction of a list ([`ico12`], [`ico42`]), blended by the three of a triangle.
//!
//! For the last two, a few suns are solved and held out: they tell what the fit or the blend is off.

mod alike;
mod backend;
mod band;
mod error;
pub mod extremes;
mod fields;
mod first;
mod fit;
#[cfg(feature = "gpu")]
mod gpu;
mod halves;
mod icosahedron;
mod lanes;
mod leaves;
mod march;
mod moments;
mod named;
mod reference;
mod refine;
mod scatter;
mod smooth;
mod source_iteration;
mod spread;
mod suns;
#[cfg(test)]
mod tests;
mod total;

pub use backend::Backend;
pub use error::OrdinatesError;
pub use fit::{Sun, Terms, evaluate};
pub use flb_format::light::{FieldKind, SunBasis};
pub use flb_format::ordinates::{MAX_RAYS, Ordinate, Ordinates, rays_for};
pub use icosahedron::{ico12, ico42};
pub use named::NamedSuns;
pub use spread::Spread;
pub use total::TotalLight;

use std::borrow::Cow;
use std::sync::Arc;

use flb_format::Field;
use flb_format::bases::BaseSet;
use flb_format::beam::single::OrdinateTracks;
use flb_format::beam::{self, BEAM_RAYS, Beam, Near, NearBeam, Sites};
use flb_format::field::CellBand;
use flb_format::matter::TurbidMedium;
use flb_format::progress::Progress;
use rayon::prelude::*;

use crate::turbid::BandScatter;
use alike::AlikeBands;
use band::{Band, Own};
#[cfg(test)]
use fields::relative_rms;
use fields::{BandLight, Making, blended};
use lanes::LANES;
use march::March;
use refine::Refined;
#[cfg(test)]
use scatter::Lit;
use scatter::Scattering;

/// Fields to solve for, and the resolution of the solve.
#[derive(Debug, Clone, PartialEq)]
pub struct OrdinatesSettings {
    /// Directions that light is marched along.
    pub ordinates: Ordinates,
    /// Rays per site edge that are marched, 1..=[`MAX_RAYS`].
    pub rays: u32,
    /// Parts that a site is cut into along each edge while light is marched, 1 or 2: within a part, what is scattered
    /// is taken as constant. 2 costs 8 times the memory and about 5 times the time.
    pub parts: u32,
    /// Dependence of the fields on the sun.
    pub suns: SunBasis,
    /// Fields to make where the suns are `Lattice18`: 0, the sky's, and those of the lattice directions that are
    /// needed. Files of other suns have all their fields (SPEC.md, M38), so there it is [`BaseSet::ALL`].
    pub bases: BaseSet,
    /// Whether fields hold the sun's beam, too.
    pub field: FieldKind,
    /// Estimated relative L2 error of the scattered light at which it has converged.
    pub tolerance: f64,
    /// Passes after which a solve is given up as not converged.
    pub max_passes: u32,
    /// Machine that light is marched on.
    pub backend: Backend,
}

/// Bands that are solved at once; more would only cost memory.
const BANDS_AT_ONCE: usize = fit::MAX_BANDS;

impl Default for OrdinatesSettings {
    fn default() -> OrdinatesSettings {
        OrdinatesSettings {
            ordinates: Ordinates::Lebedev110,
            rays: 1,
            parts: 1,
            suns: SunBasis::Harmonics { degree: 2, single: true, leaning: true },
            bases: BaseSet::ALL,
            field: FieldKind::Scattered,
            tolerance: 2e-3,
            max_passes: 200,
            backend: Backend::Cpu,
        }
    }
}

impl OrdinatesSettings {
    /// Default settings for fields of a kind: a near beam leans unless they hold the beam.
    pub fn of_field(field: FieldKind) -> OrdinatesSettings {
        let default = OrdinatesSettings::default();
        OrdinatesSettings { field, suns: default.suns.of_field(field), ..default }
    }

    /// Whether the light of the sky is wanted.
    fn sky(&self) -> bool {
        self.bases.contains(0)
    }

    /// Solves per band: the suns, and the sky.
    pub fn solves(&self) -> u32 {
        suns::SolvePlan::new(self).suns.len() as u32 + u32::from(self.sky())
    }

    /// Numbers of the fields that are made, ascending.
    pub fn items(&self) -> Vec<u8> {
        match self.suns {
            SunBasis::Lattice18 => self.bases.iter().collect(),
            SunBasis::Harmonics { .. } | SunBasis::Directions(_) => self.suns.item_numbers().collect(),
        }
    }
}

/// The fields and how they were reached.
#[derive(Debug, Clone, PartialEq)]
pub struct OrdinatesSolution {
    /// Field 0 is the total fluence under an even sky of fluence 1; the others follow, as [`SunBasis`] orders them: the
    /// lattice directions 1..=18 (those that were wanted), the harmonics and then the near beam's coefficients, or the
    /// directions of the list.
    pub fields: Vec<(u8, Field)>,
    /// Reports, one per band.
    pub reports: Vec<BandReport>,
    /// Suns that were solved to judge the fit or the blend. 0 with `Lattice18`.
    pub held_out: u32,
    /// All light at the non-empty sites, the beams with it.
    pub total: TotalLight,
}

/// Result of the solves of one band.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct BandReport {
    /// Index of the band.
    pub band: u32,
    /// Suns that were solved, the sky included.
    pub solves: u32,
    /// Largest number of passes of any of the solves.
    pub passes: u32,
    /// Largest estimated relative L2 error of the scattered light of any of them.
    pub error_estimate: f64,
    /// Whether the error estimate reached the tolerance.
    pub converged: bool,
    /// Error of the fitted or blended scattered light over the non-empty sites, rms, relative to the mean total
    /// fluence; the mean over the suns held out. `None` without any.
    pub suns_rms: Option<f64>,
}

/// Albedos of a medium's sites in one band, `[site][leaf, wood]` in the order of [`TurbidMedium::sites`].
pub type SiteAlbedos = Vec<[f32; 2]>;

/// Light and matter around a plant in a scene.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Surroundings<'a> {
    /// Light from below the horizon, relative to the sky's: 1 where the sky is all around, a plain's reflectance above
    /// a plain.
    pub below: f32,
    /// Albedos in place of those of the bands, `[band]`: of media whose sites hold matter of several species, or matter
    /// that light leaves after several collisions. Phases are still those of the bands.
    pub albedos: Option<&'a [SiteAlbedos]>,
    /// Shares of what leaves scatter that come out of the far side, `[band][site]`, in place of those of the bands,
    /// which then scatter as facets ([`crate::turbid::Phase::BiLambert`]): of media whose sites hold different leaves.
    pub transmitted: Option<&'a [Vec<f32>]>,
}

impl Surroundings<'_> {
    /// Surroundings of the sky alone.
    pub const NONE: Surroundings<'static> = Surroundings { below: 1.0, albedos: None, transmitted: None };
}

/// Solves all bands. `progress` is called with 0..=1, never falling, from any thread. The result's bytes do not depend
/// on the number of threads.
///
/// # Errors
/// A medium whose arrays have the wrong length, extinction that is negative or not finite, no bands or more than 64, an
/// albedo outside 0..=1, and settings outside of their ranges: see [`OrdinatesError`]; [`OrdinatesError::Gpu`];
/// [`OrdinatesError::Cancelled`].
pub fn solve(
    medium: &TurbidMedium,
    bands: &[BandScatter],
    settings: &OrdinatesSettings,
    progress: &Progress<'_>,
) -> Result<OrdinatesSolution, OrdinatesError> {
    solve_among(medium, bands, &Surroundings::NONE, settings, progress)
}

/// Solves for the light of a plant among surroundings.
///
/// # Errors
/// As of [`solve`]; surroundings out of range; albedos of sites that are cut.
pub fn solve_among(
    medium: &TurbidMedium,
    bands: &[BandScatter],
    surroundings: &Surroundings,
    settings: &OrdinatesSettings,
    progress: &Progress<'_>,
) -> Result<OrdinatesSolution, OrdinatesError> {
    error::check(medium, bands, settings)?;
    let sites = medium.sites();
    error::check_surroundings(surroundings, sites.len(), bands.len())?;
    progress(0.0)?;
    let marcher = settings.backend.open()?;
    let Surroundings { below, albedos, transmitted } = *surroundings;
    let plan = suns::SolvePlan::new(settings);
    let refined = (settings.parts > 1).then(|| Refined::new(medium, &sites));
    let (fine, fine_sites) =
        refined.as_ref().map_or((medium, &sites), |refined| (&refined.medium, &refined.sites));
    let mut march = Some(March::new(fine, fine_sites, settings.ordinates, settings.rays));
    progress(0.05)?;
    let has_rays_of_near = refined.is_none()
        && settings.ordinates == beam::single::ORDINATES
        && settings.rays == beam::single::rays(medium.grid.lattice);
    let near = match march.as_ref().filter(|_| has_rays_of_near && settings.suns.needs_single()) {
        Some(march) => Near::along(medium, &sites, march.tracks()),
        None => near(medium, &sites, settings.suns.needs_single()),
    };
    let beams = beams_of(&near, &plan.suns);
    drop(near);
    let fine_beams: Vec<Beam> = match &refined {
        Some(refined) => plan.suns.par_iter().map(|sun| refined.beam(sun.towards)).collect(),
        None => Vec::new(),
    };
    let marched: Vec<&Beam> = match &refined {
        Some(_) => fine_beams.iter().collect(),
        None => beams.iter().map(|near| &near.beam).collect(),
    };
    let mean_of = |values: Vec<f32>| match &refined {
        Some(refined) => refined.means(&values),
        None => values,
    };
    let open_sky = march.as_ref().filter(|_| settings.sky());
    let open_sky = open_sky.map(|march| march.sky::<1>(below).into_flattened());
    let sky = open_sky.clone().map(mean_of);
    progress(0.2)?;

    let items = settings.items();
    let mut fields: Vec<Vec<CellBand>> = vec![Vec::new(); items.len()];
    let mut reports = Vec::new();
    let far = |item: &u8| settings.suns.first_near_item().is_none_or(|near| *item < near);
    let mut total = TotalLight {
        items: items.iter().copied().filter(far).collect(),
        values: Vec::new(),
        near: total::of_near(&plan, &beams, settings),
        beyond: total::beyond(&plan, &beams, settings),
        open_sky: Vec::new(),
    };
    let spread = Spread::new(&sites, medium.grid.lattice);
    let parted = |values: &[f32]| of_parts(values, refined.as_ref()).into_owned();
    let band = |number: usize| {
        let albedos = albedos.map(|albedos| of_parts(&albedos[number], refined.as_ref()));
        let transmitted = transmitted.map(|transmitted| of_parts(&transmitted[number], refined.as_ref()));
        let own = Own { albedos: albedos.as_deref(), transmitted: transmitted.as_deref() };
        Band::new(fine, fine_sites, &bands[number], &own)
    };
    let scatter = |scattering: &Scattering, some: &[Band], made: &Progress<'_>| {
        let mut lit = marcher.scatter(scattering, some, made)?;
        lit.iter_mut().for_each(|lit| {
            lit.light.par_iter_mut().for_each(|light| *light = mean_of(std::mem::take(light)))
        });
        Ok(lit)
    };
    let (marched, lit_sky) = (marched.as_slice(), open_sky.as_deref());
    let making = Making { plan: &plan, beams: &beams, sky: sky.as_deref(), settings };
    let mut alike = match march.as_ref().filter(|_| bands.len() >= alike::MIN_BANDS && plan.held_out() > 0) {
        None => None,
        Some(march) => {
            let whole = Scattering::whole(march, &plan, marched, below, lit_sky, settings);
            let bands =
                alike::Bands { count: bands.len(), at_once: BANDS_AT_ONCE, band: &band, parted: &parted };
            let made = |share: f64| progress(0.2 + 0.7 * share);
            Some(AlikeBands::solve(&whole, &making, &bands, &scatter, &made)?)
        }
    };
    // The rays take as much memory as all the rest.
    march = march.filter(|_| alike.is_none());
    let begun = if alike.is_some() { 0.9 } else { 0.2 };
    for first in (0..bands.len()).step_by(BANDS_AT_ONCE) {
        let some = first..(first + BANDS_AT_ONCE).min(bands.len());
        let made = |share: f64| {
            let done = first as f64 + share * some.len() as f64;
            progress(begun + (1.0 - begun) * done / bands.len() as f64)
        };
        let light: Vec<BandLight> = match &mut alike {
            Some(alike) => some.clone().map(|number| alike.take(number)).collect(),
            None => {
                let march = march.as_ref().expect("it goes after the last bands");
                let whole = Scattering::whole(march, &plan, marched, below, lit_sky, settings);
                making.light(scatter(&whole, &some.clone().map(band).collect::<Vec<_>>(), &made)?)
            }
        };
        made(1.0)?;
        march = march.filter(|_| some.end < bands.len());
        for (band, light) in some.zip(light) {
            let (values, of_band, report) = making.fields(band as u32, light);
            total.values.push(of_band);
            reports.push(report);
            fields.par_iter_mut().zip(values).for_each(|(field, values)| field.push(spread.band(&values)));
        }
    }
    total.open_sky = sky.unwrap_or_default();
    progress(1.0)?;
    let field = |bands| Field::of_cells(medium.grid.lattice, bands);
    let fields = items.into_iter().zip(fields.into_iter().map(field)).collect();
    Ok(OrdinatesSolution { fields, reports, held_out: plan.held_out() as u32, total })
}

/// Makes the near beams of a medium, the rays of singly scattered light laid by all threads.
pub fn near<'m>(medium: &'m TurbidMedium, sites: &'m [u32], single: bool) -> Near<'m> {
    match single {
        false => Near::new(medium, sites, false),
        true => {
            let places = Sites::new(&medium.grid, sites);
            let lay = |ordinate| Arc::new(OrdinateTracks::lay(medium, &places, sites, ordinate));
            Near::along(medium, sites, beam::single::axes().par_iter().map(lay).collect())
        }
    }
}

/// Values of sites, for their parts if they are cut.
fn of_parts<'a, T: Copy>(of_sites: &'a [T], refined: Option<&Refined>) -> Cow<'a, [T]> {
    refined.map_or(Cow::Borrowed(of_sites), |refined| Cow::Owned(refined.to_parts(of_sites)))
}

/// The near beams of all suns.
fn beams_of(near: &Near, suns: &[Sun]) -> Vec<NearBeam> {
    let beams: Vec<Beam> = suns.par_iter().map(|sun| near.uncollided(sun.towards, BEAM_RAYS)).collect();
    let means = |some: &[Beam]| {
        let means: Vec<&[f32]> = some.iter().map(|beam| beam.mean.as_slice()).collect();
        near.around_each(&means)
    };
    let around: Vec<_> = beams.par_chunks(beam::single::BESIDE).flat_map_iter(means).collect();
    beams.into_iter().zip(around).map(|(beam, around)| near.with_means(beam, around)).collect()
}

impl OrdinatesSolution {
    /// Light of a sun at the non-empty `sites` in one band, as a renderer evaluates the fields of `suns` with the near
    /// beam of that sun: scattered, or total where the fields were solved as such.
    ///
    /// # Panics
    /// If `suns` are not those that were solved, or a lattice direction that the sun needs was not wanted.
    pub fn light(
        &self,
        suns: &SunBasis,
        band: u32,
        sites: &[u32],
        towards_sun: [f64; 3],
        near: &NearBeam,
    ) -> Vec<f32> {
        let at_sites = |field: &Field| -> Vec<f32> {
            sites.iter().map(|&site| field.value(band, site as usize)).collect()
        };
        match suns {
            SunBasis::Lattice18 | SunBasis::Directions(_) => {
                let blend = suns.blend(towards_sun).expect("a unit vector has a blend");
                let field = |base: u8| self.fields.iter().find(|(item, _)| *item == base);
                let bases =
                    blend.bases.map(|base| at_sites(&field(base).expect("the direction was solved").1));
                blended(&blend, [&bases[0], &bases[1], &bases[2]])
            }
            &SunBasis::Harmonics { degree, single, leaning } => {
                let items = usize::from(suns.items());
                assert_eq!(self.fields.len(), items, "the suns are not those that were solved");
                let fields: Vec<Vec<f32>> =
                    self.fields[1..].iter().map(|(_, field)| at_sites(field)).collect();
                evaluate(&fields, Terms { degree, single, leaning }, towards_sun, near)
            }
        }
    }
}

/// Solves go through all lanes of their groups; one of the last is the sky's.
const fn whole_lanes(solves: usize) -> usize {
    solves.div_ceil(LANES) * LANES
}
