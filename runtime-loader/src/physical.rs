//! Light of a `physical` species at points of model space: stored fields and the near beam of the sun (SPEC.md, section
//! 10.4).
//!
//! ```text
//! PhysicalSampler + sun -prepare-> PreparedSun: the near beam of every non-empty site, sampled like a field
//! PhysicalSampler -> Marcher: the near beam of one point by marches through the extinction, for suns that are too many
//! ```
//!
//! Prepare for a sun that lights many points. March for a forest, where every instance turns the sun another way:
//! nothing is kept per instance, but a sample costs `1 + 3 x offsets` marches. `cargo bench -p flb-runtime --bench
//! physical` prints both prices; on an oak, three bands, degree 2, one core of a shared machine of two (rays of singly
//! scattered light are laid once for all suns; the others cost next to nothing). Marched with 1, 4 and 16 offsets a
//! sample is 3, 1.6 and 0.9 % off (rms), their mean less than 0.2 %:
//!
//! | lattice | suns | lay rays | prepare a sun | sample, prepared | marched, 1 offset | 4 offsets | 16 offsets |
//! |---|---|---|---|---|---|---|---|
//! | 64 | `sh2` | 14 ms | 240 ms | 4.6 us | 11 us | 18 us | 54 us |
//! | 64 | `sh2s` | 1.9 s | 230 ms | 3.2 us | 7 us | 15 us | 41 us |
//! | 128 | `sh2` | 110 ms | 1.4 s | 8.0 us | 20 us | 47 us | 137 us |
//! | 128 | `sh2s` | 5.1 s | 1.8 s | 8.0 us | 20 us | 48 us | 111 us |

pub(crate) mod dense;
mod march;

use std::path::PathBuf;

use flb_format::beam::{MOST_MEANS, Near};
use flb_format::container::Species;
use flb_format::sample::locate;
use flb_format::{FieldKind, FormatError, Grid, Place, SunBasis, Turbid, room};

#[cfg(all(test, feature = "gpu"))]
pub(crate) use march::CANDIDATES;
pub(crate) use march::everywhere;
pub use march::{Marcher, RayOffsets, offset, seed_of};

use crate::sampler::{known_species, no_base, other_model};
use crate::sun_terms::{near_bases, unit};
use crate::{Library, RuntimeError, SpeciesSampler, SunTerms};

/// No matter in a site.
const EMPTY: u32 = u32::MAX;

/// A `physical` species with all its fields and its extinction, ready to be sampled from any number of threads.
pub struct PhysicalSampler {
    path: PathBuf,
    species: Species,
    light: SpeciesSampler,
    field: FieldKind,
    suns: SunBasis,
    turbid: Turbid,
    /// Non-empty sites, ascending.
    sites: Vec<u32>,
    /// `[site]`: place in `sites`, or [`EMPTY`].
    place: Vec<u32>,
}

/// A sun made ready: its terms, and its near beam in every non-empty site where the species needs one.
#[derive(Debug, Clone, PartialEq)]
pub struct PreparedSun {
    /// What its direction gives each field.
    pub terms: SunTerms,
    /// `[place]`
    near: Vec<[f32; MOST_MEANS]>,
}

impl PreparedSun {
    /// Memory that it takes.
    pub fn size_bytes(&self) -> usize {
        size_of_val(&self.near[..])
    }
}

impl PhysicalSampler {
    /// Reads, verifies and keeps every base of a species, and its extinction.
    ///
    /// # Errors
    /// [`RuntimeError::NoSuchSpecies`]; [`RuntimeError::OtherModel`]; [`RuntimeError::Format`] for a page that fails
    /// its checks.
    pub fn load(library: &Library, species: usize) -> Result<PhysicalSampler, RuntimeError> {
        let entry = known_species(library, species)?;
        let Some((_, light)) = entry.meta.physical() else {
            return Err(other_model(library, entry, "physical"));
        };
        let bases: Vec<u8> = entry.bases.iter().map(|base| base.base).collect();
        let at_file = |source: FormatError| RuntimeError::Format {
            path: library.path().to_owned(),
            source: Box::new(source),
        };
        let turbid = library.container().read_turbid(library.source(), species).map_err(at_file)?;
        // A list of sites that grows is copied to one of twice its length.
        room::ask(Place::file(0), "sites with matter", 8 * turbid.grid.sites() as u64).map_err(at_file)?;
        let sites = turbid.sites();
        let mut place =
            room::filled(Place::file(0), "places of sites", EMPTY, turbid.grid.sites()).map_err(at_file)?;
        (0..).zip(&sites).for_each(|(at, &site)| place[site as usize] = at);
        let (field, suns) = (light.field, light.suns.clone());
        let light = SpeciesSampler::load_items(library, species, &bases)?;
        let (path, species) = (library.path().to_owned(), entry.clone());
        Ok(PhysicalSampler { path, species, light, field, suns, turbid, sites, place })
    }

