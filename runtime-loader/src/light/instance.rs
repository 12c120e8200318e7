//! The light of one plant under one sun and sky.

use std::sync::Arc;

use flb_format::beam::{BEAM_RAYS, MAX_MEANS, Near};

use super::Daylight;
use super::rings::Faded;
use super::sky::SkyLight;
use super::volume::FieldVolume;
use crate::RuntimeError;
use crate::near_beam::{MediumSites, PreparedSun, RayOffsets, seed_of};
use crate::resident::{LightLevel, ResidentSpecies, Terms};
use crate::scene_light::export::luminance;
use crate::scene_light::{Modulations, SceneLightAtSun};
use crate::sun_terms::SunTerms;

/// The light of one plant, to be asked at any number of points from any number of threads. It stays as it is while the
/// sun, the sky and the plant do; a new sun takes a new one ([`super::SpeciesLight::lit_by`]).
pub struct InstanceLight<'a> {
    pub(super) species: &'a ResidentSpecies,
    pub(super) terms: Terms,
    /// The near beam at all sites, found beforehand; else it is marched for.
    prepared: Option<(&'a MediumSites, Prepared)>,
    offsets: RayOffsets,
    /// What its neighbours do, and its number among them.
    among: Option<(&'a SceneLightAtSun<'a>, u32)>,
    /// Luminance of the sun and of the sky, by which neighbours add light.
    luminance: [f32; 2],
    /// Factor on the sun's light per band; `None` is 1.
    color: Option<[f32; 3]>,
    /// In the place of an even sky.
    uneven: Option<&'a SkyLight<'a>>,
    /// In the place of the coded fields.
    fields: Option<&'a FieldVolume>,
}

/// The near beam of a sun, found beforehand.
#[derive(Debug, Clone)]
enum Prepared {
    Sun(Arc<PreparedSun>),
    Rings(Faded),
}

/// The light of one plant to be kept from frame to frame, without a borrow of its species
/// ([`super::SpeciesLight::lit_again`]).
#[derive(Debug, Clone)]
pub struct KeptLight {
    terms: Terms,
    prepared: Option<Prepared>,
    offsets: RayOffsets,
    generation: u64,
}

