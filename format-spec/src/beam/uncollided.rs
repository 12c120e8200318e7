//! Light of a sun that no site has scattered yet: the mean of exp(-optical depth) over each site.

use pulp::{Arch, NullaryFnOnce};

use crate::turbid::TurbidMedium;

use super::passing::{LANES, Passings, sum};
use super::sites::Sites;
use super::sweep::{Span, Sweep, Way};

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
pub fn uncollided(
    medium: &TurbidMedium,
    places: &Sites,
    sites: &[u32],
    towards_sun: [f64; 3],
    rays: u32,
) -> Beam {
    let depth = depth_per_edge(medium, sites, towards_sun);
    let mut beam = Beam { towards_sun, mean: vec![0.0; sites.len()], slope: vec![[0.0; 3]; sites.len()] };
    let travel = towards_sun.map(|c| -c);
    let Some(sweep) = Sweep::new(places, travel, rays) else { return beam };
    let [rows, columns] = sweep.picture();
    // Light of each ray where it is.
    let mut light = vec![1.0_f32; rows * columns];
    let axes = sweep.axes;
    let travel = axes.map(|axis| travel[axis] as f32);
    let (way, arch) = (sweep.way(), Arch::new());
    sweep.visit(|place, across, along| {
        let depth = depth[place as usize];
        let [length, mean, offsets @ ..] =
            arch.dispatch(SiteJob { depth, across, along, way, travel, light: &mut light, columns });
        beam.mean[place as usize] = mean / length;
        // Over a unit cube, offsets have a variance of 1/12 along each axis. Every site is crossed in its middle layer.
        for (axis, offset) in axes.into_iter().zip(offsets) {
            beam.slope[place as usize][axis] = 12.0 * offset / length;
        }
    });
    beam
}

/// All rays that cross a site, compiled for the SIMD of this machine. Gives sums over the crossings: length, light,
/// light x offset from the site's centre along the axes of the sweep.
struct SiteJob<'a> {
    /// Optical depth per site edge.
    depth: f32,
    across: &'a Span,
    along: &'a Span,
    way: Way,
    /// Direction of travel along the axes of the sweep.
    travel: [f32; 3],
    /// Light of each ray, row after row.
    light: &'a mut [f32],
    columns: usize,
}

impl NullaryFnOnce for SiteJob<'_> {
    type Output = [f32; 5];

    #[inline(always)]
    fn call(self) -> [f32; 5] {
        let SiteJob { depth, across, along, way, travel, light, columns } = self;
        let mut sums = [[0.0_f32; LANES]; 5];
        for (row, [enter, leave, start]) in across.rays() {
            let rays = &mut light[row * columns + along.first..][..along.enter.len()];
            let rays = rays.as_chunks_mut::<LANES>().0.iter_mut();
            let enters = along.enter.as_chunks::<LANES>().0;
            let (leaves, starts) = (along.leave.as_chunks::<LANES>().0, along.start.as_chunks::<LANES>().0);
            for (((rays, enters), leaves), starts) in rays.zip(enters).zip(leaves).zip(starts) {
                let mut lengths = [0.0; LANES];
                let mut offsets = [[0.0; LANES]; 3];
                for lane in 0..LANES {
                    let from = if enters[lane] > enter { enters[lane] } else { enter };
                    let to = if leaves[lane] < leave { leaves[lane] } else { leave };
                    lengths[lane] = way.length(from, to);
                    [offsets[0][lane], offsets[1][lane], offsets[2][lane]] =
                        way.middle(from, to, [start, starts[lane]]);
                }
                let passings = Passings::new(lengths.map(|length| depth * length));
                for lane in 0..LANES {
                    let length = lengths[lane];
                    let (mean, lean) = (passings.mean[lane], passings.lean[lane] * length);
                    let lit = rays[lane] * length;
                    sums[0][lane] += length;
                    sums[1][lane] += lit * mean;
                    for i in 0..3 {
                        sums[2 + i][lane] += lit * (mean * offsets[i][lane] + lean * travel[i]);
                    }
                    rays[lane] *= passings.transmittance[lane];
                }
            }
        }
        sums.map(sum)
    }
}

