//! Everything that can be wrong with an input: a mesh file, a species file, a material's class.

use std::io;
use std::path::PathBuf;

use flb_format::text::{escaped, url};

/// Reason why an input was refused. Every message names the file, the place, what was found and what was expected.
#[derive(Debug, thiserror::Error)]
#[non_exhaustive]
pub enum ImportError {
    /// A file cannot be opened or read.
    #[error("{}: cannot be read: {source}", path.display())]
    Io {
        /// The file.
        path: PathBuf,
        /// The system's reason.
        source: io::Error,
    },
    /// A file that the mesh cannot do without is not there.
    #[error("{file}: {place} names '{uri}', which is not there (looked for {})", looked_for.display())]
    MissingFile {
        /// The file that names the other one.
        file: String,
        /// Place in the file.
        place: String,
        /// The name as written.
        uri: String,
        /// The path that was tried.
        looked_for: PathBuf,
    },
    /// A name that leads out of the mesh's folder, to something that is there.
    #[error(
        "{file}: {place} names '{uri}', which lies outside the mesh's folder ({}); put it beside the mesh",
        leads_to.display()
    )]
    OutsideFolder {
        /// The file that names the other one.
        file: String,
        /// Place in the file.
        place: String,
        /// The name as written.
        uri: String,
        /// Path that the name leads to.
        leads_to: PathBuf,
    },
    /// File that is neither glTF, GLB nor OBJ.
    #[error("{file}: unknown kind of mesh: found {found}, expected .gltf, .glb or .obj")]
    UnknownFormat {
        /// The file.
        file: String,
        /// Extension or first bytes.
        found: String,
    },
    /// A glTF of another major version.
    #[error("{file}: glTF version {found}, expected 2.x")]
    UnsupportedVersion {
        /// The file.
        file: String,
        /// The version as written.
        found: String,
    },
    /// The file says that it cannot be read without an extension that is not supported.
    #[error("{file}: requires the extension {name}{advice}")]
    RequiredExtension {
        /// The file.
        file: String,
        /// The extension, and what is the matter with it.
        name: String,
        /// Advice for the user; may be empty, else starts with a separator.
        advice: &'static str,
    },
    /// JSON, TOML or text that does not parse; the message holds line and column.
    #[error("{file}: {message}")]
    Syntax {
        /// The file.
        file: String,
        /// Message of the parser, with its place.
        message: String,
    },
    /// A value that contradicts the format or the rest of the file.
    #[error("{file}: {place}: found {found}, expected {expected}")]
    Malformed {
        /// The file.
        file: String,
        /// Place in the file.
        place: String,
        /// Value that was read.
        found: String,
        /// Value that would have been right.
        expected: String,
    },
    /// A coordinate that is not a number.
    #[error("{file}: {place}: position {value:?} is not finite")]
    NotFinite {
        /// The file.
        file: String,
        /// Number of the vertex.
        place: String,
        /// The position.
        value: [f64; 3],
    },
    /// Number or size above a limit.
    #[error("{file}: {what}: {found} is over the limit of {limit}")]
    Limit {
        /// The file.
        file: String,
        /// Name of what is counted, with its unit.
        what: String,
        /// Number or size that was found.
        found: u64,
        /// Largest number or size.
        limit: u64,
    },
    /// Memory that a file asks for and the system does not have.
    #[error("{file}: {what}: {bytes} bytes of memory needed, which the system does not give")]
    Memory {
        /// The file.
        file: String,
        /// Purpose of the memory.
        what: String,
        /// Number of bytes.
        bytes: u64,
    },
    /// Mesh without a triangle that is left.
    #[error("{file}: no triangle is left ({detail})")]
    NoTriangles {
        /// The file.
        file: String,
        /// Reason why no triangle is left.
        detail: String,
    },
    /// Instances of a glTF that may be a forest as well as one plant.
    #[error(
        "{file}: holds {instances} instances (EXT_mesh_gpu_instancing), a forest or the parts of one plant: name the mesh to \
         read (--gltf-mesh, or gltf_mesh in a species or scene file), or '*' for all of it as one plant; the meshes are: \
         {meshes}"
    )]
    Instanced {
        /// The file.
        file: String,
        /// Number of instances.
        instances: u64,
        /// The words for its meshes.
        meshes: String,
    },
    /// A word for a mesh of a glTF that means none, or several.
    #[error("{file}: --gltf-mesh or gltf_mesh '{word}': {found}; the meshes are: {meshes}")]
    UnknownMesh {
        /// The file.
        file: String,
        /// The word.
        word: String,
        /// Reason why the word does not do.
        found: String,
        /// The words that would.
        meshes: String,
    },
    /// A pattern of nodes or groups that matches none.
    #[error("{file}: --node '{pattern}' means no node or group; there are: {nodes}")]
    UnknownNode {
        /// The file.
        file: String,
        /// The pattern.
        pattern: String,
        /// Names that there are.
        nodes: String,
    },
    /// A setting that makes no sense.
    #[error("{name}: found {found}, expected {expected}")]
    Setting {
        /// The setting.
        name: &'static str,
        /// Value that was given.
        found: String,
        /// Values that would do.
        expected: &'static str,
    },
    /// A material pattern that is no glob.
    #[error("{origin}: '{pattern}' is not a pattern: {reason}")]
    BadPattern {
        /// Option or file that holds the pattern.
        origin: String,
        /// The pattern.
        pattern: String,
        /// Reason why the pattern is no glob.
        reason: String,
    },
    /// A material pattern that matches nothing.
    #[error("{origin}: '{pattern}' matches no material; the materials are: {materials}")]
    NothingMatched {
        /// Option or file that holds the pattern.
        origin: String,
        /// The pattern.
        pattern: String,
        /// All material names.
        materials: String,
    },
    /// Materials that no rule decides.
    #[error(
        "whether these materials are leaf or wood is not known: {undecided}\n{table}\nsay it, for example: {flags}"
    )]
    Undecided {
        /// Names of the undecided materials.
        undecided: String,
        /// All materials, one per line.
        table: String,
        /// Options that would decide.
        flags: String,
    },
    /// Every material is left out.
    #[error("no material is leaf or wood, so there is nothing to bake:\n{table}")]
    NothingToBake {
        /// All materials, one per line.
        table: String,
    },
}

