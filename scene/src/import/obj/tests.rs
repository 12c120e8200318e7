//! Tiny OBJ files: what exporters write, and what none should.

mod said;
mod words;

use std::fs;

use crate::import::{Fault, ImportError, ImportSettings, import, limits};
use crate::mesh::{AlphaMode, Mesh, Wrap};

fn read(files: &[(&str, &[u8])]) -> Result<Mesh, ImportError> {
    let folder = tempfile::tempdir().unwrap();
    for (name, bytes) in files {
        let path = folder.path().join(name);
        fs::create_dir_all(path.parent().unwrap()).unwrap();
        fs::write(path, bytes).unwrap();
    }
    import(&folder.path().join(files[0].0), &ImportSettings::default())
}

fn read_text(obj: &str) -> Result<Mesh, ImportError> {
    read(&[("a.obj", obj.as_bytes())])
}

fn png(alpha: impl Fn(u32) -> u8) -> Vec<u8> {
    let image = image::RgbaImage::from_fn(4, 4, |x, _| image::Rgba([200, 200, 200, alpha(x)]));
    let mut bytes = std::io::Cursor::new(Vec::new());
    image.write_to(&mut bytes, image::ImageFormat::Png).unwrap();
    bytes.into_inner()
}

fn area_of(mesh: &Mesh) -> f64 {
    mesh.triangles
        .iter()
        .map(|t| crate::import::area(t.map(|v| mesh.positions[v as usize].map(f64::from))))
        .sum()
}

const TRIANGLE: &str = "v 0 0 0\nv 1 0 0\nv 0 1 0\n";

#[test]
fn odd_white_space_order_marks_comments_and_continued_lines_are_read() {
    let text = "\u{feff}# made by hand\r\nv\t0 0 0 1.0\r\nv 1 0 0 0.5 0.5 0.5\r\n  v 0 1 \\\r\n 0\r\nvt 0.25\r\n\r\nf 1/1 \\\r\n2/1 3/1 # done\r\n";
    let mesh = read_text(text).unwrap();
    assert_eq!(mesh.triangles.len(), 1);
    assert_eq!(mesh.uvs[0], [0.25, 1.0]);
    assert_eq!(mesh.normals[0], [0.0, 0.0, 1.0]);
}

#[test]
fn a_unit_that_a_comment_tells_is_told_unless_one_is_stated() {
    let text = format!("# Exporter 2.1\n# File units = centimeters\n{TRIANGLE}f 1 2 3\n");
    let warnings = read_text(&text).unwrap().warnings;
    assert!(
        warnings.iter().any(|warning| warning.contains("tells the unit cm") && warning.contains("--unit cm"))
    );
    let metres = text.replace("centimeters", "meters");
    assert!(!read_text(&metres).unwrap().warnings.iter().any(|warning| warning.contains("unit")));
}

#[test]
fn negative_indices_count_back_from_the_face() {
    let mesh = read_text(&format!("{TRIANGLE}f -3 -2 -1\nv 0 0 5\nf -1 -3 -2\n")).unwrap();
    assert_eq!(mesh.triangles.len(), 2);
    assert_eq!(mesh.bounds().unwrap().max[2], 5.0);
}

#[test]
fn polygons_are_cut_without_leaving_their_outline() {
    let mesh = read_text("v 0 0 0\nv 2 0 0\nv 0.4 0.4 0\nv 0 2 0\nf 1 2 3 4\nf 4 3 2 1\n").unwrap();
    assert!((area_of(&mesh) - 0.8).abs() < 1e-6, "the area of both sides counts once: {}", area_of(&mesh));
    assert!(mesh.warnings.iter().any(|warning| warning.contains("2 of 4 triangles that lie exactly on")));
}

#[test]
fn flat_triangles_go_and_a_file_of_nothing_else_is_refused() {
    let mesh = read_text(&format!("{TRIANGLE}v 2 0 0\nf 1 2 3\nf 1 2 4\nf 1 1 2\n")).unwrap();
    assert_eq!((mesh.triangles.len(), mesh.positions.len()), (1, 3));
    assert!(mesh.warnings[1].contains("2 of 3 triangles that have no area"), "{:?}", mesh.warnings);
    let error = read_text(&format!("{TRIANGLE}f 1 1 2\n")).unwrap_err();
    assert!(matches!(error, ImportError::NoTriangles { .. }), "{error}");
    assert!(read_text("").is_err());
}

