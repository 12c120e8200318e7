//! The light of a file as the renderer asks for it: from a point to light per band, under one sun.

use flb_format::beam::BEAM_RAYS;
use flb_format::sun;
use flb_render::{Light, RenderSettings};
use flb_runtime::{Library, PhysicalSampler, SpeciesSampler, bases_needed};

use crate::exit::{Failure, USAGE};
use crate::stages::Stages;

/// A species of a library, to be lit by any sun.
pub enum Lamp<'l> {
    /// Nothing of the file shows, so nothing is read.
    Dark,
    /// The papers' bases; which of them are read depends on the sun.
    Paper { library: &'l Library, species: usize },
    /// Everything is needed for every sun.
    Physical(Box<PhysicalSampler>),
}

impl<'l> Lamp<'l> {
    /// The species number `species`; `shows` tells whether the picture has any of its light.
    pub fn new(library: &'l Library, species: usize, shows: bool) -> Result<Lamp<'l>, Failure> {
        if !shows {
            return Ok(Lamp::Dark);
        }
        match library.container().species()[species].meta.physical() {
            Some(_) => Ok(Lamp::Physical(Box::new(PhysicalSampler::load(library, species)?))),
            None => Ok(Lamp::Paper { library, species }),
        }
    }

    /// Its light under the sun and the sky of `settings`.
    pub fn under(&self, settings: &RenderSettings, stages: &mut Stages) -> Result<Box<Light<'_>>, Failure> {
        let (strength, ambient) = (settings.sun_strength, settings.ambient);
        match self {
            Lamp::Dark => Ok(Box::new(|_, phi| *phi = [0.0; 3])),
            Lamp::Paper { library, species } => {
                let no_direction = || Failure::new(USAGE, "the sun has no direction");
                let blend = sun::blend(settings.sun).ok_or_else(no_direction)?;
                let sampler = SpeciesSampler::load(library, *species, &bases_needed(&blend, ambient > 0.0))?;
                Ok(Box::new(move |point, phi| sampler.indirect(&blend, strength, ambient, point, phi)))
            }
            Lamp::Physical(sampler) => {
                if ambient > 0.0 && !sampler.has_sky() {
                    let message =
                        "the file has no light of the sky (base 0 was left out); --ambient 0 goes without";
                    return Err(Failure::new(USAGE, message));
                }
                let terms = sampler.terms(settings.sun)?;
                let prepared =
                    stages.run("prepare", "", |_| sampler.prepare(&sampler.near(), terms, BEAM_RAYS));
                Ok(Box::new(move |point, phi| sampler.fluence(&prepared, strength, ambient, point, phi)))
            }
        }
    }
}
