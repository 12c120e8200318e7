//! What the fuzz targets call, each with the bytes of one input: here, so that `cargo test` replays the inputs that
//! once found something (`tests/tests/it/regressions.rs`). A target panics on what must never be; whatever else the
//! bytes lead to, an error most of all, is fine.

use std::cell::RefCell;
use std::path::Path;

use flb_baker::VoxelSettings;
use flb_baker::voxelise::voxelise;
use flb_format::container::verify;
use flb_format::{Codec, Container, FormatError, Source};
use flb_inspector::Level;
use flb_inspector::validate::check;
use flb_packer::{EncodedSpecies, PackError, copy_species, write_library_to};
use flb_scene::classify::{SpeciesRules, found};
use flb_scene::import::import;
use flb_scene::import::{Stand, WHOLE, cut_share, read_stand};
use flb_scene::scene::Scene;
use flb_scene::{ClassRules, ImportError, ImportSettings, MaterialClass, Mesh, SpeciesFile};

/// A function that is fed with bytes.
pub type Target = fn(&[u8]);

/// All targets, by the name that the fuzz target and the folder of its regressions have.
pub const TARGETS: [(&str, Target); 10] = [
    ("open", open),
    ("page", page),
    ("validate", validate),
    ("rewrite", rewrite),
    ("gltf", gltf),
    ("obj", obj),
    ("species_file", species_file),
    ("remote", remote),
    ("scene", scene),
    ("texture", texture),
];

/// Values of a base (texels times bands) over which a container is not decoded here: a small file may hold a very large
/// field by right, and decoding it would tell nothing but that.
const MAX_VALUES: u64 = 1 << 22;

/// Opening, and everything that is answered from header, tables and metadata.
pub fn open(bytes: &[u8]) {
    let Ok(container) = Container::open(&bytes.to_vec()) else { return };
    let info = flb_inspector::info(&container);
    assert_eq!(info.species.len(), container.species().len());
    for (i, species) in container.species().iter().enumerate() {
        assert_eq!(container.find_species(&species.meta.name), Some(i));
        for base in &species.bases {
            assert_eq!(container.find_base(i, base.base).map(|found| found.section), Some(base.section));
        }
    }
    for (i, section) in container.sections().iter().enumerate() {
        let last = container.pages(i).len() as u32 - 1;
        assert_eq!(container.page_of_unit(i, 0), Some(0));
        assert_eq!(container.page_of_unit(i, section.units - 1), Some(last));
        assert_eq!(container.page_of_unit(i, section.units), None);
    }
}

/// Every page by itself: read, and as blocks where there are some.
pub fn page(bytes: &[u8]) {
    let source = bytes.to_vec();
    let Ok(container) = Container::open(&source) else { return };
    for section in 0..container.sections().len() {
        for (page, entry) in (0..).zip(container.pages(section)) {
            if let Ok(payload) = container.read_page(&source, section, page) {
                assert_eq!(payload.len(), entry.raw_bytes as usize);
            }
        }
    }
    for species in container.species() {
        for base in species.bases.iter().filter(|base| base.codec == Codec::HaarPaper) {
            for page in 0..container.pages(base.section).len() as u32 {
                let _ = container.read_block_page(&source, base.section, page);
            }
        }
    }
}

/// The whole file at every level; a level holds what the ones before it hold.
pub fn validate(bytes: &[u8]) {
    let source = bytes.to_vec();
    let deepest = match Container::open(&source) {
        Ok(container) if is_large(&container) => Level::Pages,
        _ => Level::Decode,
    };
    let mut valid = true;
    for (level, name) in Level::ALL.into_iter().filter(|(level, _)| *level <= deepest) {
        let report = flb_inspector::validate(&source, level);
        assert!(valid || !report.valid, "valid at level {name}, but not at the one before");
        assert_eq!(report.valid, report.issues.is_empty());
        for issue in &report.issues {
            assert!(issue.message.starts_with(&issue.code), "{}", issue.message);
            assert!(issue.message.len() < 10_000, "a message of {} bytes", issue.message.len());
        }
        valid = report.valid;
    }
}

