//! The light of an uneven sky on a plant, from fields that know single suns and the even sky (lighting model, section
//! 9): nothing is baked anew.
//!
//! ```text
//! SkyPart x N, SpeciesLight -sky-> SkyLight: factors of the bases, near beam and beam summed over the sky per site
//! SpeciesLight -sky_beams-> SkyBeams, SkyPart x N -sky-> SkyLight: the same from harmonics of the beams, per plant
//! ```
//!
//! What is scattered is linear in the sun, so that of a sky is the sum over its parts. What comes from the sky without
//! being scattered is in no field of the sun, but in that of the even sky: what is scattered of an even sky, taken from
//! that field, leaves it. An uneven sky gives it as many times as the beams that reach the site give on the mean. All
//! is added to the even sky as a difference from it, so that an even sky has exactly the light that is stored for it.

mod beams;
#[cfg(feature = "gpu")]
mod rows;

use std::f64::consts::PI;
use std::ops::Range;
use std::sync::Arc;
use std::thread::{available_parallelism, scope};

use flb_format::beam::{Beam, MAX_MEANS, Near, means};
use flb_format::blocks::{CodedBase, Cursor};
use flb_format::sky_part::SkyPart;

use super::SpeciesLight;
use crate::RuntimeError;
use crate::near_beam::{MediumSites, everywhere};
use crate::resident::ResidentSpecies;
use crate::sun_terms::{SpeciesSuns, SunTerms, near_bases, unit};
pub use beams::SkyBeams;
use beams::SkyFactors;
#[cfg(feature = "gpu")]
pub(crate) use rows::{OTHER_ROWS, SkyRows};

/// Rays per site edge that follow the beam of each part. The noise of one is a part of the sky's.
const RAYS: u32 = 2;
/// Bands of a picture.
const BANDS: usize = 3;

/// The light of a sky on a species that stands in one way. It knows the species' medium, not its fields: those are read
/// where they are when a point is asked for.
pub struct SkyLight<'a> {
    medium: Arc<MediumSites>,
    /// Bases of the near beam.
    near: Range<u8>,
    /// Fluence.
    mean: [f32; BANDS],
    bases: Vec<OfBase>,
    sites: OfSites<'a>,
    /// Where no matter is near.
    open: OfSite,
}

/// What comes to the sites.
enum OfSites<'a> {
    /// Found for each: `[place]`.
    Summed(Vec<OfSite>),
    /// Found when it is asked for, of beams that all plants share.
    Beams(&'a SkyBeams, Box<SkyFactors>),
}

/// What the sky gives a basis of the sun.
struct OfBase {
    base: u8,
    /// Of the even sky of fluence 1.
    even: f32,
    /// Of the sky, beyond that of the even one of its fluence.
    beyond: [f32; BANDS],
}

/// What comes to a site.
#[derive(Debug, Clone, Copy, Default)]
struct OfSite {
    /// Means of the near beam over the even sky of fluence 1, and beyond those of the even sky.
    near: [f32; MAX_MEANS],
    beyond: [[f32; MAX_MEANS]; BANDS],
    /// The beam summed over the even sky of fluence 1, and its sum times the directions it comes from; of the sky.
    even: Moments,
    sky: [Moments; BANDS],
}

/// A sum of light and of light times its direction.
type Moments = [f32; 4];
/// Of a part of the sky: its share of the sphere, and its fluence per band.
type Weights = [f32; 1 + BANDS];

impl OfSite {
    fn add(&mut self, weight: f32, other: &OfSite) {
        let add = |to: &mut [f32], from: &[f32]| {
            to.iter_mut().zip(from).for_each(|(to, from)| *to += weight * from);
        };
        add(&mut self.near, &other.near);
        add(&mut self.even, &other.even);
        for band in 0..BANDS {
            add(&mut self.beyond[band], &other.beyond[band]);
            add(&mut self.sky[band], &other.sky[band]);
        }
    }
}

