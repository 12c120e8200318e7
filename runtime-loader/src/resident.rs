//! The loaded units of a library as light: what there is answers, and where something is missing what is coarser does.
//!
//! ```text
//! all of a base's detail > its averages > the other bases of the blend > the sky's base > a share of the light outside
//! ```
//!
//! Never black, and never of memory that was given back: a sample reads what `&self` holds, and units come and go
//! between frames, by `&mut self`.

use std::sync::Arc;

use flb_format::beam::MOST_MEANS;
use flb_format::blocks::{BlockFault, CodedBase, Shared, SpeciesPoint};
use flb_format::container::Container;
use flb_format::container::records::MAX_BANDS;
use flb_format::{Grid, SunBasis};

use crate::extinction::Extinction;
use crate::residency::{Runs, UnitId, UnitKind, Units};
use crate::{Marcher, SunTerms, physical};

/// Most terms of a sun's light: the sky, 16 harmonics, the means of the near beam, for which there is room for five.
pub const MOST_TERMS: usize = 22;
/// Share of the light outside that is taken to be left inside a plant of which nothing is loaded.
pub const UNKNOWN_SHARE: f32 = 0.25;
/// Means of the near beam where the extinction is not loaded: half of the plant is taken to be lit.
pub const UNKNOWN_BEAM: f32 = 0.5;

/// What a unit turns into.
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

/// What of the light is missing.
#[derive(Debug, Clone, Copy, PartialEq, Eq, PartialOrd, Ord)]
pub enum LightLevel {
    /// Nothing is loaded: a share of the light outside.
    Outside,
    /// Bases that the sun asks for are missing, others stand in.
    Other,
    /// All bases are there, and the detail of some blocks is not.
    Averages,
    /// All is there.
    Whole,
}

/// What a sun and a sky give the bases of a species: `constant + sum of factor x base`.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Terms {
    terms: [(u16, f32); MOST_TERMS],
    len: usize,
    /// Added to every band.
    pub constant: f32,
    /// What of it is missing.
    pub level: LightLevel,
    /// Place in the bases of the near beam's first coefficient, their number, and the sun's factor.
    near: Option<(u16, u16, f32)>,
}

impl Terms {
    fn none() -> Terms {
        Terms { terms: [(0, 0.0); MOST_TERMS], len: 0, constant: 0.0, level: LightLevel::Whole, near: None }
    }

    /// Places in the species' bases, and factors.
    pub fn bases(&self) -> &[(u16, f32)] {
        &self.terms[..self.len]
    }

    /// Whether [`ResidentSpecies::light`] wants the near beam.
    pub fn needs_near(&self) -> bool {
        self.near.is_some()
    }

    /// Places in the species' bases of the near beam's coefficients, and the factor of all; empty where it needs none.
    pub fn near_bases(&self) -> (std::ops::Range<u16>, f32) {
        self.near.map_or((0..0, 0.0), |(first, means, sun)| (first..first + means, sun))
    }

    fn push(&mut self, base: usize, factor: f32) {
        if factor != 0.0 {
            self.terms[self.len] = (base as u16, factor);
            self.len += 1;
        }
    }
}

/// What is loaded of a library.
#[derive(Debug)]
pub struct Resident {
    species: Vec<ResidentSpecies>,
}

/// What is loaded of a species.
#[derive(Debug)]
pub struct ResidentSpecies {
    grid: Grid,
    bands: usize,
    suns: SunBasis,
    /// Light of base 0 in empty space.
    open_sky: f32,
    /// `[base]`: item.
    items: Vec<u8>,
    shared: Option<Arc<Shared>>,
    extinction: Option<Box<Extinction>>,
    /// `[base]`
    bases: Vec<Option<Box<CodedBase>>>,
}

impl Resident {
    /// Nothing is loaded.
    pub fn new(container: &Container, units: &Units) -> Resident {
        let species = container.species().iter().enumerate().map(|(index, species)| {
            let meta = &species.meta;
            let items: Vec<u8> = units.bases(index).iter().map(|base| base.item).collect();
            ResidentSpecies {
                grid: meta.grid,
                bands: meta.band_count(),
                suns: meta.physical().map_or(SunBasis::Lattice18, |(_, light)| light.suns.clone()),
                open_sky: meta.model.empty_value(0),
                shared: None,
                extinction: None,
                bases: items.iter().map(|_| None).collect(),
                items,
            }
        });
        Resident { species: species.collect() }
    }

    /// What is loaded of a species.
    ///
    /// # Panics
    /// If there is no such species.
    pub fn species(&self, species: usize) -> &ResidentSpecies {
        &self.species[species]
    }

    /// Memory of everything loaded.
    pub fn size_bytes(&self) -> usize {
        self.species.iter().map(ResidentSpecies::size_bytes).sum()
    }

