//! What the Monte Carlo reference refuses, and why.

use flb_format::progress::Cancelled;
use thiserror::Error;

/// Input that no light can be traced in.
#[derive(Debug, Clone, PartialEq, Error)]
#[non_exhaustive]
pub enum MonteCarloError {
    /// A lattice that no format allows.
    #[error("lattice of {found} sites per edge: expected 1 to {limit}")]
    Lattice {
        /// Sites per edge.
        found: u32,
        /// Largest number.
        limit: u32,
    },
    /// Sites without size.
    #[error("spacing of {found} m: expected a finite number above 0")]
    Spacing {
        /// Edge of a site, metres.
        found: f64,
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
    /// Extinction that is no rate of loss.
    #[error("site {site:?}: {array} is {found}, expected a finite number from 0")]
    Extinction {
        /// x, y, z.
        site: [u32; 3],
        /// Name of the array.
        array: &'static str,
        /// The value, m^-1.
        found: f32,
    },
    /// Medium without matter.
    #[error("medium of {sites} sites: found none that holds matter, expected at least one")]
    Empty {
        /// Number of sites, N^3.
        sites: usize,
    },
    /// Matter that gives back more than it meets, or less than nothing.
    #[error("{matter}: albedo {found}, expected 0 to 1")]
    Albedo {
        /// Leaf or wood.
        matter: &'static str,
        /// The albedo.
        found: f64,
    },
    /// Albedos that are not one pair for each site.
    #[error("albedos of {found} sites, expected those of the {expected} sites that hold matter")]
    SiteAlbedos {
        /// Pairs that were given.
        found: usize,
        /// Sites that hold matter.
        expected: usize,
    },
    /// Phase function outside of its range.
    #[error("{matter}: {parameter} = {found}, expected {expected}")]
    Phase {
        /// Leaf or wood.
        matter: &'static str,
        /// g or transmitted.
        parameter: &'static str,
        /// Value of the parameter.
        found: f64,
        /// Range of the parameter, in words.
        expected: &'static str,
    },
    /// Direction that is no unit vector.
    #[error("direction towards the sun {found:?}: its length is {length}, expected a unit vector")]
    Direction {
        /// x, y, z.
        found: [f64; 3],
        /// Length of the vector.
        length: f64,
    },
    /// Number of photons that allows no work.
    #[error("photons is 0: expected at least 1")]
    Photons,
    /// Number of rays that is 0, or above what memory has counters for.
    #[error("{found} rays per edge of a site: expected 1 to {limit}")]
    Rays {
        /// Number of rays.
        found: u32,
        /// Largest number.
        limit: u32,
    },
    /// Light that does not find its way out.
    #[error(
        "a photon was scattered {limit} times and still flies: the medium is too dense to trace at this albedo (the densest site has an optical depth of {depth:.3e} along its edge)"
    )]
    Trapped {
        /// Largest number of collisions of a photon.
        limit: u32,
        /// Optical depth along the edge of the densest site.
        depth: f64,
    },
    /// Fields that are not of the same sites.
    #[error("{field}: found {found} sites, expected {expected}")]
    Fields {
        /// Name of the field.
        field: &'static str,
        /// Length of the field.
        found: usize,
        /// The length of the others.
        expected: usize,
    },
    /// A field that cannot be compared.
    #[error("{field}, site {site} of the non-empty ones: found {found}, expected a finite number")]
    Value {
        /// Name of the field.
        field: &'static str,
        /// Index among the non-empty sites.
        site: usize,
        /// The value.
        found: f64,
    },
    /// Reference without light.
    #[error("the reference has a mean of {found} over its sites: expected more than 0")]
    Dark {
        /// The mean.
        found: f64,
    },
    /// The caller stopped the work.
    #[error(transparent)]
    Cancelled(#[from] Cancelled),
}
