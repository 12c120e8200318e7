//! Words and bytes of an OBJ and its MTL: what they are written in, what ends a line, how names are found.

use std::ffi::OsStr;
use std::fs;
use std::os::unix::ffi::OsStrExt;

use super::{TRIANGLE, png, read, read_text};
use crate::import::{Fault, ImportSettings, import};
use crate::mesh::Mesh;

const RED: &str = "Kd 0.5 0 0\n";
const GREEN: &str = "Kd 0 0.5 0\n";

fn latin(text: &str) -> Vec<u8> {
    text.chars().map(|letter| u8::try_from(letter).expect("Latin-1")).collect()
}

/// Reads an OBJ `a.obj` of these bytes beside files whose names are bytes.
fn read_raw(obj: &[u8], others: &[(&[u8], &[u8])]) -> Mesh {
    let folder = tempfile::tempdir().expect("a folder");
    for (name, bytes) in others.iter().chain([&(&b"a.obj"[..], obj)]) {
        let path = folder.path().join(OsStr::from_bytes(name));
        fs::create_dir_all(path.parent().expect("the folder")).expect("a folder");
        fs::write(path, bytes).expect("a file");
    }
    import(&folder.path().join("a.obj"), &ImportSettings::default()).expect("it is sound")
}

fn colors(mesh: &Mesh) -> Vec<[f32; 3]> {
    mesh.materials.iter().map(|material| *material.base_color.first_chunk().expect("four")).collect()
}

fn two(library: &str) -> String {
    format!("mtllib {library}\n{TRIANGLE}v 0 0 1\nusemtl Lärche\nf 1 2 3\nusemtl Lörche\nf 1 2 4\n")
}

#[test]
fn names_that_differ_in_one_letter_of_latin_1_stay_two() {
    let mtl = format!("newmtl Lärche\n{RED}newmtl Lörche\n{GREEN}");
    let mesh = read_raw(&latin(&two("Bäume.mtl")), &[("Bäume.mtl".as_bytes(), &latin(&mtl))]);
    assert_eq!(colors(&mesh), [[0.5, 0.0, 0.0], [0.0, 0.5, 0.0]], "{:?}", mesh.warnings);
    assert_eq!(mesh.materials[1].name, "Lörche");
    // Whichever of the two files is which, and the name on disc in Latin-1 or not.
    for (obj, mtl, name) in [
        (latin(&two("Bäume.mtl")), mtl.clone().into_bytes(), latin("Bäume.mtl")),
        (two("Bäume.mtl").into_bytes(), latin(&mtl), latin("Bäume.mtl")),
        (two("B%E4ume.mtl").into_bytes(), mtl.clone().into_bytes(), "Bäume.mtl".into()),
    ] {
        let mesh = read_raw(&obj, &[(&name, &mtl)]);
        assert_eq!(colors(&mesh), [[0.5, 0.0, 0.0], [0.0, 0.5, 0.0]], "{:?}", mesh.warnings);
    }
}

#[test]
fn a_stray_byte_does_not_part_the_names_of_two_files() {
    // In a comment it has no say; elsewhere the names are read in another way than in the OBJ, and found nevertheless.
    for stray in [&b"# M\xfcller\n"[..], b"newmtl M\xfcller\n"] {
        let mtl =
            [stray, format!("newmtl Lärche\n{RED}newmtl Lörche\nmap_Kd Blätter.png\n").as_bytes()].concat();
        let image = png(|_| 255);
        let mesh = read_raw(two("a.mtl").as_bytes(), &[(b"a.mtl", &mtl), ("Blätter.png".as_bytes(), &image)]);
        assert_eq!(colors(&mesh)[0], [0.5, 0.0, 0.0], "{:?}", mesh.warnings);
        assert!(mesh.materials[1].color_texture.is_some(), "{:?}", mesh.warnings);
        assert_eq!(mesh.materials[0].name, "Lärche");
    }
}

#[test]
fn textures_whose_names_are_no_utf8_stay_two() {
    let obj = format!("mtllib a.mtl\n{TRIANGLE}v 0 0 1\nusemtl a\nf 1 2 3\nusemtl b\nf 1 2 4\n");
    let mtl = b"newmtl a\nmap_Kd L\xe4rche.png\nnewmtl b\nmap_Kd L\xf6rche.png\n";
    let (whole, cut) = (png(|_| 255), png(|x| if x < 2 { 0 } else { 255 }));
    let mesh =
        read_raw(obj.as_bytes(), &[(b"a.mtl", mtl), (b"L\xe4rche.png", &whole), (b"L\xf6rche.png", &cut)]);
    assert_eq!(mesh.images.iter().map(|image| image.has_cut).collect::<Vec<_>>(), [false, true]);
    let names: Vec<&str> = mesh.sources.iter().map(|source| source.name.as_str()).collect();
    assert_eq!(names, ["a.obj", "a.mtl", "Lärche.png", "Lörche.png"]);
}

