//! The bases of one species in memory, sampled at points of model space.
//!
//! Coded bases stay coded: a sample finds its block by arithmetic, reads that block's mask and the place of its
//! coefficients from one array, and sums coefficients times weights ([`flb_format::sample`]); blocks near geometry are
//! sampled from their bits ([`flb_format::blocks`]). Raw bases are kept as f32 (those of 16 bits are widened), bands
//! side by side, so that a sample touches four pairs of neighbours. Everything is read and verified at loading;
//! sampling does no input, takes no lock and cannot fail.

use std::path::Path;
use std::sync::Arc;

use flb_format::FormatError;
use flb_format::beam::MOST_MEANS;
use flb_format::blocks::{CodedBase, Shared, SpeciesPoint};
use flb_format::container::Species;
use flb_format::container::records::{Codec, MAX_BANDS};
use flb_format::sample::{BlockPoint, Weights, locate};
use flb_format::sun::SunBlend;
use flb_format::{Field, Grid, room};

use crate::{Library, RuntimeError, SunTerms};

/// One species, ready to be sampled from any number of threads.
pub struct SpeciesSampler {
    grid: Grid,
    bands: usize,
    /// What bases of blocks near geometry share.
    shared: Option<Arc<Shared>>,
    /// `[base]`, up to the last that was asked for; `None` where the base was not.
    bases: Vec<Option<Light>>,
}

/// One base in memory.
enum Light {
    Blocks {
        /// `[block]`, `[z][y][x]`, x fastest.
        blocks: Vec<Block>,
        /// `[kept][band]` of all blocks, one after the other.
        coefficients: Vec<f32>,
    },
    /// `[z][y][x][band]`
    Texels(Vec<f32>),
    /// Blocks near geometry, as they are coded.
    Near(Box<CodedBase>),
}

#[derive(Clone, Copy)]
struct Block {
    mask: u64,
    /// First coefficient, in units of `bands` floats. Fits: the largest lattice keeps 85^3 x 64 < 2^26.
    first: u32,
}

/// The bases that [`SpeciesSampler::indirect`] will ask for, each once, ascending: those of the blend that
/// have weight, and base 0 if there is ambient light.
pub fn bases_needed(blend: &SunBlend, ambient: bool) -> Vec<u8> {
    let sun =
        blend.bases.iter().zip(blend.weights).filter(|(_, weight)| *weight != 0.0).map(|(base, _)| *base);
    let mut bases: Vec<u8> = ambient.then_some(0).into_iter().chain(sun).collect();
    bases.sort_unstable();
    bases.dedup();
    bases
}

impl SpeciesSampler {
    /// Reads, verifies and keeps the given bases of a species of the model `paper` (repeats are ignored).
    ///
    /// # Errors
    /// [`RuntimeError::NoSuchSpecies`]; [`RuntimeError::OtherModel`]; for the first base that the file does not hold
    /// (before any page is read) [`RuntimeError::LeftOut`] if the file says so, else [`RuntimeError::MissingBase`];
    /// [`RuntimeError::Format`] for a page that fails its checks.
    pub fn load(library: &Library, species: usize, bases: &[u8]) -> Result<SpeciesSampler, RuntimeError> {
        let entry = known_species(library, species)?;
        if entry.meta.optics().is_none() {
            return Err(other_model(library, entry, "paper"));
        }
        SpeciesSampler::load_items(library, species, bases)
    }

    /// The same for a species of either model: what its bases mean is the caller's to know.
    pub(crate) fn load_items(
        library: &Library,
        species: usize,
        bases: &[u8],
    ) -> Result<SpeciesSampler, RuntimeError> {
        let (container, entry) = (library.container(), known_species(library, species)?);
        if let Some(missing) = bases.iter().find(|base| container.find_base(species, **base).is_none()) {
            return Err(no_base(library.path(), entry, *missing));
        }
        let at_library =
            |source| RuntimeError::Format { path: library.path().to_owned(), source: Box::new(source) };
        let shared = match entry.blocks {
            Some(_) if !bases.is_empty() => {
                Some(container.read_shared(library.source(), species).map_err(at_library)?)
            }
            _ => None,
        };
        let (grid, bands) = (entry.meta.grid, entry.meta.band_count());
        let mut sampler = SpeciesSampler { grid, bands, shared, bases: Vec::new() };
        for &base in bases {
            let at = usize::from(base);
            if sampler.bases.len() <= at {
                sampler.bases.resize_with(at + 1, || None);
            }
            if sampler.bases[at].is_none() {
                let light = read_light(library, species, base, sampler.shared.as_ref());
                sampler.bases[at] = Some(light.map_err(at_library)?);
            }
        }
        Ok(sampler)
    }

    /// Where the lattice lies in model space.
    pub fn grid(&self) -> &Grid {
        &self.grid
    }

    /// Values per sample.
    pub fn bands(&self) -> usize {
        self.bands
    }

