use std::fs;
use std::path::{Path, PathBuf};

use super::*;
use crate::build::tests::{Farm, plant};

struct Quiet;
impl CompareObserver for Quiet {}

/// A farm that was built, with a copy of what was built; the species are oak, oak-autumn and ash.
fn built() -> (Farm, PathBuf) {
    let farm = Farm::new();
    farm.build();
    let old = farm.path("old");
    copy(&farm.path("library"), &old);
    (farm, old)
}

fn copy(from: &Path, to: &Path) {
    fs::create_dir_all(to).expect("a folder");
    for entry in fs::read_dir(from).expect("a folder") {
        let path = entry.expect("an entry").path();
        let target = to.join(path.file_name().expect("a name"));
        match path.is_dir() {
            true => copy(&path, &target),
            false => drop(fs::copy(&path, &target).expect("a file")),
        }
    }
}

fn of(old: &Path, new: &Path, fail_above: Option<f64>) -> Comparison {
    compare(old, new, fail_above, &Quiet).expect("two libraries")
}

fn error(old: &Path, new: &Path) -> String {
    compare(old, new, None, &Quiet).expect_err("a fault").to_string()
}

fn states(found: &Comparison) -> Vec<(&str, State, bool)> {
    found.species.iter().map(|one| (one.name.as_str(), one.state, one.failure.is_some())).collect()
}

#[test]
fn a_library_is_the_same_as_itself_in_every_form() {
    let (farm, old) = built();
    let (folder, file) = (farm.path("library"), farm.path("library/library.flb"));
    for (old, new) in [(&old, &folder), (&old, &file), (&file, &old), (&file, &file)] {
        let found = of(old, new, Some(0.0));
        let count = Count { unchanged: 3, ..Count::default() };
        assert_eq!((found.count, found.passes), (count, true), "{}", found.summary());
    }
    let one = farm.path("library/species/ash.flb");
    let found = of(&file, &one, Some(0.0));
    let expected = [
        ("oak", State::Removed, true),
        ("oak-autumn", State::Removed, true),
        ("ash", State::Unchanged, false),
    ];
    assert_eq!(states(&found), expected);
    let found = of(&one, &file, Some(0.0));
    assert_eq!((found.count.added, found.passes), (2, true));
}

#[test]
fn a_change_of_reflectance_is_measured_and_the_gate_is_between() {
    let farm = Farm::new();
    // Without the noise of a coding.
    farm.edit("library.toml", "quality = 'draft'", "quality = 'draft'\ncodec = 'raw-f32'");
    farm.build();
    let (old, new) = (farm.path("old"), farm.path("library"));
    copy(&new, &old);
    let rms = |reflectance: &str| {
        let was = format!("reflectance = {reflectance}");
        farm.edit("library.toml", "reflectance = 0.3", &was);
        farm.build();
        let found = of(&old, &new, None);
        farm.edit("library.toml", &was, "reflectance = 0.3");
        assert_eq!(found.species[0].name, "oak-autumn");
        assert_eq!((found.count.changed, found.count.unchanged), (1, 2));
        found.species[0].light.as_ref().expect("light of both").rms
    };
    // Twice the change is a little more than twice the difference: more of what was scattered is scattered again.
    let twice = rms("0.34") / rms("0.32");
    assert!(1.9 < twice && twice < 2.4, "{twice}");
    farm.edit("library.toml", "reflectance = 0.3", "reflectance = 0.5");
    farm.build();
    let found = of(&old, &new, None);
    let light = found.species[0].light.as_ref().expect("light of both");
    assert!(0.001 < light.rms && light.rms < 0.1, "{light:?}");
    assert!(0.0 < light.mean && light.mean < light.rms && light.rms <= light.worst.share, "{light:?}");
    assert!(light.rms < light.p99 && light.p99 <= light.worst.share * 1.000_001, "{light:?}");
    assert!(light.points > 100 && light.worst.new != light.worst.old, "{light:?}");
    // The other bands have the light that they had.
    assert_eq!(light.worst.band, "R");
    let meta = flb_runtime::Library::open(old.join("species/oak-autumn.flb")).expect("a file");
    let bounds = meta.container().species()[0].meta.bounds_m;
    let spacing = meta.container().species()[0].meta.grid.spacing_m;
    for axis in 0..3 {
        let at = f64::from(light.worst.point_m[axis]);
        assert!(bounds.min[axis] - spacing < at && at < bounds.max[axis] + spacing, "{light:?}");
    }
    for (fail_above, passes) in [(0.0, false), (light.rms * 0.99, false), (light.rms, true), (1.0, true)] {
        assert_eq!(of(&old, &new, Some(fail_above)).passes, passes, "{fail_above}");
    }
    // The other way round it becomes darker by about as much.
    let back = of(&new, &old, None);
    let back = back.species[0].light.as_ref().expect("light of both");
    assert!(back.mean < 0.0 && (back.rms / light.rms - 1.0).abs() < 0.5, "{back:?}");
}

