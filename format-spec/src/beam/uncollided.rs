//! Light of a sun that no site has scattered yet: the mean of exp(-optical depth) over each site.

use crate::turbid::Turbid;

use super::tracks::{Sites, Step};

/// Uncollided fluence of one sun within each non-empty site.
#[derive(Debug, Clone, PartialEq)]
pub struct Beam {
    /// Unit vector towards the sun, model space.
    pub towards_sun: [f64; 3],
    /// Mean over the site: 1 where nothing is in the way.
    pub mean: Vec<f32>,
    /// Slope of the straight fit over the site, per site edge along x, y, z.
    pub slope: Vec<[f32; 3]>,
}

/// The beam of a sun that stands along `towards_sun` (a unit vector); `rays` per site edge are marched. Along a ray the
/// means are exact.
pub fn uncollided(medium: &Turbid, places: &Sites, sites: &[u32], towards_sun: [f64; 3], rays: u32) -> Beam {
    let depth = depth_per_edge(medium, sites, towards_sun);
    let travel = towards_sun.map(|c| -c as f32);
    // Sums over the crossings: length, light, light x offset from the site's centre.
    let mut sums = vec![[0.0_f32; 5]; sites.len()];
    let mut light = 1.0_f32;
    places.walk(towards_sun.map(|c| -c), rays, |step| match step {
        Step::Cross { place, length, middle } => {
            let length = length as f32;
            let passing = Passing::new(depth[place as usize] * length);
            let [lengths, mean, offset @ ..] = &mut sums[place as usize];
            *lengths += length;
            *mean += light * passing.mean * length;
            for axis in 0..3 {
                let along = passing.lean * length * travel[axis];
                offset[axis] += light * length * (passing.mean * middle[axis] as f32 + along);
            }
            light *= passing.transmittance;
        }
        Step::End => light = 1.0,
    });
    // Over a unit cube, offsets have a variance of 1/12 along each axis. Every site is crossed in its middle layer.
    let slope_of = |[length, _, offset @ ..]: &[f32; 5]| offset.map(|sum| 12.0 * sum / length);
    let mean_of = |[length, mean, ..]: &[f32; 5]| mean / length;
    Beam { towards_sun, mean: sums.iter().map(mean_of).collect(), slope: sums.iter().map(slope_of).collect() }
}

/// Optical depth of an edge of each non-empty site, for light along a unit direction or back.
pub fn depth_per_edge(medium: &Turbid, sites: &[u32], direction: [f64; 3]) -> Vec<f32> {
    let along =
        |&site: &u32| (medium.extinction_along(site as usize, direction[1]) * medium.grid.spacing_m) as f32;
    sites.iter().map(along).collect()
}

/// Moments of exp(-s t), the transmittance along a way, for t from 0 to 1.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Passing {
    /// Transmittance of the whole way, exp(-s).
    pub transmittance: f32,
    /// Mean transmittance along the way, (1 - exp(-s)) / s.
    pub mean: f32,
    /// The mean of (t - 1/2) exp(-s t), at most 0.
    pub lean: f32,
}

impl Passing {
    /// Computes the moments for an optical depth s of the whole way.
    pub fn new(s: f32) -> Passing {
        let gone = -libm::expm1f(-s);
        let transmittance = 1.0 - gone;
        // Series where the closed forms cancel: the next terms are below 1e-7 of the first.
        if s < 0.02 {
            let mean = 1.0 - s * (0.5 - s / 6.0);
            return Passing { transmittance, mean, lean: -s / 12.0 * (1.0 - s * (0.5 - s * 0.15)) };
        }
        let mean = gone / s;
        Passing { transmittance, mean, lean: (mean - transmittance) / s - 0.5 * mean }
    }
}
