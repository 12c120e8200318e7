use std::path::Path;

use super::*;

fn finish(positions: &[[f32; 3]], triangles: &[[u32; 3]]) -> Mesh {
    let mut files = Files::beside(Path::new("a.obj"));
    let mut soup = Soup::default();
    for position in positions {
        let vertex = Vertex { position: position.map(f64::from), ..Vertex::default() };
        soup.push_vertex(&mut files, vertex, String::new).unwrap();
    }
    for &triangle in triangles {
        soup.push_triangle(&mut files, triangle, 0).unwrap();
    }
    soup.finish(&mut files, None).unwrap().mesh
}

#[test]
fn normals_are_weighted_by_area_and_shared_by_position() {
    // Two squares at a right angle, one twice as long; the edge's vertices are stored twice.
    let positions = [
        [0.0, 0.0, 0.0],
        [0.0, 0.0, 1.0],
        [1.0, 0.0, 0.0],
        [0.0, 0.0, 0.0],
        [0.0, 2.0, 0.0],
        [0.0, 0.0, 1.0],
    ];
    let mesh = finish(&positions, &[[0, 1, 2], [3, 4, 5]]);
    let length = 5.0f32.sqrt();
    let expected = [-2.0 / length, 1.0 / length, 0.0];
    for vertex in [0, 1, 3, 5] {
        let normal = mesh.normals[vertex];
        let error = (0..3).map(|i| (normal[i].abs() - f32::abs(expected[i])).abs()).fold(0.0, f32::max);
        assert!(error < 1e-6, "{normal:?}");
    }
    assert_eq!(mesh.normals[0], mesh.normals[3]);
}

#[test]
fn negative_zero_is_the_same_place_as_zero() {
    let positions = [
        [0.0, 0.0, 0.0],
        [1.0, 0.0, 0.0],
        [0.0, 1.0, 0.0],
        [-0.0, 1.0, -0.0],
        [1.0, -0.0, 0.0],
        [0.0, -0.0, 0.0],
    ];
    assert_eq!(finish(&positions, &[[0, 1, 2], [3, 4, 5]]).triangles.len(), 1);
}

#[test]
fn tiny_triangles_are_kept() {
    let tiny = 1e-12;
    let mesh = finish(&[[0.0, 0.0, 0.0], [tiny, 0.0, 0.0], [0.0, tiny, 0.0]], &[[0, 1, 2]]);
    assert_eq!(mesh.normals[0], [0.0, 0.0, 1.0]);
}

#[test]
fn triangles_over_the_same_points_go_within_one_material_only() {
    let mut files = Files::beside(Path::new("a.obj"));
    let mut soup = Soup::default();
    for position in [[0.0, 0.0, 0.0], [1.0, 0.0, 0.0], [0.0, 1.0, 0.0]] {
        let vertex = Vertex { position, ..Vertex::default() };
        soup.push_vertex(&mut files, vertex, String::new).unwrap();
    }
    for (corners, material) in [([0, 1, 2], 1), ([1, 0, 2], 0), ([2, 1, 0], 1), ([0, 2, 1], 0)] {
        soup.push_triangle(&mut files, corners, material).unwrap();
    }
    let mesh = soup.finish(&mut files, None).unwrap().mesh;
    assert_eq!(mesh.triangle_material, [1, 0]);
    assert_eq!(mesh.triangles, [[0, 1, 2], [1, 0, 2]]);
}

#[test]
fn unused_vertices_go() {
    let positions = [[9.0; 3], [0.0, 0.0, 0.0], [9.0; 3], [1.0, 0.0, 0.0], [0.0, 1.0, 0.0]];
    let mesh = finish(&positions, &[[1, 3, 4]]);
    assert_eq!((mesh.positions.len(), mesh.triangles[0]), (3, [0, 1, 2]));
}
