//! How much an input may hold. Together these keep a hostile file within 1 GiB and a few seconds;
//! the largest plants in practice stay far below.

/// Bytes of one GLB, binary buffer or image file.
pub const FILE_BYTES: u64 = 384 << 20;
/// Bytes of all buffers of a glTF together, and of all that EXT_meshopt_compression unpacks.
pub const BUFFER_BYTES: u64 = 384 << 20;
/// Bytes of glTF JSON (data URIs included).
pub const JSON_BYTES: u64 = 192 << 20;
/// Objects and arrays in glTF JSON. Each may become a few hundred bytes.
pub const JSON_OBJECTS: u64 = 1 << 20;
/// Values in glTF JSON.
pub const JSON_VALUES: u64 = 8 << 20;
/// Bytes of an OBJ, which is read line by line.
pub const OBJ_BYTES: u64 = 2 << 30;
/// Bytes of one line of text, continuations included.
pub const LINE_BYTES: u64 = 1 << 20;
/// Bytes of an MTL or species file.
pub const TEXT_BYTES: u64 = 16 << 20;
/// Triangles, before the degenerate ones are dropped.
pub const TRIANGLES: u64 = 8 << 20;
/// Vertices, and `v`, `vt` and `vn` lines of an OBJ each.
pub const VERTICES: u64 = 8 << 20;
/// Materials, images, and names that are kept.
pub const MATERIALS: u64 = 1 << 16;
/// Corners of one polygon: ear clipping may take time that grows with the square.
pub const POLYGON_CORNERS: u64 = 65_536;
/// Node visits of a glTF, instances of EXT_mesh_gpu_instancing included.
pub const NODE_VISITS: u64 = 1 << 20;
/// Texels along one edge of an image.
pub const IMAGE_EDGE: u32 = 16_384;
/// Texels of all images together (4 bytes each).
pub const IMAGE_TEXELS: u64 = 80 << 20;
/// Bytes that an image decoder may take.
pub const IMAGE_DECODER_BYTES: u64 = 320 << 20;
/// Warnings that are kept; the rest is counted.
pub const WARNINGS: usize = 64;
