//! Flags of `flb bake` that choose the light transport model.

use clap::{Args, ValueEnum};

/// Which model, and how it stores light.
#[derive(Args, Clone)]
pub struct ModelArgs {
    /// Light transport model
    #[arg(long, value_enum, default_value_t = ModelArg::Paper)]
    pub model: ModelArg,
    /// How the stored light depends on the sun; `physical` only [default: sh2]
    #[arg(long, value_enum)]
    pub suns: Option<SunsArg>,
    /// Directions that light is marched along: 18, 50 or 110; `physical` only [default: 110]
    #[arg(long, value_name = "N")]
    pub ordinates: Option<u32>,
    /// Rays per site edge that are marched along each direction, 1 to 8; `physical` only [default: 1]
    #[arg(long, value_name = "N")]
    pub rays: Option<u32>,
    /// March through sites cut into 2x2x2 parts: for dense plants; 8 times the memory; `physical` only
    #[arg(long)]
    pub cut_sites: bool,
    /// What a field of the sun's light holds; `physical` only [default: scattered]
    #[arg(long, value_enum)]
    pub field: Option<FieldArg>,
    /// How leaves are inclined; `physical` only [default: measured]
    #[arg(long, value_enum)]
    pub leaf_angles: Option<LeafAnglesArg>,
}

#[derive(Clone, Copy, PartialEq, Eq, ValueEnum)]
pub enum ModelArg {
    /// The papers' lattice-Boltzmann model, exactly
    Paper,
    /// Extinction measured on the mesh, surfaces from data, directions marched through the plant
    Physical,
}

#[derive(Clone, Copy, PartialEq, Eq, ValueEnum)]
pub enum SunsArg {
    /// A field for each of 18 directions, blended by three
    Lattice18,
    /// 4 harmonics of the sun's direction and the near beam: 9 fields
    Sh1,
    /// 9 harmonics and the near beam: 14 fields
    Sh2,
    /// 16 harmonics and the near beam: 21 fields
    Sh3,
}

#[derive(Clone, Copy, PartialEq, Eq, ValueEnum)]
pub enum FieldArg {
    /// Light that was scattered at least once; renderers add the sun's beam by shadow rays
    Scattered,
    /// The sun's beam as well
    Total,
}

#[derive(Clone, Copy, PartialEq, Eq, ValueEnum)]
pub enum LeafAnglesArg {
    /// As the mesh's leaves are
    Measured,
    /// At random
    Spherical,
    /// Mostly flat
    Planophile,
    /// Mostly upright
    Erectophile,
}

impl ModelArgs {
    /// The first flag that only the `physical` model has.
    pub fn physical_flag(&self) -> Option<&'static str> {
        let flags = [
            ("--suns", self.suns.is_some()),
            ("--ordinates", self.ordinates.is_some()),
            ("--rays", self.rays.is_some()),
            ("--cut-sites", self.cut_sites),
            ("--field", self.field.is_some()),
            ("--leaf-angles", self.leaf_angles.is_some()),
        ];
        flags.into_iter().find(|(_, given)| *given).map(|(flag, _)| flag)
    }
}