/// A file whose pages are sound is copied, written and opened again: nothing is lost, and the copy is what it copies
/// to.
pub fn rewrite(bytes: &[u8]) {
    let source = bytes.to_vec();
    if check(&source, Level::Pages).is_err() {
        return;
    }
    let first = match rewritten(&source) {
        Ok(first) => first,
        // The draft has no priorities, so that its pages are decoded for them.
        Err(error) => {
            assert!(opened(&source).header().is_draft(), "pages are sound: {error}");
            check(&source, Level::Decode).expect_err("what cannot be copied is unsound");
            return;
        }
    };
    check(&first, Level::Pages).expect("what was written keeps the promises");
    assert_eq!(rewritten(&first).expect("pages are sound"), first, "a copy of a copy");
    let (before, after) = (opened(&source), opened(&first));
    let metas = |container: &Container| -> Vec<_> {
        container.species().iter().map(|species| species.meta.clone()).collect()
    };
    assert_eq!(metas(&before), metas(&after));
    for (i, section) in after.sections().iter().enumerate() {
        let same = |other: &flb_format::container::records::SectionEntry| other.key == section.key;
        let old = before.sections().iter().position(same).expect("no section is made up");
        for page in 0..after.pages(i).len() as u32 {
            let stored = |container: &Container, source: &Vec<u8>, section| {
                container.read_stored(source, section, page).expect("pages are sound")
            };
            assert_eq!(
                stored(&before, &source, old),
                stored(&after, &first, i),
                "page {page} of {}",
                section.key
            );
        }
    }
    if !is_large(&before) {
        let code = |outcome: Result<(), FormatError>| outcome.err().map(|error| error.code());
        let contents = [verify::check_content(&before, &source), verify::check_content(&after, &first)];
        let [old, new] = contents.map(code);
        assert_eq!(old, new, "the content is as good as it was");
    }
}

/// A server that answers as the bytes say: no other host sees the secret of the first, no message holds it, and what is
/// asked, kept and said is bounded. A public host leads to no private one.
pub fn remote(bytes: &[u8]) {
    let replayed = flb_runtime::source::replay::replay(bytes);
    let secret = flb_runtime::source::replay::SECRET;
    // Four reads, each of a request and ten redirects at most.
    assert!(replayed.requests.len() <= 44, "{} requests", replayed.requests.len());
    assert!(replayed.bytes <= 65_536 + 3 * 5000, "{} bytes", replayed.bytes);
    for message in &replayed.messages {
        assert!(!message.contains(secret), "{message}");
        assert!(message.len() < 5000 && !message.contains(char::is_control), "{message:?}");
    }
    // The first host has the secret by right: where its own answers spell it, it has told others by itself.
    let is_told = bytes.to_ascii_lowercase().windows(secret.len()).any(|part| part == secret.as_bytes());
    let mut public = false;
    for (host, is_private, words) in &replayed.requests {
        let lower = words.to_lowercase();
        assert!(!lower.contains("\nreferer:"), "{words}");
        let may_hold = is_told || *host == replayed.host || host.to_lowercase().contains(secret);
        assert!(may_hold || !lower.contains(secret), "{host}: {words}");
        assert!(!(public && *is_private), "a public host has led to {host}");
        public |= !is_private;
    }
}

fn opened(source: &dyn Source) -> Container {
    Container::open(source).expect("it was checked")
}

fn rewritten(source: &dyn Source) -> Result<Vec<u8>, PackError> {
    let container = opened(source);
    let copies: Vec<EncodedSpecies> = (0..container.species().len())
        .map(|i| copy_species(&container, source, i))
        .collect::<Result<_, _>>()?;
    let mut out = Vec::new();
    write_library_to(&mut out, &copies.iter().collect::<Vec<_>>()).expect("what was read can be written");
    Ok(out)
}

fn is_large(container: &Container) -> bool {
    let values = |section: &flb_format::container::records::SectionEntry| {
        u64::from(section.lattice).saturating_pow(3).saturating_mul(section.bands.into())
    };
    container.sections().iter().any(|section| values(section) > MAX_VALUES)
}

/// A glTF or GLB, alone in its folder but for a buffer and an image that it may name: as a plant, its first mesh alone,
/// and as a forest.
pub fn gltf(bytes: &[u8]) {
    let name = if bytes.starts_with(b"glTF") { "a.glb" } else { "a.gltf" };
    let files = [(name, bytes), ("a.bin", &[0x3F; 96]), ("a.png", PNG)];
    let only = |mesh: &str| ImportSettings { gltf_mesh: Some(mesh.to_owned()), ..ImportSettings::default() };
    for settings in [only(WHOLE), only("#0")] {
        look_at(in_folder(&files, |path| import(path, &settings)));
    }
    match in_folder(&files, |path| read_stand(path, &[], &[])) {
        Ok(stand) => check_stand(&stand),
        Err(error) => check_message(&error),
    }
}

