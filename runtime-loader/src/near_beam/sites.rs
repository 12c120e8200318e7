//! The sites of a medium that hold matter, for near beams that are found for all of them at once.

use flb_format::beam::{MAX_MEANS, Near};
use flb_format::error::Place;
use flb_format::light::SunBasis;
use flb_format::matter::TurbidMedium;
use flb_format::sample::{corners, locate};
use flb_format::{FormatError, room};

use super::{PreparedSun, dense, everywhere};
use crate::extinction::Extinction;
use crate::sun_terms::SunTerms;

/// No matter in a site.
const EMPTY: u32 = u32::MAX;

/// The extinction at every site, and which of them hold matter.
#[derive(Debug)]
pub(crate) struct MediumSites {
    turbid: TurbidMedium,
    /// Sites with matter, ascending.
    sites: Vec<u32>,
    /// `[site]`: place in `sites`, or [`EMPTY`].
    place: Vec<u32>,
    /// `[z][y][x]` of the blocks of 4^3: number among those with matter, or [`EMPTY`].
    blocks: Vec<u32>,
    block_count: usize,
}

/// Edge of a block, in sites.
const BLOCK: usize = 4;

/// Up to eight neighbours of a point that hold matter, with their trilinear weights.
pub(crate) struct Around<T> {
    found: [(T, f32); 8],
    count: usize,
    weight: f32,
}

impl<T: Copy> Around<T> {
    fn new(none: T) -> Around<T> {
        Around { found: [(none, 0.0); 8], count: 0, weight: 0.0 }
    }

    fn push(&mut self, one: T, weight: f32) {
        self.found[self.count] = (one, weight);
        self.count += 1;
        self.weight += weight;
    }

    /// Whether none of them counts.
    pub(crate) fn is_empty(&self) -> bool {
        self.weight <= 0.0
    }

    /// The mean of a value over them.
    pub(crate) fn mean(&self, value: impl Fn(T) -> f32) -> f32 {
        let sum: f32 = self.found[..self.count].iter().map(|(one, weight)| weight * value(*one)).sum();
        sum * (1.0 / self.weight)
    }
}

/// Sites and blocks around a point.
pub(crate) struct AroundBlocks {
    /// Place and block of each site.
    pub sites: Around<[u32; 2]>,
    pub blocks: Around<u32>,
}

impl MediumSites {
    /// Lists the sites of a medium.
    ///
    /// # Errors
    /// Where there is no memory for the lists.
    pub(crate) fn new(turbid: TurbidMedium) -> Result<MediumSites, FormatError> {
        // A list of sites that grows is copied to one of twice its length.
        room::ask(Place::file(0), "sites with matter", 8 * turbid.grid.sites() as u64)?;
        let place = room::filled(Place::file(0), "places of sites", EMPTY, turbid.grid.sites())?;
        Ok(MediumSites::listed(turbid, place))
    }

    /// Of extinction that is kept where there is some.
    pub(crate) fn of(extinction: &Extinction) -> MediumSites {
        let turbid = extinction.to_dense();
        let place = vec![EMPTY; turbid.grid.sites()];
        MediumSites::listed(turbid, place)
    }

    fn listed(turbid: TurbidMedium, mut place: Vec<u32>) -> MediumSites {
        let sites = turbid.sites();
        (0..).zip(&sites).for_each(|(at, &site)| place[site as usize] = at);
        let edge = turbid.grid.lattice as usize;
        let mut blocks = vec![EMPTY; (edge / BLOCK).pow(3)];
        let mut block_count = 0;
        for &site in &sites {
            let block = &mut blocks[block_at(edge, site as usize)];
            if *block == EMPTY {
                *block = block_count;
                block_count += 1;
            }
        }
        MediumSites { turbid, sites, place, blocks, block_count: block_count as usize }
    }

    /// The extinction, in m^-1.
    pub(crate) fn turbid(&self) -> &TurbidMedium {
        &self.turbid
    }

    /// Sites with matter, ascending.
    pub(crate) fn sites(&self) -> &[u32] {
        &self.sites
    }

    /// The place of a site among them.
    pub(crate) fn place_of(&self, site: usize) -> Option<usize> {
        Some(self.place[site]).filter(|place| *place != EMPTY).map(|place| place as usize)
    }

    /// Memory that extinction and lists take.
    pub(crate) fn size_bytes(&self) -> usize {
        self.turbid.leaf_per_m.len() * 8 + (self.sites.len() + self.place.len() + self.blocks.len()) * 4
    }

    /// Blocks of 4^3 that hold matter.
    pub(crate) fn block_count(&self) -> usize {
        self.block_count
    }

    /// The number of the block that a place lies in.
    pub(crate) fn block_of(&self, place: usize) -> usize {
        self.blocks[block_at(self.turbid.grid.lattice as usize, self.sites[place] as usize)] as usize
    }

