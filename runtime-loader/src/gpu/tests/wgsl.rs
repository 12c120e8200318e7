//! The WGSL by itself: no GPU needed.

use flb_format::beam::reaches;
use naga::proc::Layouter;
use naga::valid::{Capabilities, ValidationFlags, Validator};
use naga::{Literal, Module, TypeInner};

use super::super::layout::{self, SpeciesPlaces, Term};
use super::super::{atlas, atlas_wgsl, light_wgsl, light_wgsl_f16, pack};
use crate::near_beam::CANDIDATES;

use super::made::{Random, grid, made, shared};
use super::{near, probe, sky};

/// What every device of WebGPU can do, without a feature that is asked for.
const WEBGPU: Capabilities = Capabilities::SHADER_FLOAT16_IN_FLOAT32;

pub(super) fn parse(source: &str) -> Result<Module, String> {
    parse_for(WEBGPU, source)
}

fn parse_for(capabilities: Capabilities, source: &str) -> Result<Module, String> {
    let module = naga::front::wgsl::parse_str(source).map_err(|error| error.emit_to_string(source))?;
    let mut validator = Validator::new(ValidationFlags::all(), capabilities);
    validator.validate(&module).map_err(|error| error.emit_to_string(source))?;
    Ok(module)
}

fn sources() -> Vec<(&'static str, String)> {
    vec![
        ("light", light_wgsl(3)),
        ("samples", light_wgsl(1) + probe::SAMPLES),
        ("texels", light_wgsl(1) + probe::TEXELS),
        ("near", light_wgsl(1) + &near::near()),
        ("sky", light_wgsl(1) + &sky::sky()),
        ("fill", light_wgsl(1) + atlas::FILL),
        ("atlas", atlas_wgsl(3, 2)),
    ]
}

#[test]
fn every_module_is_valid() {
    for (name, source) in sources() {
        parse(&source).unwrap_or_else(|error| panic!("{name}: {error}"));
    }
}

#[test]
fn sums_in_f16_are_valid_where_the_device_has_it_and_only_there() {
    let source = light_wgsl_f16(1) + probe::SAMPLES;
    parse_for(WEBGPU | Capabilities::SHADER_FLOAT16, &source).unwrap_or_else(|error| panic!("{error}"));
    assert!(parse(&source).is_err());
}

#[test]
fn a_module_that_writes_what_it_may_only_read_is_found_invalid() {
    let source = light_wgsl(3).replace("record = at;", "record = at; flb_words[0] = 1u;");
    assert!(source != light_wgsl(3), "nothing was planted");
    assert!(parse(&source).is_err());
}

#[test]
fn the_bind_group_has_the_number_that_was_asked_for() {
    let module = parse(&light_wgsl(2)).unwrap();
    let mut bindings: Vec<_> =
        module.global_variables.iter().filter_map(|(_, v)| v.binding.map(|b| (b.group, b.binding))).collect();
    bindings.sort_unstable();
    assert_eq!(bindings, [(2, 0), (2, 1), (2, 2), (2, 3)]);
}

/// Names and offsets of a struct's members, and its size.
fn members(module: &Module, name: &str) -> (Vec<(String, u32)>, u32) {
    let mut layouter = Layouter::default();
    layouter.update(module.to_ctx()).unwrap();
    let found = module.types.iter().find(|(_, ty)| ty.name.as_deref() == Some(name));
    let (handle, ty) = found.unwrap_or_else(|| panic!("no struct {name}"));
    let TypeInner::Struct { members, .. } = &ty.inner else { panic!("{name} is no struct") };
    let members = members.iter().map(|member| (member.name.clone().unwrap(), member.offset));
    (members.collect(), layouter[handle].to_stride())
}

fn at<'a>(first: u32, names: impl IntoIterator<Item = &'a str>) -> Vec<(String, u32)> {
    names.into_iter().zip(0..).map(|(name, word)| (name.to_owned(), first + 4 * word)).collect()
}

#[test]
fn structs_are_laid_out_as_rust_writes_them() {
    let module = parse(&light_wgsl(3)).unwrap();
    let random = &mut Random(1);
    let shared = shared(random, 16, true, false);
    let base = made(random, &shared, 3, 1).base;

    let places = SpeciesPlaces { map: 5, extinction: 6, single: true, sky: [7, 4] };
    let species = layout::species_fields(&grid(16), &shared, places).map(|(name, _)| name);
    let mut expected = at(0, [species[0]]);
    expected.extend(at(12, species[1..].iter().copied()));
    assert_eq!(members(&module, "FlbSpecies"), (expected, layout::SPECIES_BYTES as u32));

    let mut expected = at(0, ["colors"]);
    expected.extend(at(16 * layout::COLORS as u32, layout::base_fields(&base, 1, 2).map(|(name, _)| name)));
    assert_eq!(members(&module, "FlbBase"), (expected, layout::BASE_BYTES as u32));

    let term = layout::term_fields(Term { base: 1, factor: 0.5 }).map(|(name, _)| name);
    assert_eq!(members(&module, "FlbTerm"), (at(0, term), layout::TERM_BYTES as u32));

    let (fill, about) = atlas::field_names();
    let module = parse(&(light_wgsl(1) + atlas::FILL)).unwrap();
    assert_eq!(members(&module, "Fill"), (at(0, fill), 32));
    let module = parse(&atlas_wgsl(3, 2)).unwrap();
    assert_eq!(members(&module, "FlbAtlas"), (at(0, about), 16));
}

#[test]
fn constants_are_those_of_rust() {
    let light = parse(&light_wgsl(3)).unwrap();
    let number = |module: &Module, name: &str| {
        let found = module.constants.iter().find(|(_, constant)| constant.name.as_deref() == Some(name));
        let (_, constant) = found.unwrap_or_else(|| panic!("no constant {name}"));
        match module.global_expressions[constant.init] {
            naga::Expression::Literal(Literal::U32(value)) => i64::from(value),
            naga::Expression::Literal(Literal::I32(value)) => i64::from(value),
            ref other => panic!("{name}: {other:?}"),
        }
    };
    let value = |name| number(&light, name);
    assert_eq!(value("FLB_SPECIES"), i64::from(layout::MAX_SPECIES));
    assert_eq!(value("FLB_TERMS"), i64::from(layout::MAX_TERMS));
    assert_eq!(value("FLB_WIDE"), i64::from(pack::WIDE));
    assert_eq!(value("FLB_SHIFT"), i64::from(pack::SHIFT));
    assert_eq!(value("FLB_NONE"), i64::from(layout::NONE));
    assert_eq!(value("FLB_RELATIVE"), i64::from(layout::RELATIVE));
    assert_eq!(value("FLB_CANDIDATES"), i64::from(CANDIDATES));
    assert_eq!(value("FLB_REACH_WITH_SINGLE"), i64::from(reaches(true)[0]));
    assert_eq!((reaches(true).len(), reaches(false)), (1, &[1, 3, 8][..]), "as FLB_REACHES has them");
    assert_eq!(value("FLB_COARSE"), i64::from(layout::COARSE));
    let average = i64::from(flb_format::blocks::transform::AVERAGE_COEFFICIENT);
    assert_eq!(value("FLB_AVERAGE"), average);
    let fill = parse(&(light_wgsl(1) + atlas::FILL)).unwrap();
    assert_eq!(number(&fill, "BRICK"), i64::from(atlas::BRICK));
    assert_eq!(number(&fill, "WORKGROUPS"), i64::from(atlas::WORKGROUPS));
    assert_eq!(number(&parse(&atlas_wgsl(3, 2)).unwrap(), "FLB_BRICK"), i64::from(atlas::BRICK));
}
