//! Dropping bases that no scene needs, before or after coding, and writing down that they were.

use flb_format::bases::BaseSet;
use flb_format::container::records::{KIND_AVERAGES, KIND_BASE, KIND_DETAIL, KIND_METADATA, STORED_ZSTD};

use crate::encode::encode_metadata;
use crate::{EncodeSettings, EncodedSpecies, PackError};
use flb_format::SpeciesFields;

/// Drops every base that is not in `keep`. Bases that are missing already are not recorded: no plan left them out for
/// this reason. Nothing changes where a species needs all its bases: where its suns are no lattice directions (SPEC.md,
/// M38).
pub fn keep_bases(fields: &mut SpeciesFields, keep: BaseSet, reason: &str) {
    if fields.meta.model.needs_all_items() {
        return;
    }
    let dropped = fields.bases.iter().map(|(base, _)| *base).filter(|base| !keep.contains(*base)).collect();
    fields.bases.retain(|(base, _)| keep.contains(*base));
    fields.meta.leave_out(dropped, &[], reason);
}

/// Keeps these bases alone of a species that is coded already; no page but those of the metadata changes.
///
/// # Errors
/// Metadata that grow beyond the format's limit.
pub fn keep_coded_bases(species: &mut EncodedSpecies, keep: BaseSet, reason: &str) -> Result<(), PackError> {
    if species.meta.model.needs_all_items() {
        return Ok(());
    }
    let of_base = |kind: u32| matches!(kind, KIND_BASE | KIND_AVERAGES | KIND_DETAIL);
    let drop = |kind: u32, item: u32| of_base(kind) && !keep.contains(item as u8);
    let gone = species.sections.iter().filter(|section| drop(section.kind, section.item));
    let dropped: BaseSet = gone.map(|section| section.item as u8).collect();
    species.sections.retain(|section| !drop(section.kind, section.item));
    species.meta.leave_out(dropped, &[], reason);
    for section in species.sections.iter_mut().filter(|section| section.kind == KIND_METADATA) {
        let compress = section.pages.iter().any(|page| page.compression == STORED_ZSTD);
        let settings =
            EncodeSettings { compress, page_bytes: section.page_bytes, ..EncodeSettings::default() };
        *section = encode_metadata(&species.meta, &settings)?;
    }
    Ok(())
}
