//! glTF 2.0, its ratified extensions, and the others that plants come with.

use std::collections::HashMap;
use std::sync::LazyLock;

use super::Rule::{self, NoMeaning, Read, Refused, Warned, WarnedUnless};

/// Kinds of JSON objects.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Hash)]
pub enum Place {
    /// The file.
    File,
    /// `asset`.
    Asset,
    /// An object of `scenes`.
    Scene,
    /// An object of `nodes`.
    Node,
    /// An object of `meshes`.
    Mesh,
    /// An object of a mesh's `primitives`.
    Primitive,
    /// A primitive's `attributes`.
    Attributes,
    /// An object of a primitive's `targets`.
    Target,
    /// An object of `accessors`.
    Accessor,
    /// An accessor's `sparse`, and what is in it.
    Sparse,
    /// An object of `bufferViews`.
    BufferView,
    /// An object of `buffers`.
    Buffer,
    /// An object of `images`.
    Image,
    /// An object of `textures`.
    Texture,
    /// An object of `samplers`.
    Sampler,
    /// An object of `materials`.
    Material,
    /// A material's `pbrMetallicRoughness`.
    Pbr,
    /// A use of a texture.
    TextureInfo,
    /// An object of `skins`.
    Skin,
    /// Any `extensions`.
    Extensions,
    /// KHR_materials_diffuse_transmission.
    DiffuseTransmission,
    /// KHR_materials_pbrSpecularGlossiness.
    SpecularGlossiness,
    /// KHR_materials_transmission.
    Transmission,
    /// KHR_materials_volume.
    Volume,
    /// EXT_mesh_gpu_instancing and its attributes.
    Instances,
}

/// Treatment of one member of an object.
#[derive(Debug, Clone, Copy)]
pub struct Row {
    /// Kind of the object.
    pub place: Place,
    /// The member's name; a `*` at its end stands for any ending.
    pub name: &'static str,
    /// Treatment of the member.
    pub rule: Rule,
    /// Kind of the member's objects, where their members have rows.
    pub holds: Option<Place>,
    /// A value, as JSON.
    pub example: &'static str,
}

const fn row(place: Place, name: &'static str, rule: Rule, example: &'static str) -> Row {
    Row { place, name, rule, holds: None, example }
}

const fn of(place: Place, name: &'static str, holds: Place) -> Row {
    Row { place, name, rule: Read, holds: Some(holds), example: "{}" }
}

const fn extension(name: &'static str, rule: Rule) -> Row {
    row(Place::Extensions, name, rule, "{}")
}

const NAME: Rule = NoMeaning("a name");
const SCENE: Rule = NoMeaning("of a scene: `flb scene` reads it");
const GLOSS: Rule = NoMeaning("gloss; light is solved for surfaces that scatter evenly");
/// Advice about geometry that is compressed.
pub const DECODE: &str = "; decode it first, for example with `gltf-transform copy IN OUT`";
const BESIDE: Rule = NoMeaning("data beside the surface");
const PASSES: &str = "light that passes a leaf is that of KHR_materials_diffuse_transmission, or measured";

