//! The shaders by naga, without any GPU: valid, within WebGPU's limits, and laid out as Rust writes them.

use flb_render::forest::export::{self, grids as export_grids};
use flb_runtime::scene_light::export as scene_light;
use naga::valid::{Capabilities, ValidationFlags, Validator};

use super::ways;
use crate::grids;
use crate::layout::{self, members, members::Member};
use crate::stages::{Ways, among, sources};

fn all() -> Vec<(&'static str, String)> {
    let ways = |has_water: bool| ways::all().into_iter().map(move |search| Ways { search, has_water });
    let others = ways(false).skip(1).chain(ways(true)).flat_map(|ways| sources(ways).into_iter().take(2));
    sources(Ways::default()).into_iter().chain([among()]).chain(others).collect()
}

fn parsed(source: &str) -> naga::Module {
    naga::front::wgsl::parse_str(source).unwrap_or_else(|error| panic!("{}", error.emit_to_string(source)))
}

fn is_valid(module: &naga::Module) -> Result<(), String> {
    let mut validator = Validator::new(ValidationFlags::all(), Capabilities::SHADER_FLOAT16_IN_FLOAT32);
    validator.validate(module).map(drop).map_err(|error| format!("{error:?}"))
}

#[test]
fn every_stage_is_valid_and_has_its_workgroup() {
    for (name, source) in all() {
        let module = parsed(&source);
        is_valid(&module).unwrap_or_else(|error| panic!("{name}: {error}"));
        let [entry] = &module.entry_points[..] else { panic!("{name} has one entry point") };
        assert_eq!((entry.name.as_str(), entry.workgroup_size), (name, [layout::WORKGROUP, 1, 1]));
    }
}

#[test]
fn no_stage_binds_more_than_webgpu_promises() {
    for (name, source) in all() {
        let module = parsed(&source);
        let spaces = || module.global_variables.iter().map(|(_, variable)| variable.space);
        let storage = spaces().filter(|space| matches!(space, naga::AddressSpace::Storage { .. })).count();
        let uniform = spaces().filter(|space| *space == naga::AddressSpace::Uniform).count();
        assert!(storage <= 8 && uniform <= 12, "{name}: {storage} storage buffers, {uniform} uniforms");
        let groups = module.global_variables.iter().filter_map(|(_, v)| v.binding.as_ref()).map(|b| b.group);
        assert!(groups.max().is_some_and(|most| most < 4), "{name}");
    }
}

#[test]
fn a_stage_that_writes_what_it_may_only_read_is_found_invalid() {
    let (_, source) = &sources(Ways::default())[0];
    let broken = source.replace("var met = nearest", "boxes[0].first = 1u;\n    var met = nearest");
    assert_ne!(*source, broken);
    assert!(is_valid(&parsed(&broken)).is_err());
}

fn found_in(module: &naga::Module, name: &str) -> Option<(Vec<(String, u32)>, u32)> {
    let (_, found) = module.types.iter().find(|(_, ty)| ty.name.as_deref() == Some(name))?;
    let naga::TypeInner::Struct { members, span } = &found.inner else { return None };
    let named = members.iter().map(|member| (member.name.clone().unwrap_or_default(), member.offset));
    Some((named.collect(), *span))
}

fn expected(list: &[Member]) -> (Vec<(String, u32)>, u32) {
    let mut at = 0;
    let mut found = Vec::new();
    for (name, words) in list {
        found.push(((*name).to_owned(), at));
        at += 4 * *words as u32;
    }
    (found, at)
}