    /// Sites and blocks with matter around a point.
    pub(crate) fn around_with_blocks(&self, point_model_m: [f32; 3]) -> AroundBlocks {
        let edge = self.turbid.grid.lattice as usize;
        let mut around = AroundBlocks { sites: Around::new([0; 2]), blocks: Around::new(0) };
        self.around_sites(point_model_m, |site, place, weight| {
            around.sites.push([place as u32, self.blocks[block_at(edge, site)]], weight);
        });
        if around.sites.is_empty() {
            return around;
        }
        let blocks = edge / BLOCK;
        let last = (blocks - 1) as f64;
        let point = self.turbid.grid.lattice_from_model(point_model_m.map(f64::from));
        // Written so that a NaN is the lower end.
        let at = point.map(|c| (c / BLOCK as f64 - 0.5).max(0.0).min(last));
        let low = at.map(|c| (c as usize).min(blocks - 2));
        let part: [f32; 3] = std::array::from_fn(|axis| (at[axis] - low[axis] as f64) as f32);
        for ([x, y, z], weight) in corners(part) {
            let block = self.blocks[((low[2] + z) * blocks + low[1] + y) * blocks + low[0] + x];
            if block != EMPTY {
                around.blocks.push(block, weight);
            }
        }
        if around.blocks.is_empty() {
            // A site at the edge of its block: its own block is no neighbour of the point's.
            let ([_, block], _) = around.sites.found[0];
            around.blocks = Around::new(0);
            around.blocks.push(block, 1.0);
        }
        around
    }

    /// What makes near beams of suns; `single` says whether they need light scattered once.
    pub(crate) fn near(&self, single: bool) -> Near<'_> {
        Near::new(&self.turbid, &self.sites, single)
    }

    /// The near beam of a sun at every site with matter; nothing where the fields of `suns` need none.
    pub(crate) fn prepare(&self, suns: &SunBasis, near: &Near, terms: SunTerms, rays: u32) -> PreparedSun {
        let mut all = Vec::new();
        if suns.has_near_beam() {
            let beam = near.beam(terms.towards_sun, rays);
            let means = 1 + beam.around.len();
            let mean = |j, site| if j < means { beam.mean(j, site) } else { 0.0 };
            all = (0..self.sites.len()).map(|site| std::array::from_fn(|j| mean(j, site))).collect();
        }
        PreparedSun { terms, near: all }
    }

    /// Means of the near beam at a point: over those of the eight sites that hold matter, by their trilinear weights;
    /// where none does, the beam at the point itself, and no light scattered once.
    ///
    /// # Panics
    /// If the sun was prepared for another medium.
    pub(crate) fn near_at(
        &self,
        prepared: &PreparedSun,
        single: bool,
        point_model_m: [f32; 3],
    ) -> [f32; MAX_MEANS] {
        let (mut sum, mut weights) = ([0.0; MAX_MEANS], 0.0);
        self.around(point_model_m, |place, w| {
            let near = &prepared.near[place];
            sum.iter_mut().zip(near).for_each(|(sum, near)| *sum += w * near);
            weights += w;
        });
        if weights > 0.0 {
            return sum.map(|sum| sum / weights);
        }
        self.beam_alone(prepared.terms.towards_sun, single, point_model_m)
    }

    /// The near beam of a point that no matter is near: the beam at the point itself, and no light scattered once.
    pub(crate) fn beam_alone(
        &self,
        towards_sun: [f64; 3],
        single: bool,
        point_model_m: [f32; 3],
    ) -> [f32; MAX_MEANS] {
        let point = self.turbid.grid.lattice_from_model(point_model_m.map(f64::from));
        everywhere(dense::transmittance(&self.turbid, point, towards_sun), single)
    }

    /// Tells the places of those of the eight sites around a point that hold matter, with their trilinear weights.
    pub(crate) fn around(&self, point_model_m: [f32; 3], mut tell: impl FnMut(usize, f32)) {
        self.around_sites(point_model_m, |_, place, weight| tell(place, weight));
    }

    /// The same with the sites.
    fn around_sites(&self, point_model_m: [f32; 3], mut tell: impl FnMut(usize, usize, f32)) {
        let grid = &self.turbid.grid;
        let at = locate(grid.lattice, grid.lattice_from_model(point_model_m.map(f64::from)));
        let n = grid.lattice as usize;
        let (mut first, mut part) = ([0; 3], [0.0; 3]);
        for axis in 0..3 {
            let texel = at.block[axis] as f32 * flb_format::block::STRIDE as f32 + at.local[axis];
            first[axis] = (texel as usize).min(n - 2);
            part[axis] = texel - first[axis] as f32;
        }
        for ([x, y, z], weight) in corners(part) {
            let site = ((first[2] + z) * n + first[1] + y) * n + first[0] + x;
            if let Some(place) = self.place_of(site) {
                tell(site, place, weight);
            }
        }
    }
}

/// The place of the block of a site among all blocks.
fn block_at(edge: usize, site: usize) -> usize {
    let (blocks, [x, y, z]) = (edge / BLOCK, [site % edge, site / edge % edge, site / (edge * edge)]);
    (z / BLOCK * blocks + y / BLOCK) * blocks + x / BLOCK
}
