//! How much memory a choice will need, before anything is allocated for it; and how much there is.

use flb_format::Codec;
use flb_format::beam::single;
use flb_transport::ordinates::OrdinatesSettings;

use super::choice::{FINEST_STORE, Solve, Store};
use super::transport::Marched;

/// Density, class, areas and extinction of a site; what the stages keep beside them for a moment.
const SITE_BYTES: u64 = 40;

/// What a solve keeps per non-empty site and per sun of a band, and per sun. Fitted to the built-in oak and rounded up:
/// a row tells what was predicted for it and what it took.
const LIGHT_BYTES: u64 = 36;
const BEAM_BYTES: u64 = 32;

/// Per non-empty site of a solve of `paper`: links and light of 18 directions.
const PAPER_SITE_BYTES: u64 = 2048;

/// Suns are solved in groups of so many.
const LANES: u64 = 8;

/// Every part of a site that is cut is a site of its own.
const PARTS_PER_CUT_SITE: u64 = 8;

/// Per non-empty site and ray of light scattered once: 55 axes, 1.9 crossings of 12 bytes on each.
const SINGLE_BYTES: u64 = 1300;

/// Everything that does not grow with the lattice: voxels of the fine grid, the mesh.
const BASE_BYTES: u64 = 200_000_000;

/// Predicted peak of a bake up to its fields, in bytes: not less than what it takes.
pub(super) fn of_solve(solve: &Solve, sites: u64, bands: u64) -> u64 {
    let lit = match solve.transport.marched() {
        None => PAPER_SITE_BYTES,
        Some(Marched { suns, parts, .. }) => {
            let suns = suns.basis();
            let single = suns.needs_single();
            let settings = OrdinatesSettings { suns, ..OrdinatesSettings::default() };
            let solved = u64::from(settings.solves()).next_multiple_of(LANES);
            let parts = if *parts > 1 { PARTS_PER_CUT_SITE } else { 1 };
            let rays = u64::from(single::rays(solve.lattice));
            let single = if single { rays * rays * SINGLE_BYTES } else { 0 };
            parts * solved * (bands.min(4) * LIGHT_BYTES + BEAM_BYTES) + single
        }
    };
    beside(solve) + fields(solve, bands) + sites * lit
}

/// The same of the coding, with the light sampled from the file.
pub(super) fn of_store(solve: &Solve, store: &Store, bands: u64) -> u64 {
    let fields = fields(solve, bands);
    // What a file takes of its fields, in quarters; what the search for the steps of blocks near geometry takes. Blocks
    // share texels, so that those of `paper`, which is lit all over, take more than twice its fields where nothing is
    // dropped; scattered light is nothing in most of a lattice.
    let is_all_over = solve.transport.is_all_over();
    let quarters = match (store.codec, store.threshold == 0.0) {
        (Codec::HaarPaper, true) if is_all_over => 10,
        (Codec::HaarPaper, true) => 5,
        (Codec::HaarPaper, false) if !is_all_over => 3,
        _ => 4,
    };
    // The fields, the file, and what a sampler keeps of it; the fields go before the last file is made.
    let kept = if *store == FINEST_STORE { 0 } else { fields };
    beside(solve) + kept + 2 * fields / 4 * quarters + fields / 4
}

fn beside(solve: &Solve) -> u64 {
    BASE_BYTES + u64::from(solve.lattice).pow(3) * SITE_BYTES
}

/// Plain floats.
fn fields(solve: &Solve, bands: u64) -> u64 {
    u64::from(solve.lattice).pow(3) * solve.transport.items() * bands * 4
}

/// Returns three quarters of the memory that the system has available, in bytes; `None` where it does not say.
pub fn available_bytes() -> Option<u64> {
    let text = std::fs::read_to_string("/proc/meminfo").ok()?;
    let kilobytes = text.lines().find_map(|line| line.strip_prefix("MemAvailable:"))?;
    let kilobytes: u64 = kilobytes.trim().strip_suffix("kB")?.trim().parse().ok()?;
    Some(kilobytes * 1024 / 4 * 3)
}

#[cfg(test)]
mod tests {
    use super::super::choice::choices;
    use super::*;

    #[test]
    fn more_of_anything_needs_more_memory() {
        let (choices, _) = choices(&[32, 64], false);
        for choice in &choices {
            let (solve, one) = (choice.solve, of_solve(&choice.solve, 5_000, 3));
            let finer = Solve { lattice: 2 * solve.lattice, ..solve };
            assert!(of_solve(&solve, 50_000, 3) > one && of_solve(&solve, 5_000, 4) > one, "{solve}");
            assert!(of_solve(&finer, 5_000, 3) > one, "{solve}");
            for store in &choice.stores {
                let one = of_store(&solve, store, 3);
                assert!(
                    of_store(&solve, store, 4) > one && of_store(&finer, store, 3) > one,
                    "{solve} {store}"
                );
            }
        }
    }
}
