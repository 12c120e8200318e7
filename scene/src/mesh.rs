//! A plant as triangles with materials: what import makes and every later stage reads.
//!
//! Model space is glTF's: right-handed, +Y up, metres. Node transforms, units and the up axis are
//! already applied. Degenerate triangles, and coincident duplicates of one material, are already gone.

pub mod sides;
#[cfg(any(test, feature = "testing"))]
pub mod testing;

use flb_format::meta::{Bounds, SourceFile};
use flb_format::{MaterialSurface, mesh_mark};

use sides::Sheets;

/// Triangles over shared vertices. `normals` and `uvs` are as long as `positions`.
#[derive(Debug, Clone, PartialEq, Default)]
pub struct Mesh {
    /// Model space, metres; finite.
    pub positions: Vec<[f32; 3]>,
    /// Unit length; computed where the file has none.
    pub normals: Vec<[f32; 3]>,
    /// Texture coordinates, glTF's convention: v = 0 is the image's FIRST row (OBJ's v is flipped on
    /// import). Any finite value: wrap modes apply. KHR_texture_transform is NOT yet applied: it
    /// belongs to the [`Texture`].
    pub uvs: Vec<[f32; 2]>,
    /// Indices into the vertex arrays; always in range.
    pub triangles: Vec<[u32; 3]>,
    /// Per triangle, an index into `materials`; always in range.
    pub triangle_material: Vec<u32>,
    /// At least one when there is a triangle.
    pub materials: Vec<Material>,
    /// Decoded images, shared by materials.
    pub images: Vec<Image>,
    /// Every file read, in order of reading.
    pub sources: Vec<SourceFile>,
    /// What import repaired or ignored, one sentence each, naming file and place.
    pub warnings: Vec<String>,
    /// Triangles that stand for one side of a leaf; none until classes are known ([`crate::sheets::find`]).
    pub sheets: Sheets,
}

/// A surface: colour, and where it is cut away.
#[derive(Debug, Clone, PartialEq)]
pub struct Material {
    /// As in the file; unique names are not guaranteed.
    pub name: String,
    /// Linear RGBA that multiplies the texture's linear colour. Where an OBJ has `map_Kd`, the colour
    /// is white: exporters write Kd tints that would blacken the texture.
    pub base_color: [f32; 4],
    /// Colour (sRGB) and, where `alpha_mode` says so, alpha in its A channel.
    pub color_texture: Option<Texture>,
    /// A separate alpha image (OBJ `map_d` with another file); its coverage is in `Image::rgba`'s A.
    pub alpha_texture: Option<Texture>,
    /// How alpha acts.
    pub alpha_mode: AlphaMode,
    /// Share of light that passes diffusely, from KHR_materials_diffuse_transmission (factor).
    pub diffuse_transmission: Option<f32>,
    /// What its texels say of its surface, once a bake has decided or a file of its light says so; `None`: a tint of
    /// the plant's leaf or wood ([`crate::color`]).
    pub surface: Option<MaterialSurface>,
}

impl Material {
    /// White, opaque, without textures.
    pub fn opaque(name: impl Into<String>) -> Material {
        Material {
            name: name.into(),
            base_color: [1.0; 4],
            color_texture: None,
            alpha_texture: None,
            alpha_mode: AlphaMode::Opaque,
            diffuse_transmission: None,
            surface: None,
        }
    }
}

/// How a material's alpha acts. Blend is cut at 0.5 like a mask.
#[derive(Debug, Clone, Copy, PartialEq)]
pub enum AlphaMode {
    /// Alpha is ignored.
    Opaque,
    /// Texels with alpha below the cutoff are not there.
    Cut {
        /// 0..=1; glTF's default is 0.5.
        cutoff: f32,
    },
}

/// A use of an image.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Texture {
    /// Index into [`Mesh::images`].
    pub image: u32,
    /// Outside 0..1 along u and v.
    pub wrap: [Wrap; 2],
    /// KHR_texture_transform as a row-major 2x3 matrix: `uv' = m * [u, v, 1]`.
    pub transform: [[f32; 3]; 2],
}

/// What lies outside 0..1 of a texture.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Wrap {
    /// glTF's and OBJ's default.
    Repeat,
    /// Every second copy is mirrored.
    Mirror,
    /// The edge texel.
    Clamp,
}

/// A decoded image, row 0 first.
#[derive(Debug, Clone, PartialEq)]
pub struct Image {
    /// File name, or a name that says where in the file it was.
    pub name: String,
    /// Texels per row.
    pub width: u32,
    /// Rows.
    pub height: u32,
    /// 8 bits per channel, sRGB colour and linear alpha, `[y][x][r, g, b, a]`.
    pub rgba: Vec<u8>,
    /// Whether any texel's alpha is below 255.
    pub has_cut: bool,
}

impl Mesh {
    /// Digest of its triangles, as a file of its light remembers it; `None` for a mesh without triangles or with
    /// coordinates that are not finite.
    pub fn digest(&self) -> Option<String> {
        mesh_mark::digest(&self.positions, &self.triangles)
    }

    /// Bounds of all vertices that a triangle uses; `None` without triangles.
    pub fn bounds(&self) -> Option<Bounds> {
        let mut bounds: Option<Bounds> = None;
        for &index in self.triangles.iter().flatten() {
            let point = self.positions[index as usize].map(f64::from);
            let b = bounds.get_or_insert(Bounds { min: point, max: point });
            b.min = std::array::from_fn(|axis| b.min[axis].min(point[axis]));
            b.max = std::array::from_fn(|axis| b.max[axis].max(point[axis]));
        }
        bounds
    }
}
