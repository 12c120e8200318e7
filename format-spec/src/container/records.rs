//! The plain records of a file, each with its `to_bytes` and `from_bytes` side by side, and the
//! numbers of the format: magic, version, sizes, limits. SPEC.md sections 3 to 5 are normative.
//!
//! `from_bytes` only moves bytes; what a record may hold is checked by [`Container::open`](super::Container::open).

use std::fmt;

/// First eight bytes of every file. The odd first byte, CR LF, ^Z and LF catch text transfers.
pub const MAGIC: [u8; 8] = [0x89, 0x46, 0x4C, 0x42, 0x0D, 0x0A, 0x1A, 0x0A];
/// Major and minor version of files that need nothing of a later one.
pub const VERSION: (u16, u16) = (1, 0);
/// Latest version that this code reads and writes: that of files with [`FEATURE_LEANING`].
pub const LATEST_VERSION: (u16, u16) = (1, 1);
/// Major version of the draft, whose files this code reads and [`VERSION`] replaces (SPEC.md, section 13).
pub const DRAFT_MAJOR: u16 = 0;
/// Required feature bits that the draft has.
pub const DRAFT_FEATURES: u64 = FEATURE_ZSTD | FEATURE_PHYSICAL | FEATURE_RAW_F16;
/// Kinds of sections that the draft has.
pub const DRAFT_KINDS: std::ops::RangeInclusive<u32> = KIND_METADATA..=KIND_BASE;
/// Required feature bit 0: at least one page is zstd-compressed.
pub const FEATURE_ZSTD: u64 = 1;
/// Required feature bit 1: at least one species is of the model `physical`.
pub const FEATURE_PHYSICAL: u64 = 2;
/// Required feature bit 2: at least one base is coded as `raw-f16`.
pub const FEATURE_RAW_F16: u64 = 4;
/// Required feature bit 3: at least one species is stored as blocks near geometry.
pub const FEATURE_BLOCKS: u64 = 8;
/// Required feature bit 4: the near beam of at least one species counts as often as leaves meet it.
pub const FEATURE_LEANING: u64 = 16;
/// Every required feature bit that this reader knows.
pub const FEATURES_KNOWN: u64 =
    FEATURE_ZSTD | FEATURE_PHYSICAL | FEATURE_RAW_F16 | FEATURE_BLOCKS | FEATURE_LEANING;

/// The lowest version that has these features.
pub const fn version_of(required_features: u64) -> (u16, u16) {
    if required_features & FEATURE_LEANING != 0 { LATEST_VERSION } else { VERSION }
}

/// Bytes of the header.
pub const HEADER_BYTES: u64 = 128;
/// Bytes of one entry of the table of contents.
pub const SECTION_ENTRY_BYTES: u64 = 96;
/// Bytes of one entry of a page table.
pub const PAGE_ENTRY_BYTES: u64 = 48;
/// Data of a section start at a multiple of this.
pub const SECTION_ALIGN: u64 = 64;
/// Pages start at a multiple of this.
pub const PAGE_ALIGN: u64 = 16;

/// Largest number of sections of a file.
pub const MAX_SECTIONS: u32 = 65_536;
/// Largest number of pages of a file, over all sections.
pub const MAX_PAGES: u64 = 4_194_304;
/// Smallest `page_bytes` of a section: the largest block (64 bands) fits.
pub const MIN_PAGE_BYTES: u32 = 20_480;
/// Largest `page_bytes` of a section.
pub const MAX_PAGE_BYTES: u32 = 4_194_304;
/// `page_bytes` must be a multiple of this.
pub const PAGE_BYTES_STEP: u32 = 4_096;
/// Largest size of a species' metadata, in bytes.
pub const MAX_METADATA_BYTES: u64 = 1_048_576;
/// Largest size of the metadata of all species of a file, in bytes.
pub const MAX_ALL_METADATA_BYTES: u64 = 8_388_608;
/// Largest size of all payloads of a file, in bytes, shared ones counted each time; stored bytes are never more.
pub const MAX_ALL_BYTES: u64 = 1 << 40;
/// Largest size of the payloads of a base's detail, in bytes.
pub const MAX_DETAIL_BYTES: u64 = 1 << 28;
/// Species of a section of unknown kind that belongs to the file as a whole.
pub const NO_SPECIES: u32 = u32::MAX;
/// Largest number of bands of a species.
pub const MAX_BANDS: u32 = 64;
/// Smallest and largest lattice; powers of two only.
pub const LATTICES: std::ops::RangeInclusive<u32> = 16..=256;
/// Largest window that a zstd frame may ask for.
pub const MAX_WINDOW_BYTES: u64 = 8_388_608;
/// Largest magnitude of a stored number of a base, 2^96: no sum of a decode can overflow.
pub const MAX_MAGNITUDE: f32 = 79_228_162_514_264_337_593_543_950_336.0;
/// Largest magnitude that codec 6 (`raw-f16`) stores: the largest finite binary16.
pub const MAX_MAGNITUDE_F16: f32 = 65_504.0;

