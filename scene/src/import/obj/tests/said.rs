//! What an OBJ and its MTL say beside triangles: colours of vertices, where it stands, its groups, and how much is
//! there.

use super::*;
use crate::classify::{ClassRules, classify};
use crate::{MaterialClass, PlantReader, plant::ClassedMesh};

#[test]
fn colours_behind_coordinates_are_srgb_of_either_range() {
    let with = |colors: [&str; 3]| {
        let [a, b, c] = colors;
        read_text(&format!("v 0 0 0 {a}\nv 1 0 0 {b}\nv 0 1 0 {c}\nf 1 2 3\n")).unwrap()
    };
    let mesh = with(["1 0 0", "0 0.5 0", "0 0 0.25"]);
    let expected = [[1.0, 0.0, 0.0], [0.0, 0.21404, 0.0], [0.0, 0.0, 0.05088]];
    for (color, expected) in mesh.colors.iter().flatten().zip(expected.as_flattened()) {
        assert!((color - expected).abs() < 1e-4, "{:?}", mesh.colors);
    }
    assert!(mesh.notes[0].contains("sRGB from 0 to 1"), "{:?}", mesh.notes);
    let bytes = with(["255 0 0", "0 127.5 0", "0 0 63.75"]);
    assert_eq!(bytes.colors, mesh.colors);
    assert!(with(["1 1 1", "1 1 1", "1 1 1"]).colors.is_empty(), "white says nothing");
    assert!(with(["1", "1", "0.5"]).colors.is_empty(), "a fourth number is a weight");
    let half = read_text("v 0 0 0\nv 1 0 0 1 0 0\nv 0 1 0\nf 1 2 3\n").unwrap();
    assert_eq!(half.colors, [[1.0; 3], [1.0, 0.0, 0.0], [1.0; 3]]);
}

#[test]
fn a_plant_in_national_coordinates_is_as_at_the_origin() {
    let plant = |east: f64, north: f64, up: f64| {
        let mut text = String::new();
        for i in 0..60 {
            let (x, y) = (0.013 * f64::from(i), 0.007 * f64::from(i * i % 17));
            for [dx, dy, dz] in [[0.0, 0.0, 0.0], [0.05, 0.0, 0.01], [0.0, 0.05, 0.002]] {
                text += &format!("v {:.3} {:.3} {:.3}\n", east + x + dx, north + y + dy, up + x + dz);
            }
            text += "f -3 -2 -1\n";
        }
        read_text(&text).unwrap()
    };
    let near = plant(0.0, 0.0, 0.0);
    for (east, north, up) in [(448262.0, 5411932.0, 318.0), (-17000000.0, 0.0, 0.0), (150.0, 0.0, 90.0)] {
        let far = plant(east, north, up);
        assert_eq!(far.triangles.len(), near.triangles.len());
        assert!((area_of(&far) / area_of(&near) - 1.0).abs() < 1e-5, "{}", area_of(&far));
        assert!(far.offset_m.iter().any(|offset| *offset != 0.0));
        assert!(far.bounds().unwrap().max.iter().all(|x| x.abs() < 2.0), "{:?}", far.bounds());
    }
}

