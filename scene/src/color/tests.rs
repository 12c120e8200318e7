use flb_format::material_surface::{MaterialSurface, Texel};
use flb_format::matter::{BandSurfaces, Surfaces};
use glam::DVec3;

use super::*;
use crate::leaf::knapp_carter;
use crate::mesh::{AlphaMode, Filter, Image, Material, Texture, Wrap};
use crate::{ImportError, MaterialClass, Mesh, SpeciesFile};

const LEAF: [MaterialClass; 1] = [MaterialClass::Leaf];

/// A unit square per material, whose texture is a row of these texels.
fn squares(textures: &[&[[u8; 4]]]) -> Mesh {
    let mut mesh = Mesh::default();
    for (index, texels) in textures.iter().enumerate() {
        let first = mesh.positions.len() as u32;
        let x = index as f32 * 2.0;
        mesh.positions.extend([[x, 0.0, 0.0], [x + 1.0, 0.0, 0.0], [x + 1.0, 1.0, 0.0], [x, 1.0, 0.0]]);
        mesh.normals.extend([[0.0, 0.0, 1.0]; 4]);
        mesh.uvs.extend([[0.0, 0.0], [1.0, 0.0], [1.0, 1.0], [0.0, 1.0]]);
        mesh.triangles.extend([[first, first + 1, first + 2], [first, first + 2, first + 3]]);
        mesh.triangle_material.extend([index as u32; 2]);
        let rgba = texels.concat();
        let image = Image {
            name: "texture".to_owned(),
            width: texels.len() as u32,
            height: 1,
            has_cut: texels.iter().any(|texel| texel[3] < 255),
            rgba,
        };
        let transform = [[1.0, 0.0, 0.0], [0.0, 1.0, 0.0]];
        mesh.images.push(image);
        mesh.materials.push(Material {
            color_texture: Some(Texture {
                image: index as u32,
                wrap: [Wrap::Clamp; 2],
                transform,
                filter: Filter::Linear,
            }),
            alpha_mode: AlphaMode::Cut { cutoff: 0.5 },
            ..Material::opaque(["leaves", "petals", "moss"][index])
        });
    }
    mesh
}

fn plain(color: [f32; 3]) -> Mesh {
    let mut mesh = squares(&[&[[255; 4]]]);
    let [r, g, b] = color;
    mesh.materials[0].color_texture = None;
    mesh.materials[0].base_color = [r, g, b, 1.0];
    mesh
}

fn of(mesh: &Mesh, classes: &[MaterialClass], rules: &ColorRules) -> Colors {
    resolve(mesh, classes, &knapp_carter(), rules)
}

fn by_itself(mesh: &Mesh) -> Colors {
    of(mesh, &LEAF, &ColorRules::default())
}

fn asked(source: ColorSource) -> ColorRules {
    ColorRules { flag: Some(source), ..ColorRules::default() }
}

fn of_file(text: &str) -> ColorRules {
    SpeciesFile::parse("a.toml", text).unwrap().color_rules()
}

fn leaf(colors: &Colors) -> &MaterialColor {
    colors.materials[0].as_ref().unwrap()
}

const GREEN: [u8; 4] = [86, 110, 52, 255];
const RED: [u8; 4] = [150, 26, 22, 255];
const BARK: [u8; 4] = [110, 98, 84, 255];

#[test]
fn greens_are_tints_and_other_colors_their_own() {
    let greens: [[u8; 3]; 9] = [
        [86, 110, 52],   // the built-in oak
        [92, 120, 62],   // the shrub
        [72, 98, 62],    // the spruce
        [30, 40, 20],    // in the dark
        [200, 235, 120], // young
        [125, 130, 80],  // olive
        [100, 120, 90],  // grey
        [0, 255, 0],     // drawn
        [60, 160, 40],   // vivid
    ];
    let others: [[u8; 3]; 7] = [
        [150, 26, 22],   // red
        [200, 110, 40],  // orange
        [230, 200, 60],  // yellow
        [240, 235, 230], // petals, not quite white
        [120, 90, 60],   // dry
        [90, 60, 140],   // violet
        [131, 123, 56],  // the mean of a yellow sycamore maple
    ];
    let texel = |[r, g, b]: [u8; 3]| by_itself(&squares(&[&[[r, g, b, 255]]]));
    for color in greens {
        let colors = texel(color);
        assert_eq!(leaf(&colors).texel, Texel::Tint, "{color:?}: {}", leaf(&colors).rule);
        assert_eq!((colors.mean, &colors.surfaces[..]), (knapp_carter(), &[None][..]));
    }
    for color in others {
        let colors = texel(color);
        assert_eq!(leaf(&colors).texel, Texel::Albedo, "{color:?}: {}", leaf(&colors).rule);
        assert!(leaf(&colors).is_surprise && colors.surfaces[0].is_some());
    }
}

