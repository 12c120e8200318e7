//! Meshes of grown plants.

use flb_fixtures::Plant;
use flb_scene::Mesh;
use flb_scene::mesh::{AlphaMode, Filter, Image, Material, Texture, Wrap};

/// A plant as import reads it back, its textures times a base colour.
pub fn mesh(plant: &Plant, base_color: [f32; 4]) -> Mesh {
    let mut mesh = Mesh::default();
    for (index, part) in plant.parts.iter().enumerate() {
        let first = mesh.positions.len() as u32;
        mesh.positions.extend(&part.positions);
        mesh.normals.extend(&part.normals);
        mesh.uvs.extend(&part.uvs);
        mesh.triangles.extend(part.triangles.iter().map(|corners| corners.map(|vertex| vertex + first)));
        mesh.triangle_material.resize(mesh.triangles.len(), index as u32);
        let grown = &part.material;
        let (wrap, alpha_mode) = match grown.alpha_cutoff {
            Some(cutoff) => (Wrap::Clamp, AlphaMode::Cut { cutoff }),
            None => (Wrap::Repeat, AlphaMode::Opaque),
        };
        let transform = [[1.0, 0.0, 0.0], [0.0, 1.0, 0.0]];
        mesh.materials.push(Material {
            base_color,
            color_texture: Some(Texture {
                image: index as u32,
                wrap: [wrap; 2],
                transform,
                filter: Filter::Linear,
            }),
            alpha_mode,
            ..Material::opaque(grown.name)
        });
        mesh.images.push(Image {
            name: grown.name.into(),
            width: grown.width,
            height: grown.height,
            rgba: grown.rgba.clone(),
            has_cut: grown.alpha_cutoff.is_some(),
        });
    }
    mesh
}