/// Section kind 1: metadata of a species, canonical JSON.
pub const KIND_METADATA: u32 = 1;
/// Section kind 2: one array of a species' medium.
pub const KIND_MEDIUM: u32 = 2;
/// Section kind 3: one base of a species.
pub const KIND_BASE: u32 = 3;
/// Section kind 4: what the bases of a species share that are stored as blocks near geometry.
pub const KIND_BLOCKS: u32 = 4;
/// Section kind 5: head and averages of one such base.
pub const KIND_AVERAGES: u32 = 5;
/// Section kind 6: detail of one such base.
pub const KIND_DETAIL: u32 = 6;
/// Every kind of section that this reader knows.
pub const KINDS: std::ops::RangeInclusive<u32> = KIND_METADATA..=KIND_DETAIL;

/// Item of kind 4: the block map.
pub const BLOCKS_MAP: u32 = 0;
/// Item of kind 4: the class tables of `classed`.
pub const BLOCKS_CLASSES: u32 = 1;

/// Items of kind 2. The first four are in every species, the extinctions in those of the model `physical` only.
pub const MEDIUM_ITEMS: [&str; 6] =
    ["density", "class", "leaf_area_density", "wood_area_density", "leaf_extinction", "wood_extinction"];
/// First item of kind 2 that only `physical` species have.
pub const MEDIUM_EXTINCTION: u32 = 4;
/// Number of items of kinds 3, 5 and 6 that an entry may name; how many a species has is up to its model.
pub const BASE_ITEMS: u32 = 256;

/// Section flag bit 0: a reader that does not know the kind must refuse the file.
pub const FLAG_REQUIRED: u32 = 1;
/// Section flag bit 1: a rewriter that does not know the kind may copy the section.
pub const FLAG_COPY: u32 = 2;

/// Codec 1: f32 little-endian, one after another.
pub const CODEC_RAW_F32: u32 = 1;
/// Codec 2: the papers' block codec.
pub const CODEC_HAAR_PAPER: u32 = 2;
/// Codec 3: f32, zeros left out under a mask.
pub const CODEC_SPARSE_F32: u32 = 3;
/// Codec 4: u8, zeros left out under a mask.
pub const CODEC_SPARSE_U8: u32 = 4;
/// Codec 5: canonical JSON.
pub const CODEC_JSON: u32 = 5;
/// Codec 6: binary16 little-endian, one after another.
pub const CODEC_RAW_F16: u32 = 6;
/// Codec 7: detail of blocks near geometry, by classes.
pub const CODEC_CLASSED: u32 = 7;
/// Codec 8: detail of blocks near geometry, by masks over Haar coefficients.
pub const CODEC_HAAR: u32 = 8;
/// Codec 9: a block map.
pub const CODEC_BLOCK_MAP: u32 = 9;
/// Codec 10: class tables.
pub const CODEC_CLASSES: u32 = 10;
/// Codec 11: head and averages of a base.
pub const CODEC_AVERAGES: u32 = 11;

/// Codec of a base.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Hash)]
#[cfg_attr(feature = "clap", derive(clap::ValueEnum))]
pub enum Codec {
    /// Blocks of 4^3 near geometry, quantised to an error, coefficients by the class of their block: the smallest.
    Classed,
    /// Haar blocks of 4^3 near geometry, quantised to an error, coefficients under a mask of 64 bits.
    Haar,
    /// The papers' Haar blocks of 4^3 at stride 3, thresholded.
    HaarPaper,
    /// Values as they are, 32-bit floats.
    RawF32,
    /// Values rounded to the nearest 16-bit float; above 65504 they are refused.
    RawF16,
}

impl Codec {
    /// Every codec of bases.
    pub const ALL: [Codec; 5] = [Codec::RawF32, Codec::RawF16, Codec::HaarPaper, Codec::Classed, Codec::Haar];