#[test]
fn lines_and_points_are_left_out_with_a_word() {
    let mesh = read_text(&format!("{TRIANGLE}l 1 2\nl 2 3\np 1\nf 1 2 3\n")).unwrap();
    assert!(
        mesh.warnings
            .iter()
            .any(|warning| warning.contains("l (2 times) is not read: lines have no surface")),
        "{:?}",
        mesh.warnings
    );
    assert!(
        mesh.warnings.iter().any(|warning| warning.contains("p is not read: points have no surface")),
        "{:?}",
        mesh.warnings
    );
}

#[test]
fn bad_lines_are_named() {
    for (lines, words) in [
        ("f 1 2 4", "line 4, face corner '4': found v '4', expected 1..=3"),
        ("f 1 2 -4", "line 4, face corner '-4'"),
        ("f 1 2 0", "line 4, face corner '0'"),
        ("f 1 2 x", "line 4, face corner 'x'"),
        ("f 1/1 2/1 3/1", "vt '1'"),
        ("f 1//9 2//9 3//9", "vn '9'"),
        ("f 99999999999999999999 2 3", "line 4, face corner"),
        ("v 1 2", "line 4, v: found 2 numbers, expected at least 3"),
        ("v 1 2 three", "line 4, v: found 'three'"),
        ("v nan 0 0", "line 4, vertex 4"),
        ("v 0 inf 0", "line 4, vertex 4"),
        ("v 0 1e39 0", "line 4, vertex 4"),
    ] {
        let error = read_text(&format!("{TRIANGLE}{lines}\n")).unwrap_err().to_string();
        assert!(error.contains(words), "{lines}: {error}");
    }
}

#[test]
fn endless_lines_and_polygons_are_over_a_limit() {
    let line = format!("{TRIANGLE}# {}", "x".repeat(2 << 20));
    assert_eq!(read_text(&line).unwrap_err().fault(), Fault::Limit);
    let polygon = format!("{TRIANGLE}f {}\n", "1 2 3 ".repeat(30_000));
    assert_eq!(read_text(&polygon).unwrap_err().fault(), Fault::Limit);
}

#[test]
fn without_usemtl_groups_stand_for_materials() {
    let mesh = read_text(&format!("{TRIANGLE}v 0 0 1\ng leaves\nf 1 2 3\ng trunk\nf 1 2 4\n")).unwrap();
    let names: Vec<&str> = mesh.materials.iter().map(|material| material.name.as_str()).collect();
    assert_eq!(names, ["leaves", "trunk"]);
    assert_eq!(mesh.triangle_material, [0, 1]);
}

#[test]
fn a_missing_material_file_is_a_warning() {
    let mesh = read_text(&format!("mtllib gone.mtl\n{TRIANGLE}usemtl bark\nf 1 2 3\n")).unwrap();
    assert_eq!(mesh.materials[0].name, "bark");
    assert!(mesh.warnings[0].contains("'gone.mtl' is not there"), "{:?}", mesh.warnings);
    assert!(mesh.warnings[1].contains("'bark' is in no MTL file"), "{:?}", mesh.warnings);
}

#[test]
fn mtl_options_stand_before_a_file_name_with_spaces_in_another_case() {
    let mtl = b"newmtl my leaf\r\nKd 0.1 0.2\r\nmap_Kd -s 2 4 1 -o 0.5 0.25 -clamp on -bm 3 Textures\\Green Leaf.PNG\r\n";
    let obj = format!("mtllib a b.mtl\n{TRIANGLE}usemtl my leaf\nf 1 2 3\n");
    let image = png(|x| if x == 0 { 0 } else { 255 });
    let mesh =
        read(&[("a.obj", obj.as_bytes()), ("a b.mtl", mtl), ("textures/green leaf.png", &image)]).unwrap();
    let material = &mesh.materials[0];
    let texture = material.color_texture.unwrap();
    assert_eq!(texture.wrap, [Wrap::Clamp; 2]);
    // v' = 1 - ((1 - v) * 4 + 0.25)
    assert_eq!(texture.transform, [[2.0, 0.0, 0.5], [0.0, 4.0, -3.25]]);
    assert_eq!(material.base_color, [0.1, 0.2, 0.1, 1.0], "Kd multiplies its texture");
    assert_eq!(
        material.alpha_mode,
        AlphaMode::Cut { cutoff: 0.5 },
        "its image cuts although no map_d says so"
    );
    assert_eq!(mesh.sources.len(), 3);
}