#[test]
fn barks_are_tints_and_birches_and_pots_have_colours_of_their_own() {
    let barks: [[f32; 3]; 5] = [
        [0.153, 0.123, 0.090],
        [0.124, 0.090, 0.039], // an oak
        [0.262, 0.240, 0.235], // a pine, grey
        [0.114, 0.103, 0.084], // a maple
        [0.070, 0.055, 0.040],
    ];
    let others: [([f32; 3], &str); 5] = [
        ([0.85, 0.85, 0.83], "far from the measured colour, 6.9 times as bright"),
        ([0.55, 0.53, 0.50], "far from the measured colour, 4.3 times as bright"), // a birch
        ([0.02, 0.02, 0.02], "far from the measured colour, 0.2 times as bright"),
        ([0.263, 0.127, 0.065], "far from the measured colour, 0.16 apart"), // a terracotta pot
        ([0.05, 0.10, 0.30], "far from the measured colour, 0.42 apart"),    // glazed
    ];
    let of_wood = |color| of(&plain(color), &[MaterialClass::Wood], &ColorRules::default());
    for color in barks {
        let colors = of_wood(color);
        assert_eq!(leaf(&colors).texel, Texel::Tint, "{color:?}: {}", leaf(&colors).rule);
        assert_eq!(colors.mean, knapp_carter());
    }
    for (color, rule) in others {
        let colors = of_wood(color);
        assert_eq!((leaf(&colors).texel, leaf(&colors).is_surprise), (Texel::Albedo, true), "{color:?}");
        assert_eq!(leaf(&colors).rule, rule);
        assert!((colors.mean.bands[2].wood.reflectance - f64::from(color[2])).abs() < 1e-6);
    }
    assert_eq!(leaf(&of_wood([1.0; 3])).texel, Texel::Tint, "white says nothing");
}

#[test]
fn an_albedo_reflects_its_texel_and_transmits_by_the_measured_ratio() {
    let colors = by_itself(&squares(&[&[RED]]));
    let shown = &leaf(&colors).shown;
    let linear = [0.304_987, 0.010_330, 0.008_023];
    for (band, (shown, of)) in shown.iter().zip(&knapp_carter().bands).enumerate() {
        assert!((shown.reflectance - linear[band]).abs() < 1e-5, "{band}: {shown:?}");
        let ratio = of.leaf.transmittance / of.leaf.reflectance;
        assert!((shown.transmittance - ratio * linear[band]).abs() < 1e-5, "{band}: {shown:?}");
        assert_eq!(colors.mean.bands[band].leaf.reflectance, shown.reflectance);
    }
    assert_eq!(leaf(&colors).clamped, 0.0);
}

#[test]
fn what_says_nothing_is_measured() {
    let white = by_itself(&squares(&[&[[255; 4]]]));
    let black = by_itself(&squares(&[&[[0, 0, 0, 255]]]));
    let nothing = by_itself(&plain([1.0; 3]));
    let cut_away = by_itself(&squares(&[&[[150, 26, 22, 0]]]));
    for colors in [&white, &black, &nothing, &cut_away] {
        assert_eq!((leaf(colors).texel, &colors.mean), (Texel::Tint, &knapp_carter()));
        assert_eq!(colors.surfaces, [None]);
    }
    assert_eq!(leaf(&black).warning.as_deref(), Some("its colour is black; taking the measured one"));
    assert!(leaf(&white).warning.is_none() && leaf(&nothing).texture.is_none());
    assert_eq!(leaf(&by_itself(&plain([0.3, 0.01, 0.01]))).texel, Texel::Albedo);
}

