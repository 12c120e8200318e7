//! Does a file keep every promise of SPEC.md (section 11)? Four levels, each holding the ones before it; and what each
//! looks at: the surfaces of materials, all pages, zero padding, the BLAKE3 root, all content.

use super::digest::Root;
use super::records::{HEADER_BYTES, KIND_METADATA, SectionEntry};
use super::{Container, read_header};
use crate::Source;
use crate::error::{FormatError, Place};

/// Bytes read at a time.
const STEP_BYTES: u64 = 1 << 20;

/// Depth of a validation.
#[derive(Debug, Clone, Copy, PartialEq, Eq, PartialOrd, Ord)]
#[cfg_attr(feature = "clap", derive(clap::ValueEnum))]
pub enum Level {
    /// The header alone.
    Header,
    /// Table of contents, page tables, metadata.
    Tables,
    /// Every page's digest and frame, the padding, the BLAKE3 root.
    Pages,
    /// Every page's content: blocks, values, media.
    Decode,
}

impl Level {
    /// All levels, from the quickest to the deepest, with their names.
    pub const ALL: [(Level, &'static str); 4] = [
        (Level::Header, "header"),
        (Level::Tables, "tables"),
        (Level::Pages, "pages"),
        (Level::Decode, "decode"),
    ];

    /// The level of this name.
    pub fn from_name(name: &str) -> Option<Level> {
        Level::ALL.into_iter().find(|(_, n)| *n == name).map(|(level, _)| level)
    }
}

/// Checks every promise of a file up to a level.
///
/// # Errors
/// The first broken promise.
pub fn check(source: &dyn Source, level: Level) -> Result<(), FormatError> {
    if level == Level::Header {
        return read_header(source).map(drop);
    }
    let container = Container::open(source)?;
    check_material_surfaces(&container)?;
    if level >= Level::Pages {
        check_pages(&container, source)?;
        check_padding(&container, source)?;
        check_root(&container, source)?;
    }
    if level >= Level::Decode {
        check_content(&container, source)?;
    }
    Ok(())
}

/// Checks what the metadata say of the surfaces of materials (M60). A reader that does not draw them needs no check, so
/// that opening does without.
///
/// # Errors
/// [`FormatError::MaterialSurfaces`].
pub fn check_material_surfaces(container: &Container) -> Result<(), FormatError> {
    for (species, owner) in container.species().iter().enumerate() {
        let is_it = |section: &SectionEntry| {
            section.key.kind == KIND_METADATA && section.key.species as usize == species
        };
        let section = container.sections().iter().find(|section| is_it(section));
        if let (Err(reason), Some(section)) = (owner.meta.material_surfaces(), section) {
            let place = Place::section(section.data_offset, section.key);
            return Err(FormatError::MaterialSurfaces { place, species, reason });
        }
    }
    Ok(())
}

/// Reads every page: digests and zstd frames.
///
/// # Errors
/// As [`Container::read_page`].
pub fn check_pages(container: &Container, source: &dyn Source) -> Result<(), FormatError> {
    for section in 0..container.sections.len() {
        for page in 0..container.tables[section].len() as u32 {
            container.read_page(source, section, page)?;
        }
    }
    Ok(())
}

/// Decodes every medium and every base, page by page; nothing of them is kept.
///
/// # Errors
/// As [`Container::read_medium`], [`Container::read_turbid`], [`Container::read_field`] and
/// [`Container::read_coded_base`].
pub fn check_content(container: &Container, source: &dyn Source) -> Result<(), FormatError> {
    (0..container.species.len()).try_for_each(|index| container.check_species(source, index))
}

/// Checks that every byte between the tables, the sections and the pages is 0.
///
/// # Errors
/// [`FormatError::Padding`] at the first other byte; read errors.
pub fn check_padding(container: &Container, source: &dyn Source) -> Result<(), FormatError> {
    let mut end = container.header().tables_end;
    // Pages that share the bytes of an earlier one lie before it.
    for page in container.tables.iter().flatten() {
        if page.offset < end {
            continue;
        }
        // At most SECTION_ALIGN - 1 bytes: open checked every offset.
        let mut gap = vec![0; (page.offset - end) as usize];
        read(source, end, &mut gap)?;
        if let Some(i) = gap.iter().position(|byte| *byte != 0) {
            return Err(FormatError::Padding { place: Place::padding(end + i as u64), found: gap[i] });
        }
        end = page.offset + u64::from(page.stored_bytes);
    }
    Ok(())
}

/// Computes the BLAKE3 root over the file and compares it with the header's.
///
/// # Errors
/// [`FormatError::Root`]; read errors.
pub fn check_root(container: &Container, source: &dyn Source) -> Result<(), FormatError> {
    let header = container.header();
    let mut root = Root::new(&header.to_bytes());
    let mut at = HEADER_BYTES;
    let mut buffer = vec![0; STEP_BYTES.min(header.file_bytes - at) as usize];
    while at < header.file_bytes {
        let step = STEP_BYTES.min(header.file_bytes - at) as usize;
        read(source, at, &mut buffer[..step])?;
        root.update(&buffer[..step]);
        at += step as u64;
    }
    let computed = root.finish();
    if computed != header.root {
        return Err(FormatError::Root {
            place: Place::header(80),
            stored: hexadecimal(&header.root),
            computed: hexadecimal(&computed),
        });
    }
    Ok(())
}

/// Lower-case hexadecimal digits of a digest.
pub fn hexadecimal(bytes: &[u8]) -> String {
    bytes.iter().map(|byte| format!("{byte:02x}")).collect()
}

fn read(source: &dyn Source, at: u64, buffer: &mut [u8]) -> Result<(), FormatError> {
    source.read_exact_at(at, buffer).map_err(|source| FormatError::Read {
        place: Place::file(at),
        bytes: buffer.len() as u64,
        source,
    })
}
