//! The WGSL by itself: no GPU needed.

use super::super::super::sites;
use super::super::super::sweep::MIN_LOSS;
use super::super::layout::{self, Params};
use super::super::stages::{PARTS, SOURCES};
use super::*;
use crate::gpu::buffers::WORKGROUP;
use crate::gpu::wgsl::{assert_layout, constant, parse, parse_stage};

#[test]
fn every_stage_is_valid_and_has_its_workgroup() {
    for (name, source) in SOURCES {
        parse_stage(name, source);
    }
}

#[test]
fn a_stage_that_writes_what_it_may_only_read_is_found_invalid() {
    let source =
        SOURCES[0].1.replace("after[row * params.lanes + lane] =", "before[row * params.lanes + lane] =");
    assert_ne!(source, SOURCES[0].1);
    assert!(parse(&source).is_err());
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
    let value = |name: &str| constant(&module, name);
    assert_eq!(value("WORKGROUP"), f64::from(WORKGROUP));
    assert_eq!(value("PARTS"), f64::from(PARTS));
    assert_eq!(value("MOVING"), flb_format::direction::MOVING as f64);
    assert_eq!(value("MIN_LOSS"), f64::from(MIN_LOSS));
}
