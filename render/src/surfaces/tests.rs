use flb_scene::mesh::{AlphaMode, Image, Wrap};

use crate::tests::{Setup, add_quad, at, dark, image, material, plain, reference, render, textured, wall};
use crate::*;
use flb_scene::{MaterialClass, Mesh};

const HALVES: Surfaces = Surfaces {
    leaf_reflectance: [0.1, 0.2, 0.3],
    leaf_transmittance: [0.1, 0.1, 0.1],
    wood_reflectance: [0.4; 3],
    solid_offset_m: None,
};
/// Points at which a mean is taken, and pixels: some thousands each.
const SAMPLING: f32 = 0.005;

/// The wall in an even fluence that makes a leaf send out R + T.
fn in_even_light(mesh: &Mesh, class: MaterialClass, surfaces: Surfaces) -> Picture {
    let even = |_: [f32; 3], phi: &mut [f32; 3]| *phi = [4.0 * std::f32::consts::PI; 3];
    let settings = Setup {
        width: 128,
        height: 128,
        indirect: Indirect::Only,
        shading: Shading::Physical(surfaces),
        ..plain()
    };
    render(mesh, &[class], &even, &settings).unwrap()
}

/// Mean of the pixels that show the wall.
fn mean_of(picture: &Picture) -> [f32; 3] {
    let seen: Vec<&[f32]> = picture.rgb.chunks_exact(3).filter(|rgb| rgb.iter().any(|&v| v > 0.0)).collect();
    assert!(seen.len() > 2_000, "{} pixels", seen.len());
    [0, 1, 2].map(|band| seen.iter().map(|rgb| rgb[band]).sum::<f32>() / seen.len() as f32)
}

fn assert_near(found: [f32; 3], expected: [f32; 3]) {
    let far = (0..3).any(|band| (found[band] / expected[band] - 1.0).abs() > SAMPLING);
    assert!(!far, "found {found:?}, expected {expected:?}");
}

/// Five colours; one of them, nearly black, is cut away.
fn colors() -> Image {
    image(&[
        [90, 120, 60, 255],
        [130, 150, 100, 255],
        [20, 20, 20, 0],
        [100, 80, 90, 255],
        [150, 140, 110, 255],
    ])
}

#[test]
fn a_texture_keeps_the_mean_of_its_surface() {
    let cut = textured(0, Wrap::Repeat, AlphaMode::Cut { cutoff: 0.5 });
    let mesh = wall(cut, vec![colors()], 1.0);
    let picture = in_even_light(&mesh, MaterialClass::Leaf, HALVES);
    assert_near(mean_of(&picture), [0.2, 0.3, 0.4]);
    // Wood sends out twice as much of a fluence that all comes through one face.
    let picture = in_even_light(&mesh, MaterialClass::Wood, HALVES);
    assert_near(mean_of(&picture), [0.8; 3]);
    let uneven = picture.rgb.iter().any(|&v| v > 0.9) && picture.rgb.iter().any(|&v| (0.1..0.7).contains(&v));
    assert!(uneven, "the texture shows");
}

#[test]
fn texels_that_no_surface_shows_do_not_count() {
    // The wall shows the first texel of a row of four; the others are far brighter.
    let atlas = image(&[[50; 4], [250; 4], [250; 4], [250; 4]].map(|[r, g, b, _]| [r, g, b, 255]));
    let mut mesh = wall(textured(0, Wrap::Clamp, AlphaMode::Opaque), vec![atlas], 1.0);
    mesh.uvs.iter_mut().for_each(|uv| uv[0] *= 0.125);
    assert_near(mean_of(&in_even_light(&mesh, MaterialClass::Leaf, HALVES)), [0.2, 0.3, 0.4]);
}

