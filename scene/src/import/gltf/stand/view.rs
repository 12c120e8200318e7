//! The camera and the sun of a glTF. A scene does without either, so that what cannot be used is a warning.

use flb_format::eye::Eye;
use glam::{DMat4, DVec3};
use gltf::json::camera::Type;
use gltf::json::validation::Checked;
use gltf::json::{Node, Root};
use serde::Deserialize;

use crate::import::error::ImportError;
use crate::import::files::Files;
use crate::import::gltf::scene::Scene;
use crate::import::gltf::transform::place_of;
use crate::scene::MAX_COORDINATE_M;

/// How far in front of a camera the point lies that it looks at.
const AHEAD_M: f64 = 10.0;
/// Vertical fields of view that a scene may have.
const FOV_DEG: std::ops::RangeInclusive<f64> = 0.001..=179.0;
/// A camera that leans to its side by more than this sine is told so: a scene's stands upright.
const LEAN: f64 = 0.02;

const LIGHTS: &str = "KHR_lights_punctual";

#[derive(Deserialize)]
struct Lights {
    lights: Vec<Light>,
}

#[derive(Deserialize)]
struct Light {
    #[serde(rename = "type")]
    kind: String,
    #[serde(default = "white")]
    color: [f64; 3],
}

fn white() -> [f64; 3] {
    [1.0; 3]
}

#[derive(Deserialize)]
struct NodeLight {
    light: usize,
}

/// The first perspective camera, by node.
pub(super) fn camera(
    files: &mut Files,
    root: &Root,
    worlds: &[Option<DMat4>],
) -> Result<Option<Eye>, ImportError> {
    let mut first = None;
    for (index, node) in root.nodes.iter().enumerate() {
        let Some((camera, world)) = node.camera.map(|camera| camera.value()).zip(worlds[index]) else {
            continue;
        };
        let Some(json) = root.cameras.get(camera) else {
            let expected = format!("one of {}", root.cameras.len());
            return Err(files.malformed(place_of(root, index), format!("camera {camera}"), expected));
        };
        let fov_deg = match (&json.type_, &json.perspective) {
            (Checked::Valid(Type::Perspective), Some(lens)) => f64::from(lens.yfov).to_degrees(),
            _ => f64::NAN,
        };
        let place = place_of(root, index);
        let (Some(ahead), true) = (backward(world), FOV_DEG.contains(&fov_deg)) else {
            files.warn(format!("the camera of {place} has no perspective that a scene can have; ignored"));
            continue;
        };
        if first.is_some() {
            files.warn(format!("the camera of {place} is not the first; ignored"));
            continue;
        }
        let position = world.w_axis.truncate();
        if position.abs().max_element() > MAX_COORDINATE_M - AHEAD_M {
            files.warn(format!("the camera of {place} stands farther off than 1e9 m; ignored"));
            continue;
        }
        if world.x_axis.truncate().normalize_or_zero().y.abs() > LEAN {
            files.warn(format!("the camera of {place} leans to its side; a scene's stands upright"));
        }
        let look_at_m = (position - ahead * AHEAD_M).to_array();
        first = Some(Eye { position_m: position.to_array(), look_at_m, fov_deg });
    }
    Ok(first)
}

/// Azimuth and elevation of the first directional light, by node, degrees.
pub(super) fn sun(files: &mut Files, root: &Root, scene: &Scene) -> Result<Option<[f64; 2]>, ImportError> {
    let json = root.extensions.as_ref().and_then(|extensions| extensions.others.get(LIGHTS));
    let lights = match json.map(Lights::deserialize) {
        Some(Ok(Lights { lights })) => lights,
        Some(Err(error)) => return Err(files.malformed(LIGHTS, error, "lights, each with a type")),
        None => Vec::new(),
    };
    let mut first = None;
    for (index, node) in root.nodes.iter().enumerate() {
        let (Some(light), Some(world)) = (light_of(files, root, index, node)?, scene.worlds[index]) else {
            continue;
        };
        let Some(Light { kind, color }) = lights.get(light) else {
            let expected = format!("one of {}", lights.len());
            return Err(files.malformed(place_of(root, index), format!("light {light}"), expected));
        };
        let place = place_of(root, index);
        match (kind == "directional", backward(world)) {
            _ if !scene.shown[index] => files.warn(format!("the light of {place} is hidden; ignored")),
            (true, Some(towards)) if first.is_none() => {
                let [azimuth, elevation] = angles(towards);
                if elevation < 0.0 {
                    files.warn(format!(
                        "the sun of {place} stands {:.1} degrees below the horizon",
                        -elevation
                    ));
                }
                if let [r, g, b] = *color
                    && [g, b] != [r; 2]
                {
                    files.warn(format!("the sun of {place} has the colour {r} {g} {b}; a scene's is white"));
                }
                first = Some([azimuth, elevation]);
            }
            (true, Some(_)) => files.warn(format!("the sun of {place} is not the first; ignored")),
            (true, None) => files.warn(format!("the sun of {place} has no direction; ignored")),
            (false, _) => files.warn(format!("the light of {place} is not directional; ignored")),
        }
    }
    Ok(first)
}

fn light_of(files: &Files, root: &Root, index: usize, node: &Node) -> Result<Option<usize>, ImportError> {
    let Some(json) = node.extensions.as_ref().and_then(|extensions| extensions.others.get(LIGHTS)) else {
        return Ok(None);
    };
    let malformed = |error| files.malformed(format!("{}, {LIGHTS}", place_of(root, index)), error, "a light");
    NodeLight::deserialize(json).map(|node| Some(node.light)).map_err(malformed)
}

/// The direction of +Z: cameras look and suns shine along -Z. `None` where the transform has lost it.
fn backward(world: DMat4) -> Option<DVec3> {
    world.z_axis.truncate().try_normalize()
}

/// Sines below this are what rounding leaves of a sun overhead, which has no azimuth.
const OVERHEAD: f64 = 1e-6;

/// Azimuth clockwise from north, -Z, over east, +X; and elevation.
fn angles(towards: DVec3) -> [f64; 2] {
    if towards.x.abs().max(towards.z.abs()) < OVERHEAD {
        return [0.0, 90.0_f64.copysign(towards.y)];
    }
    let azimuth = libm::atan2(towards.x, -towards.z).to_degrees();
    let azimuth = if azimuth < 0.0 { azimuth + 360.0 } else { azimuth };
    [azimuth + 0.0, libm::asin(towards.y.clamp(-1.0, 1.0)).to_degrees()]
}