    /// Where the lattice lies in model space.
    pub fn grid(&self) -> &Grid {
        self.light.grid()
    }

    /// Values per sample.
    pub fn bands(&self) -> usize {
        self.light.bands()
    }

    /// Whether the sun's beam is part of the sun's light.
    pub fn field(&self) -> FieldKind {
        self.field
    }

    /// How the fields depend on the sun.
    pub fn suns(&self) -> &SunBasis {
        &self.suns
    }

    /// The extinction, in m^-1.
    pub fn turbid(&self) -> &Turbid {
        &self.turbid
    }

    /// Memory that fields, extinction and lists take.
    pub fn size_bytes(&self) -> usize {
        let lists = (self.sites.len() + self.place.len()) * 4;
        self.light.size_bytes() + self.turbid.leaf_per_m.len() * 8 + lists
    }

    /// All of its fields, by their bases.
    pub(crate) fn fields(&self) -> &SpeciesSampler {
        &self.light
    }

    /// Why it has no such basis.
    pub(crate) fn no_base(&self, base: u8) -> RuntimeError {
        no_base(&self.path, &self.species, base)
    }

    /// Whether there is light of the sky; a file of lattice directions may have been made without.
    pub fn has_sky(&self) -> bool {
        self.light.has_base(0)
    }

    /// What a sun that stands in direction `towards_sun` (model space, any length) gives each field.
    ///
    /// # Errors
    /// [`RuntimeError::NoDirection`] for a vector that is zero or not finite; where the species holds lattice
    /// directions and has not one that the sun needs, [`RuntimeError::LeftOut`] or [`RuntimeError::MissingBase`].
    pub fn terms(&self, towards_sun: [f64; 3]) -> Result<SunTerms, RuntimeError> {
        let terms = unit(towards_sun).and_then(|unit| SunTerms::of(&self.suns, towards_sun, unit));
        let terms = terms.ok_or(RuntimeError::NoDirection { found: towards_sun })?;
        match terms.bases().map(|(base, _)| base).filter(|base| !self.light.has_base(*base)).min() {
            Some(missing) => Err(self.no_base(missing)),
            None => Ok(terms),
        }
    }

