//! One bake, measured: a row of every table.

use flb_format::Codec;
use serde::Serialize;

use super::choice::{Solve, Store, presets_of};
use super::on_mesh::MeshRow;
use super::truth::TruthError;

/// A solve with a coding, what it cost and how far off it is. Fields that a model does not have are null.
#[derive(Debug, Clone, PartialEq, Serialize)]
pub struct Row {
    /// Number of the row, from 1; 1 is the finest, with which all others are compared.
    pub row: usize,
    /// Name of the choice, in short.
    pub choice: String,
    /// Presets of `flb bake` that are just this.
    pub presets: Vec<&'static str>,
    /// Light transport model.
    pub model: &'static str,
    /// Sites along each edge.
    pub lattice: u32,
    /// Name of the basis of the sun's direction.
    pub suns: Option<String>,
    /// Number of directions that light is marched along.
    pub ordinates: Option<u32>,
    /// Rays per site edge.
    pub rays: Option<u32>,
    /// Parts of a site along each edge.
    pub parts: Option<u32>,
    /// Light that a field holds: scattered or total.
    pub field: &'static str,
    /// Change of light at which the solve ends.
    pub tolerance: f64,
    /// Name of the codec.
    pub codec: &'static str,
    /// Threshold of `haar-paper`.
    pub threshold: Option<f32>,
    /// PSNR that is coded to, in dB.
    pub psnr_db: Option<f64>,
    /// Non-empty sites of the medium.
    pub sites: u64,
    /// Time from import to write, as a bake alone takes.
    pub seconds: f64,
    /// Largest heap in use.
    pub peak_bytes: u64,
    /// Memory that was predicted, bytes, with the light sampled from the file.
    pub predicted_bytes: u64,
    /// Length of the file.
    pub bytes: u64,
    /// Number of stored fields.
    pub fields: usize,
    /// Whether every solve met its tolerance.
    pub converged: bool,
    /// Error of the light on the mesh.
    pub mesh: Option<MeshRow>,
    /// Reason why there is no error on the mesh.
    pub mesh_missing: Option<String>,
    /// Rms distance of the light at the plant's surface from that of row 1, % of its mean total fluence.
    pub finest_percent: f64,
    /// Rms distance from the finest row of the model `paper`, % of its mean light; `None` of another model, and where
    /// that was not tried.
    pub paper_percent: Option<f64>,
    /// The band that is furthest off in its own mean total fluence, and how far.
    pub worst_band: String,
    /// Distance of the worst band, in % of its own mean total fluence.
    pub worst_band_percent: f64,
    /// Error against Monte Carlo in the medium.
    pub monte_carlo: Option<TruthError>,
    /// Reason why there is no error against Monte Carlo.
    pub monte_carlo_missing: Option<String>,
    /// Whether no other row is as good or better in seconds, memory, bytes and distance, and better in one of them; in
    /// steps of 10 %.
    pub pareto: bool,
    /// Flags of `flb bake` that make it.
    pub flags: String,
}

impl Row {
    /// What is known of a row before it is measured.
    pub(super) fn new(solve: &Solve, store: &Store) -> Row {
        let transport = &solve.transport;
        let marched = transport.marched();
        let threshold = (store.codec == Codec::HaarPaper).then_some(store.threshold);
        let psnr_db = store.codec.is_near_geometry().then_some(store.psnr_db);
        let flags = format!("{} {}", solve.flags(), store.flags());
        Row {
            row: 0,
            choice: format!("{solve} {store}"),
            presets: presets_of(solve, store),
            model: transport.name(),
            lattice: solve.lattice,
            suns: marched.map(|one| one.suns.name().to_owned()),
            ordinates: marched.map(|one| one.ordinates.count()),
            rays: marched.map(|one| one.rays),
            parts: marched.map(|one| one.parts),
            field: transport.field().name(),
            tolerance: transport.tolerance(),
            codec: store.codec.name(),
            threshold,
            psnr_db,
            sites: 0,
            seconds: 0.0,
            peak_bytes: 0,
            predicted_bytes: 0,
            bytes: 0,
            fields: 0,
            converged: false,
            mesh: None,
            mesh_missing: None,
            finest_percent: 0.0,
            paper_percent: None,
            worst_band: String::new(),
            worst_band_percent: 0.0,
            monte_carlo: None,
            monte_carlo_missing: None,
            pareto: false,
            flags,
        }
    }

    /// What is weighed: seconds, memory, bytes, distance from the finest. Less is better.
    pub(crate) fn weighed(&self) -> [f64; 4] {
        [self.seconds, self.peak_bytes as f64, self.bytes as f64, self.finest_percent]
    }

    /// Seconds, megabytes of memory and megabytes of file in one number: their geometric mean.
    pub fn cost(&self) -> f64 {
        // Where the heap is not counted, memory is the same for all.
        let memory = if self.peak_bytes == 0 { 1.0 } else { self.peak_bytes as f64 / 1e6 };
        libm::cbrt(self.seconds * memory * (self.bytes as f64 / 1e6))
    }
}
