//! The loaded units of a library as light: what there is answers, and where something is missing what is coarser does.
//!
//! ```text
//! all of a base's detail > its averages > the other bases of the blend > the plant's mean, spread as the sky's base
//!     > the plant's mean
//! ```
//!
//! Whatever is loaded, the mean light of the plant is right. What has just come takes the place of what stood in for it
//! over some frames ([`Resident::advance`]), so that nothing flashes.
//!
//! Never black, and never of memory that was given back: a sample reads what `&self` holds, and units come and go
//! between frames, by `&mut self`.

mod all;
mod generation;
mod mean;
mod one_base;
mod terms;

use std::sync::{Arc, OnceLock};

use flb_format::beam::{MAX_MEANS, Near};
use flb_format::blocks::{CodedBase, Shared};
use flb_format::container::Species;
use flb_format::light::SunBasis;
use flb_format::{FormatError, Grid};

use crate::base::{Base, SamplePoint, read_base};
use crate::entry::{known_species, no_base};
use crate::extinction::Extinction;
use crate::near_beam::{Marcher, MediumSites, everywhere};
use crate::residency::Runs;
use crate::sun_terms::{SpeciesSuns, SunTerms, unit};
use crate::{Library, RuntimeError};
pub use all::Resident;
use mean::Mean;
pub(crate) use terms::Shown;
pub use terms::Terms;

/// Largest number of terms of a sun's light: the sky, 16 harmonics, the means of the near beam, for which there is room
/// for five.
pub const MAX_TERMS: usize = 22;
/// Share of the light outside that is taken to be left inside a plant of which nothing is loaded.
pub const UNKNOWN_SHARE: f32 = 0.25;
/// Means of the near beam where the extinction is not loaded: half of the plant is taken to be lit.
pub const UNKNOWN_BEAM: f32 = 0.5;

/// How far the square of a length may be from 1 for a direction to be marched along as it is given.
const ROUNDED: f64 = 1e-5;

/// Decoded content of a unit.
#[derive(Debug)]
pub enum Payload {
    /// Block map and class tables, with the boxes of the blocks.
    Shared(Arc<Shared>, Runs),
    /// Extinction, where there is some.
    Extinction(Box<Extinction>),
    /// A base without its detail.
    Averages(Box<CodedBase>),
    /// Payload of a page of detail.
    Detail(Vec<u8>),
}

/// Completeness of the light, the least complete first.
#[derive(Debug, Clone, Copy, PartialEq, Eq, PartialOrd, Ord)]
pub enum LightLevel {
    /// Nothing is loaded: the mean light of the plant.
    Outside,
    /// Bases that the sun asks for or the extinction are missing or have just come; what is there stands in.
    Other,
    /// All bases are there, and the detail of some blocks is not.
    Averages,
    /// All is there.
    Whole,
}

/// Loaded units of a species.
#[derive(Debug, Clone)]
pub struct ResidentSpecies {
    grid: Grid,
    bands: usize,
    suns: SpeciesSuns,
    mean: Mean,
    /// Its medium has an extinction.
    has_extinction: bool,
    /// Its light is never below 0.
    is_bounded: bool,
    /// `[base]`: item.
    items: Vec<u8>,
    shared: Option<Arc<Shared>>,
    extinction: Option<Arc<Extinction>>,
    /// The same at all sites, once it is asked for or where it was read so.
    sites: OnceLock<Arc<MediumSites>>,
    /// `[base]`
    bases: Vec<Option<Base>>,
    /// `[base]`, and of the extinction: frames that it has been there, at most [`Self::blend_frames`].
    ages: Vec<u16>,
    extinction_age: u16,
    /// Frames over which what comes takes the place of what stood in for it, 1 or more.
    blend_frames: u16,
    /// How often its terms have changed.
    generation: u64,
}