    /// What makes near beams of suns: sums of the extinction over the cubes, and rays for light scattered once where
    /// the fields need it. Build it once for many suns.
    pub fn near(&self) -> Near<'_> {
        Near::new(&self.turbid, &self.sites, self.suns.needs_single())
    }

    /// The near beam of a sun in every non-empty site; `rays` per site edge (2 do) find the beam. Nothing is computed
    /// for a species of directions.
    pub fn prepare(&self, near: &Near, terms: SunTerms, rays: u32) -> PreparedSun {
        let mut all = Vec::new();
        if self.suns.first_near_item().is_some() {
            let beam = near.beam(terms.towards_sun, rays);
            let means = 1 + beam.around.len();
            let mean = |j, site| if j < means { beam.mean(j, site) } else { 0.0 };
            all = (0..self.sites.len()).map(|site| std::array::from_fn(|j| mean(j, site))).collect();
        }
        PreparedSun { terms, near: all }
    }

    /// A sun of a species without near beams: nothing but its terms.
    pub(crate) fn prepared_blend(&self, terms: SunTerms) -> PreparedSun {
        PreparedSun { terms, near: Vec::new() }
    }

    /// Fluence per band at a point of model space: `sun` times the light of the prepared sun (scattered or total,
    /// [`PhysicalSampler::field`]) plus `sky` times that of the even sky, never below 0. Points outside the lattice
    /// take the value of the nearest point of it.
    ///
    /// # Panics
    /// If `out` is shorter than the bands, or `sky` is not 0 and the species has no base 0.
    pub fn fluence(
        &self,
        prepared: &PreparedSun,
        sun: f32,
        sky: f32,
        point_model_m: [f32; 3],
        out: &mut [f32],
    ) {
        let near = match self.suns.first_near_item() {
            Some(_) if sun != 0.0 => self.near_at(prepared, point_model_m),
            _ => [0.0; MOST_MEANS],
        };
        self.fluence_of(&prepared.terms, near, sun, sky, point_model_m, out);
    }

    /// The same with means of the near beam that the caller has found, as by [`Marcher::near`].
    ///
    /// # Panics
    /// As [`PhysicalSampler::fluence`].
    pub fn fluence_of(
        &self,
        terms: &SunTerms,
        near: [f32; MOST_MEANS],
        sun: f32,
        sky: f32,
        point_model_m: [f32; 3],
        out: &mut [f32],
    ) {
        let expected = near_bases(&self.suns);
        assert_eq!(terms.near_bases(), expected, "terms of a species whose suns are stored in another way");
        let out = &mut out[..self.bands()];
        self.light.sum(terms, near, [sun, sky], point_model_m, out);
        out.iter_mut().for_each(|value| *value = value.max(0.0));
    }

    /// Light of the even sky of fluence 1 alone, per band.
    ///
    /// # Panics
    /// If the species has no base 0, or `out` is shorter than the bands.
    pub fn sky(&self, point_model_m: [f32; 3], out: &mut [f32]) {
        let out = &mut out[..self.bands()];
        out.fill(0.0);
        self.light.at(point_model_m).add(0, 1.0, out);
        out.iter_mut().for_each(|value| *value = value.max(0.0));
    }

    /// Means of the near beam at a point: over the non-empty of the eight sites, by their trilinear weights; where
    /// there are none, the beam at the point itself, and no light scattered once.
    ///
    /// # Panics
    /// If the species has no near beam, or the sun was prepared for another medium.
    pub fn near_at(&self, prepared: &PreparedSun, point_model_m: [f32; 3]) -> [f32; MOST_MEANS] {
        let (mut sum, mut weights) = ([0.0; MOST_MEANS], 0.0);
        self.around(point_model_m, |place, w| {
            let near = &prepared.near[place];
            sum.iter_mut().zip(near).for_each(|(sum, near)| *sum += w * near);
            weights += w;
        });
        if weights > 0.0 {
            return sum.map(|sum| sum / weights);
        }
        let point = self.grid().lattice_from_model(point_model_m.map(f64::from));
        let beam = dense::transmittance(&self.turbid, point, prepared.terms.towards_sun);
        march::everywhere(beam, self.suns.needs_single())
    }

    /// Number of non-empty sites.
    pub(crate) fn site_count(&self) -> usize {
        self.sites.len()
    }

    /// Tells the places of the non-empty ones of the eight sites around a point, with their trilinear weights.
    pub(crate) fn around(&self, point_model_m: [f32; 3], mut tell: impl FnMut(usize, f32)) {
        let grid = self.grid();
        let at = locate(grid.lattice, grid.lattice_from_model(point_model_m.map(f64::from)));
        let n = grid.lattice as usize;
        let mut first = [0; 3];
        let mut weight = [[0.0; 2]; 3];
        for axis in 0..3 {
            let texel = at.block[axis] as f32 * flb_format::block::STRIDE as f32 + at.local[axis];
            first[axis] = (texel as usize).min(n - 2);
            let t = texel - first[axis] as f32;
            weight[axis] = [1.0 - t, t];
        }
        for corner in 0..8 {
            let [x, y, z] = [corner & 1, corner >> 1 & 1, corner >> 2];
            let site = ((first[2] + z) * n + first[1] + y) * n + first[0] + x;
            let place = self.place[site];
            if place != EMPTY {
                tell(place as usize, weight[0][x] * weight[1][y] * weight[2][z]);
            }
        }
    }
}

#[cfg(test)]
mod tests;
