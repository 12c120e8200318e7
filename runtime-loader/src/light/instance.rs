//! The light of one plant under one sun and sky.
//!
//! Light of a file and streamed light add up in orders of their own, and scene light scales the first before the sum
//! and the second after it. Each order is kept, since bytes depend on the rounding: those of golden pictures, and of
//! whatever a caller makes of the light.

use std::sync::Arc;

use flb_format::Grid;
use flb_format::beam::{BEAM_RAYS, MOST_MEANS};

use super::Daylight;
use super::file::FileLight;
use super::sky::SkyLight;
use crate::resident::{LightLevel, ResidentSpecies, Terms};
use crate::scene_light::export::luminance;
use crate::scene_light::{Modulations, SceneLightAtSun};
use crate::sun_terms::unit;
use crate::{Marcher, PhysicalSampler, PreparedSun, RayOffsets, RuntimeError, SunTerms, seed_of};

/// How far the square of a length may be from 1 for a direction to be marched along as it is given.
const ROUNDED: f64 = 1e-5;

/// The light of one plant, to be asked at any number of points from any number of threads. It stays as it is while the
/// sun, the sky and the plant do; a new sun takes a new one ([`super::SpeciesLight::under`]).
pub struct InstanceLight<'a> {
    pub(super) kind: Kind<'a>,
    /// Irradiance of the sun, light of the sky.
    pub(super) strengths: [f32; 2],
    offsets: RayOffsets,
    /// What its neighbours do, and its number among them.
    among: Option<(&'a SceneLightAtSun<'a>, u32)>,
    /// Luminance of the sun and of the sky, by which neighbours add light.
    luminance: [f32; 2],
    /// Factor on the sun's light per band; `None` is 1.
    color: Option<[f32; 3]>,
    /// In the place of an even sky.
    uneven: Option<&'a SkyLight<'a>>,
}

pub(super) enum Kind<'a> {
    File { file: &'a FileLight, sun: Option<(SunTerms, Beam<'a>)> },
    Streamed(Box<Streamed<'a>>),
}

/// Where the near beam of a file's species comes from.
pub(super) enum Beam<'a> {
    /// It needs none.
    None,
    /// From marches at each point.
    Marched(&'a PhysicalSampler),
    /// From all sites, found beforehand.
    Prepared(&'a PhysicalSampler, Arc<PreparedSun>),
}

/// Light of what a streamer has loaded.
pub(super) struct Streamed<'a> {
    pub species: &'a ResidentSpecies,
    /// In the model's frame, as it was given.
    towards_sun: [f64; 3],
    /// What it is marched along.
    unit: [f64; 3],
    pub terms: Terms,
    /// Of the sun and of the sky alone, where neighbours leave other shares of each.
    pub apart: Option<[Terms; 2]>,
}