impl ResidentSpecies {
    /// Nothing is loaded; `items` are those that its bases will have, ascending.
    fn empty(species: &Species, items: Vec<u8>) -> ResidentSpecies {
        let meta = &species.meta;
        ResidentSpecies {
            grid: meta.grid,
            bands: meta.band_count(),
            suns: SpeciesSuns::of(&meta.model),
            mean: Mean::of(meta),
            has_extinction: meta.model.has_extinction(),
            is_bounded: meta.model.is_bounded(),
            shared: None,
            extinction: None,
            sites: OnceLock::new(),
            bases: items.iter().map(|_| None).collect(),
            ages: vec![0; items.len()],
            extinction_age: 0,
            blend_frames: 1,
            generation: 0,
            items,
        }
    }

    /// Reads, verifies and keeps bases of a species (repeats are ignored), whatever their codec, and the extinction of
    /// one of the model `physical`.
    ///
    /// # Errors
    /// [`RuntimeError::NoSuchSpecies`]; for the first base that the file does not hold (before any page is read)
    /// [`RuntimeError::LeftOut`] if the file says so, else [`RuntimeError::MissingBase`]; [`RuntimeError::Format`] for
    /// a page that fails its checks.
    pub fn load(library: &Library, species: usize, bases: &[u8]) -> Result<ResidentSpecies, RuntimeError> {
        let (container, entry) = (library.container(), known_species(library, species)?);
        if let Some(missing) = bases.iter().find(|base| container.find_base(species, **base).is_none()) {
            return Err(no_base(library.path(), entry, *missing));
        }
        let at_library = |source: FormatError| RuntimeError::Format {
            path: library.path().to_owned(),
            source: Box::new(source),
        };
        let mut items = bases.to_vec();
        items.sort_unstable();
        items.dedup();
        let mut loaded = ResidentSpecies::empty(entry, items);
        if loaded.has_extinction {
            let turbid = container.read_turbid(library.source(), species).map_err(at_library)?;
            let sites = MediumSites::new(turbid).map_err(at_library)?;
            if loaded.suns().has_near_beam() {
                loaded.extinction = Some(Arc::new(Extinction::of(sites.turbid())));
                loaded.extinction_age = 1;
            }
            loaded.sites = OnceLock::from(Arc::new(sites));
        }
        if entry.blocks.is_some() && !bases.is_empty() {
            loaded.shared = Some(container.read_shared(library.source(), species).map_err(at_library)?);
        }
        for (item, base) in loaded.items.iter().zip(&mut loaded.bases) {
            let read = read_base(library, species, *item, loaded.shared.as_ref());
            *base = Some(read.map_err(at_library)?);
        }
        loaded.ages.fill(1);
        Ok(loaded)
    }

    /// Grid of the lattice in model space.
    pub fn grid(&self) -> &Grid {
        &self.grid
    }

    /// Values per sample.
    pub fn bands(&self) -> usize {
        self.bands
    }

    /// Extinction, once it is loaded, of a species whose suns need a near beam.
    pub fn extinction(&self) -> Option<&Extinction> {
        self.extinction.as_deref()
    }

    /// Whether the near beam of the species' suns needs light scattered once.
    pub fn needs_single(&self) -> bool {
        self.suns().needs_single()
    }

    /// Block map and detail coding that the bases share, once they are loaded.
    pub fn shared(&self) -> Option<&Arc<Shared>> {
        self.shared.as_ref()
    }

    /// A base by its place, once its averages are loaded.
    pub fn base(&self, base: usize) -> Option<&CodedBase> {
        self.bases.get(base)?.as_ref()?.coded()
    }

    /// Memory that everything loaded takes.
    pub fn size_bytes(&self) -> usize {
        let bases: usize = self.bases.iter().flatten().map(Base::size_bytes).sum();
        let extinction = self.extinction.as_ref().map_or(0, |extinction| extinction.size_bytes());
        let sites = self.sites.get().map_or(0, |sites| sites.size_bytes());
        bases + extinction + sites + self.shared.as_ref().map_or(0, |shared| shared.size_bytes())
    }

    /// How its light depends on the sun.
    pub(crate) fn suns(&self) -> &SunBasis {
        self.suns.basis()
    }

    /// The same with what a sun's direction does to its near beam.
    pub(crate) fn species_suns(&self) -> &SpeciesSuns {
        &self.suns
    }

