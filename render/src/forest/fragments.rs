//! What every ray of a picture meets first: traced once for a camera, lit as often as the sun moves.

use std::sync::atomic::{AtomicUsize, Ordering};

use glam::{DVec3, Vec3};
use rayon::prelude::*;

use super::{
    Eye, Forest, InstanceSearch, Water, eye, placed::WorldRay, trace::PlantHit, view_grid::ViewGrid,
};
use crate::{
    RenderError, hash, jitter,
    lens::Lens,
    scene::TriangleHit,
    sequence,
    settings::{EDGE_LIMIT, PIXEL_LIMIT, SAMPLE_LIMIT},
};

/// Most rays of a picture: 3 GiB of fragments, and as much again for what is mirrored, where all is water.
pub const RAY_LIMIT: u64 = 1 << 27;
/// Most rays that look for the sky from a point of the ground.
pub const SKY_RAY_LIMIT: u32 = 256;
/// How bright plants that hide the sky from the ground are taken to be, as a share of it: their leaves let light
/// through and pass it on, and ground is scenery.
pub(super) const LEAVES_BEFORE_SKY: f32 = 0.25;
/// Pixels along the edge of a square that one thread works on at a time.
const SQUARE_PX: u32 = 16;

/// The picture that is to be taken.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct View {
    /// From where.
    pub eye: Eye,
    /// Pixels per row, 1..=16384.
    pub width: u32,
    /// Rows, 1..=16384; at most 2^26 pixels altogether.
    pub height: u32,
    /// Rays per pixel, 1..=4096; at most 2^27 rays altogether.
    pub samples: u32,
    /// Rays that look for the sky from each point of the ground, 0..=256; with none, it lies under open sky.
    pub sky_rays: u32,
}

/// What a ray meets.
#[derive(Debug, Clone, Copy, PartialEq)]
pub enum Fragment {
    /// Nothing.
    Sky,
    /// The ground.
    Ground {
        /// From the camera.
        distance_m: f64,
        /// Light of the sky by the cosine, as a share of that without plants.
        sky: f32,
    },
    /// An instance.
    Plant {
        /// Its number.
        instance: u32,
        /// Where on its model.
        found: TriangleHit,
    },
    /// Water.
    Water {
        /// From the camera.
        distance_m: f64,
        /// As of the ground.
        sky: f32,
        /// Number in its square of what it mirrors, for [`Fragments::mirrored_at`]: few rays have one, and all would be
        /// larger for it.
        mirrored: u32,
    },
}

/// What the rays of a picture meet first, for [`Forest::relight`] on the forest that traced them.
pub struct Fragments {
    pub(crate) view: View,
    pub(crate) lens: Lens,
    /// Squares of the picture in rows; `[y][x][sample]` within each.
    pub(crate) squares: Vec<Square>,
}

pub(crate) struct Square {
    pub left: u32,
    pub top: u32,
    pub width: u32,
    pub fragments: Vec<Fragment>,
    /// What is met by way of the water, in the order of the rays that come to it.
    pub mirrored: Vec<Fragment>,
}

impl View {
    /// Refuses a view outside its limits.
    ///
    /// # Errors
    /// [`RenderError::Setting`].
    pub fn check(&self) -> Result<(), RenderError> {
        let refuse = |name, found: u64, expected: String| {
            Err(RenderError::Setting { name, found: found.to_string(), expected })
        };
        for (name, found, low, high) in [
            ("width", self.width, 1, EDGE_LIMIT),
            ("height", self.height, 1, EDGE_LIMIT),
            ("samples", self.samples, 1, SAMPLE_LIMIT),
            ("sky_rays", self.sky_rays, 0, SKY_RAY_LIMIT),
        ] {
            if !(low..=high).contains(&found) {
                return refuse(name, found.into(), format!("{low}..={high}"));
            }
        }
        let pixels = u64::from(self.width) * u64::from(self.height);
        if pixels > PIXEL_LIMIT {
            return refuse("width x height", pixels, format!("at most {PIXEL_LIMIT} pixels"));
        }
        let rays = pixels * u64::from(self.samples);
        match rays > RAY_LIMIT {
            true => refuse("width x height x samples", rays, format!("at most {RAY_LIMIT} rays")),
            false => Ok(()),
        }
    }

