//! Fields and medium of a species to coded pages. Bases are coded in parallel, each by one thread, so
//! the bytes do not depend on the number of threads.

use flb_format::container::{metadata, payload};
use flb_format::payload::{BlockPage, SPARSE_GROUP, SparseValue};
use flb_format::records::*;
use flb_format::{BaseSet, Class, Field, Medium, Place, SpeciesMeta, block};
use rayon::prelude::*;
use std::sync::atomic::{AtomicUsize, Ordering};

use crate::PackError;
use crate::quality::{self, CodingReport};

/// zstd's level for pages; they are small, and written once but read often.
const ZSTD_LEVEL: i32 = 9;

/// How the bases of a species are coded.
#[derive(Debug, Clone, PartialEq)]
pub struct EncodeSettings {
    /// Codec of every base.
    pub codec: Codec,
    /// Relative threshold of `haar-paper`: a coefficient is kept above `threshold` times the base's value
    /// in empty space (1, or 18 for base 0). Not used by `raw-f32`.
    pub threshold: f32,
    /// Whether pages are zstd-compressed where that makes them smaller.
    pub compress: bool,
    /// Most bytes of a page before compression; a multiple of 4096 from 20480 to 4194304.
    pub page_bytes: u32,
}

impl Default for EncodeSettings {
    fn default() -> EncodeSettings {
        EncodeSettings { codec: Codec::HaarPaper, threshold: 0.0, compress: false, page_bytes: 65_536 }
    }
}

/// Everything about a species that packing needs.
#[derive(Debug, Clone, PartialEq)]
pub struct SpeciesFields {
    /// Name, units, optics, provenance. `settings` gains the keys `encode.*`.
    pub meta: SpeciesMeta,
    /// Its medium, on the grid of `meta`.
    pub medium: Medium,
    /// Base index 0..=18 and field, in any order.
    pub bases: Vec<(u8, Field)>,
}

/// A species as it goes into a file.
#[derive(Debug, Clone)]
pub struct EncodedSpecies {
    /// As stored.
    pub meta: SpeciesMeta,
    /// Ascending by kind and item.
    pub sections: Vec<EncodedSection>,
    /// Sizes and errors of the coding; `None` for a species that was copied without decoding.
    pub report: Option<CodingReport>,
    /// Sections that [`crate::copy_species`] left behind, as their flags demand.
    pub dropped: Vec<SectionKey>,
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
    /// Most bytes of a payload.
    pub page_bytes: u32,
    /// Sites per edge, or 0.
    pub lattice: u32,
    /// Values per site, or 0.
    pub bands: u32,
    /// In order.
    pub pages: Vec<EncodedPage>,
}

/// A page, not yet placed in a file.
#[derive(Debug, Clone, PartialEq, Eq)]
pub struct EncodedPage {
    /// Units.
    pub count: u32,
    /// Bytes before compression.
    pub raw_bytes: u32,
    /// How `stored` holds the payload.
    pub compression: u32,
    /// Bytes as they go into the file.
    pub stored: Vec<u8>,
}