#[test]
fn requests_win_and_those_that_cannot_be_followed_say_why() {
    let green = squares(&[&[GREEN]]);
    let colors = of(&green, &LEAF, &asked(ColorSource::Texture));
    assert_eq!((leaf(&colors).texel, leaf(&colors).is_surprise), (Texel::Albedo, false));
    let red = of(&squares(&[&[RED]]), &LEAF, &asked(ColorSource::Measured));
    assert_eq!((leaf(&red).texel, &red.mean), (Texel::Tint, &knapp_carter()));

    let bare = of(&plain([1.0; 3]), &LEAF, &asked(ColorSource::Texture));
    let expected = "--leaf-colour texture: found neither a texture nor a base colour, expected a colour to take; taking \
                    the measured colour";
    assert_eq!(leaf(&bare).warning.as_deref(), Some(expected));
    let model = crate::leaf::LeafModel::default();
    let infrared = model.surfaces(&crate::leaf::Bands::Ranges(vec![crate::leaf::Range {
        name: "NIR".to_owned(),
        low_nm: 750.0,
        high_nm: 900.0,
    }]));
    let blind = resolve(&green, &LEAF, &infrared, &asked(ColorSource::Texture));
    let warning = leaf(&blind).warning.clone().unwrap();
    assert!(warning.contains("found the bands NIR, expected R, G and B among them"), "{warning}");
    assert_eq!(blind.mean, infrared);
}

#[test]
fn a_file_speaks_of_materials_and_the_flag_of_leaves() {
    let mesh = squares(&[&[GREEN], &[RED], &[RED]]);
    let classes = [MaterialClass::Leaf, MaterialClass::Leaf, MaterialClass::Wood];
    let texels = |rules: &ColorRules| -> Vec<Texel> {
        of(&mesh, &classes, rules).materials.iter().flatten().map(|material| material.texel).collect()
    };
    use Texel::{Albedo, Tint};
    assert_eq!(texels(&ColorRules::default()), [Tint, Albedo, Albedo]);
    assert_eq!(texels(&of_file("leaf_colour = \"texture\"")), [Albedo, Albedo, Albedo]);
    assert_eq!(texels(&of_file("wood_colour = \"measured\"")), [Tint, Albedo, Tint]);
    let measured = ColorRules { wood_flag: Some(ColorSource::Measured), ..ColorRules::default() };
    assert_eq!(texels(&measured), [Tint, Albedo, Tint]);
    let both = "leaf_colour = [{ material = \"moss\", colour = \"texture\" }]\nwood_colour = \"measured\"";
    assert_eq!(texels(&of_file(both)), [Tint, Albedo, Tint], "of wood its own key counts first");
    let missed =
        of_file("wood_colour = [{ material = \"pot\", colour = \"texture\" }]").check(&["moss"]).unwrap_err();
    assert!(missed.to_string().contains("a.toml: wood_colour"), "{missed}");
    let by_material = r#"leaf_colour = [{ material = "PET*", colour = "measured" }, { material = "moss", colour = "texture" },
                         { colour = "texture" }]"#;
    let rules = of_file(by_material);
    assert_eq!(texels(&rules), [Albedo, Tint, Albedo]);
    assert_eq!(
        texels(&ColorRules { flag: Some(ColorSource::Measured), ..rules.clone() }),
        [Tint, Tint, Albedo]
    );

    assert!(rules.check(&["leaves", "petals", "moss"]).is_ok());
    let error = rules.check(&["leaves", "petals"]).unwrap_err();
    assert!(matches!(&error, ImportError::NothingMatched { pattern, .. } if pattern == "moss"), "{error}");
    let error =
        of_file(r#"leaf_colour = [{ material = "a[", colour = "texture" }]"#).check(&["a"]).unwrap_err();
    assert!(matches!(error, ImportError::BadPattern { .. }), "{error}");
}

#[test]
fn a_material_with_surfaces_of_its_own_is_mixed_into_the_mean() {
    let petals = |name: &str, r: f64, t: f64| {
        format!(
            "[[surfaces]]\nmaterial = \"petal*\"\nname = \"{name}\"\nleaf = {{ reflectance = {r}, transmittance = {t} }}\n"
        )
    };
    let rules = of_file(&[petals("R", 0.6, 0.3), petals("G", 0.1, 0.05), petals("B", 0.1, 0.05)].concat());
    let mut mesh = squares(&[&[GREEN], &[RED], &[BARK]]);
    mesh.materials[1].color_texture = None;
    let classes = [MaterialClass::Leaf, MaterialClass::Leaf, MaterialClass::Wood];
    let colors = of(&mesh, &classes, &rules);
    let [red, ..] = &colors.mean.bands[..] else { panic!("three bands") };
    assert!((red.leaf.reflectance - (0.07 + 0.6) / 2.0).abs() < 1e-6, "{red:?}");
    assert!((red.leaf.transmittance - (0.055 + 0.3) / 2.0).abs() < 1e-6, "{red:?}");
    assert_eq!(red.wood, knapp_carter().bands[0].wood);
    // Both leaves now differ from the mean leaf, and say so; the wood does not.
    let reflectances = colors.surfaces.iter().map(|surface| surface.as_ref().map(|of| of.reflectance[0]));
    assert_eq!(reflectances.collect::<Vec<_>>(), [Some(0.07), Some(0.6), None]);
}

