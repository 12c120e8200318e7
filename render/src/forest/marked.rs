//! Fragments in false colours: what is known of each place, in place of how it looks.

use glam::Vec3;
use rayon::prelude::*;

use super::{Forest, Fragments, fragments::Fragment, relight::ForestLight};
use crate::{Asked, Picture};

/// What is no plant.
const GROUND: f32 = 0.05;

impl Forest<'_> {
    /// A picture of fragments that this forest has traced, in which each plant has the linear colour that `mark` writes
    /// for an instance and a point of its model; ground and water are a dark grey, the sky black.
    pub fn marked(&self, fragments: &Fragments, mark: &ForestLight<'_>) -> Picture {
        let (samples, view) = (fragments.view.samples as usize, &fragments.view);
        let color = |fragment: &Fragment, x: u32, y: u32, sample: u32| match fragment {
            Fragment::Sky => Vec3::ZERO,
            Fragment::Ground { .. } | Fragment::Water { .. } => Vec3::splat(GROUND),
            Fragment::Plant { instance, found } => {
                let placed = &self.instances[*instance as usize];
                let looking = placed.model_direction(fragments.ray(x, y, sample).direction).as_vec3();
                let hit = self.models[placed.species].surface(looking, found);
                let mut color = [0.0; 3];
                mark(*instance, Asked::of(hit.point, &hit), &mut color);
                Vec3::from(color)
            }
        };
        let squares: Vec<Vec<Vec3>> = fragments
            .squares
            .par_iter()
            .map(|square| {
                let pixels = square.fragments.chunks_exact(samples).zip(0..);
                let mean = |(pixel, number): (&[Fragment], u32)| {
                    let (x, y) = (square.left + number % square.width, square.top + number / square.width);
                    let sum: Vec3 = pixel.iter().zip(0..).map(|(one, sample)| color(one, x, y, sample)).sum();
                    sum / samples as f32
                };
                pixels.map(mean).collect()
            })
            .collect();
        let mut rgb = vec![0.0; view.width as usize * view.height as usize * 3];
        for (square, colors) in fragments.squares.iter().zip(squares) {
            for (color, number) in colors.iter().zip(0..) {
                let (x, y) = (square.left + number % square.width, square.top + number / square.width);
                let first = 3 * (y as usize * view.width as usize + x as usize);
                rgb[first..first + 3].copy_from_slice(&color.to_array());
            }
        }
        Picture { width: view.width, height: view.height, rgb }
    }
}
