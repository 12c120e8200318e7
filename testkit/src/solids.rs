//! Meshes of solids: what light on wood is judged on where no leaf is near. And of a leaf alone.

use flb_fixtures::PlantMaterial;
use flb_scene::Mesh;
use flb_scene::mesh::Material;
use glam::Vec3;

/// A profile (radius, height) turned about the vertical, with flat normals; counter-clockwise from outside where it
/// rises outside.
fn turned(profile: &[[f64; 2]]) -> Mesh {
    let clay = PlantMaterial { name: "clay", alpha_cutoff: None, width: 0, height: 0, rgba: Vec::new() };
    let part = flb_fixtures::turned(clay, profile);
    let corners = part.triangles.iter().map(|t| t.map(|vertex| Vec3::from(part.positions[vertex as usize])));
    // Rings at the poles have no width.
    let flat: Vec<[Vec3; 3]> = corners.filter(|[a, b, c]| (*b - *a).cross(*c - *a).length() > 1e-9).collect();
    let normals = flat.iter().flat_map(|[a, b, c]| [(*b - *a).cross(*c - *a).normalize().to_array(); 3]);
    Mesh {
        materials: vec![Material::opaque("clay")],
        normals: normals.collect(),
        positions: flat.iter().flatten().map(|point| point.to_array()).collect(),
        uvs: vec![[0.0; 2]; 3 * flat.len()],
        triangles: (0..flat.len() as u32).map(|t| [3 * t, 3 * t + 1, 3 * t + 2]).collect(),
        triangle_material: vec![0; flat.len()],
        ..Mesh::default()
    }
}

/// A ball of radius 0.5 m.
pub fn ball() -> Mesh {
    let ring = |k: u32| {
        let angle = std::f64::consts::PI * f64::from(k) / 48.0;
        [0.5 * libm::sin(angle), 0.5 - 0.5 * libm::cos(angle)]
    };
    turned(&(0..=48).map(ring).collect::<Vec<_>>())
}

/// A pot: an outer wall that widens upwards, a rim, an inner wall and a floor inside.
pub fn pot() -> Mesh {
    turned(&[
        [0.0, 0.0],
        [0.3, 0.0],
        [0.42, 0.6],
        [0.46, 0.6],
        [0.46, 0.72],
        [0.41, 0.72],
        [0.26, 0.06],
        [0.0, 0.06],
    ])
}

/// A trunk that tapers, 3 m high and 0.5 m thick at its foot.
pub fn trunk() -> Mesh {
    turned(&[[0.0, 0.0], [0.25, 0.0], [0.2, 1.0], [0.17, 2.0], [0.15, 3.0], [0.0, 3.0]])
}

/// A square leaf with sides of 2 m around the origin, spanned by two unit vectors across each other.
pub fn sheet(right: [f32; 3], up: [f32; 3]) -> Mesh {
    let [right, up] = [right, up].map(Vec3::from);
    let corners = [(-1.0, -1.0), (1.0, -1.0), (1.0, 1.0), (-1.0, 1.0)].map(|(a, b)| a * right + b * up);
    Mesh {
        materials: vec![Material::opaque("leaf")],
        normals: vec![right.cross(up).to_array(); 4],
        positions: corners.map(|corner| corner.to_array()).to_vec(),
        uvs: vec![[0.0; 2]; 4],
        triangles: vec![[0, 1, 2], [0, 2, 3]],
        triangle_material: vec![0; 2],
        ..Mesh::default()
    }
}

/// A mesh and a wall beside it, 0.1 m thick and 2 m high, 0.3 m from where the mesh ends.
pub fn beside_a_wall(mut mesh: Mesh) -> Mesh {
    let end = mesh.positions.iter().map(|point| point[0]).fold(f32::MIN, f32::max);
    let (low, high) = ([end + 0.3, -0.5, -1.0], [end + 0.4, 1.5, 1.0]);
    // Corners by bits x, y, z; quads counter-clockwise from outside.
    for quad in [[0, 4, 6, 2], [1, 3, 7, 5], [0, 1, 5, 4], [2, 6, 7, 3], [0, 2, 3, 1], [4, 5, 7, 6]] {
        let corners = quad.map(|bits: usize| {
            std::array::from_fn(|axis| if bits >> axis & 1 == 1 { high[axis] } else { low[axis] })
        });
        let [a, b, c, _] = corners.map(|corner: [f32; 3]| Vec3::from(corner));
        let normal = (b - a).cross(c - a).normalize().to_array();
        let first = mesh.positions.len() as u32;
        mesh.positions.extend(corners);
        mesh.normals.extend([normal; 4]);
        mesh.uvs.extend([[0.0; 2]; 4]);
        mesh.triangles.extend([[first, first + 1, first + 2], [first, first + 2, first + 3]]);
        mesh.triangle_material.extend([0; 2]);
    }
    mesh
}
