//! Random bases of both codings, as a reader gets them: their detail may come in part.

use std::sync::Arc;

use flb_format::Grid;
use flb_format::blocks::classes::{ClassTable, Widths, fields};
use flb_format::blocks::{
    Averages, BlockMap, Classes, CodedBase, CodedBlock, Coding, Head, MAX_WIDTH, Shared, TEXELS, detail,
};

/// SplitMix64 (Steele, Lea and Flood 2014).
pub(super) struct Random(pub u64);

impl Random {
    pub(super) fn next(&mut self) -> u64 {
        self.0 = self.0.wrapping_add(0x9E37_79B9_7F4A_7C15);
        let mut h = self.0;
        h = (h ^ (h >> 30)).wrapping_mul(0xBF58_476D_1CE4_E5B9);
        h = (h ^ (h >> 27)).wrapping_mul(0x94D0_49BB_1331_11EB);
        h ^ (h >> 31)
    }

    pub(super) fn below(&mut self, end: usize) -> usize {
        (self.next() % end as u64) as usize
    }

    pub(super) fn unit(&mut self) -> f64 {
        (self.next() >> 11) as f64 / (1u64 << 53) as f64
    }
}

/// Of a lattice, somewhere in model space.
pub(super) fn grid(lattice: u32) -> Grid {
    Grid { lattice, origin_m: [-1.75, 0.25, -3.0], spacing_m: 0.11 }
}

/// What bases share: a map of some of the blocks or of all, class tables with widths of all sizes, or none.
pub(super) fn shared(random: &mut Random, lattice: u32, haar: bool, full: bool) -> Arc<Shared> {
    let density = 20 + random.below(200);
    let non_empty: Vec<bool> = (0..lattice.pow(3)).map(|_| random.below(density) == 0).collect();
    let map = if full { BlockMap::all(lattice) } else { BlockMap::near(lattice, &non_empty) };
    let mut table = |count: usize| {
        let mut widths = || -> Widths {
            let most = 1 + random.below(usize::from(MAX_WIDTH));
            std::array::from_fn(|_| random.below(3 * most + 1).saturating_sub(2 * most) as u8)
        };
        ClassTable::new((0..count).map(|_| widths()).collect())
    };
    let coding = if haar { Coding::Haar } else { Coding::Classed(Classes::new([table(40), table(5)])) };
    Arc::new(Shared { map, coding })
}

/// A base and its detail, page by page: first block, blocks, payload.
pub(super) struct Made {
    pub base: CodedBase,
    pub pages: Vec<(u32, u32, Vec<u8>)>,
}

impl Made {
    /// With the detail of all pages for which `is_wanted` holds.
    pub(super) fn with(&self, is_wanted: impl Fn(usize) -> bool) -> CodedBase {
        let mut base = self.base.clone();
        for (_, (first, count, payload)) in self.pages.iter().enumerate().filter(|(i, _)| is_wanted(*i)) {
            base.add(*first, *count, payload).expect("a sound page");
        }
        base
    }
}

/// A base of random averages up to 3000 steps and random detail, in about `pages` pages.
pub(super) fn made(random: &mut Random, shared: &Arc<Shared>, bands: u32, pages: usize) -> Made {
    let components = 1 + random.below(bands as usize);
    let head = Head {
        bands,
        axes: [[0, 1, 2], [2, 0, 1], [1, 0, 2], [2, 1, 0]][random.below(4)],
        unit: 1.0 / 262_144.0,
        thresholds: [1500, 700, 100],
        peak: 1.5,
        rms_error: 0.01,
        dark_error: 0.1,
        rotation: (0..components * bands as usize).map(|_| 2.0 * random.unit() as f32 - 1.0).collect(),
    }
    .checked()
    .expect("a sound head");
    let map = &shared.map;
    let mut any = |count: usize| -> Vec<i16> {
        (0..count).map(|_| (random.below(6001) as i32 - 3000) as i16).collect()
    };
    let coarse = if map.is_full() { 0 } else { (map.lattice() as usize / 16).pow(3) };
    let averages = Averages {
        blocks: (0..components).map(|_| any(map.len())).collect(),
        coarse: if coarse == 0 { Vec::new() } else { (0..components).map(|_| any(coarse)).collect() },
    };
    let order = head.order();
    let blocks: Vec<CodedBlock> = (0..map.len() * components)
        .map(|i| coded_block(random, &shared.coding, &order, i % components))
        .collect();
    let per_page = map.len().div_ceil(pages);
    let pages = blocks.chunks(per_page * components).enumerate().map(|(i, blocks)| {
        let payload = detail::encode(&shared.coding, &order, components, blocks);
        ((i * per_page) as u32, (blocks.len() / components) as u32, payload)
    });
    Made { pages: pages.collect(), base: CodedBase::new(shared, head, averages) }
}

fn coded_block(random: &mut Random, coding: &Coding, order: &[u8; TEXELS], component: usize) -> CodedBlock {
    let mut values = [0; TEXELS];
    let class = match coding {
        Coding::Classed(classes) => {
            let widths = classes.tables[Classes::table(component)].widths();
            let class = random.below(widths.len());
            for (place, width) in fields(&widths[class]) {
                let codes = 1 << width;
                values[usize::from(order[place as usize])] =
                    (2 * random.below(codes) as i32 + 1 - codes as i32) as i16;
            }
            class
        }
        Coding::Haar => {
            let width = random.below(usize::from(MAX_WIDTH));
            let most = random.below(1 << width) as i32;
            for value in &mut values[1..] {
                if random.below(5) == 0 {
                    *value = 2 * (random.below(2 * most as usize + 1) as i32 - most) as i16;
                }
            }
            match values[1..].iter().map(|v| usize::from(v.unsigned_abs() / 2)).max().expect("values") {
                0 => 0,
                largest => 1 + largest.next_power_of_two().ilog2() as usize,
            }
        }
    };
    CodedBlock { class: class as u16, values }
}