#[test]
fn large_faces_count_for_more_than_small_ones() {
    let texels = image(&[[90, 90, 90, 255], [140, 140, 140, 255]]);
    let mut mesh = wall(textured(0, Wrap::Clamp, AlphaMode::Opaque), vec![texels], 0.0);
    add_quad(&mut mesh, 0, [-0.5, 1.0, 0.0], [[1.0, 0.0, 0.0], [0.0, 1.0, 0.0]], 0.0);
    mesh.uvs[4..].fill([1.0, 0.0]);
    assert_near(mean_of(&in_even_light(&mesh, MaterialClass::Leaf, HALVES)), [0.2, 0.3, 0.4]);
}

#[test]
fn a_plain_color_changes_nothing_and_each_material_has_its_own_mean() {
    let mut mesh = wall(material("dark", [0.1, 0.2, 0.05]), vec![], 1.0);
    mesh.materials.push(material("bright", [0.9, 0.8, 0.7]));
    add_quad(&mut mesh, 1, [-1.0, 1.0, 0.0], [[2.0, 0.0, 0.0], [0.0, 2.0, 0.0]], 1.0);
    let even = |_: [f32; 3], phi: &mut [f32; 3]| *phi = [4.0 * std::f32::consts::PI; 3];
    let settings = Setup { indirect: Indirect::Only, shading: Shading::Physical(HALVES), ..plain() };
    let picture = render(&mesh, &[MaterialClass::Leaf; 2], &even, &settings).unwrap();
    assert_eq!(at(&picture, 16, 8), at(&picture, 16, 24));
    crate::tests::assert_close(at(&picture, 16, 8), [0.2, 0.3, 0.4]);
}

#[test]
fn a_bright_texel_sends_out_no_more_than_it_gets() {
    let mut texels = [[20, 20, 20, 255]; 16];
    texels[7] = [255; 4];
    let mesh = wall(textured(0, Wrap::Clamp, AlphaMode::Opaque), vec![image(&texels)], 1.0);
    let picture = in_even_light(&mesh, MaterialClass::Leaf, HALVES);
    let brightest = |band: usize| picture.rgb.iter().skip(band).step_by(3).fold(0.0f32, |a, &b| a.max(b));
    for band in 0..3 {
        assert!((brightest(band) - 1.0).abs() < 1e-6, "band {band}: {}", brightest(band));
    }
}

#[test]
fn what_is_neither_leaf_nor_wood_reflects_its_color() {
    let pot = wall(material("pot", [0.5, 0.3, 0.1]), vec![], 1.0);
    assert_near(mean_of(&in_even_light(&pot, MaterialClass::Neither, HALVES)), [1.0, 0.6, 0.2]);
}

#[test]
fn surfaces_that_cannot_be_are_refused_by_name() {
    let mesh = wall(material("wall", [1.0; 3]), vec![], 1.0);
    let refused = |surfaces: Surfaces| {
        let settings = Setup { samples: 2, shading: Shading::Physical(surfaces), ..plain() };
        let classes = [MaterialClass::Leaf];
        let shaded = render(&mesh, &classes, &dark, &settings).unwrap_err().to_string();
        let traced = reference(&mesh, &classes, &settings).unwrap_err().to_string();
        assert_eq!(shaded, traced);
        shaded
    };
    let message = refused(Surfaces { leaf_reflectance: [0.1, f32::NAN, 0.1], ..HALVES });
    assert_eq!(message, "render setting `leaf_reflectance` is [0.1, NaN, 0.1], expected 0..=1 in every band");
    assert!(
        refused(Surfaces { leaf_transmittance: [0.1, 0.1, -0.1], ..HALVES }).contains("`leaf_transmittance`")
    );
    assert!(refused(Surfaces { wood_reflectance: [1.1, 0.0, 0.0], ..HALVES }).contains("`wood_reflectance`"));
    let message = refused(Surfaces { leaf_transmittance: [0.1, 0.81, 0.1], ..HALVES });
    assert!(
        message.starts_with("render setting `leaf_reflectance + leaf_transmittance` is [0.2, 1.01"),
        "{message}"
    );
}
