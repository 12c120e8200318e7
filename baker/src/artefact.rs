//! Stage artefacts: what a stage made, as bytes that the same build reads back from a cache folder, and the
//! key under which to look for them.
//!
//! ```text
//! magic 8 | schema u32 | kind u32 | BLAKE3 of the key and the payload 32 | payload (rkyv)
//! ```
//!
//! The key is under the digest, so that an artefact copied or renamed to the name of another is refused.
//!
//! Bytes are trusted in no respect: magic, schema, kind and digest first, then rkyv's own validation, then
//! what a value must be (lengths, ranges, finite numbers), for a cache can pass its byte check and still lie.
//! The layout is private to a build: any change of it, or of what a stage computes, raises [`SCHEMA`]. The
//! public format is `.flb`.

use flb_format::field::{CellBand, Cells};
use flb_format::matter::Class;
use flb_format::{Field, Grid, Medium};
use rkyv::api::high::{HighDeserializer, HighSerializer, HighValidator};
use rkyv::bytecheck::CheckBytes;
use rkyv::rancor::Error as RkyvError;
use rkyv::ser::allocator::ArenaHandle;
use rkyv::util::AlignedVec;
use rkyv::{Archive, Deserialize, Serialize};

use crate::voxelise::{Cluster, LATTICES, Occupancy, SiteArea, VoxelError};

mod physical;
#[cfg(test)]
mod tests;

pub use physical::LightArtefact;
#[doc(hidden)]
pub use physical::{StoredCrown, StoredLight, StoredReport};

/// Version of the artefacts' layout and of what the stages compute. Part of every header and key.
pub const SCHEMA: u32 = 21;

const MAGIC: [u8; 8] = *b"FLBSTAGE";
/// Bytes before the payload; a multiple of 16, so that an aligned file has an aligned payload.
const HEADER: usize = 48;
/// Most bands of a field.
const MAX_BANDS: u32 = 64;

