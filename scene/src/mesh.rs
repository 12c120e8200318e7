//! A plant as triangles with materials: what import makes and every later stage reads.
//!
//! Model space is glTF's: right-handed, +Y up, metres. Node transforms, units and the up axis are
//! already applied. Degenerate triangles, and coincident duplicates of one material, are already gone.

pub mod sides;
#[cfg(any(test, feature = "testing"))]
pub mod testing;

use flb_format::material_surface::MaterialSurface;
use flb_format::mesh;
use flb_format::meta::{Bounds, SourceFile};
use glam::Vec3;

use sides::Sheets;

/// Triangles over shared vertices. `normals` and `uvs` are as long as `positions`.
#[derive(Debug, Clone, PartialEq, Default)]
pub struct Mesh {
    /// Model space, metres; finite.
    pub positions: Vec<[f32; 3]>,
    /// Normals of unit length; computed where the file has none.
    pub normals: Vec<[f32; 3]>,
    /// Texture coordinates, glTF's convention: v = 0 is the image's FIRST row (OBJ's v is flipped on
    /// import). Any finite value: wrap modes apply. KHR_texture_transform is NOT yet applied: it
    /// belongs to the [`Texture`].
    pub uvs: Vec<[f32; 2]>,
    /// Indices into the vertex arrays; always in range.
    pub triangles: Vec<[u32; 3]>,
    /// Material of each triangle, an index into `materials`; always in range.
    pub triangle_material: Vec<u32>,
    /// Materials, at least one when there is a triangle.
    pub materials: Vec<Material>,
    /// Decoded images, shared by materials.
    pub images: Vec<Image>,
    /// Every file read, in order of reading.
    pub sources: Vec<SourceFile>,
    /// Warnings of what import repaired or ignored, one sentence each, naming file and place.
    pub warnings: Vec<String>,
    /// Triangles that stand for one side of a leaf; none until classes are known ([`crate::sheets::find`]).
    pub sheets: Sheets,
    /// Notes of what import made of the file that its user should know, one sentence each: an offset, what the file
    /// itself hides.
    pub notes: Vec<String>,
    /// Linear R, G, B of each vertex, which multiply the colour of its material; empty where all are white.
    pub colors: Vec<[f32; 3]>,
    /// Offset subtracted from the coordinates of a plant that stands far from its file's origin, model space, metres:
    /// whole numbers. A renderer that places the plant where its file has it adds them.
    pub offset_m: [f64; 3],
    /// The nodes or groups that the triangles came from, in the file's order.
    pub parts: Vec<Part>,
}

/// A node of a glTF, or a group of an OBJ.
#[derive(Debug, Clone, PartialEq, Default)]
pub struct Part {
    /// Name of the part, then those of what it is a part of: a node's mesh and the nodes above it, a group's object.
    /// Names that are empty are left out; at most [`PART_NAMES`].
    pub names: Vec<String>,
    /// Number of the node in its glTF.
    pub node: Option<u32>,
    /// Triangles of the part, one entry a material.
    pub uses: Vec<PartUse>,
}

/// Largest number of names of a part.
pub const PART_NAMES: usize = 6;

/// Triangles of a part that have one material.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct PartUse {
    /// Index of the material in [`Mesh::materials`].
    pub material: u32,
    /// Number of triangles.
    pub triangles: u64,
    /// Area of the triangles, nothing cut away, square metres.
    pub area_m2: f64,
    /// Bounds of the triangles, model space, metres.
    pub bounds_m: Bounds,
    /// Where they stand.
    pub foot: Foot,
}

/// Corners of triangles in the lowest twentieth of their height: of a tree's wood, the foot of its trunk.
#[derive(Debug, Clone, Copy, PartialEq, Default)]
pub struct Foot {
    /// Mean of the corners, model space, metres.
    pub middle_m: [f64; 3],
    /// Root mean square distance of the corners from the middle over the ground, metres: a tube's radius.
    pub spread_m: f64,
}

impl Part {
    /// A word for messages: its first name, or its node's number.
    pub fn label(&self) -> String {
        match (self.names.first(), self.node) {
            (Some(name), _) => name.clone(),
            (None, Some(node)) => format!("#{node}"),
            (None, None) => "unnamed".to_owned(),
        }
    }

    /// Names that are its own: those of a node and its mesh.
    pub(crate) fn own_names(&self) -> &[String] {
        &self.names[..self.names.len().min(2)]
    }

    /// Bounds of all triangles of the part, model space, metres.
    pub fn bounds_m(&self) -> Option<Bounds> {
        self.uses.iter().map(|used| used.bounds_m).reduce(around)
    }
}

/// The box around two boxes.
pub fn around(a: Bounds, b: Bounds) -> Bounds {
    let side =
        |of: fn(f64, f64) -> f64, a: [f64; 3], b: [f64; 3]| std::array::from_fn(|axis| of(a[axis], b[axis]));
    Bounds { min: side(f64::min, a.min, b.min), max: side(f64::max, a.max, b.max) }
}