#[test]
fn map_d_cuts_by_alpha_or_by_luminance() {
    let cut = png(|x| if x < 2 { 0 } else { 255 });
    let solid = png(|_| 255);
    let dark = {
        let image = image::GrayImage::from_fn(4, 4, |x, _| image::Luma([if x == 0 { 0 } else { 255 }]));
        let mut bytes = std::io::Cursor::new(Vec::new());
        image.write_to(&mut bytes, image::ImageFormat::Png).unwrap();
        bytes.into_inner()
    };
    let obj = format!("mtllib a.mtl\n{TRIANGLE}usemtl m\nf 1 2 3\n");
    let read_with = |mtl: &str| {
        let files: [(&str, &[u8]); 5] = [
            ("a.obj", obj.as_bytes()),
            ("a.mtl", mtl.as_bytes()),
            ("cut.png", &cut),
            ("solid.png", &solid),
            ("dark.png", &dark),
        ];
        read(&files).unwrap()
    };
    let mesh = read_with("newmtl m\nmap_Kd cut.png\nmap_d cut.png\n");
    assert_eq!(mesh.materials[0].alpha_mode, AlphaMode::Cut { cutoff: 0.5 });
    assert_eq!(mesh.materials[0].alpha_texture, None);
    let mesh = read_with("newmtl m\nmap_Kd solid.png\nmap_d dark.png\n");
    let alpha = &mesh.images[mesh.materials[0].alpha_texture.unwrap().image as usize];
    assert_eq!((alpha.rgba[3], alpha.rgba[7]), (0, 255));
    let mesh = read_with("newmtl m\nmap_Kd solid.png\nmap_d solid.png\n");
    assert_eq!(mesh.materials[0].alpha_mode, AlphaMode::Opaque);
    assert!(mesh.warnings[0].contains("has no alpha; taken as opaque"), "{:?}", mesh.warnings);
    let mesh = read_with("newmtl m\nd 0.3\nKd 0.5 0.25 0.125\nmap_d nowhere.png\n");
    assert_eq!(mesh.materials[0].base_color, [0.5, 0.25, 0.125, 0.3]);
    assert_eq!(mesh.materials[0].alpha_mode, AlphaMode::Blend);
    assert_eq!(mesh.warnings.len(), 1, "{:?}", mesh.warnings);
    let mesh = read_with("newmtl m\nd 0\n");
    assert_eq!(mesh.materials[0].alpha_mode, AlphaMode::Opaque);
    assert!(mesh.warnings[0].contains("which would leave nothing; taken as opaque"), "{:?}", mesh.warnings);
    let mesh = read_with("newmtl m\nKd 0 0 0\nmap_Kd solid.png\n");
    assert_eq!(mesh.materials[0].base_color, [1.0; 4], "a black Kd beside an image means 1");
}

/// A zlib stream of so many zeros (RFC 1951, section 3.2.6): one, and then copies of 258 before each.
fn packed_zeros(copies: usize) -> Vec<u8> {
    let mut bits = vec![true, true, false];
    let mut code = |value: u32, length: u32| bits.extend((0..length).rev().map(|bit| value >> bit & 1 == 1));
    code(0b0011_0000, 8);
    (0..copies).for_each(|_| code(0b1_1000_1010_0000, 13));
    code(0, 7);
    let byte = |bits: &[bool]| bits.iter().enumerate().map(|(i, bit)| u8::from(*bit) << i).sum::<u8>();
    let check = ((1 + 258 * copies as u32) % 65_521) << 16 | 1;
    [&[0x78, 1][..], &bits.chunks(8).map(byte).collect::<Vec<_>>(), &check.to_be_bytes()].concat()
}

/// Unpacked, each took a second and hundreds of megabytes: here, all that a decoder may take.
#[test]
fn colour_profiles_and_texts_of_a_png_are_not_unpacked() {
    let plain = png(|x| if x < 2 { 0 } else { 255 });
    let chunk = |kind: &[u8; 4], content: &[u8]| {
        let crc = kind.iter().chain(content).fold(!0, |crc, byte| next_crc(crc, *byte));
        [&(content.len() as u32).to_be_bytes()[..], kind, content, &(!crc).to_be_bytes()].concat()
    };
    // The text takes what the profile leaves of it.
    let text_bytes = 8 << 20;
    let profile = packed_zeros((limits::IMAGE_DECODER_BYTES as usize - text_bytes) / 258);
    let profile = chunk(b"iCCP", &[b"a\0\0", &profile[..]].concat());
    let text = chunk(b"tEXt", &[b"a\0", &vec![b'a'; text_bytes][..]].concat());
    let (head, rest) = plain.split_at(8 + 25);
    let heavy = [head, &profile, &text, rest].concat();
    let obj = format!("mtllib a.mtl\n{TRIANGLE}vt 0 0\nusemtl m\nf 1/1 2/1 3/1\n");
    let read = |image: &[u8]| {
        let mtl = b"newmtl m\nmap_Kd leaf.png\n";
        read(&[("a.obj", obj.as_bytes()), ("a.mtl", mtl), ("leaf.png", image)]).expect("it is sound")
    };
    let (with, without) = (read(&heavy), read(&plain));
    assert_eq!(with.warnings, without.warnings);
    assert_eq!(with.images[0].rgba, without.images[0].rgba);
}

