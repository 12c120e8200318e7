//! What a sun and a sky give the bases of a species that are there.

use std::ops::Range;

use super::{LightLevel, ResidentSpecies, UNKNOWN_SHARE};
use crate::SunTerms;
use crate::sun_terms::MOST;

/// What a sun and a sky give the bases of a species: `constant + sum of factor x base`. Where bases are missing, others
/// stand in.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Terms {
    /// Irradiance of the sun, light of the sky.
    strengths: [f32; 2],
    /// Unit vector towards the sun, model space; zeros where there is no sun.
    towards_sun: [f64; 3],
    /// Of a sun of irradiance 1: places in the species' bases, and factors. A plant keeps its terms, and a scene has a
    /// million plants.
    sun: [u8; MOST],
    factors: [f32; MOST],
    len: u8,
    /// Place in the bases of the near beam's first coefficient, and their number.
    near: Option<(u8, u8)>,
    /// Factor of the sky's base in place of a sun of irradiance 1.
    stand_in: f32,
    /// Place of the sky's base.
    sky: Option<u8>,
    /// Added to every band: of a sun of irradiance 1, of a sky of light 1.
    constants: [f32; 2],
    /// What of it is missing.
    pub level: LightLevel,
}

/// Factors of parts of the light.
#[derive(Debug, Clone, Copy)]
pub(crate) struct Factors {
    /// Of the sun's bases and of the near beam's.
    pub sun: f32,
    /// Of the sky's base.
    pub sky: f32,
    /// Added to every band.
    pub constant: f32,
}

impl Terms {
    /// A sun without a direction, of which there are no terms, sends nothing.
    pub(super) fn of(
        species: &ResidentSpecies,
        is_there: &dyn Fn(usize) -> bool,
        of_sun: Option<SunTerms>,
        strengths: [f32; 2],
    ) -> Terms {
        let place = |item: u8| species.place(item).filter(|place| is_there(*place));
        let mut terms = Terms {
            strengths,
            towards_sun: [0.0; 3],
            sun: [0; MOST],
            factors: [0.0; MOST],
            len: 0,
            near: None,
            stand_in: 0.0,
            sky: place(0).map(|place| place as u8),
            constants: [0.0; 2],
            level: LightLevel::Whole,
        };
        if let Some(of_sun) = of_sun.filter(|_| strengths[0] != 0.0) {
            terms.towards_sun = of_sun.towards_sun;
            let is_found = match of_sun.near_bases().is_empty() {
                true => terms.push_blend(&of_sun, &place),
                false => terms.push_harmonics(species, &of_sun, &place),
            };
            if !is_found {
                terms.level = LightLevel::Other;
                terms.stand_in = 1.0 / species.open_sky;
            }
        }
        let sky_counts = strengths[1] != 0.0 || terms.stand_in != 0.0;
        if sky_counts && terms.sky.is_none() {
            let unknown = UNKNOWN_SHARE * species.open_sky;
            terms.constants = [terms.stand_in * unknown, unknown];
            terms.stand_in = 0.0;
            let level = if terms.len > 0 { LightLevel::Other } else { LightLevel::Outside };
            terms.level = terms.level.min(level);
        }
        let near = terms.near_bases().0;
        let is_whole =
            |base: u16| species.bases[usize::from(base)].as_ref().is_some_and(|base| base.is_whole());
        if !terms.bases().map(|(base, _)| base).chain(near).all(is_whole) {
            terms.level = terms.level.min(LightLevel::Averages);
        }
        terms
    }

    /// The bases of a blend, those that are there in place of those that are not; whether there is one.
    fn push_blend(&mut self, of_sun: &SunTerms, place: &dyn Fn(u8) -> Option<usize>) -> bool {
        let (mut there, mut all) = (0.0, 0.0);
        for (item, weight) in of_sun.bases() {
            all += weight;
            if place(item).is_some() {
                there += weight;
            }
        }
        if there == 0.0 {
            return false;
        }
        let scale = if there == all { 1.0 } else { all / there };
        for (item, weight) in of_sun.bases() {
            match place(item) {
                Some(place) => self.push(place, weight * scale),
                None => self.level = LightLevel::Other,
            }
        }
        true
    }

    /// Harmonics and the near beam, once all of them are there: some without the others are no light. Whether they are.
    fn push_harmonics(
        &mut self,
        species: &ResidentSpecies,
        of_sun: &SunTerms,
        place: &dyn Fn(u8) -> Option<usize>,
    ) -> bool {
        let near = of_sun.near_bases();
        let mut all = of_sun.bases().map(|(item, _)| item).chain(near.clone());
        let Some(first) = place(near.start).filter(|_| all.all(|item| place(item).is_some())) else {
            return false;
        };
        for (item, y) in of_sun.bases() {
            place(item).into_iter().for_each(|place| self.push(place, y));
        }
        self.near = Some((first as u8, near.len() as u8));
        if species.extinction.is_none() {
            self.level = LightLevel::Other;
        }
        true
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
        let [of_sun, of_sky] = self.constants;
        Factors { sun, sky: sky + sun * self.stand_in, constant: sun * of_sun + sky * of_sky }
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

    /// Added to every band.
    pub fn constant(&self) -> f32 {
        self.factors([1.0; 2]).constant
    }

    /// Whether [`ResidentSpecies::light`] wants the near beam.
    pub fn needs_near(&self) -> bool {
        self.near.is_some()
    }

    /// Places in the species' bases of the near beam's coefficients, and the factor of all; empty where it needs none.
    pub fn near_bases(&self) -> (Range<u16>, f32) {
        let of = |(first, means): (u8, u8)| {
            (u16::from(first)..u16::from(first) + u16::from(means), self.strengths[0])
        };
        self.near.map_or((0..0, 0.0), of)
    }

    /// Unit vector towards the sun, model space; zeros where there is no sun.
    pub fn towards_sun(&self) -> [f64; 3] {
        self.towards_sun
    }
}