/// Codes a species. `progress` is called with the share that is done, from any thread.
///
/// # Errors
/// Settings outside the format's limits; fields or medium that do not fit the metadata; values that the
/// format refuses (NaN, infinite, negative density).
pub fn encode_species(
    fields: &SpeciesFields,
    settings: &EncodeSettings,
    progress: &(dyn Fn(f64) + Sync),
) -> Result<EncodedSpecies, PackError> {
    check_settings(settings)?;
    let bases = check_fields(fields)?;
    check_medium(fields)?;
    let points = quality::surface_sites(&fields.medium);
    let done = AtomicUsize::new(0);
    let coded: Vec<(EncodedSection, quality::BaseReport)> = bases
        .par_iter()
        .map(|(base, field)| {
            let coded = encode_base(*base, field, settings, &points);
            let count = done.fetch_add(1, Ordering::Relaxed) + 1;
            progress(count as f64 / bases.len() as f64);
            coded
        })
        .collect();
    let (base_sections, reports): (Vec<_>, _) = coded.into_iter().unzip();
    let report = CodingReport::pool(reports);
    let meta = with_settings(&fields.meta, settings, &report);

    let mut sections = vec![encode_metadata(&meta, settings)?];
    sections.extend(encode_medium(&fields.medium, settings));
    sections.extend(base_sections);
    Ok(EncodedSpecies { meta, sections, report: Some(report), dropped: Vec::new() })
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

/// The bases in ascending order, once their shapes and values fit.
fn check_fields(fields: &SpeciesFields) -> Result<Vec<&(u8, Field)>, PackError> {
    let name = &fields.meta.name;
    let shape = |what: String, found: String, expected: String| {
        let species = name.clone();
        Err(PackError::Shape { species, what, found, expected })
    };
    let mut bases: Vec<&(u8, Field)> = fields.bases.iter().collect();
    bases.sort_by_key(|(base, _)| *base);
    if bases.is_empty() {
        return shape("number of bases".into(), "0".into(), "1 to 19".into());
    }
    if let Some(pair) = bases.windows(2).find(|pair| pair[0].0 == pair[1].0) {
        return shape(format!("base {}", pair[0].0), "given twice".into(), "given once".into());
    }
    let (lattice, bands) = (fields.meta.grid.lattice, fields.meta.optics.bands.len() as u32);
    for (base, field) in &bases {
        if *base > 18 {
            return shape("base".into(), base.to_string(), "0 to 18".into());
        }
        let found = (field.lattice, field.bands, field.values.len());
        let expected = (lattice, bands, fields.meta.grid.sites() * bands as usize);
        if found != expected {
            let what = format!("(lattice, bands, values) of base {base}");
            return shape(what, format!("{found:?}"), format!("{expected:?}"));
        }
    }
    let left_out = fields.meta.left_out.as_ref().map_or(BaseSet::NONE, |left_out| left_out.bases);
    if let Some((base, _)) = bases.iter().find(|(base, _)| left_out.contains(*base)) {
        return shape(format!("base {base}"), "given".into(), "none, as the metadata leave it out".into());
    }
    bases.par_iter().try_for_each(|(base, field)| {
        let bad = |value: &f32| !matches!(value.abs().partial_cmp(&MAX_MAGNITUDE), Some(o) if o.is_le());
        match field.values.iter().position(bad) {
            None => Ok(()),
            Some(i) => {
                let sites = fields.meta.grid.sites();
                let (species, band, site) = (name.clone(), (i / sites) as u32, i % sites);
                Err(PackError::FieldValue { species, base: *base, band, site, found: field.values[i] })
            }
        }
    })?;
    Ok(bases)
}

fn check_medium(fields: &SpeciesFields) -> Result<(), PackError> {
    let (medium, species) = (&fields.medium, || fields.meta.name.clone());
    if medium.grid != fields.meta.grid {
        return Err(PackError::Shape {
            species: species(),
            what: "the medium's grid".into(),
            found: format!("{:?}", medium.grid),
            expected: format!("{:?}, as in the metadata", fields.meta.grid),
        });
    }
    let sites = medium.grid.sites();
    let arrays = [
        ("density", &medium.density, 1.0),
        ("leaf area density", &medium.leaf_area_density, MAX_MAGNITUDE),
        ("wood area density", &medium.wood_area_density, MAX_MAGNITUDE),
    ];
    for (array, values, most) in arrays {
        if values.len() != sites || medium.class.len() != sites {
            let (found, expected) = (values.len().min(medium.class.len()), sites.to_string());
            let what = format!("length of {array} or class");
            return Err(PackError::Shape { species: species(), what, found: found.to_string(), expected });
        }
        if let Some(site) = values.iter().position(|value| !(0.0..=most).contains(value)) {
            let found = values[site].to_string();
            let expected = if most == 1.0 { "0 to 1" } else { "0 to 2^96" };
            return Err(PackError::MediumValue { species: species(), array, site, found, expected });
        }
    }
    let empty_without_density =
        |site: &usize| (medium.class[*site] == Class::Empty) == (medium.density[*site] == 0.0);
    if let Some(site) = (0..sites).find(|site| !empty_without_density(site)) {
        let found = format!("{:?} at density {}", medium.class[site], medium.density[site]);
        let expected = "Empty exactly where the density is 0";
        return Err(PackError::MediumValue { species: species(), array: "class", site, found, expected });
    }
    Ok(())
}

/// The metadata with the settings that shape the coded bytes, and the error that they made; those of an
/// earlier coding go.
fn with_settings(meta: &SpeciesMeta, settings: &EncodeSettings, report: &CodingReport) -> SpeciesMeta {
    let mut meta = meta.clone();
    let earlier_psnr_db = meta.settings.get("encode.surface_psnr_db").and_then(|db| db.as_f64());
    meta.settings.retain(|key, _| !key.starts_with("encode."));
    let mut set = |key: &str, value: serde_json::Value| {
        meta.settings.insert(format!("encode.{key}"), value);
    };
    set("codec", settings.codec.name().into());
    set("compress", settings.compress.into());
    set("page_bytes", settings.page_bytes.into());
    if settings.codec == Codec::HaarPaper {
        // The shortest decimal of the f32, not the long one of its double.
        let shortest: f64 = settings.threshold.to_string().parse().expect("a float's text is a float");
        set("threshold", shortest.into());
    }
    // A copied species is not decoded, and still can say what it lost. Null: no sample has an error.
    let psnr_db = combined_psnr_db(earlier_psnr_db, report.surface_psnr_db);
    set("surface_psnr_db", psnr_db.map(|db| libm::round(db * 1e3) / 1e3).into());
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

fn encode_medium(medium: &Medium, settings: &EncodeSettings) -> Vec<EncodedSection> {
    let class: Vec<u8> = medium.class.iter().map(|class| *class as u8).collect();
    let lattice = medium.grid.lattice;
    let array = |item: u32, codec, pages| EncodedSection {
        lattice,
        bands: 1,
        ..section(KIND_MEDIUM, item, codec, settings, pages)
    };
    vec![
        array(0, CODEC_SPARSE_F32, sparse_pages(&medium.density, settings)),
        array(1, CODEC_SPARSE_U8, sparse_pages(&class, settings)),
        array(2, CODEC_SPARSE_F32, sparse_pages(&medium.leaf_area_density, settings)),
        array(3, CODEC_SPARSE_F32, sparse_pages(&medium.wood_area_density, settings)),
    ]
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
    field: &Field,
    settings: &EncodeSettings,
    points: &[u32],
) -> (EncodedSection, quality::BaseReport) {
    let (pages, error) = match settings.codec {
        Codec::RawF32 => (raw_pages(field, settings), quality::SurfaceError::exact(points, field)),
        Codec::HaarPaper => {
            let threshold = payload::absolute_threshold(base, settings.threshold);
            let blocks = block_pages(field, threshold, settings.page_bytes);
            let error = quality::SurfaceError::of_blocks(points, field, &blocks);
            let pages = blocks
                .into_iter()
                .map(|page| store(page.masks.len() as u32, page.to_bytes(), settings.compress));
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
    let report = quality::BaseReport::new(base, field.values.len() as u64 * 4, coded_bytes, error);
    (coded, report)
}

fn raw_pages(field: &Field, settings: &EncodeSettings) -> Vec<EncodedPage> {
    let page = |values: &[f32]| {
        let mut bytes = Vec::with_capacity(values.len() * 4);
        payload::encode_raw(values, &mut bytes);
        store(values.len() as u32, bytes, settings.compress)
    };
    field.values.chunks(settings.page_bytes as usize / 4).map(page).collect()
}

/// As many blocks per page as fit, in `[z][y][x]` order.
fn block_pages(field: &Field, threshold: f32, page_bytes: u32) -> Vec<BlockPage> {
    let bands = field.bands as usize;
    let per_axis = block::blocks_per_axis(field.lattice);
    let mut texels = vec![0.0; block::TEXELS * bands];
    let mut coefficients = Vec::with_capacity(texels.len());
    let mut pages = Vec::new();
    let (mut page, mut bytes) = (BlockPage::default(), 0);
    for b in 0..per_axis.pow(3) {
        let at = [b % per_axis, b / per_axis % per_axis, b / (per_axis * per_axis)];
        block::gather(field, at, &mut texels);
        coefficients.clear();
        let mask = block::encode(&texels, bands, threshold, &mut coefficients);
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
            return EncodedPage { count, raw_bytes, compression: STORED_ZSTD, stored: frame };
        }
    }
    EncodedPage { count, raw_bytes, compression: STORED_PLAIN, stored: payload }
}