impl<'a> SkyLight<'a> {
    /// For parts in the frame of the model.
    pub(super) fn new(light: &SpeciesLight, parts: &[SkyPart]) -> Result<SkyLight<'a>, RuntimeError> {
        let medium = checked(light)?;
        let suns = light.resident().species_suns();
        let weights = Weighted::of(suns, parts)?;
        parts.iter().try_for_each(|part| light.check(Some(part.towards), true))?;
        let sites = sites_of(medium, light.resident(), parts, &weights);
        Ok(SkyLight::with_sites(suns, Arc::clone(medium), parts, weights, OfSites::Summed(sites)))
    }

    fn with_sites(
        suns: &SpeciesSuns,
        medium: Arc<MediumSites>,
        parts: &[SkyPart],
        Weighted { weights, near, mean }: Weighted,
        sites: OfSites<'a>,
    ) -> SkyLight<'a> {
        let terms = |part: &SkyPart| SunTerms::of(suns, part.towards);
        // Each part has a direction, and so terms.
        let terms: Vec<SunTerms> = parts.iter().filter_map(terms).collect();
        let bases = bases_of(&terms, &weights, mean);
        let basis = suns.basis();
        let mut open = OfSite::default();
        let [even, sky @ ..] = if basis.is_leaning() { sum_of(&near) } else { with(1.0, mean) };
        let of_sky: [f32; BANDS] = [0, 1, 2].map(|band| sky[band] - mean[band] * even);
        let means = everywhere(1.0, basis.needs_single());
        open.near = means.map(|near| even * near);
        open.beyond = of_sky.map(|of_sky| means.map(|near| of_sky * near));
        for (part, weights) in parts.iter().zip(&weights) {
            add_moments(&mut open, part.towards, weights, 1.0);
        }
        SkyLight { medium, near: near_bases(basis), mean, bases, sites, open }
    }

    /// Fluence of the sky, R, G, B.
    pub fn fluence(&self) -> [f32; BANDS] {
        self.mean
    }

    /// Memory that it takes.
    pub fn size_bytes(&self) -> usize {
        let sites = match &self.sites {
            OfSites::Summed(sites) => size_of_val(&sites[..]),
            OfSites::Beams(_, factors) => size_of_val(&**factors),
        };
        sites + size_of_val(&self.bases[..])
    }

    /// Sums of bases that a sample needs: the even sky, what it scatters smoothly, each basis of the near beam, and of
    /// each band what the sky scatters beyond the even one.
    fn sums(&self) -> Vec<Vec<(u8, f32)>> {
        let mut sums = vec![vec![(0, 1.0)], self.bases.iter().map(|of| (of.base, of.even)).collect()];
        sums.extend(self.near.clone().map(|base| vec![(base, 1.0)]));
        let beyond = |band: usize| self.bases.iter().map(|of| (of.base, of.beyond[band])).collect();
        sums.extend((0..BANDS).map(beyond));
        sums
    }

    /// Where a cursor can keep blocks of those sums: not where bases are coded in another way, or not there.
    pub(super) fn cursor<'s>(&'s self, species: &'s ResidentSpecies) -> Option<SkyCursor<'s>> {
        let coded = |(base, factor): &(u8, f32)| Some((species.item(*base)?.coded()?, *factor));
        let sums: Option<Vec<Vec<(&CodedBase, f32)>>> =
            self.sums().iter().map(|sum| sum.iter().map(coded).collect()).collect();
        let sums = sums?;
        let found = vec![0.0; sums.len() * BANDS];
        Some(SkyCursor { sky: self, species, cursor: Cursor::of_sums(sums), found })
    }

    /// Adds the light at a point of the model, times `scale`, as it falls on a leaf or on a solid that faces some way.
    pub(super) fn add(
        &self,
        species: &ResidentSpecies,
        point_m: [f32; 3],
        facing: Option<[f32; 3]>,
        scale: f32,
        out: &mut [f32],
    ) {
        let mut at = species.point(point_m);
        let mut found = Vec::with_capacity(8 * BANDS);
        for sum in self.sums() {
            let mut light = [0.0; BANDS];
            for (base, factor) in sum {
                let Some(base) = species.item(base) else {
                    return self.add_even(species, point_m, scale, out);
                };
                at.add(base, factor, &mut light);
            }
            found.extend(light);
        }
        self.add_of(&found, point_m, facing, scale, out);
    }

    /// Adds an even sky of the same fluence, where a base was dropped since.
    fn add_even(&self, species: &ResidentSpecies, point_m: [f32; 3], scale: f32, out: &mut [f32]) {
        let mut light: [f32; BANDS] = std::array::from_fn(|band| species.mean_of_sky(band));
        if let Some(base) = species.item(0) {
            light = [0.0; BANDS];
            species.point(point_m).add(base, 1.0, &mut light);
        }
        for ((out, mean), light) in out.iter_mut().zip(self.mean).zip(light) {
            *out += scale * mean * light.max(0.0);
        }
    }

    /// The same from the sums at the point, `[sum][band]`.
    fn add_of(
        &self,
        found: &[f32],
        point_m: [f32; 3],
        facing: Option<[f32; 3]>,
        scale: f32,
        out: &mut [f32],
    ) {
        let site = self.site_at(point_m);
        let of = |sum: usize, band: usize| found[sum * BANDS + band];
        let near = self.near.clone().len();
        for (band, out) in out.iter_mut().enumerate().take(BANDS) {
            let stored = of(0, band);
            let mut scattered = of(1, band);
            let mut beyond = of(2 + near + band, band);
            for j in 0..near {
                scattered += of(2 + j, band) * site.near[j];
                beyond += of(2 + j, band) * site.beyond[band][j];
            }
            let direct = (stored - scattered).clamp(0.0, stored.max(0.0));
            let light =
                self.mean[band] * stored + beyond + direct * (site.share(band, facing) - self.mean[band]);
            *out += scale * light.max(0.0);
        }
    }

    /// Means over the non-empty of the eight sites around a point, by their trilinear weights.
    fn site_at(&self, point_m: [f32; 3]) -> OfSite {
        match &self.sites {
            OfSites::Beams(beams, factors) => {
                beams.at(&self.medium, point_m, factors, self.mean).unwrap_or(self.open)
            }
            OfSites::Summed(sites) => {
                let (mut sum, mut weights) = (OfSite::default(), 0.0);
                self.medium.around(point_m, |place, weight| {
                    sum.add(weight, &sites[place]);
                    weights += weight;
                });
                if weights <= 0.0 {
                    return self.open;
                }
                let mut mean = OfSite::default();
                mean.add(1.0 / weights, &sum);
                mean
            }
        }
    }
}