#[test]
fn coordinates_that_went_through_f32_are_refused_where_that_lost_the_shape() {
    let text = |edge: f32| {
        let east = 5411932.0f32;
        format!("v {} 0 0\nv {} {edge} 0\nv {} 0 {edge}\nf 1 2 3\n", east, east + edge, east)
    };
    let error = read_text(&text(2.0)).unwrap_err().to_string();
    assert!(error.contains("the v lines: found coordinates of 5411934 in numbers of 32 bits"), "{error}");
    assert!(read_text(&text(64.0)).is_ok(), "a larger shape is there");
    // The shape of a leaf in seven digits, as many programs print them.
    let seven = "v 448262.3 5411932 318.12\nv 448262.4 5411932 318.16\nv 448262.3 5411933 318.12\nf 1 2 3\n";
    let error = read_text(seven).unwrap_err().to_string();
    assert!(
        error.contains("the v lines: found coordinates of 5411933 with so few digits that their steps are 1"),
        "{error}"
    );
    let centimetres = "v 448262.31 5411932.04 318.12\nv 448262.44 5411932.09 318.16\n\
                       v 448262.37 5411932.18 318.12\nf 1 2 3\n";
    assert!(read_text(centimetres).is_ok());
    // Leaves of a decimetre, in decimetres, beside a trunk of long edges.
    let tree = |digits: usize| {
        let mut text = String::new();
        for i in 0..40 {
            let (x, y) = (448262.13 + 0.17 * f64::from(i), 5411932.27 + 0.11 * f64::from(i));
            let [w, h] = if i < 10 { [3.0, 9.0] } else { [0.1, 0.1] };
            text += &format!("v {x:.digits$} {y:.digits$} {:.digits$}\n", 318.1 + 0.13 * f64::from(i));
            text += &format!(
                "v {:.digits$} {y:.digits$} 318.3\nv {x:.digits$} {:.digits$} 318.3\n",
                x + w,
                y + h
            );
            text += "f -3 -2 -1\n";
        }
        read_text(&text)
    };
    let mut small = String::new();
    for i in 0..40 {
        let (x, h) = (448262.1 + 0.3 * f64::from(i), if i < 10 { 9.0 } else { 0.1 });
        small += &format!("v {x:.1} 5411932.0 0\nv {:.1} 5411932.0 0\n", x + 0.1);
        small += &format!("v {x:.1} {:.1} 0\nf -3 -2 -1\n", 5411932.0 + h);
    }
    let error = read_text(&small).unwrap_err().to_string();
    assert!(error.contains("steps are 0.1 there, and 75 % of the triangles within 2 steps"), "{error}");
    assert!(tree(3).is_ok());
}

#[test]
fn a_highlight_above_1_does_not_make_bytes_of_colours() {
    let with = |highlight: &str| {
        read_text(&format!(
            "v 0 0 0 0.2 0.5 0.1\nv 1 0 0 0.2 0.5 0.1\nv 0 1 0 0.2 {highlight} 0.1\nf 1 2 3\n"
        ))
        .unwrap()
    };
    let (plain, light) = (with("1"), with("1.02"));
    assert_eq!(plain.colors, light.colors);
    let told = light.warnings.join("; ");
    assert!(
        told.contains("are up to 1.02") && told.contains("1 of 9 values above 0 are taken as 1"),
        "{told}"
    );
    assert!(plain.warnings.iter().all(|told| !told.contains("colours of vertices")));
    let dark = read_text("v 0 0 0 2 5 1\nv 1 0 0 0 3 0\nv 0 1 0 1 1 1\nf 1 2 3\n").unwrap();
    assert!(dark.notes[0].contains("from 0 to 255"), "{:?}", dark.notes);
}

#[test]
fn groups_and_objects_are_parts_that_can_be_chosen() {
    let text = format!(
        "{TRIANGLE}v 0 0 5\nv 1 0 5\nv 0 1 5\no Oak\ng Trunk\nusemtl atlas\nf 1 2 3\ng Crown_LOD0\nf 4 5 6\n\
         o Pine\nf 1 2 6\n"
    );
    let mesh = read_text(&text).unwrap();
    let labels: Vec<String> = mesh.parts.iter().map(|part| part.label()).collect();
    assert_eq!(labels, ["Trunk", "Crown_LOD0", "Pine"]);
    assert_eq!(mesh.parts[0].names, ["Trunk", "Oak"]);
    assert_eq!(mesh.materials.len(), 3, "trunk, crown, and what says nothing");
    let chosen = |words: &[&str]| {
        let folder = tempfile::tempdir().unwrap();
        fs::write(folder.path().join("a.obj"), &text).unwrap();
        let nodes = words.iter().map(|&word| word.to_owned()).collect();
        import(&folder.path().join("a.obj"), &ImportSettings { nodes, ..ImportSettings::default() })
    };
    assert_eq!(chosen(&["oak"]).unwrap().triangles.len(), 2);
    assert_eq!(chosen(&["crown*"]).unwrap().bounds().unwrap().min[2], 5.0);
    let error = chosen(&["birch"]).unwrap_err().to_string();
    assert!(error.contains("there are: 'Trunk', 'Crown_LOD0', 'Pine'"), "{error}");
}

