//! A species by itself on sites as coarse as a scene's.

use flb_format::matter::TurbidMedium;
use flb_format::{Grid, Placement, Transform};

use super::deposit::{BORDER, Sums};
use super::grains::Grain;
use super::{Plant, SceneLightError};

/// The smallest lattice.
const SMALLEST: u32 = 16;
/// The largest.
const LARGEST: u32 = 256;

/// The species' matter on sites of `spacing_m` of its own metres, less open than it is.
pub(super) fn coarse(
    plant: &Plant,
    grains: &[Grain],
    spacing_m: f64,
) -> Result<TurbidMedium, SceneLightError> {
    let grid = grid_around(plant.name, grains, spacing_m)?;
    let mut sums = Sums::new(grid, None);
    sums.add(&AT_HOME, grains, 1.0, [0.0; 2]);
    Ok(sums.finish(plant.turbid.angles.clone(), None).0)
}

/// Where a plant stands that stands nowhere in particular.
const AT_HOME: Placement = Placement {
    species: 0,
    transform: Transform {
        rotation: [[1.0, 0.0, 0.0], [0.0, 1.0, 0.0], [0.0, 0.0, 1.0]],
        position_m: [0.0; 3],
        scale: 1.0,
    },
};

/// A lattice with the plant in its middle.
fn grid_around(species: &str, grains: &[Grain], spacing_m: f64) -> Result<Grid, SceneLightError> {
    let (mut low, mut high) = ([f64::INFINITY; 3], [f64::NEG_INFINITY; 3]);
    for grain in grains {
        for axis in 0..3 {
            low[axis] = low[axis].min(grain.at_m[axis]);
            high[axis] = high[axis].max(grain.at_m[axis]);
        }
    }
    let longest_m = (0..3).map(|axis| high[axis] - low[axis]).fold(0.0, f64::max);
    // A site more on either side holds a part of the outermost grains.
    let needed = libm::ceil(longest_m / spacing_m) + f64::from(2 * (BORDER + 1));
    if needed > f64::from(LARGEST) {
        let found = libm::ceil(longest_m / spacing_m);
        return Err(SceneLightError::TooFine { species: species.to_owned(), found });
    }
    let lattice = (needed as u32).next_power_of_two().max(SMALLEST);
    let origin_m = std::array::from_fn(|axis| {
        f64::midpoint(low[axis], high[axis]) - spacing_m * f64::from(lattice) / 2.0
    });
    Ok(Grid { lattice, origin_m, spacing_m })
}
