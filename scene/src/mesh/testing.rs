//! Small meshes for tests.

use super::{AlphaMode, Filter, Image, Material, Mesh, Texture, Wrap};

/// A use of an image with uv as they are.
pub fn identity(image: u32, wrap: Wrap) -> Texture {
    Texture { image, wrap: [wrap; 2], transform: [[1.0, 0.0, 0.0], [0.0, 1.0, 0.0]], filter: Filter::Linear }
}

/// A green image whose alpha is 255 where `present`, else 0.
pub fn image(width: u32, height: u32, present: impl Fn(u32, u32) -> bool) -> Image {
    let mut rgba = Vec::new();
    for (x, y) in (0..height).flat_map(|y| (0..width).map(move |x| (x, y))) {
        rgba.extend([90, 160, 60, if present(x, y) { 255 } else { 0 }]);
    }
    Image { name: "leaf".to_owned(), width, height, rgba, has_cut: true }
}

/// Triangles without texture, all of material 0.
pub fn soup(triangles: &[[[f32; 3]; 3]]) -> Mesh {
    let positions: Vec<[f32; 3]> = triangles.concat();
    let count = triangles.len() as u32;
    Mesh {
        normals: vec![[0.0, 1.0, 0.0]; positions.len()],
        uvs: vec![[0.0; 2]; positions.len()],
        positions,
        triangles: (0..count).map(|i| [3 * i, 3 * i + 1, 3 * i + 2]).collect(),
        triangle_material: vec![0; count as usize],
        materials: vec![Material::opaque("leaf"), Material::opaque("wood")],
        ..Mesh::default()
    }
}

/// The unit square in the plane z = 0, uv 0..1, as two triangles with a cut image.
pub fn card(cut: Image, wrap: Wrap) -> Mesh {
    let corners = [[0.0, 0.0], [1.0, 0.0], [1.0, 1.0], [0.0, 1.0]];
    let mut material = Material::opaque("leaf");
    material.color_texture = Some(identity(0, wrap));
    material.alpha_mode = AlphaMode::Cut { cutoff: 0.5 };
    Mesh {
        positions: corners.map(|[x, y]| [x, y, 0.0]).to_vec(),
        normals: vec![[0.0, 0.0, 1.0]; 4],
        uvs: corners.to_vec(),
        triangles: vec![[0, 1, 2], [0, 2, 3]],
        triangle_material: vec![0; 2],
        materials: vec![material],
        images: vec![cut],
        ..Mesh::default()
    }
}
