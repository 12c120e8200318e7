//! One base in memory, and a point to sample bases at.
//!
//! Blocks near geometry stay as they are coded and are sampled from their bits ([`flb_format::blocks`]). The codecs
//! that hold a whole base are decoded when it is read: blocks of `haar-paper` to their masks and coefficients, whose
//! sum times weights is a sample ([`flb_format::sample`]); raw values to f32 (those of 16 bits are widened), bands side
//! by side, so that a sample touches four pairs of neighbours. Sampling does no input, takes no lock and cannot fail.

use std::sync::Arc;

use flb_format::blocks::{CodedBase, Shared, SpeciesPoint};
use flb_format::container::records::MAX_BANDS;
use flb_format::error::Place;
use flb_format::sample::{BlockPoint, Weights, locate};
use flb_format::{Codec, Field, FormatError, room};

use crate::Library;

/// One base in memory.
#[derive(Debug, Clone)]
pub(crate) enum Base {
    /// Blocks near geometry, as they are coded.
    Near(Arc<CodedBase>),
    /// Of the codec `haar-paper`.
    Blocks {
        /// `[block]`, `[z][y][x]`, x fastest.
        blocks: Vec<Block>,
        /// `[kept][band]` of all blocks, one after the other.
        coefficients: Vec<f32>,
    },
    /// `[z][y][x][band]`
    Texels(Vec<f32>),
}

/// A block of `haar-paper`.
#[derive(Debug, Clone, Copy)]
pub(crate) struct Block {
    mask: u64,
    /// First coefficient, in units of `bands` floats. Fits: the largest lattice keeps 85^3 x 64 < 2^26.
    first: u32,
}

impl Base {
    /// Memory that it takes, what near geometry shares left out.
    pub(crate) fn size_bytes(&self) -> usize {
        match self {
            Base::Near(coded) => coded.size_bytes(),
            Base::Blocks { blocks, coefficients } => {
                size_of_val(&blocks[..]) + size_of_val(&coefficients[..])
            }
            Base::Texels(texels) => size_of_val(&texels[..]),
        }
    }

    /// As it is coded, near geometry.
    pub(crate) fn coded(&self) -> Option<&CodedBase> {
        match self {
            Base::Near(coded) => Some(coded),
            Base::Blocks { .. } | Base::Texels(_) => None,
        }
    }

    /// Whether the detail of every block is there.
    pub(crate) fn is_whole(&self) -> bool {
        self.coded().is_none_or(CodedBase::is_whole)
    }
}

/// A point at which bases are sampled. What several of them need is found once.
pub(crate) struct SamplePoint<'a> {
    lattice: u32,
    /// In lattice coordinates.
    point: [f64; 3],
    near: Option<SpeciesPoint<'a>>,
    whole: Option<InBlock>,
}

/// Where a point lies in its block of a base that covers the lattice.
struct InBlock {
    place: BlockPoint,
    /// Index of the block in its base.
    block: u32,
    weights: Weights,
}

impl InBlock {
    fn of(lattice: u32, point: [f64; 3]) -> InBlock {
        let place = locate(lattice, point);
        InBlock { block: place.block_index(lattice), weights: Weights::at(place.local), place }
    }
}

impl<'a> SamplePoint<'a> {
    /// A point in coordinates of the lattice.
    pub(crate) fn new(lattice: u32, point: [f64; 3]) -> SamplePoint<'a> {
        SamplePoint { lattice, point, near: None, whole: None }
    }

    /// Adds `factor` times the sample of a base; one whose factor is 0 is not touched.
    #[inline]
    pub(crate) fn add(&mut self, base: &'a Base, factor: f32, out: &mut [f32]) {
        if factor == 0.0 {
            return;
        }
        let point = self.point;
        match base {
            Base::Near(coded) => {
                let mut light = [0.0; MAX_BANDS as usize];
                let light = &mut light[..out.len()];
                // Bases that were read before and after their block map was dropped for a while do not share it.
                let near = match &mut self.near {
                    Some(near) if near.is_among(coded.shared()) => near,
                    near => near.insert(SpeciesPoint::new(coded.shared(), point)),
                };
                coded.sample_at(near, light);
                out.iter_mut().zip(light).for_each(|(out, light)| *out += factor * *light);
            }
            Base::Blocks { blocks, coefficients } => {
                let whole = self.whole.get_or_insert_with(|| InBlock::of(self.lattice, point));
                let block = blocks[whole.block as usize];
                let kept = &coefficients[block.first as usize * out.len()..];
                whole.weights.add(block.mask, kept, factor, out);
            }
            Base::Texels(texels) => {
                let whole = self.whole.get_or_insert_with(|| InBlock::of(self.lattice, point));
                add_texels(texels, self.lattice, &whole.place, factor, out);
            }
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
pub(crate) fn read_base(
    library: &Library,
    species: usize,
    base: u8,
    shared: Option<&Arc<Shared>>,
) -> Result<Base, FormatError> {
    let (container, source) = (library.container(), library.source());
    let entry = container.find_base(species, base).ok_or(FormatError::NoBase { species, base })?;
    if let Some(shared) = shared {
        return Ok(Base::Near(Arc::new(container.read_coded_base(source, species, base, shared)?)));
    }
    if entry.codec != Codec::HaarPaper {
        let section = &container.sections()[entry.section];
        let place = Place::section(section.data_offset, section.key);
        let field = container.read_field(source, species, base)?;
        let texels = room::filled(place, "a field", 0.0, field.len())?;
        return Ok(Base::Texels(interleaved(&field, texels)));
    }
    let bands = container.species()[species].meta.band_count();
    let pages = container.pages(entry.section);
    // Both sizes are of pages that the container has checked against the file's length and its limits.
    let section = &container.sections()[entry.section];
    let place = Place::section(section.data_offset, section.key);
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
    Ok(Base::Blocks { blocks, coefficients })
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