#[test]
fn threads_change_no_byte_of_the_files() {
    let (farm, old) = built();
    farm.edit("library.toml", "reflectance = 0.3", "reflectance = 0.36");
    farm.write("ash.obj", &plant(1.4));
    farm.build();
    let on = |threads: usize| {
        let pool = rayon::ThreadPoolBuilder::new().num_threads(threads).build().expect("threads");
        pool.install(|| files(&of(&old, &farm.path("library"), Some(0.001))))
    };
    let (one, three) = (on(1), on(3));
    assert_eq!(one, three);
    let names: Vec<&str> = one.iter().map(|(name, _)| name.as_str()).collect();
    let pictures = ["1-before.png", "1-after.png", "1-difference.png"];
    assert_eq!((&names[..3], &names[6..]), (&pictures[..], &FILES[..]));
    let text = |name: &str| {
        let file = one.iter().find(|(file, _)| file == name).expect("a file");
        String::from_utf8(file.1.clone()).expect("text")
    };
    let page = text("index.html");
    assert!(page.contains("<b class=\"bad\">Failed:</b> 2 changed") && page.contains("1-difference.png"));
    assert!(page.contains("times 8") && !page.contains("<script") && !page.contains("http"), "{page}");
    let xml = text("junit.xml");
    assert!(xml.contains("tests=\"3\" failures=\"2\""), "{xml}");
    assert!(xml.contains("<testcase classname=\"species\" name=\"oak-autumn\"><failure message=\""), "{xml}");
    assert!(xml.contains("name=\"oak\"><system-out>the same bytes"), "{xml}");
    let differs: Vec<&str> = xml.lines().filter(|line| line.contains("name=\"ash\"")).collect();
    assert!(differs[0].contains("upper bounds, m,") && differs[0].contains("-&gt;"), "{differs:?}");
}

#[test]
fn light_that_cannot_be_compared_is_beyond_every_tolerance() {
    let (farm, old) = built();
    farm.edit("library.toml", "mesh = 'ash.obj'", "mesh = 'ash.obj'\nbake = { model = 'paper' }");
    farm.edit("library.toml", "name = 'B', leaf", "name = 'NIR', leaf");
    farm.build();
    let found = of(&old, &farm.path("library"), Some(1e9));
    let expected = [
        ("ash", State::Changed, true),
        ("oak-autumn", State::Changed, true),
        ("oak", State::Unchanged, false),
    ];
    assert_eq!(states(&found), expected);
    let reasons: Vec<&str> = found.species.iter().filter_map(|one| one.incomparable.as_deref()).collect();
    assert_eq!(reasons, ["model physical -> paper", "bands R G B -> R G NIR"]);
    assert!(of(&old, &farm.path("library"), None).passes);
}