    /// Unit vector into the middle of the picture, and from there half its width to the right and half its height up,
    /// all at distance 1.
    ///
    /// # Errors
    /// [`RenderError::Setting`] for an eye that sees nothing.
    pub fn frame(&self) -> Result<[[f64; 3]; 3], RenderError> {
        let lens = eye::lens(&self.eye, [self.width, self.height])?;
        Ok([lens.forward, lens.right, lens.up].map(|axis| axis.to_array()))
    }
}

impl Fragments {
    /// The ray number `sample` of a pixel.
    pub(crate) fn ray(&self, x: u32, y: u32, sample: u32) -> WorldRay {
        let [x, y] = point(&self.view, x, y, sample);
        self.lens.ray(x, y)
    }

    /// What the ray number `sample` of a pixel meets; nothing beyond the picture.
    pub fn at(&self, x: u32, y: u32, sample: u32) -> Option<Fragment> {
        self.in_square(x, y, sample).map(|(_, fragment)| fragment)
    }

    /// What it meets by way of the water, its distance counted from there; nothing where it does not come to any.
    pub fn mirrored_at(&self, x: u32, y: u32, sample: u32) -> Option<Fragment> {
        match self.in_square(x, y, sample)? {
            (square, Fragment::Water { mirrored, .. }) => square.mirrored.get(mirrored as usize).copied(),
            _ => None,
        }
    }

    fn in_square(&self, x: u32, y: u32, sample: u32) -> Option<(&Square, Fragment)> {
        let is_here = |square: &&Square| {
            (square.left..square.left + square.width).contains(&x)
                && (square.top..square.top + SQUARE_PX).contains(&y)
        };
        let columns = self.view.width.div_ceil(SQUARE_PX);
        let number = (y / SQUARE_PX) * columns + x / SQUARE_PX;
        let square = self.squares.get(number as usize).filter(is_here)?;
        let pixel = (y - square.top) * square.width + x - square.left;
        let in_pixel = (sample < self.view.samples).then_some(sample)?;
        let fragment = square.fragments.get((pixel * self.view.samples + in_pixel) as usize)?;
        Some((square, *fragment))
    }

    /// Rays that meet a plant, the ground, nothing, and water.
    pub fn counts(&self) -> [usize; 4] {
        let mut counts = [0; 4];
        for fragment in self.squares.iter().flat_map(|square| &square.fragments) {
            counts[match fragment {
                Fragment::Plant { .. } => 0,
                Fragment::Ground { .. } => 1,
                Fragment::Sky => 2,
                Fragment::Water { .. } => 3,
            }] += 1;
        }
        counts
    }

    /// Memory that they take.
    pub fn size_bytes(&self) -> usize {
        let of = |square: &Square| size_of_val(&square.fragments[..]) + size_of_val(&square.mirrored[..]);
        self.squares.iter().map(of).sum()
    }
}

/// Where in the picture a ray goes through, in pixels.
fn point(view: &View, x: u32, y: u32, sample: u32) -> [f64; 2] {
    let [dx, dy] = jitter(x, y, sample, view.samples).map(f64::from);
    [f64::from(x) + dx, f64::from(y) + dy]
}

