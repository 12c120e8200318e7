//! What following a plan saves: for the summaries of `bake` and `pack`.

use flb_format::SpeciesMeta;
use flb_format::bases::BaseSet;
use flb_format::container::Species;
use flb_format::container::records::{KIND_AVERAGES, KIND_BASE, KIND_DETAIL};
use flb_packer::EncodedSpecies;
use serde::Serialize;

/// What following a plan saves for one species, in the summaries of `bake` and `pack`.
#[derive(Serialize)]
pub(crate) struct PlanSavings {
    /// Bases left out by now, by this plan or an earlier one.
    pub bases_left_out: BaseSet,
    /// Bands left out by now, by this plan or an earlier one.
    pub bands_left_out: Vec<String>,
    /// Solves that a bake of everything would have done more; `pack` never solves.
    pub solves_left_out: u32,
    /// Bytes of the file that they would take: in `bake` as many as the bases that are there take on average, in
    /// `pack` as many as they take in the input.
    pub file_bytes_left_out: u64,
    /// Bytes of their fields in memory.
    pub memory_bytes_left_out: u64,
}

impl PlanSavings {
    /// Of a species baked by a plan, that could have had so many bands; `solves` that were done, and of a bake without
    /// a plan.
    pub(crate) fn of_bake(species: &EncodedSpecies, all_bands: usize, solves: [u32; 2]) -> PlanSavings {
        let meta = &species.meta;
        let of_base = |kind: u32| matches!(kind, KIND_BASE | KIND_AVERAGES | KIND_DETAIL);
        let (mut kept, mut bytes) = (0, 0u64);
        for section in species.sections.iter().filter(|section| of_base(section.kind)) {
            kept += usize::from(section.kind != KIND_DETAIL);
            bytes += section.pages.iter().map(|page| page.stored.len() as u64).sum::<u64>();
        }
        let here = (kept * meta.band_count()) as u64;
        let all = u64::from(meta.model.items()) * all_bands as u64;
        let (bases_left_out, bands_left_out) = left_out(meta);
        PlanSavings {
            bases_left_out,
            bands_left_out,
            solves_left_out: solves[1] - solves[0],
            file_bytes_left_out: bytes * (all - here) / here.max(1),
            memory_bytes_left_out: (all - here) * meta.grid.sites() as u64 * 4,
        }
    }

    /// Of a species of a file, of which `keep` is kept.
    pub(crate) fn of_pack(species: &Species, keep: BaseSet) -> PlanSavings {
        let (earlier, bands_left_out) = left_out(&species.meta);
        let dropped = || species.bases.iter().filter(|base| !keep.contains(base.base));
        let values = species.meta.grid.sites() * species.meta.band_count();
        PlanSavings {
            bases_left_out: earlier.union(dropped().map(|base| base.base).collect()),
            bands_left_out,
            solves_left_out: 0,
            file_bytes_left_out: dropped().map(|base| base.bytes).sum(),
            memory_bytes_left_out: (dropped().count() * values * 4) as u64,
        }
    }
}

fn left_out(meta: &SpeciesMeta) -> (BaseSet, Vec<String>) {
    meta.left_out.as_ref().map_or((BaseSet::NONE, Vec::new()), |l| (l.bases, l.bands.clone()))
}
