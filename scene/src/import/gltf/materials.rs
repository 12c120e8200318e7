//! glTF materials to [`Material`]: base colour (or the diffuse of the older specular-glossiness
//! model), alpha, texture transform and diffuse transmission.

use std::borrow::Cow;

use gltf::json::material::AlphaMode as JsonAlphaMode;
use gltf::json::texture::{Info, MagFilter, WrappingMode};
use gltf::json::validation::Checked;
use gltf::json::{Material as Json, Root};
use serde::Deserialize;
use serde_json::{Map, Value};

use super::buffers::{self, Buffers};
use crate::import::error::ImportError;
use crate::import::files::Files;
use crate::import::images::Images;
use crate::mesh::{AlphaMode, Filter, Image, Material, Texture, Wrap};
use crate::texture::SrgbTable;

/// A material and the set of texture coordinates that its colour texture reads.
pub(super) struct Loaded {
    /// Material without name.
    pub material: Material,
    /// `TEXCOORD_n`; `None` where no texture is read.
    pub tex_coord: Option<u32>,
}

/// Everything that materials are made from.
pub(super) struct Library<'a> {
    /// The file's JSON.
    pub root: &'a Root,
    /// The file's bytes.
    pub buffers: &'a Buffers,
    /// Images decoded so far.
    pub images: Images,
}

#[derive(Deserialize, Default)]
#[serde(rename_all = "camelCase", default)]
struct TextureTransform {
    offset: Option<[f32; 2]>,
    rotation: f32,
    scale: Option<[f32; 2]>,
    tex_coord: Option<u32>,
}

#[derive(Deserialize, Default)]
#[serde(rename_all = "camelCase", default)]
struct DiffuseTransmission {
    diffuse_transmission_factor: Option<f32>,
    diffuse_transmission_texture: Option<Info>,
    diffuse_transmission_color_factor: Option<[f32; 3]>,
    diffuse_transmission_color_texture: Option<Info>,
}

#[derive(Deserialize)]
#[serde(rename_all = "camelCase")]
struct SpecularGlossiness {
    diffuse_factor: Option<[f32; 4]>,
    diffuse_texture: Option<Info>,
}

