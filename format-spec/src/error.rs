//! Everything that can be wrong with a file, one numbered variant per broken promise of `SPEC.md`.
//!
//! The number is part of the format's interface: it never changes its meaning (SPEC.md, section 12).

use std::fmt;
use std::io;

use crate::blocks::{BlockFault, Rule};
use crate::container::records::{DRAFT_MAJOR, SectionKey, VERSION};

/// Place in a file at which something was found.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub struct Place {
    /// The part of the file.
    pub part: Part,
    /// Offset in bytes from the start of the file.
    pub offset_bytes: u64,
    /// The section, where one is known.
    pub section: Option<SectionKey>,
    /// Index of the page in its section, where one is known.
    pub page: Option<u32>,
}

/// The parts of a file that a [`Place`] can lie in.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Part {
    /// The file as a whole.
    File,
    /// The fixed header.
    Header,
    /// The table of contents.
    Contents,
    /// The page table of a section.
    PageTable,
    /// The content of a section, over all its pages.
    Section,
    /// One page.
    Page,
    /// Filling between pages or sections.
    Padding,
}

impl Place {
    /// The header's field at this offset.
    pub fn header(offset_bytes: u64) -> Place {
        Place { part: Part::Header, offset_bytes, section: None, page: None }
    }

    /// The file at this offset.
    pub fn file(offset_bytes: u64) -> Place {
        Place { part: Part::File, offset_bytes, section: None, page: None }
    }

    /// Filling at this offset.
    pub fn padding(offset_bytes: u64) -> Place {
        Place { part: Part::Padding, offset_bytes, section: None, page: None }
    }

    /// The table of contents at this offset, in the entry of this section.
    pub fn contents(offset_bytes: u64, section: Option<SectionKey>) -> Place {
        Place { part: Part::Contents, offset_bytes, section, page: None }
    }

    /// The page table of a section at this offset, in the entry of this page.
    pub fn page_table(offset_bytes: u64, section: SectionKey, page: Option<u32>) -> Place {
        Place { part: Part::PageTable, offset_bytes, section: Some(section), page }
    }

    /// The content of a section that starts at this offset.
    pub fn section(offset_bytes: u64, section: SectionKey) -> Place {
        Place { part: Part::Section, offset_bytes, section: Some(section), page: None }
    }

    /// A page whose stored bytes start at this offset.
    pub fn page(offset_bytes: u64, section: SectionKey, page: u32) -> Place {
        Place { part: Part::Page, offset_bytes, section: Some(section), page: Some(page) }
    }
}

impl fmt::Display for Place {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        match self.part {
            Part::File => write!(f, "file")?,
            Part::Header => write!(f, "header")?,
            Part::Contents => write!(f, "table of contents")?,
            Part::PageTable => write!(f, "page table")?,
            Part::Section => write!(f, "section")?,
            Part::Page => write!(f, "page")?,
            Part::Padding => write!(f, "padding")?,
        }
        match (self.part, self.page) {
            (Part::Page, Some(page)) => write!(f, " {page}")?,
            (_, Some(page)) => write!(f, " entry {page}")?,
            _ => {}
        }
        if let Some(section) = self.section {
            write!(f, " of {section}")?;
        }
        write!(f, " at byte {}", self.offset_bytes)
    }
}

/// Class of an error, by which a caller treats it; the command line maps it to an exit code.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum ErrorClass {
    /// The bytes break a promise of the format.
    Invalid,
    /// The file may be sound, but needs a newer or richer reader.
    Unsupported,
    /// The file asks for more than this reader's limits.
    Limit,
    /// The bytes could not be read.
    Io,
    /// The caller asked for a species, base or page that the file does not hold.
    Request,
}