    /// Whether a base was loaded.
    pub fn has_base(&self, base: u8) -> bool {
        self.bases.get(base as usize).is_some_and(Option::is_some)
    }

    /// Memory that the loaded bases take.
    pub fn size_bytes(&self) -> usize {
        let size = |light: &Light| match light {
            Light::Blocks { blocks, coefficients } => {
                size_of_val(&blocks[..]) + size_of_val(&coefficients[..])
            }
            Light::Texels(texels) => size_of_val(&texels[..]),
            Light::Near(coded) => coded.size_bytes(),
        };
        // What bases share is counted once.
        let shared = self.shared.as_ref().map_or(0, |shared| shared.size_bytes());
        self.bases.iter().flatten().map(size).sum::<usize>() + shared
    }

    /// phi of one base at a point of model space, trilinear, one value per band. Points outside the lattice
    /// take the value of the nearest point of it; a coordinate that is NaN counts as the lower end.
    ///
    /// # Panics
    /// If the base was not loaded or `out` is shorter than the bands.
    pub fn sample(&self, base: u8, point_model_m: [f32; 3], out: &mut [f32]) {
        let out = &mut out[..self.bands];
        out.fill(0.0);
        self.at(point_model_m).add(base, 1.0, out);
    }

    /// `sun * sum_k w_k B_k + ambient * B_0` at a point of model space (lighting model, section 6), one value
    /// per band. Bases whose factor is 0 are neither needed nor touched: [`bases_needed`].
    ///
    /// # Panics
    /// If a base with a factor other than 0 was not loaded, or `out` is shorter than the bands.
    pub fn indirect(
        &self,
        blend: &SunBlend,
        sun: f32,
        ambient: f32,
        point_model_m: [f32; 3],
        out: &mut [f32],
    ) {
        let out = &mut out[..self.bands];
        out.fill(0.0);
        let at = self.at(point_model_m);
        for (base, weight) in blend.bases.into_iter().zip(blend.weights) {
            at.add(base, sun * weight, out);
        }
        at.add(0, ambient, out);
    }

    /// `sun` times the light of a sun of these terms and means of its near beam, plus `sky` times that of base 0. May
    /// be below 0. `out` is as long as the bands.
    ///
    /// The order of the sum is that of all files' pictures: the sun's bases, its near beam, the sky. Streamed light is
    /// added up with the sky before the near beam ([`crate::resident::ResidentSpecies::sum`]); both orders are kept, as
    /// another one rounds otherwise.
    pub(crate) fn sum(
        &self,
        terms: &SunTerms,
        near: [f32; MOST_MEANS],
        [sun, sky]: [f32; 2],
        point_model_m: [f32; 3],
        out: &mut [f32],
    ) {
        out.fill(0.0);
        let at = self.at(point_model_m);
        terms.bases().for_each(|(base, factor)| at.add(base, sun * factor, out));
        terms.near_bases().zip(near).for_each(|(base, near)| at.add(base, sun * near, out));
        at.add(0, sky, out);
    }

    /// A base that is kept as it is coded, near geometry.
    pub(crate) fn coded(&self, base: u8) -> Option<&CodedBase> {
        match self.bases.get(usize::from(base))? {
            Some(Light::Near(coded)) => Some(coded),
            _ => None,
        }
    }

    pub(crate) fn at(&self, point_model_m: [f32; 3]) -> SamplePoint<'_> {
        let lattice = self.grid.lattice;
        let point = self.grid.lattice_from_model(point_model_m.map(f64::from));
        let place = locate(lattice, point);
        SamplePoint {
            sampler: self,
            block: place.block_index(lattice),
            weights: Weights::at(place.local),
            place,
            near: self.shared.as_ref().map(|shared| SpeciesPoint::new(shared, point)),
        }
    }
}

pub(crate) fn known_species(library: &Library, index: usize) -> Result<&Species, RuntimeError> {
    let all = library.container().species();
    let path = || library.path().to_owned();
    all.get(index).ok_or_else(|| RuntimeError::NoSuchSpecies { path: path(), index, count: all.len() })
}

pub(crate) fn other_model(library: &Library, species: &Species, expected: &'static str) -> RuntimeError {
    let (name, found) = (species.meta.name.clone(), species.meta.model.name());
    RuntimeError::OtherModel { path: library.path().to_owned(), species: name, found, expected }
}

/// Why a species has no such base.
pub(crate) fn no_base(path: &Path, species: &Species, base: u8) -> RuntimeError {
    let (path, name) = (path.to_owned(), species.meta.name.clone());
    match species.meta.left_out.as_ref().filter(|left_out| left_out.bases.contains(base)) {
        Some(left_out) => {
            RuntimeError::LeftOut { path, species: name, base, reason: left_out.reason.clone() }
        }
        None => {
            let available = species.bases.iter().map(|b| b.base).collect();
            RuntimeError::MissingBase { path, species: name, base, available }
        }
    }
}

