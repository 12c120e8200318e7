//! Rays in the light of a sun: shadow rays and baked light, and nothing that the camera has found before.

use flb_format::progress::Progress;
use flb_scene::MaterialClass;
use flb_scene::sky::Sky;
use glam::{DVec3, Vec3};

use super::{
    Forest, Fragments, InstanceSearch, View,
    fragments::{Camera, Fragment, Square, Tracer},
    ground::GroundSurface,
    placed::WorldRay,
    scenery::Scenery,
    squares,
    sun_grid::{self, SunGrid},
    trace::SunWay,
    water::{Facet, INTO_FROM_SKY, Water, WaterSurface, reflectance},
};
use crate::{
    Lighting, Look, Picture, RenderError,
    backdrop::sky_gradient,
    picture::{if_finite, not_below_0},
    scene::{Hit, TriangleHit},
    shading::Seen,
    sun::Sunlight,
};

/// Point and side of a surface for which light is asked.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct LightQuery {
    /// Number of the plant that the surface belongs to; 0 for a plant alone.
    pub instance: u32,
    /// A point of model space, metres.
    pub point: [f32; 3],
    /// Unit normal of the side of a solid that is seen, in model space; a leaf has one light for both of its sides.
    pub facing: Option<[f32; 3]>,
}

/// Source of phi: writes phi per band, R, G, B, with sun and sky applied, their directions turned into the plant's own
/// frame. In the `physical` shading phi is the fluence of what was scattered and of the sky, in units in which a sun of
/// irradiance 1 has fluence 1.
pub type LightFn<'a> = dyn Fn(LightQuery, &mut [f32; 3]) + Sync + 'a;

impl LightQuery {
    /// At a point that stands for where a ray met a surface.
    pub(crate) fn of(instance: u32, point: Vec3, hit: &Hit) -> LightQuery {
        let facing = (hit.class != MaterialClass::Leaf).then(|| hit.flat_normal.to_array());
        LightQuery { instance, point: point.to_array(), facing }
    }
}

/// A scene under one sun.
pub(crate) struct Lit<'a> {
    forest: &'a Forest<'a>,
    lighting: &'a Lighting,
    look: &'a Look,
    light: &'a LightFn<'a>,
    sun: SunWay,
    scenery: Scenery,
    /// What a white ground sends out under open sky.
    white_under_sky: Vec3,
    /// The sky that is drawn, where it is not the even one.
    drawn_sky: Option<Sky>,
}

impl Forest<'_> {
    /// A picture of fragments that this forest has traced, in the light of a sun and of `light`. `progress` is called
    /// with the share done, 0..=1, from any thread.
    ///
    /// # Errors
    /// [`RenderError`] for settings outside their limits, and for light that is not finite.
    pub fn relight(
        &self,
        fragments: &Fragments,
        lighting: &Lighting,
        look: &Look,
        light: &LightFn<'_>,
        progress: &Progress<'_>,
    ) -> Result<Picture, RenderError> {
        let camera = &fragments.camera;
        let lit = Lit::new(self, camera, lighting, look, light)?;
        let work = |number, _| lit.square(camera, fragments.square(number));
        picture(&camera.view, squares::pixels(&camera.view, progress, work)?)
    }

    /// Renders a picture in one go, of as many rays as one likes: what they meet is not kept.
    ///
    /// # Errors
    /// As [`Forest::relight`], and [`RenderError::Underwater`].
    pub fn render(
        &self,
        view: &View,
        lighting: &Lighting,
        look: &Look,
        light: &LightFn<'_>,
        progress: &Progress<'_>,
    ) -> Result<Picture, RenderError> {
        let camera = Camera::new(self, view)?;
        let lit = Lit::new(self, &camera, lighting, look, light)?;
        let tracer = Tracer::new(self, camera);
        picture(view, squares::pixels(view, progress, |_, area| lit.square(&camera, &tracer.square(area)))?)
    }

    /// How much of each pixel is covered by plants, water and ground that has not faded into the haze, 0 to 1, in all
    /// bands: the alpha of a picture of these fragments without a backdrop ([`Look::has_backdrop`]).
    ///
    /// # Errors
    /// [`RenderError`] for settings outside their limits.
    pub fn coverage(
        &self,
        fragments: &Fragments,
        lighting: &Lighting,
        look: &Look,
    ) -> Result<Picture, RenderError> {
        let camera = &fragments.camera;
        let lit = Lit::new(self, camera, lighting, look, &|_, _| {})?;
        let work = |number, _| lit.covered_square(camera, fragments.square(number));
        picture(&camera.view, squares::pixels(&camera.view, &|_| Ok(()), work)?)
    }

    /// The same of a picture whose fragments are not kept.
    ///
    /// # Errors
    /// As [`Forest::render`].
    pub(crate) fn coverage_of(
        &self,
        view: &View,
        lighting: &Lighting,
        look: &Look,
    ) -> Result<Picture, RenderError> {
        let camera = Camera::new(self, view)?;
        let lit = Lit::new(self, &camera, lighting, look, &|_, _| {})?;
        let tracer = Tracer::new(self, camera);
        let work = |_, area| lit.covered_square(&camera, &tracer.square(area));
        picture(view, squares::pixels(view, &|_| Ok(()), work)?)
    }
}

