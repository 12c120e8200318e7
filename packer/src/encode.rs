//! Fields and medium of a species to coded pages. Bases are coded in parallel, each by one thread, so
//! the bytes do not depend on the number of threads.

mod check;
mod near_geometry;
mod settings;

use flb_format::container::payload::{BlockPage, SPARSE_GROUP, SparseValue};
use flb_format::container::records::*;
use flb_format::container::{metadata, payload};
use flb_format::error::Place;
use flb_format::matter::TurbidMedium;
use flb_format::mesh::{MESH_ERROR, MeshError};
use flb_format::progress::Progress;
use flb_format::{Field, Medium, SpeciesFields, SpeciesMeta, block, provenance};
use rayon::prelude::*;
use std::ops::RangeInclusive;
use std::sync::Arc;
use std::sync::atomic::{AtomicUsize, Ordering};

use crate::quality::{self, CodingReport};
use crate::rate::Missed;
use crate::surface::surface_sites;
use crate::{PackError, priority};

pub use settings::{CodingPreset, EncodeSettings, StoredBlocks};

/// zstd's level for pages; they are small, and written once but read often.
const ZSTD_LEVEL: i32 = 9;

/// A species as it goes into a file.
#[derive(Debug, Clone)]
pub struct EncodedSpecies {
    /// Metadata as stored.
    pub meta: SpeciesMeta,
    /// Sections, ascending by kind and item.
    pub sections: Vec<EncodedSection>,
    /// Sizes and errors of the coding; `None` for a species that was copied without decoding.
    pub report: Option<CodingReport>,
    /// Sections that [`crate::copy_species`] left behind, as their flags demand.
    pub dropped: Vec<SectionKey>,
}

impl EncodedSpecies {
    /// Bases whose coding missed the error that was asked for.
    pub fn missed(&self) -> impl Iterator<Item = &Missed> {
        self.report.iter().flat_map(|report| &report.missed)
    }

    /// Writes into the metadata how far the coded light is off on the mesh. `settings` are those of its coding.
    ///
    /// # Errors
    /// Metadata that no file can hold.
    pub fn set_mesh_error(&mut self, error: &MeshError, settings: &EncodeSettings) -> Result<(), PackError> {
        self.meta.settings.insert(MESH_ERROR.to_owned(), error.to_value());
        let metadata = encode_metadata(&self.meta, settings)?;
        let is_metadata = |section: &&mut EncodedSection| section.kind == KIND_METADATA;
        self.sections.iter_mut().filter(is_metadata).for_each(|section| *section = metadata.clone());
        Ok(())
    }
}

/// A section, not yet placed in a file.
#[derive(Debug, Clone)]
pub struct EncodedSection {
    /// Kind of the section.
    pub kind: u32,
    /// Item within the kind.
    pub item: u32,
    /// Flags of the section.
    pub flags: u32,
    /// Number of the codec.
    pub codec: u32,
    /// Relative threshold.
    pub threshold: f32,
    /// Largest size of a payload, in bytes.
    pub page_bytes: u32,
    /// Sites per edge, or 0.
    pub lattice: u32,
    /// Values per site, or 0.
    pub bands: u32,
    /// Pages in order.
    pub pages: Vec<EncodedPage>,
}

impl EncodedSection {
    /// Bytes of all its payloads, before compression.
    pub fn raw_bytes(&self) -> u64 {
        self.pages.iter().map(|page| u64::from(page.raw_bytes)).sum()
    }
}

/// A page, not yet placed in a file.
#[derive(Debug, Clone, PartialEq)]
pub struct EncodedPage {
    /// Number of units.
    pub count: u32,
    /// Bytes before compression.
    pub raw_bytes: u32,
    /// Encoding of `stored`: plain or zstd.
    pub compression: u32,
    /// Squared error that reading it removes, as in [`PageEntry::priority`].
    pub priority: f32,
    /// Bytes as they go into the file.
    pub stored: Arc<[u8]>,
}