impl<'a> InstanceLight<'a> {
    /// The light of kept terms, where they are those of the species as it is.
    pub(super) fn of_kept(species: &'a ResidentSpecies, kept: &KeptLight) -> Option<InstanceLight<'a>> {
        if kept.generation != species.generation() {
            return None;
        }
        let lit = InstanceLight { offsets: kept.offsets, ..InstanceLight::of_terms(species, kept.terms) };
        Some(match &kept.prepared {
            Some(prepared) => lit.prepare(|_, _, _| prepared.clone()),
            None => lit,
        })
    }

    /// Returns what can be kept of the light: all but neighbours, an uneven sky and its sun's colour, which have
    /// borrows of their own.
    pub fn keep(&self) -> KeptLight {
        KeptLight {
            terms: self.terms,
            prepared: self.prepared.as_ref().map(|(_, prepared)| prepared.clone()),
            offsets: self.offsets,
            generation: self.species.generation(),
        }
    }

    /// Of a daylight whose numbers are finite.
    pub(crate) fn new(species: &'a ResidentSpecies, daylight: &Daylight) -> InstanceLight<'a> {
        let Daylight { towards_sun, sun, sky } = *daylight;
        InstanceLight::of_terms(species, species.terms(towards_sun, sun, sky))
    }

    fn of_terms(species: &'a ResidentSpecies, terms: Terms) -> InstanceLight<'a> {
        InstanceLight {
            species,
            terms,
            prepared: None,
            offsets: RayOffsets::new(1),
            among: None,
            luminance: terms.strengths(),
            color: None,
            uneven: None,
            fields: None,
        }
    }

    /// Returns the light among neighbours: `shade` is the scene light of the same sun, and `instance` the plant's
    /// number there.
    ///
    /// # Errors
    /// [`RuntimeError::Bands`] unless the light has three: scene light has the luminance of red, green and blue.
    ///
    /// # Panics
    /// In the light of a point, if the shade has no such instance.
    pub fn with_neighbours(
        self,
        shade: &'a SceneLightAtSun<'a>,
        instance: u32,
    ) -> Result<InstanceLight<'a>, RuntimeError> {
        if self.bands() != 3 {
            return Err(RuntimeError::Bands { found: self.bands(), expected: 3 });
        }
        Ok(InstanceLight { among: Some((shade, instance)), ..self })
    }

    /// Returns the light under an uneven sky, which was made of the same species, and a coloured sun: its irradiance
    /// per band is multiplied. For a light that was made without an even sky. Of the sky, neighbours leave and add what
    /// they do of an even one.
    ///
    /// # Panics
    /// If the light has an even sky.
    #[must_use]
    pub fn with_sky(self, sky: &'a SkyLight<'a>, sun_color: [f32; 3]) -> InstanceLight<'a> {
        let [sun, even] = self.terms.strengths();
        assert!(even == 0.0, "one sky");
        let luminance = [sun * luminance(sun_color), luminance(sky.fluence())];
        InstanceLight { uneven: Some(sky), color: Some(sun_color), luminance, ..self }
    }

    /// Returns the light by fields of the same species that are expanded ([`super::SpeciesLight::field_volume`]): for
    /// points that lie far from one another. What was loaded since they were expanded is not in it.
    ///
    /// # Panics
    /// In the light of a point, if the fields are of a species with fewer of them.
    #[must_use]
    pub fn with_fields(self, fields: &'a FieldVolume) -> InstanceLight<'a> {
        InstanceLight { fields: Some(fields), ..self }
    }

    /// Whether its fields are expanded.
    pub(super) fn is_expanded(&self) -> bool {
        self.fields.is_some()
    }

    /// Returns the light for a picture of so many rays a pixel: the more there are, the fewer places each looks at for
    /// the near beam. Without it a point looks at as many as a pixel of one ray does.
    ///
    /// Where several rays make a pixel and the near beam is marched for, the light of one of them may be below 0: cut
    /// off there it would be too bright in the mean, by 4 % where a ray looks at one place
    /// (`cargo bench -p flb-tests --bench grain -- shrub 4000 32`). It is the mean over a pixel that is cut off at 0.
    #[must_use]
    pub fn for_rays(self, rays: u32) -> InstanceLight<'a> {
        InstanceLight { offsets: RayOffsets::new(rays), ..self }
    }

    /// Returns the light with the near beam found for all sites at once, where the light needs one and the extinction
    /// is loaded: a second or less, and then each point costs less than by marches and has less noise. For a plant that
    /// many points are asked of.
    #[must_use]
    pub fn prepared(self) -> InstanceLight<'a> {
        self.prepare(|species, sites, terms| {
            let near = sites.near(species.needs_single());
            Prepared::Sun(Arc::new(sites.prepare(species.suns(), &near, terms, BEAM_RAYS)))
        })
    }