/// The means of a square's pixels, `[y][x]`, not below 0, of what `color` gives each of their rays; it gets what water
/// sends back, too.
fn means(
    camera: &Camera,
    square: &Square,
    color: impl Fn(&Fragment, &[Fragment], &WorldRay) -> Vec3,
) -> Vec<[f32; 3]> {
    let samples = camera.view.samples;
    let pixels = square.fragments.chunks_exact(samples as usize);
    let mean = |(pixel, (x, y)): (&[Fragment], (u32, u32))| {
        let mut sum = Vec3::ZERO;
        for (sample, fragment) in (0..).zip(pixel) {
            sum += color(fragment, &square.mirrored, &camera.ray(x, y, sample));
        }
        not_below_0((sum / samples as f32).to_array())
    };
    pixels.zip(square.area.pixels()).map(mean).collect()
}

pub(crate) fn picture(view: &View, pixels: Vec<[f32; 3]>) -> Result<Picture, RenderError> {
    if_finite(Picture { width: view.width, height: view.height, rgb: pixels.into_flattened() })
}

impl<'a> Lit<'a> {
    pub(crate) fn new(
        forest: &'a Forest<'a>,
        camera: &Camera,
        lighting: &'a Lighting,
        look: &'a Look,
        light: &'a LightFn<'a>,
    ) -> Result<Lit<'a>, RenderError> {
        let scenery = forest.around().scenery(lighting, look, camera.lens.position.to_array())?;
        let towards = DVec3::from(scenery.towards_sun);
        let white_under_sky = Vec3::from(scenery.white_under_sky);
        let grid = match forest.search.shadow {
            InstanceSearch::Tree => None,
            InstanceSearch::Grid => {
                let extents = forest.instances.iter().map(|placed| placed.extent);
                Some(SunGrid::new(extents, towards, sun_grid::PAD))
            }
        };
        let sun = SunWay { towards, grid };
        let drawn_sky = lighting.drawn_sky(scenery.sky_strength);
        Ok(Lit { forest, lighting, look, light, sun, scenery, white_under_sky, drawn_sky })
    }

    /// The means of a square's pixels, `[y][x]`, not below 0.
    fn square(&self, camera: &Camera, square: &Square) -> Vec<[f32; 3]> {
        let time_s = camera.view.time_s;
        means(camera, square, |fragment, mirrored, ray| self.seen(fragment, mirrored, ray, time_s))
    }

    /// How much of a square's pixels is covered, `[y][x]`, in all bands.
    fn covered_square(&self, camera: &Camera, square: &Square) -> Vec<[f32; 3]> {
        means(camera, square, |fragment, _, ray| Vec3::splat(self.covered(fragment, ray)))
    }

    /// How much a ray from the camera is stopped.
    fn covered(&self, fragment: &Fragment, ray: &WorldRay) -> f32 {
        match fragment {
            Fragment::Sky => 0.0,
            Fragment::Ground { distance_m, .. } => self.cover(ray.origin + ray.direction * *distance_m),
            Fragment::Plant { .. } | Fragment::Water { .. } => 1.0,
        }
    }

    /// Linear colour that a ray from the camera sees; `mirrored` is what water sends back.
    fn seen(&self, fragment: &Fragment, mirrored_at: &[Fragment], ray: &WorldRay, time_s: f64) -> Vec3 {
        match (fragment, &self.forest.water) {
            (Fragment::Water { distance_m, sky, mirrored }, Some(surface)) => {
                let facet = surface.facet(ray, *distance_m, time_s);
                let Facet { back, share, .. } = &facet;
                let image = mirrored_at.get(*mirrored as usize).unwrap_or(&Fragment::Sky);
                let body = self.body(&surface.water, back.origin, *sky) * (1.0 - share);
                let image = self.color_before(image, back, || self.sky_color(back));
                image * *share + body + self.highlight(surface, &facet, ray)
            }
            _ => self.color(fragment, ray),
        }
    }

    /// What comes out of the water at a point of it.
    fn body(&self, water: &Water, point: DVec3, sky: f32) -> Vec3 {
        let cosine = self.sun.towards.y as f32;
        let sun = self.sun_on(point, cosine) * (1.0 - reflectance(cosine));
        water.color() * (sun + self.sky_on(sky) * INTO_FROM_SKY)
    }

    /// The sun's highlight on water, of a ray to a facet of it.
    fn highlight(&self, surface: &WaterSurface, facet: &Facet, ray: &WorldRay) -> Vec3 {
        let units = self.forest.units;
        let share = match units.has_highlights() {
            true => {
                let highlight = units.highlights(self.look).water;
                highlight.towards(facet.normal.as_vec3(), self.sunlight().towards, ray.direction.as_vec3())
            }
            false => surface.glint(facet, ray.direction, self.sun.towards),
        };
        self.sun_on(facet.back.origin, share)
    }

    /// Linear colour of anything but water along a ray.
    pub(crate) fn color(&self, fragment: &Fragment, ray: &WorldRay) -> Vec3 {
        match self.look.has_backdrop {
            true => self.color_before(fragment, ray, || self.sky_color(ray)),
            false => self.color_before(fragment, ray, || Vec3::ZERO),
        }
    }

    /// The same before a sky.
    fn color_before(&self, fragment: &Fragment, ray: &WorldRay, sky_color: impl Fn() -> Vec3) -> Vec3 {
        match (fragment, &self.forest.soil) {
            (Fragment::Plant { instance, found }, _) => self.plant(*instance, found, ray),
            (Fragment::Ground { distance_m, sky }, Some(soil)) => {
                let point = ray.origin + ray.direction * *distance_m;
                let cover = self.cover(point);
                if cover == 0.0 {
                    return sky_color();
                }
                self.ground(soil, point, *sky) * cover + sky_color() * (1.0 - cover)
            }
            _ => sky_color(),
        }
    }

    /// Of the scene, in the frame of the world.
    pub(crate) fn sunlight(&self) -> Sunlight {
        Sunlight {
            towards: self.sun.towards.as_vec3(),
            strength: self.scenery.sun_strength,
            color: Vec3::from(self.lighting.sun_color),
        }
    }

    fn plant(&self, instance: u32, found: &TriangleHit, ray: &WorldRay) -> Vec3 {
        let placed = &self.forest.instances[instance as usize];
        let model = &self.forest.models[placed.placement.species];
        let looking = placed.model_direction(ray.direction).as_vec3();
        let hit = model.surface(looking, found);
        let towards = placed.model_direction(self.sun.towards).as_vec3();
        let sun = Sunlight { towards, ..self.sunlight() };
        let sees = |side: Vec3| !self.forest.is_shaded(&self.sun, instance, &hit, side);
        let has_direct = self.look.has_direct() && self.scenery.sun_strength > 0.0;
        let phi = |query: LightQuery| {
            let mut phi = [0.0; 3];
            (self.light)(query, &mut phi);
            Vec3::from(phi)
        };
        let seen = Seen { instance, hit: &hit, looking, sun, has_direct };
        seen.color(model.finish.as_ref(), self.look, sees, phi)
    }

    fn ground(&self, soil: &GroundSurface, point: DVec3, sky: f32) -> Vec3 {
        let cosine = soil.normal(point).dot(self.sun.towards.as_vec3());
        soil.color() * (self.sun_on(soil.off(point), cosine) + self.sky_on(sky))
    }

    /// What a white ground sends out at a point because of the sun. `cosine` is of its angle to the ground's normal.
    fn sun_on(&self, origin: DVec3, cosine: f32) -> Vec3 {
        if !self.look.has_direct() || cosine <= 0.0 || self.scenery.white_in_sun <= 0.0 {
            return Vec3::ZERO;
        }
        let ray = WorldRay { origin, direction: self.sun.towards };
        match self.forest.is_blocked(&self.sun, &ray, None) {
            true => Vec3::ZERO,
            false => Vec3::from(self.lighting.sun_color) * (cosine * self.scenery.white_in_sun),
        }
    }

    /// What it sends out because of the sky, of which it sees a share.
    fn sky_on(&self, share: f32) -> Vec3 {
        match self.look.has_indirect() {
            true => self.white_under_sky * share,
            false => Vec3::ZERO,
        }
    }

    /// How much of the ground is left of the haze.
    fn cover(&self, point: DVec3) -> f32 {
        let offset = point - DVec3::from(self.scenery.center_m);
        let reach = (offset.x * offset.x + offset.z * offset.z).sqrt() / self.scenery.haze_m;
        let inward = (1.0 - reach).clamp(0.0, 1.0) as f32;
        (inward * inward * (3.0 - 2.0 * inward)).min(1.0)
    }

    fn sky_color(&self, ray: &WorldRay) -> Vec3 {
        match (&self.drawn_sky, self.look.has_sky && self.look.has_direct()) {
            (_, false) => Vec3::ZERO,
            (None, true) => sky_gradient(ray.direction.y as f32) * self.scenery.sky_strength,
            (Some(drawn), true) => Vec3::from(drawn.seen(ray.direction.as_vec3().to_array())),
        }
    }
}