/// Codes a species. `progress` is called with the share that is done, from any thread.
///
/// # Errors
/// Settings outside the format's limits; fields or medium that do not fit the metadata; values that the
/// format or the codec refuses (NaN, infinite, negative density; above 65504 in `raw-f16`);
/// [`PackError::Cancelled`].
pub fn encode_species(
    fields: &SpeciesFields,
    settings: &EncodeSettings,
    progress: &Progress<'_>,
) -> Result<EncodedSpecies, PackError> {
    check_settings(settings)?;
    let bases = check::fields(fields, settings.codec)?;
    check::medium(fields)?;
    check::turbid(fields)?;
    let points = surface_sites(&fields.medium);
    let near_geometry::Encoded { sections: base_sections, reports, missed } =
        if settings.codec.is_near_geometry() {
            near_geometry::encode(fields, &bases, settings, &points, progress)?
        } else {
            let unit = unit_of_light(fields, &points);
            let near = (settings.codec == Codec::HaarPaper && !settings.has_all_blocks())
                .then(|| block::near(fields.meta.grid.lattice, &near_geometry::sampled_sites(fields).0));
            let done = AtomicUsize::new(0);
            let coded = bases
                .par_iter()
                .map(|(base, field)| {
                    let threshold = if *base == 0 { settings.threshold } else { settings.threshold * unit };
                    let settings = EncodeSettings { threshold, ..settings.clone() };
                    let empty_value = fields.meta.model.empty_value(*base);
                    let coded = encode_base(*base, empty_value, field, &settings, &points, near.as_deref());
                    let count = done.fetch_add(1, Ordering::Relaxed) + 1;
                    progress(count as f64 / bases.len() as f64)?;
                    Ok(coded)
                })
                .collect::<Result<Vec<_>, PackError>>()?;
            let (sections, reports) = coded.into_iter().unzip();
            near_geometry::Encoded { sections, reports, missed: Vec::new() }
        };
    let together = settings.codec.is_near_geometry() && near_geometry::harmonics(fields).is_some();
    let report = CodingReport { missed, ..CodingReport::pool(reports, together) };
    let meta = with_settings(&fields.meta, settings, &report);

    let mut sections = vec![encode_metadata(&meta, settings)?];
    sections.extend(encode_medium(&fields.medium, fields.turbid.as_ref(), settings));
    sections.extend(base_sections);
    Ok(EncodedSpecies { meta, sections, report: Some(report), dropped: Vec::new() })
}

/// Codes species side by side, with the same settings: small ones leave cores idle where one is coded at a time. The
/// species of the result are in the order given. `progress` is called with the share that is done, from any thread.
///
/// # Errors
/// Those of [`encode_species`], for the first species in order that has one.
pub fn encode_all(
    species: &[&SpeciesFields],
    settings: &EncodeSettings,
    progress: &Progress<'_>,
) -> Result<Vec<EncodedSpecies>, PackError> {
    let done = AtomicUsize::new(0);
    let share = |count: usize| progress(count as f64 / species.len() as f64);
    let encode = |fields: &&SpeciesFields| {
        let coded = encode_species(fields, settings, &|_| share(done.load(Ordering::Relaxed)))?;
        share(done.fetch_add(1, Ordering::Relaxed) + 1)?;
        Ok(coded)
    };
    let coded: Vec<_> = species.par_iter().map(encode).collect();
    coded.into_iter().collect()
}

fn check_settings(settings: &EncodeSettings) -> Result<(), PackError> {
    let fits = (0.0..=MAX_MAGNITUDE).contains(&settings.threshold);
    if !fits {
        let (found, expected) = (settings.threshold.to_string(), "a number from 0 to 2^96");
        return Err(PackError::Setting { what: "threshold", found, expected });
    }
    let page_bytes = settings.page_bytes;
    let fits =
        (MIN_PAGE_BYTES..=MAX_PAGE_BYTES).contains(&page_bytes) && page_bytes.is_multiple_of(PAGE_BYTES_STEP);
    if !fits {
        let (found, expected) = (page_bytes.to_string(), "a multiple of 4096 from 20480 to 4194304");
        return Err(PackError::Setting { what: "page size", found, expected });
    }
    Ok(())
}