    /// Puts a unit in its place; one that it stands on is there.
    ///
    /// # Errors
    /// [`BlockFault`] for a page that is not of its base; nothing is changed.
    ///
    /// # Panics
    /// If the payload is not of the unit's kind, or what it stands on is not there.
    pub fn insert(&mut self, units: &Units, unit: UnitId, payload: Payload) -> Result<(), BlockFault> {
        let unit = units.get(unit);
        let species = &mut self.species[unit.species as usize];
        match (unit.kind, payload) {
            (UnitKind::Shared, Payload::Shared(shared, _)) => species.shared = Some(shared),
            (UnitKind::Extinction, Payload::Extinction(extinction)) => species.extinction = Some(extinction),
            (UnitKind::Averages { base }, Payload::Averages(coded)) => {
                assert!(species.shared.is_some(), "averages stand on a block map");
                species.bases[base as usize] = Some(coded);
            }
            (UnitKind::Detail { base, .. }, Payload::Detail(payload)) => {
                let base = species.bases[base as usize].as_mut().expect("detail stands on averages");
                base.add(unit.blocks[0], unit.blocks[1], &payload)?;
            }
            (kind, _) => panic!("a payload of another kind than {kind:?}"),
        }
        Ok(())
    }

    /// Drops a unit; nothing that stands on it is there any more.
    pub fn remove(&mut self, units: &Units, unit: UnitId) {
        let unit = units.get(unit);
        let species = &mut self.species[unit.species as usize];
        match unit.kind {
            UnitKind::Shared => species.shared = None,
            UnitKind::Extinction => species.extinction = None,
            UnitKind::Averages { base } => species.bases[base as usize] = None,
            UnitKind::Detail { base, .. } => {
                if let Some(base) = &mut species.bases[base as usize] {
                    base.remove(unit.blocks[0]);
                }
            }
        }
    }
}

impl ResidentSpecies {
    /// Where the lattice lies in model space.
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

    /// Whether the near beam of its suns needs light scattered once.
    pub fn needs_single(&self) -> bool {
        self.suns.needs_single()
    }

    /// What the bases share, once it is loaded.
    pub fn shared(&self) -> Option<&Arc<Shared>> {
        self.shared.as_ref()
    }

    /// A base by its place, once its averages are loaded.
    pub fn base(&self, base: usize) -> Option<&CodedBase> {
        self.bases.get(base)?.as_deref()
    }

    fn size_bytes(&self) -> usize {
        let bases: usize = self.bases.iter().flatten().map(|base| base.size_bytes()).sum();
        let extinction = self.extinction.as_ref().map_or(0, |extinction| extinction.size_bytes());
        bases + extinction + self.shared.as_ref().map_or(0, |shared| shared.size_bytes())
    }

    /// Items of its bases, ascending.
    pub fn items(&self) -> &[u8] {
        &self.items
    }

    /// What a sun along `towards_sun` (model space, any length but 0) and an even sky give each base that is there.
    /// Factors are of irradiance, as [`PhysicalSampler::fluence`](crate::PhysicalSampler::fluence) and
    /// [`SpeciesSampler::indirect`](crate::SpeciesSampler::indirect) take them.
    pub fn terms(&self, towards_sun: [f64; 3], sun: f32, sky: f32) -> Terms {
        self.terms_of(&|base| self.bases[base].is_some(), towards_sun, sun, sky)
    }

    /// The same where other bases are there than here, as on a GPU that takes its time; `is_there` is asked for their
    /// places. The level is still that of what is here.
    pub fn terms_of(
        &self,
        is_there: &dyn Fn(usize) -> bool,
        towards_sun: [f64; 3],
        sun: f32,
        sky: f32,
    ) -> Terms {
        let mut terms = Terms::none();
        let mut sky = sky;
        let place = |item: u8| self.items.binary_search(&item).ok().filter(|place| is_there(*place));
        if sun != 0.0 {
            let length = libm::sqrt(towards_sun.iter().map(|c| c * c).sum());
            // A vector that is no direction sends nothing.
            if let Some(of_sun) = SunTerms::of(&self.suns, towards_sun, towards_sun.map(|c| c / length)) {
                let unfound = match of_sun.near_bases().is_empty() {
                    true => self.push_blend(&of_sun, &place, sun, &mut terms),
                    false => self.push_harmonics(&of_sun, &place, sun, &mut terms),
                };
                sky += unfound / self.open_sky;
            }
        }
        if sky != 0.0 {
            match place(0) {
                Some(place) => terms.push(place, sky),
                None => {
                    terms.constant += UNKNOWN_SHARE * sky * self.open_sky;
                    let level = if terms.len > 0 { LightLevel::Other } else { LightLevel::Outside };
                    terms.level = terms.level.min(level);
                }
            }
        }
        let (near, _) = terms.near_bases();
        let is_whole = |base: u16| self.bases[usize::from(base)].as_ref().is_some_and(|base| base.is_whole());
        if !terms.bases().iter().map(|(base, _)| *base).chain(near).all(is_whole) {
            terms.level = terms.level.min(LightLevel::Averages);
        }
        terms
    }

