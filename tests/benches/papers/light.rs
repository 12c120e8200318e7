//! A stand in the light of files, and the time that its parts take.

use std::time::Instant;

use flb_format::sun::towards_sun;
use flb_format::{Daylight, Placement};
use flb_render::forest::{Eye, Forest, Fragments, Ground, Land, Search, View};
use flb_render::{Indirect, LightQuery, Lighting, Look, Picture, Shading, Species};
use flb_runtime::light::LightCursors;
use flb_runtime::{InstanceLight, SpeciesLight};

use crate::species::Plant;

/// Factor on the ambient base, as `flb render` has it.
const SKY: f32 = 0.02;

pub(crate) struct Lit<'a> {
    pub forest: Forest<'a>,
    instances: Vec<Placement>,
    eye: Eye,
}

impl<'a> Lit<'a> {
    pub(crate) fn new(plants: &'a [&Plant], instances: Vec<Placement>, eye: Eye) -> Lit<'a> {
        let species: Vec<Species> = plants
            .iter()
            .map(|plant| Species {
                mesh: &plant.mesh.mesh,
                classes: &plant.mesh.classes,
                shading: Shading::Paper,
            })
            .collect();
        let ground = Ground { land: Land::Plane { height_m: 0.0 }, color: [0.2; 3], fades_at_m: None };
        let forest =
            Forest::prepare(&species, &instances, Some(ground), Search::default()).expect("a sound scene");
        Lit { forest, instances, eye }
    }

    /// What the camera sees, and the seconds that it took.
    pub(crate) fn trace(&self, edge: u32, samples: u32) -> (Fragments, f64) {
        let view = self.view(edge, samples);
        timed(|| self.forest.trace(&view, &|_| Ok(())).expect("a sound view"))
    }

    fn view(&self, edge: u32, samples: u32) -> View {
        View { eye: self.eye, width: edge, height: edge, samples, sky_rays: 0, time_s: 0.0 }
    }

    /// Seconds for what the dissertation's further thread prepares while a frame is drawn: the grid over the picture,
    /// the one across the sun's rays, and the light of each plant under the sun.
    pub(crate) fn prepare(&self, edge: u32, light: &[SpeciesLight<'_>], sun_deg: [f64; 2]) -> [f64; 3] {
        let (view, boxes) = (self.view(edge, 1), self.forest.flat_boxes());
        let daylight = daylight(sun_deg);
        let (_, over_picture) = timed(|| boxes.view_grid(&view).expect("a sound view"));
        let (_, across_sun) = timed(|| boxes.sun_grid(daylight.towards_sun, 0.0));
        let (_, lit) = timed(|| self.lit(light, &daylight));
        [over_picture, across_sun, lit]
    }

    fn lit<'l>(&self, light: &'l [SpeciesLight<'l>], daylight: &Daylight) -> Vec<Option<InstanceLight<'l>>> {
        let of = |one: &Placement| {
            light[one.species].lit_by(daylight, &one.transform).expect("all bases are there")
        };
        self.instances.iter().map(|one| Some(of(one))).collect()
    }

    /// A picture under a sun, blends and shadow structures included, and the seconds that it took.
    pub(crate) fn relight(
        &self,
        fragments: &Fragments,
        light: &[SpeciesLight<'_>],
        sun_deg: [f64; 2],
        indirect: Indirect,
    ) -> (Picture, f64) {
        timed(|| {
            let daylight = daylight(sun_deg);
            let lit = self.lit(light, &daylight);
            let cursors = LightCursors::new(&lit);
            let look = Look { indirect, indirect_scale: 1.0, ..Look::default() };
            let phi = |LightQuery { instance, point, facing }: LightQuery, out: &mut [f32; 3]| {
                cursors.at_facing(instance as usize, point, facing, out);
            };
            let lighting = Lighting::of(daylight);
            self.forest.relight(fragments, &lighting, &look, &phi, &|_| Ok(())).expect("a finite light")
        })
    }
}

fn daylight([azimuth, elevation]: [f64; 2]) -> Daylight {
    Daylight { towards_sun: towards_sun(azimuth, elevation), sun: 1.0, sky: SKY }
}

/// Suns that move from east to west, 45 degrees to either side of the zenith.
pub(crate) fn suns(count: usize) -> Vec<[f64; 2]> {
    let angle = |number: usize| 90.0 * (number as f64 + 0.5) / count as f64 - 45.0;
    (0..count).map(angle).map(|angle| [if angle < 0.0 { 90.0 } else { 270.0 }, 90.0 - angle.abs()]).collect()
}

pub(crate) fn timed<T>(work: impl FnOnce() -> T) -> (T, f64) {
    let start = Instant::now();
    let made = work();
    (made, start.elapsed().as_secs_f64())
}
