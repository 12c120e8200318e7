//! glTF materials to [`Material`]: base colour (or the diffuse of the older specular-glossiness
//! model), alpha, texture transform and diffuse transmission.

use std::borrow::Cow;

use gltf::json::material::AlphaMode as JsonAlphaMode;
use gltf::json::texture::{Info, WrappingMode};
use gltf::json::validation::Checked;
use gltf::json::{Material as Json, Root};
use serde::Deserialize;
use serde_json::{Map, Value};

use super::buffers::{self, Buffers};
use crate::import::error::ImportError;
use crate::import::files::Files;
use crate::import::images::Images;
use crate::mesh::{AlphaMode, Material, Texture, Wrap};

/// A material and the set of texture coordinates that its colour texture reads.
pub struct Loaded {
    /// Without name.
    pub material: Material,
    /// `TEXCOORD_n`.
    pub tex_coord: u32,
}

/// Everything that materials are made from.
pub struct Library<'a> {
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
    diffuse_transmission_factor: f32,
}

#[derive(Deserialize)]
#[serde(rename_all = "camelCase")]
struct SpecularGlossiness {
    diffuse_factor: Option<[f32; 4]>,
    diffuse_texture: Option<Info>,
}

impl Library<'_> {
    /// Material `index`, which exists.
    pub fn load(&mut self, files: &mut Files, index: usize) -> Result<Loaded, ImportError> {
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
        if let Some(older) = older {
            base_color = older.diffuse_factor.unwrap_or(base_color);
            texture = older.diffuse_texture.or(texture);
        }
        let transmission: Option<DiffuseTransmission> =
            extension(files, &place, others, "KHR_materials_diffuse_transmission")?;
        let (color_texture, tex_coord) = match &texture {
            Some(info) => self.texture(files, &place, info)?,
            None => (None, 0),
        };
        let alpha_mode = alpha_mode(files, &place, json, &mut base_color, color_texture, &self.images);
        let material = Material {
            color_texture,
            alpha_mode,
            base_color,
            diffuse_transmission: transmission
                .map(|t| t.diffuse_transmission_factor)
                .filter(|factor| *factor > 0.0),
            ..Material::opaque(name)
        };
        Ok(Loaded { material, tex_coord })
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
        let source = webp.or((source != u32::MAX as usize).then_some(source));
        let Some(source) = source else {
            files.warn(format!("{place} has no source that is read (KTX2, DDS?); going on without"));
            return Ok((None, tex_coord));
        };
        let Some(image) = self.image(files, &place, source)? else {
            return Ok((None, tex_coord));
        };
        let sampler = json.sampler.and_then(|sampler| self.root.samplers.get(sampler.value()));
        let wrap =
            sampler.map_or([Wrap::Repeat; 2], |sampler| [wrap(&sampler.wrap_s), wrap(&sampler.wrap_t)]);
        Ok((Some(Texture { image, wrap, transform: matrix(&transform) }), tex_coord))
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

/// The mask that really acts: none where the image is opaque. The alpha factor moves into the
/// cutoff, for later stages look at texels alone.
fn alpha_mode(
    files: &mut Files,
    place: &str,
    json: &Json,
    base_color: &mut [f32; 4],
    texture: Option<Texture>,
    images: &Images,
) -> AlphaMode {
    let factor = std::mem::replace(&mut base_color[3], 1.0);
    let cutoff = match json.alpha_mode {
        Checked::Valid(JsonAlphaMode::Mask) => json.alpha_cutoff.map_or(0.5, |cutoff| cutoff.0),
        Checked::Valid(JsonAlphaMode::Blend) => 0.5,
        Checked::Valid(JsonAlphaMode::Opaque) | Checked::Invalid => return AlphaMode::Opaque,
    };
    let mask = matches!(json.alpha_mode, Checked::Valid(JsonAlphaMode::Mask));
    let image = texture.map(|texture| &images.images[texture.image as usize]);
    if !image.is_some_and(|image| image.has_cut) {
        if mask {
            let what = match image {
                Some(image) => format!("its image '{}' has no alpha", image.name),
                None => "it has no image".to_owned(),
            };
            files.warn(format!("{place} has alpha mode MASK, but {what}; taken as opaque"));
        }
        return AlphaMode::Opaque;
    }
    if !mask {
        if factor < 1.0 {
            files.warn(format!("{place} is {factor} opaque by its factor; only its image's alpha is used"));
        }
        return AlphaMode::Cut { cutoff };
    }
    let effective = cutoff / factor;
    if effective > 1.0 || effective.is_nan() {
        files.warn(format!(
            "{place}: an alpha factor of {factor} would cut everything; only its image's alpha is used"
        ));
        return AlphaMode::Cut { cutoff };
    }
    AlphaMode::Cut { cutoff: effective.max(0.0) }
}
