use std::collections::BTreeMap;
use std::fs;
use std::path::Path;
use std::sync::Mutex;

use tempfile::{TempDir, tempdir};

use super::*;
use crate::cache::Place;

/// A plant of a trunk and leaves, `height_m` high.
pub(crate) fn plant(height_m: f64) -> String {
    let mut text = String::new();
    let mut vertices = 0;
    let mut square = |text: &mut String, corners: [[f64; 3]; 4]| {
        corners.iter().for_each(|[x, y, z]| *text += &format!("v {x} {y} {z}\n"));
        *text += &format!("f {} {} {} {}\n", vertices + 1, vertices + 2, vertices + 3, vertices + 4);
        vertices += 4;
    };
    text += "usemtl bark\n";
    let (low, high) = (0.0, 0.8 * height_m);
    for [[x, z], [u, w]] in [[[0.0, 0.0], [0.1, 0.0]], [[0.1, 0.0], [0.05, 0.1]], [[0.05, 0.1], [0.0, 0.0]]] {
        square(&mut text, [[x, low, z], [u, low, w], [u, high, w], [x, high, z]]);
    }
    text += "usemtl leaves\n";
    for at in 0..24 {
        let (turn, y) = (f64::from(at) * 2.4, (0.4 + 0.025 * f64::from(at)) * height_m);
        let [x, z] = [0.4 * libm::cos(turn), 0.4 * libm::sin(turn)];
        square(
            &mut text,
            [[x, y, z], [x + 0.2, y, z + 0.05], [x + 0.2, y + 0.1, z + 0.1], [x, y + 0.1, z + 0.05]],
        );
    }
    text
}

const MANIFEST: &str = "
[bake]
quality = 'draft'
lattice = 16
voxels = 64

[[species]]
name = 'oak'
mesh = 'oak.obj'
species_file = 'oak.toml'

[[species.variant]]
name = 'autumn'
plant = { leaf_colour = 'measured', surfaces = [{ name = 'R', leaf = { reflectance = 0.3, transmittance = 0.2 }, wood = { reflectance = 0.1 } }, { name = 'G', leaf = { reflectance = 0.1, transmittance = 0.1 }, wood = { reflectance = 0.1 } }, { name = 'B', leaf = { reflectance = 0.05, transmittance = 0.05 }, wood = { reflectance = 0.1 } }] }

[[species]]
name = 'ash'
mesh = 'ash.obj'
";

pub(crate) struct Farm {
    folder: TempDir,
}

/// Stages of each species as they ran.
pub(crate) type Ran = BTreeMap<String, Vec<&'static str>>;

#[derive(Default)]
struct Heard(Mutex<Ran>);

impl BuildObserver for Heard {
    fn at(&self, species: &str, step: Step, share: f64) {
        if share == 0.0 {
            let mut heard = self.0.lock().expect("no holder panics");
            let steps = heard.entry(species.to_owned()).or_default();
            if !steps.contains(&step.name()) {
                steps.push(step.name());
            }
        }
    }
}

impl Farm {
    pub(crate) fn new() -> Farm {
        let farm = Farm { folder: tempdir().expect("a folder") };
        farm.write("library.toml", MANIFEST);
        farm.write("oak.obj", &plant(2.0));
        farm.write("ash.obj", &plant(1.5));
        farm.write("oak.toml", "wood = ['bark']\n");
        farm
    }

    pub(crate) fn path(&self, name: &str) -> std::path::PathBuf {
        self.folder.path().join(name)
    }

    pub(crate) fn write(&self, name: &str, text: &str) {
        fs::write(self.path(name), text).expect("a file");
    }

    pub(crate) fn edit(&self, name: &str, from: &str, to: &str) {
        let text = fs::read_to_string(self.path(name)).expect("a file");
        assert!(text.contains(from), "{name} has no {from}");
        self.write(name, &text.replace(from, to));
    }

    fn build_with(
        &self,
        settings: &BuildSettings,
        observer: &dyn BuildObserver,
    ) -> Result<Summary, FarmError> {
        let manifest = Manifest::read(&self.path("library.toml")).expect("a manifest");
        let cache = self.path("cache");
        let tell = |_: &str| {};
        let cache = Cache::open(Some(&Place::Folder(cache)), &tell).expect("a cache");
        build(&manifest, settings, (&cache, Trust::Nothing), observer)
    }

    pub(crate) fn build(&self) -> (Vec<(String, String)>, Ran) {
        let heard = Heard::default();
        let summary = self.build_with(&settings(), &heard).expect("a build");
        let outcome = |built: &Built| {
            let told = match &built.outcome {
                Outcome::Current => "current".to_owned(),
                Outcome::Stored => "stored".to_owned(),
                Outcome::Made(why) => why.to_string(),
                Outcome::Failed(error) => error.to_string(),
                Outcome::Skipped => "skipped".to_owned(),
            };
            (built.name.clone(), told)
        };
        (summary.species.iter().map(outcome).collect(), heard.0.into_inner().expect("no holder panics"))
    }

