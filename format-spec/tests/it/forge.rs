//! Golden files, taken apart and put together wrongly with sound digests, so that the check behind the
//! digests is reached.

pub(crate) mod any;
pub(crate) mod bits;
pub(crate) mod content;
pub(crate) mod directions;
pub(crate) mod layout;
pub(crate) mod near;
pub(crate) mod physical;

use flb_format::container::digest::{self, Root};
use flb_format::container::verify;
use flb_format::records::*;
use flb_format::{Container, FormatError};

/// All golden files of this version and those before, by name: `raw-f32`, `v0.1/raw-f32`.
pub(crate) fn golden() -> Vec<(String, Vec<u8>)> {
    let mut files = Vec::new();
    for prefix in ["", "v0.1/"] {
        let folder = format!("{}/golden/{prefix}", env!("CARGO_MANIFEST_DIR"));
        let paths = std::fs::read_dir(folder)
            .expect("the golden folder is in the repository")
            .map(|entry| entry.expect("the folder can be listed").path())
            .filter(|path| path.extension().is_some_and(|e| e == "flb"));
        let before = files.len();
        files.extend(paths.map(|path| {
            let name = path.file_stem().expect("a golden file has a name").to_string_lossy();
            (format!("{prefix}{name}"), std::fs::read(&path).expect("a golden file can be read"))
        }));
        assert!(files.len() >= before + 8, "golden files are missing");
    }
    files.sort();
    files
}

/// One golden file.
pub(crate) fn golden_file(name: &str) -> Vec<u8> {
    golden().into_iter().find(|(n, _)| n == name).expect("there is such a golden file").1
}

/// Everything that SPEC.md promises, at level decode.
pub(crate) fn verdict(bytes: &[u8]) -> Result<(), FormatError> {
    let bytes = &bytes.to_vec();
    let container = Container::open(bytes)?;
    verify::check_material_surfaces(&container)?;
    verify::check_pages(&container, bytes)?;
    verify::check_padding(&container, bytes)?;
    verify::check_root(&container, bytes)?;
    verify::check_content(&container, bytes)
}

/// The same, by putting every medium and every field together.
pub(crate) fn read_all(bytes: &[u8]) -> Result<(), FormatError> {
    let bytes = &bytes.to_vec();
    let container = Container::open(bytes)?;
    for (i, species) in container.species().iter().enumerate() {
        container.read_medium(bytes, i)?;
        species.extinction.map(|_| container.read_turbid(bytes, i)).transpose()?;
        species.blocks.map(|_| container.read_shared(bytes, i)).transpose()?;
        species.bases.iter().try_for_each(|base| container.read_field(bytes, i, base.base).map(drop))?;
    }
    Ok(())
}

/// A file in parts. `bytes` are the whole file; header and tables are written over it by [`Parts::join`].
pub(crate) struct Parts {
    pub header: Header,
    pub sections: Vec<SectionEntry>,
    /// `[section][page]`
    pub tables: Vec<Vec<PageEntry>>,
    pub bytes: Vec<u8>,
    /// Whether `join` computes page digests anew.
    pub repair_pages: bool,
}

impl Parts {
    pub(crate) fn of(bytes: &[u8]) -> Parts {
        let (header, _) = Header::from_bytes(bytes[..128].try_into().expect("128 bytes"));
        let contents_end = 128 + header.contents_bytes as usize;
        let sections: Vec<_> =
            bytes[128..contents_end].as_chunks().0.iter().map(SectionEntry::from_bytes).collect();
        let table = |section: &SectionEntry| {
            let start = section.table_offset as usize;
            let table = &bytes[start..start + 48 * section.page_count as usize];
            table.as_chunks().0.iter().map(PageEntry::from_bytes).collect()
        };
        let tables = sections.iter().map(table).collect();
        Parts { header, sections, tables, bytes: bytes.to_vec(), repair_pages: true }
    }

    /// Index of the first section of a kind and item.
    pub(crate) fn find(&self, kind: u32, item: u32) -> usize {
        self.sections.iter().position(|s| s.key.kind == kind && s.key.item == item).expect("it is there")
    }

    /// The first base section.
    pub(crate) fn base(&self) -> usize {
        self.sections.iter().position(|s| s.key.kind == KIND_BASE).expect("it is there")
    }

    /// The stored bytes of a page.
    pub(crate) fn stored(&mut self, section: usize, page: usize) -> &mut [u8] {
        let entry = self.tables[section][page];
        &mut self.bytes[entry.offset as usize..][..entry.stored_bytes as usize]
    }

    /// The file, with every digest made to fit.
    pub(crate) fn join(mut self) -> Vec<u8> {
        let mut at = 128 + 96 * self.sections.len();
        for (section, table) in self.sections.iter_mut().zip(&mut self.tables) {
            for (i, page) in table.iter_mut().enumerate() {
                let stored = (page.offset as usize)
                    .checked_add(page.stored_bytes as usize)
                    .and_then(|end| self.bytes.get(page.offset as usize..end));
                if let Some(stored) = stored.filter(|_| self.repair_pages) {
                    page.digest = digest::page(section.key, i as u32, stored);
                }
            }
            let bytes: Vec<u8> = table.iter().flat_map(PageEntry::to_bytes).collect();
            section.table_digest = digest::plain(&bytes);
            self.bytes[at..at + bytes.len()].copy_from_slice(&bytes);
            at += bytes.len();
        }
        let contents: Vec<u8> = self.sections.iter().flat_map(SectionEntry::to_bytes).collect();
        self.header.contents_digest = digest::plain(&contents);
        self.bytes[128..128 + contents.len()].copy_from_slice(&contents);
        let mut root = Root::new(&self.header.to_bytes());
        root.update(&self.bytes[128..]);
        self.header.root = root.finish();
        let header = self.header.to_bytes();
        self.bytes[..128].copy_from_slice(&header);
        self.bytes
    }
}

/// A golden file with an edit that no digest gives away.
pub(crate) fn forge(name: &str, edit: impl FnOnce(&mut Parts)) -> Vec<u8> {
    let mut parts = Parts::of(&golden_file(name));
    edit(&mut parts);
    parts.join()
}

/// A golden file whose last section (a base) has one page less or more bytes: `payload` replaces the
/// payload of the file's last page, stored as `stored` with this compression.
pub(crate) fn replace_last_page(name: &str, raw_bytes: u32, compression: u32, stored: &[u8]) -> Vec<u8> {
    forge(name, |parts| {
        let section = parts.sections.last_mut().expect("a file has sections");
        let page = parts.tables.last_mut().expect("a section has a table").last_mut().expect("and a page");
        section.raw_bytes = section.raw_bytes - u64::from(page.raw_bytes) + u64::from(raw_bytes);
        section.data_bytes = section.data_bytes - u64::from(page.stored_bytes) + stored.len() as u64;
        page.raw_bytes = raw_bytes;
        page.stored_bytes = stored.len() as u32;
        page.compression = compression;
        parts.bytes.truncate(page.offset as usize);
        parts.bytes.extend(stored);
        parts.header.file_bytes = parts.bytes.len() as u64;
        parts.header.required_features =
            u64::from(parts.tables.iter().flatten().any(|page| page.compression == STORED_ZSTD));
    })
}
