//! Memory that each choice will need, and the choices that there is memory for.

use flb_baker::voxelise::VoxelSettings;
use flb_baker::{downsample, voxelise};
use flb_format::size_text::bytes;
use flb_scene::{ClassedMesh, Observer, Plant, Step};

use super::choice::{self, Choice, FINEST_STORE, Skipped, Solve, Store};
use super::memory;
use super::settings::TradeSettings;
use super::transport::BandNames;
use crate::EvalError;

/// Lattice and its non-empty sites.
type Sites = Vec<(u32, u64)>;

/// What memory is predicted from.
pub(super) struct Predict {
    sites: Sites,
    names: BandNames,
}

impl Predict {
    /// Counts the non-empty sites of every lattice.
    pub(super) fn survey(
        plant: &Plant,
        settings: &TradeSettings,
        observer: &dyn Observer,
    ) -> Result<Predict, EvalError> {
        Ok(Predict { sites: survey(&plant.classed, settings, observer)?, names: BandNames::of(plant) })
    }

    pub(super) fn sites(&self, lattice: u32) -> u64 {
        self.sites.iter().find(|(of, _)| *of == lattice).map_or(0, |(_, sites)| *sites)
    }

    fn of_solve(&self, solve: &Solve) -> u64 {
        memory::of_solve(solve, self.sites(solve.lattice), self.bands())
    }

    pub(super) fn bytes(&self, solve: &Solve, store: &Store) -> u64 {
        self.of_solve(solve).max(memory::of_store(solve, store, self.bands()))
    }

    fn bands(&self) -> u64 {
        self.names.most()
    }
}

fn survey(
    ClassedMesh { mesh, classes }: &ClassedMesh,
    settings: &TradeSettings,
    observer: &dyn Observer,
) -> Result<Sites, EvalError> {
    let TradeSettings { voxels, ignore_alpha, .. } = *settings;
    let count = |&lattice: &u32| -> Result<_, EvalError> {
        let settings = VoxelSettings { voxels, lattice, ignore_alpha };
        let medium =
            Step::Survey.run(observer, &lattice.to_string(), |progress| -> Result<_, EvalError> {
                Ok(downsample(&voxelise(mesh, classes, &settings, progress)?)?)
            })?;
        Ok((lattice, medium.nonempty_sites() as u64))
    };
    settings.lattices.iter().map(count).collect()
}

/// The choices that fit into the memory, and those that were skipped.
pub(super) fn affordable(
    settings: &TradeSettings,
    predict: &Predict,
) -> Result<(Vec<Choice>, Vec<Skipped>), EvalError> {
    let TradeSettings { ref lattices, limit_bytes, quick, .. } = *settings;
    let need = |lattice: u32| predict.bytes(&choice::finest(lattice), &FINEST_STORE);
    let Some(&finest) = lattices.iter().filter(|lattice| need(**lattice) <= limit_bytes).max() else {
        let smallest = lattices.iter().min().copied().unwrap_or_default();
        let solve = choice::finest(smallest).to_string();
        return Err(EvalError::Memory { solve, needed_bytes: need(smallest), limit_bytes });
    };
    let (all, mut skipped) = choice::choices(lattices, quick);
    let too_much = |solve: &Solve, store: Option<&Store>, needed: u64| {
        let (need, limit) = (bytes(needed), bytes(limit_bytes));
        let reason = format!("it would need about {need} of memory, at most {limit} may be used");
        Skipped { is_of_memory: true, ..Skipped::new(solve, store, reason) }
    };
    let mut kept = Vec::new();
    for mut choice in all {
        let solve = choice.solve;
        if predict.of_solve(&solve) > limit_bytes {
            skipped.push(too_much(&solve, None, predict.of_solve(&solve)));
            continue;
        }
        if solve.lattice > finest {
            // There is nothing as fine that it could be compared with.
            let reason = format!("the finest solve that fits into memory is of lattice {finest}");
            skipped.push(Skipped::new(&solve, None, reason));
            continue;
        }
        let is_too_much = |store: &mut Store| predict.bytes(&solve, store) > limit_bytes;
        skipped.extend(
            choice
                .stores
                .extract_if(.., is_too_much)
                .map(|store| too_much(&solve, Some(&store), predict.bytes(&solve, &store))),
        );
        if !choice.stores.is_empty() {
            kept.push(choice);
        }
    }
    let mut compared = Vec::new();
    for choice in kept {
        match predict.names.why_not_compared(&choice.solve.transport) {
            None => compared.push(choice),
            Some(reason) => skipped.push(Skipped::new(&choice.solve, None, reason)),
        }
    }
    Ok((compared, skipped))
}
