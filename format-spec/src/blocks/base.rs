//! A coded base in memory: readable from its averages on, and refined by pages of detail in any order.

use std::sync::Arc;

use super::bits::BitReader;
use super::classes::GROUP_BYTES;
use super::coarse::{self, Coarse};
use super::lanes::{self, Job, Lanes};
use super::transform::{self, AVERAGE_COEFFICIENT, AVERAGE_TEXEL, EDGE, TEXELS};
use super::{Averages, BlockFault, BlockMap, Coding, Head, MAX_HALVINGS, Rule, detail};

/// Block map and detail coding that all bases of a species share.
#[derive(Debug, Clone, PartialEq, Eq)]
pub struct Shared {
    /// The stored blocks.
    pub map: BlockMap,
    /// Coding of their detail.
    pub coding: Coding,
}

impl Shared {
    /// Memory that it takes.
    pub fn size_bytes(&self) -> usize {
        let classes = match &self.coding {
            Coding::Classed(classes) => classes.size_bytes(),
            Coding::Haar => 0,
        };
        self.map.size_bytes() + classes
    }
}

/// Head and averages of a base, from their payload.
///
/// # Errors
/// Those of [`Head::from_bytes`] and [`Averages::from_bytes`].
pub fn parse_averages(shared: &Shared, bands: u32, bytes: &[u8]) -> Result<(Head, Averages), BlockFault> {
    let head_bytes = bytes.first().map_or(0, |first| Head::len_bytes(*first, bands)).min(bytes.len());
    let (head, averages) = bytes.split_at(head_bytes);
    let head = Head::from_bytes(head, bands)?;
    let averages = Averages::from_bytes(averages, &shared.map, head.components())?;
    Ok((head, averages))
}

/// The pages of a base's detail, checked one after another and not kept.
#[derive(Debug)]
pub struct DetailCheck<'a> {
    shared: &'a Shared,
    components: usize,
    /// Bytes of the payloads so far.
    added: usize,
}

impl DetailCheck<'_> {
    /// Makes a check of a base with so many components.
    pub fn new(shared: &Shared, components: usize) -> DetailCheck<'_> {
        DetailCheck { shared, components, added: 0 }
    }

    /// Checks the payload of a page that holds `count` blocks from rank `first` on, behind those of the page before.
    ///
    /// # Errors
    /// As [`CodedBase::add`].
    pub fn check(&mut self, first: u32, count: u32, payload: &[u8]) -> Result<(), BlockFault> {
        check_range(self.shared.map.len(), first, count)?;
        check_size(self.added, payload)?;
        detail::parse(&self.shared.coding, self.components, count as usize, payload)?;
        self.added += payload.len();
        Ok(())
    }
}

/// A page holds a block at least, and only stored ones.
fn check_range(stored: usize, first: u32, count: u32) -> Result<(), BlockFault> {
    if count > 0 && u64::from(first) + u64::from(count) <= stored as u64 {
        return Ok(());
    }
    let (found, expected) = (format!("{count} from {first}"), format!("at least 1, of {stored} stored ones"));
    Err(BlockFault::new(Rule::DetailBlocks, "the blocks of a page of detail", found, expected))
}

/// With what was added before, a page's payload is within the limit.
fn check_size(added: usize, payload: &[u8]) -> Result<(), BlockFault> {
    let found = added + payload.len();
    if found <= MAX_DETAIL_BYTES {
        return Ok(());
    }
    let expected = format!("up to {MAX_DETAIL_BYTES}");
    Err(BlockFault::length(Rule::DetailSize, "the detail of a base", found, expected))
}

/// Bytes behind the last field, so that a reader may take those of a group anywhere.
const WINDOW_BYTES: usize = GROUP_BYTES;
/// Most bytes of the payloads of a base's detail, so that places of bits are `u32`.
const MAX_DETAIL_BYTES: usize = crate::container::records::MAX_DETAIL_BYTES as usize;

