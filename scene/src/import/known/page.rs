//! The tables as text, for the book.

use super::Rule;
use super::gltf::{Place, ROWS};
use super::obj::{MTL, OBJ, Row};

/// Writes tables of Markdown of what is read of a glTF, of an OBJ and of an MTL.
pub fn markdown() -> String {
    let mut text = String::from("### glTF 2.0\n\n| of | member | made of it | |\n|---|---|---|---|\n");
    for row in ROWS {
        let of = of(row.place);
        text += &line(&[of, &format!("`{}`", row.name)], row.rule);
    }
    for (title, rows) in [("OBJ", OBJ), ("MTL", MTL)] {
        text += &format!("\n### {title}\n\n| statement | made of it | |\n|---|---|---|\n");
        rows.iter().for_each(|(keyword, rule, _): &Row| text += &line(&[&format!("`{keyword}`")], *rule));
    }
    text
}

fn line(cells: &[&str], rule: Rule) -> String {
    format!("| {} | {} | {} |\n", cells.join(" | "), rule.word(), rule.why())
}

fn of(place: Place) -> &'static str {
    match place {
        Place::File => "the file",
        Place::Asset => "`asset`",
        Place::Scene => "a scene",
        Place::Node => "a node",
        Place::Mesh => "a mesh",
        Place::Primitive => "a primitive",
        Place::Attributes => "its attributes",
        Place::Target => "a morph target",
        Place::Accessor => "an accessor",
        Place::Sparse => "a sparse accessor",
        Place::BufferView => "a buffer view",
        Place::Buffer => "a buffer",
        Place::Image => "an image",
        Place::Texture => "a texture",
        Place::Sampler => "a sampler",
        Place::Material => "a material",
        Place::Pbr => "`pbrMetallicRoughness`",
        Place::TextureInfo => "a use of a texture",
        Place::Skin => "a skin",
        Place::Extensions => "extensions",
        Place::DiffuseTransmission => "KHR_materials_diffuse_transmission",
        Place::SpecularGlossiness => "KHR_materials_pbrSpecularGlossiness",
        Place::Transmission => "KHR_materials_transmission",
        Place::Volume => "KHR_materials_volume",
        Place::Instances => "EXT_mesh_gpu_instancing",
    }
}
