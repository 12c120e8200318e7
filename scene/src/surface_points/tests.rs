//! Two squares, of which one may be cut.

use super::*;
use crate::Mesh;
use crate::mesh::sides::Side;
use crate::mesh::{AlphaMode, Filter, Image, Material, Texture, Wrap};

/// Two squares in the plane z = 0, of 1 and of 3 m^2, the second of another material.
fn squares(alpha_mode: AlphaMode) -> ClassedMesh {
    let material =
        |name: &str, color_texture| Material { color_texture, alpha_mode, ..Material::opaque(name) };
    let transform = [[1.0, 0.0, 0.0], [0.0, 1.0, 0.0]];
    let texture = Texture { image: 0, wrap: [Wrap::Repeat; 2], transform, filter: Filter::Linear };
    // The left texel is there, the right one is cut away.
    let image = Image {
        name: "half".to_owned(),
        width: 2,
        height: 1,
        rgba: [[255; 4], [255, 255, 255, 0]].concat(),
        has_cut: true,
    };
    let corner = |x: f32, y: f32| [x, y, 0.0];
    let mesh = Mesh {
        positions: vec![
            corner(0.0, 0.0),
            corner(1.0, 0.0),
            corner(1.0, 1.0),
            corner(0.0, 1.0),
            corner(2.0, 0.0),
            corner(5.0, 0.0),
            corner(5.0, 1.0),
            corner(2.0, 1.0),
        ],
        normals: vec![[0.0, 0.0, 1.0]; 8],
        uvs: [[0.0, 0.0], [1.0, 0.0], [1.0, 1.0], [0.0, 1.0]].repeat(2),
        triangles: vec![[0, 1, 2], [0, 2, 3], [4, 5, 6], [4, 6, 7]],
        triangle_material: vec![0, 0, 1, 1],
        materials: vec![material("leaf", Some(texture)), material("wood", None)],
        images: vec![image],
        ..Mesh::default()
    };
    ClassedMesh { mesh, classes: vec![MaterialClass::Leaf, MaterialClass::Wood] }
}

fn on_the_first(classed: &ClassedMesh) -> (usize, Vec<[f32; 3]>) {
    let points = surface_points(classed, 1000, false).expect("textures that can be cut");
    assert_eq!(points.len(), 1000);
    let points: Vec<[f32; 3]> = points.into_iter().map(|point| point.position_m).collect();
    assert!(points.iter().all(|p| p[2] == 0.0 && (0.0..=1.0).contains(&p[1])));
    (points.iter().filter(|p| p[0] <= 1.0).count(), points)
}

#[test]
fn points_are_even_by_area() {
    let (first, _) = on_the_first(&squares(AlphaMode::Opaque));
    assert!((240..=260).contains(&first), "{first} of 1000 on a quarter of the area");
}

#[test]
fn half_of_a_triangle_of_one_side_counts() {
    let mut classed = squares(AlphaMode::Opaque);
    let of_second = classed.mesh.triangle_material.iter().map(|&material| match material {
        0 => Side::Both,
        _ => Side::Back,
    });
    classed.mesh.sheets.sides = of_second.collect();
    let (first, _) = on_the_first(&classed);
    assert!((390..=410).contains(&first), "{first} of 1000 on 1 of 2.5 m2");
}

#[test]
fn no_point_lies_where_alpha_cuts() {
    let (first, points) = on_the_first(&squares(AlphaMode::Cut { cutoff: 0.5 }));
    assert!((133..=153).contains(&first), "{first} of 1000 on a seventh of the area");
    assert!(points.iter().all(|p| p[0] <= 0.5 || p[0] >= 2.0));
}

#[test]
fn what_is_neither_leaf_nor_wood_has_no_points() {
    let mut classed = squares(AlphaMode::Opaque);
    classed.classes[1] = MaterialClass::Neither;
    assert_eq!(on_the_first(&classed).0, 1000);
    classed.classes[0] = MaterialClass::Neither;
    assert_eq!(surface_points(&classed, 10, false).expect("nothing to cut"), []);
}

#[test]
fn a_mesh_without_texture_coordinates_and_normals_has_points() {
    let mut classed = squares(AlphaMode::Opaque);
    let (_, expected) = on_the_first(&classed);
    (classed.mesh.uvs, classed.mesh.normals) = (Vec::new(), Vec::new());
    assert_eq!(on_the_first(&classed).1, expected);
    // Where alpha cuts, all of it lies on the texel of (0, 0), as it does for rays.
    let mut classed = squares(AlphaMode::Cut { cutoff: 0.5 });
    classed.mesh.uvs.clear();
    assert_eq!(on_the_first(&classed).1, expected);
}