#[test]
fn bright_texels_are_clamped_and_the_mean_is_that_of_what_is_shown() {
    // One texel of eight is far brighter than the others.
    let mut row = [[60, 80, 40, 255]; 8];
    row[3] = [250, 255, 240, 255];
    let colors = of(&squares(&[&row]), &LEAF, &asked(ColorSource::Measured));
    let clamped = leaf(&colors).clamped;
    assert!((0.05..0.2).contains(&clamped), "{clamped}");
    let green = colors.mean.bands[1].leaf;
    assert!(green.reflectance + green.transmittance < 0.275 * 0.99, "{green:?}");
    // The tint is still about the measured leaf, which is no longer the mean one.
    assert_eq!(
        colors.surfaces[0].as_ref().map(|of| (of.texel, of.reflectance[1])),
        Some((Texel::Tint, 0.125))
    );
    let white = of(&squares(&[&[[255; 4]]]), &LEAF, &asked(ColorSource::Texture));
    for band in &white.mean.bands {
        assert!((band.leaf.reflectance + band.leaf.transmittance - 1.0).abs() < 1e-6, "{band:?}");
    }
    assert_eq!(leaf(&white).clamped, 0.0, "in the mean all bands are scaled alike");
}

#[test]
fn petals_keep_their_hue_however_bright() {
    for texel in [[240u8, 235, 230], [250, 215, 40], [255, 255, 255]] {
        let [r, g, b] = texel;
        let mut mesh = squares(&[&[[r, g, b, 255]; 2]]);
        mesh.materials[0].name = "Cherry_Petals".to_owned();
        let colors = by_itself(&mesh);
        let of = leaf(&colors);
        assert_eq!((of.texel, of.clamped, of.warning.as_deref()), (Texel::Albedo, 0.0, None), "{texel:?}");
        let color = of.texture.unwrap();
        let scale = of.shown[0].reflectance / color[0];
        for (shown, color) in of.shown.iter().zip(color) {
            assert!((shown.reflectance - scale * color).abs() < 1e-6, "{texel:?}: {shown:?}");
            assert!((shown.transmittance / shown.reflectance - 1.2).abs() < 1e-4, "{texel:?}: {shown:?}");
        }
        let sent = of.shown.iter().map(|shown| shown.reflectance + shown.transmittance).fold(0.0, f64::max);
        assert!((sent - 1.0).abs() < 1e-6, "{texel:?}: {sent}");
    }
}

#[test]
fn white_is_the_colour_of_flowers_and_a_word_on_leaves() {
    let named = |name: &str, mut mesh: Mesh| {
        mesh.materials[0].name = name.to_owned();
        let colors = by_itself(&mesh);
        (leaf(&colors).texel, leaf(&colors).warning.clone())
    };
    let picture = || squares(&[&[[255; 4]; 2]]);
    for name in [
        "petals",
        "Blüten",
        "cherryPetal",
        "white_flower_mat",
        "flor_blanca",
        "Kirschblüten",
        "花瓣",
        "kwiat",
    ] {
        assert_eq!(named(name, picture()), (Texel::Albedo, None), "{name}");
        assert_eq!(named(name, squares(&[&[[255; 4]]])), (Texel::Albedo, None), "{name}");
        assert_eq!(named(name, plain([1.0; 3])), (Texel::Albedo, None), "{name}");
    }
    for name in ["leaves", "flower_leaves", "petal_stem"] {
        let (texel, warning) = named(name, picture());
        assert!(texel == Texel::Tint && warning.is_some_and(|told| told.contains("white")), "{name}");
        assert_eq!(named(name, squares(&[&[[255; 4]]])), (Texel::Tint, None), "{name}");
    }
}

