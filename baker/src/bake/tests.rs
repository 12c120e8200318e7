use std::collections::BTreeMap;
use std::sync::Mutex;

use flb_format::Quality;
use flb_format::light::{FieldKind, SunBasis};
use flb_scene::extents::Walls;
use flb_scene::mesh::testing::soup;
use flb_scene::{MaterialClass, Observer, Unobserved};
use flb_transport::ordinates::Ordinates;

use super::*;
use crate::solids::tests::leaves_deep_in_a_pot;

mod stopped;

/// Leaves here and there, of one seed.
fn plant(name: &str) -> Plant {
    let leaf = |i: u32| {
        let [x, y, z] = [i % 3, i / 3 % 3, i / 9].map(|c| c as f32 * 0.3);
        [[x, y, z], [x + 0.25, y + 0.05, z], [x, y + 0.2, z + 0.15]]
    };
    let triangles: Vec<[[f32; 3]; 3]> = (0..27).map(leaf).collect();
    Plant::new(name, soup(&triangles), vec![MaterialClass::Leaf, MaterialClass::Wood])
}

fn quick() -> BakeSettings {
    let physical =
        PhysicalSettings { ordinates: Ordinates::Lattice18, ..PhysicalSettings::of(Quality::Draft) };
    BakeSettings {
        lattice: 16,
        voxels: 64,
        model: ModelSettings::Physical(physical),
        ..BakeSettings::default()
    }
}

fn paper() -> BakeSettings {
    BakeSettings { model: ModelSettings::Paper(PaperSettings::default()), ..quick() }
}

/// A store in memory.
#[derive(Default)]
struct Shelf {
    kept: Mutex<BTreeMap<String, Vec<u8>>>,
    refused: Mutex<Vec<String>>,
}

impl Store for Shelf {
    fn get(&self, name: &str) -> Option<Vec<u8>> {
        self.kept.lock().expect("no test panics inside").get(name).cloned()
    }

    fn put(&self, name: &str, bytes: &[u8]) {
        self.kept.lock().expect("no test panics inside").insert(name.to_owned(), bytes.to_vec());
    }

    fn refuse(&self, name: &str, _: &str) {
        self.refused.lock().expect("no test panics inside").push(name.to_owned());
    }
}

/// Writes down what it is told.
#[derive(Default)]
struct Diary(Mutex<Vec<String>>);

impl Observer for Diary {
    fn begin(&self, step: Step, species: &str) {
        self.0.lock().expect("no test panics inside").push(format!("{species} {}", step.name()));
    }
}

impl BakeObserver for Diary {
    fn hear(&self, event: &Event) {
        let line = match event {
            Event::Reused { step, .. } => format!("reused {}", step.name()),
            Event::Changed { step, parts, .. } => format!("changed {}: {}", step.name(), parts.join(" ")),
            Event::Solved(summary) => format!("solved, cached {}", summary.cached),
            other => other.to_string(),
        };
        self.0.lock().expect("no test panics inside").push(line);
    }
}

impl Diary {
    fn lines(&self) -> Vec<String> {
        std::mem::take(&mut self.0.lock().expect("no test panics inside"))
    }
}

#[test]
fn leaves_that_walls_enclose_are_lit_by_fields_for_single_suns() {
    let pot = Plant::new("pot", leaves_deep_in_a_pot(), vec![MaterialClass::Wood, MaterialClass::Leaf]);
    let suns = |plant: &Plant, settings: &BakeSettings| {
        let baked = bake(plant.clone(), settings, &NoStore, &Unobserved).expect("a good plant");
        baked.fields.meta.model.physical().expect("the physical model").1.suns.clone()
    };
    let ModelSettings::Physical(physical) = quick().model else { panic!("the physical model") };
    let usual = physical.suns.basis(Walls::None);
    assert_eq!(suns(&plant("fern"), &quick()), usual);
    assert_eq!(suns(&pot, &quick()), SunBasis::Lattice18);
    let given = PhysicalSettings { suns: SunChoice::Fixed(usual.clone()), ..physical };
    let given = BakeSettings { model: ModelSettings::Physical(given), ..quick() };
    assert_eq!(suns(&pot, &given), usual);
}

#[test]
fn a_flat_leaf_does_not_light_itself_however_it_lies() {
    let corner = |i: u32, upright: bool| {
        let [a, b] = [i % 2, i / 2].map(|c| c as f32);
        if upright { [a, b, 0.0] } else { [a, 0.0, b] }
    };
    let ModelSettings::Physical(physical) = quick().model else { panic!("the physical model") };
    let suns = SunChoice::Fixed(SunBasis::Lattice18);
    let physical = PhysicalSettings { ordinates: Ordinates::Lebedev50, suns, ..physical };
    let settings =
        BakeSettings { lattice: 32, voxels: 256, model: ModelSettings::Physical(physical), ..quick() };
    for upright in [false, true] {
        let of = |corners: [u32; 3]| corners.map(|i| corner(i, upright));
        let classes = vec![MaterialClass::Leaf, MaterialClass::Wood];
        let leaf = Plant::new("leaf", soup(&[of([0, 1, 2]), of([1, 3, 2])]), classes);
        let baked = bake(leaf, &settings, &NoStore, &Unobserved).expect("a good plant").fields;
        let sites = baked.turbid.as_ref().expect("an extinction").sites();
        // In green, of which the leaf scatters 0.28: so much of the sun comes back to it. It kept 0.1 when what it
        // takes back did not go by how it lies.
        for (item, field) in baked.bases.iter().filter(|(item, _)| *item != 0) {
            let of_sites = sites.iter().map(|&site| f64::from(field.value(1, site as usize)));
            let mean = of_sites.sum::<f64>() / sites.len() as f64;
            assert!(mean.abs() < 0.03, "upright {upright}, direction {item}: {mean}");
        }
    }
}

