//! The WGSL by itself: no GPU needed.

use flb_format::ordinates::Ordinates;
use naga::proc::Layouter;
use naga::valid::{Capabilities, ValidationFlags, Validator};
use naga::{AddressSpace, Literal, Module, TypeInner};

use super::super::layout::{self, AXIS_MOMENTS, AXIS_WORDS, Params};
use super::super::stages::{PARTS, SOURCES};
use super::*;
use crate::gpu::buffers::WORKGROUP;

/// Storage buffers of a stage that WebGPU promises everywhere.
const MAX_STORAGE_BUFFERS: usize = 8;

fn parse(source: &str) -> Result<Module, String> {
    let module = naga::front::wgsl::parse_str(source).map_err(|error| error.emit_to_string(source))?;
    let mut validator = Validator::new(ValidationFlags::all(), Capabilities::empty());
    validator.validate(&module).map_err(|error| error.emit_to_string(source))?;
    Ok(module)
}

fn source_of(name: &str) -> &'static str {
    SOURCES.iter().find(|(stage, _)| *stage == name).unwrap().1
}

#[test]
fn every_stage_is_valid_has_its_workgroup_and_binds_what_webgpu_promises() {
    for (name, source) in SOURCES {
        let module = parse(source).unwrap_or_else(|error| panic!("{name}: {error}"));
        let entry: Vec<_> =
            module.entry_points.iter().map(|entry| (entry.name.as_str(), entry.workgroup_size)).collect();
        assert_eq!(entry, [(name, [WORKGROUP, 1, 1])]);
        let is_storage = |space| matches!(space, AddressSpace::Storage { .. });
        let buffers =
            module.global_variables.iter().filter(|(_, variable)| is_storage(variable.space)).count();
        assert!(buffers <= MAX_STORAGE_BUFFERS, "{name} binds {buffers} storage buffers");
    }
}

#[test]
fn a_stage_that_writes_what_it_may_only_read_is_found_invalid() {
    let source = source_of("mix_light").replace("light[at] = light[at]", "steps[at] = light[at]");
    assert_ne!(source, source_of("mix_light"));
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
    let module = parse(source_of("first")).unwrap();
    assert_layout(&module, "Params", Params { sites: 1, lanes: 2, moments: 3 }.fields());
    let medium = medium();
    let march = March::new(&medium, &medium.sites(), Ordinates::Lebedev50, 1);
    let axis = &march.axes[3];
    let (segments, slants, _) = axis.slanted_rays().next().unwrap();
    assert_layout(&module, "Segment", layout::segment_fields(&segments[0], 5));
    assert_layout(&module, "Slant", layout::slant_fields(&slants[0]));
    let (of_axis, size) = members(&module, "Axis");
    let places = [("direction", 0), ("index", 12), ("rays", 16), ("moments", 4 * AXIS_MOMENTS as u32)];
    assert_eq!(of_axis, places.map(|(name, at)| (name.to_owned(), at)));
    assert_eq!(size, 4 * AXIS_WORDS as u32);
    let words = layout::axis_words(axis, 3, 77);
    assert_eq!((words[..3].to_vec(), words[3], words[4]), (axis.direction.map(f32::to_bits).to_vec(), 3, 77));
    assert_eq!(words[AXIS_MOMENTS..][..9], axis.moments::<9>(1.0).map(f32::to_bits));
}

#[test]
fn offsets_are_signed_bytes_of_which_127_is_one() {
    let slant = super::super::super::march::Slant { depth: 0.5, length: 1.0, offset: [127, -127, 0] };
    let [_, _, (name, word)] = layout::slant_fields(&slant);
    // `unpack4x8snorm` takes the lowest byte for x.
    assert_eq!((name, word.to_le_bytes()), ("offset", [0x7f, 0x81, 0, 0]));
}

#[test]
fn constants_are_those_of_rust() {
    let module = parse(source_of("measure")).unwrap();
    let value = |name: &str| {
        let found = module.constants.iter().find(|(_, constant)| constant.name.as_deref() == Some(name));
        let (_, constant) = found.unwrap_or_else(|| panic!("no constant {name}"));
        match module.global_expressions[constant.init] {
            naga::Expression::Literal(Literal::U32(value)) => value,
            ref other => panic!("{name}: {other:?}"),
        }
    };
    assert_eq!([value("WORKGROUP"), value("PARTS")], [WORKGROUP, PARTS]);
}
