//! Materials, images and what alpha leaves of them, as words.

use flb_format::surface::Law;
use flb_render::forest::export::{FlatModel, linear_from_srgb};
use flb_scene::MaterialClass;
use flb_scene::alpha::{Coverage, Cut};
use flb_scene::mesh::{Filter, Image, Material, Texture, Wrap};

use crate::ForestError;
use crate::layout::{CLASS_LEAF, MAX_MATERIALS, NONE, NOTHING, Words};

/// Longest edge of an image.
const MAX_TEXELS: u32 = u16::MAX as u32;

/// Everything that is looked up by word: the table from sRGB to linear light, then images, cuts and what is added.
pub(crate) struct Lookups {
    pub words: Vec<u32>,
    /// `Material`s of all species.
    pub materials: Words,
    count: usize,
}

impl Lookups {
    pub(crate) fn new() -> Lookups {
        let words = linear_from_srgb().map(f32::to_bits).to_vec();
        Lookups { words, materials: Words::default(), count: 0 }
    }

    /// Adds the materials of a species, whose vertices begin at a number, and tells the number of the first.
    pub(crate) fn add(&mut self, model: &FlatModel<'_>, first_vertex: u32) -> Result<u32, ForestError> {
        let first = self.count;
        self.count += model.mesh.materials.len();
        if self.count > MAX_MATERIALS {
            return Err(ForestError::TooMany {
                what: "materials of all species",
                found: self.count as u64,
                most: MAX_MATERIALS as u64,
            });
        }
        let images =
            model.mesh.images.iter().map(|image| self.image(image)).collect::<Result<Vec<_>, _>>()?;
        let colors = self.colors(model, first_vertex);
        for (index, material) in model.mesh.materials.iter().enumerate() {
            let image = material.color_texture.and_then(|texture| {
                let image = model.mesh.images.get(texture.image as usize)?;
                let is_there = image.width > 0 && image.height > 0;
                is_there.then_some((texture, image, images[texture.image as usize]))
            });
            self.material(model, index, material, image, colors)?;
        }
        Ok(first as u32)
    }

    /// The materials, as many as the uniform holds.
    pub(crate) fn material_words(&self) -> Vec<u32> {
        let mut words = self.materials.0.clone();
        words.resize(MAX_MATERIALS * 32, 0);
        words
    }

    fn material(
        &mut self,
        model: &FlatModel<'_>,
        index: usize,
        material: &Material,
        image: Option<(Texture, &Image, u32)>,
        colors: u32,
    ) -> Result<(), ForestError> {
        let cut = match &model.coverage[index] {
            Coverage::Full => (NONE, None),
            Coverage::Nothing => (NOTHING, None),
            Coverage::Cut(cut) => (self.cut(cut)?, Some(cut)),
        };
        let class = model.classes[index];
        let [unit, reflectance, transmittance] = finish(model, index);
        let [r, g, b, _] = material.base_color;
        let wrap = image.map_or(0, |(texture, ..)| wrap_bits(texture.wrap) | filter_bit(texture.filter))
            | cut.1.map_or(0, |cut| wrap_bits(cut.wrap()) << 4);
        let [image_u, image_v] = image.map_or([[0.0; 3]; 2], |(texture, image, _)| {
            let row = |axis: usize, texels: u32| {
                let [a, b, c] = texture.transform[axis].map(|entry| f64::from(entry) * f64::from(texels));
                [a, b, c - 0.5]
            };
            [row(0, image.width), row(1, image.height)]
        });
        let [cut_u, cut_v] = cut.1.map_or([[0.0; 3]; 2], Cut::texel_matrix);
        let size = |[width, height]: [u32; 2]| width | height << 16;
        self.materials
            .floats([r, g, b])
            .whole(if class == MaterialClass::Leaf { CLASS_LEAF } else { 0 })
            .floats(unit)
            .whole(image.map_or(NONE, |(.., word)| word))
            .floats(reflectance)
            .whole(image.map_or(0, |(_, image, _)| size([image.width, image.height])))
            .floats(transmittance)
            .whole(cut.0)
            .rounded(image_u)
            .whole(cut.1.map_or(0, |cut| size(cut.size().map(|edge| edge as u32))))
            .rounded(image_v)
            .whole(wrap)
            .rounded(cut_u)
            .whole(solid_offset(model, class).to_bits())
            .rounded(cut_v)
            .whole(colors);
        Ok(())
    }