/// What thresholds are relative to in the sun's fields. In `paper` files that is the light that enters, 1. Scattered
/// light of dark leaves is a few hundredths of it, so in `physical` files it is the mean scattered light of the
/// brightest band: of all bases of directions, or c_0 of the harmonics. Where that is not above 0, the near beam has
/// all the light: it is between 0 and 1, and half of what goes with it counts, too.
fn unit_of_light(fields: &SpeciesFields, points: &[u32]) -> f32 {
    let Some((_, light)) = fields.meta.physical() else { return 1.0 };
    let mean_of = |field: &Field, band: u32| {
        let sum: f64 = points.iter().map(|&site| f64::from(field.value(band, site as usize))).sum();
        sum / points.len().max(1) as f64
    };
    let sum_over = |band: u32, items: RangeInclusive<u8>| -> f64 {
        let counted = fields.bases.iter().filter(|(base, _)| items.contains(base));
        counted.map(|(_, field)| mean_of(field, band)).sum()
    };
    let of_band = |band: u32| match light.suns.first_near_item() {
        None => {
            let suns = fields.bases.iter().filter(|(base, _)| *base > 0).count();
            sum_over(band, 1..=u8::MAX) / suns.max(1) as f64
        }
        Some(near) => {
            let smooth = sum_over(band, 1..=1);
            if smooth > 0.0 { smooth } else { smooth + 0.5 * sum_over(band, near..=u8::MAX) }
        }
    };
    (0..fields.meta.band_count() as u32).map(of_band).fold(0.0, f64::max) as f32
}

/// The metadata with the settings that shape the coded bytes, and the error that they made; those of an
/// earlier coding go.
fn with_settings(meta: &SpeciesMeta, settings: &EncodeSettings, report: &CodingReport) -> SpeciesMeta {
    let mut meta = meta.clone();
    let earlier_psnr_db = meta.recorded(&provenance::SURFACE_PSNR_DB).flatten();
    meta.settings.retain(|key, _| !key.starts_with(provenance::CODING) && key != MESH_ERROR);
    meta.record(&provenance::CODEC, settings.codec.name().to_owned());
    meta.record(&provenance::COMPRESS, settings.compress);
    meta.record(&provenance::PAGE_BYTES, settings.page_bytes);
    if settings.codec == Codec::HaarPaper {
        // The shortest decimal of the f32, not the long one of its double.
        let shortest: f64 = settings.threshold.to_string().parse().expect("a float's text is a float");
        meta.record(&provenance::THRESHOLD, shortest);
    }
    if settings.codec.is_near_geometry() {
        let (psnr_db, relative) = settings.target.errors();
        psnr_db.into_iter().for_each(|db| meta.record(&provenance::TARGET_PSNR_DB, db));
        relative.into_iter().for_each(|share| meta.record(&provenance::TARGET_ERROR, share));
    }
    let has_fewer = settings.codec == Codec::HaarPaper && !settings.has_all_blocks();
    if settings.codec.is_near_geometry() || has_fewer {
        meta.record(&provenance::ALL_BLOCKS, settings.has_all_blocks());
    }
    // A copied species is not decoded, and still can say what it lost. Null: no sample has an error.
    let psnr_db = combined_psnr_db(earlier_psnr_db, report.surface_psnr_db);
    meta.record(&provenance::SURFACE_PSNR_DB, psnr_db.map(|db| libm::round(db * 1e3) / 1e3));
    meta
}

/// The error of a coding of what an earlier coding left: mean squares add, as those of independent errors do.
fn combined_psnr_db(earlier: Option<f64>, now: Option<f64>) -> Option<f64> {
    let square = |db: f64| libm::exp10(-db / 10.0);
    match (earlier, now) {
        (Some(a), Some(b)) => Some(-10.0 * libm::log10(square(a) + square(b))),
        (a, b) => a.or(b),
    }
}

