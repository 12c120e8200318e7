//! Flags of `flb bake` that choose the light transport model.

use clap::{Args, ValueEnum};
use flb_baker::crown::LeafAngleChoice;
use flb_format::light::FieldKind;
use flb_transport::monte_carlo::judge::MAX_SUNS;
use flb_transport::ordinates::NamedSuns;

/// Which model, and how it stores light.
#[derive(Args, Clone)]
pub(crate) struct ModelArgs {
    /// Light transport model [default: physical; paper with --quality papers]
    #[arg(long, value_enum)]
    pub model: Option<ModelArg>,
    /// How the stored light depends on the sun; `physical` only [default: the preset's; lattice18 where walls enclose
    /// leaves]
    #[arg(long, value_enum)]
    pub suns: Option<NamedSuns>,
    /// Directions that light is marched along: 18, 50 or 110; `physical` only [default: the preset's]
    #[arg(long, value_name = "N")]
    pub ordinates: Option<u32>,
    /// Rays per site edge that are marched along each direction, 1 to 8; `physical` only [default: 4 at lattice 32, 2
    /// at 64, 1 from 128 on; cut sites count as the finer lattice]
    #[arg(long, value_name = "N")]
    pub rays: Option<u32>,
    /// March through sites cut into 2x2x2 parts: for dense plants; 8 times the memory; `physical` only [default: the
    /// preset's]
    #[arg(long, value_name = "true|false", num_args = 0..=1, require_equals = true, default_missing_value = "true")]
    pub cut_sites: Option<bool>,
    /// What a field of the sun's light holds; `physical` only [default: scattered]
    #[arg(long, value_enum)]
    pub field: Option<FieldKind>,
    /// How leaves are inclined; `physical` only [default: measured]
    #[arg(long, value_enum)]
    pub leaf_angles: Option<LeafAngleChoice>,
    /// Trace this many suns (0 to 22) by Monte Carlo in the same medium, each with two seeds, print how far the light
    /// is off, and keep it in the file, for `flb info`; `physical` only
    #[arg(long, value_name = "SUNS", default_value_t = 0, value_parser = clap::value_parser!(u8).range(0..=MAX_SUNS as i64))]
    pub monte_carlo: u8,
}

#[derive(Clone, Copy, PartialEq, Eq, ValueEnum)]
pub(crate) enum ModelArg {
    /// Extinction measured on the mesh, surfaces from data, directions marched through the plant
    Physical,
    /// The lattice-Boltzmann model of Steele and Geist (2009), with the points that it leaves open settled as
    /// docs/lighting-model.md says
    Paper,
}
