//! What `bake` and `pack` say at the end about each species and each stage.

use flb_format::records::KIND_BASE;
use flb_packer::EncodedSpecies;
use serde::Serialize;

use crate::print;
use crate::stages::Stage;

/// One species in the summary of `bake` and `pack`.
#[derive(Serialize)]
pub struct SpeciesSummary {
    pub name: String,
    pub triangles: u64,
    pub leaf_triangles: u64,
    pub wood_triangles: u64,
    pub lattice: u32,
    pub sites_nonempty: u64,
    pub bases: Vec<u32>,
    /// All pages of the species as stored.
    pub bytes: u64,
    /// Bytes of the bases as plain 32-bit floats over the bytes that their pages take in the file.
    pub ratio: f64,
    /// Error of trilinear samples inside non-empty sites, each base relative to its own peak, all bases
    /// pooled; null where no sample has an error.
    pub surface_psnr_db: Option<f64>,
}