    /// Where the colours of the vertices of all species would begin for those of this one to lie where they do; `NONE`
    /// where they are white.
    fn colors(&mut self, model: &FlatModel<'_>, first_vertex: u32) -> u32 {
        if model.mesh.colors.is_empty() {
            return NONE;
        }
        let first = self.words.len() as u32;
        self.words.extend(model.mesh.colors.as_flattened().iter().map(|value| value.to_bits()));
        // Indices of vertices count over all species; the sum of both wraps back.
        first.wrapping_sub(3 * first_vertex)
    }

    /// First word of an image, a word a texel.
    fn image(&mut self, image: &Image) -> Result<u32, ForestError> {
        check_edges([image.width as usize, image.height as usize])?;
        let first = self.words.len() as u32;
        let texels = image.rgba.as_chunks::<4>().0.iter().map(|texel| u32::from_le_bytes(*texel));
        self.words.extend(texels);
        // Texels that are missing are white, as on the CPU.
        self.words.resize(first as usize + image.width as usize * image.height as usize, u32::MAX);
        Ok(first)
    }

    /// First word of a cut, a bit a texel; rows are of whole pairs of words.
    fn cut(&mut self, cut: &Cut) -> Result<u32, ForestError> {
        check_edges(cut.size())?;
        let first = self.words.len() as u32;
        for y in 0..cut.size()[1] {
            self.words.extend(cut.row(y).iter().flat_map(|word| [*word as u32, (*word >> 32) as u32]));
        }
        Ok(first)
    }
}

/// How far off a surface its light is sampled, metres of the model; below 0 where half of the light at a solid falls on
/// it.
fn solid_offset(model: &FlatModel<'_>, class: MaterialClass) -> f32 {
    match (class, &model.surfaces) {
        (MaterialClass::Leaf, _) | (_, None) => 0.0,
        (_, Some((surfaces, _))) => surfaces.solid_offset_m.unwrap_or(-1.0),
    }
}

/// A colour, and what a surface of that colour reflects and lets through.
fn finish(model: &FlatModel<'_>, index: usize) -> [[f32; 3]; 3] {
    let Some((_, laws)) = &model.surfaces else { return [[1.0; 3], [0.0; 3], [0.0; 3]] };
    let Law { unit, reflectance, transmittance } = laws[index];
    [unit, reflectance, transmittance]
}

fn check_edges(edges: [usize; 2]) -> Result<(), ForestError> {
    match edges.into_iter().find(|edge| *edge > MAX_TEXELS as usize) {
        None => Ok(()),
        Some(edge) => Err(ForestError::TooMany {
            what: "texels along an image's edge",
            found: edge as u64,
            most: MAX_TEXELS.into(),
        }),
    }
}

/// `NEAREST`, behind the wraps of colours and cover.
fn filter_bit(filter: Filter) -> u32 {
    u32::from(filter == Filter::Nearest) << 8
}

/// `WRAP_REPEAT`, `WRAP_CLAMP`, `WRAP_MIRROR`, two bits an axis.
fn wrap_bits(wrap: [Wrap; 2]) -> u32 {
    let code = |wrap: Wrap| match wrap {
        Wrap::Repeat => 0,
        Wrap::Clamp => 1,
        Wrap::Mirror => 2,
    };
    code(wrap[0]) | code(wrap[1]) << 2
}