    /// Whether its medium has an extinction, whether that is loaded or not.
    pub(crate) fn has_extinction(&self) -> bool {
        self.has_extinction
    }

    /// Mean light of a sky of 1 in a band.
    pub(crate) fn mean_of_sky(&self, band: usize) -> f32 {
        self.mean.of_sky(band)
    }

    /// How far what has been there for so many frames is shown, 0..=1.
    pub(crate) fn shown(&self, age: u16) -> f32 {
        f32::from(age.min(self.blend_frames)) / f32::from(self.blend_frames)
    }

    /// Place in the bases of an item that is loaded.
    pub(crate) fn place(&self, item: u8) -> Option<usize> {
        // Of a species that is whole, an item is at its own place.
        let place = match self.items.get(usize::from(item)) {
            Some(at) if *at == item => usize::from(item),
            _ => self.items.binary_search(&item).ok()?,
        };
        self.bases[place].is_some().then_some(place)
    }

    /// The base of an item that is loaded.
    pub(crate) fn item(&self, item: u8) -> Option<&Base> {
        self.bases[self.place(item)?].as_ref()
    }

    /// The first basis of a sun that is not loaded, the near beam's left out.
    pub(crate) fn lacks(&self, terms: &SunTerms) -> Option<u8> {
        terms.bases().map(|(base, _)| base).filter(|base| self.item(*base).is_none()).min()
    }