    /// Every file of the output, by its path.
    pub(crate) fn files(&self) -> BTreeMap<String, Vec<u8>> {
        fn add(folder: &Path, base: &Path, found: &mut BTreeMap<String, Vec<u8>>) {
            for entry in fs::read_dir(folder).expect("a folder") {
                let path = entry.expect("an entry").path();
                match path.is_dir() {
                    true => add(&path, base, found),
                    false => {
                        let name = path.strip_prefix(base).expect("below").display().to_string();
                        found.insert(name, fs::read(&path).expect("a file"));
                    }
                }
            }
        }
        let (mut found, output) = (BTreeMap::new(), self.path("library"));
        add(&output, &output, &mut found);
        found
    }
}

fn settings() -> BuildSettings {
    BuildSettings {
        jobs: 2,
        threads: 2,
        memory_bytes: 4 << 30,
        only: Vec::new(),
        on_failure: OnFailure::KeepGoing,
    }
}

fn told(name: &str, what: &str) -> (String, String) {
    (name.to_owned(), what.to_owned())
}

#[test]
fn a_library_is_built_once_and_again_changes_no_byte() {
    let farm = Farm::new();
    let (outcomes, _) = farm.build();
    let new = |name| told(name, "it was never built here");
    assert_eq!(outcomes, [new("oak"), new("oak-autumn"), new("ash")]);
    let files = farm.files();
    for name in
        ["species/oak.flb", "pictures/ash.png", "logs/oak.log", "records/oak-autumn.json", "library.flb"]
    {
        assert!(files.contains_key(name), "{name}: {:?}", files.keys());
    }
    let library = flb_runtime::Library::open(farm.path("library/library.flb")).expect("a library");
    let names: Vec<&str> = library.container().species().iter().map(|one| one.meta.name.as_str()).collect();
    assert_eq!(names, ["ash", "oak", "oak-autumn"]);
    let page = String::from_utf8(files["index.html"].clone()).expect("text");
    assert!(page.contains("3 species") && !page.contains("<script") && !page.contains("http"), "{page}");

    let (outcomes, ran) = farm.build();
    assert_eq!(outcomes, ["oak", "oak-autumn", "ash"].map(|name| told(name, "current")));
    assert!(ran.is_empty(), "{ran:?}");
    assert_eq!(farm.files(), files);

    // A lost output comes back from the cache, to the same bytes; so does all of it elsewhere.
    fs::remove_dir_all(farm.path("library")).expect("it was there");
    let (outcomes, _) = farm.build();
    assert_eq!(outcomes, ["oak", "oak-autumn", "ash"].map(|name| told(name, "stored")));
    let again = farm.files();
    assert!(files.iter().all(|(name, bytes)| name == "index.html" || again[name] == *bytes));
}

#[test]
fn what_changes_is_said_and_no_more_is_made() {
    let farm = Farm::new();
    farm.build();
    let before = farm.files();
    farm.edit("library.toml", "reflectance = 0.3", "reflectance = 0.35");
    let (outcomes, ran) = farm.build();
    let why = "plant.surfaces.R.leaf.reflectance 0.3 -> 0.35; species_file oak.toml has other bytes: solve, encode, \
               write; import, voxelise, crown reused";
    assert_eq!(outcomes, [told("oak", "current"), told("oak-autumn", why), told("ash", "current")]);
    assert_eq!(ran.keys().collect::<Vec<_>>(), ["oak-autumn"]);
    let log = fs::read_to_string(farm.path("library/logs/oak-autumn.log")).expect("a log");
    for step in ["voxelise", "downsample", "crown"] {
        assert!(log.contains(&format!("oak-autumn: {step} from the cache")), "{step}: {log}");
    }
    assert!(!log.contains("solve from the cache"), "{log}");
    let after = farm.files();
    assert_eq!(before["species/oak.flb"], after["species/oak.flb"]);
    assert_ne!(before["species/oak-autumn.flb"], after["species/oak-autumn.flb"]);

    // Lines that move change nothing.
    farm.edit("library.toml", "mesh = 'ash.obj'", "mesh = 'ash.obj'\nplant = { wood = ['bark'] }");
    farm.build();
    farm.edit("library.toml", "[bake]", "# A line more.\n[bake]");
    assert!(farm.build().0.iter().all(|(_, told)| told == "current"));

    farm.write("ash.obj", &plant(1.4));
    let (outcomes, _) = farm.build();
    let why = "mesh ash.obj has other bytes: import, voxelise, crown, solve, encode, write";
    assert_eq!(outcomes[2], told("ash", why));
    farm.edit("library.toml", "quality = 'draft'", "quality = 'draft'\ntarget_psnr = 40.0");
    let (outcomes, _) = farm.build();
    for (_, why) in outcomes {
        assert!(why.ends_with(": encode, write; import, voxelise, crown, solve reused"), "{why}");
    }
}

