//! What to render: size, sun, view, exposure. Checked once, before anything is allocated.

use flb_scene::sky::Sky;
use glam::DVec3;

use crate::{RenderError, Shading};

/// Longest edge of a picture, pixels.
pub const EDGE_LIMIT: u32 = 16_384;
/// Most pixels of a picture: 64 Mi, 768 MiB of linear colour.
pub const PIXEL_LIMIT: u64 = 1 << 26;
/// Most samples per pixel.
pub const SAMPLE_LIMIT: u32 = 4_096;

/// Which part of the light is shown. In linear light `Off` + `Only` = `On`.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Indirect {
    /// Direct and indirect light, and the background.
    On,
    /// Direct light and the background.
    Off,
    /// Indirect light alone, before black.
    Only,
}

/// What to render and from where. [`Default`] is a square portrait from the south.
#[derive(Debug, Clone, PartialEq)]
pub struct RenderSettings {
    /// Pixels per row, 1..=16384.
    pub width: u32,
    /// Rows, 1..=16384; at most 2^26 pixels altogether.
    pub height: u32,
    /// Samples per pixel, 1..=4096.
    pub samples: u32,
    /// Towards the sun, model space, any length but zero.
    pub sun: [f64; 3],
    /// How surfaces answer to light, and in which units.
    pub shading: Shading,
    /// Irradiance of the sun on a plane that faces it. A white matt plane then sends out as much in the
    /// `paper` shading, and the pi-th part of it as radiance in the `physical` one. The closure applies its
    /// own sun to phi.
    pub sun_strength: f32,
    /// Factor on it per band, R, G, B; of the `physical` shading alone.
    pub sun_color: [f32; 3],
    /// Ambient light, as given to the closure: a weight on the ambient base in the `paper` shading, the
    /// fluence of an isotropic sky in the `physical` one, a quarter of which falls on level ground. Here it
    /// lights the ground and brightens the sky; in a path-traced reference it lights the plant too.
    pub ambient: f32,
    /// An uneven sky in the place of the even one, in the frame of the model; `ambient` does not count then. It lights
    /// the ground and is seen behind the plant; in a path-traced reference it lights the plant too. The closure applies
    /// it to phi. Of the `physical` shading alone.
    pub dome: Option<Sky>,
    /// Which part of the light is shown.
    pub indirect: Indirect,
    /// Scale of indirect light in the `paper` shading.
    pub indirect_scale: f32,
    /// Strength of the leaves' highlight in the `paper` shading; 0 is matt.
    pub specular: f32,
    /// Where the camera stands, degrees clockwise from north (-Z) seen from above; 180 stands in the south
    /// and looks north, so that the morning sun (east, +X) is on the right.
    pub view_azimuth_deg: f64,
    /// Height of the camera above the horizon, degrees, -89..=89.
    pub view_elevation_deg: f64,
    /// Vertical opening angle, degrees, 1..=120.
    pub field_of_view_deg: f64,
    /// Stops: the picture is multiplied by 2^exposure before tone mapping. Linear output is left alone.
    pub exposure: f32,
    /// A round matt ground under the plant that catches its shadow: reflectance 0.23, 0.22, 0.15. It sends
    /// the plant no light.
    pub ground: bool,
    /// A gradient of sky in the background; black without. It is scenery: in the `physical` shading it has
    /// the mean luminance of the even, white sky that lights the plant, drawn or not.
    pub sky: bool,
}

impl Default for RenderSettings {
    fn default() -> Self {
        RenderSettings {
            width: 768,
            height: 768,
            samples: 16,
            sun: [0.4, 0.7, 0.5],
            shading: Shading::Paper,
            sun_strength: 1.0,
            sun_color: [1.0; 3],
            dome: None,
            ambient: 0.02,
            indirect: Indirect::On,
            indirect_scale: 0.5,
            specular: 0.08,
            view_azimuth_deg: 180.0,
            view_elevation_deg: 12.0,
            field_of_view_deg: 30.0,
            exposure: 0.0,
            ground: true,
            sky: true,
        }
    }
}

impl RenderSettings {
    /// Checks every setting and gives back the unit vector towards the sun.
    pub(crate) fn validated(&self) -> Result<DVec3, RenderError> {
        for (name, edge) in [("width", self.width), ("height", self.height)] {
            whole(name, edge, EDGE_LIMIT)?;
        }
        let pixels = u64::from(self.width) * u64::from(self.height);
        if pixels > PIXEL_LIMIT {
            return Err(refuse("width x height", pixels, format!("at most {PIXEL_LIMIT} pixels")));
        }
        whole("samples", self.samples, SAMPLE_LIMIT)?;
        range("sun_strength", self.sun_strength.into(), 0.0, 1e6)?;
        for band in self.sun_color {
            range("sun_color", band.into(), 0.0, 1e6)?;
        }
        if self.dome.is_some() && self.shading == Shading::Paper {
            return Err(dome_over_paper());
        }
        range("ambient", self.ambient.into(), 0.0, 1e6)?;
        range("indirect_scale", self.indirect_scale.into(), 0.0, 1e6)?;
        range("specular", self.specular.into(), 0.0, 1e3)?;
        range("view_azimuth_deg", self.view_azimuth_deg, -36_000.0, 36_000.0)?;
        range("view_elevation_deg", self.view_elevation_deg, -89.0, 89.0)?;
        range("field_of_view_deg", self.field_of_view_deg, 1.0, 120.0)?;
        range("exposure", self.exposure.into(), -32.0, 32.0)?;
        if let Shading::Physical(surfaces) = &self.shading {
            surfaces.check()?;
        }
        sun_direction(self.sun)
    }
}

/// An uneven sky where the file does not say what comes from the sky itself.
pub(crate) fn dome_over_paper() -> RenderError {
    refuse("dome", "a sky with the shading `paper`", "the shading `physical`".into())
}

/// The unit vector of a direction of any length.
pub(crate) fn sun_direction(sun: [f64; 3]) -> Result<DVec3, RenderError> {
    let direction = DVec3::from(sun);
    let length = direction.length();
    if !(length.is_finite() && length > 1e-9) {
        return Err(refuse("sun", format!("{sun:?}"), "a finite direction that is not zero".into()));
    }
    Ok(direction / length)
}

fn whole(name: &'static str, found: u32, limit: u32) -> Result<(), RenderError> {
    if (1..=limit).contains(&found) { Ok(()) } else { Err(refuse(name, found, format!("1..={limit}"))) }
}

pub(crate) fn range(name: &'static str, found: f64, low: f64, high: f64) -> Result<(), RenderError> {
    if found >= low && found <= high { Ok(()) } else { Err(refuse(name, found, format!("{low}..={high}"))) }
}

fn refuse(name: &'static str, found: impl ToString, expected: String) -> RenderError {
    RenderError::Setting { name, found: found.to_string(), expected }
}
