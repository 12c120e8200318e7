//! A day of a plant under a clear sky: baked light against paths traced on the mesh under the same sun and sky.

use flb_format::Daylight;
use flb_format::sun::towards_sun;
use flb_render::reference::render_reference;
use flb_render::{
    Indirect, LightQuery, Lighting, Look, Picture, Portrait, Shading, Species, Surfaces, render_plant,
};
use flb_runtime::light::{LightCursors, SkyBeams, SkyLight};
use flb_runtime::{SpeciesLight, Transform};
use flb_scene::ClassedMesh;
use flb_scene::sky::Sky;

use crate::default_bake::DefaultBake;
use crate::portrait::light_of;

/// A morning in the south-east to an evening in the north-west: azimuth and elevation.
pub const DAY: [[f64; 2]; 8] = [
    [75.0, 5.0],
    [90.0, 20.0],
    [115.0, 40.0],
    [150.0, 60.0],
    [190.0, 65.0],
    [230.0, 50.0],
    [260.0, 28.0],
    [280.0, 10.0],
];
/// Of the sky.
pub const TURBIDITY: f64 = 3.0;

/// Light of a frame, baked and traced, R, G, B: sums over its pixels.
pub struct Frame {
    /// By the file.
    pub baked: [f64; 3],
    /// By paths.
    pub traced: [f64; 3],
}

impl Frame {
    /// Baked over traced, per band.
    pub fn ratios(&self) -> [f64; 3] {
        [0, 1, 2].map(|band| self.baked[band] / self.traced[band])
    }

    /// Of the means over the bands.
    pub fn ratio(&self) -> f64 {
        self.baked.iter().sum::<f64>() / self.traced.iter().sum::<f64>()
    }
}

/// A plant, its light, and how its pictures are taken.
pub struct Subject<'a> {
    mesh: &'a ClassedMesh,
    surfaces: Surfaces,
    light: SpeciesLight<'static>,
    edge: u32,
    samples: [u32; 2],
}

impl<'a> Subject<'a> {
    /// Pictures of `edge` pixels, with so many rays a pixel of baked light and of paths.
    ///
    /// # Panics
    /// Unless the model is `physical`.
    pub fn new(bake: &'a DefaultBake, edge: u32, samples: [u32; 2]) -> Subject<'a> {
        let light = SpeciesLight::load(&bake.library(), 0).expect("a sound file");
        Subject { mesh: &bake.mesh, surfaces: bake.surfaces(), light, edge, samples }
    }

    /// The plant before black under a sky and its sun; `sky_alone` leaves out the sun.
    ///
    /// # Panics
    /// Never: the suns of a day are good ones.
    pub fn frame(&self, sun: [f64; 2], indirect: Indirect, sky_alone: bool) -> Frame {
        let (lighting, dome) = lighting(sun, sky_alone);
        let look = Look { indirect, has_sky: false, ..Look::default() };
        let of_sky = self.light.sky(dome.patches(), &Transform::IDENTITY).expect("the whole sphere");
        let baked = self.baked(&lighting, &look, &of_sky);
        let portrait = self.portrait(self.samples[1]);
        let traced = render_reference(&self.plant(), &portrait, &lighting, &look, &|_| Ok(()))
            .expect("a picture")
            .picture;
        Frame { baked: light_of(&baked), traced: light_of(&traced) }
    }

    /// The plant under the sky alone, by beams that a stand shares over the sky that is found for one plant: the sum of
    /// the pixels, and the rms of their difference relative to their mean.
    ///
    /// # Panics
    /// Never: the suns of a day are good ones.
    pub fn shared_over_own(&self, beams: &SkyBeams, sun: [f64; 2]) -> [f64; 2] {
        let (lighting, dome) = lighting(sun, true);
        let look = Look { indirect: Indirect::Only, has_sky: false, ..Look::default() };
        let parts = dome.patches();
        let own = self.light.sky(parts, &Transform::IDENTITY).expect("the whole sphere");
        let shared = beams.sky(parts, &Transform::IDENTITY).expect("the whole sphere");
        let [own, shared] = [own, shared].map(|sky| self.baked(&lighting, &look, &sky).rgb);
        let sum = |picture: &[f32]| picture.iter().map(|band| f64::from(*band)).sum::<f64>();
        let squares = own.iter().zip(&shared).map(|(own, shared)| f64::from((own - shared) * (own - shared)));
        let lit = own.iter().filter(|band| **band > 0.0).count() as f64;
        [sum(&shared) / sum(&own), (squares.sum::<f64>() / lit).sqrt() / (sum(&own) / lit)]
    }

    /// What its species' stands share of skies.
    ///
    /// # Panics
    /// Never: the model is `physical`.
    pub fn beams(&self) -> SkyBeams {
        self.light.sky_beams().expect("a physical file")
    }

    fn plant(&self) -> Species<'_> {
        let ClassedMesh { mesh, classes } = self.mesh;
        Species { mesh, classes, shading: Shading::Physical(self.surfaces) }
    }

    fn portrait(&self, samples: u32) -> Portrait {
        Portrait { width: self.edge, height: self.edge, samples, has_ground: false, ..Portrait::default() }
    }

    fn baked(&self, lighting: &Lighting, look: &Look, of_sky: &SkyLight<'_>) -> Picture {
        let lit = self.light.lit_by_in_model(&lighting.daylight).expect("a sun");
        let lit = [Some(lit.with_sky(of_sky, lighting.sun_color).prepared())];
        let cursors = LightCursors::new(&lit);
        let light =
            |query: LightQuery, phi: &mut [f32; 3]| cursors.at_facing(0, query.point, query.facing, phi);
        let portrait = self.portrait(self.samples[0]);
        render_plant(&self.plant(), &portrait, lighting, look, &light, &|_| Ok(())).expect("a picture")
    }
}

/// A clear sky and its sun; `sky_alone` leaves out the sun.
fn lighting([azimuth_deg, elevation_deg]: [f64; 2], sky_alone: bool) -> (Lighting, Sky) {
    let towards_sun = towards_sun(azimuth_deg, elevation_deg);
    let dome = Sky::clear(towards_sun, TURBIDITY).expect("a sky");
    let sun_color = dome.sun().expect("a clear sky has a sun");
    let sun = if sky_alone { 0.0 } else { 1.0 };
    let daylight = Daylight { towards_sun, sun, sky: 0.0 };
    (Lighting { sun_color, dome: Some(dome.clone()), ..Lighting::of(daylight) }, dome)
}