pub(crate) fn encode_metadata(
    meta: &SpeciesMeta,
    settings: &EncodeSettings,
) -> Result<EncodedSection, PackError> {
    let key = SectionKey { kind: KIND_METADATA, species: 0, item: 0 };
    let bytes = metadata::to_bytes(meta, Place::section(0, key))?;
    let pages = bytes
        .chunks(settings.page_bytes as usize)
        .map(|part| store(part.len() as u32, part.to_vec(), settings.compress))
        .collect();
    Ok(section(KIND_METADATA, 0, CODEC_JSON, settings, pages))
}

fn encode_medium(
    medium: &Medium,
    turbid: Option<&TurbidMedium>,
    settings: &EncodeSettings,
) -> Vec<EncodedSection> {
    let class: Vec<u8> = medium.class.iter().map(|class| *class as u8).collect();
    let lattice = medium.grid.lattice;
    let array = |item: u32, codec, pages| EncodedSection {
        lattice,
        bands: 1,
        ..section(KIND_MEDIUM, item, codec, settings, pages)
    };
    let mut sections = vec![
        array(0, CODEC_SPARSE_F32, sparse_pages(&medium.density, settings)),
        array(1, CODEC_SPARSE_U8, sparse_pages(&class, settings)),
        array(2, CODEC_SPARSE_F32, sparse_pages(&medium.leaf_area_density, settings)),
        array(3, CODEC_SPARSE_F32, sparse_pages(&medium.wood_area_density, settings)),
    ];
    for (item, per_m) in
        (MEDIUM_EXTINCTION..).zip(turbid.into_iter().flat_map(|t| [&t.leaf_per_m, &t.wood_per_m]))
    {
        sections.push(array(item, CODEC_SPARSE_F32, sparse_pages(per_m, settings)));
    }
    sections
}

/// As many groups of 64 values per page as fit.
fn sparse_pages<T: SparseValue>(values: &[T], settings: &EncodeSettings) -> Vec<EncodedPage> {
    let mut pages = Vec::new();
    let (mut start, mut bytes) = (0, 0);
    let mut flush = |range: std::ops::Range<usize>| {
        let count = range.len() as u32;
        pages.push(store(count, payload::encode_sparse(&values[range]), settings.compress));
    };
    for (g, group) in values.chunks_exact(SPARSE_GROUP).enumerate() {
        let more = payload::sparse_group_bytes(group);
        if bytes + more > settings.page_bytes as usize {
            flush(start..g * SPARSE_GROUP);
            (start, bytes) = (g * SPARSE_GROUP, 0);
        }
        bytes += more;
    }
    flush(start..values.len());
    pages
}

fn encode_base(
    base: u8,
    empty_value: f32,
    field: &Field,
    settings: &EncodeSettings,
    points: &[u32],
    near: Option<&[bool]>,
) -> (EncodedSection, quality::BaseReport) {
    let (pages, error) = match settings.codec {
        Codec::RawF32 => (
            raw_pages(field, empty_value, 4, payload::encode_raw, settings),
            quality::SurfaceError::exact(points, field),
        ),
        Codec::RawF16 => {
            let values = field.values().iter().map(|value| payload::rounded_f16(*value)).collect();
            let rounded = Field::new(field.lattice, field.bands, values);
            let error = quality::SurfaceError::of_texels(points, field, &rounded);
            (raw_pages(&rounded, empty_value, 2, payload::encode_raw_f16, settings), error)
        }
        Codec::Classed | Codec::Haar => unreachable!("coded for all bases at once, in `near`"),
        Codec::HaarPaper => {
            let threshold = payload::absolute_threshold(empty_value, settings.threshold);
            let blocks = block_pages(field, threshold, settings.page_bytes, near);
            let error = quality::SurfaceError::of_blocks(points, field, &blocks);
            let pages = blocks.into_iter().map(|page| EncodedPage {
                priority: priority::of_blocks(&page, field.bands as usize, empty_value),
                ..store(page.masks.len() as u32, page.to_bytes(), settings.compress)
            });
            (pages.collect(), error)
        }
    };
    let threshold = if settings.codec == Codec::HaarPaper { settings.threshold + 0.0 } else { 0.0 };
    let coded = EncodedSection {
        lattice: field.lattice,
        bands: field.bands,
        threshold,
        ..section(KIND_BASE, base.into(), settings.codec.number(), settings, pages)
    };
    let coded_bytes = coded.pages.iter().map(|page| page.stored.len() as u64).sum();
    let report = quality::BaseReport::new(base, field.len() as u64 * 4, coded_bytes, error);
    (coded, report)
}

