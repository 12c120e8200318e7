//! The WGSL by itself: no GPU needed.

use flb_format::ordinates::Ordinates;
use naga::AddressSpace;

use super::super::layout::{self, AXIS_MOMENTS, AXIS_WORDS, Params};
use super::super::stages::{PARTS, SOURCES};
use super::*;
use crate::gpu::buffers::WORKGROUP;
use crate::gpu::wgsl::{assert_layout, constant, members, parse, parse_stage};

/// Storage buffers of a stage that WebGPU promises everywhere.
const MAX_STORAGE_BUFFERS: usize = 8;

fn source_of(name: &str) -> &'static str {
    SOURCES.iter().find(|(stage, _)| *stage == name).unwrap().1
}

#[test]
fn every_stage_is_valid_has_its_workgroup_and_binds_what_webgpu_promises() {
    for (name, source) in SOURCES {
        let module = parse_stage(name, source);
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

#[test]
fn structs_are_laid_out_as_rust_writes_them() {
    let module = parse(source_of("first")).unwrap();
    assert_layout(&module, "Params", Params { sites: 1, lanes: 2, moments: 3 }.fields());
    let medium = medium();
    let march = March::new(&medium, &medium.sites(), Ordinates::Lebedev50, 1);
    let axis = &march.axes[3];
    let (segments, slants, _) = axis.slanted_rays().next().unwrap();
    let matter = layout::matter_fields([0.1, 0.2, 0.3], 0.4, 0.5);
    assert_layout(&parse(source_of("step_to")).unwrap(), "Matter", matter);
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
    let value = |name: &str| constant(&module, name);
    assert_eq!([value("WORKGROUP"), value("PARTS")], [WORKGROUP, PARTS].map(f64::from));
}