#[test]
fn the_alpha_of_a_colour_image_is_no_cut_where_it_is_gloss_or_the_material_is_wood() {
    let obj = format!(
        "mtllib a.mtl\n{TRIANGLE}v 0 0 1\nv 1 0 1\nv 0 1 1\nusemtl bark\nf 1 2 3\nusemtl leaves\nf 4 5 6\n"
    );
    let with = |alpha: &dyn Fn(u32) -> u8| {
        let image = png(alpha);
        let mtl = b"newmtl bark\nmap_Kd a.png\nnewmtl leaves\nmap_Kd a.png\n";
        let mesh = read(&[("a.obj", obj.as_bytes()), ("a.mtl", mtl), ("a.png", &image)]).unwrap();
        let warnings = mesh.warnings.clone();
        let (ClassedMesh { mesh, classes }, _) = PlantReader::default().class(mesh).unwrap();
        assert_eq!(classes, [MaterialClass::Wood, MaterialClass::Leaf]);
        (mesh.materials[0].alpha_mode, mesh.materials[1].alpha_mode, warnings)
    };
    let cut = AlphaMode::Cut { cutoff: 0.5 };
    let (bark, leaves, warnings) = with(&|x| if x < 2 { 0 } else { 255 });
    assert_eq!((bark, leaves), (AlphaMode::Opaque, cut));
    assert!(warnings[0].contains("it cuts, unless the material is wood"), "{warnings:?}");
    let (bark, leaves, warnings) = with(&|x| 100 + 20 * x as u8);
    assert_eq!((bark, leaves), (AlphaMode::Opaque, AlphaMode::Opaque));
    assert!(warnings[0].contains("is no outline (100 % of it is neither 0 nor 1)"), "{warnings:?}");
    let (bark, leaves, warnings) = with(&|_| 0);
    assert_eq!((bark, leaves), (AlphaMode::Opaque, AlphaMode::Opaque));
    assert!(warnings[0].contains("is 0 everywhere; it is not used"), "{warnings:?}");
}

#[test]
fn an_image_of_ambient_light_stands_in_for_a_colour() {
    let obj = format!("mtllib a.mtl\n{TRIANGLE}vt 0 0\nusemtl leaves\nf 1/1 2/1 3/1\n");
    let image = png(|_| 255);
    let files =
        |mtl: &'static [u8]| read(&[("a.obj", obj.as_bytes()), ("a.mtl", mtl), ("a.png", &image)]).unwrap();
    let mesh = files(b"newmtl leaves\nmap_Ka a.png\n");
    assert!(mesh.materials[0].color_texture.is_some());
    assert!(mesh.warnings[0].contains("its map_Ka 'a.png' is taken as its colour"), "{:?}", mesh.warnings);
    let both = files(b"newmtl leaves\nmap_Ka a.png\nmap_Kd a.png\n");
    assert!(both.warnings.is_empty(), "{:?}", both.warnings);
    assert!(classify(&both, &ClassRules::default()).is_ok());
}

#[test]
fn a_surface_without_an_image_may_be_there_in_part() {
    let obj = format!("mtllib a.mtl\n{TRIANGLE}usemtl leaves\nf 1 2 3\n");
    for (mtl, share) in [("newmtl leaves\nd 0.4\n", 0.4), ("newmtl leaves\nTr 0.25\n", 0.75)] {
        let mesh = read(&[("a.obj", obj.as_bytes()), ("a.mtl", mtl.as_bytes())]).unwrap();
        let coverage = [crate::alpha::Coverage::of(&mesh, 0).unwrap()];
        let mut there = 0.0;
        crate::color::on_surface(&mesh, &coverage, |_, _, area| there += area);
        assert!((there / 0.5 - share).abs() < 0.02, "{mtl}: {there}");
    }
}