/// The check sum of a chunk (PNG, annex D), a byte at a time.
fn next_crc(crc: u32, byte: u8) -> u32 {
    (0..8).fold(crc ^ u32::from(byte), |crc, _| if crc & 1 == 1 { 0xedb8_8320 ^ crc >> 1 } else { crc >> 1 })
}

#[test]
fn of_a_url_in_a_file_no_more_than_the_host_is_told() {
    let obj = |library: &str| format!("mtllib {library}\n{TRIANGLE}vt 0 0\nusemtl m\nf 1/1 2/1 3/1\n");
    for url in [
        "http://u:p/S3CR3T@h/x",
        r"http:\\h\x?sig=S3CR3T",
        "//u:S3CR3T@h/x",
        "http://h/x?a=\"S3CR3T",
        "ftp:/h/x#S3CR3T",
    ] {
        let mtl = format!("newmtl m\nmap_Kd {url}\nmap_d {url} S3CR3T\n");
        for (library, mtl) in [("a.mtl", mtl.as_str()), (url, "")] {
            let mesh =
                read(&[("a.obj", obj(library).as_bytes()), ("a.mtl", mtl.as_bytes())]).expect("warnings");
            let told = mesh.warnings.join("\n");
            assert!(told.contains("is not there") && !told.contains("S3CR3T"), "{url}: {told}");
        }
    }
}

#[test]
fn no_prefix_of_a_file_panics() {
    let text =
        format!("mtllib a.mtl\n{TRIANGLE}vt 0 1\nvn 0 0 1\nusemtl m\nf 1/1/1 2/1/1 3/1/1\nf -1 -2 -3\n");
    for length in 0..text.len() {
        let _ = read_text(&text[..length]);
    }
    let mtl = "newmtl m\nKd 1 0\nKd spectral x.rfl\nmap_Kd -s\nmap_Kd -imfchan\nmap_d -o 1 2 3\nd\nTr x\nd -halo 0.5\n";
    for length in 0..mtl.len() {
        let _ = read(&[("a.obj", text.as_bytes()), ("a.mtl", &mtl.as_bytes()[..length])]);
    }
}

#[test]
fn endless_names_are_over_a_limit() {
    let long = "x".repeat(100_000);
    for line in [format!("usemtl {long}"), format!("g {long}"), format!("o {long}"), format!("mtllib {long}")]
    {
        let error = read_text(&format!("{TRIANGLE}{line}\nf 1 2 3\n")).unwrap_err();
        assert!(error.to_string().contains("name: 100000 is over the limit"), "{error}");
    }
    let mtl = format!("newmtl {long}\n");
    let obj = format!("mtllib a.mtl\n{TRIANGLE}usemtl m\nf 1 2 3\n");
    let error = read(&[("a.obj", obj.as_bytes()), ("a.mtl", mtl.as_bytes())]).unwrap_err();
    assert!(error.to_string().contains("newmtl: bytes of a name"), "{error}");
    let mtl = format!("newmtl m\nmap_Kd {long}\n");
    let error = read(&[("a.obj", obj.as_bytes()), ("a.mtl", mtl.as_bytes())]).unwrap_err();
    assert!(error.to_string().contains("bytes of a file's name"), "{error}");
}

#[test]
fn one_material_file_named_many_times_is_read_once() {
    // 15 MB, which would be read 200 times.
    let mtl = format!("newmtl m\nKd 0.5 0.5 0.5\n{}", "# nothing\n".repeat(1_500_000));
    let obj = format!("{}{TRIANGLE}usemtl m\nf 1 2 3\n", "mtllib a.mtl a.mtl\n".repeat(200));
    let mesh = read(&[("a.obj", obj.as_bytes()), ("a.mtl", mtl.as_bytes())]).unwrap();
    assert_eq!(mesh.materials[0].base_color, [0.5, 0.5, 0.5, 1.0]);
    assert_eq!(mesh.sources.len(), 2);
    // Two of that size are more than all together may have.
    let obj = format!("mtllib a.mtl\nmtllib b.mtl\n{TRIANGLE}usemtl m\nf 1 2 3\n");
    let files: [(&str, &[u8]); 3] =
        [("a.obj", obj.as_bytes()), ("a.mtl", mtl.as_bytes()), ("b.mtl", mtl.as_bytes())];
    assert_eq!(read(&files).unwrap_err().fault(), Fault::Limit);
    let error = read_text(&format!("{}{TRIANGLE}f 1 2 3\n", "mtllib a.mtl\n".repeat(300))).unwrap_err();
    assert!(error.to_string().contains("mtllib lines: 257 is over the limit"), "{error}");
}