/// A broken promise, where it was found, what was read and what was expected.
#[derive(Debug, thiserror::Error)]
#[allow(missing_docs, reason = "the fields repeat the messages: place, what was read, what was expected")]
#[non_exhaustive]
pub enum FormatError {
    /// The operating system could not deliver bytes that the file's length promises.
    #[error("FLB-1000 {place}: cannot read {bytes} bytes: {source}")]
    Read { place: Place, bytes: u64, source: io::Error },
    #[error("FLB-1001 {place}: the file has {found} bytes, expected at least {expected}")]
    TooShort { place: Place, found: u64, expected: u64 },
    #[error("FLB-1002 {place}: magic {found:02x?}, expected {expected:02x?}: {hint}")]
    Magic { place: Place, found: [u8; 8], expected: [u8; 8], hint: &'static str },
    #[error(
        "FLB-1003 {place}: format version {}.{}, this reader knows major versions {DRAFT_MAJOR} and {}",
        found.0, found.1, VERSION.0
    )]
    Version { place: Place, found: (u16, u16) },
    #[error("FLB-1004 {place}: required feature bit {bit} is not known to this reader")]
    Feature { place: Place, bit: u32 },
    #[error("FLB-1005 {place}: header digest {stored:016x}, expected {computed:016x}")]
    HeaderDigest { place: Place, stored: u64, computed: u64 },
    #[error("FLB-1006 {place}: header of {found} bytes, expected {expected}")]
    HeaderSize { place: Place, found: u32, expected: u32 },
    #[error("FLB-1007 {place}: reserved field holds {found:#x}, expected 0")]
    Reserved { place: Place, found: u64 },
    #[error("FLB-1008 {place}: the file has {found} bytes, its header promises {expected}")]
    FileLength { place: Place, found: u64, expected: u64 },
    #[error("FLB-1009 {place}: {what} is {found}, over the limit of {limit}")]
    Limit { place: Place, what: &'static str, found: u64, limit: u64 },
    #[error("FLB-1010 {place}: feature bit {bit} is {found}, but {source_of_truth} say {expected}")]
    FeatureUse { place: Place, bit: &'static str, found: bool, source_of_truth: &'static str, expected: bool },

    #[error("FLB-2001 {place}: {what} is {found}, expected {expected}")]
    ContentsPlace { place: Place, what: &'static str, found: u64, expected: u64 },
    #[error("FLB-2002 {place}: digest {stored:016x} in the header, expected {computed:016x}")]
    ContentsDigest { place: Place, stored: u64, computed: u64 },
    #[error("FLB-2003 {place}: it follows {previous}, expected ascending order")]
    SectionOrder { place: Place, previous: SectionKey },
    #[error("FLB-2004 {place}: the section is listed twice")]
    SectionTwice { place: Place },
    #[error("FLB-2005 {place}: required section kind {kind} is not known to this reader")]
    SectionKind { place: Place, kind: u32 },
    #[error("FLB-2006 {place}: codec {found} is not known to this reader for such a section")]
    Codec { place: Place, found: u32 },
    #[error("FLB-2007 {place}: {what} is {found}, expected {expected}")]
    SectionField { place: Place, what: &'static str, found: String, expected: String },
    #[error("FLB-2008 {place}: species {species} has no {missing}")]
    SectionMissing { place: Place, species: u32, missing: String },
    #[error("FLB-2009 {place}: data at byte {found}, expected {expected} (no hole, no overlap)")]
    SectionPlace { place: Place, found: u64, expected: u64 },

    #[error("FLB-3001 {place}: the page table lies at byte {found}, expected {expected}")]
    TablePlace { place: Place, found: u64, expected: u64 },
    #[error("FLB-3002 {place}: digest {stored:016x} in the contents, expected {computed:016x}")]
    TableDigest { place: Place, stored: u64, computed: u64 },
    #[error(
        "FLB-3003 {place}: the page lies at byte {found}, expected {expected}, or where an earlier page of its size lies"
    )]
    PagePlace { place: Place, found: u64, expected: u64 },
    #[error("FLB-3004 {place}: {what} is {found}, expected {expected}")]
    PageSize { place: Place, what: &'static str, found: u64, expected: String },
    #[error("FLB-3005 {place}: {what} is {found}, expected {expected}")]
    PageUnits { place: Place, what: &'static str, found: u64, expected: String },
    #[error("FLB-3006 {place}: {what} is {found}, but its pages give {expected}")]
    SectionSum { place: Place, what: &'static str, found: u64, expected: u64 },
    #[error("FLB-3007 {place}: page compression {found} is not known to this reader")]
    Compression { place: Place, found: u32 },
    #[error("FLB-3008 {place}: priority is {found}, expected {expected}")]
    PagePriority { place: Place, found: f32, expected: &'static str },

    #[error("FLB-4001 {place}: digest {stored:016x} in the table, expected {computed:016x}")]
    PageDigest { place: Place, stored: u64, computed: u64 },
    #[error("FLB-4002 {place}: zstd frame refused: {reason}")]
    Frame { place: Place, reason: String },
    #[error("FLB-4003 {place}: payload of {found} bytes, expected {expected}")]
    PayloadLength { place: Place, found: u64, expected: u64 },
    #[error("FLB-4004 {place}: byte {found:#04x}, expected 0")]
    Padding { place: Place, found: u8 },
    #[error("FLB-4005 {place}: BLAKE3 root {stored}, expected {computed}")]
    Root { place: Place, stored: String, computed: String },

    #[error("FLB-5001 {place}: metadata is not JSON: {reason}")]
    Json { place: Place, reason: String },
    #[error("FLB-5002 {place}: JSON is not canonical: {reason}")]
    JsonForm { place: Place, reason: String },
    #[error("FLB-5003 {place}: {field} is {found}, expected {expected}")]
    MetaValue { place: Place, field: String, found: String, expected: String },
    #[error("FLB-5004 {place}: name {name:?} is taken by species {other}")]
    SpeciesName { place: Place, name: String, other: u32 },
    #[error("FLB-5005 {place}: index of block {block} is {found}, the masks before it give {expected}")]
    BlockIndex { place: Place, block: u32, found: u32, expected: u64 },
    #[error("FLB-5006 {place}: value {index} is {found}, expected {expected}")]
    Value { place: Place, index: u64, found: f32, expected: &'static str },
    #[error("FLB-5007 {place}: coefficient {coefficient} of block {block} is kept, expected {expected}")]
    Coefficient { place: Place, block: u32, coefficient: u32, expected: String },
    #[error("FLB-5008 {place}: site {site} has class {class} and density {density}, expected {expected}")]
    Class { place: Place, site: u64, class: u8, density: f32, expected: &'static str },
    #[error("FLB-5009 {place}: base {base} is present, but the metadata say that it was left out: {reason}")]
    LeftOutPresent { place: Place, base: u8, reason: String },
    #[error("FLB-5010 {place}: block map: {fault}")]
    BlockMap { place: Place, fault: Box<BlockFault> },
    #[error("FLB-5011 {place}: class tables: {fault}")]
    BlockClasses { place: Place, fault: Box<BlockFault> },
    #[error("FLB-5012 {place}: head: {fault}")]
    BaseHead { place: Place, fault: Box<BlockFault> },
    #[error("FLB-5013 {place}: averages: {fault}")]
    Averages { place: Place, fault: Box<BlockFault> },
    #[error("FLB-5014 {place}: detail: {fault}")]
    Detail { place: Place, fault: Box<BlockFault> },
    #[error("FLB-5015 {place}: species {species}: {reason}")]
    MaterialSurfaces { place: Place, species: usize, reason: String },

    #[error("FLB-6001 species {found} was asked for, the file has {count}")]
    NoSpecies { found: usize, count: usize },
    #[error("FLB-6002 base {base} was asked for, species {species} has no such base")]
    NoBase { species: usize, base: u8 },
    #[error("FLB-6005 base {base} was asked for, but it was left out of species {species}: {reason}")]
    BaseLeftOut { species: usize, base: u8, reason: String },
    #[error("FLB-6003 page {page} of section {section} was asked for, there is none")]
    NoPage { section: usize, page: u32 },
    #[error(
        "FLB-6006 the extinction was asked for, species {species} is of the model \"paper\" and has none"
    )]
    NoExtinction { species: usize },
    #[error("FLB-6004 {place}: pages of another codec were asked for, this section's is {codec}")]
    NoBlocks { place: Place, codec: &'static str },
    #[error("FLB-6007 {place}: {bytes} bytes of memory needed for {what}, which the system does not give")]
    Memory { place: Place, what: &'static str, bytes: u64 },
}

macro_rules! codes {
    ($($number:literal $variant:ident $class:ident),* $(,)?) => {
        impl FormatError {
            /// The number of the broken promise: 1003 for `FLB-1003`.
            pub fn code(&self) -> u32 {
                match self { $(FormatError::$variant { .. } => $number),* }
            }

            /// Class of the error, by which a caller treats it.
            pub fn class(&self) -> ErrorClass {
                match self { $(FormatError::$variant { .. } => ErrorClass::$class),* }
            }
        }

        /// Every code that a [`FormatError`] can have, ascending.
        pub const CODES: &[u32] = &[$($number),*];
    };
}

codes! {
    1000 Read Io, 1001 TooShort Invalid, 1002 Magic Invalid, 1003 Version Unsupported,
    1004 Feature Unsupported, 1005 HeaderDigest Invalid, 1006 HeaderSize Invalid,
    1007 Reserved Invalid, 1008 FileLength Invalid, 1009 Limit Limit, 1010 FeatureUse Invalid,
    2001 ContentsPlace Invalid, 2002 ContentsDigest Invalid, 2003 SectionOrder Invalid,
    2004 SectionTwice Invalid, 2005 SectionKind Unsupported, 2006 Codec Unsupported,
    2007 SectionField Invalid, 2008 SectionMissing Invalid, 2009 SectionPlace Invalid,
    3001 TablePlace Invalid, 3002 TableDigest Invalid, 3003 PagePlace Invalid,
    3004 PageSize Invalid, 3005 PageUnits Invalid, 3006 SectionSum Invalid,
    3007 Compression Unsupported, 3008 PagePriority Invalid,
    4001 PageDigest Invalid, 4002 Frame Invalid, 4003 PayloadLength Invalid,
    4004 Padding Invalid, 4005 Root Invalid,
    5001 Json Invalid, 5002 JsonForm Invalid, 5003 MetaValue Invalid, 5004 SpeciesName Invalid,
    5005 BlockIndex Invalid, 5006 Value Invalid, 5007 Coefficient Invalid, 5008 Class Invalid,
    5009 LeftOutPresent Invalid, 5010 BlockMap Invalid, 5011 BlockClasses Invalid,
    5012 BaseHead Invalid, 5013 Averages Invalid, 5014 Detail Invalid, 5015 MaterialSurfaces Invalid,
    6001 NoSpecies Request, 6002 NoBase Request, 6003 NoPage Request, 6004 NoBlocks Request,
    6005 BaseLeftOut Request, 6006 NoExtinction Request, 6007 Memory Limit,
}

impl FormatError {
    /// A broken rule of blocks near geometry, found at a place.
    pub fn blocks(place: Place, fault: BlockFault) -> FormatError {
        let fault = Box::new(fault);
        match fault.rule {
            Rule::MapLength | Rule::MapEmpty => FormatError::BlockMap { place, fault },
            Rule::ClassesLength | Rule::ClassWidth | Rule::ClassOrder => {
                FormatError::BlockClasses { place, fault }
            }
            Rule::HeadLength | Rule::HeadField => FormatError::BaseHead { place, fault },
            Rule::AveragesLength | Rule::AveragesCode | Rule::AverageRange => {
                FormatError::Averages { place, fault }
            }
            Rule::DetailBlocks
            | Rule::DetailLength
            | Rule::BlockClass
            | Rule::BlockMask
            | Rule::DetailSize => FormatError::Detail { place, fault },
        }
    }

    /// Place of the fault; `None` for a request that no file could answer.
    pub fn place(&self) -> Option<Place> {
        use FormatError as E;
        match self {
            E::NoSpecies { .. }
            | E::NoBase { .. }
            | E::BaseLeftOut { .. }
            | E::NoExtinction { .. }
            | E::NoPage { .. } => None,
            E::Read { place, .. }
            | E::TooShort { place, .. }
            | E::Magic { place, .. }
            | E::Version { place, .. }
            | E::Feature { place, .. }
            | E::HeaderDigest { place, .. }
            | E::HeaderSize { place, .. }
            | E::Reserved { place, .. }
            | E::FileLength { place, .. }
            | E::Limit { place, .. }
            | E::Memory { place, .. }
            | E::FeatureUse { place, .. }
            | E::ContentsPlace { place, .. }
            | E::ContentsDigest { place, .. }
            | E::SectionOrder { place, .. }
            | E::SectionTwice { place }
            | E::SectionKind { place, .. }
            | E::Codec { place, .. }
            | E::SectionField { place, .. }
            | E::SectionMissing { place, .. }
            | E::SectionPlace { place, .. }
            | E::TablePlace { place, .. }
            | E::TableDigest { place, .. }
            | E::PagePlace { place, .. }
            | E::PageSize { place, .. }
            | E::PageUnits { place, .. }
            | E::SectionSum { place, .. }
            | E::Compression { place, .. }
            | E::PagePriority { place, .. }
            | E::PageDigest { place, .. }
            | E::Frame { place, .. }
            | E::PayloadLength { place, .. }
            | E::Padding { place, .. }
            | E::Root { place, .. }
            | E::Json { place, .. }
            | E::JsonForm { place, .. }
            | E::MetaValue { place, .. }
            | E::SpeciesName { place, .. }
            | E::BlockIndex { place, .. }
            | E::Value { place, .. }
            | E::Coefficient { place, .. }
            | E::Class { place, .. }
            | E::LeftOutPresent { place, .. }
            | E::BlockMap { place, .. }
            | E::BlockClasses { place, .. }
            | E::BaseHead { place, .. }
            | E::Averages { place, .. }
            | E::Detail { place, .. }
            | E::MaterialSurfaces { place, .. }
            | E::NoBlocks { place, .. } => Some(*place),
        }
    }
}
