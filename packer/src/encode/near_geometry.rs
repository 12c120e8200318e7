//! The codecs that store blocks near geometry: payloads of [`crate::rate`] to sections, and their error as a reader
//! samples them.

use std::sync::Arc;

use flb_format::blocks::{BlockMap, Classes, CodedBase, Coding, Shared};
use flb_format::container::records::*;
use flb_format::light::SunBasis;
use flb_format::matter::Class;
use flb_format::progress::Progress;
use flb_format::{Codec, Field};
use rayon::prelude::*;

use crate::quality::{BaseReport, SurfaceError};
use crate::rate::{
    BasePayloads, DetailCoding, Missed, RateSettings, SampledSites, SpeciesPayloads, code_harmonics,
    code_species,
};
use crate::{EncodeSettings, PackError};
use flb_format::SpeciesFields;

use super::{EncodedPage, EncodedSection, section, store};

/// What [`encode`] makes.
pub(super) struct Encoded {
    pub sections: Vec<EncodedSection>,
    pub reports: Vec<BaseReport>,
    pub missed: Vec<Missed>,
}

/// Sites that renderers sample, and those of them that hold leaves: light at solids is sampled off their surface, in
/// the sites of wood and in those beside them.
pub(super) fn sampled_sites(fields: &SpeciesFields) -> (Vec<bool>, Vec<bool>) {
    let medium = &fields.medium;
    let mut all: Vec<bool> = medium.class.iter().map(|class| *class != Class::Empty).collect();
    let mut leaves: Vec<bool> = medium.class.iter().map(|class| *class == Class::Leaf).collect();
    let mut wood: Vec<bool> = medium.class.iter().map(|class| *class == Class::Wood).collect();
    if let Some(turbid) = &fields.turbid {
        // A site can have extinction of matter that fills none of its voxels.
        for (site, (leaf, of_wood)) in turbid.leaf_per_m.iter().zip(&turbid.wood_per_m).enumerate() {
            all[site] |= leaf + of_wood > 0.0;
            leaves[site] |= *leaf > 0.0;
            wood[site] |= *of_wood > 0.0;
        }
    }
    let physical = fields.meta.physical();
    if physical.is_some_and(|(_, light)| light.solid_offset.is_some()) {
        let n = medium.grid.lattice as usize;
        for site in (0..wood.len()).filter(|site| wood[*site]) {
            for step in [1, n, n * n] {
                // The outer two layers are empty, so neighbours are there.
                all[site - step] = true;
                all[site + step] = true;
            }
        }
    }
    (all, leaves)
}

