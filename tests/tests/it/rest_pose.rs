//! Whatever draws a plant asks for its light at the rest pose: a swaying mesh, and any level of detail of it.

use flb_fixtures::PlantKind;
use flb_runtime::{Daylight, InstanceLight, SpeciesLight};
use flb_scene::{ClassedMesh, MaterialClass};
use flb_tests::default_bake::DefaultBake;

const DAYLIGHT: Daylight = Daylight { towards_sun: [0.3, 0.8, 0.2], sun: 1.0, sky: 0.36 };

/// Middles of leaf triangles with their areas, m^2.
fn leaves(plant: &ClassedMesh) -> Vec<([f32; 3], f64)> {
    let ClassedMesh { mesh, classes } = plant;
    let is_leaf = |material: u32| classes[material as usize] == MaterialClass::Leaf;
    let of_triangle = |triangle: &[u32; 3]| {
        let [a, b, c] = triangle.map(|vertex| mesh.positions[vertex as usize]);
        let [p, q]: [[f64; 3]; 2] =
            [b, c].map(|end| std::array::from_fn(|axis| f64::from(end[axis]) - f64::from(a[axis])));
        let cross: [f64; 3] = std::array::from_fn(|i| {
            let (j, k) = ((i + 1) % 3, (i + 2) % 3);
            p[j] * q[k] - p[k] * q[j]
        });
        let area = libm::sqrt(cross.iter().map(|c| c * c).sum::<f64>()) / 2.0;
        ([0, 1, 2].map(|axis| (a[axis] + b[axis] + c[axis]) / 3.0), area)
    };
    let triangles = mesh.triangles.iter().zip(&mesh.triangle_material);
    triangles.filter(|(_, material)| is_leaf(**material)).map(|(triangle, _)| of_triangle(triangle)).collect()
}

fn at(lit: &InstanceLight<'_>, point: [f32; 3]) -> [f32; 3] {
    let mut phi = [0.0; 3];
    lit.at(point, &mut phi);
    phi
}

/// Mean of the bands over the area.
fn mean(lit: &InstanceLight<'_>, leaves: &[([f32; 3], f64)]) -> [f64; 3] {
    let whole: f64 = leaves.iter().map(|(_, area)| area).sum();
    let mut sums = [0.0; 3];
    for (middle, area) in leaves {
        let phi = at(lit, *middle);
        sums.iter_mut().zip(phi).for_each(|(sum, phi)| *sum += f64::from(phi) * area / whole);
    }
    sums
}

/// Where a gust from the west holds a point: 20 degrees of lean at the top of a plant 6 m high.
fn swayed([x, y, z]: [f32; 3]) -> [f32; 3] {
    [x + 0.06 * y * y, y, z]
}

#[test]
fn light_at_the_rest_pose_does_not_flicker_in_wind_and_serves_every_level_of_detail() {
    let oak = DefaultBake::of(PlantKind::Oak);
    let library = oak.library();
    let light = SpeciesLight::load(&library, 0).expect("a default bake");
    let lit = light.lit_by_in_model(&DAYLIGHT).expect("a sun").prepared();
    let leaves = leaves(&oak.mesh);
    assert!(leaves.len() > 1000, "{}", leaves.len());

    // Levels of detail that keep one leaf triangle of five or of seven: their mean light is that of the whole crown,
    // within what a thousand points tell of it.
    let whole = mean(&lit, &leaves);
    for kept in [5, 7] {
        let coarse: Vec<_> = leaves.iter().copied().step_by(kept).collect();
        let of_coarse = mean(&lit, &coarse);
        for band in 0..3 {
            let ratio = of_coarse[band] / whole[band];
            assert!((ratio - 1.0).abs() < 0.03, "one of {kept}, band {band}: {ratio}");
        }
    }

    // A leaf that wind moves keeps its light where the rest pose is asked for; asked for where it is drawn, most of the
    // crown would be lit as if it stood beside itself.
    let (mut squares, mut sum) = (0.0, 0.0);
    for (middle, _) in &leaves {
        let [_, calm, _] = at(&lit, *middle);
        let [_, moved, _] = at(&lit, swayed(*middle));
        squares += f64::from(calm - moved) * f64::from(calm - moved);
        sum += f64::from(calm);
    }
    let rms = libm::sqrt(squares / leaves.len() as f64) / (sum / leaves.len() as f64);
    assert!(rms > 0.2, "a swayed point would be off by {rms} only");
}