impl OfSite {
    /// What comes from the sky itself, relative to an even one of fluence 1: a mean over where the site sees it; of a
    /// solid by the cosine, to the first order of directions.
    fn share(&self, band: usize, facing: Option<[f32; 3]>) -> f32 {
        let on = |moments: &Moments| match facing {
            None => moments[0],
            Some(normal) => {
                let along: f32 = normal.iter().zip(&moments[1..]).map(|(n, m)| n * m).sum();
                (moments[0] / 4.0 + along / 2.0).max(moments[0] * MIN_ON_SOLIDS)
            }
        };
        match on(&self.even) {
            even if even > 0.0 => (on(&self.sky[band]) / even).max(0.0),
            _ => 0.0,
        }
    }
}

/// Least part of the beams around that is taken to fall on a solid.
const MIN_ON_SOLIDS: f32 = 0.02;

fn bases_of(terms: &[SunTerms], weights: &[Weights], mean: [f32; BANDS]) -> Vec<OfBase> {
    let mut sums: Vec<(u8, [f64; 1 + BANDS])> = Vec::new();
    for (terms, weights) in terms.iter().zip(weights) {
        for (base, factor) in terms.bases() {
            let at = match sums.binary_search_by_key(&base, |(base, _)| *base) {
                Ok(at) => at,
                Err(at) => {
                    sums.insert(at, (base, [0.0; 1 + BANDS]));
                    at
                }
            };
            let of_base = sums[at].1.iter_mut().zip(weights);
            of_base.for_each(|(sum, weight)| *sum += f64::from(factor) * f64::from(*weight));
        }
    }
    let of_base = |(base, [even, sky @ ..]): (u8, [f64; 1 + BANDS])| OfBase {
        base,
        even: even as f32,
        beyond: [0, 1, 2].map(|band| (sky[band] - f64::from(mean[band]) * even) as f32),
    };
    sums.into_iter().map(of_base).collect()
}