#[test]
fn names_are_found_in_another_composition_and_in_another_case() {
    let image = png(|_| 255);
    for (written, on_disc) in [
        ("Bl\u{e4}tter.png", "Bla\u{308}tter.png"),
        ("Bla\u{308}tter.png", "Bl\u{e4}tter.png"),
        ("BLA\u{308}TTER.PNG", "bl\u{e4}tter.png"),
        ("Bl%C3%A4tter.png", "Bla\u{308}tter.png"),
        ("H\u{f6}he\\Bl\u{e4}tter.png", "HO\u{308}HE/Bla\u{308}tter.png"),
        ("C:\\B\u{e4}ume\\Bl\u{e4}tter.png", "textures/Bla\u{308}tter.PNG"),
    ] {
        let obj = format!("mtllib a.mtl\n{TRIANGLE}usemtl Ahornbl\u{e4}tter\nf 1 2 3\n");
        let mtl = format!("newmtl Ahornbla\u{308}tter\nmap_Kd {written}\n");
        let files = [(&b"a.mtl"[..], mtl.as_bytes()), (on_disc.as_bytes(), &image[..])];
        let mesh = read_raw(obj.as_bytes(), &files);
        assert!(mesh.materials[0].color_texture.is_some(), "{written}: {:?}", mesh.warnings);
    }
}

#[test]
fn of_several_spellings_the_nearest_is_taken() {
    let (whole, cut) = (png(|_| 255), png(|x| if x < 2 { 0 } else { 255 }));
    let obj = format!("mtllib a.mtl\n{TRIANGLE}usemtl a\nf 1 2 3\n");
    let written = "newmtl a\nmap_Kd Bl\u{e4}tter.png\n";
    // The first of each pair comes first in byte order, or is in a folder that has no such file.
    for (other, nearest) in [
        ("BL\u{c4}TTER.png", "Bla\u{308}tter.png"),
        ("Bla\u{308}tter.png", "Bl\u{e4}tter.png"),
        ("bl\u{e4}tter.png", "Bl\u{e4}tter.png"),
    ] {
        let files =
            [(&b"a.mtl"[..], written.as_bytes()), (other.as_bytes(), &cut), (nearest.as_bytes(), &whole)];
        let mesh = read_raw(obj.as_bytes(), &files);
        assert!(!mesh.images[0].has_cut, "{nearest}, not {other}");
    }
    let written = "newmtl a\nmap_Kd tex/leaf.png\n";
    let files = [(&b"a.mtl"[..], written.as_bytes()), (b"TEX/other.png", &cut), (b"Tex/Leaf.png", &whole)];
    assert_eq!(read_raw(obj.as_bytes(), &files).images.len(), 1);
}

#[test]
fn a_material_in_another_case_is_taken_with_a_word() {
    let obj = format!("mtllib a.mtl\n{TRIANGLE}usemtl Leaves\nf 1 2 3\n");
    let mesh = read(&[("a.obj", obj.as_bytes()), ("a.mtl", format!("newmtl leaves\n{RED}").as_bytes())]);
    let mesh = mesh.expect("it is sound");
    assert_eq!(colors(&mesh), [[0.5, 0.0, 0.0]]);
    assert!(mesh.warnings[0].contains("'Leaves' is 'leaves' in the MTL file"), "{:?}", mesh.warnings);
    let both = format!("newmtl leaves\n{RED}newmtl Leaves\n{GREEN}");
    let mesh = read(&[("a.obj", obj.as_bytes()), ("a.mtl", both.as_bytes())]).expect("it is sound");
    assert_eq!((colors(&mesh), mesh.warnings.len()), (vec![[0.0, 0.5, 0.0]], 0));
}