/// A base, expanded for random access to its blocks.
#[derive(Debug, Clone)]
pub struct CodedBase {
    pub(super) shared: Arc<Shared>,
    pub(super) head: Head,
    /// `[component][Morton code]`: [`Averages::coarse`].
    coarse: Vec<Vec<i16>>,
    /// `[block][1 + component]`: first byte of the block's fields (first bit of `haar`), then average (low half) and
    /// class or width (high half).
    pub(super) blocks: Vec<u32>,
    /// `[block][component]` of `haar`.
    pub(super) masks: Vec<u64>,
    /// Fields: of `classed` each component's of a block from a whole byte on, of `haar` payloads of pages. Then a
    /// window of 0.
    pub(super) bytes: Vec<u8>,
    /// Bytes of the payloads added.
    added: usize,
    /// The pages added, in the order of their bytes.
    pages: Vec<Page>,
    /// `[block]` whether its detail was added.
    detailed: Vec<bool>,
    /// How many of them are.
    detailed_count: usize,
    /// `[component][band]`
    pub(super) colors: Vec<f32>,
    /// [`Head::order`]
    order: [u8; TEXELS],
}

/// A page of detail that was added.
#[derive(Debug, Clone, Copy)]
struct Page {
    /// Ranks of its blocks.
    first: u32,
    count: u32,
    /// Bytes of its payload, and those that it takes in memory.
    payload: u32,
    bytes: u32,
}

/// Average in a word of a component of a block.
#[inline(always)]
pub(super) fn average_of(word: u32) -> i16 {
    word as u16 as i16
}

/// Texels of a component of a stored block, to be read.
struct Texels<'a> {
    base: &'a CodedBase,
    rank: usize,
    component: usize,
}

impl Job for Texels<'_> {
    type Output = [i32; TEXELS];

    #[inline(always)]
    fn call<L: Lanes>(self, lanes: L) -> [i32; TEXELS] {
        self.base.texels_with(lanes, self.rank, self.component)
    }
}

impl CodedBase {
    /// A base without detail. `averages` are of the components of `head` and of the map.
    pub fn new(shared: &Arc<Shared>, head: Head, averages: Averages) -> CodedBase {
        let components = head.components();
        let mut blocks = Vec::with_capacity(shared.map.len() * (1 + components));
        for rank in 0..shared.map.len() {
            blocks.push(0);
            let none = u32::from(shared.coding.none()) << 16;
            blocks.extend(averages.blocks.iter().map(|values| u32::from(values[rank] as u16) | none));
        }
        let masks = match shared.coding {
            Coding::Haar => vec![0; shared.map.len() * components],
            Coding::Classed(_) => Vec::new(),
        };
        CodedBase {
            colors: head.colors(),
            order: head.order(),
            detailed: vec![false; shared.map.len()],
            detailed_count: 0,
            bytes: vec![0; WINDOW_BYTES],
            added: 0,
            pages: Vec::new(),
            shared: Arc::clone(shared),
            head,
            coarse: averages.coarse,
            blocks,
            masks,
        }
    }

    /// Reads the payload of head and averages.
    ///
    /// # Errors
    /// Those of [`Head::from_bytes`] and [`Averages::from_bytes`].
    pub fn from_bytes(shared: &Arc<Shared>, bands: u32, bytes: &[u8]) -> Result<CodedBase, BlockFault> {
        let (head, averages) = parse_averages(shared, bands, bytes)?;
        Ok(CodedBase::new(shared, head, averages))
    }

    /// Block map and detail coding that all bases of the species share.
    pub fn shared(&self) -> &Shared {
        &self.shared
    }

    /// Head of the base: bands, unit, steps and rotation.
    pub fn head(&self) -> &Head {
        &self.head
    }

