//! Reads a plant from glTF, GLB or OBJ into a [`Mesh`]: model space, clean triangles, decoded
//! images, digests of all files read. Only this module knows file formats.

mod blend;
mod choice;
pub mod error;
mod files;
mod first_bytes;
mod gltf;
mod images;
pub mod known;
mod limits;
mod memory;
mod named;
mod obj;
mod png;
mod points;
mod soup;
mod split;
mod split_patterns;
mod things;
mod type_words;
pub(crate) mod uses;

use std::io::Read;
use std::path::Path;

pub use self::error::{Fault, ImportError, excerpt, quoted};
pub use self::files::{read_bytes, read_text};
pub use self::gltf::{Plant, Stand, StandSpecies, WHOLE};
pub use self::images::{MAX_SOFT, cut_share, soft_share};
pub use self::limits::{MAX_SPECIES, TEXT_BYTES};
pub use self::memory::{ask, reserve};
pub use self::named::named_files;
pub(crate) use self::png::leave_out_metadata;
pub use self::soup::{Up, area};
pub use self::split_patterns::{is_met_by, splits};
pub use self::things::told_of_part;
pub(crate) use self::things::{Things, told_of_material};
pub use self::type_words::in_words;

use self::blend::place_blends;
use self::choice::Choice;
use self::files::{Files, Records, name_of, open_regular};
use self::soup::{FileFrame, Soup, WITHIN, is_beyond};
use self::split::split;
use self::split_patterns::SplitPatterns;
use crate::mesh::{AlphaMode, Mesh, Texture};

/// Settings that a mesh file does not state by itself.
#[derive(Debug, Clone, PartialEq, Default)]
pub struct ImportSettings {
    /// Axis that points up in the file; by default +Y, which glTF prescribes and most OBJ files use.
    pub up: Option<Up>,
    /// Metres per unit of the file, by default 1.
    pub unit_m: Option<f64>,
    /// The one mesh of a glTF file to read, in its own space: nodes do not move it. Its name, or its number as `#3`;
    /// [`WHOLE`] for the default scene as one plant, which it is by default where EXT_mesh_gpu_instancing does not
    /// multiply meshes.
    pub gltf_mesh: Option<String>,
    /// Patterns of the nodes of a glTF, or of the groups and objects of an OBJ, that are read, each with all below it:
    /// globs of names, any case, or `#3` for a node's number. Without any, all are read that the file itself shows.
    pub nodes: Vec<String>,
    /// Patterns `MATERIAL@PART` of names of materials and of nodes or groups (globs, any case): a material is split
    /// where one part of it meets a pattern and another does not. Other patterns split nothing.
    pub split: Vec<String>,
    /// Take all vertices for white and opaque, whatever colours they have.
    pub ignore_vertex_colors: bool,
    /// Offset subtracted from the coordinates, model space, metres. By default whole numbers where the plant stands so
    /// far from the origin that an f32 loses its shape, else nothing.
    pub offset_m: Option<[f64; 3]>,
}

/// The kinds of mesh files.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
enum Format {
    Gltf,
    Obj,
}

/// Reads the mesh at `path` and the files that it names.
///
/// # Errors
/// [`ImportError`] for whatever is missing, malformed, unsupported or over a limit. What can be
/// repaired or left out without changing the plant's shape ends up in [`Mesh::warnings`] instead.
pub fn import(path: &Path, settings: &ImportSettings) -> Result<Mesh, ImportError> {
    let unit_m = settings.unit_m.unwrap_or(1.0);
    if !(unit_m.is_finite() && unit_m > 0.0) {
        let expected = "a finite number of metres above 0";
        return Err(ImportError::Setting { name: "unit", found: unit_m.to_string(), expected });
    }
    let choice = Choice::compile(&settings.nodes)?;
    let split_by = SplitPatterns::compile(&settings.split)?;
    let is_unit_stated = settings.unit_m.is_some();
    let frame = FileFrame { up: settings.up.unwrap_or(Up::Y), unit_m, is_unit_stated };
    let mut files = Files::beside(path);
    let mut soup = Soup::new(settings.ignore_vertex_colors);
    let surfaces = match format_of(path)? {
        Format::Gltf => {
            let bytes = files.read(path, limits::FILE_BYTES)?;
            let mesh = settings.gltf_mesh.as_deref();
            gltf::import(&mut files, bytes, mesh, &choice, frame, &mut soup)?
        }
        Format::Obj if settings.gltf_mesh.is_some() => {
            let found =
                format!("'{}' for {}, an OBJ", settings.gltf_mesh.as_deref().unwrap_or_default(), files.file);
            return Err(ImportError::Setting { name: "gltf_mesh", found, expected: "a glTF or GLB file" });
        }
        Format::Obj => obj::import(&mut files, path, &choice, frame, &mut soup)?,
    };
    for material in surfaces.materials.iter().filter(|material| is_beyond(&material.base_color)) {
        let ([r, g, b, _], name) = (material.base_color, quoted(&material.name));
        files.warn(format!("the material '{name}' has the colour {r} {g} {b}, {WITHIN}"));
    }
    limit_cutting(&files, &surfaces)?;
    let gltf::Surfaces { materials, images, parts } = surfaces;
    let mut finished = soup.finish(&mut files, settings.offset_m)?;
    finished.mesh.images = images;
    let mesh = split(&files, finished, materials, parts, &split_by)?;
    let mesh = place_blends(mesh);
    if mesh.offset_m != [0.0; 3] {
        let [x, y, z] = mesh.offset_m;
        files.note(format!(
            "the plant stands at {x} {y} {z} m (x, y up, z), too far off for numbers of 32 bits: these metres are taken \
             off its coordinates (offset_m)"
        ));
    }
    note_read(&mut files, &mesh);
    limit_size(&files, &mesh, unit_m)?;
    let Records { sources, warnings, notes } = files.into_records();
    Ok(Mesh { sources, warnings, notes, ..mesh })
}

