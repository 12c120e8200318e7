//! Fragments in false colours: what is known of each place, in place of how it looks.

use glam::Vec3;

use super::{Forest, Fragments, fragments::Fragment, squares};
use crate::{LightFn, LightQuery, Picture};

/// What is no plant.
const GROUND: f32 = 0.05;

impl Forest<'_> {
    /// A picture of fragments that this forest has traced, in which each plant has the linear colour that `mark` writes
    /// for an instance and a point of its model; ground and water are a dark grey, the sky black.
    pub fn marked(&self, fragments: &Fragments, mark: &LightFn<'_>) -> Picture {
        let camera = &fragments.camera;
        let color = |fragment: &Fragment, (x, y): (u32, u32), sample: u32| match fragment {
            Fragment::Sky => Vec3::ZERO,
            Fragment::Ground { .. } | Fragment::Water { .. } => Vec3::splat(GROUND),
            Fragment::Plant { instance, found } => {
                let placed = &self.instances[*instance as usize];
                let looking = placed.model_direction(camera.ray(x, y, sample).direction).as_vec3();
                let hit = self.models[placed.placement.species].surface(looking, found);
                let mut color = [0.0; 3];
                mark(LightQuery::of(*instance, hit.point, &hit), &mut color);
                Vec3::from(color)
            }
        };
        let samples = camera.view.samples as usize;
        let pixels = squares::pixels(&camera.view, &|_| Ok(()), |number, area| {
            let rays = fragments.square(number).fragments.chunks_exact(samples);
            let mean = |(rays, pixel): (&[Fragment], (u32, u32))| {
                let sum: Vec3 = rays.iter().zip(0..).map(|(one, sample)| color(one, pixel, sample)).sum();
                (sum / samples as f32).to_array()
            };
            rays.zip(area.pixels()).map(mean).collect()
        });
        let pixels = pixels.expect("nothing stops it");
        Picture { width: camera.view.width, height: camera.view.height, rgb: pixels.into_flattened() }
    }
}