#[test]
fn values_of_a_form_that_is_not_read_are_told_with_their_line() {
    let obj = format!("mtllib a.mtl\n{TRIANGLE}usemtl leaves\nf 1 2 3\n");
    let image = png(|_| 255);
    let told = |statement: &str| {
        let mtl = format!("newmtl leaves\n{statement}\n");
        let mesh = read(&[("a.obj", obj.as_bytes()), ("a.mtl", mtl.as_bytes()), ("a.png", &image)]).unwrap();
        mesh.warnings.join("; ")
    };
    let cases = [
        ("Kd 0,1 0,3 0,05", "line 2 of a.mtl, Kd: found '0,1 0,3 0,05', expected three numbers"),
        ("Kd spectral green.rfl 1", "Kd: found 'spectral green.rfl 1'"),
        ("Kd xyz 0.1 0.2 0.05", "Kd: found 'xyz 0.1 0.2 0.05'"),
        ("Kd 0.1 nan 0.1", "Kd: found '0.1 nan 0.1'"),
        ("Kd 25 76 12", "the material 'leaves' has the colour 25 76 12, expected shares from 0 to 1"),
        ("Kd -0.1 0.3 0.1", "'leaves' has the colour -0.1 0.3 0.1"),
        ("d 0,5", "line 2 of a.mtl, d: found '0,5', expected a number"),
        ("Tr", "Tr: found ''"),
        ("d 0.4\nTr 0.4", "a.mtl: d in line 2 says an opacity of 0.4, Tr in line 3 one of 0.6: d is taken"),
        ("Tr 1\nd 1", "Tr in line 2 one of 0: d is taken"),
        ("map_Kd -mm 0.0 0.2 a.png", "-mm of map_Kd (a.mtl) is not read"),
        ("map_Kd -t 0.5 0.5 0.5 a.png", "-t of map_Kd (a.mtl) is not read"),
        ("map_Kd -imfchan g a.png", "-imfchan of map_Kd (a.mtl) is not read"),
        ("map_d -imfchan z a.png", "-imfchan of map_d (a.mtl) is not read"),
        ("d 0.5\nmap_d a.png", "its d or Tr, 0.5, is not used"),
        ("map_Kd a.png", "1 face of the material 'leaves' has no texture coordinates (vt)"),
    ];
    for (statement, words) in cases {
        assert!(told(statement).contains(words), "{statement}: {}", told(statement));
    }
    for fine in [
        "Kd 0.1 0.3 0.05 # green",
        "Kd 0.5",
        "d 0.5",
        "d 0.7\nTr 0.3",
        "d -halo 0.5",
        "Kd 0 0 0\nmap_d -mm 0 1 -t 0 0 a.png",
    ] {
        let told = told(fine);
        assert!(!told.contains("expected") && !told.contains("is not read"), "{fine}: {told}");
    }
}

#[test]
fn colours_to_255_leave_alpha_as_it_is() {
    let obj = |scale: f32| {
        let c = 0.5 * scale;
        let vertices = ["0 0 0", "1 0 0", "0 1 0"].map(|at| format!("v {at} {c} {scale} {c}\n")).concat();
        format!("mtllib a.mtl\n{vertices}vt 0 0\nvt 1 0\nvt 0 1\nusemtl leaves\nf 1/1 2/2 3/3\n")
    };
    let image = png(|x| if x < 2 { 0 } else { 255 });
    let mtl = b"newmtl leaves\nmap_Kd a.png\nmap_d a.png\n";
    let left = |obj: &str| {
        let mesh = read(&[("a.obj", obj.as_bytes()), ("a.mtl", mtl), ("a.png", &image)]).unwrap();
        let coverage = [crate::alpha::Coverage::of(&mesh, 0).unwrap()];
        let mut there = 0.0;
        crate::color::on_surface(&mesh, &coverage, |_, _, area| there += area);
        (there, mesh.colors)
    };
    let [ones, bytes, rounded] = [1.0, 255.0, 1.000_001].map(|scale| left(&obj(scale)));
    assert!((ones.0 - 0.125).abs() < 0.01, "{}", ones.0);
    assert_eq!(ones, bytes);
    assert!((rounded.1[0][0] - ones.1[0][0]).abs() < 1e-5 && rounded.1[0][1] == 1.0, "{rounded:?}");
}

#[test]
fn numbers_of_a_vertex_that_mean_nothing_here_are_told() {
    for (numbers, words) in [
        ("0.5", "the fourth number of v is not read: a weight"),
        ("1 2", "the fourth and fifth number of v is not read"),
        ("1 0 0 0.4", "the seventh number of v is not read"),
    ] {
        let mesh = read_text(&format!("v 0 0 0 {numbers}\nv 1 0 0\nv 0 1 0\nf 1 2 3\n")).unwrap();
        assert!(mesh.warnings.iter().any(|warning| warning.contains(words)), "{:?}", mesh.warnings);
    }
    let mesh = read_text("v 0 0 0 1\nv 1 0 0 1 0 0 1\nv 0 1 0\nf 1 2 3\n").unwrap();
    assert!(!mesh.warnings.iter().any(|warning| warning.contains("number of v")), "{:?}", mesh.warnings);
}