    /// The name used in reports and on the command line.
    pub fn name(self) -> &'static str {
        match self {
            Codec::RawF32 => "raw-f32",
            Codec::RawF16 => "raw-f16",
            Codec::HaarPaper => "haar-paper",
            Codec::Classed => "classed",
            Codec::Haar => "haar",
        }
    }

    /// The number used in files.
    pub fn number(self) -> u32 {
        match self {
            Codec::RawF32 => CODEC_RAW_F32,
            Codec::RawF16 => CODEC_RAW_F16,
            Codec::HaarPaper => CODEC_HAAR_PAPER,
            Codec::Classed => CODEC_CLASSED,
            Codec::Haar => CODEC_HAAR,
        }
    }

    /// Whether only blocks near geometry are stored, averages and detail apart ([`crate::blocks`]).
    pub fn is_near_geometry(self) -> bool {
        matches!(self, Codec::Classed | Codec::Haar)
    }

    /// The codec of a base with this number.
    pub fn from_number(number: u32) -> Option<Codec> {
        Codec::ALL.into_iter().find(|codec| codec.number() == number)
    }

    /// The codec of this name.
    pub fn from_name(name: &str) -> Option<Codec> {
        Codec::ALL.into_iter().find(|codec| codec.name() == name)
    }

    /// Largest magnitude of a value that can be coded.
    pub fn max_magnitude(self) -> f32 {
        match self {
            Codec::RawF32 | Codec::HaarPaper | Codec::Classed | Codec::Haar => MAX_MAGNITUDE,
            Codec::RawF16 => MAX_MAGNITUDE_F16,
        }
    }
}

/// Key that identifies a section: its kind, its species, and the item within that kind. Sections are sorted by it in
/// this order of fields.
#[derive(Debug, Clone, Copy, PartialEq, Eq, PartialOrd, Ord, Hash)]
pub struct SectionKey {
    /// One of [`KINDS`]; others are not known to this version.
    pub kind: u32,
    /// Index of the species.
    pub species: u32,
    /// Base index, medium array, or 0.
    pub item: u32,
}

impl fmt::Display for SectionKey {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        let SectionKey { kind, species, item } = self;
        match (*kind, MEDIUM_ITEMS.get(*item as usize)) {
            (KIND_METADATA, _) => write!(f, "metadata of species {species}"),
            (KIND_MEDIUM, Some(name)) => write!(f, "{name} of species {species}"),
            (KIND_BASE, _) => write!(f, "base {item} of species {species}"),
            (KIND_BLOCKS, _) if *item == BLOCKS_MAP => write!(f, "block map of species {species}"),
            (KIND_BLOCKS, _) if *item == BLOCKS_CLASSES => write!(f, "class tables of species {species}"),
            (KIND_AVERAGES, _) => write!(f, "averages of base {item} of species {species}"),
            (KIND_DETAIL, _) => write!(f, "detail of base {item} of species {species}"),
            _ => write!(f, "section (kind {kind}, species {species}, item {item})"),
        }
    }
}

/// The header, without magic and digest.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub struct Header {
    /// Major and minor version.
    pub version: (u16, u16),
    /// Size of the header itself.
    pub header_bytes: u32,
    /// Features that a reader must know.
    pub required_features: u64,
    /// Features that a reader may ignore.
    pub optional_features: u64,
    /// Length of the file.
    pub file_bytes: u64,
    /// Offset of the table of contents.
    pub contents_offset: u64,
    /// Bytes of the table of contents.
    pub contents_bytes: u64,
    /// Entries of the table of contents.
    pub section_count: u32,
    /// Zero.
    pub reserved_60: u32,
    /// xxh3-64 of the table of contents.
    pub contents_digest: u64,
    /// Offset of the first byte behind the last page table.
    pub tables_end: u64,
    /// BLAKE3 of bytes 0..80 and of everything from byte 128 on.
    pub root: [u8; 32],
    /// Zero.
    pub reserved_112: u64,
}

/// Length of the header's part that the BLAKE3 root covers.
pub const ROOT_HEAD_BYTES: usize = 80;
/// Length of the header's part that its digest covers.
pub const HEADER_DIGESTED_BYTES: usize = 120;

impl Header {
    /// Whether the file is of the draft.
    pub fn is_draft(&self) -> bool {
        self.version.0 == DRAFT_MAJOR
    }

    /// Kinds of sections that the file's version knows.
    pub fn kinds(&self) -> std::ops::RangeInclusive<u32> {
        if self.is_draft() { DRAFT_KINDS } else { KINDS }
    }