/// Notes what many readers leave out, and this one reads.
fn note_read(files: &mut Files, mesh: &Mesh) {
    const LISTED: usize = 8;
    if !mesh.colors.is_empty() {
        files.note("colours of vertices multiply those of materials".to_owned());
    }
    let stated = mesh.materials.iter().filter_map(|material| {
        let percent = 100.0 * material.diffuse_transmission?;
        Some(format!("{percent:.0} % of '{}'", quoted(&material.name)))
    });
    let stated: Vec<String> = stated.take(LISTED).collect();
    if !stated.is_empty() {
        files
            .note(format!("light that passes, by KHR_materials_diffuse_transmission: {}", stated.join(", ")));
    }
}

/// Reads where the meshes of the glTF at `path` stand, as plants of a scene: those below the nodes that a pattern of
/// `nodes` means, or all without a pattern. Meshes that a word of `leave_out` means are not among them.
///
/// # Errors
/// As [`import`]; [`ImportError::Malformed`] with the node for a plant that no bake can serve: one bake serves
/// rotations and uniform scales.
pub fn read_stand(path: &Path, leave_out: &[String], nodes: &[String]) -> Result<Stand, ImportError> {
    let mut files = Files::beside(path);
    if format_of(path)? != Format::Gltf {
        let expected = "a glTF or GLB file, which says where plants stand";
        return Err(ImportError::Setting {
            name: "scene",
            found: format!("{}, an OBJ", files.file),
            expected,
        });
    }
    let bytes = files.read(path, limits::FILE_BYTES)?;
    gltf::read_stand(files, bytes, leave_out, &Choice::compile(nodes)?)
}

/// Largest coordinate, metres: of more, areas are no numbers of f32.
const MAX_M: f32 = 1e9;

/// An error where a mesh is larger than any scene.
fn limit_size(files: &Files, mesh: &Mesh, unit_m: f64) -> Result<(), ImportError> {
    let is_far = |position: &&[f32; 3]| position.iter().any(|c| c.abs() > MAX_M);
    match mesh.positions.iter().find(is_far) {
        None => Ok(()),
        Some(position) if unit_m > 1.0 => {
            let found = format!("{unit_m:e} m, by which a vertex of {} is at {position:?} m", files.file);
            Err(ImportError::Setting { name: "--unit (unit_m)", found, expected: "coordinates up to 1e9 m" })
        }
        Some(position) => {
            Err(files.malformed("a vertex", format!("{position:?} m"), "coordinates up to 1e9 m".to_owned()))
        }
    }
}

/// An error where images cut so many materials that asking every texel of each would take long.
fn limit_cutting(files: &Files, surfaces: &gltf::Surfaces) -> Result<(), ImportError> {
    let texels_of = |texture: Texture| {
        let image = &surfaces.images[texture.image as usize];
        u64::from(image.width) * u64::from(image.height)
    };
    let cut = surfaces.materials.iter().filter(|material| material.alpha_mode != AlphaMode::Opaque);
    let textures = cut.flat_map(|material| [material.color_texture, material.alpha_texture]).flatten();
    files.limit("texels that cut, over all materials", textures.map(texels_of).sum(), limits::CUT_TEXELS)
}

/// By the file's first bytes, then by its extension.
fn format_of(path: &Path) -> Result<Format, ImportError> {
    let mut start = Vec::new();
    let read = open_regular(path)?.take(first_bytes::LENGTH as u64).read_to_end(&mut start);
    read.map_err(|source| ImportError::Io { path: path.to_owned(), source })?;
    let extension = path.extension().unwrap_or_default().to_string_lossy().to_lowercase();
    let unknown = |found: String| ImportError::UnknownFormat { file: name_of(path), found };
    if let Some(kind) = first_bytes::kind_of(&start) {
        return Err(unknown(kind.to_owned()));
    }
    start.truncate(4);
    match extension.as_str() {
        _ if gltf::is_glb(&start) => Ok(Format::Gltf),
        "gltf" => Ok(Format::Gltf),
        "obj" => Ok(Format::Obj),
        _ => Err(unknown(format!("extension '{extension}' and first bytes {start:02x?}"))),
    }
}