#[test]
fn a_material_that_is_defined_twice_is_told_where_it_differs() {
    let obj = format!("mtllib a.mtl b.mtl\n{TRIANGLE}usemtl leaves\nf 1 2 3\n");
    let with = |second: &'static [u8]| {
        read(&[("a.obj", obj.as_bytes()), ("a.mtl", b"newmtl leaves\nKd 0.1 0.2 0.1\n"), ("b.mtl", second)])
            .unwrap()
    };
    let other = with(b"newmtl leaves\nKd 0.6 0.1 0.1\n");
    assert_eq!(other.materials[0].base_color, [0.6, 0.1, 0.1, 1.0]);
    assert!(other.warnings[0].contains("'leaves' is there several times"), "{:?}", other.warnings);
    let same = with(b"newmtl leaves\nKd 0.1 0.2 0.1\n");
    assert!(same.warnings.is_empty(), "{:?}", same.warnings);
}

#[test]
fn several_material_files_on_a_line_may_have_blanks_in_their_names() {
    for line in ["mtllib a b.mtl c.mtl d e f.mtl", "mtllib \"a b.mtl\" \"c.mtl\" \"d e f.mtl\""] {
        let obj = format!("{line}\n{TRIANGLE}usemtl bark\nf 1 2 3\nv 0 0 1\nusemtl leaves\nf 1 2 4\n");
        let mesh = read(&[
            ("a.obj", obj.as_bytes()),
            ("a b.mtl", b"newmtl bark\nKd 0.3 0.2 0.1\n"),
            ("c.mtl", b"newmtl other\n"),
            ("d e f.mtl", b"newmtl leaves\nKd 0.1 0.3 0.05\n"),
        ])
        .unwrap();
        assert!(mesh.warnings.is_empty(), "{:?}", mesh.warnings);
        assert_eq!([0, 1].map(|material| mesh.materials[material].base_color[0]), [0.3, 0.1]);
    }
}

#[test]
fn gloss_in_the_alpha_of_a_colour_takes_nothing_from_a_share() {
    let obj = format!("mtllib a.mtl\n{TRIANGLE}vt 0 0\nvt 1 0\nvt 0 1\nusemtl leaves\nf 1/1 2/2 3/3\n");
    let mtl = b"newmtl leaves\nd 0.5\nmap_Kd a.png\n";
    let mesh =
        read(&[("a.obj", obj.as_bytes()), ("a.mtl", mtl), ("a.png", &png(|x| 100 + 20 * x as u8))]).unwrap();
    let coverage = [crate::alpha::Coverage::of(&mesh, 0).unwrap()];
    let mut there = 0.0;
    crate::color::on_surface(&mesh, &coverage, |_, _, area| there += area);
    assert!((there / 0.5 - 0.5).abs() < 0.02, "{there}");
}

/// A trunk of bark, 2 m high, and so many leaves around it.
fn tree(leaves: usize) -> String {
    let mut text = String::from("usemtl Bark\n");
    let ring = [[0.1, 0.1], [-0.1, 0.1], [-0.1, -0.1], [0.1, -0.1]];
    for (at, [x, z]) in ring.into_iter().enumerate() {
        let [u, w] = ring[(at + 1) % 4];
        text += &format!("v {x} 0 {z}\nv {u} 0 {w}\nv {u} 2 {w}\nv {x} 2 {z}\nf -4 -3 -2 -1\n");
    }
    text += "usemtl Leaves\n";
    for at in 0..leaves {
        let turn = std::f64::consts::TAU * at as f64 / leaves as f64;
        let [x, z] = [libm::cos(turn), libm::sin(turn)].map(|side| 0.5 * side);
        let y = 1.5 + 0.4 * libm::sin(5.0 * turn);
        text += &format!("v {x} {y} {z}\nv {} {y} {z}\nv {x} {} {z}\nf -3 -2 -1\n", x + 0.1, y + 0.1);
    }
    text
}

