//! Where light is compared: points of the plant's surface.

use flb_baker::voxelise::VoxelError;
use flb_scene::MaterialClass;
use flb_scene::alpha::Coverage;

use crate::exit::{Failure, VERDICT};
use flb_scene::ClassedMesh;

/// Candidates per point wanted, of which those on texels that are cut away are passed over.
const CANDIDATES: u64 = 256;

/// Steps of the R sequence in three dimensions (M. Roberts, 2018): powers of the root of g^4 = g + 1.
const STEPS: [f64; 3] = [0.819_172_513_396_164_4, 0.671_043_606_703_789_2, 0.549_700_477_901_970_3];

/// Up to `count` points on leaf and wood triangles, even by area, on present texels only; model space, metres. The same
/// for the same mesh.
pub fn points(classed: &ClassedMesh, count: u32, ignore_alpha: bool) -> Result<Vec<[f32; 3]>, Failure> {
    let ClassedMesh { mesh, classes } = classed;
    let coverage: Vec<Coverage> = (0..mesh.materials.len())
        .map(|material| if ignore_alpha { Ok(Coverage::Full) } else { Coverage::of(mesh, material) })
        .collect::<Result<_, _>>()
        .map_err(VoxelError::Alpha)?;
    let mut ends = Vec::with_capacity(mesh.triangles.len());
    let mut area_m2 = 0.0;
    for (triangle, &material) in mesh.triangles.iter().zip(&mesh.triangle_material) {
        if classes[material as usize] != MaterialClass::Neither {
            area_m2 += twice_area(triangle.map(|vertex| mesh.positions[vertex as usize].map(f64::from)));
        }
        ends.push(area_m2);
    }
    let mut found = Vec::new();
    for i in 0..u64::from(count) * CANDIDATES {
        let [place, u, v] = STEPS.map(|step| (0.5 + step * i as f64).fract());
        let triangle = ends.partition_point(|&end| end <= place * area_m2);
        if found.len() == count as usize || triangle == ends.len() {
            break;
        }
        let (u, v) = if u + v > 1.0 { (1.0 - u, 1.0 - v) } else { (u, v) };
        let shares = [1.0 - u - v, u, v];
        let corners = mesh.triangles[triangle].map(|vertex| vertex as usize);
        let mix = |of: &dyn Fn(usize) -> f32| -> f32 {
            (0..3).map(|k| shares[k] * f64::from(of(corners[k]))).sum::<f64>() as f32
        };
        let uv = [0, 1].map(|axis| mix(&|vertex| mesh.uvs[vertex][axis]));
        if coverage[mesh.triangle_material[triangle] as usize].present_at(uv) {
            found.push([0, 1, 2].map(|axis| mix(&|vertex| mesh.positions[vertex][axis])));
        }
    }
    match found.is_empty() {
        true => Err(Failure::new(
            VERDICT,
            "found no point of leaf or wood to measure light at, expected some surface",
        )),
        false => Ok(found),
    }
}

fn twice_area([a, b, c]: [[f64; 3]; 3]) -> f64 {
    let (p, q): ([f64; 3], [f64; 3]) =
        (std::array::from_fn(|i| b[i] - a[i]), std::array::from_fn(|i| c[i] - a[i]));
    let cross: [f64; 3] = std::array::from_fn(|i| {
        let (j, k) = ((i + 1) % 3, (i + 2) % 3);
        p[j] * q[k] - p[k] * q[j]
    });
    libm::sqrt(cross.iter().map(|c| c * c).sum())
}

#[cfg(test)]
mod tests {
    use super::*;
    use flb_scene::Mesh;
    use flb_scene::mesh::{AlphaMode, Image, Material, Texture, Wrap};

    /// Two squares in the plane z = 0, of 1 and of 3 m^2, the second of another material.
    fn squares(alpha_mode: AlphaMode) -> ClassedMesh {
        let material =
            |name: &str, color_texture| Material { color_texture, alpha_mode, ..Material::opaque(name) };
        let transform = [[1.0, 0.0, 0.0], [0.0, 1.0, 0.0]];
        let texture = Texture { image: 0, wrap: [Wrap::Repeat; 2], transform };
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
        let points = points(classed, 1000, false).expect("there is surface");
        assert_eq!(points.len(), 1000);
        assert!(points.iter().all(|p| p[2] == 0.0 && (0.0..=1.0).contains(&p[1])));
        (points.iter().filter(|p| p[0] <= 1.0).count(), points)
    }

    #[test]
    fn points_are_even_by_area() {
        let (first, _) = on_the_first(&squares(AlphaMode::Opaque));
        assert!((240..=260).contains(&first), "{first} of 1000 on a quarter of the area");
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
        let failure = points(&classed, 10, false).expect_err("nothing counts");
        assert!(failure.message.contains("found no point of leaf or wood"), "{}", failure.message);
    }
}