/// Optical depth of an edge of each non-empty site, for light along a unit direction or back.
pub fn depth_per_edge(medium: &TurbidMedium, sites: &[u32], direction: [f64; 3]) -> Vec<f32> {
    let along = |&site: &u32| {
        let depth = medium.extinction_along(site as usize, direction[1]) * medium.grid.spacing_m;
        // Finite, so that it is nothing on no way.
        (depth as f32).min(f32::MAX)
    };
    sites.iter().map(along).collect()
}

#[cfg(test)]
pub(super) mod tests {
    use super::super::walk::uncollided_ray_by_ray;
    use super::*;
    use crate::Grid;
    use crate::turbid::LeafAngles;

    /// Along axes, edges and diagonals of sites, and across them.
    pub(crate) const DIRECTIONS: [[f64; 3]; 13] = [
        [0.0, 1.0, 0.0],
        [0.3, -1.0, -0.4],
        [0.0, 0.0, -1.0],
        [1.0, 0.0, 0.0],
        [0.6, 0.0, -0.8],
        [0.0, -0.6, 0.8],
        [1.0, 1.0, 1.0],
        [-1.0, 1.0, -1.0],
        [0.3, 1.0, 0.1],
        [-1.0, 0.4, 0.7],
        [0.2, -0.5, -0.9],
        [0.9, -0.8, 0.85],
        [1e-13, 1.0, -1e-5],
    ];

    pub(crate) fn unit(direction: [f64; 3]) -> [f64; 3] {
        let length = libm::sqrt(direction.iter().map(|c| c * c).sum());
        direction.map(|c| c / length)
    }

    /// A grid with matter here and there, dense and thin, some of it at the walls.
    pub(crate) fn medium(lattice: u32) -> TurbidMedium {
        let grid = Grid { lattice, spacing_m: 0.5, origin_m: [0.0; 3] };
        let mut state = 1u32;
        let mut random = || {
            state = state.wrapping_mul(1_664_525).wrapping_add(1_013_904_223);
            (state >> 8) as f32 / (1 << 24) as f32
        };
        let density = |_| if random() < 0.2 { 20.0 * random() * random() * random() } else { 0.0 };
        let leaf_per_m: Vec<f32> = (0..grid.sites()).map(density).collect();
        let wood_per_m = vec![0.0; leaf_per_m.len()];
        TurbidMedium { grid, leaf_per_m, wood_per_m, angles: LeafAngles::spherical() }
    }

    /// [`medium`], and one with matter far from the walls, a layer thin.
    pub(crate) fn media() -> [TurbidMedium; 2] {
        let mut small = medium(16);
        for site in 0..small.leaf_per_m.len() {
            let [x, y, z] = small.grid.site(site);
            if !((3..=6).contains(&x) && (9..=14).contains(&y) && z == 5) {
                small.leaf_per_m[site] = 0.0;
            }
        }
        [medium(16), small]
    }

    #[test]
    fn site_by_site_is_ray_by_ray() {
        for medium in media() {
            is_ray_by_ray(&medium);
        }
    }

    fn is_ray_by_ray(medium: &TurbidMedium) {
        let sites = medium.sites();
        let places = Sites::new(&medium.grid, &sites);
        for towards_sun in DIRECTIONS.map(unit) {
            for rays in [1, 2, 4] {
                let found = uncollided(medium, &places, &sites, towards_sun, rays);
                let expected = uncollided_ray_by_ray(medium, &sites, towards_sun, rays);
                for place in 0..sites.len() {
                    let (found_mean, mean) = (found.mean[place], expected.mean[place]);
                    assert!(
                        (found_mean - mean).abs() < 1e-5,
                        "{towards_sun:?}, {rays}: {found_mean}, {mean}"
                    );
                    for axis in 0..3 {
                        let (found, slope) = (found.slope[place][axis], expected.slope[place][axis]);
                        assert!(
                            (found - slope).abs() < 1e-4,
                            "{towards_sun:?}, {rays}, {axis}: {found}, {slope}"
                        );
                    }
                }
            }
        }
    }

    #[test]
    fn no_sites_have_no_beam() {
        let medium = TurbidMedium { leaf_per_m: vec![0.0; 16 * 16 * 16], ..medium(16) };
        let places = Sites::new(&medium.grid, &[]);
        assert!(uncollided(&medium, &places, &[], [0.0, 1.0, 0.0], 4).mean.is_empty());
    }
}