    /// A point of model space to sample bases at.
    pub(crate) fn point(&self, point_model_m: [f32; 3]) -> SamplePoint<'_> {
        SamplePoint::new(self.grid.lattice, self.grid.lattice_from_model(point_model_m.map(f64::from)))
    }

    /// The sites of its medium, made for the first who asks; `None` where the extinction is not loaded.
    pub(crate) fn sites(&self) -> Option<&Arc<MediumSites>> {
        if let (None, Some(extinction)) = (self.sites.get(), &self.extinction) {
            return Some(self.sites.get_or_init(|| Arc::new(MediumSites::of(extinction))));
        }
        self.sites.get()
    }

    /// Number of sites that hold matter; 0 where the extinction is not loaded. Their list is not made for it.
    pub(crate) fn matter_sites(&self) -> usize {
        match (self.sites.get(), &self.extinction) {
            (Some(sites), _) => sites.sites().len(),
            (None, Some(extinction)) => extinction.depths().len(),
            (None, None) => 0,
        }
    }

    /// Sums that the near beams of all its suns share; `None` where they need no near beam, and where the extinction is
    /// not loaded.
    pub(crate) fn near_sums(&self) -> Option<Near<'_>> {
        let sites = self.sites().filter(|_| self.suns().has_near_beam())?;
        Some(sites.near(self.needs_single()))
    }

    /// Items of its bases, ascending.
    pub fn items(&self) -> &[u8] {
        &self.items
    }

    /// Factors that a sun along `towards_sun` (model space, any length) and an even sky give each base that is there. A
    /// sun that has no direction sends nothing. Factors are of irradiance, as [`crate::Daylight`] has them.
    pub fn terms(&self, towards_sun: [f64; 3], sun: f32, sky: f32) -> Terms {
        self.with_all_shown(|shown| self.terms_of(shown, towards_sun, sun, sky))
    }

    /// The same by what the sun's direction gives each basis.
    pub(crate) fn terms_by(&self, of_sun: Option<SunTerms>, sun: f32, sky: f32) -> Terms {
        self.with_all_shown(|shown| Terms::of(self, shown, of_sun, [sun, sky]))
    }

    fn with_all_shown<T>(&self, call: impl FnOnce(&Shown) -> T) -> T {
        let base = |place: usize| self.shown(self.ages[place]);
        call(&Shown { base: &base, extinction: self.shown(self.extinction_age) })
    }

    /// The same where less is there than here, or has come later, as on a GPU that takes its time.
    pub(crate) fn terms_of(&self, shown: &Shown, towards_sun: [f64; 3], sun: f32, sky: f32) -> Terms {
        let of_sun = if sun != 0.0 { SunTerms::of(&self.suns, towards_sun) } else { None };
        Terms::of(self, shown, of_sun, [sun, sky])
    }

    /// Means of the near beam at a point of model space, for a sun along `towards_sun` (any length; nothing comes from
    /// one without a direction), by marches ([`Marcher::near`]); [`UNKNOWN_BEAM`] where the extinction is not loaded.
    pub fn near(
        &self,
        point_model_m: [f32; 3],
        towards_sun: [f64; 3],
        offsets: &[[f32; 3]],
    ) -> [f32; MAX_MEANS] {
        let single = self.suns().needs_single();
        let squared: f64 = towards_sun.iter().map(|c| c * c).sum();
        let is_unit = (squared - 1.0).abs() < ROUNDED;
        let towards_sun = if is_unit { Some(towards_sun) } else { unit(towards_sun) };
        let Some(towards_sun) = towards_sun else { return [0.0; MAX_MEANS] };
        match &self.extinction {
            Some(extinction) => Marcher::of(extinction, single).near(point_model_m, towards_sun, offsets),
            None => everywhere(UNKNOWN_BEAM, single),
        }
    }

    /// Light per band at a point of model space, from terms of this state of the species; of the model `physical`
    /// never below 0. `near` is that of [`ResidentSpecies::near`] where [`Terms::needs_near`] says so, else it does not
    /// count.
    ///
    /// Where a base of the terms was dropped since, it is the light of what is there now.
    ///
    /// # Panics
    /// If `out` is not as long as the bands.
    pub fn light(&self, terms: &Terms, near: [f32; MAX_MEANS], point_model_m: [f32; 3], out: &mut [f32]) {
        self.sum_of(terms, near, [1.0; 2], point_model_m, out);
        self.bound(out);
    }

    /// The same where shares of the sun's light and of the sky's are left, not bounded.
    pub(crate) fn sum_of(
        &self,
        terms: &Terms,
        near: [f32; MAX_MEANS],
        shares: [f32; 2],
        point_model_m: [f32; 3],
        out: &mut [f32],
    ) {
        if !self.add_terms(terms, near, shares, point_model_m, out) {
            let [sun, sky] = terms.strengths();
            self.add_terms(&self.terms(terms.towards_sun(), sun, sky), near, shares, point_model_m, out);
        }
    }

    /// Sums up what terms ask for; whether all of it is there.
    fn add_terms(
        &self,
        terms: &Terms,
        near: [f32; MAX_MEANS],
        shares: [f32; 2],
        point_model_m: [f32; 3],
        out: &mut [f32],
    ) -> bool {
        let factors = terms.factors(shares);
        self.fill(terms, factors.constants, out);
        let mut point = self.point(point_model_m);
        for (base, factor) in terms.at_point(factors, near) {
            let Some(Some(base)) = self.bases.get(usize::from(base)) else { return false };
            point.add(base, factor, out);
        }
        true
    }

    /// Sets light to what is added to each band, by these factors of the sun's part and of the sky's.
    pub(crate) fn fill(&self, terms: &Terms, factors: [f32; 2], out: &mut [f32]) {
        if terms.missing().0 == [0.0; 2] {
            return out.fill(0.0);
        }
        let first = terms.constants();
        let all = (out.len() > first[0].len()).then(|| self.mean.constants(terms));
        for (band, out) in out.iter_mut().enumerate() {
            let constant = |source: usize| match &all {
                Some(all) => all(source, band),
                None => first[source][band],
            };
            *out = factors[0] * constant(0) + factors[1] * constant(1);
        }
    }

    /// Whether its light is never below 0.
    pub(crate) fn is_bounded(&self) -> bool {
        self.is_bounded
    }

    /// Takes off what is below 0 of light that never is.
    pub(crate) fn bound(&self, out: &mut [f32]) {
        if self.is_bounded {
            out.iter_mut().for_each(|value| *value = value.max(0.0));
        }
    }
}

#[cfg(test)]
mod tests;