impl Forest<'_> {
    /// Finds what every ray of a picture meets first. `progress` is called with the share done, 0..=1, from any thread.
    ///
    /// # Errors
    /// [`RenderError::Setting`] for a view outside its limits; [`RenderError::Underwater`].
    pub fn trace(&self, view: &View, progress: &(dyn Fn(f64) + Sync)) -> Result<Fragments, RenderError> {
        view.check()?;
        if let Some(water) = &self.water {
            water.check_eye(view.eye.position_m)?;
        }
        let size = [view.width, view.height];
        let lens = eye::lens(&view.eye, size)?;
        let grid = match self.search.primary {
            InstanceSearch::Tree => None,
            InstanceSearch::Grid => {
                Some(ViewGrid::new(self.instances.iter().map(|placed| placed.extent), &lens, size))
            }
        };
        let mut squares: Vec<Square> = (0..view.height)
            .step_by(SQUARE_PX as usize)
            .flat_map(|top| (0..view.width).step_by(SQUARE_PX as usize).map(move |left| (left, top)))
            .map(|(left, top)| Square {
                left,
                top,
                width: SQUARE_PX.min(view.width - left),
                fragments: Vec::new(),
                mirrored: Vec::new(),
            })
            .collect();
        let (count, done) = (squares.len(), AtomicUsize::new(0));
        progress(0.0);
        squares.par_iter_mut().for_each(|square| {
            let bottom = (square.top + SQUARE_PX).min(view.height);
            for y in square.top..bottom {
                for x in square.left..square.left + square.width {
                    for sample in 0..view.samples {
                        let [px, py] = point(view, x, y, sample);
                        let met = match &grid {
                            None => self.nearest(&lens.ray(px, py)),
                            Some(grid) => self.nearest_in_view(grid, &lens, px, py),
                        };
                        let seed = hash(x ^ hash(y ^ hash(sample)));
                        let seen =
                            self.seen(&lens.ray(px, py), met, view.sky_rays, seed, &mut square.mirrored);
                        square.fragments.push(seen);
                    }
                }
            }
            progress((done.fetch_add(1, Ordering::Relaxed) + 1) as f64 / count as f64);
        });
        Ok(Fragments { view: *view, lens, squares })
    }

    /// Of a ray from the camera, which may come to water first: then what that mirrors is found too.
    fn seen(
        &self,
        ray: &WorldRay,
        met: Option<PlantHit>,
        sky_rays: u32,
        seed: u32,
        mirrored: &mut Vec<Fragment>,
    ) -> Fragment {
        let ground = self.soil.as_ref().and_then(|soil| soil.along(ray));
        let nearest = met.map_or(f64::INFINITY, |met| met.distance_m).min(ground.unwrap_or(f64::INFINITY));
        let along = |water: &Water| Some((*water, water.along(ray)?));
        let Some((water, distance_m)) = self.water.as_ref().and_then(along).filter(|(_, d)| *d < nearest)
        else {
            return self.fragment(ray, met, ground, sky_rays, seed);
        };
        let back = water.mirrored(ray, distance_m);
        let ground = self.soil.as_ref().and_then(|soil| soil.along(&back));
        mirrored.push(self.fragment(&back, self.nearest(&back), ground, sky_rays, seed));
        let sky = self.open_sky(back.origin, Vec3::Y, sky_rays, seed);
        Fragment::Water { distance_m, sky, mirrored: mirrored.len() as u32 - 1 }
    }

    /// Of a ray that comes to no water. `ground` is the distance to the ground.
    fn fragment(
        &self,
        ray: &WorldRay,
        met: Option<PlantHit>,
        ground: Option<f64>,
        sky_rays: u32,
        seed: u32,
    ) -> Fragment {
        match (met, ground) {
            (Some(met), None) => Fragment::Plant { instance: met.instance, found: met.found },
            (Some(met), Some(distance_m)) if met.distance_m <= distance_m => {
                Fragment::Plant { instance: met.instance, found: met.found }
            }
            (_, Some(distance_m)) => {
                let point = ray.origin + ray.direction * distance_m;
                let sky = self
                    .soil
                    .as_ref()
                    .map_or(1.0, |soil| self.open_sky(soil.off(point), soil.normal(point), sky_rays, seed));
                Fragment::Ground { distance_m, sky }
            }
            (None, None) => Fragment::Sky,
        }
    }

    /// Light of the sky on a point of ground or water, as a share of that without plants.
    fn open_sky(&self, origin: DVec3, normal: Vec3, rays: u32, seed: u32) -> f32 {
        if rays == 0 {
            return 1.0;
        }
        let is_open = |ray: &u32| {
            let direction = around(normal, sequence(seed, *ray)).as_dvec3();
            !self.is_hidden(&WorldRay { origin, direction })
        };
        let open = (0..rays).filter(is_open).count() as f32 / rays as f32;
        open + (1.0 - open) * LEAVES_BEFORE_SKY
    }
}

/// A unit vector on the side of `normal`, spread by its cosine over points of the unit square.
fn around(normal: Vec3, [u, v]: [f32; 2]) -> Vec3 {
    let y = 2.0 * u - 1.0;
    let (sin, cos) = libm::sincosf(std::f32::consts::TAU * v);
    let level = (1.0 - y * y).max(0.0).sqrt();
    (normal + Vec3::new(level * cos, y, level * sin)).normalize_or(normal)
}