/// An OBJ; behind a zero byte its MTL, `a.mtl`, and behind another its image, `a.png`.
pub fn obj(bytes: &[u8]) {
    let mut parts = bytes.splitn(3, |byte| *byte == 0);
    let mut part = || parts.next().unwrap_or_default();
    let (mesh, library, image) = (part(), part(), part());
    let files = [("a.obj", mesh), ("a.mtl", library), ("a.png", if image.is_empty() { PNG } else { image })];
    look_at(in_folder(&files, |path| import(path, &ImportSettings::default())));
}

/// Two texels, one of them clear.
const PNG: &[u8] = include_bytes!("two-texels.png");

thread_local! {
    /// A folder that is used again and again: making one takes longer than reading a small mesh.
    static FOLDER: RefCell<Option<tempfile::TempDir>> = const { RefCell::new(None) };
}

/// What `read` makes of the first file of a folder of these.
fn in_folder<T>(files: &[(&str, &[u8])], read: impl FnOnce(&Path) -> T) -> T {
    FOLDER.with_borrow_mut(|folder| {
        let memory = Path::new("/dev/shm");
        let place = if memory.is_dir() { memory.to_owned() } else { std::env::temp_dir() };
        let folder = folder.get_or_insert_with(|| tempfile::tempdir_in(place).expect("a temporary folder"));
        for (name, bytes) in files {
            std::fs::write(folder.path().join(name), bytes).expect("a temporary file");
        }
        let found = read(&folder.path().join(files[0].0));
        std::fs::remove_file(folder.path().join(files[0].0)).expect("a temporary file");
        found
    })
}

/// Does with a mesh what a bake would, at the coarsest.
fn look_at(mesh: Result<Mesh, ImportError>) {
    match mesh {
        Ok(mesh) => bake(&mesh),
        Err(error) => check_message(&error),
    }
}

fn check_message(error: &ImportError) {
    assert!(error.to_string().len() < 20_000, "a message of {} bytes", error.to_string().len());
}

/// What a scene file may hold.
fn check_stand(stand: &Stand) {
    assert!(!stand.plants.is_empty());
    for plant in &stand.plants {
        assert!(plant.species < stand.species.len());
        assert!(plant.position_m.iter().all(|x| x.abs() <= 1e9), "{plant:?}");
        assert!((1e-6..=1e6).contains(&plant.scale), "{plant:?}");
        let length = plant.rotation.iter().map(|x| x * x).sum::<f64>().sqrt();
        assert!((length - 1.0).abs() < 1e-6 && plant.rotation[3] >= 0.0, "{plant:?}");
    }
    let mut names: Vec<&str> = stand.species.iter().map(|species| species.name.as_str()).collect();
    assert!(
        names.iter().all(|name| !name.trim().is_empty() && !name.contains(flb_format::text::is_hidden)),
        "{names:?}"
    );
    names.sort_unstable();
    names.dedup();
    assert_eq!(names.len(), stand.species.len(), "names are unique");
    for (index, species) in stand.species.iter().enumerate() {
        assert_eq!(stand.find(&species.name).map(|_| ()), Some(()));
        assert_eq!(stand.find(&format!("#{}", species.mesh)), Some(index));
    }
    let numbers =
        stand.camera.iter().flat_map(|camera| camera.position_m.into_iter().chain(camera.look_at_m));
    assert!(numbers.chain(stand.sun.into_iter().flatten()).all(f64::is_finite));
}

fn bake(mesh: &Mesh) {
    check_mesh(mesh);
    let known = found(mesh, &ClassRules::default()).expect("there is no pattern to be wrong");
    assert_eq!(flb_scene::classify::table::rows(mesh, &known).len(), mesh.materials.len());
    if mesh.triangles.len() > 1000 {
        return;
    }
    let classes = vec![MaterialClass::Leaf; mesh.materials.len()];
    for ignore_alpha in [false, true] {
        let settings = VoxelSettings { voxels: 32, lattice: 16, ignore_alpha };
        if let Ok(occupancy) = voxelise(mesh, &classes, &settings, &|_| Ok(())) {
            let medium = flb_baker::downsample(&occupancy).expect("an occupancy of voxelise downsamples");
            assert!(medium.density.iter().all(|density| (0.0..=1.0).contains(density)));
        }
    }
}