impl Library<'_> {
    /// Material `index`, which exists.
    pub(super) fn load(&mut self, files: &mut Files, index: usize) -> Result<Loaded, ImportError> {
        let json = &self.root.materials[index];
        let name = match json.name.as_deref().filter(|name| !name.is_empty()) {
            Some(name) => files.name(format!("materials[{index}]"), name)?,
            None => format!("material_{index}"),
        };
        let place = format!("materials[{index}] '{name}'");
        let others = json.extensions.as_ref().map(|extensions| &extensions.others);
        let mut base_color = json.pbr_metallic_roughness.base_color_factor.0;
        let mut texture = json.pbr_metallic_roughness.base_color_texture.clone();
        let older: Option<SpecularGlossiness> =
            extension(files, &place, others, "KHR_materials_pbrSpecularGlossiness")?;
        if let Some(older) =
            older.filter(|older| older.diffuse_factor.is_some() || older.diffuse_texture.is_some())
        {
            // The metallic-roughness model beside it is for readers that do not know this one.
            base_color = older.diffuse_factor.unwrap_or([1.0; 4]);
            texture = older.diffuse_texture;
        }
        let transmission: Option<DiffuseTransmission> =
            extension(files, &place, others, "KHR_materials_diffuse_transmission")?;
        let (color_texture, tex_coord) = match &texture {
            Some(info) => self.texture(files, &place, info)?,
            None => (None, 0),
        };
        let tex_coord_of_color = color_texture.map(|_| tex_coord);
        if json.alpha_mode == Checked::Invalid {
            return Err(files.malformed(place, "an unknown alphaMode", "OPAQUE, MASK or BLEND"));
        }
        let alpha_mode = alpha_mode(files, &place, json, &mut base_color, color_texture, &self.images);
        let material = Material { color_texture, alpha_mode, base_color, ..Material::opaque(name) };
        let mut loaded = Loaded { material, tex_coord: tex_coord_of_color };
        if let Some(transmission) = transmission {
            self.transmission(files, &place, &transmission, tex_coord_of_color, &mut loaded)?;
        }
        loaded.tex_coord = loaded.tex_coord.filter(|_| self.images.differ_in(&loaded.material));
        Ok(loaded)
    }

    /// What passes. A texture of it that has the coordinates of the colour's is read where the surface is; of another
    /// the mean over the image is taken.
    fn transmission(
        &mut self,
        files: &mut Files,
        place: &str,
        json: &DiffuseTransmission,
        tex_coord_of_color: Option<u32>,
        loaded: &mut Loaded,
    ) -> Result<(), ImportError> {
        let material = &mut loaded.material;
        // Where the extension states no factor, it is 0: nothing passes.
        let stated = json.diffuse_transmission_factor.filter(|factor| factor.is_finite());
        let mut factor = stated.unwrap_or(0.0).clamp(0.0, 1.0);
        if let Some(info) = json.diffuse_transmission_texture.as_ref().filter(|_| factor > 0.0) {
            // Zeros of colour's alpha are an unused channel; here they let nothing pass.
            self.images.keeps_zero_alpha = true;
            let found = self.texture(files, place, info);
            self.images.keeps_zero_alpha = false;
            let (texture, tex_coord) = found?;
            material.passes_by_texture = texture.is_some();
            match texture {
                Some(texture) if tex_coord_of_color.is_none_or(|of_color| of_color == tex_coord) => {
                    loaded.tex_coord = Some(tex_coord);
                    material.passing_texture = Some(texture);
                }
                Some(texture) => {
                    let [.., alpha] = mean_texel(&self.images.images[texture.image as usize]);
                    factor *= alpha;
                    files.warn(format!(
                        "{place}: diffuseTransmissionTexture has other texture coordinates than the colour; its mean, \
                         {alpha:.3}, is taken"
                    ));
                }
                None => {}
            }
        }
        let mut color = json.diffuse_transmission_color_factor;
        if let Some(info) = json.diffuse_transmission_color_texture.as_ref().filter(|_| factor > 0.0)
            && let (Some(texture), tex_coord) = self.texture(files, place, info)?
        {
            let [r, g, b] = color.unwrap_or([1.0; 3]);
            color = match tex_coord_of_color.or(loaded.tex_coord).is_none_or(|known| known == tex_coord) {
                true => {
                    loaded.tex_coord = Some(tex_coord);
                    material.passing_color_texture = Some(texture);
                    Some([r, g, b])
                }
                false => {
                    let [x, y, z, _] = mean_texel(&self.images.images[texture.image as usize]);
                    files.warn(format!(
                        "{place}: diffuseTransmissionColorTexture has other texture coordinates than the colour; its \
                         mean, {x:.3} {y:.3} {z:.3}, is taken"
                    ));
                    Some([r * x, g * y, b * z])
                }
            };
        }
        material.transmission_color = color.filter(|color| color.iter().all(|value| value.is_finite()));
        material.diffuse_transmission = Some(factor);
        Ok(())
    }

    fn texture(
        &mut self,
        files: &mut Files,
        place: &str,
        info: &Info,
    ) -> Result<(Option<Texture>, u32), ImportError> {
        let others = info.extensions.as_ref().map(|extensions| &extensions.others);
        let transform: TextureTransform =
            extension(files, place, others, "KHR_texture_transform")?.unwrap_or_default();
        let tex_coord = transform.tex_coord.unwrap_or(info.tex_coord);
        let Some(json) = self.root.textures.get(info.index.value()) else {
            let expected = format!("one of {}", self.root.textures.len());
            return Err(files.malformed(place, format!("texture {}", info.index.value()), expected));
        };
        let place = format!("textures[{}]", info.index.value());
        let webp = json.extensions.as_ref().and_then(|extensions| {
            let source = extensions.others.get("EXT_texture_webp")?.get("source")?.as_u64()?;
            usize::try_from(source).ok()
        });
        // gltf-json writes u32::MAX where a texture has no plain source.
        let source = json.source.value();
        let plain = (source != u32::MAX as usize).then_some(source);
        let mut sources = webp.into_iter().chain(plain).peekable();
        if sources.peek().is_none() {
            files.warn(format!("{place} has no source that is read (KTX2, DDS?); going on without"));
        }
        let mut image = None;
        for source in sources {
            image = self.image(files, &place, source)?;
            if image.is_some() {
                break;
            }
        }
        let Some(image) = image else { return Ok((None, tex_coord)) };
        let sampler = json.sampler.and_then(|sampler| self.root.samplers.get(sampler.value()));
        let modes = sampler.map(|sampler| [&sampler.wrap_s, &sampler.wrap_t]);
        if modes.is_some_and(|modes| modes.contains(&&Checked::Invalid)) {
            return Err(files.malformed(place, "an unknown wrapS or wrapT", "10497, 33071 or 33648"));
        }
        let wrap = modes.map_or([Wrap::Repeat; 2], |modes| modes.map(wrap));
        let filter = match sampler.and_then(|sampler| sampler.mag_filter.as_ref()) {
            Some(Checked::Valid(MagFilter::Nearest)) => Filter::Nearest,
            Some(Checked::Invalid) => {
                files.warn(format!(
                    "{place} has an unknown magFilter (9728 or 9729 are known); taken as 9729"
                ));
                Filter::Linear
            }
            _ => Filter::Linear,
        };
        Ok((Some(Texture { image, wrap, transform: matrix(&transform), filter }), tex_coord))
    }

    fn image(&mut self, files: &mut Files, place: &str, index: usize) -> Result<Option<u32>, ImportError> {
        let Some(json) = self.root.images.get(index) else {
            let expected = format!("one of {}", self.root.images.len());
            return Err(files.malformed(place, format!("image {index}"), expected));
        };
        let place = format!("images[{index}]");
        let named = match json.name.as_deref().filter(|name| !name.is_empty()) {
            Some(name) => files.name(&place, name)?,
            None => place.clone(),
        };
        let (root, buffers) = (self.root, self.buffers);
        match (&json.uri, json.buffer_view) {
            (Some(uri), _) if uri.starts_with("data:") => self.images.get(files, &place, |files| {
                Ok((named, Cow::Owned(buffers::decode_data_uri(files, &place, uri)?)))
            }),
            (Some(uri), _) => self.images.get_file(files, uri, &place, &[]),
            (None, Some(view)) => self.images.get(files, &place, |files| {
                let view = buffers.view(files, root, &place, view.value())?;
                Ok((named, Cow::Borrowed(view.bytes)))
            }),
            (None, None) => {
                files.warn(format!("{place} has neither uri nor bufferView; going on without"));
                Ok(None)
            }
        }
    }
}