    /// The bases of a blend, those that are there in place of those that are not; returns what no base could be
    /// found for, for the sky's to stand in.
    fn push_blend(
        &self,
        of_sun: &SunTerms,
        place: &dyn Fn(u8) -> Option<usize>,
        sun: f32,
        terms: &mut Terms,
    ) -> f32 {
        let (mut there, mut all) = (0.0, 0.0);
        for (item, weight) in of_sun.bases() {
            all += weight;
            if place(item).is_some() {
                there += weight;
            }
        }
        if there == 0.0 {
            terms.level = LightLevel::Other;
            return sun;
        }
        for (item, weight) in of_sun.bases() {
            match place(item) {
                Some(place) => terms.push(place, sun * weight * (all / there)),
                None => terms.level = LightLevel::Other,
            }
        }
        0.0
    }

    /// Harmonics and the near beam, once all of them are there: some without the others are no light. Returns the sun's
    /// factor where they are not, for the sky's base to stand in.
    fn push_harmonics(
        &self,
        of_sun: &SunTerms,
        place: &dyn Fn(u8) -> Option<usize>,
        sun: f32,
        terms: &mut Terms,
    ) -> f32 {
        let near = of_sun.near_bases();
        let harmonics: Option<Vec<(usize, f32)>> =
            of_sun.bases().map(|(item, y)| Some((place(item)?, y))).collect();
        let near: Option<Vec<usize>> = near.map(place).collect();
        let (Some(harmonics), Some(near)) = (harmonics, near) else {
            terms.level = LightLevel::Other;
            return sun;
        };
        harmonics.into_iter().for_each(|(place, y)| terms.push(place, sun * y));
        terms.near = Some((near[0] as u16, near.len() as u16, sun));
        if self.extinction.is_none() {
            terms.level = LightLevel::Other;
        }
        0.0
    }

    /// Means of the near beam at a point of model space, for a sun along the unit vector `towards_sun`, by marches
    /// ([`Marcher::near`]); [`UNKNOWN_BEAM`] where the extinction is not loaded.
    pub fn near(
        &self,
        point_model_m: [f32; 3],
        towards_sun: [f64; 3],
        offsets: &[[f32; 3]],
    ) -> [f32; MOST_MEANS] {
        let single = self.suns.needs_single();
        match &self.extinction {
            Some(extinction) => Marcher::of(extinction, single).near(point_model_m, towards_sun, offsets),
            None => physical::everywhere(UNKNOWN_BEAM, single),
        }
    }

    /// Light per band at a point of model space, from terms of this state of the species; never below 0. `near` is
    /// that of [`ResidentSpecies::near`] where [`Terms::needs_near`] says so, else it does not count.
    ///
    /// # Panics
    /// If `out` is not as long as the bands, or a base of the terms was dropped meanwhile.
    pub fn light(&self, terms: &Terms, near: [f32; MOST_MEANS], point_model_m: [f32; 3], out: &mut [f32]) {
        self.sum(terms, near, point_model_m, out);
        out.iter_mut().for_each(|value| *value = value.max(0.0));
    }

    /// The same for a part of the light, which may be below 0 where the whole is not.
    ///
    /// # Panics
    /// As [`ResidentSpecies::light`].
    pub fn sum(&self, terms: &Terms, near: [f32; MOST_MEANS], point_model_m: [f32; 3], out: &mut [f32]) {
        let point = self.grid.lattice_from_model(point_model_m.map(f64::from));
        out.fill(terms.constant);
        let mut place: Option<SpeciesPoint<'_>> = None;
        let mut one = [0.0; MAX_BANDS as usize];
        let one = &mut one[..self.bands];
        let mut add = |base: usize, factor: f32| {
            let base = self.bases[base].as_ref().expect("terms are of the bases that are there");
            // Bases that were read before and after their block map was dropped for a while do not share it.
            let place = match &mut place {
                Some(place) if place.is_among(base.shared()) => place,
                place => place.insert(SpeciesPoint::new(base.shared(), point)),
            };
            base.sample_at(place, one);
            out.iter_mut().zip(&*one).for_each(|(out, light)| *out += factor * light);
        };
        for (base, factor) in terms.bases() {
            add(usize::from(*base), *factor);
        }
        let (bases, sun) = terms.near_bases();
        bases.zip(near).for_each(|(base, near)| add(usize::from(base), sun * near));
    }
}

#[cfg(test)]
mod tests;