fn add_moments(site: &mut OfSite, towards: [f64; 3], weights: &Weights, beam: f32) {
    let [even, sky @ ..] = weights;
    let along = [1.0, towards[0] as f32, towards[1] as f32, towards[2] as f32].map(|c| c * beam);
    let add = |sum: &mut Moments, weight: f32| {
        sum.iter_mut().zip(along).for_each(|(sum, along)| *sum += weight * along);
    };
    add(&mut site.even, *even);
    site.sky.iter_mut().zip(sky).for_each(|(sum, weight)| add(sum, *weight));
}

/// The parts of a sky as weights, and its fluence.
struct Weighted {
    weights: Vec<Weights>,
    /// As often as the near beam of each counts.
    near: Vec<Weights>,
    mean: [f32; BANDS],
}

impl Weighted {
    fn of(suns: &SpeciesSuns, parts: &[SkyPart]) -> Result<Weighted, RuntimeError> {
        if let Some(part) = parts.iter().find(|part| unit(part.towards).is_none()) {
            return Err(RuntimeError::NoDirection { found: part.towards });
        }
        let whole: f64 = parts.iter().map(|part| part.solid_angle).sum();
        let is_fine = |part: &SkyPart| part.fluence.iter().all(|band| band.is_finite() && *band >= 0.0);
        if !((whole / (4.0 * PI) - 1.0).abs() < 1e-3 && parts.iter().all(is_fine)) {
            return Err(RuntimeError::UnevenSky {
                found: "parts that are not the whole sphere, or no light",
                expected: "solid angles that sum to 4 pi and finite fluences, 0 or more",
            });
        }
        let of_part = |part: &SkyPart| {
            let [red, green, blue] = part.fluence;
            [(part.solid_angle / whole) as f32, red, green, blue]
        };
        let weights: Vec<Weights> = parts.iter().map(of_part).collect();
        let [_, mean @ ..] = sum_of(&weights);
        let near = parts.iter().zip(&weights).map(|(part, weights)| {
            let factor = unit(part.towards).map_or(1.0, |towards| suns.near_factor(towards));
            weights.map(|weight| factor * weight)
        });
        Ok(Weighted { mean, near: near.collect(), weights })
    }
}

/// The medium of a species that is as it has to be for an uneven sky.
fn checked<'l>(light: &'l SpeciesLight) -> Result<&'l Arc<MediumSites>, RuntimeError> {
    let species = light.resident();
    if !species.has_extinction() {
        return Err(RuntimeError::UnevenSky {
            found: "the model \"paper\"",
            expected: "\"physical\": a paper file does not say what comes from the sky itself",
        });
    }
    light.check_bands(BANDS)?;
    light.check(None, true)?;
    species.sites().ok_or(match species.suns().has_near_beam() {
        true => super::NOT_THERE,
        // The extinction of a species whose suns need no near beam is no unit.
        false => RuntimeError::UnevenSky {
            found: "streamed light of a species of directions, whose extinction is not streamed",
            expected: "harmonics, or a species that is loaded whole (`SpeciesLight::load`)",
        },
    })
}

/// Follows beams through the plant, on all threads, and tells each with its number, in the order of the numbers.
fn for_each_beam(near: &Near, towards: &[[f64; 3]], mut tell: impl FnMut(usize, &Beam)) {
    in_order(
        towards.len(),
        |number| near.uncollided(towards[number], RAYS),
        |number, beam| tell(number, &beam),
    );
}