#[test]
fn structs_are_laid_out_as_rust_writes_them() {
    let structs: [(&str, &[Member]); 13] = [
        ("View", &members::VIEW),
        ("Daylight", &members::DAYLIGHT),
        ("Strip", &members::STRIP),
        ("Fragment", &members::FRAGMENT),
        ("Lit", &members::LIT),
        ("Box", &members::BOX),
        ("Model", &members::MODEL),
        ("Triangle", &members::TRIANGLE),
        ("Vertex", &members::VERTEX),
        ("Instance", &members::INSTANCE),
        ("Material", &members::MATERIAL),
        ("SpeciesTerms", &members::SPECIES_TERMS),
        ("VolumeBlend", &members::VOLUME_BLEND),
    ];
    let modules: Vec<_> = all().iter().map(|(_, source)| parsed(source)).collect();
    for (name, list) in structs {
        let mut found = modules.iter().filter_map(|module| found_in(module, name)).peekable();
        assert!(found.peek().is_some(), "no stage has {name}");
        assert!(found.all(|found| found == expected(list)), "{name}");
    }
    assert_eq!(u64::from(expected(&members::FRAGMENT).1), layout::FRAGMENT_BYTES);
    assert_eq!(u64::from(expected(&members::LIT).1), layout::LIT_BYTES);
    assert_eq!(expected(&members::DAYLIGHT).1 as usize, 4 * layout::DAYLIGHT_WORDS);
    assert_eq!(expected(&members::SPECIES_TERMS).1 as usize, 4 * layout::LIGHT_WORDS);
}

#[test]
fn constants_are_those_of_rust() {
    let text: String = all().into_iter().map(|(_, source)| source).collect();
    let whole = [
        ("WORKGROUP", layout::WORKGROUP),
        ("EDGE", layout::EDGE),
        ("MODELS", layout::MAX_MODELS as u32),
        ("MATERIALS", layout::MAX_MATERIALS as u32),
        ("STACK", layout::STACK),
        ("CLASS_LEAF", layout::CLASS_LEAF),
        ("VIEW_CELL", export_grids::VIEW_CELL_PX),
        ("GRID_HEAD", grids::GRID_HEAD),
        ("SUN_HEAD", grids::SUN_HEAD),
        ("WAVE_COUNT", flb_scene::waves::WAVE_COUNT as u32),
    ];
    for (name, value) in whole {
        assert!(text.contains(&format!("const {name}: u32 = {value}u;")), "{name} is {value}");
    }
    let bits = [
        ("SKY", layout::SKY),
        ("GROUND", layout::GROUND),
        ("NONE", layout::NONE),
        ("NOTHING", layout::NOTHING),
        ("TRIANGLE_CUT", layout::TRIANGLE_CUT),
        ("TRIANGLE_FRONT", layout::TRIANGLE_FRONT),
        ("TRIANGLE_BACK", layout::TRIANGLE_BACK),
        ("BY_WATER", layout::BY_WATER),
    ];
    for (name, value) in bits {
        assert!(text.contains(&format!("const {name}: u32 = {value:#x}u;")), "{name} is {value:#x}");
    }
    let [index, into] = [export::REFRACTIVE_INDEX, export::INTO_FROM_SKY];
    assert!(text.contains(&format!("const REFRACTIVE_INDEX: f32 = {index};")));
    assert!(text.contains(&format!("const INTO_FROM_SKY: f32 = {into};")));
    assert!(text.contains(&format!("const NO_GLINT: f32 = {:.1};", export::NO_GLINT)));
    assert!(text.contains(&format!("const GRID_PAD: f32 = {};", export_grids::MODEL_PAD)));
    assert!(text.contains(&format!("const SUN_PAD: f32 = {};", grids::SUN_PAD)));
    assert!(text.contains(&format!("const FLOOR: f32 = {};", scene_light::FLOOR)));
    let [red, green, blue] = scene_light::LUMINANCE;
    assert!(text.contains(&format!("const LUMINANCE: vec3<f32> = vec3<f32>({red}, {green}, {blue});")));
    assert!(text.contains(&format!("const LEAVES_BEFORE_SKY: f32 = {};", export::LEAVES_BEFORE_SKY)));
    assert!(text.contains(&format!("const BLACK: f32 = {:e};", export::BLACK)));
}