    /// Returns the light prepared by sums that many suns of the species share ([`super::SpeciesLight::near`]), which
    /// take longer than one of the suns. With `None` the light stays as it is.
    #[must_use]
    pub fn prepared_by(self, near: Option<&Near>) -> InstanceLight<'a> {
        let Some(near) = near else { return self };
        self.prepare(|species, sites, terms| {
            Prepared::Sun(Arc::new(sites.prepare(species.suns(), near, terms, BEAM_RAYS)))
        })
    }

    /// Returns the light with the near beam of the same sun that was prepared for another file of the same medium,
    /// whose fields depend on the sun in the same way ([`InstanceLight::prepared_sun`]).
    #[must_use]
    pub fn prepared_as(self, other: &Arc<PreparedSun>) -> InstanceLight<'a> {
        self.prepare(|_, _, _| Prepared::Sun(Arc::clone(other)))
    }

    fn prepare(
        self,
        sun: impl FnOnce(&ResidentSpecies, &MediumSites, SunTerms) -> Prepared,
    ) -> InstanceLight<'a> {
        if !self.terms.needs_near() {
            return self;
        }
        let terms = SunTerms::of_unit(self.species.species_suns(), self.terms.towards_sun());
        let (Some(sites), Some(terms)) = (self.species.sites(), terms) else { return self };
        let prepared = sun(self.species, sites, terms);
        InstanceLight { prepared: Some((sites, prepared)), ..self }
    }

    /// The light by rings of the same species.
    pub(super) fn found_by_rings(self, faded: Faded) -> InstanceLight<'a> {
        self.prepare(|_, _, _| Prepared::Rings(faded))
    }

    /// Near beam that [`InstanceLight::prepared`] found; `None` where nothing was prepared, or nothing needed to be.
    pub fn prepared_sun(&self) -> Option<&Arc<PreparedSun>> {
        match &self.prepared {
            Some((_, Prepared::Sun(sun))) => Some(sun),
            _ => None,
        }
    }

    /// Unit vector towards the sun in model space and the number of places that a point looks at for the near beam,
    /// where it marches for one. `None` where the near beam was found beforehand, and where the light needs none.
    pub fn marches(&self) -> Option<([f64; 3], usize)> {
        let marches = self.terms.needs_near() && self.prepared.is_none() && self.species.matter_sites() > 0;
        marches.then(|| (self.terms.towards_sun(), self.offsets.count()))
    }

    /// The sun's beam at a point of the model at rest, metres, of a sun of irradiance 1: that of the point's own site
    /// in the mean. `None` where the light needs no near beam.
    pub fn beam_at(&self, point_m: [f32; 3]) -> Option<f32> {
        self.terms.needs_near().then(|| self.near(point_m)[0])
    }

    /// Values per point.
    pub fn bands(&self) -> usize {
        self.species.bands()
    }

    /// Completeness of the light; a file's light is whole.
    pub fn level(&self) -> LightLevel {
        self.terms.level
    }

    /// Factors that the sun and the sky give each base.
    pub fn terms(&self) -> &Terms {
        &self.terms
    }

    /// Light per band at a point of the model at rest, metres: of the model `physical` fluence, without the sun's beam
    /// unless the fields hold it ([`flb_format::light::FieldKind`]). A point outside the lattice takes the light of the
    /// nearest point of it; a coordinate that is NaN counts as the lower end.
    ///
    /// # Panics
    /// If `out` is shorter than the bands.
    pub fn at(&self, point_m: [f32; 3], out: &mut [f32]) {
        self.at_facing(point_m, None, out);
    }

    /// Light per band at a point before a solid that faces some way (a unit vector): of an uneven sky more or less
    /// falls on it.
    ///
    /// # Panics
    /// If `out` is shorter than the bands.
    pub fn at_facing(&self, point_m: [f32; 3], facing: Option<[f32; 3]>, out: &mut [f32]) {
        let out = &mut out[..self.bands()];
        let modulation = self.modulation(point_m);
        let shares = [modulation.sun.scale, modulation.sky.scale];
        let near = self.near(point_m);
        match self.fields {
            Some(fields) => {
                self.species.fill(&self.terms, self.terms.factors(shares).constants, out);
                fields.add(&self.terms, near, shares, point_m, out);
            }
            None => self.species.sum_of(&self.terms, near, shares, point_m, out),
        }
        self.bound(out);
        self.color(out);
        if let Some(sky) = self.uneven {
            sky.add(self.species, point_m, facing, modulation.sky.scale, out);
        }
        self.add(&modulation, out);
    }

    /// Takes off what the light of a point is below 0, where the mean over several of them is not bounded later.
    pub(super) fn bound(&self, out: &mut [f32]) {
        let is_marched = self.terms.needs_near() && self.prepared.is_none();
        if !(is_marched && self.offsets.are_of_several_rays()) {
            self.species.bound(out);
        }
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

    /// Means of the near beam at a point, where the light needs them.
    pub(super) fn near(&self, point_m: [f32; 3]) -> [f32; MAX_MEANS] {
        if !self.terms.needs_near() {
            return Default::default();
        }
        match &self.prepared {
            Some((sites, Prepared::Sun(sun))) => sites.near_at(sun, self.species.needs_single(), point_m),
            Some((sites, Prepared::Rings(faded))) => {
                faded.near_at(sites, self.species.needs_single(), self.terms.towards_sun(), point_m)
            }
            None => self.offsets.with(seed_of(point_m), |offsets| {
                self.species.near(point_m, self.terms.towards_sun(), offsets)
            }),
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
