//! What every ray of a picture meets first: traced once for a camera, lit as often as the sun moves.

use flb_format::progress::Progress;
use flb_scene::sampling::cosine_hemisphere;
use glam::{DVec3, Vec3};

use super::{
    Eye, Forest, InstanceSearch, eye,
    placed::WorldRay,
    squares::{self, Area},
    trace::PlantHit,
    view_grid::ViewGrid,
    water::WaterSurface,
};
use crate::lens::Lens;
use crate::scene::TriangleHit;
use crate::settings::{MAX_EDGE, MAX_PIXELS, MAX_SAMPLES};
use crate::{RenderError, jitter, r2_sequence};
use flb_scene::sampling::hash;
use flb_scene::waves::MAX_TIME_S;

/// Largest number of rays of a picture: 3 GiB of fragments, and as much again for what is mirrored, where all is water.
pub const MAX_RAYS: u64 = 1 << 27;
/// Largest number of rays that look for the sky from a point of the ground.
pub const MAX_SKY_RAYS: u32 = 256;
/// How bright plants that hide the sky from the ground are taken to be, as a share of it: their leaves let light
/// through and pass it on, and ground is scenery.
pub(super) const LEAVES_BEFORE_SKY: f32 = 0.25;

/// The picture that is to be taken.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct View {
    /// Position and direction of the camera.
    pub eye: Eye,
    /// Pixels per row, 1..=16384.
    pub width: u32,
    /// Rows, 1..=16384; at most 2^26 pixels altogether.
    pub height: u32,
    /// Rays per pixel, 1..=4096; at most 2^27 rays altogether.
    pub samples: u32,
    /// Rays that look for the sky from each point of the ground, 0..=256; with none, it lies under open sky.
    pub sky_rays: u32,
    /// Time of the waves on water, seconds.
    pub time_s: f64,
}

/// First hit of a ray.
#[derive(Debug, Clone, Copy, PartialEq)]
pub enum Fragment {
    /// Nothing was hit.
    Sky,
    /// The ground.
    Ground {
        /// Distance from the camera, metres.
        distance_m: f64,
        /// Light of the sky by the cosine, as a share of that without plants.
        sky: f32,
    },
    /// An instance.
    Plant {
        /// Number of the instance.
        instance: u32,
        /// Hit on the instance's model.
        found: TriangleHit,
    },
    /// Water.
    Water {
        /// Distance from the camera, metres.
        distance_m: f64,
        /// Light of the sky by the cosine, as a share of that without plants.
        sky: f32,
        /// Number in its square of what it mirrors, for [`Fragments::mirrored_at`]: few rays have one, and all would be
        /// larger for it.
        mirrored: u32,
    },
}

/// First hits of the rays of a picture, for [`Forest::relight`] on the forest that traced them.
pub struct Fragments {
    pub(crate) camera: Camera,
    /// Squares of the picture in rows.
    squares: Vec<Square>,
}

/// A view and the lens that its rays go through.
#[derive(Clone, Copy)]
pub(crate) struct Camera {
    pub view: View,
    pub lens: Lens,
}

/// The rays of a square of the picture.
pub(crate) struct Square {
    pub area: Area,
    /// `[y][x][sample]`
    pub fragments: Vec<Fragment>,
    /// Hits by way of the water, in the order of the rays that come to it.
    pub mirrored: Vec<Fragment>,
}

impl View {
    /// Refuses a view outside its limits.
    ///
    /// # Errors
    /// [`RenderError::Setting`].
    pub fn check(&self) -> Result<(), RenderError> {
        self.check_picture()?;
        let rays = u64::from(self.width) * u64::from(self.height) * u64::from(self.samples);
        match rays > MAX_RAYS {
            true => Err(RenderError::Setting {
                name: "width x height x samples",
                found: rays.to_string(),
                expected: format!("at most {MAX_RAYS} rays"),
            }),
            false => Ok(()),
        }
    }

