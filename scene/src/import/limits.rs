//! How much an input may hold. Together these keep a hostile file within 1 GiB and a few seconds;
//! the largest plants in practice stay far below.

/// Bytes that reading a mesh may take at any time, by [`Files::hold`](super::files::Files::hold). The limits below
/// bound each thing; this one bounds them together. What is left of 1 GiB is for the program itself.
pub(super) const MEMORY_BYTES: u64 = 704 << 20;
/// Bytes of one GLB, binary buffer or image file.
pub(super) const FILE_BYTES: u64 = 384 << 20;
/// Bytes of all buffers of a glTF together, and of all that EXT_meshopt_compression unpacks.
pub(super) const BUFFER_BYTES: u64 = 384 << 20;
/// Bytes of glTF JSON (data URIs included).
pub(super) const JSON_BYTES: u64 = 192 << 20;
/// Objects and arrays in glTF JSON.
pub(super) const JSON_OBJECTS: u64 = 1 << 20;
/// Values in glTF JSON.
pub(super) const JSON_VALUES: u64 = 8 << 20;
/// Memory that an object of glTF JSON may become: the largest record of the `gltf` crate, twice, as lists grow by
/// doubling.
pub(super) const JSON_OBJECT_BYTES: u64 = 1400;
/// Memory that an array of glTF JSON may become, its values aside.
pub(super) const JSON_ARRAY_BYTES: u64 = 200;
/// Memory that a value of glTF JSON may become: a text of its own (32) and its place in a list that doubles (3 times
/// 32), and the address space that an allocator takes beside them. So that a list of 2^23 places is never made.
pub(super) const JSON_VALUE_BYTES: u64 = 176;
/// Bytes of an OBJ, which is read line by line.
pub(super) const OBJ_BYTES: u64 = 1 << 30;
/// Bytes of one line of text, continuations included.
pub(super) const LINE_BYTES: u64 = 1 << 20;
/// Files that an OBJ names by `mtllib`, and such lines.
pub(super) const LIBRARIES: u64 = 256;
/// Bytes of all MTL files of an OBJ together.
pub(super) const MTL_BYTES: u64 = 16 << 20;
/// Bytes of a species or plan file.
pub const TEXT_BYTES: u64 = 4 << 20;
/// Bytes of the name of a material, mesh, node, image or group.
pub(super) const NAME_BYTES: u64 = 1024;
/// Bytes of the name of a file, as written.
pub(super) const URI_BYTES: u64 = 4096;
/// Names of files that a mesh may mention, each time counted.
pub(super) const FILES: u64 = 1 << 14;
/// Entries of a folder among which a file is looked for in another case.
pub(super) const FOLDER_ENTRIES: usize = 1 << 16;
/// Triangles, before the degenerate ones are dropped.
pub(super) const TRIANGLES: u64 = 8 << 20;
/// Vertices, and `v`, `vt` and `vn` lines of an OBJ each.
pub(super) const VERTICES: u64 = 8 << 20;
/// Materials, images, and names that are kept.
pub(super) const MATERIALS: u64 = 1 << 16;
/// Corners of one polygon.
pub(super) const POLYGON_CORNERS: u64 = 4096;
/// Sum over all concave polygons of the square of their corners, as clipping ears takes some 30 ns of each at worst.
pub(super) const POLYGON_WORK: u64 = 1 << 27;
/// Node visits of a glTF, instances of EXT_mesh_gpu_instancing included.
pub(super) const NODE_VISITS: u64 = 1 << 20;
/// Texels along one edge of an image.
pub(super) const IMAGE_EDGE: u32 = 16_384;
/// Texels of all images together (4 bytes each).
pub(super) const IMAGE_TEXELS: u64 = 80 << 20;
/// Bytes of all images as they are stored, an image that is stored once and used twice counted twice.
pub(super) const IMAGE_BYTES: u64 = 256 << 20;
/// Texels that cut, over all materials: an image counts for each material that it cuts.
pub(super) const CUT_TEXELS: u64 = 1 << 30;
/// Bytes that an image decoder may take.
pub(super) const IMAGE_DECODER_BYTES: u64 = 320 << 20;
/// Warnings that are kept; the rest is counted.
pub(super) const WARNINGS: usize = 64;
/// Species of a scene.
pub const MAX_SPECIES: usize = 4096;
