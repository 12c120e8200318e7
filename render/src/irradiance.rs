//! Irradiance at points of a mesh, by paths traced on the mesh itself: what baked light is judged by.
//!
//! At each point and on each of its two sides, paths start in directions drawn by the cosine and run as those of
//! [`crate::reference::render_reference`]. One set of paths serves all suns: every surface that a path meets is lit by
//! each of them through a shadow ray. The suns' own beams on the point itself are left out, as they are in a baked
//! field of scattered light. The sky is even over the whole sphere; there is no ground.

use std::f64::consts::PI;
use std::sync::atomic::{AtomicUsize, Ordering};

use flb_format::progress::Progress;
use flb_scene::sampling::cosine_hemisphere;
use flb_scene::surface_points::SurfacePoint;
use flb_scene::{MaterialClass, Mesh};
use glam::Vec3;
use rayon::prelude::*;

use crate::paths::{Draw, Paths};
use crate::physical::Physical;
use crate::scene::{Hit, Ray, Scene, TriangleHit};
use crate::sun::{Sun, Sunlight, lift};
use crate::surfaces::{Finish, Matt};
use crate::{RenderError, Surfaces, r2_sequence};
use flb_scene::sampling::hash;

/// Fluence of the sky, of which each direction has the 4 pi-th part as radiance.
const SKY_RADIANCE: f64 = 1.0 / (4.0 * PI);

/// Irradiance that paths found at a point of the mesh.
#[derive(Debug, Clone, PartialEq)]
pub struct PointIrradiance {
    /// Class of the point's material.
    pub class: MaterialClass,
    /// Index into the mesh's materials.
    pub material: usize,
    /// Unit normal of the flat triangle, to the side from which its vertices run counter-clockwise.
    pub normal: [f32; 3],
    /// The side of the normal, and the other one.
    pub sides: [SideIrradiance; 2],
}

impl PointIrradiance {
    /// Point at which a renderer asks for light at `position_m`: of a solid, so far before the side that is open.
    pub fn asked_at(&self, position_m: [f32; 3], solid_offset_m: Option<f32>) -> [f32; 3] {
        match (self.class, solid_offset_m) {
            (MaterialClass::Leaf, _) | (_, None) => position_m,
            (_, Some(offset_m)) => {
                let away = if self.faces_back() { -offset_m } else { offset_m };
                std::array::from_fn(|axis| position_m[axis] + away * self.normal[axis])
            }
        }
    }

    /// Whether the side away from the normal sees more of the sky: the outer side of a solid that is turned inside out.
    pub fn faces_back(&self) -> bool {
        let [front, back] = &self.sides;
        let sky = |side: &SideIrradiance| side.sources.last().map_or(0.0, |sky| sky.mean[1]);
        (back.open, sky(back)) > (front.open, sky(front))
    }
}

/// Irradiance on one side of a point.
#[derive(Debug, Clone, PartialEq)]
pub struct SideIrradiance {
    /// Share of the cosine-weighted directions in which nothing stands in the way of the sky, 0..=1.
    pub open: f32,
    /// Irradiance by each sun, without its own beam; last by the sky.
    pub sources: Vec<Estimate>,
}

/// A mean over paths.
#[derive(Debug, Clone, Copy, PartialEq, Default)]
pub struct Estimate {
    /// Irradiance per band R, G, B: of a sun of irradiance 1 on a plane that faces it, or of a sky of fluence 1.
    pub mean: [f32; 3],
    /// Standard error of the mean, from the spread of the paths. First directions are spread more evenly than chance
    /// would, so it is high rather than low.
    pub error: [f32; 3],
    /// Difference of two independent halves of the paths, scaled so that its square is in the mean the square of what
    /// the mean is off. It has a sign and one degree of freedom: of use over many points, where it is not high.
    pub difference: [f32; 3],
}

/// Traces `samples` paths from each side of each point, in two independent halves, under `suns` (directions towards
/// them in model space, any length) and an even sky. The same input gives the same bytes for any number of threads.
///
/// `classes` holds one class per material, `surfaces` are those of the file, and `progress` hears the share of points
/// done, 0..=1, from any thread.
///
/// # Errors
/// [`RenderError`] for fewer than 2 samples, suns without a direction, points that are not of the mesh, and meshes that
/// [`crate::render_plant`] refuses.
pub fn irradiance(
    (mesh, classes): (&Mesh, &[MaterialClass]),
    surfaces: Surfaces,
    points: &[SurfacePoint],
    suns: &[[f64; 3]],
    samples: u32,
    progress: &Progress<'_>,
) -> Result<Vec<PointIrradiance>, RenderError> {
    surfaces.check()?;
    if samples < 2 {
        let expected = "2 or more, to estimate an error from".into();
        return Err(RenderError::Setting { name: "samples", found: samples.to_string(), expected });
    }
    let scene = Scene::prepare(mesh, classes)?;
    let suns = suns.iter().map(|&sun| sunlight(sun)).collect::<Result<Vec<_>, _>>()?;
    if let Some(point) = points.iter().find(|point| point.triangle as usize >= mesh.triangles.len()) {
        let what = format!("a point of it, but the mesh has {} triangles", mesh.triangles.len());
        return Err(RenderError::Triangle { triangle: point.triangle as usize, what });
    }
    let finish = Finish::of(&scene, surfaces);
    let tracer =
        Tracer { paths: Paths { scene: &scene, finish: &finish, lift: lift(&scene) }, suns, samples };
    let done = AtomicUsize::new(0);
    progress(0.0)?;
    let trace = |(number, point): (usize, &SurfacePoint)| {
        let found = tracer.point(number as u32, point);
        progress((done.fetch_add(1, Ordering::Relaxed) + 1) as f64 / points.len() as f64)?;
        Ok(found)
    };
    points.par_iter().enumerate().map(trace).collect()
}

