//! What a solve refuses, and why.

use flb_format::matter::Class;
use flb_format::progress::Cancelled;
use thiserror::Error;

use super::SolverKind;
use crate::gpu::GpuError;

/// Input that cannot be solved.
#[derive(Debug, Clone, PartialEq, Error)]
#[non_exhaustive]
pub enum SolveError {
    /// The lattice's edge is not one of the sizes of the format.
    #[error("lattice of {found} sites per edge: expected a power of two, 16 to 256")]
    Lattice {
        /// Sites per edge.
        found: u32,
    },
    /// An array of the medium does not fit its grid.
    #[error("medium's {array}: found {found} values, expected {expected} for a lattice of {lattice}")]
    Length {
        /// Name of the array.
        array: &'static str,
        /// Length of the array.
        found: usize,
        /// Number of sites, N^3.
        expected: usize,
        /// Sites per edge, N.
        lattice: u32,
    },
    /// A density that is no share of a whole.
    #[error("site {site:?}: density {found}, expected 0 to 1")]
    Density {
        /// x, y, z.
        site: [u32; 3],
        /// The density.
        found: f32,
    },
    /// Density and class contradict each other.
    #[error(
        "site {site:?}: class {class:?} with density {density}; a site is empty exactly where its density is 0"
    )]
    Class {
        /// x, y, z.
        site: [u32; 3],
        /// The class.
        class: Class,
        /// The density.
        density: f32,
    },
    /// Matter at the boundary or next to it.
    #[error(
        "site {site:?}: density {density} in the outer two layers of a lattice of {lattice}; they must be empty: the outermost holds the boundary light, and one empty site lies between it and the plant"
    )]
    Border {
        /// x, y, z.
        site: [u32; 3],
        /// The density.
        density: f32,
        /// Sites per edge, N.
        lattice: u32,
    },
    /// Too few or too many bands.
    #[error("{found} bands: expected 1 to {limit}")]
    Bands {
        /// Number of bands.
        found: usize,
        /// Largest number.
        limit: usize,
    },
    /// The operator would take more light than there is, or give negative light.
    #[error(
        "band {band} ({name}), {class:?}: sigma_a = {found}, expected 0 to 1; beyond that sigma_s = 1 - sigma_a or the share of light that goes straight on turns negative, and so does the light"
    )]
    Absorption {
        /// Index of the band.
        band: usize,
        /// Name of the band.
        name: String,
        /// Leaf or wood.
        class: Class,
        /// Value of sigma_a.
        found: f64,
    },
    /// Asymmetry outside of the Henyey-Greenstein function's range.
    #[error("band {band} ({name}), {class:?}: g = {found}, expected -1 to 1")]
    Asymmetry {
        /// Index of the band.
        band: usize,
        /// Name of the band.
        name: String,
        /// Leaf or wood.
        class: Class,
        /// Value of g.
        found: f64,
    },
    /// A tolerance that can never or always be met.
    #[error("tolerance {found}: expected more than 0 and less than 1")]
    Tolerance {
        /// The tolerance.
        found: f64,
    },
    /// Limit of sweeps that allows no work.
    #[error("max_sweeps is 0: expected at least 1")]
    MaxSweeps,
    /// Fixed number of iterations that is none.
    #[error("0 steps: expected at least 1")]
    NoSteps,
    /// Fixed number of iterations for a solver that does no iterations of the papers.
    #[error(
        "steps for the solver {solver:?}, which goes until the tolerance is met: expected Explicit or Literal"
    )]
    Steps {
        /// The solver.
        solver: SolverKind,
    },
    /// Empty set of bases.
    #[error("no bases to solve: expected at least one of 0 to 18")]
    NoBases,
    /// The solver on the GPU cannot do it.
    #[error(transparent)]
    Gpu(#[from] GpuError),
    /// The caller stopped the work.
    #[error(transparent)]
    Cancelled(#[from] Cancelled),
}