#[test]
fn other_codings_and_lattices_are_compared_and_said() {
    let (farm, old) = built();
    farm.edit("library.toml", "quality = 'draft'", "quality = 'draft'\ncodec = 'raw-f32'");
    farm.build();
    let found = of(&old, &farm.path("library"), Some(0.02));

    assert_eq!((found.count.changed, found.passes), (3, true), "{}", found.summary());
    let all = || found.species.iter().filter_map(|one| one.light.as_ref());
    assert!(all().count() == 3 && all().all(|light| 0.0 < light.rms && light.rms < 0.02), "{found:?}");
    farm.edit("library.toml", "lattice = 16", "lattice = 32");
    farm.build();
    let found = of(&old, &farm.path("library"), None);
    let one = &found.species[0];
    assert!(one.light.is_some() && one.differs[0] == "lattice 16 -> 32", "{one:?}");
}

#[test]
fn bad_libraries_are_told() {
    let (farm, old) = built();
    let new = farm.path("library");
    let (index, ash) = (new.join("index.json"), new.join("species/ash.flb"));
    let text = fs::read_to_string(&index).expect("text");
    let bytes = fs::read(&ash).expect("bytes");

    let none = error(&old, &farm.path("none"));
    assert!(none.contains("none: cannot open"), "{none}");
    let folder = error(&farm.path("cache"), &new);
    assert!(folder.contains("cache: found a folder without index.json, expected one that"), "{folder}");
    let no_light = error(&farm.path("oak.obj"), &new);
    assert!(no_light.contains("oak.obj: FLB-"), "{no_light}");

    for (from, to, told) in [
        ("{", "nonsense", "expected an index that `flb library build` wrote"),
        ("\"schema\": 1", "\"schema\": 2", "found schema 2 instead of 1"),
        ("species/ash.flb", "../ash.flb", "found the path \"../ash.flb\", expected one that stays below"),
        ("species/ash.flb", "/ash.flb", "found the path \"/ash.flb\""),
        ("species/ash.flb", "species/elm.flb", "species/elm.flb: cannot open"),
        ("species/ash.flb", "species/oak.flb", "the file changed since it was built"),
    ] {
        assert!(text.contains(from), "{from}");
        fs::write(&index, text.replacen(from, to, 1)).expect("a file");
        let found = error(&old, &new);
        assert!(found.contains(told) && found.contains("library/"), "{from} -> {to}: {found}");
    }

    // A file whose digest the index has, but not of this species, or damaged.
    let with = |bytes: &[u8]| {
        let was = serde_json::from_str::<crate::index::Index>(&text).expect("an index").species["ash"]
            .facts
            .blake3
            .clone();
        fs::write(&ash, bytes).expect("a file");
        fs::write(&index, text.replace(&was, blake3::hash(bytes).to_hex().as_str())).expect("a file");
        error(&old, &new)
    };
    let other = with(&fs::read(new.join("species/oak.flb")).expect("bytes"));
    assert!(other.contains("found 1 species: \"oak\", expected the species \"ash\""), "{other}");
    for at in [9, bytes.len() / 2, bytes.len() - 9] {
        let mut damaged = bytes.clone();
        damaged[at] ^= 0x40;
        let found = with(&damaged);
        assert!(found.contains("ash.flb: FLB-"), "{at}: {found}");
    }
    let cut = with(&bytes[..bytes.len() / 2]);
    assert!(cut.contains("ash.flb: FLB-"), "{cut}");
}

#[test]
fn an_observer_hears_and_refuses() {
    struct Strict;
    impl CompareObserver for Strict {
        fn admit(&self, light: &[(&Library, &Species)]) -> Result<(), String> {
            Err(format!("no room for {}", light[0].1.meta.name))
        }
    }
    let (farm, old) = built();
    farm.edit("library.toml", "reflectance = 0.3", "reflectance = 0.36");
    farm.build();
    let refused = compare(&old, &farm.path("library"), None, &Strict).expect_err("refused");
    assert!(matches!(refused, FarmError::Room(ref told) if told == "no room for oak-autumn"), "{refused}");
}