/// Bytes that are not the artefact asked for.
#[derive(Debug, Clone, PartialEq, thiserror::Error)]
#[non_exhaustive]
pub enum ArtefactError {
    /// Fewer bytes than the header.
    #[error("artefact of {found} bytes: the header alone has {HEADER}")]
    Short {
        /// Bytes found.
        found: usize,
    },
    /// The bytes are no artefact.
    #[error("artefact begins with {found:02x?}, expected {MAGIC:02x?}")]
    Magic {
        /// First bytes that were read.
        found: [u8; 8],
    },
    /// Written by another build.
    #[error("artefact of schema {found}, expected {SCHEMA}")]
    Schema {
        /// Schema found.
        found: u32,
    },
    /// Artefact of another stage.
    #[error("artefact of kind {found}, expected {expected}")]
    Kind {
        /// Kind found.
        found: u32,
        /// Kind asked for.
        expected: u32,
    },
    /// Damaged, or the artefact of another key.
    #[error("artefact's key and payload have digest {found}, its header says {expected}")]
    Digest {
        /// Digest of key and payload.
        found: String,
        /// Digest in the header.
        expected: String,
    },
    /// rkyv's validation or serialisation failed.
    #[error("artefact's payload: {0}")]
    Layout(String),
    /// The value contradicts itself.
    #[error("artefact: {place}: {fault}")]
    Value {
        /// Part of the value.
        place: String,
        /// Value that was found, and what was expected.
        fault: String,
    },
    /// An occupancy contradicts itself.
    #[error("artefact: {0}")]
    Occupancy(#[from] VoxelError),
}

/// A value that can be stored: implemented for [`Occupancy`], [`Medium`], [`Crown`](crate::crown::Crown), one base's
/// ([`BaseArtefact`]) and all bases' fields, and how `physical` ones were solved ([`LightArtefact`]).
pub trait Artefact: Sized {
    /// Number of the kind in the header.
    #[doc(hidden)]
    const KIND: u32;
    #[doc(hidden)]
    type Stored: Archive<
            Archived: for<'a> CheckBytes<HighValidator<'a, RkyvError>>
                          + Deserialize<Self::Stored, HighDeserializer<RkyvError>>,
        > + for<'a> Serialize<HighSerializer<AlignedVec, ArenaHandle<'a>, RkyvError>>;
    #[doc(hidden)]
    fn store(&self) -> Self::Stored;
    #[doc(hidden)]
    fn restore(stored: Self::Stored) -> Result<Self, ArtefactError>;
}

/// The fields of a solution, by base: `(base, field)`.
pub type BaseArtefact = (u8, Field);

/// An artefact as the bytes that are kept under a key.
///
/// # Errors
/// Only if rkyv cannot serialise it.
pub fn to_bytes<A: Artefact>(artefact: &A, key: &str) -> Result<Vec<u8>, ArtefactError> {
    let payload = payload_of(artefact)?;
    let mut bytes = Vec::with_capacity(HEADER + payload.len());
    bytes.extend_from_slice(&MAGIC);
    bytes.extend_from_slice(&SCHEMA.to_le_bytes());
    bytes.extend_from_slice(&A::KIND.to_le_bytes());
    bytes.extend_from_slice(seal(key, &payload).as_bytes());
    bytes.extend_from_slice(&payload);
    Ok(bytes)
}

/// The digest of what a stage made, for the keys of what is made from it.
///
/// # Errors
/// As [`to_bytes`].
pub fn digest<A: Artefact>(artefact: &A) -> Result<[u8; 32], ArtefactError> {
    Ok(*blake3::hash(&payload_of(artefact)?).as_bytes())
}

fn payload_of<A: Artefact>(artefact: &A) -> Result<AlignedVec, ArtefactError> {
    rkyv::to_bytes::<RkyvError>(&artefact.store()).map_err(|error| ArtefactError::Layout(error.to_string()))
}

/// BLAKE3 of the key and what is kept under it.
fn seal(key: &str, payload: &[u8]) -> blake3::Hash {
    let mut hasher = blake3::Hasher::new_derive_key("flb stage artefact");
    hasher.update(&(key.len() as u64).to_le_bytes()).update(key.as_bytes()).update(payload);
    hasher.finalize()
}

/// The artefact of a key, in a slice of any alignment.
///
/// # Errors
/// Whatever differs from what [`to_bytes`] writes, in the order of the module's description.
pub fn from_bytes<A: Artefact>(bytes: &[u8], key: &str) -> Result<A, ArtefactError> {
    let payload = checked_payload(bytes, Some(A::KIND), key)?;
    let layout = |error: RkyvError| ArtefactError::Layout(error.to_string());
    let is_aligned = payload.as_ptr().addr() % 16 == 0;
    let stored = if is_aligned {
        rkyv::from_bytes::<A::Stored, RkyvError>(payload).map_err(layout)?
    } else {
        let mut aligned = AlignedVec::<16>::with_capacity(payload.len());
        aligned.extend_from_slice(payload);
        rkyv::from_bytes::<A::Stored, RkyvError>(&aligned).map_err(layout)?
    };
    A::restore(stored)
}

/// Checks bytes that were kept under a key, of an artefact of any kind: that they are those that were written.
///
/// # Errors
/// All errors of [`from_bytes`] but those of kind, layout and value.
pub fn check(bytes: &[u8], key: &str) -> Result<(), ArtefactError> {
    checked_payload(bytes, None, key).map(drop)
}

/// `kind`: the expected one, where one is.
fn checked_payload<'b>(bytes: &'b [u8], kind: Option<u32>, key: &str) -> Result<&'b [u8], ArtefactError> {
    if bytes.len() < HEADER {
        return Err(ArtefactError::Short { found: bytes.len() });
    }
    let (header, payload) = bytes.split_at(HEADER);
    let u32_at = |at: usize| u32::from_le_bytes(header[at..at + 4].try_into().expect("4 bytes"));
    let magic: [u8; 8] = header[..8].try_into().expect("8 bytes");
    if magic != MAGIC {
        return Err(ArtefactError::Magic { found: magic });
    }
    if u32_at(8) != SCHEMA {
        return Err(ArtefactError::Schema { found: u32_at(8) });
    }
    if let Some(expected) = kind.filter(|kind| u32_at(12) != *kind) {
        return Err(ArtefactError::Kind { found: u32_at(12), expected });
    }
    let expected = blake3::Hash::from_bytes(header[16..].try_into().expect("32 bytes"));
    let found = seal(key, payload);
    if found != expected {
        return Err(ArtefactError::Digest { found: found.to_string(), expected: expected.to_string() });
    }
    Ok(payload)
}