    /// The header's bytes, digest included.
    pub fn to_bytes(&self) -> [u8; HEADER_BYTES as usize] {
        let mut bytes = [0; HEADER_BYTES as usize];
        bytes[0..8].copy_from_slice(&MAGIC);
        bytes[8..10].copy_from_slice(&self.version.0.to_le_bytes());
        bytes[10..12].copy_from_slice(&self.version.1.to_le_bytes());
        bytes[12..16].copy_from_slice(&self.header_bytes.to_le_bytes());
        bytes[16..24].copy_from_slice(&self.required_features.to_le_bytes());
        bytes[24..32].copy_from_slice(&self.optional_features.to_le_bytes());
        bytes[32..40].copy_from_slice(&self.file_bytes.to_le_bytes());
        bytes[40..48].copy_from_slice(&self.contents_offset.to_le_bytes());
        bytes[48..56].copy_from_slice(&self.contents_bytes.to_le_bytes());
        bytes[56..60].copy_from_slice(&self.section_count.to_le_bytes());
        bytes[60..64].copy_from_slice(&self.reserved_60.to_le_bytes());
        bytes[64..72].copy_from_slice(&self.contents_digest.to_le_bytes());
        bytes[72..80].copy_from_slice(&self.tables_end.to_le_bytes());
        bytes[80..112].copy_from_slice(&self.root);
        bytes[112..120].copy_from_slice(&self.reserved_112.to_le_bytes());
        let digest = super::digest::plain(&bytes[..HEADER_DIGESTED_BYTES]);
        bytes[120..128].copy_from_slice(&digest.to_le_bytes());
        bytes
    }

    /// The fields of a header and the digest that it stores; nothing is checked.
    pub fn from_bytes(bytes: &[u8; HEADER_BYTES as usize]) -> (Header, u64) {
        let mut fields = Fields { bytes, at: 8 };
        let header = Header {
            version: (fields.u16(), fields.u16()),
            header_bytes: fields.u32(),
            required_features: fields.u64(),
            optional_features: fields.u64(),
            file_bytes: fields.u64(),
            contents_offset: fields.u64(),
            contents_bytes: fields.u64(),
            section_count: fields.u32(),
            reserved_60: fields.u32(),
            contents_digest: fields.u64(),
            tables_end: fields.u64(),
            root: fields.array(),
            reserved_112: fields.u64(),
        };
        (header, fields.u64())
    }
}

/// One entry of the table of contents.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct SectionEntry {
    /// Kind, species, item.
    pub key: SectionKey,
    /// [`FLAG_REQUIRED`], [`FLAG_COPY`].
    pub flags: u32,
    /// Offset of the first page.
    pub data_offset: u64,
    /// Bytes from the first page's first to the last page's last, padding between pages included.
    pub data_bytes: u64,
    /// Bytes of all pages before compression.
    pub raw_bytes: u64,
    /// Offset of the page table.
    pub table_offset: u64,
    /// Entries of the page table.
    pub page_count: u32,
    /// Codec of the pages.
    pub codec: u32,
    /// Relative threshold of `haar-paper`, else 0.
    pub threshold: f32,
    /// Largest size of a page before compression, in bytes.
    pub page_bytes: u32,
    /// Sites per edge of the lattice; 0 for metadata.
    pub lattice: u32,
    /// Values per site: bands of a base, 1 for the medium, 0 for metadata.
    pub bands: u32,
    /// Units over all pages: blocks, values or bytes, as the codec says.
    pub units: u64,
    /// Zero.
    pub reserved: u64,
    /// xxh3-64 of the page table.
    pub table_digest: u64,
}

impl SectionEntry {
    /// The record's bytes.
    pub fn to_bytes(&self) -> [u8; SECTION_ENTRY_BYTES as usize] {
        let mut bytes = [0; SECTION_ENTRY_BYTES as usize];
        bytes[0..4].copy_from_slice(&self.key.kind.to_le_bytes());
        bytes[4..8].copy_from_slice(&self.key.species.to_le_bytes());
        bytes[8..12].copy_from_slice(&self.key.item.to_le_bytes());
        bytes[12..16].copy_from_slice(&self.flags.to_le_bytes());
        bytes[16..24].copy_from_slice(&self.data_offset.to_le_bytes());
        bytes[24..32].copy_from_slice(&self.data_bytes.to_le_bytes());
        bytes[32..40].copy_from_slice(&self.raw_bytes.to_le_bytes());
        bytes[40..48].copy_from_slice(&self.table_offset.to_le_bytes());
        bytes[48..52].copy_from_slice(&self.page_count.to_le_bytes());
        bytes[52..56].copy_from_slice(&self.codec.to_le_bytes());
        bytes[56..60].copy_from_slice(&self.threshold.to_le_bytes());
        bytes[60..64].copy_from_slice(&self.page_bytes.to_le_bytes());
        bytes[64..68].copy_from_slice(&self.lattice.to_le_bytes());
        bytes[68..72].copy_from_slice(&self.bands.to_le_bytes());
        bytes[72..80].copy_from_slice(&self.units.to_le_bytes());
        bytes[80..88].copy_from_slice(&self.reserved.to_le_bytes());
        bytes[88..96].copy_from_slice(&self.table_digest.to_le_bytes());
        bytes
    }