#[test]
fn lines_end_with_cr_with_lf_with_both_and_with_any_in_turn() {
    let lines = ["mtllib a.mtl", "v 0 0 0", "", "v 1 0 \\", "0", "v 0 1 0", "usemtl m", "f 1 2 3", "f 1 2 4"];
    let mtl = ["newmtl m", "Kd 0.5 0 0", ""];
    for ends in [&["\n"][..], &["\r\n"], &["\r"], &["\r\r\n"], &["\r", "\n", "\r\n"], &["\r", "\r\n"]] {
        let join = |lines: &[&str]| {
            let ends = ends.iter().cycle();
            lines.iter().zip(ends).map(|(line, end)| format!("{line}{end}")).collect::<String>()
        };
        let (obj, mtl) = (join(&lines), join(&mtl));
        let files = |obj: &str| read(&[("a.obj", obj.as_bytes()), ("a.mtl", mtl.as_bytes())]);
        let error = files(&obj).unwrap_err().to_string();
        assert!(error.contains("line 9, face corner '4'"), "{ends:?}: {error}");
        let mesh = files(&obj.replace("f 1 2 4", "")).expect("it is sound");
        assert_eq!((mesh.triangles.len(), colors(&mesh)), (1, vec![[0.5, 0.0, 0.0]]), "{ends:?}");
    }
    // An empty line ends what a backslash joins, also where CR ends lines.
    for end in ["\n", "\r"] {
        let error = read_text(&["v 0 0 \\", "", "0"].join(end)).unwrap_err().to_string();
        assert!(error.contains("line 1, v: found 2 numbers"), "{end:?}: {error}");
    }
}

#[test]
fn many_lines_of_cr_are_no_line_that_is_too_long() {
    let obj = format!("{TRIANGLE}{}f 1 2 3\n", "# a line of a file of an old program\n".repeat(100_000));
    assert_eq!(read_text(&obj.replace('\n', "\r")).expect("it is sound").triangles.len(), 1);
}

#[test]
fn utf_16_with_a_mark_is_read_and_without_one_it_is_refused() {
    let obj = two("Bäume.mtl").replace("Lörche", "葉🌳");
    let mtl = format!("newmtl Lärche\n{RED}newmtl 葉🌳\n{GREEN}");
    let wide = |text: &str, big: bool| -> Vec<u8> {
        let units = text.encode_utf16();
        units.flat_map(|unit| if big { unit.to_be_bytes() } else { unit.to_le_bytes() }).collect()
    };
    let expected = read_raw(obj.as_bytes(), &[("Bäume.mtl".as_bytes(), mtl.as_bytes())]);
    for big in [false, true] {
        let of = |text: &str| wide(&format!("\u{feff}{text}"), big);
        // Letters of two halves lie on both sides of a piece that is read at a time.
        for blanks in [0, 4080, 4081, 4082, 4083] {
            let padded = format!("# {}🌳\n{obj}", " ".repeat(blanks / 2));
            let mesh = read_raw(&of(&padded), &[("Bäume.mtl".as_bytes(), &of(&mtl))]);
            assert_eq!((colors(&mesh), &mesh.triangles), (colors(&expected), &expected.triangles));
        }
        let error = read(&[("a.obj", &wide(&obj, big))]).unwrap_err();
        assert_eq!(error.fault(), Fault::Input);
        assert!(
            error.to_string().contains("a.obj: line 1 holds a byte 0, expected text in UTF-8"),
            "{error}"
        );
        let whole = of(&obj);
        for bad in [&whole[..whole.len() - 1], &[&whole[..], &wide("x", big), &[0xD8, 0xD8]].concat()] {
            let error = read(&[("a.obj", bad)]).unwrap_err();
            assert_eq!(error.fault(), Fault::Input);
            assert!(
                error.to_string().contains("it is not UTF-16, which its byte order mark says"),
                "{error}"
            );
        }
    }
    let error = read(&[("a.obj", b"\xff\xfe\0\0v\0\0\0")]).unwrap_err().to_string();
    assert!(error.contains("a.obj: is UTF-32 text"), "{error}");
}

#[test]
fn normals_and_texture_coordinates_that_are_no_numbers_are_missing_ones() {
    let plain = read_text(&format!("{TRIANGLE}f 1 2 3\n")).expect("it is sound");
    for word in ["-1.#IND", "1.#QNAN", "nan(ind)", "-nan(ind)", "-nan", "inf", "-1.#INF00", "1,5"] {
        let mesh =
            read_text(&format!("{TRIANGLE}vn {word} 0 {word}\nf 1//1 2//1 3//1\n")).expect("it is sound");
        assert_eq!((&mesh.normals, &mesh.positions), (&plain.normals, &plain.positions), "{word}");
        assert!(
            mesh.warnings.iter().any(|warning| warning.contains("normals that are not numbers")),
            "{word}"
        );
        let mesh = read_text(&format!("{TRIANGLE}vt 0.5 {word}\nf 1/1 2/1 3/1\n")).expect("it is sound");
        assert_eq!(mesh.uvs, [[0.0; 2]; 3], "{word}");
        assert!(
            mesh.warnings.iter().any(|warning| warning.contains("texture coordinates that are not")),
            "{word}"
        );
        let error = read_text(&format!("v {word} 0 0\n{TRIANGLE}f 1 2 3\n")).unwrap_err();
        assert_eq!(error.fault(), Fault::Input, "{word}");
    }
    let error = read_text(&format!("{TRIANGLE}vn 1\nf 1 2 3\n")).unwrap_err().to_string();
    assert!(error.contains("line 4, vn: found 1 numbers, expected at least 3"), "{error}");
}

