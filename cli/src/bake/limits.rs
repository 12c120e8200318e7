//! Limits of flags that the bakes of a plant and of a scene share.

use flb_transport::ordinates::Ordinates;

use crate::exit::{Failure, USAGE};

/// Refuses a lattice that no format has.
pub(crate) fn check_lattice(lattice: u32) -> Result<(), Failure> {
    match lattice.is_power_of_two() && (16..=256).contains(&lattice) {
        true => Ok(()),
        false => {
            let message = format!("--lattice is {lattice}, expected a power of two, 16 to 256");
            Err(Failure::new(USAGE, message))
        }
    }
}

/// The directions of `--ordinates`.
pub(crate) fn ordinates_of(count: u32) -> Result<Ordinates, Failure> {
    let refuse = || Failure::new(USAGE, format!("--ordinates is {count}, expected 18, 50 or 110"));
    Ordinates::of_count(count).ok_or_else(refuse)
}

/// Refuses a solve that would never end, or never begin.
pub(crate) fn check_end(tolerance: f64, max_sweeps: u32) -> Result<(), Failure> {
    let refuse = |message: String| Err(Failure::new(USAGE, message));
    if !(tolerance > 0.0 && tolerance < 1.0) {
        return refuse(format!("--tolerance is {tolerance}, expected a number between 0 and 1"));
    }
    if max_sweeps == 0 {
        return refuse("--max-sweeps is 0, expected 1 or more".to_owned());
    }
    Ok(())
}
