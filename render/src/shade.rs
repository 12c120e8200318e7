//! What a ray sees: the plant in the light of the sun and of the closure, before sky and ground.

use glam::{DVec3, Vec3};

use crate::{
    Asked, FacingLight, Indirect, RenderSettings, Shading,
    backdrop::{Backdrop, Seen},
    paper::Paper,
    physical::Physical,
    scene::{Hit, Ray, Scene},
    sun::{Sun, Sunlight},
    surfaces::Finish,
};

pub(crate) struct Shader<'a> {
    backdrop: Backdrop<'a>,
    sun: Sun<'a>,
    plant: Plant,
    indirect: Indirect,
    light: &'a FacingLight<'a>,
}

enum Plant {
    Paper(Paper),
    Physical(Physical, Finish),
}

impl<'a> Shader<'a> {
    pub(crate) fn new(
        scene: &'a Scene<'a>,
        settings: &'a RenderSettings,
        towards_sun: DVec3,
        light: &'a FacingLight<'a>,
    ) -> Self {
        let light_of_sun = Sunlight {
            towards: towards_sun.as_vec3(),
            strength: settings.sun_strength,
            color: Vec3::from(settings.sun_color),
        };
        let plant = match settings.shading {
            Shading::Paper => Plant::Paper(Paper {
                sun: light_of_sun,
                specular: settings.specular,
                indirect_scale: settings.indirect_scale,
            }),
            Shading::Physical(surfaces) => {
                Plant::Physical(Physical { sun: light_of_sun }, Finish::of(scene, surfaces))
            }
        };
        let sun = Sun { scene, light: light_of_sun };
        let backdrop = Backdrop::new(scene, settings, sun);
        Shader { backdrop, sun, plant, indirect: settings.indirect, light }
    }

    /// Linear colour seen along a ray from the camera.
    pub(crate) fn color(&self, ray: Ray) -> [f32; 3] {
        match self.backdrop.seen(ray) {
            Seen::Backdrop(color) => color,
            Seen::Plant(hit) => self.plant(&hit, ray),
        }
        .to_array()
    }

    fn plant(&self, hit: &Hit, ray: Ray) -> Vec3 {
        let mut color = Vec3::ZERO;
        let (has_direct, has_indirect) = (self.indirect != Indirect::Only, self.indirect != Indirect::Off);
        match &self.plant {
            Plant::Paper(paper) => {
                if has_direct {
                    color += paper.direct(hit, ray.direction, |side| self.sun.sees_hit(hit, side));
                }
                if has_indirect {
                    color += paper.indirect(hit, self.phi(Asked::of(hit.point, hit)));
                }
            }
            Plant::Physical(physical, finish) => {
                let matt = finish.at(hit);
                if has_direct {
                    color += physical.direct(hit, &matt, |side| self.sun.sees_hit(hit, side));
                }
                if has_indirect {
                    color += physical.indirect(&matt, self.phi(finish.asks(hit)));
                }
            }
        }
        color
    }

    fn phi(&self, asked: Asked) -> Vec3 {
        let mut phi = [0.0; 3];
        (self.light)(asked, &mut phi);
        Vec3::from(phi)
    }
}