    /// The record in these bytes; nothing is checked.
    pub fn from_bytes(bytes: &[u8; SECTION_ENTRY_BYTES as usize]) -> SectionEntry {
        let mut fields = Fields { bytes, at: 0 };
        SectionEntry {
            key: SectionKey { kind: fields.u32(), species: fields.u32(), item: fields.u32() },
            flags: fields.u32(),
            data_offset: fields.u64(),
            data_bytes: fields.u64(),
            raw_bytes: fields.u64(),
            table_offset: fields.u64(),
            page_count: fields.u32(),
            codec: fields.u32(),
            threshold: f32::from_bits(fields.u32()),
            page_bytes: fields.u32(),
            lattice: fields.u32(),
            bands: fields.u32(),
            units: fields.u64(),
            reserved: fields.u64(),
            table_digest: fields.u64(),
        }
    }
}

/// Encoding of a stored page: the payload as it is.
pub const STORED_PLAIN: u32 = 0;
/// Encoding of a stored page: one zstd frame.
pub const STORED_ZSTD: u32 = 1;

/// One entry of a page table.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct PageEntry {
    /// Offset of the stored bytes.
    pub offset: u64,
    /// Stored bytes.
    pub stored_bytes: u32,
    /// Bytes of the payload, before compression.
    pub raw_bytes: u32,
    /// Index of the first unit of the page in its section.
    pub first: u64,
    /// Units of the page.
    pub count: u32,
    /// [`STORED_PLAIN`] or [`STORED_ZSTD`].
    pub compression: u32,
    /// Squared error that reading the page removes, in squares of the base's peak, summed over texels and bands; 0
    /// where everything needs the page. In files of the draft always 0.
    pub priority: f32,
    /// Zero.
    pub reserved: u32,
    /// xxh3-64 of the page's key, index and stored bytes.
    pub digest: u64,
}

impl PageEntry {
    /// The record's bytes.
    pub fn to_bytes(&self) -> [u8; PAGE_ENTRY_BYTES as usize] {
        let mut bytes = [0; PAGE_ENTRY_BYTES as usize];
        bytes[0..8].copy_from_slice(&self.offset.to_le_bytes());
        bytes[8..12].copy_from_slice(&self.stored_bytes.to_le_bytes());
        bytes[12..16].copy_from_slice(&self.raw_bytes.to_le_bytes());
        bytes[16..24].copy_from_slice(&self.first.to_le_bytes());
        bytes[24..28].copy_from_slice(&self.count.to_le_bytes());
        bytes[28..32].copy_from_slice(&self.compression.to_le_bytes());
        bytes[32..36].copy_from_slice(&self.priority.to_le_bytes());
        bytes[36..40].copy_from_slice(&self.reserved.to_le_bytes());
        bytes[40..48].copy_from_slice(&self.digest.to_le_bytes());
        bytes
    }

    /// The record in these bytes; nothing is checked.
    pub fn from_bytes(bytes: &[u8; PAGE_ENTRY_BYTES as usize]) -> PageEntry {
        let mut fields = Fields { bytes, at: 0 };
        PageEntry {
            offset: fields.u64(),
            stored_bytes: fields.u32(),
            raw_bytes: fields.u32(),
            first: fields.u64(),
            count: fields.u32(),
            compression: fields.u32(),
            priority: f32::from_bits(fields.u32()),
            reserved: fields.u32(),
            digest: fields.u64(),
        }
    }
}

/// The next multiple of `align` from `offset` on; `None` past the end of u64.
pub fn align_up(offset: u64, align: u64) -> Option<u64> {
    offset.checked_next_multiple_of(align)
}

/// Reads little-endian fields one after another from a record of known size.
struct Fields<'a> {
    bytes: &'a [u8],
    at: usize,
}

impl Fields<'_> {
    fn array<const N: usize>(&mut self) -> [u8; N] {
        let field = self.bytes[self.at..self.at + N].try_into().expect("N bytes make an array of N");
        self.at += N;
        field
    }

    fn u16(&mut self) -> u16 {
        u16::from_le_bytes(self.array())
    }

    fn u32(&mut self) -> u32 {
        u32::from_le_bytes(self.array())
    }

    fn u64(&mut self) -> u64 {
        u64::from_le_bytes(self.array())
    }
}