#[test]
fn as_many_materials_as_allowed_are_looked_up_at_once() {
    let count = 60_000;
    let mtl: String = (0..count).map(|i| format!("newmtl material number {i}\nKd {} 0 0\n", i % 2)).collect();
    let faces: String =
        (0..count).map(|i| format!("usemtl material number {}\nf 1 2 {}\n", count - 1 - i, i + 3)).collect();
    let points: String = (0..count).map(|i| format!("v 0 1 {i}\n")).collect();
    let obj = format!("mtllib a.mtl\nv 0 0 0\nv 1 0 0\n{points}{faces}");
    let mesh = read(&[("a.obj", obj.as_bytes()), ("a.mtl", mtl.as_bytes())]).unwrap();
    assert_eq!(mesh.materials.len(), count);
    assert_eq!(mesh.materials[0].base_color, [1.0, 0.0, 0.0, 1.0]);
}

#[test]
fn polygons_that_take_long_to_cut_are_over_a_limit() {
    // Spikes that cross each other: ear clipping at its worst.
    let corners = 4096;
    let star: String = (0..corners)
        .map(|i| {
            let angle = f64::from(i) * 2.399963;
            let radius = if i % 2 == 0 { 1.0 } else { 0.01 };
            format!("v {} {} 0\n", radius * libm::cos(angle), radius * libm::sin(angle))
        })
        .collect();
    let face: String = (1..=corners).map(|i| format!(" {i}")).collect();
    let faces = format!("f{face}\n").repeat(20);
    let error = read_text(&format!("{star}{faces}")).unwrap_err();
    assert!(error.to_string().contains("line 4105: corners of concave faces, squared"), "{error}");
}

#[test]
fn names_of_textures_stay_inside_the_folder() {
    let outside = tempfile::tempdir().unwrap();
    let folder = outside.path().join("plant");
    fs::create_dir(&folder).unwrap();
    fs::write(outside.path().join("leaf.png"), png(|_| 255)).unwrap();
    fs::write(outside.path().join("other.mtl"), "newmtl m\nKd 0 0 0\n").unwrap();
    let read = |library: &str, map: &str| {
        fs::write(folder.join("a.obj"), format!("mtllib {library}\n{TRIANGLE}usemtl m\nf 1 2 3\n")).unwrap();
        fs::write(folder.join("a.mtl"), format!("newmtl m\nmap_Kd {map}\n")).unwrap();
        import(&folder.join("a.obj"), &ImportSettings::default())
    };
    for (library, map, words) in [
        ("../other.mtl", "x.png", "mtllib names '../other.mtl', which lies outside"),
        ("a.mtl", "../leaf.png", "the material 'm' names '../leaf.png', which lies outside"),
        ("a.mtl", "-s 1 1 1 ..\\leaf.png", "the material 'm' names '..\\leaf.png', which lies outside"),
    ] {
        let error = read(library, map).unwrap_err();
        assert!(error.to_string().contains(words), "{library}, {map}: {error}");
    }
    assert!(read("a.mtl", "../none.png").unwrap().warnings[0].contains("which is not there"));
}

#[test]
fn numbers_of_every_kind_end_well() {
    for number in
        ["1e400", "-1e400", "nan", "inf", "-inf", "1e39", "1e-400", "0x1", "1_0", "", "+", "1e", "٣"]
    {
        for line in [
            format!("v {number} 0 0"),
            format!("vt {number} 0\nf 1/1 2/1 3/1"),
            format!("vn {number} 0 0\nf 1//1 2//1 3//1"),
            format!("f {number} 2 3"),
            format!("f 1 2 -{number}"),
        ] {
            match read_text(&format!("{TRIANGLE}{line}\nf 1 2 3\n")) {
                Ok(mesh) => {
                    let finite = |v: &[f32]| v.iter().all(|x| x.is_finite());
                    assert!(mesh.positions.iter().all(|p| finite(p)), "{line}");
                    assert!(mesh.normals.iter().all(|n| finite(n)), "{line}");
                    assert!(mesh.uvs.iter().all(|uv| finite(uv)), "{line}");
                }
                Err(error) => assert_eq!(error.fault(), Fault::Input, "{line}: {error}"),
            }
        }
    }
}
