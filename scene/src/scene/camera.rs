//! The `[camera]` of a scene file.

use serde::Deserialize;
use toml::Spanned;

use super::Camera;
use super::reading::{Checked, Reading};

/// Points of a camera path.
pub const MAX_CAMERA_POINTS: usize = 4096;

#[derive(Deserialize)]
#[serde(deny_unknown_fields)]
pub(super) struct RawCamera {
    position_m: Option<[f64; 3]>,
    path_m: Option<Vec<[f64; 3]>>,
    look_at_m: Option<Spanned<[f64; 3]>>,
    look_at_path_m: Option<Spanned<Vec<[f64; 3]>>>,
    fov_deg: Spanned<f64>,
    height_px: Spanned<u32>,
    pixels_per_site: Option<Spanned<f64>>,
}

impl Reading<'_> {
    pub(super) fn camera(&self, raw: Spanned<RawCamera>) -> Checked<Camera> {
        let (at, raw) = (raw.span().start, raw.into_inner());
        let path_m = match (raw.position_m, raw.path_m) {
            (Some(position_m), None) => vec![position_m],
            (None, Some(path_m)) if !path_m.is_empty() => path_m,
            (position_m, path_m) => {
                let found = match (position_m, path_m) {
                    (None, None) => "neither position_m nor path_m",
                    (None, _) => "a path_m without points",
                    _ => "position_m and path_m",
                };
                return Err(self.malformed(at, "camera", found, "one of position_m and path_m"));
            }
        };
        self.limit("camera.path_m", path_m.len(), MAX_CAMERA_POINTS)?;
        self.points(at, "a position of camera", &path_m)?;
        let look_at_m = self.looked_at(raw.look_at_m, raw.look_at_path_m, &path_m)?;
        let (fov, height) = (raw.fov_deg.span().start, raw.height_px.span().start);
        let fov_deg = self.within(fov, "camera.fov_deg", raw.fov_deg.into_inner(), 0.001, 179.0)?;
        let height_px = raw.height_px.into_inner();
        self.within(height, "camera.height_px", height_px.into(), 1.0, 1e6)?;
        let pixels_per_site = raw.pixels_per_site.map_or(Ok(4.0), |pixels| {
            self.within(pixels.span().start, "camera.pixels_per_site", pixels.into_inner(), 0.25, 256.0)
        })?;
        Ok(Camera { path_m, look_at_m, fov_deg, height_px, pixels_per_site })
    }

    /// A point for each position.
    fn looked_at(
        &self,
        one: Option<Spanned<[f64; 3]>>,
        path: Option<Spanned<Vec<[f64; 3]>>>,
        path_m: &[[f64; 3]],
    ) -> Checked<Option<Vec<[f64; 3]>>> {
        let (at, points) = match (one, path) {
            (None, None) => return Ok(None),
            (Some(one), None) => (one.span().start, vec![one.into_inner(); path_m.len()]),
            (None, Some(path)) => (path.span().start, path.into_inner()),
            (Some(one), Some(_)) => {
                let found = "look_at_m and look_at_path_m";
                return Err(self.malformed(one.span().start, "camera", found, "one of them"));
            }
        };
        if points.len() != path_m.len() {
            let expected = format!("{}, one for each position of the camera", path_m.len());
            let found = format!("{} points", points.len());
            return Err(self.malformed(at, "camera.look_at_path_m", found, &expected));
        }
        self.points(at, "what camera looks at", &points)?;
        match points.iter().zip(path_m).position(|(point, position)| point == position) {
            None => Ok(Some(points)),
            Some(same) => {
                let found = format!("{:?}, where it stands", points[same]);
                Err(self.malformed(at, "what camera looks at", found, "another point"))
            }
        }
    }
}