/// The key of a stage's artefact: BLAKE3, as 64 hexadecimal digits, of schema, tool version, stage, settings
/// and inputs (digests or keys of earlier stages), each with its length before it, so that no two lists
/// read the same.
pub fn key(stage: &str, inputs: &[&[u8]], settings: &str) -> String {
    let mut hasher = blake3::Hasher::new_derive_key("flb stage artefact key");
    hasher.update(&SCHEMA.to_le_bytes());
    let head = [env!("CARGO_PKG_VERSION").as_bytes(), stage.as_bytes(), settings.as_bytes()];
    for part in head.into_iter().chain(inputs.iter().copied()) {
        hasher.update(&(part.len() as u64).to_le_bytes());
        hasher.update(part);
    }
    hasher.finalize().to_hex().to_string()
}

#[derive(Archive, Serialize, Deserialize)]
struct StoredGrid {
    lattice: u32,
    origin_m: [f64; 3],
    spacing_m: f64,
}

impl StoredGrid {
    fn store(grid: &Grid) -> StoredGrid {
        let &Grid { lattice, origin_m, spacing_m } = grid;
        StoredGrid { lattice, origin_m, spacing_m }
    }

    fn restore(self) -> Result<Grid, ArtefactError> {
        let StoredGrid { lattice, origin_m, spacing_m } = self;
        check_lattice("grid", lattice)?;
        let finite = spacing_m.is_finite() && origin_m.iter().all(|c| c.is_finite());
        if !finite || spacing_m <= 0.0 {
            let found = format!("origin {origin_m:?}, spacing {spacing_m}");
            return fault("grid", format!("{found}: expected finite numbers, spacing above 0"));
        }
        Ok(Grid { lattice, origin_m, spacing_m })
    }
}

#[doc(hidden)]
#[derive(Archive, Serialize, Deserialize)]
pub struct StoredOccupancy {
    grid: StoredGrid,
    voxels: u32,
    positions: Vec<[u16; 3]>,
    /// `[cluster][leaf, wood][z]`
    words: Vec<[[u64; 8]; 2]>,
    sites: Vec<u32>,
    /// `[site][leaf, wood]`
    areas: Vec<[u64; 2]>,
}

impl Artefact for Occupancy {
    const KIND: u32 = 1;
    type Stored = StoredOccupancy;

    fn store(&self) -> StoredOccupancy {
        StoredOccupancy {
            grid: StoredGrid::store(self.grid()),
            voxels: self.voxels(),
            positions: self.clusters().iter().map(|cluster| cluster.position).collect(),
            words: self.clusters().iter().map(|cluster| [cluster.leaf, cluster.wood]).collect(),
            sites: self.areas().iter().map(|area| area.site).collect(),
            areas: self.areas().iter().map(|area| [area.leaf, area.wood]).collect(),
        }
    }

    fn restore(stored: StoredOccupancy) -> Result<Occupancy, ArtefactError> {
        check_length("words", stored.words.len(), stored.positions.len())?;
        check_length("areas", stored.areas.len(), stored.sites.len())?;
        let clusters = stored.positions.into_iter().zip(stored.words);
        let clusters = clusters.map(|(position, [leaf, wood])| Cluster { position, leaf, wood }).collect();
        let areas = stored.sites.into_iter().zip(stored.areas);
        let areas = areas.map(|(site, [leaf, wood])| SiteArea { site, leaf, wood }).collect();
        Ok(Occupancy::from_parts(stored.grid.restore()?, stored.voxels, clusters, areas)?)
    }
}