    /// Adds the payload of a page that holds `count` blocks from rank `first` on. Nothing is added on error.
    ///
    /// # Errors
    /// [`Rule::DetailBlocks`], [`Rule::DetailSize`], and those of [`detail::parse`].
    pub fn add(&mut self, first: u32, count: u32, payload: &[u8]) -> Result<(), BlockFault> {
        check_range(self.detailed.len(), first, count)?;
        let (first, count) = (first as usize, count as usize);
        if let Some(twice) = (first..first + count).find(|rank| self.detailed[*rank]) {
            let what = "a block of a page of detail";
            return Err(BlockFault::new(
                Rule::DetailBlocks,
                what,
                twice,
                "one whose detail was not read before",
            ));
        }
        check_size(self.added, payload)?;
        let components = self.head.components();
        let page = detail::parse(&self.shared.coding, components, count, payload)?;
        self.added += payload.len();
        self.bytes.truncate(self.bytes.len() - WINDOW_BYTES);
        let offset = self.bytes.len();
        // No more than is needed, so that what the base says that it takes is what it takes.
        self.bytes.reserve_exact(payload.len() + components * count + WINDOW_BYTES);
        if self.shared.coding == Coding::Haar {
            self.bytes.extend(payload);
        }
        for (i, start) in page.starts.iter().enumerate() {
            let classes = &page.classes[i * components..][..components];
            let block = &mut self.blocks[(first + i) * (1 + components)..][..1 + components];
            block[0] = match &self.shared.coding {
                Coding::Haar => (8 * offset as u64 + start) as u32,
                Coding::Classed(tables) => {
                    let first_byte = self.bytes.len() as u32;
                    let mut reader = BitReader::from(payload, *start);
                    classes.iter().for_each(|class| reader.copy(tables.bits(*class), &mut self.bytes));
                    first_byte
                }
            };
            for (word, class) in block[1..].iter_mut().zip(classes) {
                *word = *word & 0xFFFF | u32::from(*class) << 16;
            }
            self.detailed[first + i] = true;
        }
        self.detailed_count += count;
        let bytes = (self.bytes.len() - offset) as u32;
        self.pages.push(Page {
            first: first as u32,
            count: count as u32,
            payload: payload.len() as u32,
            bytes,
        });
        self.bytes.resize(self.bytes.len() + WINDOW_BYTES, 0);
        if !page.masks.is_empty() {
            self.masks[first * components..][..page.masks.len()].copy_from_slice(&page.masks);
        }
        Ok(())
    }

    /// Takes back the page that was added with blocks from rank `first` on: they have their averages again, as if it
    /// had never been added. Returns whether there was such a page.
    pub fn remove(&mut self, first: u32) -> bool {
        let Some(at) = self.pages.iter().position(|page| page.first == first) else { return false };
        let page = self.pages.remove(at);
        let start: usize = self.pages[..at].iter().map(|before| before.bytes as usize).sum();
        self.bytes.drain(start..start + page.bytes as usize);
        self.bytes.shrink_to_fit();
        self.added -= page.payload as usize;
        let components = self.head.components();
        let none = u32::from(self.shared.coding.none()) << 16;
        let is_haar = self.shared.coding == Coding::Haar;
        let ranks = |page: &Page| page.first as usize..(page.first + page.count) as usize;
        for rank in ranks(&page) {
            let block = &mut self.blocks[rank * (1 + components)..][..1 + components];
            block[0] = 0;
            block[1..].iter_mut().for_each(|word| *word = *word & 0xFFFF | none);
            self.detailed[rank] = false;
            self.detailed_count -= 1;
            if is_haar {
                self.masks[rank * components..][..components].fill(0);
            }
        }
        let moved = if is_haar { 8 * page.bytes } else { page.bytes };
        for rank in self.pages[at..].iter().flat_map(ranks) {
            self.blocks[rank * (1 + components)] -= moved;
        }
        true
    }

    /// Memory that the base takes, what it shares left out.
    pub fn size_bytes(&self) -> usize {
        let coarse: usize = self.coarse.iter().map(|values| size_of_val(&values[..])).sum();
        let pages = size_of_val(&self.pages[..]);
        4 * self.blocks.len() + 8 * self.masks.len() + self.bytes.len() + self.detailed.len() + coarse + pages
    }

    /// Whether the detail of every block was added.
    pub fn is_whole(&self) -> bool {
        self.detailed_count == self.detailed.len()
    }