fn sunlight(towards: [f64; 3]) -> Result<Sunlight, RenderError> {
    let unit = glam::DVec3::from(towards).try_normalize();
    match unit {
        Some(towards) => Ok(Sunlight { towards: towards.as_vec3(), strength: 1.0, color: Vec3::ONE }),
        None => Err(RenderError::Setting {
            name: "sun",
            found: format!("{towards:?}"),
            expected: "a direction: finite and not zero".into(),
        }),
    }
}

struct Tracer<'a> {
    paths: Paths<'a>,
    suns: Vec<Sunlight>,
    samples: u32,
}

/// Sums over paths: of a value and of its square.
#[derive(Clone, Copy, Default)]
struct Sum([f64; 3], [f64; 3]);

impl Sum {
    fn add(&mut self, value: Vec3) {
        for (band, value) in value.to_array().into_iter().enumerate() {
            self.0[band] += f64::from(value);
            self.1[band] += f64::from(value) * f64::from(value);
        }
    }
}

/// The mean of what two halves found with so many paths each, times `factor`.
fn estimate(halves: [&Sum; 2], counts: [u32; 2], factor: f64) -> Estimate {
    let [first, second] = counts.map(f64::from);
    let count = first + second;
    let mean = |band: usize| (halves[0].0[band] + halves[1].0[band]) / count;
    let error = |band: usize| {
        let square = (halves[0].1[band] + halves[1].1[band]) / count;
        let variance = (square - mean(band) * mean(band)).max(0.0) / (count - 1.0);
        (variance.sqrt() * factor) as f32
    };
    // Halves of variance v / n_1 and v / n_2 differ by v n / (n_1 n_2) squared, and their mean is off by v / n.
    let scale = (first * second).sqrt() / count * factor;
    let difference = |band: usize| (scale * (halves[0].0[band] / first - halves[1].0[band] / second)) as f32;
    let bands = [0, 1, 2];
    Estimate {
        mean: bands.map(|band| (mean(band) * factor) as f32),
        error: bands.map(error),
        difference: bands.map(difference),
    }
}

impl Tracer<'_> {
    fn point(&self, number: u32, point: &SurfacePoint) -> PointIrradiance {
        let scene = self.paths.scene;
        let on = TriangleHit { distance: 0.0, triangle: point.triangle, weights: point.weights };
        // Seen from the side of its normal: of two directions the one that gives the counter-clockwise face.
        let seen = scene.surface(Vec3::Y, &on);
        let front = scene.front(point.triangle).unwrap_or(seen.flat_normal);
        let side = |back: u32| {
            let normal = if back == 0 { front } else { -front };
            self.side(2 * number + back, &seen, normal)
        };
        PointIrradiance {
            class: seen.class,
            material: seen.material,
            normal: front.to_array(),
            sides: [side(0), side(1)],
        }
    }

    fn side(&self, seed: u32, at: &Hit, normal: Vec3) -> SideIrradiance {
        let counts = [self.samples.div_ceil(2), self.samples / 2];
        let halves = [0, 1].map(|half| self.half(2 * seed + half, counts[half as usize], at, normal));
        let [(first, open), (second, also_open)] = &halves;
        let sky = self.suns.len();
        let of_source = |source: usize| {
            let factor = if source == sky { PI * SKY_RADIANCE } else { PI };
            estimate([&first[source], &second[source]], counts, factor)
        };
        let open = (open + also_open) as f32 / self.samples as f32;
        SideIrradiance { open, sources: (0..=sky).map(of_source).collect() }
    }

    /// Sums over paths of a seed, of each sun and last of the sky, and how many of them meet nothing.
    fn half(&self, seed: u32, samples: u32, at: &Hit, normal: Vec3) -> (Vec<Sum>, u32) {
        let mut sums = vec![Sum::default(); self.suns.len() + 1];
        let mut lit = vec![Vec3::ZERO; self.suns.len()];
        let mut open = 0;
        for sample in 0..samples {
            let mut draw = Draw::new(seed, hash(seed), sample);
            let [height, turn] = r2_sequence(seed, sample);
            let ray = Ray {
                origin: at.point + normal * self.paths.lift,
                direction: cosine_hemisphere(normal, height, turn),
            };
            lit.fill(Vec3::ZERO);
            let sky = match self.paths.scene.nearest(ray, Some(at.triangle)) {
                None => {
                    open += 1;
                    Vec3::ONE
                }
                Some(hit) => {
                    self.light(Vec3::ONE, &hit, &self.paths.finish.at(&hit), &mut lit);
                    let leaves = self.paths.follow(hit, &mut draw, |throughput, hit, matt| {
                        self.light(throughput, hit, matt, &mut lit);
                    });
                    leaves.map_or(Vec3::ZERO, |(_, throughput)| throughput)
                }
            };
            sums.iter_mut().zip(lit.iter().chain([&sky])).for_each(|(sum, value)| sum.add(*value));
        }
        (sums, open)
    }

    /// Adds what each sun makes of a surface that a path has met.
    fn light(&self, throughput: Vec3, hit: &Hit, matt: &Matt, lit: &mut [Vec3]) {
        for (light, sum) in self.suns.iter().zip(lit) {
            let sun = Sun { scene: self.paths.scene, light: *light };
            *sum += throughput * Physical { sun: *light }.direct(hit, matt, |side| sun.sees_hit(hit, side));
        }
    }
}

#[cfg(test)]
mod tests;
