//! A picture of a plant alone: a forest of one, before a camera that frames it.

use flb_format::progress::Progress;
use flb_format::sun::towards_sun;
use flb_format::{Placement, Transform};
use glam::DVec3;

use crate::forest::{Eye, Forest, Ground, Land, Search, Species, View};
use crate::scene::Scene;
use crate::settings::range;
use crate::{LightFn, Lighting, Look, Picture, RenderError, lens};

/// Room left around the plant, as a share of the picture's half width and height.
const MARGIN: f64 = 0.07;
/// Linear reflectance of the ground: dry grass.
const GROUND: [f32; 3] = [0.23, 0.22, 0.15];
/// Sizes of the plant from its middle at which the ground has faded.
const FADES_AT: f64 = 1.5;

/// Size and direction of the picture of a plant. [`Default`] is a square portrait from the south.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Portrait {
    /// Pixels per row, 1..=16384.
    pub width: u32,
    /// Rows, 1..=16384; at most 2^26 pixels altogether.
    pub height: u32,
    /// Samples per pixel, 1..=4096.
    pub samples: u32,
    /// Azimuth of the camera, degrees clockwise from north (-Z) seen from above; 180 stands in the south and looks
    /// north, so that the morning sun (east, +X) is on the right.
    pub view_azimuth_deg: f64,
    /// Height of the camera above the horizon, degrees, -89..=89.
    pub view_elevation_deg: f64,
    /// Vertical opening angle, degrees, 1..=120.
    pub field_of_view_deg: f64,
    /// A level matt ground under the plant that catches its shadow and fades into the sky: reflectance 0.23, 0.22,
    /// 0.15. It sends the plant no light.
    pub has_ground: bool,
}

impl Default for Portrait {
    fn default() -> Portrait {
        Portrait {
            width: 768,
            height: 768,
            samples: 16,
            view_azimuth_deg: 180.0,
            view_elevation_deg: 12.0,
            field_of_view_deg: 30.0,
            has_ground: true,
        }
    }
}

/// Ray traces a plant in the light of one sun and of `light`, which is asked for instance 0.
///
/// Of the plant's classes, leaves get a highlight in the `paper` shading, and light passes through them in the
/// `physical` one. `progress` is called with the share done, 0..=1, from any thread.
///
/// # Errors
/// [`RenderError`] for settings outside their limits, a mesh without triangles, a wrong number of classes,
/// vertices that are not finite, and light that is not finite.
pub fn render_plant(
    plant: &Species<'_>,
    portrait: &Portrait,
    lighting: &Lighting,
    look: &Look,
    light: &LightFn<'_>,
    progress: &Progress<'_>,
) -> Result<Picture, RenderError> {
    let (forest, view) = portrait.prepare(plant, lighting, look)?;
    forest.render(&view, lighting, look, light, progress)
}

/// How much of each pixel of a plant's picture is covered, as [`Forest::coverage`] has it.
///
/// # Errors
/// As [`render_plant`].
pub fn cover_of_plant(
    plant: &Species<'_>,
    portrait: &Portrait,
    lighting: &Lighting,
    look: &Look,
) -> Result<Picture, RenderError> {
    let (forest, view) = portrait.prepare(plant, lighting, look)?;
    forest.coverage_of(&view, lighting, look)
}

impl Portrait {
    /// A forest of one plant, and the view that frames it. Numbers are checked before.
    pub(crate) fn prepare<'a>(
        &self,
        plant: &Species<'a>,
        lighting: &Lighting,
        look: &Look,
    ) -> Result<(Forest<'a>, View), RenderError> {
        self.check()?;
        lighting.validated()?;
        look.check()?;
        let alone = Placement { species: 0, transform: Transform::IDENTITY };
        let mut forest = Forest::prepare(std::slice::from_ref(plant), &[alone], None, Search::default())?;
        let (scene, _) = forest.first_model();
        let eye = self.eye(scene);
        let ground = Ground {
            land: Land::Plane { height_m: scene.min.y.into() },
            color: GROUND,
            fades_at_m: Some(f64::from(scene.size()) * FADES_AT),
        };
        if self.has_ground {
            forest = forest.with_ground(ground)?;
        }
        Ok((forest, self.view(eye)))
    }

    fn check(&self) -> Result<(), RenderError> {
        let nowhere = Eye { position_m: [0.0; 3], look_at_m: [0.0; 3], fov_deg: self.field_of_view_deg };
        self.view(nowhere).check_picture()?;
        range("view_azimuth_deg", self.view_azimuth_deg, -36_000.0, 36_000.0)?;
        range("view_elevation_deg", self.view_elevation_deg, -89.0, 89.0)?;
        range("field_of_view_deg", self.field_of_view_deg, 1.0, 120.0)
    }

    fn view(&self, eye: Eye) -> View {
        View { eye, width: self.width, height: self.height, samples: self.samples, sky_rays: 0, time_s: 0.0 }
    }

    /// At the nearest place on the line of sight from which every vertex lies inside the margin.
    fn eye(&self, scene: &Scene<'_>) -> Eye {
        // The camera stands where the sun would stand at its angles.
        let backward = DVec3::from(towards_sun(self.view_azimuth_deg, self.view_elevation_deg));
        let (forward, fov_deg) = (-backward, self.field_of_view_deg);
        let size = [self.width, self.height];
        let ([right, up], [half_width, half_height]) = (lens::upright(forward), lens::half(fov_deg, size));

        let target = (scene.min.as_dvec3() + scene.max.as_dvec3()) / 2.0;
        let mut distance = f64::from(scene.size()) * 1e-3;
        for vertex in scene.vertices() {
            let offset = vertex.as_dvec3() - target;
            let reach = (offset.dot(right).abs() / half_width).max(offset.dot(up).abs() / half_height);
            distance = distance.max(reach / (1.0 - MARGIN) - offset.dot(forward));
        }
        let position_m = (target + backward * distance).to_array();
        Eye { position_m, look_at_m: target.to_array(), fov_deg }
    }
}