    /// The same where fragments are not kept, so that any number of rays will do.
    pub(crate) fn check_picture(&self) -> Result<(), RenderError> {
        let refuse = |name, found: u64, expected: String| {
            Err(RenderError::Setting { name, found: found.to_string(), expected })
        };
        for (name, found, low, high) in [
            ("width", self.width, 1, MAX_EDGE),
            ("height", self.height, 1, MAX_EDGE),
            ("samples", self.samples, 1, MAX_SAMPLES),
            ("sky_rays", self.sky_rays, 0, MAX_SKY_RAYS),
        ] {
            if !(low..=high).contains(&found) {
                return refuse(name, found.into(), format!("{low}..={high}"));
            }
        }
        if !(-MAX_TIME_S..=MAX_TIME_S).contains(&self.time_s) {
            let expected = format!("-{MAX_TIME_S:e}..={MAX_TIME_S:e}");
            return Err(RenderError::Setting { name: "time_s", found: self.time_s.to_string(), expected });
        }
        let pixels = u64::from(self.width) * u64::from(self.height);
        match pixels > MAX_PIXELS {
            true => refuse("width x height", pixels, format!("at most {MAX_PIXELS} pixels")),
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

impl Camera {
    /// # Errors
    /// [`RenderError::Setting`] for a view outside its limits but for the number of rays; [`RenderError::Underwater`].
    pub(crate) fn new(forest: &Forest<'_>, view: &View) -> Result<Camera, RenderError> {
        view.check_picture()?;
        if let Some(water) = forest.water() {
            water.check_eye(view.eye.position_m)?;
        }
        Ok(Camera { view: *view, lens: eye::lens(&view.eye, [view.width, view.height])? })
    }

    /// Where in the picture the ray number `sample` of a pixel goes through, in pixels.
    fn point(&self, x: u32, y: u32, sample: u32) -> [f64; 2] {
        let [dx, dy] = jitter(x, y, sample, self.view.samples).map(f64::from);
        [f64::from(x) + dx, f64::from(y) + dy]
    }

    /// The ray number `sample` of a pixel.
    pub(crate) fn ray(&self, x: u32, y: u32, sample: u32) -> WorldRay {
        let [x, y] = self.point(x, y, sample);
        self.lens.ray(x, y)
    }
}

impl Fragments {
    /// The picture that they are of.
    pub fn view(&self) -> &View {
        &self.camera.view
    }

    /// The rays of a square, by its number in the order of the picture.
    pub(super) fn square(&self, number: usize) -> &Square {
        &self.squares[number]
    }

    #[cfg(test)]
    pub(super) fn squares(&self) -> impl Iterator<Item = &Square> {
        self.squares.iter()
    }

    /// Hit of the ray number `sample` of a pixel; `None` beyond the picture.
    pub fn at(&self, x: u32, y: u32, sample: u32) -> Option<Fragment> {
        self.in_square(x, y, sample).map(|(_, fragment)| fragment)
    }

    /// Hit of a ray by way of the water, its distance counted from there; `None` where the ray does not come to any.
    pub fn mirrored_at(&self, x: u32, y: u32, sample: u32) -> Option<Fragment> {
        match self.in_square(x, y, sample)? {
            (square, Fragment::Water { mirrored, .. }) => square.mirrored.get(mirrored as usize).copied(),
            _ => None,
        }
    }

    fn in_square(&self, x: u32, y: u32, sample: u32) -> Option<(&Square, Fragment)> {
        let view = &self.camera.view;
        if x >= view.width || y >= view.height || sample >= view.samples {
            return None;
        }
        let square = &self.squares[squares::number_of(view, x, y)];
        let pixel = (y - square.area.top) * square.area.width + x - square.area.left;
        let fragment = square.fragments.get((pixel * view.samples + sample) as usize)?;
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

    /// Rays that meet each of so many plants, by way of the water, too.
    pub fn on_plants(&self, plants: usize) -> Vec<u32> {
        let mut counts = vec![0_u32; plants];
        for fragment in self.squares.iter().flat_map(|square| square.fragments.iter().chain(&square.mirrored))
        {
            if let Fragment::Plant { instance, .. } = fragment {
                counts[*instance as usize] += 1;
            }
        }
        counts
    }

    /// Memory that they take.
    pub fn size_bytes(&self) -> usize {
        let of = |square: &Square| size_of_val(&square.fragments[..]) + size_of_val(&square.mirrored[..]);
        self.squares.iter().map(of).sum()
    }
}

/// A forest before a camera.
pub(crate) struct Tracer<'f> {
    forest: &'f Forest<'f>,
    camera: Camera,
    grid: Option<ViewGrid>,
}

impl<'f> Tracer<'f> {
    pub(crate) fn new(forest: &'f Forest<'f>, camera: Camera) -> Tracer<'f> {
        let size = [camera.view.width, camera.view.height];
        let extents = || forest.instances.iter().map(|placed| placed.extent);
        let grid = match forest.search.primary {
            InstanceSearch::Tree => None,
            InstanceSearch::Grid => Some(ViewGrid::new(extents(), &camera.lens, size)),
        };
        Tracer { forest, camera, grid }
    }

    pub(crate) fn square(&self, area: Area) -> Square {
        let samples = self.camera.view.samples;
        let rays = (area.width * area.height) as usize * samples as usize;
        let (mut fragments, mut mirrored) = (Vec::with_capacity(rays), Vec::new());
        for (x, y) in area.pixels() {
            fragments.extend((0..samples).map(|sample| self.fragment(x, y, sample, &mut mirrored)));
        }
        Square { area, fragments, mirrored }
    }

    /// What the ray number `sample` of a pixel meets; what it meets by way of the water is put into a list.
    pub(crate) fn fragment(&self, x: u32, y: u32, sample: u32, mirrored: &mut Vec<Fragment>) -> Fragment {
        let (forest, lens) = (self.forest, &self.camera.lens);
        let [px, py] = self.camera.point(x, y, sample);
        let ray = lens.ray(px, py);
        let met = match &self.grid {
            None => forest.nearest(&ray),
            Some(grid) => forest.nearest_in_view(grid, lens, px, py),
        };
        let seed = hash(x ^ hash(y ^ hash(sample)));
        forest.seen(&ray, met, &self.camera.view, seed, mirrored)
    }
}

impl Forest<'_> {
    /// Finds what every ray of a picture meets first. `progress` is called with the share done, 0..=1, from any thread.
    ///
    /// # Errors
    /// [`RenderError::Setting`] for a view outside its limits; [`RenderError::Underwater`].
    pub fn trace(&self, view: &View, progress: &Progress<'_>) -> Result<Fragments, RenderError> {
        view.check()?;
        let camera = Camera::new(self, view)?;
        let tracer = Tracer::new(self, camera);
        let squares = squares::in_parallel(view, progress, |_, area| tracer.square(area))?;
        Ok(Fragments { camera, squares })
    }

    /// Of a ray from the camera, which may come to water first: then what that mirrors is found too.
    fn seen<'s>(
        &'s self,
        ray: &WorldRay,
        met: Option<PlantHit>,
        view: &View,
        seed: u32,
        mirrored: &mut Vec<Fragment>,
    ) -> Fragment {
        let ground = self.soil.as_ref().and_then(|soil| soil.along(ray));
        let nearest = met.map_or(f64::INFINITY, |met| met.distance_m).min(ground.unwrap_or(f64::INFINITY));
        let View { sky_rays, time_s, .. } = *view;
        let along = |surface: &'s WaterSurface| Some((surface, surface.water.along(ray)?));
        let Some((surface, distance_m)) = self.water.as_ref().and_then(along).filter(|(_, d)| *d < nearest)
        else {
            return self.fragment(ray, met, ground, sky_rays, seed);
        };
        let back = surface.facet(ray, distance_m, time_s).back;
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
            let [height, turn] = r2_sequence(seed, *ray);
            let direction = cosine_hemisphere(normal, height, turn).as_dvec3();
            !self.is_hidden(&WorldRay { origin, direction })
        };
        let open = (0..rays).filter(is_open).count() as f32 / rays as f32;
        open + (1.0 - open) * LEAVES_BEFORE_SKY
    }
}