#[doc(hidden)]
#[derive(Archive, Serialize, Deserialize)]
pub struct StoredMedium {
    grid: StoredGrid,
    density: Vec<f32>,
    class: Vec<u8>,
    leaf_area_density: Vec<f32>,
    wood_area_density: Vec<f32>,
}

impl Artefact for Medium {
    const KIND: u32 = 2;
    type Stored = StoredMedium;

    fn store(&self) -> StoredMedium {
        StoredMedium {
            grid: StoredGrid::store(&self.grid),
            density: self.density.clone(),
            class: self.class.iter().map(|&class| class as u8).collect(),
            leaf_area_density: self.leaf_area_density.clone(),
            wood_area_density: self.wood_area_density.clone(),
        }
    }

    fn restore(stored: StoredMedium) -> Result<Medium, ArtefactError> {
        let grid = stored.grid.restore()?;
        check_length("density", stored.density.len(), grid.sites())?;
        check_length("class", stored.class.len(), grid.sites())?;
        check_length("leaf_area_density", stored.leaf_area_density.len(), grid.sites())?;
        check_length("wood_area_density", stored.wood_area_density.len(), grid.sites())?;
        let mut class = Vec::with_capacity(grid.sites());
        for (site, &code) in stored.class.iter().enumerate() {
            let density = stored.density[site];
            class.push(match code {
                0 if density == 0.0 => Class::Empty,
                1 if density > 0.0 && density <= 1.0 => Class::Leaf,
                2 if density > 0.0 && density <= 1.0 => Class::Wood,
                _ => return fault(&format!("site {site}"), format!("class {code} with density {density}")),
            });
            for area in [stored.leaf_area_density[site], stored.wood_area_density[site]] {
                if !(area >= 0.0 && area.is_finite()) || (code == 0 && area > 0.0) {
                    return fault(&format!("site {site}"), format!("class {code} with area density {area}"));
                }
            }
        }
        let StoredMedium { density, leaf_area_density, wood_area_density, .. } = stored;
        Ok(Medium { grid, density, class, leaf_area_density, wood_area_density })
    }
}

#[doc(hidden)]
#[derive(Archive, Serialize, Deserialize)]
pub struct StoredField {
    base: u8,
    lattice: u32,
    bands: u32,
    /// Runs of sites, `[z][y][x]`, that share a value: where each ends, and the number of the value. Empty where sites
    /// have values of their own.
    runs: Vec<(u32, u32)>,
    /// `[band]`, each with a value for each site, or for each number of the runs.
    values: Vec<Vec<f32>>,
}

/// One base's field: the unit to cache where memory is short.
impl Artefact for BaseArtefact {
    const KIND: u32 = 3;
    type Stored = StoredField;

    fn store(&self) -> StoredField {
        let (base, field) = self;
        let Field { lattice, bands, .. } = *field;
        let shared = field.cells().and_then(|of_bands| {
            let cells = of_bands.first()?.cells();
            of_bands.iter().all(|band| band.cells().is_same(cells)).then_some((cells, of_bands))
        });
        let (runs, values) = match shared {
            Some((cells, of_bands)) => {
                (runs(cells.of_sites()), of_bands.iter().map(|band| band.values().to_vec()).collect())
            }
            None => {
                let sites = (lattice as usize).pow(3).max(1);
                (Vec::new(), field.values().chunks(sites).map(<[f32]>::to_vec).collect())
            }
        };
        StoredField { base: *base, lattice, bands, runs, values }
    }