impl<'a> InstanceLight<'a> {
    pub(super) fn of_file(
        file: &'a FileLight,
        daylight: &Daylight,
    ) -> Result<InstanceLight<'a>, RuntimeError> {
        let mut sun = None;
        if daylight.sun != 0.0 {
            let terms = file.terms(daylight.towards_sun)?;
            let beam = match file.physical() {
                Some(sampler) if !terms.near_bases().is_empty() => Beam::Marched(sampler),
                _ => Beam::None,
            };
            sun = Some((terms, beam));
        }
        if daylight.sky != 0.0 && !file.fields().has_base(0) {
            return Err(file.missing(0));
        }
        Ok(InstanceLight::new(Kind::File { file, sun }, daylight))
    }

    pub(super) fn streamed(species: &'a ResidentSpecies, daylight: &Daylight) -> InstanceLight<'a> {
        let Daylight { towards_sun, sun, sky } = *daylight;
        let squared: f64 = towards_sun.iter().map(|c| c * c).sum();
        let is_unit = (squared - 1.0).abs() < ROUNDED;
        let unit = if is_unit { towards_sun } else { unit(towards_sun).unwrap_or_default() };
        let terms = species.terms(towards_sun, sun, sky);
        let streamed = Streamed { species, towards_sun, unit, terms, apart: None };
        InstanceLight::new(Kind::Streamed(Box::new(streamed)), daylight)
    }

    fn new(kind: Kind<'a>, daylight: &Daylight) -> InstanceLight<'a> {
        let strengths = [daylight.sun, daylight.sky];
        let offsets = RayOffsets::new(1);
        InstanceLight {
            kind,
            strengths,
            offsets,
            among: None,
            luminance: strengths,
            color: None,
            uneven: None,
        }
    }

    /// The same among neighbours: `shade` is that of the same sun, and `instance` its number there.
    ///
    /// # Errors
    /// [`RuntimeError::Bands`] unless the light has three: scene light has the luminance of red, green and blue.
    ///
    /// # Panics
    /// In the light of a point, if the shade has no such instance.
    pub fn among(
        mut self,
        shade: &'a SceneLightAtSun<'a>,
        instance: u32,
    ) -> Result<InstanceLight<'a>, RuntimeError> {
        if self.bands() != 3 {
            return Err(RuntimeError::Bands { found: self.bands(), expected: 3 });
        }
        let [sun, sky] = self.strengths;
        if let Kind::Streamed(light) = &mut self.kind {
            let terms = |sun, sky| light.species.terms(light.towards_sun, sun, sky);
            light.apart = Some([terms(sun, 0.0), terms(0.0, sky)]);
        }
        Ok(InstanceLight { among: Some((shade, instance)), ..self })
    }

    /// The same under an uneven sky, which was made of the same species, and a coloured sun: its irradiance per band is
    /// multiplied. For a light that was made without an even sky. Of the sky, neighbours leave and add what they do of
    /// an even one.
    ///
    /// # Panics
    /// If the light has an even sky.
    #[must_use]
    pub fn with_sky(self, sky: &'a SkyLight<'a>, sun_color: [f32; 3]) -> InstanceLight<'a> {
        assert!(self.strengths[1] == 0.0, "one sky");
        let luminance = [self.strengths[0] * luminance(sun_color), luminance(sky.fluence())];
        InstanceLight { uneven: Some(sky), color: Some(sun_color), luminance, ..self }
    }

    /// The same for a picture of so many rays a pixel: the more there are, the fewer places each looks at for the near
    /// beam. Without it a point looks at as many as a pixel of one ray does.
    #[must_use]
    pub fn for_rays(self, rays: u32) -> InstanceLight<'a> {
        InstanceLight { offsets: RayOffsets::new(rays), ..self }
    }

    /// The same with the near beam found for all sites at once, where the species of a file needs one: a second or
    /// less, and then each point costs less than by marches and has less noise. For a plant that many points are asked
    /// of. Streamed light stays marched.
    #[must_use]
    pub fn prepared(self) -> InstanceLight<'a> {
        self.prepare(|sampler, terms| Arc::new(sampler.prepare(&sampler.near(), *terms, BEAM_RAYS)))
    }

    /// The same with the near beam of the same sun that was prepared for another file of the same medium, whose fields
    /// depend on the sun in the same way ([`InstanceLight::prepared_sun`]).
    #[must_use]
    pub fn prepared_as(self, other: &Arc<PreparedSun>) -> InstanceLight<'a> {
        self.prepare(|_, _| other.clone())
    }

    fn prepare(
        mut self,
        sun: impl FnOnce(&PhysicalSampler, &SunTerms) -> Arc<PreparedSun>,
    ) -> InstanceLight<'a> {
        if let Kind::File { sun: Some((terms, beam)), .. } = &mut self.kind
            && let Beam::Marched(sampler) = *beam
        {
            *beam = Beam::Prepared(sampler, sun(sampler, terms));
        }
        self
    }

    /// What [`InstanceLight::prepared`] found; `None` where nothing was, or nothing needed to be.
    pub fn prepared_sun(&self) -> Option<&Arc<PreparedSun>> {
        match &self.kind {
            Kind::File { sun: Some((_, Beam::Prepared(_, prepared))), .. } => Some(prepared),
            _ => None,
        }
    }

    /// The sun's beam at a point of the model at rest, metres, of a sun of irradiance 1: that of the point's own site
    /// in the mean. `None` where the light needs no near beam.
    pub fn beam_at(&self, point_m: [f32; 3]) -> Option<f32> {
        self.needs_near().then(|| self.near(point_m)[0])
    }

    /// Values per point.
    pub fn bands(&self) -> usize {
        match &self.kind {
            Kind::File { file, .. } => file.fields().bands(),
            Kind::Streamed(light) => light.species.bands(),
        }
    }

    /// What of the light is missing; nothing of a file's.
    pub fn level(&self) -> LightLevel {
        self.terms().map_or(LightLevel::Whole, |terms| terms.level)
    }

    /// What the sun and the sky give each base of a streamed species; `None` for one of a file.
    pub fn terms(&self) -> Option<&Terms> {
        match &self.kind {
            Kind::File { .. } => None,
            Kind::Streamed(light) => Some(&light.terms),
        }
    }

    /// Light per band at a point of the model at rest, metres: of the model `physical` fluence, without the sun's beam
    /// unless the fields hold it ([`flb_format::FieldKind`]). A point outside the lattice takes the light of the
    /// nearest point of it; a coordinate that is NaN counts as the lower end.
    ///
    /// # Panics
    /// If `out` is shorter than the bands.
    pub fn at(&self, point_m: [f32; 3], out: &mut [f32]) {
        self.at_facing(point_m, None, out);
    }

    /// The same for a point before a solid that faces some way (a unit vector): of an uneven sky more or less falls on
    /// it.
    ///
    /// # Panics
    /// If `out` is shorter than the bands.
    pub fn at_facing(&self, point_m: [f32; 3], facing: Option<[f32; 3]>, out: &mut [f32]) {
        let out = &mut out[..self.bands()];
        let modulation = self.modulation(point_m);
        self.of_sun_and_even_sky(point_m, &modulation, out);
        self.color(out);
        if let Some(sky) = self.uneven {
            sky.add(point_m, facing, modulation.sky.scale, out);
        }
        self.add(&modulation, out);
    }

    /// Colours light of the sun alone.
    pub(super) fn color(&self, out: &mut [f32]) {
        if let Some(color) = self.color {
            out.iter_mut().zip(color).for_each(|(out, color)| *out *= color);
        }
    }

    pub(super) fn uneven(&self) -> Option<&'a SkyLight<'a>> {
        self.uneven
    }

    fn of_sun_and_even_sky(&self, point_m: [f32; 3], modulation: &Modulations, out: &mut [f32]) {
        match &self.kind {
            Kind::File { file, sun } => {
                let strengths =
                    [self.strengths[0] * modulation.sun.scale, self.strengths[1] * modulation.sky.scale];
                match sun {
                    Some((terms, _)) => file.fields().sum(terms, self.near(point_m), strengths, point_m, out),
                    None => sky_alone(file, strengths[1], point_m, out),
                }
                if sun.is_some() && self.is_bounded() {
                    out.iter_mut().for_each(|value| *value = value.max(0.0));
                }
            }
            Kind::Streamed(light) => light.at(self.near(point_m), modulation, point_m, out),
        }
    }

    pub(super) fn grid(&self) -> &Grid {
        match &self.kind {
            Kind::File { file, .. } => file.fields().grid(),
            Kind::Streamed(light) => light.species.grid(),
        }
    }

    /// Whether the light is never below 0: of the model `paper` that of a file may be, by as much as its coding is off.
    pub(super) fn is_bounded(&self) -> bool {
        match &self.kind {
            Kind::File { file, .. } => file.physical().is_some(),
            Kind::Streamed(_) => true,
        }
    }

    fn needs_near(&self) -> bool {
        match &self.kind {
            Kind::File { sun, .. } => matches!(sun, Some((_, Beam::Marched(_) | Beam::Prepared(..)))),
            Kind::Streamed(light) => light.terms.needs_near(),
        }
    }

    /// Means of the near beam at a point, where the light needs them.
    pub(super) fn near(&self, point_m: [f32; 3]) -> [f32; MOST_MEANS] {
        let offsets =
            |call: &dyn Fn(&[[f32; 3]]) -> [f32; MOST_MEANS]| self.offsets.with(seed_of(point_m), call);
        match &self.kind {
            Kind::File { file, sun: Some((terms, Beam::Marched(sampler))) } => {
                let marcher = Marcher::of(file.extinction(sampler), sampler.suns().needs_single());
                offsets(&|offsets| marcher.near(point_m, terms.towards_sun, offsets))
            }
            Kind::File { sun: Some((_, Beam::Prepared(sampler, prepared))), .. } => {
                sampler.near_at(prepared, point_m)
            }
            Kind::Streamed(light) if light.terms.needs_near() => {
                offsets(&|offsets| light.species.near(point_m, light.unit, offsets))
            }
            _ => Default::default(),
        }
    }

    pub(super) fn is_among(&self) -> bool {
        self.among.is_some()
    }

    /// What neighbours do at a point.
    pub(super) fn modulation(&self, point_m: [f32; 3]) -> Modulations {
        self.among.map_or(Modulations::UNCHANGED, |(shade, instance)| shade.at(instance, point_m))
    }

    /// Adds what neighbours bring.
    pub(super) fn add(&self, modulation: &Modulations, out: &mut [f32]) {
        if self.is_among() {
            let [sun, sky] = self.luminance;
            modulation.add(sun, sky, out.try_into().expect("scene light is of three bands alone"));
        }
    }
}

/// Light of a file's sky. It is scaled at last: a sum that is scaled from the start rounds otherwise where fields are
/// uncoded.
fn sky_alone(file: &FileLight, sky: f32, point_m: [f32; 3], out: &mut [f32]) {
    match file.physical() {
        _ if sky == 0.0 => return out.fill(0.0),
        None => file.fields().sample(0, point_m, out),
        Some(sampler) => sampler.sky(point_m, out),
    }
    out.iter_mut().for_each(|value| *value *= sky);
}

impl Streamed<'_> {
    fn at(&self, near: [f32; MOST_MEANS], modulation: &Modulations, point_m: [f32; 3], out: &mut [f32]) {
        let Some([sun, sky]) = &self.apart else {
            return self.species.light(&self.terms, near, point_m, out);
        };
        let mut of_sky = [0.0; 3];
        self.species.sum(sun, near, point_m, out);
        self.species.sum(sky, Default::default(), point_m, &mut of_sky);
        for (light, sky) in out.iter_mut().zip(of_sky) {
            *light = (*light * modulation.sun.scale + sky * modulation.sky.scale).max(0.0);
        }
    }
}
