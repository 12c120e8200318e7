//! A world matrix as position, rotation and one scale, where it is no more than these.

use std::f64::consts::FRAC_1_SQRT_2;

use glam::{DMat3, DMat4, DQuat, DVec3};

use super::Plant;
use crate::scene::{MAX_COORDINATE_M, SCALES};

/// Scales along the axes may differ by this share, and axes from right angles by this cosine: what f32 matrices leave
/// through a chain of nodes is a hundredth of it, and a leaf 10 m up is off by a millimetre.
const TOLERANCE: f64 = 1e-4;

const EXPECTED: &str = "a rotation and one scale along all axes, without mirror or shear: one bake serves no others (apply the scale to the mesh)";

/// The plant at `world_from_mesh`; else what was found and what was expected.
pub(super) fn plant(world: DMat4, species: usize) -> Result<Plant, (String, &'static str)> {
    let position_m = world.w_axis.truncate().to_array();
    if !world.is_finite() {
        return Err(("a transform that is not finite".to_owned(), "finite numbers"));
    }
    if position_m.iter().any(|x| x.abs() > MAX_COORDINATE_M) {
        return Err((format!("position {position_m:?}"), "coordinates of -1e9 to 1e9 m"));
    }
    let axes = [world.x_axis, world.y_axis, world.z_axis].map(|axis| axis.truncate());
    let scales = axes.map(DVec3::length);
    let scale = (scales[0] + scales[1] + scales[2]) / 3.0;
    if !(SCALES[0]..=SCALES[1]).contains(&scale) {
        return Err((format!("scale {scale}"), "a scale of 1e-6 to 1e6"));
    }
    let [x, y, z] = axes.map(|axis| axis / scale);
    if scales.iter().any(|one| (one / scale - 1.0).abs() > TOLERANCE) {
        return Err((format!("scales {scales:?} along x, y and z"), EXPECTED));
    }
    let slant = x.dot(y).abs().max(y.dot(z).abs()).max(z.dot(x).abs());
    if slant > TOLERANCE {
        return Err((format!("axes with a cosine of {slant:.6} between them (a shear)"), EXPECTED));
    }
    if x.cross(y).dot(z) < 0.0 {
        return Err(("a mirror".to_owned(), EXPECTED));
    }
    let rotation =
        DQuat::from_mat3(&DMat3::from_cols(x.normalize(), y.normalize(), z.normalize())).normalize();
    Ok(Plant { species, position_m, rotation: canonical(rotation), scale })
}

/// The rotation of a model that was made of the mesh by turning its +Z up: that turn is undone first.
pub(super) fn with_z_up(rotation: [f64; 4]) -> [f64; 4] {
    let undone = DQuat::from_xyzw(FRAC_1_SQRT_2, 0.0, 0.0, FRAC_1_SQRT_2);
    canonical((DQuat::from_array(rotation) * undone).normalize())
}

/// Of the two quaternions of a rotation the one whose w is not negative.
fn canonical(rotation: DQuat) -> [f64; 4] {
    let rotation = if rotation.w < 0.0 { -rotation } else { rotation };
    rotation.to_array().map(|x| x + 0.0)
}