#[test]
fn a_store_changes_no_field_and_says_what_it_gave() {
    for settings in [quick(), paper()] {
        let (shelf, diary) = (Shelf::default(), Diary::default());
        let alone = bake(plant("fern"), &settings, &NoStore, &diary).expect("a good plant");
        assert!(diary.lines().iter().all(|line| !line.starts_with("reused")));
        for round in 0..2 {
            let kept = bake(plant("fern"), &settings, &shelf, &diary).expect("a good plant");
            assert!(kept == alone);
            let reused = diary.lines().iter().filter(|line| line.starts_with("reused")).count();
            let stages = if matches!(settings.model, ModelSettings::Paper(_)) { 3 } else { 4 };
            assert_eq!(reused, round * stages);
        }
        assert!(shelf.refused.into_inner().expect("no test panics inside").is_empty());
    }
}

#[test]
fn what_is_made_again_is_told_with_the_parts_of_its_key_that_changed() {
    let (shelf, diary) = (Shelf::default(), Diary::default());
    bake(plant("fern"), &quick(), &shelf, &diary).expect("a good plant");
    assert!(diary.lines().iter().all(|line| !line.starts_with("changed")), "nothing was there before");
    let mut other = quick();
    let ModelSettings::Physical(physical) = &mut other.model else { panic!("the other model") };
    (physical.field, physical.tolerance) = (FieldKind::Total, 0.5);
    bake(plant("fern"), &other, &shelf, &diary).expect("a good plant");
    let changed: Vec<String> = diary.lines().into_iter().filter(|line| line.starts_with("changed")).collect();
    // A near beam does not lean in fields that hold the beam.
    assert_eq!(changed, ["changed solve: suns field tolerance"]);
    // Another plant of the name: its triangles are others, and so is all that follows.
    let mut moved = plant("fern");
    moved.classed.mesh.positions[0][0] = -0.5;
    bake(moved, &other, &shelf, &diary).expect("a good plant");
    let changed: Vec<String> = diary.lines().into_iter().filter(|line| line.starts_with("changed")).collect();
    assert_eq!(
        changed,
        [
            "changed voxelise: mesh",
            "changed downsample: occupancy",
            "changed crown: medium mesh",
            "changed solve: medium"
        ]
    );
}

#[test]
fn a_store_that_lies_is_found_and_mended() {
    let shelf = Shelf::default();
    let good = bake(plant("fern"), &quick(), &shelf, &Unobserved).expect("a good plant");
    let names: Vec<String> = shelf.kept.lock().expect("alone").keys().cloned().collect();
    let stages = ["occupancy", "medium", "crown", "light", "field"];
    for stage in stages {
        let name = names.iter().find(|name| name.starts_with(stage)).expect("every stage is kept");
        let whole = shelf.get(name).expect("it is kept");
        for bad in [&whole[..whole.len() - 1], &[], b"another thing altogether"] {
            shelf.put(name, bad);
            assert!(bake(plant("fern"), &quick(), &shelf, &Unobserved).expect("a good plant") == good);
            assert!(shelf.get(name).expect("it is kept") == whole, "{stage} is mended");
        }
    }
    assert_eq!(shelf.refused.into_inner().expect("alone").len(), 3 * stages.len());
    // What says why a key differs is only talk.
    let parts: Vec<String> = names.into_iter().filter(|name| name.starts_with("parts-")).collect();
    assert_eq!(parts.len(), 4);
    let shelf = Shelf::default();
    parts.iter().for_each(|name| shelf.put(name, b"{]"));
    assert!(bake(plant("fern"), &quick(), &shelf, &Unobserved).expect("a good plant") == good);
}

#[test]
fn what_cannot_be_baked_says_why() {
    let refuse = |plant: Plant, settings: &BakeSettings| {
        bake(plant, settings, &NoStore, &Unobserved).expect_err("no such bake").to_string()
    };
    let mut huge = plant("fern");
    huge.classed.mesh.positions.iter_mut().for_each(|p| *p = p.map(|c| c * 1e6));
    let said = refuse(huge, &quick());
    assert!(said.starts_with("the plant is ") && said.contains("expected 0.00001 to 100000 m"), "{said}");
    let said = refuse(plant(""), &quick());
    assert!(said.starts_with("the species cannot be stored"), "{said}");
    let wanted = Wanted { bands: Some(vec!["NIR".to_owned()]), ..Wanted::default() };
    let said = refuse(plant("fern"), &BakeSettings { wanted, ..quick() });
    assert!(said.contains("NIR") && said.contains("fern"), "{said}");
    let said = refuse(plant("fern"), &BakeSettings { lattice: 17, ..quick() });
    assert!(said.contains("17"), "{said}");
}
