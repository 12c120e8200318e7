//! What to choose for a plant: bakes it under a grid of choices, measures what each costs and how far it is off, and
//! says which row each preset should be.
//!
//! ```text
//! mesh -survey-> sites per lattice -choices, memory-> choices to try
//!     -measure-> rows -front, recommend-> Trade
//! ```
//!
//! Every solve is baked once, by what `flb_baker::bake` does, the finest first; of each only its rows are kept.

mod choice;
mod front;
mod heap;
mod measure;
mod memory;
mod meter;
mod on_mesh;
mod predict;
mod recommend;
mod row;
mod sample;
mod settings;
mod transport;
mod truth;

use flb_baker::bake::BakeObserver;
use flb_scene::{Plant, Step};
use flb_transport::monte_carlo::judge;
use serde::Serialize;

use crate::{EvalError, judged_points};
use choice::finest;
use front::in_steps;
use measure::{Bench, OfAll, OfLattice};
use predict::{Predict, affordable};

pub use choice::{Choice, FINEST_STORE, Skipped, Solve, Store, choices};
pub use front::front;
pub use heap::{Heap, NoHeap};
pub use memory::available_bytes;
pub use on_mesh::MeshRow;
pub use recommend::Recommended;
pub use row::Row;
pub use sample::MeanFluence;
pub use settings::TradeSettings;
pub use transport::{Marched, Transport};
pub use truth::TruthError;

/// Rows of all choices, and what is recommended.
#[derive(Debug, Clone, PartialEq, Serialize)]
pub struct Trade {
    /// Points of the plant's surface that light was compared at.
    pub points: usize,
    /// Unit vectors towards the suns, model space.
    pub suns: Vec<[f64; 3]>,
    /// Mean fluence of the finest light.
    pub mean_fluence: MeanFluence,
    /// Memory that no choice may need more of.
    pub memory_limit_bytes: u64,
    /// Monte Carlo light of each lattice.
    pub monte_carlo: Vec<Traced>,
    /// Rows, the finest first.
    pub rows: Vec<Row>,
    /// Choices that were not tried.
    pub skipped: Vec<Skipped>,
    /// Row of each preset.
    pub recommended: Vec<Recommended>,
}

/// Monte Carlo light of a lattice.
#[derive(Debug, Clone, PartialEq, Serialize)]
pub struct Traced {
    /// Sites along each edge.
    pub lattice: u32,
    /// Non-empty sites.
    pub sites: u64,
    /// Photons of every sun, band and seed; `None` where nothing was traced.
    pub photons: Option<u64>,
    /// Reason why nothing was traced.
    pub missing: Option<String>,
}

impl Traced {
    fn new(lattice: u32, sites: u64, photons: Result<u64, String>) -> Traced {
        let (photons, missing) = match photons {
            Ok(photons) => (Some(photons), None),
            Err(reason) => (None, Some(reason)),
        };
        Traced { lattice, sites, photons, missing }
    }
}

/// Measures every choice.
///
/// `plants` reads the plant, as before each bake; its time counts. `heap` tells how much memory is in use. The observer
/// is told each choice as a note.
///
/// # Errors
/// Errors of `plants`; [`EvalError`] of a plant that cannot be baked or judged with these settings, and
/// [`EvalError::Memory`].
///
/// # Panics
/// If more suns are asked for than [`MAX_SUNS`](judge::MAX_SUNS).
pub fn trade<E: From<EvalError>>(
    plants: &dyn Fn() -> Result<Plant, E>,
    settings: &TradeSettings,
    heap: &dyn Heap,
    observer: &dyn BakeObserver,
) -> Result<Trade, E> {
    let plant = Step::Import.run(observer, "", |_| plants())?;
    let points = judged_points(&plant.classed, settings.points, settings.ignore_alpha)?;
    let suns = judge::suns(settings.suns);
    let predict = Predict::survey(&plant, settings, observer)?;
    drop(plant);
    let (choices, skipped) = affordable(settings, &predict)?;

    let bench = Bench { settings, heap, observer, points: &points, suns: &suns };
    let mut of_all = OfAll::default();
    let (mut rows, mut traced) = (Vec::new(), Vec::new());
    let mut of_lattice = OfLattice::default();
    for (at, choice) in choices.iter().enumerate() {
        observer.note(&format!("{} of {}: {}", at + 1, choices.len(), choice.solve));
        let measured = bench.measure(choice, plants, &mut of_lattice, &mut of_all)?;
        let lattice = choice.solve.lattice;
        let sites = predict.sites(lattice);
        rows.extend(measured.into_iter().map(|(store, row)| {
            let predicted_bytes = predict.bytes(&choice.solve, &store);
            Row { sites, predicted_bytes, ..row }
        }));
        if choices.get(at + 1).is_none_or(|next| next.solve.lattice != lattice) {
            traced.push(Traced::new(lattice, sites, of_lattice.photons()));
            of_lattice = OfLattice::default();
        }
    }
    let rows = numbered(rows);
    Ok(Trade {
        points: points.len(),
        suns,
        mean_fluence: of_all.finest.map(|finest| finest.mean_fluence()).unwrap_or_default(),
        memory_limit_bytes: settings.limit_bytes,
        monte_carlo: traced,
        recommended: recommend::recommend(&rows),
        rows,
        skipped,
    })
}

/// Numbers the rows, the finest first, and marks the front.
fn numbered(mut rows: Vec<Row>) -> Vec<Row> {
    let is_finest = |row: &Row| row.choice == format!("{} {FINEST_STORE}", finest(row.lattice));
    if let Some(at) = rows.iter().position(is_finest) {
        rows[..=at].rotate_right(1);
    }
    let weighed: Vec<_> = rows.iter().map(|row| in_steps(row.weighed())).collect();
    for (at, (row, on_front)) in rows.iter_mut().zip(front(&weighed)).enumerate() {
        (row.row, row.pareto) = (at + 1, on_front);
    }
    rows
}
