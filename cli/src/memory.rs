//! Memory that the fields of a file take where a command needs them whole, looked at before any is read: a file of a
//! few kilobytes can hold, soundly, 4 GiB of zeros for each base.

use std::path::Path;

use flb_format::container::{BaseEntry, Species};
use flb_runtime::Library;

use crate::args::MemoryArgs;
use crate::exit::{Failure, LIMIT, USAGE};
use crate::print;

/// Refuses what needs more than the limit. `what` is named in the error.
pub(crate) fn check(
    library: &Library,
    what: &str,
    needed_bytes: u64,
    args: &MemoryArgs,
) -> Result<(), Failure> {
    match check_bytes(what, needed_bytes, args) {
        Err(failure) if failure.code == LIMIT => Err(failure.at(library.path())),
        result => result,
    }
}

/// The same where no library is at fault.
pub(crate) fn check_bytes(what: &str, needed_bytes: u64, args: &MemoryArgs) -> Result<(), Failure> {
    let limit_gb = args.memory_limit;
    if !(limit_gb.is_finite() && limit_gb > 0.0) {
        return Err(Failure::new(USAGE, format!("--memory-limit is {limit_gb}, expected a number above 0")));
    }
    if needed_bytes as f64 <= limit_gb * 1e9 {
        return Ok(());
    }
    let needed = print::bytes(needed_bytes);
    let message =
        format!("{what}: {needed} of memory needed, over the limit of {limit_gb} GB (--memory-limit)");
    Err(Failure::new(LIMIT, message))
}

/// Refuses a scene of so many plants where the limit, or the system, has no room for `each` bytes for one, beside the
/// scene itself.
pub(crate) fn check_plants(
    scene: &Path,
    plants: usize,
    each: usize,
    args: &MemoryArgs,
) -> Result<(), Failure> {
    let bytes = plants.saturating_mul(each);
    check_bytes(&format!("{plants} plants"), bytes as u64, args).map_err(|failure| failure.at(scene))?;
    Vec::<u8>::new().try_reserve_exact(bytes).map_err(|_| {
        let message =
            format!("{plants} plants need {bytes} bytes of memory more, which the system does not give");
        Failure::new(LIMIT, message).at(scene)
    })
}

/// A list with room for a file of so many bytes.
pub(crate) fn room_for(bytes: usize) -> Result<Vec<u8>, Failure> {
    let mut list = Vec::new();
    list.try_reserve_exact(bytes).map_err(|_| {
        Failure::new(
            LIMIT,
            format!("{bytes} bytes of memory needed for the file, which the system does not give"),
        )
    })?;
    Ok(list)
}

/// A base with all its values.
pub(crate) fn field_bytes(species: &Species) -> u64 {
    // At most 256^3 sites of 64 bands.
    4 * species.meta.grid.sites() as u64 * species.meta.band_count() as u64
}

/// A base with all its values, and its pages while they are decoded.
pub(crate) fn read_bytes(species: &Species, base: &BaseEntry) -> u64 {
    field_bytes(species).saturating_add(base.raw_bytes)
}

/// All bases of a species with all their values.
pub(crate) fn fields_bytes(species: &Species) -> u64 {
    let pages = species.bases.iter().map(|base| base.raw_bytes).max().unwrap_or(0);
    (species.bases.len() as u64 * field_bytes(species)).saturating_add(pages)
}

/// All bases of a species as a sampler keeps them: coded, or plain values.
pub(crate) fn sampler_bytes(species: &Species) -> u64 {
    let kept = |base: &BaseEntry| match base.codec {
        flb_format::Codec::RawF32 | flb_format::Codec::RawF16 => field_bytes(species),
        _ => base.raw_bytes,
    };
    species.bases.iter().map(kept).fold(field_bytes(species), u64::saturating_add)
}
