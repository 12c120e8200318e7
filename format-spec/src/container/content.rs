//! All content checked and none of it kept: what a check holds in memory does not grow with what a file claims to hold.
//! SPEC.md section 11, level decode; the order of checks is that of reading, where fields are put together.
//!
//! Pages of plain floats and of `haar-paper` stand for themselves, and so does detail, once the averages are read.
//! Density and class of a species are compared site by site, so these two are held, 5 bytes a site.

use std::sync::Arc;

use crate::blocks::base::{DetailCheck, parse_averages};
use crate::blocks::{Head, Shared};
use crate::error::FormatError;
use crate::{Source, room};

use super::near::{ask_for_blocks, ask_for_detail};
use super::payload::{self, SparseValue};
use super::records::Codec;
use super::{BaseEntry, Container, Species};

impl Container {
    /// Checks the medium and all bases of a species.
    pub(super) fn check_species(&self, source: &dyn Source, index: usize) -> Result<(), FormatError> {
        let species = &self.species[index];
        self.check_medium(source, species)?;
        let shared = species.blocks.map(|_| self.read_shared(source, index)).transpose()?;
        for base in &species.bases {
            match &shared {
                Some(shared) => self.check_coded_base(source, base, shared)?,
                None => self.check_base(source, base)?,
            }
        }
        Ok(())
    }

    fn check_medium(&self, source: &dyn Source, species: &Species) -> Result<(), FormatError> {
        let [density, class, areas @ ..] = species.medium;
        let sites = species.meta.grid.sites();
        let densities: Vec<f32> = self.read_sparse(source, density, sites)?;
        let classes: Vec<u8> = self.read_sparse(source, class, sites)?;
        self.join_class(density, &densities, &classes)?;
        drop((densities, classes));
        for section in areas.into_iter().chain(species.extinction.into_iter().flatten()) {
            self.check_sparse::<f32>(source, section)?;
        }
        Ok(())
    }

    fn check_sparse<T: SparseValue>(&self, source: &dyn Source, section: usize) -> Result<(), FormatError> {
        for page in 0..self.tables[section].len() as u32 {
            let bytes = self.read_page(source, section, page)?;
            let context = self.page_context(section, page);
            let mut values =
                room::filled(context.place, "values of a page", T::default(), context.count as usize)?;
            payload::decode_sparse(&bytes, context, &mut values)?;
        }
        Ok(())
    }

    /// A base of kind 3.
    fn check_base(&self, source: &dyn Source, base: &BaseEntry) -> Result<(), FormatError> {
        for page in 0..self.tables[base.section].len() as u32 {
            match base.codec {
                Codec::RawF32 | Codec::RawF16 => drop(self.read_value_page(source, base.section, page)?),
                Codec::HaarPaper => drop(self.read_block_page(source, base.section, page)?),
                Codec::Classed | Codec::Haar => unreachable!("its species has a block map"),
            }
        }
        Ok(())
    }

    /// A base of blocks near geometry. Every field of a block that parses is sound: decoding adds nothing.
    fn check_coded_base(
        &self,
        source: &dyn Source,
        base: &BaseEntry,
        shared: &Arc<Shared>,
    ) -> Result<(), FormatError> {
        let head = self.check_averages(source, base, shared)?;
        let section = base.detail.expect("open found the detail of every base");
        let mut detail = DetailCheck::new(shared, head.components());
        for page in 0..self.tables[section].len() as u32 {
            let payload = self.read_page(source, section, page)?;
            let context = self.page_context(section, page);
            ask_for_detail(context, head.components())?;
            detail
                .check(context.first as u32, context.count, &payload)
                .map_err(|fault| FormatError::blocks(context.place, fault))?;
        }
        Ok(())
    }

    fn check_averages(
        &self,
        source: &dyn Source,
        base: &BaseEntry,
        shared: &Shared,
    ) -> Result<Head, FormatError> {
        let (place, bytes) = self.read_whole(source, base.section)?;
        let bands = self.sections[base.section].bands;
        ask_for_blocks(place, shared.map.len(), bands)?;
        let (head, _) =
            parse_averages(shared, bands, &bytes).map_err(|fault| FormatError::blocks(place, fault))?;
        Ok(head)
    }
}
