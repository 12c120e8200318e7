//! The WGSL by itself: no GPU needed.

use naga::proc::Layouter;
use naga::valid::{Capabilities, ValidationFlags, Validator};
use naga::{Literal, Module, TypeInner};

use super::super::super::sites;
use super::super::super::sweep::MIN_LOSS;
use super::super::layout::{self, Params};
use super::super::stages::{PARTS, SOURCES};
use super::*;
use crate::gpu::buffers::WORKGROUP;

fn parse(source: &str) -> Result<Module, String> {
    let module = naga::front::wgsl::parse_str(source).map_err(|error| error.emit_to_string(source))?;
    let mut validator = Validator::new(ValidationFlags::all(), Capabilities::empty());
    validator.validate(&module).map_err(|error| error.emit_to_string(source))?;
    Ok(module)
}

#[test]
fn every_stage_is_valid_and_has_its_workgroup() {
    for (name, source) in SOURCES {
        let module = parse(source).unwrap_or_else(|error| panic!("{name}: {error}"));
        let entry: Vec<_> =
            module.entry_points.iter().map(|entry| (entry.name.as_str(), entry.workgroup_size)).collect();
        assert_eq!(entry, [(name, [WORKGROUP, 1, 1])]);
    }
}

#[test]
fn a_stage_that_writes_what_it_may_only_read_is_found_invalid() {
    let source =
        SOURCES[0].1.replace("after[row * params.lanes + lane] =", "before[row * params.lanes + lane] =");
    assert_ne!(source, SOURCES[0].1);
    assert!(parse(&source).is_err());
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

fn assert_layout<const N: usize>(module: &Module, name: &str, fields: [(&'static str, u32); N]) {
    let expected: Vec<(String, u32)> =
        fields.iter().zip(0..).map(|(field, at)| (field.0.to_owned(), 4 * at)).collect();
    assert_eq!(members(module, name), (expected, 4 * N as u32), "{name}");
}

#[test]
fn structs_are_laid_out_as_rust_writes_them() {
    let module = parse(SOURCES[0].1).unwrap();
    assert_layout(&module, "Params", Params { sites: 1, lanes: 2, picks: 3, slot: 4 }.fields());
    let sites = sites::find(&media::tree(16, 3), usize::MAX);
    assert_layout(&module, "Site", layout::site_fields(&sites.domains[0], 0));
    assert_layout(&module, "Gain", layout::gain_fields(&Optics::paper().bands[0], 1));
}

#[test]
fn constants_are_those_of_rust() {
    let module = parse(SOURCES[0].1).unwrap();
    let value = |name: &str| {
        let found = module.constants.iter().find(|(_, constant)| constant.name.as_deref() == Some(name));
        let (_, constant) = found.unwrap_or_else(|| panic!("no constant {name}"));
        match module.global_expressions[constant.init] {
            naga::Expression::Literal(Literal::U32(value)) => f64::from(value),
            naga::Expression::Literal(Literal::F32(value)) => f64::from(value),
            ref other => panic!("{name}: {other:?}"),
        }
    };
    assert_eq!(value("WORKGROUP"), f64::from(WORKGROUP));
    assert_eq!(value("PARTS"), f64::from(PARTS));
    assert_eq!(value("MOVING"), flb_format::direction::MOVING as f64);
    assert_eq!(value("MIN_LOSS"), f64::from(MIN_LOSS));
}