/// Sections of kinds 4 to 6, ascending by kind and item, and the report of every base. `bases` ascend.
pub(super) fn encode(
    fields: &SpeciesFields,
    bases: &[&(u8, Field)],
    settings: &EncodeSettings,
    points: &[u32],
    progress: &Progress<'_>,
) -> Result<Encoded, PackError> {
    let lattice = fields.meta.grid.lattice;
    let (all, leaves) = sampled_sites(fields);
    let sites = SampledSites { all: &all, leaves: &leaves };
    let list: Vec<(u8, &Field)> = bases.iter().map(|(base, field)| (*base, field)).collect();
    let rate = RateSettings {
        coding: if settings.codec == Codec::Haar { DetailCoding::Haar } else { DetailCoding::Classed },
        target: settings.target,
        all_blocks: settings.has_all_blocks(),
        page_bytes: settings.page_bytes,
    };
    let coded = match harmonics(fields) {
        Some(count) => code_harmonics(lattice, sites, &list, count, &rate),
        None => code_species(lattice, sites, &list, &rate),
    };
    let coded = coded.map_err(|error| error.of(&fields.meta.name))?;
    progress(0.9)?;
    let shared = shared(&coded, lattice);
    let bands = fields.meta.band_count() as u32;
    let sections: Vec<[EncodedSection; 2]> =
        coded.bases.par_iter().map(|base| base_sections(base, settings, lattice, bands)).collect();
    let reports = coded.bases.par_iter().zip(&sections).zip(&list).map(|((base, sections), (_, field))| {
        let read = read_back(&shared, base);
        let mut error = SurfaceError::of_samples(points, field, |point, out| read.sample(point, out));
        if harmonics(fields).is_some() && base.base > 0 {
            error.peak = base.head.peak.into(); // of the light that they make together
        }
        let bytes = sections.iter().flat_map(|s| &s.pages).map(|page| page.stored.len() as u64).sum();
        BaseReport::new(base.base, field.len() as u64 * 4, bytes, error)
    });
    let reports = reports.collect();

    let whole = |item, codec, payload: &[u8]| EncodedSection {
        lattice,
        bands: 1,
        ..section(KIND_BLOCKS, item, codec, settings, bytes_pages(payload, settings))
    };
    let mut all = vec![whole(BLOCKS_MAP, CODEC_BLOCK_MAP, &coded.map)];
    all.extend(coded.classes.iter().map(|classes| whole(BLOCKS_CLASSES, CODEC_CLASSES, classes)));
    let (averages, details): (Vec<_>, Vec<_>) = sections.into_iter().map(|[a, d]| (a, d)).unzip();
    all.extend(averages);
    all.extend(details);
    Ok(Encoded { sections: all, reports, missed: coded.missed })
}

/// How many bases are harmonics of the sun's direction, if they are.
pub(super) fn harmonics(fields: &SpeciesFields) -> Option<usize> {
    match fields.meta.physical()?.1.suns {
        SunBasis::Harmonics { degree, .. } => Some((usize::from(degree) + 1).pow(2)),
        SunBasis::Lattice18 | SunBasis::Directions(_) => None,
    }
}

/// Averages and detail of a base.
fn base_sections(
    base: &BasePayloads,
    settings: &EncodeSettings,
    lattice: u32,
    bands: u32,
) -> [EncodedSection; 2] {
    let mut averages = base.head.to_bytes();
    averages.extend(&base.averages);
    let mut averages = bytes_pages(&averages, settings);
    averages.iter_mut().for_each(|page| page.priority = base.priority); // each part needs all others
    let detail = base.pages.iter().map(|page| EncodedPage {
        priority: page.priority,
        ..store(page.count, page.payload.clone(), settings.compress)
    });
    let of = |kind, codec, pages| EncodedSection {
        lattice,
        bands,
        ..section(kind, base.base.into(), codec, settings, pages)
    };
    [of(KIND_AVERAGES, CODEC_AVERAGES, averages), of(KIND_DETAIL, settings.codec.number(), detail.collect())]
}

/// A payload that has a unit per byte.
fn bytes_pages(payload: &[u8], settings: &EncodeSettings) -> Vec<EncodedPage> {
    let parts = payload.chunks(settings.page_bytes as usize);
    parts.map(|part| store(part.len() as u32, part.to_vec(), settings.compress)).collect()
}

fn shared(coded: &SpeciesPayloads, lattice: u32) -> Arc<Shared> {
    let map = BlockMap::from_bytes(&coded.map, lattice).expect("the map was just made");
    let coding = match &coded.classes {
        Some(classes) => Coding::Classed(Classes::from_bytes(classes).expect("the tables were just made")),
        None => Coding::Haar,
    };
    Arc::new(Shared { map, coding })
}

/// The base as a reader has it.
fn read_back(shared: &Arc<Shared>, base: &BasePayloads) -> CodedBase {
    let mut bytes = base.head.to_bytes();
    bytes.extend(&base.averages);
    let mut read =
        CodedBase::from_bytes(shared, base.head.bands, &bytes).expect("the averages were just made");
    for page in &base.pages {
        read.add(page.first, page.count, &page.payload).expect("the page was just made");
    }
    read
}