    fn restore(stored: StoredField) -> Result<BaseArtefact, ArtefactError> {
        let StoredField { base, lattice, bands, runs, values } = stored;
        let place = format!("base {base}");
        check_lattice(&place, lattice)?;
        if !(1..=MAX_BANDS).contains(&bands) {
            return fault(&place, format!("{bands} bands: expected 1 to {MAX_BANDS}"));
        }
        check_length(&place, values.len(), bands as usize)?;
        let sites = (lattice as usize).pow(3);
        for (band, values) in values.iter().enumerate() {
            if let Some(at) = values.iter().position(|value| !value.is_finite()) {
                let place = format!("{place}, band {band}");
                return fault(&place, format!("value {at} is {}: expected a finite number", values[at]));
            }
        }
        if runs.is_empty() {
            values.iter().try_for_each(|values| check_length(&place, values.len(), sites))?;
            return Ok((base, Field::new(lattice, bands, values.concat())));
        }
        let cells = cells(&place, &runs, sites)?;
        let least = cells.count();
        values.iter().try_for_each(|values| match values.len() >= least {
            true => Ok(()),
            false => fault(&place, format!("{} values: expected at least {least}", values.len())),
        })?;
        let of_bands = values.into_iter().map(|values| CellBand::new(cells.clone(), values));
        Ok((base, Field::of_cells(lattice, of_bands.collect())))
    }
}

/// Runs of sites with one number: where each ends, and the number.
fn runs(cells: &[u32]) -> Vec<(u32, u32)> {
    let mut runs: Vec<(u32, u32)> = Vec::new();
    for (end, &cell) in (1..).zip(cells) {
        match runs.last_mut().filter(|(_, last)| *last == cell) {
            Some((last_end, _)) => *last_end = end,
            None => runs.push((end, cell)),
        }
    }
    runs
}

/// The number of each site.
fn cells(place: &str, runs: &[(u32, u32)], sites: usize) -> Result<Cells, ArtefactError> {
    let mut cells = Vec::with_capacity(sites);
    for &(end, cell) in runs {
        if end as usize <= cells.len() || end as usize > sites {
            let expected = format!("{} to {sites}", cells.len() + 1);
            return fault(place, format!("a run that ends at site {end}: expected {expected}"));
        }
        cells.resize(end as usize, cell);
    }
    check_length(place, cells.len(), sites)?;
    Ok(Cells::new(cells))
}

/// All fields of a solution, bases ascending.
impl Artefact for Vec<BaseArtefact> {
    const KIND: u32 = 4;
    type Stored = Vec<StoredField>;

    fn store(&self) -> Vec<StoredField> {
        self.iter().map(BaseArtefact::store).collect()
    }

    fn restore(stored: Vec<StoredField>) -> Result<Vec<BaseArtefact>, ArtefactError> {
        let fields = stored.into_iter().map(BaseArtefact::restore).collect::<Result<Vec<_>, _>>()?;
        for pair in fields.windows(2) {
            let ((base, field), (next, next_field)) = (&pair[0], &pair[1]);
            if base >= next {
                return fault("fields", format!("base {base} is stored before base {next}"));
            }
            if (field.lattice, field.bands) != (next_field.lattice, next_field.bands) {
                return fault("fields", format!("bases {base} and {next} differ in lattice or bands"));
            }
        }
        Ok(fields)
    }
}

fn fault<T>(place: &str, fault: String) -> Result<T, ArtefactError> {
    Err(ArtefactError::Value { place: place.to_owned(), fault })
}

fn check_lattice(place: &str, lattice: u32) -> Result<(), ArtefactError> {
    if lattice.is_power_of_two() && (LATTICES[0]..=LATTICES[1]).contains(&lattice) {
        return Ok(());
    }
    fault(place, format!("lattice {lattice}: expected a power of two from 16 to 256"))
}

fn check_length(place: &str, found: usize, expected: usize) -> Result<(), ArtefactError> {
    if found == expected {
        return Ok(());
    }
    fault(place, format!("{found} entries: expected {expected}"))
}