/// Rows of all members.
pub const ROWS: &[Row] = &[
    of(Place::File, "asset", Place::Asset),
    of(Place::File, "scenes", Place::Scene),
    row(Place::File, "scene", Read, "0"),
    of(Place::File, "nodes", Place::Node),
    of(Place::File, "meshes", Place::Mesh),
    of(Place::File, "accessors", Place::Accessor),
    of(Place::File, "bufferViews", Place::BufferView),
    of(Place::File, "buffers", Place::Buffer),
    of(Place::File, "images", Place::Image),
    of(Place::File, "textures", Place::Texture),
    of(Place::File, "samplers", Place::Sampler),
    of(Place::File, "materials", Place::Material),
    of(Place::File, "skins", Place::Skin),
    row(
        Place::File,
        "animations",
        WarnedUnless("the pose at rest is read", "[]"),
        r#"[{"channels": [], "samplers": []}]"#,
    ),
    row(Place::File, "cameras", SCENE, "[]"),
    row(Place::File, "extensionsUsed", NoMeaning("what uses them says so"), "[]"),
    row(Place::File, "extensionsRequired", Read, "[]"),
    row(Place::Asset, "version", Read, r#""2.0""#),
    row(Place::Asset, "minVersion", Read, r#""2.0""#),
    row(Place::Asset, "generator", NAME, r#""x""#),
    row(Place::Asset, "copyright", NAME, r#""x""#),
    row(Place::Scene, "nodes", Read, "[0]"),
    row(Place::Scene, "name", NoMeaning("a name, told where there are several scenes"), r#""x""#),
    row(Place::Node, "children", Read, "[0]"),
    row(Place::Node, "mesh", Read, "0"),
    row(Place::Node, "skin", Read, "0"),
    row(Place::Node, "matrix", Read, "[2,0,0,0,0,2,0,0,0,0,2,0,0,0,0,1]"),
    row(Place::Node, "translation", Read, "[1,0,0]"),
    row(Place::Node, "rotation", Read, "[0,1,0,0]"),
    row(Place::Node, "scale", Read, "[2,2,2]"),
    row(Place::Node, "weights", Read, "[1]"),
    row(Place::Node, "name", Read, r#""trunk""#),
    row(Place::Node, "camera", SCENE, "0"),
    of(Place::Mesh, "primitives", Place::Primitive),
    row(Place::Mesh, "weights", Read, "[1]"),
    row(Place::Mesh, "name", Read, r#""trunk""#),
    of(Place::Primitive, "attributes", Place::Attributes),
    row(Place::Primitive, "indices", Read, "0"),
    row(Place::Primitive, "material", Read, "0"),
    row(Place::Primitive, "mode", Read, "4"),
    of(Place::Primitive, "targets", Place::Target),
    row(Place::Attributes, "POSITION", Read, "0"),
    row(Place::Attributes, "NORMAL", Read, "0"),
    row(Place::Attributes, "TANGENT", NoMeaning("for maps of normals"), "0"),
    row(Place::Attributes, "TEXCOORD_*", Read, "0"),
    row(Place::Attributes, "COLOR_0", Read, "0"),
    row(Place::Attributes, "COLOR_*", Warned("COLOR_0 alone colours a surface"), "0"),
    row(Place::Attributes, "JOINTS_*", Read, "0"),
    row(Place::Attributes, "WEIGHTS_*", Read, "0"),
    row(Place::Attributes, "_*", BESIDE, "0"),
    row(Place::Target, "POSITION", Read, "0"),
    row(Place::Target, "NORMAL", Read, "0"),
    row(Place::Target, "TANGENT", NoMeaning("for maps of normals"), "0"),
    row(Place::Target, "TEXCOORD_*", Warned("morph targets move points and normals alone"), "0"),
    row(Place::Target, "COLOR_*", Warned("morph targets move points and normals alone"), "0"),
    row(Place::Accessor, "bufferView", Read, "0"),
    row(Place::Accessor, "byteOffset", Read, "0"),
    row(Place::Accessor, "componentType", Read, "5126"),
    row(Place::Accessor, "normalized", Read, "false"),
    row(Place::Accessor, "count", Read, "3"),
    row(Place::Accessor, "type", Read, r#""VEC3""#),
    row(Place::Accessor, "min", NoMeaning("found from the numbers"), "[0,0,0]"),
    row(Place::Accessor, "max", NoMeaning("found from the numbers"), "[1,2,0]"),
    of(Place::Accessor, "sparse", Place::Sparse),
    row(Place::Accessor, "name", NAME, r#""x""#),
    row(Place::Sparse, "count", Read, "0"),
    of(Place::Sparse, "indices", Place::Sparse),
    of(Place::Sparse, "values", Place::Sparse),
    row(Place::Sparse, "bufferView", Read, "0"),
    row(Place::Sparse, "byteOffset", Read, "0"),
    row(Place::Sparse, "componentType", Read, "5121"),
    row(Place::BufferView, "buffer", Read, "0"),
    row(Place::BufferView, "byteOffset", Read, "0"),
    row(Place::BufferView, "byteLength", Read, "36"),
    row(Place::BufferView, "byteStride", Read, "12"),
    row(Place::BufferView, "target", NoMeaning("for graphics cards"), "34962"),
    row(Place::BufferView, "name", NAME, r#""x""#),
    row(Place::Buffer, "uri", Read, r#""x""#),
    row(Place::Buffer, "byteLength", Read, "36"),
    row(Place::Buffer, "name", NAME, r#""x""#),
    row(Place::Image, "uri", Read, r#""x""#),
    row(Place::Image, "bufferView", Read, "0"),
    row(Place::Image, "mimeType", NoMeaning("found from the first bytes"), r#""image/png""#),
    row(Place::Image, "name", Read, r#""leaf""#),
    row(Place::Texture, "sampler", Read, "0"),
    row(Place::Texture, "source", Read, "0"),
    row(Place::Texture, "name", NAME, r#""x""#),
    row(Place::Sampler, "wrapS", Read, "33071"),
    row(Place::Sampler, "wrapT", Read, "33071"),
    row(Place::Sampler, "magFilter", Read, "9728"),
    row(Place::Sampler, "minFilter", NoMeaning("light is solved at every point, not at a distance"), "9729"),
    row(Place::Sampler, "name", NAME, r#""x""#),
    row(Place::Material, "name", Read, r#""leaf""#),
    of(Place::Material, "pbrMetallicRoughness", Place::Pbr),
    row(Place::Material, "alphaMode", Read, r#""MASK""#),
    row(Place::Material, "alphaCutoff", Read, "0.4"),
    row(Place::Material, "doubleSided", NoMeaning("every surface has two sides"), "true"),
    row(
        Place::Material,
        "normalTexture",
        NoMeaning("finer than a site of the light; pictures shade by triangles"),
        r#"{"index": 0}"#,
    ),
    row(Place::Material, "occlusionTexture", NoMeaning("light is solved instead"), r#"{"index": 0}"#),
    row(
        Place::Material,
        "emissiveFactor",
        WarnedUnless("light that a plant sends out by itself is left out", "[0,0,0]"),
        "[1,0,0]",
    ),
    row(
        Place::Material,
        "emissiveTexture",
        NoMeaning("nothing without an emissiveFactor"),
        r#"{"index": 0}"#,
    ),
    row(Place::Pbr, "baseColorFactor", Read, "[1,0,0,1]"),
    of(Place::Pbr, "baseColorTexture", Place::TextureInfo),
    row(Place::Pbr, "metallicFactor", GLOSS, "0.5"),
    row(Place::Pbr, "roughnessFactor", GLOSS, "0.5"),
    row(Place::Pbr, "metallicRoughnessTexture", GLOSS, r#"{"index": 0}"#),
    row(Place::TextureInfo, "index", Read, "0"),
    row(Place::TextureInfo, "texCoord", Read, "1"),
    row(Place::Skin, "joints", Read, "[0]"),
    row(Place::Skin, "inverseBindMatrices", Read, "0"),
    row(Place::Skin, "skeleton", NoMeaning("joints say where they are"), "0"),
    row(Place::Skin, "name", NAME, r#""x""#),
    // Extensions that say something of shape, colour or what light does.
    Row { holds: Some(Place::DiffuseTransmission), ..extension("KHR_materials_diffuse_transmission", Read) },
    Row { holds: Some(Place::SpecularGlossiness), ..extension("KHR_materials_pbrSpecularGlossiness", Read) },
    Row { holds: Some(Place::Transmission), ..extension("KHR_materials_transmission", Read) },
    Row { holds: Some(Place::Volume), ..extension("KHR_materials_volume", Read) },
    Row { holds: Some(Place::Instances), ..extension("EXT_mesh_gpu_instancing", Read) },
    extension("KHR_texture_transform", Read),
    extension("KHR_mesh_quantization", Read),
    extension("KHR_node_visibility", Read),
    extension("MSFT_lod", Read),
    extension("EXT_meshopt_compression", Read),
    extension("KHR_meshopt_compression", Read),
    extension("EXT_texture_webp", Read),
    extension("KHR_materials_variants", Warned("the materials that the file shows by default are read")),
    extension("KHR_materials_volume_scatter", Warned(PASSES)),
    extension("ADOBE_materials_thin_transparency", Warned(PASSES)),
    extension("KHR_draco_mesh_compression", Refused(DECODE)),
    extension("KHR_gaussian_splatting", Refused("; splats have no surface: export triangles")),
    extension("KHR_texture_basisu", Refused("; convert its KTX2 textures to PNG or JPEG first")),
    extension("MSFT_texture_dds", Refused("; convert its DDS textures to PNG or JPEG first")),
    extension("EXT_texture_avif", Refused("; convert its AVIF textures to PNG or JPEG first")),
    // Extensions without meaning for light.
    extension("KHR_lights_punctual", SCENE),
    extension("EXT_lights_image_based", SCENE),
    extension("EXT_lights_ies", SCENE),
    extension("KHR_animation_pointer", NoMeaning("the pose at rest is read")),
    extension("KHR_materials_anisotropy", GLOSS),
    extension("KHR_materials_clearcoat", GLOSS),
    extension("KHR_materials_dispersion", GLOSS),
    extension("KHR_materials_ior", GLOSS),
    extension("KHR_materials_iridescence", GLOSS),
    extension("KHR_materials_sheen", GLOSS),
    extension("KHR_materials_specular", GLOSS),
    extension("ADOBE_materials_clearcoat_specular", GLOSS),
    extension("ADOBE_materials_clearcoat_tint", GLOSS),
    extension("KHR_materials_emissive_strength", NoMeaning("nothing without an emissiveFactor")),
    extension("KHR_materials_unlit", NoMeaning("how the plant is lit is what flb computes")),
    extension("KHR_xmp_json_ld", BESIDE),
    extension("KHR_xmp", BESIDE),
    extension("KHR_node_hoverability", BESIDE),
    extension("KHR_node_selectability", BESIDE),
    extension("KHR_interactivity", BESIDE),
    extension("KHR_audio_emitter", BESIDE),
    extension("KHR_physics_rigid_bodies", BESIDE),
    extension("KHR_implicit_shapes", BESIDE),
    extension("EXT_mesh_features", BESIDE),
    extension("EXT_mesh_manifold", BESIDE),
    extension("EXT_instance_features", BESIDE),
    extension("EXT_structural_metadata", BESIDE),
    extension("CESIUM_primitive_outline", BESIDE),
    extension("MSFT_packing_normalRoughnessMetallic", GLOSS),
    extension("MSFT_packing_occlusionRoughnessMetallic", GLOSS),
    extension("MSFT_screencoverage", BESIDE),
    row(Place::DiffuseTransmission, "diffuseTransmissionFactor", Read, "0.4"),
    of(Place::DiffuseTransmission, "diffuseTransmissionTexture", Place::TextureInfo),
    row(Place::DiffuseTransmission, "diffuseTransmissionColorFactor", Read, "[1,1,1]"),
    of(Place::DiffuseTransmission, "diffuseTransmissionColorTexture", Place::TextureInfo),
    row(Place::SpecularGlossiness, "diffuseFactor", Read, "[1,0,0,1]"),
    of(Place::SpecularGlossiness, "diffuseTexture", Place::TextureInfo),
    row(Place::SpecularGlossiness, "specularFactor", GLOSS, "[1,1,1]"),
    row(Place::SpecularGlossiness, "glossinessFactor", GLOSS, "1"),
    row(Place::SpecularGlossiness, "specularGlossinessTexture", GLOSS, r#"{"index": 0}"#),
    row(Place::Transmission, "transmissionFactor", WarnedUnless(PASSES, "0"), "0.3"),
    row(
        Place::Transmission,
        "transmissionTexture",
        NoMeaning("nothing without a transmissionFactor"),
        r#"{"index": 0}"#,
    ),
    row(Place::Volume, "thicknessFactor", WarnedUnless(PASSES, "0"), "0.3"),
    row(Place::Volume, "thicknessTexture", NoMeaning("nothing without a thicknessFactor"), r#"{"index": 0}"#),
    row(Place::Volume, "attenuationDistance", NoMeaning("nothing without a thicknessFactor"), "1"),
    row(Place::Volume, "attenuationColor", NoMeaning("nothing without a thicknessFactor"), "[1,1,1]"),
    of(Place::Instances, "attributes", Place::Instances),
    row(Place::Instances, "TRANSLATION", Read, "0"),
    row(Place::Instances, "ROTATION", Read, "0"),
    row(Place::Instances, "SCALE", Read, "0"),
    row(Place::Instances, "_COLOR_0", Warned("all instances have the colours of their mesh"), "0"),
    row(Place::Instances, "_*", BESIDE, "0"),
];

/// The row of a member.
pub fn find(place: Place, name: &str) -> Option<&'static Row> {
    let any_ending = || {
        let mut starts = STARTS.iter().filter(|(row, _)| row.place == place);
        starts.find(|(_, start)| name.starts_with(start)).map(|(row, _)| *row)
    };
    BY_NAME.get(&(place, name)).copied().or_else(any_ending)
}

/// Rows by what they are of and their name: a file may have a million members.
static BY_NAME: LazyLock<HashMap<(Place, &str), &Row>> =
    LazyLock::new(|| ROWS.iter().map(|row| ((row.place, row.name), row)).collect());

/// Rows of any ending, and what comes before it.
static STARTS: LazyLock<Vec<(&Row, &str)>> =
    LazyLock::new(|| ROWS.iter().filter_map(|row| Some((row, row.name.strip_suffix('*')?))).collect());

/// Returns advice against a file that requires an extension: an empty one for an unknown extension, `None` where there
/// is nothing to say against it.
pub fn advice_against(extension: &str) -> Option<&'static str> {
    match find(Place::Extensions, extension) {
        None => Some(""),
        Some(Row { rule: Refused(advice), .. }) => Some(advice),
        Some(_) => None,
    }
}