/// Means over an image: linear R, G, B, and alpha.
fn mean_texel(image: &Image) -> [f32; 4] {
    let table = SrgbTable::new();
    let mut sums = [0.0f64; 4];
    let texels = image.rgba.as_chunks::<4>().0;
    for [r, g, b, a] in texels {
        let values =
            [table.0[*r as usize], table.0[*g as usize], table.0[*b as usize], f32::from(*a) / 255.0];
        sums.iter_mut().zip(values).for_each(|(sum, value)| *sum += f64::from(value));
    }
    sums.map(|sum| (sum / texels.len().max(1) as f64) as f32)
}

/// The extension `name`, if it is there.
fn extension<T: serde::de::DeserializeOwned>(
    files: &Files,
    place: &str,
    others: Option<&Map<String, Value>>,
    name: &str,
) -> Result<Option<T>, ImportError> {
    let Some(value) = others.and_then(|others| others.get(name)).filter(|value| !value.is_null()) else {
        return Ok(None);
    };
    T::deserialize(value)
        .map(Some)
        .map_err(|error| files.malformed(format!("{place}, {name}"), error, "the extension's members"))
}

fn wrap(mode: &Checked<WrappingMode>) -> Wrap {
    match mode {
        Checked::Valid(WrappingMode::ClampToEdge) => Wrap::Clamp,
        Checked::Valid(WrappingMode::MirroredRepeat) => Wrap::Mirror,
        Checked::Valid(WrappingMode::Repeat) | Checked::Invalid => Wrap::Repeat,
    }
}

/// Scale, then rotation, then offset. The rotation's sense is that of the example in
/// KHR_texture_transform: offset (0, 1), rotation pi/2, scale 1/2 shows the lower left quadrant.
fn matrix(transform: &TextureTransform) -> [[f32; 3]; 2] {
    let [offset_u, offset_v] = transform.offset.unwrap_or([0.0; 2]);
    let [scale_u, scale_v] = transform.scale.unwrap_or([1.0; 2]);
    let (sin, cos) = (libm::sinf(transform.rotation), libm::cosf(transform.rotation));
    [[cos * scale_u, sin * scale_v, offset_u], [-sin * scale_u, cos * scale_v, offset_v]]
}

/// The mask that really acts. The alpha factor of a mask over an image moves into the cutoff, so that texels alone
/// decide; elsewhere it stays in the base colour.
fn alpha_mode(
    files: &mut Files,
    place: &str,
    json: &Json,
    base_color: &mut [f32; 4],
    texture: Option<Texture>,
    images: &Images,
) -> AlphaMode {
    let factor = base_color[3].clamp(0.0, 1.0);
    base_color[3] = factor;
    let image = texture.map(|texture| &images.images[texture.image as usize]);
    let cuts = image.is_some_and(|image| image.has_cut);
    let cutoff = match json.alpha_mode {
        Checked::Valid(JsonAlphaMode::Mask) => json.alpha_cutoff.map_or(0.5, |cutoff| cutoff.0),
        Checked::Valid(JsonAlphaMode::Blend) => return AlphaMode::Blend,
        Checked::Valid(JsonAlphaMode::Opaque) | Checked::Invalid => {
            base_color[3] = 1.0;
            return AlphaMode::Opaque;
        }
    };
    if !cuts && factor >= cutoff {
        let what = match image {
            Some(image) => format!("its image '{}' has no alpha", image.name),
            None => "it has no image".to_owned(),
        };
        files.warn(format!(
            "{place} has alpha mode MASK, but {what}; taken as opaque, unless its vertices say less"
        ));
    }
    let effective = cutoff / factor;
    if !cuts || effective > 1.0 || effective.is_nan() {
        return AlphaMode::Cut { cutoff };
    }
    base_color[3] = 1.0;
    AlphaMode::Cut { cutoff: effective.max(0.0) }
}