#[test]
fn textures_lie_beside_the_mtl_or_beside_the_obj() {
    let (whole, cut) = (png(|_| 255), png(|x| if x < 2 { 0 } else { 255 }));
    let obj = format!("mtllib mats/tree.mtl\n{TRIANGLE}vt 0 0\nusemtl m\nf 1/1 2/1 3/1\n");
    let read = |map: &str, images: &[(&str, &[u8])]| {
        let mtl = format!("newmtl m\nmap_Kd {map}\n");
        let mut files = vec![("a.obj", obj.as_bytes()), ("mats/tree.mtl", mtl.as_bytes())];
        files.extend(images);
        super::read(&files).expect("it is sound")
    };
    for (map, at) in [
        ("leaf.png", "mats/leaf.png"),
        ("leaf.png", "mats/textures/leaf.png"),
        ("leaf.png", "leaf.png"),
        ("leaf.png", "textures/leaf.png"),
        ("mats/leaf.png", "mats/leaf.png"),
        ("../tex/leaf.png", "tex/leaf.png"),
        ("C:\\work\\leaf.png", "mats/LEAF.png"),
    ] {
        let mesh = read(map, &[(at, &whole)]);
        assert_eq!((mesh.images.len(), mesh.warnings.len()), (1, 0), "{map} at {at}: {:?}", mesh.warnings);
    }
    // The MTL names its neighbour; a name as written is before a guess.
    assert!(!read("leaf.png", &[("leaf.png", &cut), ("mats/leaf.png", &whole)]).images[0].has_cut);
    assert!(!read("leaf.png", &[("mats/textures/leaf.png", &cut), ("leaf.png", &whole)]).images[0].has_cut);
}

#[test]
fn nothing_beside_the_mtl_lies_outside_the_mesh() {
    let outside = tempfile::tempdir().expect("a folder");
    let folder = outside.path().join("plant");
    fs::create_dir_all(folder.join("mats")).expect("a folder");
    fs::write(outside.path().join("leaf.png"), png(|_| 255)).expect("a file");
    fs::write(folder.join("a.obj"), format!("mtllib mats/a.mtl\n{TRIANGLE}usemtl m\nf 1 2 3\n"))
        .expect("a file");
    fs::write(folder.join("mats/a.mtl"), "newmtl m\nmap_Kd ../../leaf.png\n").expect("a file");
    let error = import(&folder.join("a.obj"), &ImportSettings::default()).unwrap_err().to_string();
    assert!(error.contains("names '../../leaf.png', which lies outside the mesh's folder"), "{error}");
}

#[test]
fn a_second_material_file_is_found_beside_the_first() {
    let obj = format!("mtllib mats/a.mtl b.mtl\n{TRIANGLE}usemtl m\nf 1 2 3\n");
    let mtl = format!("newmtl m\n{RED}");
    let mesh = read(&[("a.obj", obj.as_bytes()), ("mats/a.mtl", b""), ("mats/b.mtl", mtl.as_bytes())]);
    assert_eq!(colors(&mesh.expect("it is sound")), [[0.5, 0.0, 0.0]]);
}

#[test]
fn the_second_byte_of_a_character_of_shift_jis_joins_no_line() {
    // A name of one character, 0x95 0x5C, whose second byte is a backslash; then a face.
    let mut obj = b"v 0 0 0\nv 1 0 0\nv 0 1 0\nusemtl ".to_vec();
    obj.extend([0x95, b'\\', b'\n']);
    obj.extend(b"f 1 2 3\nf 3 \\\n2 1\n");
    let mesh = read(&[("a.obj", &obj)]).unwrap();
    assert_eq!(mesh.materials.len(), 1, "{:?}", mesh.materials);
    assert!(mesh.materials[0].name.chars().count() == 2, "{:?}", mesh.materials[0].name);
    assert!(mesh.warnings.iter().any(|warning| warning.contains("1 of 2 triangles that lie exactly")));
}
