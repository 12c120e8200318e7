use flb_scene::Mesh;
use flb_scene::color::MaterialColor;
use flb_scene::mesh::Material;
use flb_transport::turbid::{LeafAngles, scatter};

use super::*;

/// Two leaves, each a square of 1 m side by side in the plane z = 0.5, then one of wood above the first; of sites of
/// 2 m the first pair shares one.
fn plant(colors: [[f64; 2]; 3]) -> (Plant, TurbidMedium) {
    let mut mesh = Mesh::default();
    for (index, [x, y]) in [[0.5, 0.5], [1.5, 0.5], [0.5, 2.5]].into_iter().enumerate() {
        // A little inside of its square, so that no corner is another site's.
        let (x, y): (f32, f32) = (x, y);
        let corner = |dx: f32, dy: f32| [x + 0.4 * dx, y + 0.4 * dy, 0.5];
        let first = mesh.positions.len() as u32;
        mesh.positions.extend([corner(-1.0, -1.0), corner(1.0, -1.0), corner(1.0, 1.0), corner(-1.0, 1.0)]);
        mesh.triangles.extend([[first, first + 1, first + 2], [first, first + 2, first + 3]]);
        mesh.triangle_material.extend([index as u32; 2]);
        mesh.materials.push(Material::opaque(["leaf", "petal", "bark"][index]));
    }
    let classes = vec![MaterialClass::Leaf, MaterialClass::Leaf, MaterialClass::Wood];
    let mut plant = Plant::new("plant", mesh, classes);
    for (color, [reflectance, transmittance]) in plant.colors.iter_mut().zip(colors) {
        let color: &mut MaterialColor = color.as_mut().expect("leaf or wood");
        color.shown = vec![MeanShares { reflectance, transmittance }; 3];
    }
    let grid = flb_format::Grid { lattice: 16, origin_m: [0.0; 3], spacing_m: 2.0 };
    let mut turbid = TurbidMedium {
        grid,
        leaf_per_m: vec![0.0; grid.sites()],
        wood_per_m: vec![0.0; grid.sites()],
        angles: LeafAngles::spherical(),
    };
    turbid.leaf_per_m[grid.index(0, 0, 0)] = 1.0;
    turbid.wood_per_m[grid.index(0, 1, 0)] = 1.0;
    turbid.leaf_per_m[grid.index(5, 5, 5)] = 1.0; // where no point is found
    (plant, turbid)
}

fn means() -> Vec<BandScatter> {
    flb_scene::leaf::knapp_carter().bands.iter().map(scatter).collect()
}

#[test]
fn a_site_of_two_materials_has_the_mean_by_area() {
    let (plant, turbid) = plant([[0.1, 0.1], [0.5, 0.3], [0.2, 0.0]]);
    let bands = mix(&plant, &[0, 2], &turbid, &means(), false).unwrap().expect("leaf and petal differ");
    assert_eq!(bands.len(), 2);
    for band in &bands {
        let [[leaf, _], [_, wood], _] = band.albedos[..] else { panic!("three sites") };
        assert!((leaf - 0.5).abs() < 1e-6 && (wood - 0.2).abs() < 1e-6, "{leaf} {wood}");
        assert!((band.transmitted[0] - 0.4).abs() < 1e-6, "{:?}", band.transmitted);
    }
    let [mean, ..] = &means()[..] else { panic!("three bands") };
    assert_eq!(bands[0].albedos[2], mean.albedos(0));
}

#[test]
fn plants_whose_leaves_are_alike_are_not_mixed() {
    let (plant, turbid) = plant([[0.1, 0.1], [0.1, 0.1], [0.2, 0.0]]);
    assert_eq!(mix(&plant, &[0, 1, 2], &turbid, &means(), false).unwrap(), None);
}

#[test]
fn another_mixture_has_another_digest() {
    let of = |colors| {
        let (plant, turbid) = plant(colors);
        digest(&mix(&plant, &[1], &turbid, &means(), false).unwrap().expect("they differ"))
    };
    assert_ne!(of([[0.1, 0.1], [0.5, 0.3], [0.2, 0.0]]), of([[0.1, 0.1], [0.3, 0.5], [0.2, 0.0]]));
}
