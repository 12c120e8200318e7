//! What a sun and a sky give the bases of a species that are there.

use std::ops::Range;

use flb_format::beam::MAX_MEANS;

use super::{LightLevel, ResidentSpecies};
use crate::sun_terms::{MAX_BASES, SunTerms};

/// Bands whose mean light [`Terms::constant`] holds.
const CONSTANT_BANDS: usize = 3;

/// What of a species is there, and how far it has taken the place of what stood in for it: 0 where it is not there,
/// 1 where it is shown in full.
pub(crate) struct Shown<'a> {
    /// Share of a base by its place.
    pub base: &'a dyn Fn(usize) -> f32,
    /// Share of the extinction.
    pub extinction: f32,
}

/// Factors that a sun and a sky give the bases of a species: `constant + sum of factor x base`. For what is missing the
/// mean light of the plant stands in, spread as the sky's light where that is there.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Terms {
    /// Irradiance of the sun, light of the sky.
    strengths: [f32; 2],
    /// Unit vector towards the sun, model space; zeros where there is no sun.
    towards_sun: [f64; 3],
    /// Of a sun of irradiance 1: places in the species' bases, and factors. A plant keeps its terms, and a scene has a
    /// million plants.
    sun: [u8; MAX_BASES],
    factors: [f32; MAX_BASES],
    len: u8,
    /// Place in the bases of the near beam's first coefficient, and their number.
    near: Option<(u8, u8)>,
    /// Factor of these, of a sun of irradiance 1.
    near_factor: f32,
    /// Factor of the sky's base in place of a sun of irradiance 1.
    stand_in: f32,
    /// Place of the sky's base.
    sky: Option<u8>,
    /// Factor of it under a sky of light 1.
    sky_factor: f32,
    /// Factor of it by which averages have the mean of all of it.
    of_averages: f32,
    /// Shares of a sun of irradiance 1 and of a sky of light 1 that the plant's mean light stands in for.
    missing: [f32; 2],
    /// What that is in the first bands, added to them.
    constants: [[f32; CONSTANT_BANDS]; 2],
    /// Completeness of the light.
    pub level: LightLevel,
}

/// Factors of parts of the light.
#[derive(Debug, Clone, Copy)]
pub(crate) struct Factors {
    /// Factor of the sun's bases.
    pub sun: f32,
    /// Factor of the near beam's bases.
    pub near: f32,
    /// Factor of the sky's base.
    pub sky: f32,
    /// Factors of the constants of the sun and of the sky.
    pub constants: [f32; 2],
}

impl Terms {
    /// A sun without a direction, of which there are no terms, sends nothing.
    pub(super) fn of(
        species: &ResidentSpecies,
        shown: &Shown,
        of_sun: Option<SunTerms>,
        strengths: [f32; 2],
    ) -> Terms {
        let sky =
            species.place(0).map(|place| (place, (shown.base)(place))).filter(|(_, shown)| *shown > 0.0);
        let mut terms = Terms {
            strengths,
            towards_sun: [0.0; 3],
            sun: [0; MAX_BASES],
            factors: [0.0; MAX_BASES],
            len: 0,
            near: None,
            near_factor: 0.0,
            stand_in: 0.0,
            sky: sky.map(|(place, _)| place as u8),
            sky_factor: sky.map_or(0.0, |(_, shown)| shown),
            of_averages: 1.0,
            missing: [0.0; 2],
            constants: [[0.0; CONSTANT_BANDS]; 2],
            level: LightLevel::Whole,
        };
        if let Some(of_sun) = of_sun.filter(|_| strengths[0] != 0.0) {
            terms.towards_sun = of_sun.towards_sun;
            let found = match of_sun.near_bases().is_empty() {
                true => terms.push_blend(species, &of_sun, shown),
                false => terms.push_harmonics(species, &of_sun, shown),
            };
            terms.missing[0] = 1.0 - found;
        }
        if strengths[1] != 0.0 {
            terms.missing[1] = 1.0 - terms.sky_factor;
        }
        if let Some(coded) = sky.and_then(|(place, _)| species.bases[place].as_ref()?.coded()) {
            terms.of_averages = species.mean.of_detail(coded.detail_share());
        }
        if terms.missing != [0.0; 2] {
            terms.stand_in =
                terms.missing[0] * terms.sky_factor * species.mean.sun_over_sky(terms.towards_sun);
            let (constant, bands) = (species.mean.constants(&terms), species.bands);
            terms.constants = [0, 1].map(|source| {
                std::array::from_fn(|band| if band < bands { constant(source, band) } else { 0.0 })
            });
            let nothing = terms.len == 0 && terms.sky.is_none();
            terms.level = if nothing { LightLevel::Outside } else { LightLevel::Other };
        }
        let near = terms.near_bases().0;
        let is_whole =
            |base: u16| species.bases[usize::from(base)].as_ref().is_some_and(|base| base.is_whole());
        if !terms.bases().map(|(base, _)| base).chain(near).all(is_whole) {
            terms.level = terms.level.min(LightLevel::Averages);
        }
        terms
    }

