//! Blocks near geometry out of a container: what a species' bases share, a base's averages, its pages of detail.

use std::sync::Arc;

use crate::blocks::base::parse_averages;
use crate::blocks::{BlockFault, BlockMap, Classes, CodedBase, Coding, Rule, Shared};
use crate::error::{FormatError, Place};
use crate::{Source, room};

use super::payload::PageContext;
use super::{BaseEntry, Container, open};

impl Container {
    /// Block map and class tables of a species.
    ///
    /// # Errors
    /// [`FormatError::NoSpecies`]; [`FormatError::NoBlocks`] for a species of other codecs; as
    /// [`Container::read_page`]; the promises of SPEC.md, M50 and sections 8.5.1 and 8.5.2.
    pub fn read_shared(&self, source: &dyn Source, species: usize) -> Result<Arc<Shared>, FormatError> {
        let owner = self.known_species(species)?;
        let Some(blocks) = owner.blocks else {
            return Err(self.no_blocks(&owner.bases[0]));
        };
        let (place, bytes) = self.read_whole(source, blocks.map)?;
        let lattice = owner.meta.grid.lattice;
        let map = BlockMap::from_bytes(&bytes, lattice).map_err(|fault| FormatError::blocks(place, fault))?;
        let coding = match blocks.classes {
            None => Coding::Haar,
            Some(classes) => {
                let (place, bytes) = self.read_whole(source, classes)?;
                let classes =
                    Classes::from_bytes(&bytes).map_err(|fault| FormatError::blocks(place, fault))?;
                Coding::Classed(classes)
            }
        };
        // Of all bases, since they have the same number of blocks.
        if let Some(detail) = owner.bases.iter().find_map(|base| base.detail) {
            let blocks = self.sections[detail].units;
            if blocks != map.len() as u64 {
                let fault = BlockFault {
                    rule: Rule::DetailBlocks,
                    what: "the number of its blocks".to_owned(),
                    found: blocks.to_string(),
                    expected: format!("{}, as in the block map", map.len()),
                };
                return Err(FormatError::blocks(self.section_place(detail), fault));
            }
        }
        Ok(Arc::new(Shared { map, coding }))
    }

    /// A base of blocks near geometry with its averages alone, which give it a quarter of its resolution.
    ///
    /// # Errors
    /// As [`Container::read_field`], [`FormatError::NoBlocks`] for a base of another codec, and the promises of SPEC.md
    /// sections 8.5.3.
    pub fn read_averages(
        &self,
        source: &dyn Source,
        species: usize,
        base: u8,
        shared: &Arc<Shared>,
    ) -> Result<CodedBase, FormatError> {
        let entry = self.near_geometry(species, base)?;
        let (place, bytes) = self.read_whole(source, entry.section)?;
        let bands = self.sections[entry.section].bands;
        ask_for_blocks(place, shared.map.len(), bands)?;
        let (head, averages) =
            parse_averages(shared, bands, &bytes).map_err(|fault| FormatError::blocks(place, fault))?;
        let head = match self.chosen_bands(species) {
            Some(bands) => head.with_bands(bands),
            None => head,
        };
        Ok(CodedBase::new(shared, head, averages))
    }

    /// Adds a page of detail to a base that [`Container::read_averages`] read.
    ///
    /// # Errors
    /// As [`Container::read_page`], and the promises of SPEC.md section 8.5.4; a page that was added before is refused,
    /// too.
    pub fn read_detail(
        &self,
        source: &dyn Source,
        species: usize,
        base: u8,
        page: u32,
        into: &mut CodedBase,
    ) -> Result<(), FormatError> {
        let entry = self.near_geometry(species, base)?;
        let section = entry.detail.expect("open found the detail of every base");
        let payload = self.read_page(source, section, page)?;
        let context = self.page_context(section, page);
        ask_for_detail(context, into.head().components())?;
        // A section has at most as many units as the lattice blocks.
        into.add(context.first as u32, context.count, &payload)
            .map_err(|fault| FormatError::blocks(context.place, fault))
    }

    /// A base of blocks near geometry with all its detail.
    ///
    /// # Errors
    /// As [`Container::read_averages`] and [`Container::read_detail`].
    pub fn read_coded_base(
        &self,
        source: &dyn Source,
        species: usize,
        base: u8,
        shared: &Arc<Shared>,
    ) -> Result<CodedBase, FormatError> {
        let mut coded = self.read_averages(source, species, base, shared)?;
        let section = self.near_geometry(species, base)?.detail.expect("open found the detail of every base");
        let payloads = self.tables[section].iter().map(|page| u64::from(page.raw_bytes)).sum();
        room::ask(self.section_place(section), "the detail of a base", payloads)?;
        for page in 0..self.tables[section].len() as u32 {
            self.read_detail(source, species, base, page, &mut coded)?;
        }
        Ok(coded)
    }

    fn near_geometry(&self, species: usize, base: u8) -> Result<&BaseEntry, FormatError> {
        self.known_species(species)?;
        let entry = self.find_base(species, base).ok_or_else(|| self.no_base(species, base))?;
        if entry.codec.is_near_geometry() { Ok(entry) } else { Err(self.no_blocks(entry)) }
    }

    fn no_blocks(&self, base: &BaseEntry) -> FormatError {
        FormatError::NoBlocks { place: self.section_place(base.section), codec: base.codec.name() }
    }

    /// The payloads of all pages of a section that is small, one after another.
    pub(super) fn read_whole(
        &self,
        source: &dyn Source,
        section: usize,
    ) -> Result<(Place, Vec<u8>), FormatError> {
        let bytes = open::read_section(source, &self.sections[section], &self.tables[section])?;
        Ok((self.section_place(section), bytes))
    }
}

/// Room for a base without its detail: of each block's components an average and a word, of `haar` a mask.
pub(super) fn ask_for_blocks(place: Place, blocks: usize, bands: u32) -> Result<(), FormatError> {
    room::ask(place, "blocks of a base", 16 * blocks as u64 * (u64::from(bands) + 1))
}

/// Room for what is read of a page of detail: of each block's components a class, a mask and a length; where blocks
/// start.
pub(super) fn ask_for_detail(page: PageContext, components: usize) -> Result<(), FormatError> {
    let each = size_of::<u16>() + 2 * size_of::<u64>();
    room::ask(
        page.place,
        "blocks of a page of detail",
        u64::from(page.count) * (components * each + 8) as u64,
    )
}
