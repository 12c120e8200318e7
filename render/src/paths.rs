//! Paths of light from surface to surface, followed backwards: what pictures and irradiances are judged by.

use glam::Vec3;
use rand::{Rng, SeedableRng};
use rand_pcg::Pcg64Mcg;

use flb_scene::sampling::cosine_hemisphere;

use crate::scene::{Hit, Ray, Scene};
use crate::surfaces::{Finish, Matt};
use flb_scene::sampling::hash;

/// Most times that a path is scattered. What is left of it then is lost: nothing to speak of for real leaves,
/// which send on less than 0.9, and what a white plant hides in its depths.
const MAX_BOUNCES: u32 = 64;
/// Bounces that every path may make before roulette.
const SURE_BOUNCES: u32 = 2;

/// Where paths run.
pub(crate) struct Paths<'a> {
    pub scene: &'a Scene<'a>,
    pub finish: &'a Finish,
    /// Distance from its surface at which a ray starts.
    pub lift: f32,
}

impl Paths<'_> {
    /// Follows a path from a surface until it leaves the plant or ends, and tells each surface that it meets, with the
    /// path's throughput up to there. Returns the direction in which it reaches the sky and its throughput, if it does.
    pub(crate) fn follow(
        &self,
        mut hit: Hit,
        draw: &mut Draw,
        mut meets: impl FnMut(Vec3, &Hit, &Matt),
    ) -> Option<(Vec3, Vec3)> {
        let mut throughput = Vec3::ONE;
        let mut matt = self.finish.at(&hit);
        for bounce in 0..MAX_BOUNCES {
            let Some((side, share)) = chosen_side(&hit, &matt, throughput, draw) else { break };
            throughput *= share;
            if bounce >= SURE_BOUNCES {
                let survival = throughput.max_element().min(1.0);
                if draw.unit() >= survival {
                    break;
                }
                throughput /= survival;
            }
            let ray = Ray {
                origin: hit.point + side * self.lift,
                direction: cosine_hemisphere(side, draw.unit(), draw.unit()),
            };
            let Some(next) = self.scene.nearest(ray, Some(hit.triangle)) else {
                return Some((ray.direction, throughput));
            };
            hit = next;
            matt = self.finish.at(&hit);
            meets(throughput, &hit, &matt);
        }
        None
    }
}

/// The side of a surface on which a path goes on, drawn by its share of the light that the path still
/// carries, and the factor on the path; nothing where the surface is black.
fn chosen_side(hit: &Hit, matt: &Matt, throughput: Vec3, draw: &mut Draw) -> Option<(Vec3, Vec3)> {
    let back = throughput.dot(matt.reflectance);
    let through = throughput.dot(matt.transmittance);
    if back + through <= 0.0 {
        return None;
    }
    let chance = back / (back + through);
    Some(match draw.unit() < chance {
        true => (hit.flat_normal, matt.reflectance / chance),
        false => (-hit.flat_normal, matt.transmittance / (1.0 - chance)),
    })
}

/// The random numbers of one path.
pub(crate) struct Draw(Pcg64Mcg);

impl Draw {
    pub(crate) fn new(x: u32, y: u32, sample: u32) -> Self {
        let pixel = hash(x ^ hash(y));
        Draw(Pcg64Mcg::seed_from_u64(u64::from(pixel) << 32 | u64::from(hash(pixel ^ sample))))
    }

    /// 0..1, below 1.
    pub(crate) fn unit(&mut self) -> f32 {
        (self.0.next_u64() >> 40) as f32 / (1u64 << 24) as f32
    }
}
