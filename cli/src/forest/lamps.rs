//! The light of a scene's species as the renderer asks for it: from an instance and a point of its model to light per band,
//! under a sun that every instance sees from another side.

use flb_format::sun::{self, SunBlend};
use flb_render::seed_of;
use flb_runtime::scene_light::{Shade, Shares};
use flb_runtime::{Library, Marcher, PhysicalSampler, RayOffsets, SpeciesSampler, SunTerms, bases_needed};
use flb_scene::scene::Instance;

use crate::exit::{Failure, USAGE};

/// The light of one species, for the suns that it was loaded for.
pub enum Lamp {
    /// It has none, or none of it shows.
    Dark,
    /// The papers' bases.
    Paper(SpeciesSampler),
    /// Everything that its file has.
    Physical(Box<PhysicalSampler>),
}

/// All species under one sun and the sky.
pub struct Shine<'l> {
    lamps: &'l [Lamp],
    marchers: &'l [Option<Marcher<'l>>],
    instances: &'l [Instance],
    /// `[instance]`
    aims: Vec<Aim>,
    strength: f32,
    ambient: f32,
    /// Places from which the mean light around a point is estimated.
    offsets: RayOffsets,
    /// What plants do to each other's light.
    shade: Option<&'l Shade<'l>>,
}

/// The sun as an instance sees it.
enum Aim {
    None,
    Blend(SunBlend),
    Terms(SunTerms),
}

impl Lamp {
    /// Loads what these instances of a library's species need under suns that stand in these directions (world).
    pub fn load<'i>(
        library: &Library,
        species: usize,
        instances: impl Iterator<Item = &'i Instance> + Clone,
        suns: &[[f64; 3]],
        has_sky: bool,
    ) -> Result<Lamp, Failure> {
        if library.container().species()[species].meta.physical().is_some() {
            let sampler = PhysicalSampler::load(library, species)?;
            if has_sky && !sampler.has_sky() {
                let message =
                    "the file has no light of the sky (base 0 was left out); --ambient 0 goes without";
                return Err(Failure::new(USAGE, message).at(library.path()));
            }
            return Ok(Lamp::Physical(Box::new(sampler)));
        }
        let mut bases: Vec<u8> = if has_sky { vec![0] } else { Vec::new() };
        for sun in suns {
            for instance in instances.clone() {
                bases.extend(bases_needed(&blend(instance, *sun), false));
            }
            bases.sort_unstable();
            bases.dedup();
        }
        Ok(Lamp::Paper(SpeciesSampler::load(library, species, &bases)?))
    }

    /// Memory that it takes.
    pub fn size_bytes(&self) -> usize {
        match self {
            Lamp::Dark => 0,
            Lamp::Paper(sampler) => sampler.size_bytes(),
            Lamp::Physical(sampler) => sampler.size_bytes(),
        }
    }

    /// What finds the near beam of points, where the species needs it.
    pub fn marcher(&self) -> Option<Marcher<'_>> {
        match self {
            Lamp::Physical(sampler) if sampler.suns().first_near_item().is_some() => {
                Some(Marcher::new(sampler))
            }
            _ => None,
        }
    }
}

impl<'l> Shine<'l> {
    /// Turns the sun that stands in a direction (world) into the frame of each instance, for a picture of so many rays a pixel.
    /// `marchers` are those of the lamps.
    pub fn new(
        lamps: &'l [Lamp],
        marchers: &'l [Option<Marcher<'l>>],
        instances: &'l [Instance],
        sun: [f64; 3],
        [strength, ambient]: [f32; 2],
        rays: u32,
    ) -> Result<Shine<'l>, Failure> {
        let aim = |instance: &Instance| {
            Ok(match &lamps[instance.species] {
                _ if strength == 0.0 => Aim::None,
                Lamp::Dark => Aim::None,
                Lamp::Paper(_) => Aim::Blend(blend(instance, sun)),
                Lamp::Physical(sampler) => Aim::Terms(sampler.terms(in_model(instance, sun))?),
            })
        };
        let aims = instances.iter().map(aim).collect::<Result<Vec<_>, Failure>>()?;
        let offsets = RayOffsets::new(rays);
        Ok(Shine { lamps, marchers, instances, aims, strength, ambient, offsets, shade: None })
    }

    /// The same among neighbours.
    pub fn among(self, shade: Option<&'l Shade<'l>>) -> Shine<'l> {
        Shine { shade, ..self }
    }

    /// Light at a point of an instance's model.
    pub fn at(&self, instance: u32, point_model_m: [f32; 3], phi: &mut [f32; 3]) {
        if let Lamp::Dark = self.lamps[self.instances[instance as usize].species] {
            *phi = [0.0; 3];
            return;
        }
        let shares = self.shade.map_or(Shares::ALL, |shade| shade.at(instance, point_model_m));
        let [sun, sky] = [self.strength * shares.sun.left, self.ambient * shares.sky.left];
        self.alone(instance, point_model_m, [sun, sky], phi);
        shares.add(self.strength, self.ambient, phi);
    }

    /// Light of the plant's own file, of a sun and a sky of these strengths.
    fn alone(
        &self,
        instance: u32,
        point_model_m: [f32; 3],
        [strength, ambient]: [f32; 2],
        phi: &mut [f32; 3],
    ) {
        let index = instance as usize;
        let species = self.instances[index].species;
        match (&self.lamps[species], &self.aims[index]) {
            (Lamp::Dark, _) => *phi = [0.0; 3],
            (Lamp::Paper(sampler), Aim::Blend(blend)) => {
                sampler.indirect(blend, strength, ambient, point_model_m, phi);
            }
            (Lamp::Physical(sampler), Aim::Terms(terms)) => {
                let near = self.marchers[species].as_ref().map_or_else(Default::default, |marcher| {
                    self.offsets.with(seed_of(point_model_m), |offsets| {
                        marcher.near(point_model_m, terms.towards_sun, offsets)
                    })
                });
                sampler.fluence_of(terms, near, strength, ambient, point_model_m, phi);
            }
            (lamp, _) => lamp.sky(ambient, point_model_m, phi),
        }
    }
}

impl Lamp {
    /// Light of the sky alone.
    fn sky(&self, ambient: f32, point_model_m: [f32; 3], phi: &mut [f32; 3]) {
        *phi = [0.0; 3];
        if ambient == 0.0 {
            return;
        }
        match self {
            Lamp::Dark => {}
            Lamp::Paper(sampler) => sampler.sample(0, point_model_m, phi),
            Lamp::Physical(sampler) => sampler.sky(point_model_m, phi),
        }
        phi.iter_mut().for_each(|value| *value *= ambient);
    }
}

/// A direction of the world in an instance's own frame.
fn in_model(instance: &Instance, direction: [f64; 3]) -> [f64; 3] {
    let rotation = &instance.rotation;
    std::array::from_fn(|column| (0..3).map(|row| rotation[row][column] * direction[row]).sum())
}

fn blend(instance: &Instance, sun: [f64; 3]) -> SunBlend {
    sun::blend(in_model(instance, sun)).expect("a rotation leaves a direction its length")
}