    /// The bases of a blend, those that are there in place of those that are not; how far they are shown.
    fn push_blend(&mut self, species: &ResidentSpecies, of_sun: &SunTerms, shown: &Shown) -> f32 {
        let place = |item: u8| species.place(item).map(|place| (place, (shown.base)(place)));
        let (mut there, mut all, mut most) = (0.0, 0.0, 0.0_f32);
        for (item, weight) in of_sun.bases() {
            all += weight;
            if let Some((_, shown)) = place(item).filter(|_| weight != 0.0) {
                there += weight * shown;
                most = most.max(shown);
            }
        }
        if there == 0.0 {
            return 0.0;
        }
        let scale = if there == all { 1.0 } else { most * all / there };
        for (item, weight) in of_sun.bases() {
            match place(item).filter(|(_, shown)| *shown > 0.0) {
                Some((place, shown)) => self.push(place, weight * shown * scale),
                None => self.level = LightLevel::Other,
            }
        }
        most
    }

    /// Harmonics and the near beam, once all of them and the extinction are there: some without the others are no
    /// light. How far they are shown.
    fn push_harmonics(&mut self, species: &ResidentSpecies, of_sun: &SunTerms, shown: &Shown) -> f32 {
        let near = of_sun.near_bases();
        let of_item = |item: u8| species.place(item).map_or(0.0, |place| (shown.base)(place));
        let all = of_sun.bases().map(|(item, _)| item).chain(near.clone());
        let shown = all.map(of_item).fold(shown.extinction, f32::min);
        let Some(first) = species.place(near.start).filter(|_| shown > 0.0) else { return 0.0 };
        for (item, y) in of_sun.bases() {
            species.place(item).into_iter().for_each(|place| self.push(place, y * shown));
        }
        self.near = Some((first as u8, near.len() as u8));
        self.near_factor = shown * of_sun.near_factor();
        shown
    }

    fn push(&mut self, base: usize, factor: f32) {
        if factor != 0.0 {
            self.sun[usize::from(self.len)] = base as u8;
            self.factors[usize::from(self.len)] = factor;
            self.len += 1;
        }
    }

    /// Factors of the sun's light and of the sky's, where these shares of them are left.
    pub(crate) fn factors(&self, [sun, sky]: [f32; 2]) -> Factors {
        let (sun, sky) = (self.strengths[0] * sun, self.strengths[1] * sky);
        Factors {
            sun,
            near: sun * self.near_factor,
            sky: (sky * self.sky_factor + sun * self.stand_in) * self.of_averages,
            constants: [sun, sky],
        }
    }

    /// Shares of a sun of irradiance 1 and of a sky of light 1 that the plant's mean light stands in for, and the
    /// factor of the sky's base in that.
    pub(super) fn missing(&self) -> ([f32; 2], f32) {
        (self.missing, self.stand_in)
    }

    /// Places in the species' bases, and what each of them is multiplied by at a point with these means of the near
    /// beam: the sun's, the near beam's, then the sky's.
    pub(crate) fn at_point(
        &self,
        factors: Factors,
        near: [f32; MAX_MEANS],
    ) -> impl Iterator<Item = (u16, f32)> {
        let of_sun = self.sun().map(move |(base, factor)| (base, factors.sun * factor));
        let of_beam = self.near_bases().0.zip(near).map(move |(base, near)| (base, factors.near * near));
        let of_sky = self.sky().map(|base| (base, factors.sky));
        of_sun.chain(of_beam).chain(of_sky).filter(|(_, factor)| *factor != 0.0)
    }

    /// Places in the species' bases and factors of a sun of irradiance 1.
    pub(crate) fn sun(&self) -> impl Iterator<Item = (u16, f32)> {
        let len = usize::from(self.len);
        self.sun[..len].iter().map(|place| u16::from(*place)).zip(self.factors[..len].iter().copied())
    }

    /// Place of the sky's base.
    pub(crate) fn sky(&self) -> Option<u16> {
        self.sky.map(u16::from)
    }

    /// Irradiance of the sun, light of the sky.
    pub(crate) fn strengths(&self) -> [f32; 2] {
        self.strengths
    }

    /// Places in the species' bases, and factors: the sun's, then the sky's.
    pub fn bases(&self) -> impl Iterator<Item = (u16, f32)> {
        let Factors { sun, sky, .. } = self.factors([1.0; 2]);
        let of_sky = self.sky().filter(|_| sky != 0.0).map(|place| (place, sky));
        self.sun().map(move |(base, factor)| (base, sun * factor)).chain(of_sky)
    }

    /// What is added to the first bands, of a sun of irradiance 1 and of a sky of light 1.
    pub(super) fn constants(&self) -> &[[f32; CONSTANT_BANDS]; 2] {
        &self.constants
    }

    /// Added to each of the first three bands.
    pub fn constant(&self) -> [f32; CONSTANT_BANDS] {
        let [sun, sky] = self.constants;
        std::array::from_fn(|band| self.strengths[0] * sun[band] + self.strengths[1] * sky[band])
    }

    /// Whether [`ResidentSpecies::light`] wants the near beam.
    pub fn needs_near(&self) -> bool {
        self.near.is_some()
    }

    /// Places in the species' bases of the near beam's coefficients, and the factor of all; empty where it needs none.
    pub fn near_bases(&self) -> (Range<u16>, f32) {
        let of = |(first, means): (u8, u8)| {
            (u16::from(first)..u16::from(first) + u16::from(means), self.strengths[0] * self.near_factor)
        };
        self.near.map_or((0..0, 0.0), of)
    }

    /// Unit vector towards the sun, model space; zeros where there is no sun.
    pub fn towards_sun(&self) -> [f64; 3] {
        self.towards_sun
    }
}