/// As many values per page as fit, each of `value_bytes` as `encode` appends it.
fn raw_pages(
    field: &Field,
    empty_value: f32,
    value_bytes: usize,
    encode: fn(&[f32], &mut Vec<u8>),
    settings: &EncodeSettings,
) -> Vec<EncodedPage> {
    let page = |values: &[f32]| {
        let mut bytes = Vec::with_capacity(values.len() * value_bytes);
        encode(values, &mut bytes);
        let priority = priority::of_values(values, empty_value);
        EncodedPage { priority, ..store(values.len() as u32, bytes, settings.compress) }
    };
    field.values().chunks(settings.page_bytes as usize / value_bytes).map(page).collect()
}

/// As many blocks per page as fit, in `[z][y][x]` order. `near` tells, per block, whether it is stored; `None`: all.
fn block_pages(field: &Field, threshold: f32, page_bytes: u32, near: Option<&[bool]>) -> Vec<BlockPage> {
    let bands = field.bands as usize;
    let per_axis = block::blocks_per_axis(field.lattice);
    let mut texels = vec![0.0; block::TEXELS * bands];
    let mut coefficients = Vec::with_capacity(texels.len());
    let mut pages = Vec::new();
    let (mut page, mut bytes) = (BlockPage::default(), 0);
    for b in 0..per_axis.pow(3) {
        let at = [b % per_axis, b / per_axis % per_axis, b / (per_axis * per_axis)];
        coefficients.clear();
        let mask = if near.is_none_or(|near| near[b as usize]) {
            block::gather(field, at, &mut texels);
            block::encode(&texels, bands, threshold, &mut coefficients)
        } else {
            0
        };
        let more = BlockPage::block_bytes(mask, field.bands);
        if bytes + more > page_bytes {
            pages.push(std::mem::take(&mut page));
            (page.first_block, bytes) = (b, 0);
        }
        page.push(mask, &coefficients, bands);
        bytes += more;
    }
    pages.push(page);
    pages
}

fn section(
    kind: u32,
    item: u32,
    codec: u32,
    settings: &EncodeSettings,
    pages: Vec<EncodedPage>,
) -> EncodedSection {
    EncodedSection {
        kind,
        item,
        flags: FLAG_REQUIRED,
        codec,
        threshold: 0.0,
        page_bytes: settings.page_bytes,
        lattice: 0,
        bands: 0,
        pages,
    }
}

/// A payload as it is stored: compressed where that is wanted and makes it smaller.
fn store(count: u32, payload: Vec<u8>, compress: bool) -> EncodedPage {
    let raw_bytes = payload.len() as u32;
    if compress {
        let frame = zstd::bulk::compress(&payload, ZSTD_LEVEL).expect("zstd compresses any bytes in memory");
        if frame.len() < payload.len() {
            return EncodedPage {
                count,
                raw_bytes,
                compression: STORED_ZSTD,
                priority: 0.0,
                stored: frame.into(),
            };
        }
    }
    EncodedPage { count, raw_bytes, compression: STORED_PLAIN, priority: 0.0, stored: payload.into() }
}