/// Makes something for each number on all threads, and takes what was made in the order of the numbers.
fn in_order<T: Send>(count: usize, make: impl Fn(usize) -> T + Sync, mut take: impl FnMut(usize, T)) {
    let threads = available_parallelism().map_or(1, |count| count.get());
    let numbers: Vec<usize> = (0..count).collect();
    for numbers in numbers.chunks(threads) {
        let made: Vec<T> = scope(|scope| {
            let make = &make;
            let running: Vec<_> = numbers.iter().map(|&number| scope.spawn(move || make(number))).collect();
            running.into_iter().map(|thread| thread.join().expect("the work does not panic")).collect()
        });
        numbers.iter().zip(made).for_each(|(&number, made)| take(number, made));
    }
}

/// Sums up the beams of all parts.
fn sites_of(
    medium: &MediumSites,
    species: &ResidentSpecies,
    parts: &[SkyPart],
    Weighted { weights, near: near_weights, mean }: &Weighted,
) -> Vec<OfSite> {
    let single = species.needs_single();
    let near = medium.near(single);
    let mut sites = vec![OfSite::default(); medium.sites().len()];
    // What the near beam's means are made of: of the even sky, then of each band of the sky.
    let of_near = if species.suns().has_near_beam() { sites.len() } else { 0 };
    let mut own: [Vec<f32>; 1 + BANDS] = std::array::from_fn(|_| vec![0.0; of_near]);
    let towards: Vec<[f64; 3]> = parts.iter().map(|part| part.towards).collect();
    for_each_beam(&near, &towards, |number, beam| {
        for (site, beam) in sites.iter_mut().zip(&beam.mean) {
            add_moments(site, towards[number], &weights[number], *beam);
        }
        for (own, weight) in own.iter_mut().zip(near_weights[number]) {
            own.iter_mut().zip(&beam.mean).for_each(|(sum, beam)| *sum += weight * beam);
        }
    });
    if of_near > 0 {
        add_near(&mut sites, &near, &own, means(single), *mean);
    }
    sites
}

/// The means of the near beam, which are linear in the beam, of the sums over the sky.
fn add_near(
    sites: &mut [OfSite],
    near: &Near,
    own: &[Vec<f32>; 1 + BANDS],
    count: usize,
    mean: [f32; BANDS],
) {
    let around = near.around_each(&own.each_ref().map(Vec::as_slice));
    for (place, site) in sites.iter_mut().enumerate() {
        for j in 0..count {
            let of = |of: usize| if j == 0 { own[of][place] } else { around[of][j - 1][place] };
            site.near[j] = of(0);
            (0..BANDS).for_each(|band| site.beyond[band][j] = of(1 + band) - mean[band] * of(0));
        }
    }
}

/// A number for the even sky and one for each band of the sky.
fn with(even: f32, [red, green, blue]: [f32; BANDS]) -> Weights {
    [even, red, green, blue]
}

/// The sum over all parts.
fn sum_of(weights: &[Weights]) -> Weights {
    std::array::from_fn(|of| weights.iter().map(|weights| f64::from(weights[of])).sum::<f64>() as f32)
}

/// A memory of the blocks last read.
pub(super) struct SkyCursor<'a> {
    sky: &'a SkyLight<'a>,
    species: &'a ResidentSpecies,
    cursor: Cursor<'a>,
    found: Vec<f32>,
}

impl SkyCursor<'_> {
    /// As [`SkyLight::add`].
    pub(super) fn add(&mut self, point_m: [f32; 3], facing: Option<[f32; 3]>, scale: f32, out: &mut [f32]) {
        let grid = self.species.grid();
        self.cursor.sample(grid.lattice_from_model(point_m.map(f64::from)), &mut self.found);
        self.sky.add_of(&self.found, point_m, facing, scale, out);
    }
}