/// What a sample of any base needs to know about its point.
pub(crate) struct SamplePoint<'a> {
    sampler: &'a SpeciesSampler,
    place: BlockPoint,
    /// Index of the block in its base.
    block: u32,
    weights: Weights,
    /// Among blocks near geometry, where the bases have them.
    near: Option<SpeciesPoint<'a>>,
}

impl SamplePoint<'_> {
    /// Adds `factor` times the sample of a base.
    #[inline]
    pub(crate) fn add(&self, base: u8, factor: f32, out: &mut [f32]) {
        if factor == 0.0 {
            return;
        }
        match self.sampler.bases.get(base as usize) {
            Some(Some(Light::Blocks { blocks, coefficients })) => {
                let block = blocks[self.block as usize];
                let kept = &coefficients[block.first as usize * out.len()..];
                self.weights.add(block.mask, kept, factor, out);
            }
            Some(Some(Light::Texels(texels))) => {
                add_texels(texels, self.sampler.grid.lattice, &self.place, factor, out)
            }
            Some(Some(Light::Near(coded))) => {
                let mut light = [0.0; MAX_BANDS as usize];
                let light = &mut light[..out.len()];
                coded.sample_at(self.near.as_ref().expect("blocks near geometry"), light);
                out.iter_mut().zip(light).for_each(|(out, light)| *out += factor * *light);
            }
            _ => panic!("base {base} was not loaded"),
        }
    }
}

/// Adds `factor` times the trilinear sample of `[z][y][x][band]` texels.
fn add_texels(texels: &[f32], lattice: u32, place: &BlockPoint, factor: f32, out: &mut [f32]) {
    let (n, bands) = (lattice as usize, out.len());
    let mut first = [0; 3];
    let mut weight = [[0.0; 2]; 3];
    for axis in 0..3 {
        let start = place.block[axis] as usize * flb_format::block::STRIDE;
        let inside = (place.local[axis] as usize).min(n - 2 - start).min(flb_format::block::STRIDE - 1);
        first[axis] = start + inside;
        let t = place.local[axis] - inside as f32;
        weight[axis] = [1.0 - t, t];
    }
    for (z, y) in [(0, 0), (0, 1), (1, 0), (1, 1)] {
        let row = (((first[2] + z) * n + first[1] + y) * n + first[0]) * bands;
        let along = factor * weight[2][z] * weight[1][y];
        let (left, right) = texels[row..row + 2 * bands].split_at(bands);
        for (band, value) in out.iter_mut().enumerate() {
            *value += along * (weight[0][0] * left[band] + weight[0][1] * right[band]);
        }
    }
}

/// Reads one base that the container has, every page verified.
fn read_light(
    library: &Library,
    species: usize,
    base: u8,
    shared: Option<&Arc<Shared>>,
) -> Result<Light, FormatError> {
    let (container, source) = (library.container(), library.source());
    let entry = container.find_base(species, base).ok_or(FormatError::NoBase { species, base })?;
    if let Some(shared) = shared {
        return Ok(Light::Near(Box::new(container.read_coded_base(source, species, base, shared)?)));
    }
    if entry.codec != Codec::HaarPaper {
        let section = &container.sections()[entry.section];
        let place = flb_format::Place::section(section.data_offset, section.key);
        let field = container.read_field(source, species, base)?;
        let texels = room::filled(place, "a field", 0.0, field.values.len())?;
        return Ok(Light::Texels(interleaved(&field, texels)));
    }
    let bands = container.species()[species].meta.band_count();
    let pages = container.pages(entry.section);
    // Both sizes are of pages that the container has checked against the file's length and its limits.
    let section = &container.sections()[entry.section];
    let place = flb_format::Place::section(section.data_offset, section.key);
    let mut blocks =
        room::empty(place, "blocks of a base", pages.iter().map(|page| page.count as usize).sum())?;
    let mut coefficients = Vec::new();
    // A list that grows is copied to one of twice its length.
    room::ask(
        place,
        "values of a base",
        2 * pages.iter().map(|page| u64::from(page.raw_bytes)).sum::<u64>(),
    )?;
    for page in 0..pages.len() as u32 {
        let page = container.read_block_page(source, entry.section, page)?;
        let before = (coefficients.len() / bands) as u32;
        blocks.extend(page.masks.iter().zip(&page.index).map(|(&mask, i)| Block { mask, first: before + i }));
        coefficients.extend_from_slice(&page.coefficients);
    }
    coefficients.shrink_to_fit();
    Ok(Light::Blocks { blocks, coefficients })
}

/// `[band][z][y][x]` to `[z][y][x][band]`.
fn interleaved(field: &Field, mut texels: Vec<f32>) -> Vec<f32> {
    let bands = field.bands as usize;
    for band in 0..bands {
        for (site, value) in field.band(band as u32).iter().enumerate() {
            texels[site * bands + band] = *value;
        }
    }
    texels
}

#[cfg(test)]
mod tests;
