//! A sky as a few directions: what light is found for, where it is found by direction.
//!
//! The sphere is cut into rows of even height in angle, and each row into cells about as wide as high. A cell's
//! direction is the middle of its light, so that a small bright part keeps its place.

use std::f64::consts::PI;

use flb_format::sky_part::SkyPart;
use glam::DVec3;

use super::{Sky, luminance};

/// Rows from the zenith to the nadir; an even number, so that no cell lies across the horizon.
const ROWS: usize = 12;

/// Sums over a cell.
#[derive(Clone, Copy, Default)]
struct Cell {
    solid_angle: f64,
    light: [f64; 3],
    /// Directions, by light and by solid angle.
    middles: [DVec3; 2],
}

/// Divides a sky into 184 parts, in the order of rows.
pub fn patches(sky: &Sky) -> Vec<SkyPart> {
    let row_height = PI / ROWS as f64;
    let columns: Vec<usize> = (0..ROWS)
        .map(|row| {
            let around = 2.0 * PI * libm::cos(PI / 2.0 - (row as f64 + 0.5) * row_height);
            (libm::round(around / row_height) as usize).max(3)
        })
        .collect();
    let firsts: Vec<usize> = (0..ROWS).map(|row| columns[..row].iter().sum()).collect();
    let mut cells = vec![Cell::default(); columns.iter().sum()];
    let [rows, around] = sky.steps();
    let turn = 2.0 * PI / around as f64;
    let turns: Vec<(f64, f64)> = (0..around).map(|step| libm::sincos((step as f64 + 0.5) * turn)).collect();
    for row in 0..rows {
        let angle = |part: f64| (row as f64 + part) * PI / rows as f64;
        let solid_angle = turn * (libm::cos(angle(0.0)) - libm::cos(angle(1.0)));
        let (level, up) = libm::sincos(angle(0.5));
        let of_row = (row * ROWS / rows).min(ROWS - 1);
        for (step, (sin, cos)) in turns.iter().enumerate() {
            // Columns run from the south over the west to the north, which is the middle, as in images.
            let towards = DVec3::new(-level * sin, up, level * cos);
            let cell = &mut cells[firsts[of_row] + step * columns[of_row] / around];
            let light = sky.radiance(towards.as_vec3().to_array());
            cell.solid_angle += solid_angle;
            (0..3).for_each(|band| cell.light[band] += f64::from(light[band]) * solid_angle);
            cell.middles[0] += towards * (f64::from(luminance(light)) * solid_angle);
            cell.middles[1] += towards * solid_angle;
        }
    }
    let patch = |cell: &Cell| SkyPart {
        towards: cell.middles[0].normalize_or(cell.middles[1].normalize_or(DVec3::Y)).to_array(),
        solid_angle: cell.solid_angle,
        fluence: cell.light.map(|light| light as f32),
    };
    cells.iter().map(patch).collect()
}