#[test]
fn diffuse_transmission_divides_the_texel() {
    let mut mesh = squares(&[&[RED]]);
    mesh.materials[0].diffuse_transmission = Some(0.25);
    let shown = leaf(&by_itself(&mesh)).shown[0];
    assert!((shown.transmittance / shown.reflectance - 1.0 / 3.0).abs() < 1e-6, "{shown:?}");
    assert!((shown.transmittance + shown.reflectance - 0.304_987).abs() < 1e-5, "{shown:?}");
}

#[test]
fn measured_leaves_are_divided_as_the_file_says() {
    let of_factor = |factor: f32, rules: &ColorRules| {
        let mut mesh = squares(&[&[GREEN]]);
        mesh.materials[0].diffuse_transmission = Some(factor);
        of(&mesh, &LEAF, rules)
    };
    let measured = knapp_carter();
    for factor in [0.0, 0.4, 0.9] {
        let colors = of_factor(factor, &ColorRules::default());
        let (color, passes) = (leaf(&colors), f64::from(factor));
        assert_eq!(color.texel, Texel::Tint);
        assert!(color.note.as_ref().is_some_and(|note| note.contains("as its file says")), "{color:?}");
        for (shown, band) in color.shown.iter().zip(&measured.bands) {
            let scattered = band.leaf.reflectance + band.leaf.transmittance;
            assert!((shown.transmittance - passes * scattered).abs() < 1e-6, "{factor}: {shown:?}");
            assert!((shown.reflectance - (1.0 - passes) * scattered).abs() < 1e-6, "{factor}: {shown:?}");
        }
        let mean = &colors.mean.bands[1].leaf;
        assert!((mean.transmittance - color.shown[1].transmittance).abs() < 1e-12, "{mean:?}");
    }
    // What is said of leaves, by a flag or a species file, goes before, and is told.
    let surfaces = "[[surfaces]]\nname = 'R'\nleaf = { reflectance = 0.1, transmittance = 0.1 }\nwood = { reflectance = 0.1 }";
    for rules in [asked(ColorSource::Measured), of_file(surfaces)] {
        let colors = of_factor(0.9, &rules);
        assert_eq!(colors.mean, measured);
        assert!(leaf(&colors).note.as_ref().is_some_and(|note| note.contains("what is measured is taken")));
    }
    assert_eq!(leaf(&by_itself(&squares(&[&[GREEN]]))).note, None);
}

#[test]
fn distances_of_colors_leave_brightness_out() {
    let green = DVec3::new(0.07, 0.125, 0.04);
    assert!(apart(3.0 * green, green) < 1e-12);
    assert_eq!((apart(DVec3::X, DVec3::Y), apart(DVec3::Y, green)), (1.0, 0.0));
    assert!((apart(DVec3::ONE, DVec3::Y) - 2.0 / 3.0).abs() < 1e-12);
}

#[test]
fn the_order_of_bands_changes_no_decision_and_no_surface() {
    let mesh = squares(&[&[RED], &[GREEN]]);
    let measured = crate::leaf::knapp_carter();
    let by_name = |colors: &Colors, surfaces: &Surfaces, name: &str| {
        let band = surfaces.bands.iter().position(|band| band.name == name).expect("it is there");
        let of = |surface: &Option<MaterialSurface>| {
            surface
                .as_ref()
                .map(|surface| (surface.texel, surface.reflectance[band], surface.transmittance[band]))
        };
        let mean = &colors.mean.bands[band];
        (colors.surfaces.iter().map(of).collect::<Vec<_>>(), mean.leaf.reflectance, mean.leaf.transmittance)
    };
    let classes = [MaterialClass::Leaf; 2];
    let expected = resolve(&mesh, &classes, &measured, &ColorRules::default());
    for order in [[2, 1, 0], [1, 0, 2], [1, 2, 0]] {
        let mut turned = measured.clone();
        turned.bands = order.iter().map(|&band| measured.bands[band].clone()).collect();
        turned.bands.insert(0, BandSurfaces { name: "NIR".to_owned(), ..measured.bands[1].clone() });
        let found = resolve(&mesh, &classes, &turned, &ColorRules::default());
        for name in ["R", "G", "B"] {
            assert_eq!(
                by_name(&found, &turned, name),
                by_name(&expected, &measured, name),
                "{order:?}, {name}"
            );
        }
        let told = |colors: &Colors| {
            let of = |color: &Option<MaterialColor>| {
                color.as_ref().map(|color| (color.measured.clone(), color.rule.clone()))
            };
            colors.materials.iter().map(of).collect::<Vec<_>>()
        };
        assert_eq!(told(&found), told(&expected), "{order:?}");
    }
}