#[test]
fn what_stands_beside_a_plant_is_not_leaf_or_wood_because_of_the_material_that_it_wears() {
    let beside = |group: &str, material: &str| {
        format!("o Oak\n{}o {group}\nusemtl {material}\nv 0 0 3\nv 1 0 3\nv 0 1 3\nf -3 -2 -1\n", tree(20))
    };
    let read = |text: &str, ignore: &[&str]| {
        let rules = ClassRules {
            ignore: ignore.iter().map(|&pattern| pattern.to_owned()).collect(),
            ..ClassRules::default()
        };
        let settings = ImportSettings { split: rules.split_patterns(), ..ImportSettings::default() };
        let folder = tempfile::tempdir().unwrap();
        fs::write(folder.path().join("a.obj"), text).unwrap();
        let mesh = import(&folder.path().join("a.obj"), &settings).unwrap();
        classify(&mesh, &rules).map(|classes| (mesh.materials.len(), classes))
    };
    let things = [
        ("UCX_trunk_01", "Bark", "ucx"),
        ("trunk_collider", "Bark", "collider"),
        ("tree-colonly", "Leaves", "colonly"),
        ("billboard", "Leaves", "billboard"),
        ("flower_pot", "Bark", "pot"),
        ("Ground", "Leaves", "ground"),
        ("Backdrop", "Bark", "backdrop"),
    ];
    for (group, material, word) in things {
        let text = beside(group, material);
        let error = read(&text, &[]).unwrap_err().to_string();
        let why = format!("'{word}' in the name of its part '{group}' is no word of a plant");
        assert!(error.contains(&why), "{error}");
        let pattern = format!("{material}@{group}");
        assert!(error.contains(&format!("known: '{pattern}'\n")), "{error}");
        let (materials, classes) = read(&text, &[&pattern]).unwrap();
        let count = |class| classes.iter().filter(|classified| classified.class == class).count();
        assert_eq!((materials, count(MaterialClass::Neither)), (3, 1), "{group}");
    }
    let hulls =
        format!("{}o UCX_b\nusemtl Bark\nv 0 0 4\nv 1 0 4\nv 0 1 4\nf -3 -2 -1\n", beside("UCX_a", "Bark"));
    let error = read(&hulls, &[]).unwrap_err().to_string();
    assert!(error.contains("--ignore 'Bark@UCX_*'"), "{error}");
    assert!(read(&hulls, &["Bark@UCX_*"]).is_ok());
    // A plant may be named after its pot, and what is read alone is what is meant.
    for whole in ["flower_pot", "Tree_Billboard"] {
        let text = format!("o {whole}\n{}", tree(20));
        assert_eq!(read(&text, &[]).unwrap().0, 2, "{whole}");
    }
    let potted =
        format!("o Stone\nusemtl Rocks\nv 0 0 3\nv 1 0 3\nv 0 1 3\nf -3 -2 -1\no flower_pot\n{}", tree(20));
    let error = read(&potted, &[]).unwrap_err().to_string();
    assert!(error.contains("known: 'Rocks'\n"), "{error}");
}

#[test]
fn levels_whose_trunks_coincide_are_a_doubt_all_the_same() {
    let doubts = |text: &str| {
        let classed = PlantReader::default().class(read_text(text).unwrap()).unwrap().0;
        let doubts = crate::extents::doubts(&classed, &ImportSettings::default());
        doubts.iter().map(|doubt| doubt.name()).collect::<Vec<_>>()
    };
    assert!(doubts(&format!("o Oak_L0\n{}o Oak_L1\n{}", tree(40), tree(21))).contains(&"levels"));
    assert!(!doubts(&format!("o Oak\n{}", tree(40))).contains(&"levels"));
    let mesh = read_text(&format!("o a\n{}o b\n{}o c\n{}", tree(40), tree(21), tree(40))).unwrap();
    let labels: Vec<String> = mesh.parts.iter().map(|part| part.label()).collect();
    assert_eq!(labels, ["a", "b"], "of the third nothing is left");
    assert_eq!(mesh.parts[1].bounds_m().unwrap().min[1], 0.0);
    assert_eq!(mesh.parts[1].uses.iter().map(|used| used.triangles).sum::<u64>(), 20, "one leaf is in both");
}