    /// Share of the stored blocks whose detail was added.
    pub fn detail_share(&self) -> f32 {
        self.detailed_count as f32 / self.detailed.len() as f32
    }

    /// Texels of a component of a stored block, exact; those of its average where its detail was not added.
    ///
    /// # Panics
    /// If there is no such rank or component.
    pub fn texels(&self, rank: usize, component: usize) -> [i32; TEXELS] {
        lanes::run(Texels { base: self, rank, component })
    }

    /// Coefficients of a component of a stored block by their index, which the rows of [`Coding::rows`] turn into
    /// [`CodedBase::texels`]: a reader that keeps blocks in a layout of its own, as a GPU does, starts from these.
    ///
    /// # Panics
    /// If there is no such rank or component.
    pub fn coefficients(&self, rank: usize, component: usize) -> [i32; TEXELS] {
        self.coefficients_with(lanes::Scalar, rank, component)
    }

    /// Halvings of a stored block's steps: but for the first, its coefficients are multiples of
    /// `1 << (MAX_HALVINGS - halvings)`.
    ///
    /// # Panics
    /// If there is no such rank.
    pub fn halvings(&self, rank: usize) -> u32 {
        self.head.halvings(self.average(rank, 0))
    }

    /// Average of a component of a stored block, in steps.
    ///
    /// # Panics
    /// If there is no such rank or component.
    pub fn average(&self, rank: usize, component: usize) -> i16 {
        let components = self.head.components();
        assert!(component < components, "component {component} of {components}");
        average_of(self.blocks[rank * (1 + components) + 1 + component])
    }

    /// Coarse averages, `[component][Morton code]`; of no component where the map is full.
    pub fn coarse_averages(&self) -> &[Vec<i16>] {
        &self.coarse
    }