#[test]
fn a_file_of_the_farm_is_what_a_bake_of_its_own_writes() {
    let farm = Farm::new();
    farm.build();
    let manifest = Manifest::read(&farm.path("library.toml")).expect("a manifest");
    let entry = manifest.find("ash").expect("an ash");
    let (bake, coding) = (
        entry.recipe.bake_settings(crate::recipe::Machine::Cpu).unwrap(),
        entry.recipe.encode_settings().unwrap(),
    );
    let reader = flb_scene::PlantReader::default();
    let (classed, _) = reader.read(&entry.mesh).unwrap();
    let plant = reader.plant("ash".to_owned(), classed);
    let baked =
        flb_baker::bake(plant, &bake, &flb_baker::bake::NoStore, &flb_scene::Unobserved).expect("a bake");
    let coded = flb_packer::encode_species(&baked.fields, &coding, &|_| Ok(())).unwrap();
    let mut bytes = Vec::new();
    flb_packer::write_library_to(&mut bytes, &[&coded]).unwrap();
    assert_eq!(farm.files()["species/ash.flb"], bytes);
}

#[test]
fn one_that_fails_leaves_the_others_and_is_told() {
    let farm = Farm::new();
    farm.write("ash.obj", "usemtl box\nv 0 0 0\nv 1 0 0\nv 0 1 0\nf 1 2 3\n");
    let (outcomes, _) = farm.build();
    assert!(outcomes[2].1.contains("ash.obj") && outcomes[2].1.contains("box"), "{outcomes:?}");
    assert_eq!(outcomes[0].1, "it was never built here");
    let files = farm.files();
    assert!(files.contains_key("species/oak.flb") && !files.contains_key("library.flb"));
    let page = String::from_utf8(files["index.html"].clone()).expect("text");
    assert!(page.contains("Failed") && page.contains("ash"), "{page}");
    // Mended, it alone is made.
    farm.write("ash.obj", &plant(1.5));
    let (outcomes, ran) = farm.build();
    assert_eq!(outcomes[2], told("ash", "it was never built here"));
    assert_eq!(ran.keys().collect::<Vec<_>>(), ["ash"]);
    assert!(farm.files().contains_key("library.flb"));
}

#[test]
fn damaged_entries_of_the_store_are_made_again() {
    let farm = Farm::new();
    farm.build();
    let files = farm.files();
    fs::remove_dir_all(farm.path("library")).expect("it was there");
    for entry in fs::read_dir(farm.path("cache")).expect("a cache") {
        let path = entry.expect("an entry").path();
        let mut bytes = fs::read(&path).expect("a file");
        if let Some(byte) = bytes.get_mut(60) {
            *byte ^= 0x10;
        }
        fs::write(&path, bytes).expect("a file");
    }
    let (outcomes, _) = farm.build();
    assert_eq!(outcomes.len(), 3);
    let again = farm.files();
    for name in ["species/oak.flb", "species/ash.flb", "library.flb"] {
        assert_eq!(again[name], files[name], "{name}");
    }
}

#[test]
fn budgets_names_and_only_some_species() {
    let farm = Farm::new();
    farm.edit(
        "library.toml",
        "mesh = 'ash.obj'",
        "mesh = 'ash.obj'\nbudget = { bytes = 100, seconds = 1e6 }",
    );
    let only = |name: &str| BuildSettings { only: vec![name.to_owned()], ..settings() };
    let summary = farm.build_with(&only("ash"), &Heard::default()).expect("a build");
    assert_eq!(summary.species.len(), 1);
    assert!(summary.species[0].over[0].ends_with("over its budget of 100"), "{:?}", summary.species[0].over);
    assert!(!summary.is_whole());
    assert!(!farm.files().contains_key("species/oak.flb"));
    let error = farm.build_with(&only("oka"), &Heard::default()).expect_err("no such species");
    assert!(error.to_string().ends_with("no species is named \"oka\", did you mean \"oak\"?"), "{error}");
    fs::write(farm.path("library/species/elm.flb"), b"x").expect("a file");
    let summary = farm.build_with(&settings(), &Heard::default()).expect("a build");
    assert_eq!(summary.left_over, ["elm"]);
}