/// A surface: colour, and where it is cut away.
#[derive(Debug, Clone, PartialEq)]
pub struct Material {
    /// Name in the file; unique names are not guaranteed.
    pub name: String,
    /// Linear RGBA that multiplies the texture's linear colour. Where an OBJ has `map_Kd`, the colour
    /// is white: exporters write Kd tints that would blacken the texture.
    pub base_color: [f32; 4],
    /// Colour (sRGB) and, where `alpha_mode` says so, alpha in its A channel.
    pub color_texture: Option<Texture>,
    /// A separate alpha image (OBJ `map_d` with another file); its coverage is in `Image::rgba`'s A.
    pub alpha_texture: Option<Texture>,
    /// Effect of alpha.
    pub alpha_mode: AlphaMode,
    /// Share of light that passes diffusely, from KHR_materials_diffuse_transmission: factor times the mean of its
    /// texture over the surface. `None` without the extension.
    pub diffuse_transmission: Option<f32>,
    /// Whether a texture says where light passes.
    pub passes_by_texture: bool,
    /// Linear colour of the light that passes, where the file says one: factor times the mean of its texture.
    pub transmission_color: Option<[f32; 3]>,
    /// Texture whose A channel multiplies `diffuse_transmission`: while a file is read only, before materials are split
    /// by it.
    pub passing_texture: Option<Texture>,
    /// Texture whose colour multiplies `transmission_color`, likewise.
    pub passing_color_texture: Option<Texture>,
    /// Whether the alpha of the colour image may mean something else than where the surface is: no file says that it
    /// cuts.
    pub is_alpha_guessed: bool,
    /// Whether the names of its parts say what it is, though its own name does: an atlas that leaves and wood share.
    pub is_told_by_parts: bool,
    /// Surface that the texels state, once a bake has decided or a file of its light says so; `None`: a tint of the
    /// plant's leaf or wood ([`crate::color`]).
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
            passes_by_texture: false,
            transmission_color: None,
            passing_texture: None,
            passing_color_texture: None,
            is_alpha_guessed: false,
            is_told_by_parts: false,
            surface: None,
        }
    }
}

/// Effect of a material's alpha.
#[derive(Debug, Clone, Copy, PartialEq)]
pub enum AlphaMode {
    /// Alpha is ignored.
    Opaque,
    /// Texels with alpha below the cutoff are not there.
    Cut {
        /// Alpha below which a texel is absent, 0..=1; glTF's default is 0.5.
        cutoff: f32,
    },
    /// Alpha is the share of the surface that is there, texel by texel: of a texel of 0.4, 40 % stops light.
    Blend,
}

/// A use of an image.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Texture {
    /// Index of the image in [`Mesh::images`].
    pub image: u32,
    /// Outside 0..1 along u and v.
    pub wrap: [Wrap; 2],
    /// KHR_texture_transform as a row-major 2x3 matrix: `uv' = m * [u, v, 1]`.
    pub transform: [[f32; 3]; 2],
    /// Colour between the middles of texels.
    pub filter: Filter,
}

/// Colour between the middles of texels. Cover is that of the nearest, whatever the filter.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Filter {
    /// Mixed of four texels.
    Linear,
    /// Colour of the nearest one, as of a palette (glTF's magFilter 9728).
    Nearest,
}

/// Continuation of a texture outside 0..1.
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

impl Image {
    /// Name of the image without extension.
    pub fn stem(&self) -> &str {
        self.name.rsplit_once('.').map_or(self.name.as_str(), |(stem, _)| stem)
    }
}

impl Mesh {
    /// Gives each material the surface that a file states for it, `None` for a tint of the species' mean. Returns false
    /// and changes nothing if the file states those of another number of materials.
    pub fn set_surfaces(&mut self, surfaces: Vec<Option<MaterialSurface>>) -> bool {
        if surfaces.len() != self.materials.len() {
            return false;
        }
        self.materials.iter_mut().zip(surfaces).for_each(|(material, surface)| material.surface = surface);
        true
    }

    /// Digest of its triangles, as a file of its light remembers it; `None` for a mesh without triangles or with
    /// coordinates that are not finite.
    pub fn digest(&self) -> Option<String> {
        mesh::digest(&self.positions, &self.triangles)
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

    /// Corners of a triangle, model space, metres.
    pub fn corners_m(&self, triangle: usize) -> [[f64; 3]; 3] {
        self.triangles[triangle].map(|vertex| self.positions[vertex as usize].map(f64::from))
    }

    /// The colour of a triangle's vertices at the weights of its second and third one, linear; white where the mesh has
    /// none.
    pub fn vertex_color(&self, triangle: usize, weights: [f32; 2]) -> Vec3 {
        if self.colors.is_empty() {
            return Vec3::ONE;
        }
        let [a, b, c] = self.triangles[triangle]
            .map(|vertex| self.colors.get(vertex as usize).map_or(Vec3::ONE, |color| Vec3::from(*color)));
        a * (1.0 - weights[0] - weights[1]) + b * weights[0] + c * weights[1]
    }
}