    /// The coarse level of a component; `None` where the map is full.
    pub(super) fn coarse(&self, component: usize) -> Option<Coarse<'_>> {
        self.coarse.get(component).map(|averages| Coarse { edge: coarse::edge(&self.shared.map), averages })
    }

    /// Whether the detail of a stored block was added.
    ///
    /// # Panics
    /// If there is no such rank.
    pub fn is_detailed(&self, rank: usize) -> bool {
        self.detailed[rank]
    }

    /// [`CodedBase::texels`] by one of the ways to read fields.
    #[inline(always)]
    fn texels_with<L: Lanes>(&self, lanes: L, rank: usize, component: usize) -> [i32; TEXELS] {
        let word = self.blocks[rank * (1 + self.head.components())..][1 + component];
        if let Coding::Classed(classes) = &self.shared.coding
            && classes.groups((word >> 16) as u16).is_empty()
        {
            return [i32::from(average_of(word)) * AVERAGE_TEXEL; TEXELS];
        }
        let mut values = self.coefficients_with(lanes, rank, component);
        // Each with rows that the compiler knows.
        match &self.shared.coding {
            Coding::Classed(_) => transform::inverse(&transform::SMOOTH, &mut values),
            Coding::Haar => transform::inverse(&transform::HAAR, &mut values),
        }
        values
    }

    /// [`CodedBase::coefficients`] by one of the ways to read fields.
    #[inline(always)]
    pub(super) fn coefficients_with<L: Lanes>(
        &self,
        lanes: L,
        rank: usize,
        component: usize,
    ) -> [i32; TEXELS] {
        let components = self.head.components();
        assert!(component < components, "component {component} of {components}");
        let block = &self.blocks[rank * (1 + components)..][..1 + components];
        let order = &self.order;
        let scale = MAX_HALVINGS - self.head.halvings(average_of(block[1]));
        let mut values = [0; TEXELS];
        match &self.shared.coding {
            Coding::Classed(classes) => {
                let number = |c: usize| (block[1 + c] >> 16) as u16;
                let before: usize = (0..component).map(|c| classes.bytes(number(c))).sum();
                for group in classes.groups(number(component)) {
                    let found = lanes.values(group, &self.bytes[block[0] as usize + before..]);
                    for (lane, value) in found.iter().enumerate() {
                        // A filled-up lane has place 0, which is written last.
                        values[usize::from(order[group.place(lane)]) % TEXELS] = value << scale;
                    }
                }
            }
            Coding::Haar => {
                let mut reader = BitReader::from(&self.bytes, u64::from(block[0]));
                let masks = &self.masks[rank * components..][..components];
                let bits = |c: usize| u64::from(masks[c].count_ones()) * u64::from(block[1 + c] >> 16);
                reader.at += (0..component).map(bits).sum::<u64>();
                let width = block[1 + component] >> 16;
                for place in (1..TEXELS).filter(|place| masks[component] >> place & 1 == 1) {
                    let field = reader.take(width).expect("the page's length was checked");
                    values[usize::from(order[place])] = detail::mask_value(field, width) << scale;
                }
            }
        }
        values[0] = i32::from(average_of(block[1 + component])) * AVERAGE_COEFFICIENT;
        values
    }

    /// Texels of a component of block `[x, y, z]`: of the coarse level where it is not stored.
    pub(super) fn block_texels(&self, block: [u32; 3], component: usize) -> [i32; TEXELS] {
        match self.shared.map.rank(block) {
            Some(rank) => self.texels(rank as usize, component),
            None => self.coarse_texels(block, component),
        }
    }

    /// Texels of a component of block `[x, y, z]` of the coarse level; 0 where there is none.
    pub(super) fn coarse_texels(&self, block: [u32; 3], component: usize) -> [i32; TEXELS] {
        match self.coarse(component) {
            Some(coarse) => std::array::from_fn(|t| {
                let [x, y, z] = [t % EDGE, t / EDGE % EDGE, t / (EDGE * EDGE)].map(|d| d as u32);
                coarse.texel([block[0] * 4 + x, block[1] * 4 + y, block[2] * 4 + z])
            }),
            None => [0; TEXELS],
        }
    }

    /// The whole field, with the coarse level where no block is stored.
    pub fn field(&self) -> crate::Field {
        let map = &self.shared.map;
        let mut field = crate::Field::zeros(map.lattice(), self.head.bands);
        for code in 0..(map.lattice() / EDGE as u32).pow(3) {
            let block = super::map::decode(code);
            let texels: Vec<_> = (0..self.head.components()).map(|c| self.block_texels(block, c)).collect();
            for t in 0..TEXELS {
                let [x, y, z] = [t % EDGE, t / EDGE % EDGE, t / (EDGE * EDGE)].map(|d| d as u32);
                let at = [block[0] * 4 + x, block[1] * 4 + y, block[2] * 4 + z];
                self.write(&mut field, at, texels.iter().map(|texels| texels[t]));
            }
        }
        field
    }

    /// The field at a quarter of its resolution: averages of blocks, which is all that it needs.
    pub fn quarter(&self) -> crate::Field {
        let map = &self.shared.map;
        let mut field = crate::Field::zeros(map.lattice() / EDGE as u32, self.head.bands);
        let mut integers = vec![0; self.head.components()];
        for code in 0..field.lattice.pow(3) {
            let block = super::map::decode(code);
            for (c, integer) in integers.iter_mut().enumerate() {
                *integer = match map.rank(block) {
                    Some(rank) => i32::from(self.average(rank as usize, c)) * AVERAGE_TEXEL,
                    None => self.coarse(c).map_or(0, |coarse| coarse.block(block)),
                };
            }
            self.write(&mut field, block, integers.iter().copied());
        }
        field
    }

    /// Integers of all components to light, in the order of components.
    fn write(
        &self,
        field: &mut crate::Field,
        [x, y, z]: [u32; 3],
        integers: impl Iterator<Item = i32> + Clone,
    ) {
        let n = field.lattice as usize;
        let bands = field.bands as usize;
        let site = (z as usize * n + y as usize) * n + x as usize;
        for band in 0..bands {
            let mut sum = 0.0;
            for (c, integer) in integers.clone().enumerate() {
                sum += self.colors[c * bands + band] * integer as f32;
            }
            field.values_mut()[band * n * n * n + site] = sum;
        }
    }
}