/// A text for a message: as it is, or its start and end where it is long. Parsers quote what they read: of a URL the
/// host is left.
pub fn excerpt(text: String) -> String {
    const START: usize = 400;
    const END: usize = 100;
    let text = url::shown_lines(&text).into_owned();
    if text.len() <= START + END {
        return text;
    }
    let (start, end) = (text.floor_char_boundary(START), text.ceil_char_boundary(text.len() - END));
    format!("{} ... {}", &text[..start], &text[end..])
}

/// A name or value from a file for a message: as [`excerpt`], on one line, so that it cannot pass for more than it is.
pub fn quoted(text: &str) -> String {
    excerpt(escaped(text, |_| false).into_owned())
}

/// Kind of an [`ImportError`], for exit codes.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Fault {
    /// The file or the options are wrong.
    Input,
    /// The system refused to read.
    Io,
    /// The file is right but uses something unsupported.
    Unsupported,
    /// A limit was hit.
    Limit,
    /// The user has to say more, or something else.
    Usage,
}

impl ImportError {
    /// The kind of trouble.
    pub fn fault(&self) -> Fault {
        match self {
            ImportError::Io { .. } | ImportError::MissingFile { .. } => Fault::Io,
            ImportError::UnknownFormat { .. }
            | ImportError::UnsupportedVersion { .. }
            | ImportError::RequiredExtension { .. } => Fault::Unsupported,
            ImportError::Limit { .. } | ImportError::Memory { .. } => Fault::Limit,
            ImportError::Syntax { .. }
            | ImportError::Malformed { .. }
            | ImportError::OutsideFolder { .. }
            | ImportError::NotFinite { .. }
            | ImportError::NoTriangles { .. } => Fault::Input,
            ImportError::Instanced { .. }
            | ImportError::UnknownMesh { .. }
            | ImportError::UnknownNode { .. }
            | ImportError::Setting { .. }
            | ImportError::BadPattern { .. }
            | ImportError::NothingMatched { .. }
            | ImportError::Undecided { .. }
            | ImportError::NothingToBake { .. } => Fault::Usage,
        }
    }
}
