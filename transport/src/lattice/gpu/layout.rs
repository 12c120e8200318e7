//! Rust values -> the words of the WGSL structs in types.wgsl, field by field. A test holds names and offsets against
//! what naga reads from the WGSL.

use flb_format::direction::opposite;
use flb_format::matter::BandOptics;

use super::super::collision;
use super::super::kernel::{Gain, LANES};
use super::super::sites::Domain;

/// `Params`.
#[derive(Debug, Clone, Copy)]
pub(super) struct Params {
    pub sites: u32,
    pub lanes: u32,
    pub picks: u32,
    pub slot: u32,
}

impl Params {
    pub(super) fn fields(&self) -> [(&'static str, u32); 4] {
        [("sites", self.sites), ("lanes", self.lanes), ("picks", self.picks), ("slot", self.slot)]
    }
}

/// `Site` of index `site`.
pub(super) fn site_fields(domain: &Domain, site: usize) -> [(&'static str, u32); 3] {
    [
        ("density", domain.rho[site].to_bits()),
        ("wood", u32::from(domain.wood[site])),
        ("echoes", domain.echoes[site]),
    ]
}

/// `Gain` of leaf (class 0) or wood (class 1) in one band.
pub(super) fn gain_fields(band: &BandOptics, class: usize) -> [(&'static str, u32); 16] {
    let matrix = collision::gains(band)[class];
    let split = Gain::new(&[matrix; LANES]).fields(0);
    let back = |m: usize| matrix[m][opposite(m)] as f32;
    let last = [("back_axis", back(1)), ("back_diagonal", back(7))];
    let mut all = split.into_iter().chain(last).map(|(name, value)| (name, value.to_bits()));
    std::array::from_fn(|_| all.next().expect("14 and 2 fields"))
}

/// Words of a struct.
pub(super) fn words<const N: usize>(fields: [(&'static str, u32); N]) -> [u32; N] {
    fields.map(|(_, word)| word)
}