/// What every later stage relies on.
fn check_mesh(mesh: &Mesh) {
    let vertices = mesh.positions.len();
    assert_eq!((mesh.normals.len(), mesh.uvs.len()), (vertices, vertices));
    assert_eq!(mesh.triangle_material.len(), mesh.triangles.len());
    assert!(mesh.triangles.as_flattened().iter().all(|&vertex| (vertex as usize) < vertices));
    assert!(mesh.triangle_material.iter().all(|&material| (material as usize) < mesh.materials.len()));
    assert!(mesh.positions.as_flattened().iter().all(|x| x.is_finite()));
    assert!(mesh.uvs.as_flattened().iter().all(|x| x.is_finite()));
    for normal in &mesh.normals {
        let length = normal.iter().map(|x| x * x).sum::<f32>().sqrt();
        assert!((length - 1.0).abs() < 1e-3, "a normal {normal:?}");
    }
    for image in &mesh.images {
        assert_eq!(image.rgba.len(), 4 * image.width as usize * image.height as usize);
    }
    for material in &mesh.materials {
        let textures = [material.color_texture, material.alpha_texture];
        assert!(textures.iter().flatten().all(|texture| (texture.image as usize) < mesh.images.len()));
    }
}

/// A text as a species file.
pub fn species_file(bytes: &[u8]) {
    let Ok(text) = std::str::from_utf8(bytes) else { return };
    match SpeciesFile::parse("a.toml", text) {
        Ok(species) => {
            let bands = species.surfaces.iter().map(|surfaces| surfaces.bands.len());
            let bands = bands.chain(species.optics.iter().map(|optics| optics.bands.len()));
            assert!(bands.into_iter().all(|bands| (1..=64).contains(&bands)));
            let rules: SpeciesRules = species.rules();
            let mesh = Mesh { materials: vec![leaf()], ..Mesh::default() };
            let decided = found(&mesh, &ClassRules { species: Some(rules), ..ClassRules::default() });
            let _ = decided.map_err(|error| check_message(&error));
        }
        Err(error) => check_message(&error),
    }
}

/// A text as a scene: read in parts, it is what it is as a whole, or refused both ways.
pub fn scene(bytes: &[u8]) {
    let Ok(text) = std::str::from_utf8(bytes) else { return };
    let [whole, parts, told] = [Scene::parse_as_a_whole, Scene::parse_in_parts, Scene::parse]
        .map(|parse| parse("a.toml", Path::new("scenes"), text));
    match (whole, parts, told) {
        (Ok(whole), Ok(parts), Ok(told)) => {
            assert!(whole == parts && whole == told, "{whole:?}\n{parts:?}");
            assert!(whole.instances.iter().all(|instance| instance.species < whole.species.len()));
        }
        (Err(whole), Err(parts), Err(told)) => {
            check_message(&parts);
            check_message(&told);
            assert_eq!(whole.to_string(), told.to_string(), "a small text tells what it always told");
        }
        (whole, parts, told) => {
            panic!("as a whole {:?}, in parts {:?}, {:?}", whole.err(), parts.err(), told.err());
        }
    }
}

/// An image beside a mesh whose leaves it cuts, under the name that its kind has.
pub fn texture(bytes: &[u8]) {
    let name = match bytes {
        [0xFF, 0xD8, ..] => "a.jpg",
        [b'R', b'I', b'F', b'F', ..] => "a.webp",
        [b'B', b'M', ..] => "a.bmp",
        [0x89, ..] => "a.png",
        // Nothing but its name tells it.
        _ => "a.tga",
    };
    let library = format!("newmtl leaf\nmap_Kd {name}\nmap_d -imfchan m {name}\n");
    let files = [("a.obj", LEAF), ("a.mtl", library.as_bytes()), (name, bytes)];
    look_at(in_folder(&files, |path| {
        let mesh = import(path, &ImportSettings::default())?;
        for image in &mesh.images {
            assert!(image.width.max(image.height) <= 16_384, "{} x {}", image.width, image.height);
            assert!((0.0..=1.0).contains(&cut_share(image, 0.5)));
        }
        Ok(mesh)
    }));
}

/// A square with corners of an image on it.
const LEAF: &[u8] = b"mtllib a.mtl\nv 0 0 0\nv 1 0 0\nv 1 1 0\nv 0 1 0\nvt 0 0\nvt 1 0\nvt 1 1\nvt 0 1\n\
    usemtl leaf\nf 1/1 2/2 3/3 4/4\n";

fn leaf() -> flb_scene::mesh::Material {
    flb_scene::mesh::Material::opaque("Leaf 01")
}
