//! Light that has met nothing yet: its mean over each site, integrated along parallel rays.
//!
//! A site may have an optical depth of 5 by itself, so the value at its centre says little about its mean. Along a ray
//! the mean in a site is exact, T (1 - e^-s) / s; across, rays lie on a regular grid over the sites' faces.

use std::f64::consts::PI;

use glam::DVec3;

use super::sites::Sites;
use super::{MonteCarloError, check, in_order};
use crate::turbid::{LeafAngles, TurbidMedium};

/// Parts of the work that are summed one after another.
const PARTS: usize = 16;

/// Directions that stand for the whole sky.
const SKY_DIRECTIONS: usize = 512;

/// Mean over the volume of each non-empty site (in the order of [`TurbidMedium::sites`]) of exp(-optical depth towards
/// the sun): the fluence of a unit beam before its first collision. `toward_sun` is a unit vector in model space.
/// `rays_per_site_edge` squared rays go through each site's face; 8 leave about 0.1 %.
pub fn uncollided(
    medium: &TurbidMedium,
    toward_sun: [f64; 3],
    rays_per_site_edge: u32,
) -> Result<Vec<f64>, MonteCarloError> {
    check::medium(medium)?;
    check::rays(rays_per_site_edge)?;
    let direction = -DVec3::from_array(check::direction(toward_sun)?);
    let sites = Sites::new(medium, [false; 3]);
    let beam = Beam::new(&sites, direction, medium.angles.relative(direction.y), rays_per_site_edge);
    let rows = beam.rows[0].end - beam.rows[0].start;
    let bound = |part: usize| beam.rows[0].start + rows * part as i64 / PARTS as i64;
    means(&sites, PARTS, |part, sums| beam.add(bound(part)..bound(part + 1), sums))
}

/// Returns the uncollided light from everywhere, below the plant too, of fluence 1 in empty space: the mean of
/// [`uncollided`] over 512 directions spread evenly (a Fibonacci lattice), each with a quarter of the rays per edge.
pub fn uncollided_sky(medium: &TurbidMedium, rays_per_site_edge: u32) -> Result<Vec<f64>, MonteCarloError> {
    check::medium(medium)?;
    check::rays(rays_per_site_edge)?;
    let sites = Sites::new(medium, [false; 3]);
    sky(&sites, &medium.angles, rays_per_site_edge.div_ceil(4))
}

fn sky(sites: &Sites, angles: &LeafAngles, rays: u32) -> Result<Vec<f64>, MonteCarloError> {
    let add = |part: usize, sums: &mut [[f64; 2]]| {
        for i in (part..SKY_DIRECTIONS).step_by(PARTS) {
            let direction = fibonacci(i, SKY_DIRECTIONS);
            let beam = Beam::new(sites, direction, angles.relative(direction.y), rays);
            beam.add(beam.rows[0].clone(), sums);
        }
    };
    means(sites, PARTS, add)
}

/// Direction `i` of `count` that cover the sphere evenly (Gonzalez, 2010).
fn fibonacci(i: usize, count: usize) -> DVec3 {
    let up = 1.0 - (2 * i + 1) as f64 / count as f64;
    let level = (1.0 - up * up).sqrt();
    let turn = PI * (3.0 - 5.0f64.sqrt()) * i as f64;
    DVec3::new(level * libm::cos(turn), up, level * libm::sin(turn))
}

/// `add` sums light times length, and length, per site; the quotient is the mean.
fn means(
    sites: &Sites,
    parts: usize,
    add: impl Fn(usize, &mut [[f64; 2]]) + Sync,
) -> Result<Vec<f64>, MonteCarloError> {
    let mut sums = vec![[0.0; 2]; sites.matter.len()];
    let run = |part| {
        let mut sums = vec![[0.0; 2]; sites.matter.len()];
        add(part, &mut sums);
        Ok(sums)
    };
    in_order(parts, &|_| Ok(()), run, |part: Vec<[f64; 2]>| {
        for (sum, part) in sums.iter_mut().zip(part) {
            *sum = [sum[0] + part[0], sum[1] + part[1]];
        }
    })?;
    Ok(sums.into_iter().map(|[light, length]| light / length).collect())
}

/// Parallel rays on a regular grid in the plane of the side that faces the light most: whatever their slope, they cross
/// every layer of sites on the same grid, only shifted, so each site has its full share of rays.
struct Beam<'a> {
    sites: &'a Sites,
    direction: DVec3,
    /// Extinction by leaves along the direction, relative to its mean over all.
    relative: f64,
    /// Rays per edge of a site.
    rays: f64,
    /// The axis nearest to the direction, and the two others.
    axes: [usize; 3],
    /// Numbers of the rays along the two other axes.
    rows: [std::ops::Range<i64>; 2],
}

impl Beam<'_> {
    fn new(sites: &Sites, direction: DVec3, relative: f64, rays: u32) -> Beam<'_> {
        let along = (0..3).fold(0, |best, axis| match direction[axis].abs() > direction[best].abs() {
            true => axis,
            false => best,
        });
        let axes = [along, (along + 1) % 3, (along + 2) % 3];
        let rays = f64::from(rays);
        let depth = f64::from(sites.size[along]);
        let rows = std::array::from_fn(|i| {
            // A ray moves this far sideways while it crosses the box.
            let shift = direction[axes[i + 1]] / direction[along].abs() * depth;
            let size = f64::from(sites.size[axes[i + 1]]);
            ((-shift.max(0.0)) * rays).floor() as i64..((size - shift.min(0.0)) * rays).ceil() as i64
        });
        Beam { sites, direction, relative, rays, axes, rows }
    }

    /// Adds the rays of some rows: light times length, and length.
    fn add(&self, rows: std::ops::Range<i64>, sums: &mut [[f64; 2]]) {
        let [along, across, aside] = self.axes;
        // The grid is closer, seen along the direction, the steeper the direction is to the plane.
        let share = self.direction[along].abs() / (self.rays * self.rays);
        let mut at = DVec3::ZERO;
        at[along] = if self.direction[along] > 0.0 { 0.0 } else { f64::from(self.sites.size[along]) };
        for row in rows {
            at[across] = (row as f64 + 0.5) / self.rays;
            for ray in self.rows[1].clone() {
                at[aside] = (ray as f64 + 0.5) / self.rays;
                let Some(entry) = self.sites.entry(at, self.direction) else { continue };
                let mut light = share;
                self.sites.march(entry, self.direction, |slot, _, length| {
                    let [leaf, wood] = self.sites.matter[slot as usize];
                    let depth = (leaf * self.relative + wood) * length;
                    let lost = -libm::expm1(-depth);
                    let mean = if depth > 1e-9 { lost / depth } else { 1.0 };
                    let sum = &mut sums[slot as usize];
                    *sum = [sum[0] + light * mean * length, sum[1] + share * length];
                    light *= 1.0 - lost;
                    None
                });
            }
        }
    }
}
