//! What tests ask of WGSL. No GPU is needed.

use naga::proc::Layouter;
use naga::valid::{Capabilities, ValidationFlags, Validator};
use naga::{Literal, Module, TypeInner};

use super::buffers::WORKGROUP;

/// Parses and validates.
pub(crate) fn parse(source: &str) -> Result<Module, String> {
    let module = naga::front::wgsl::parse_str(source).map_err(|error| error.emit_to_string(source))?;
    let mut validator = Validator::new(ValidationFlags::all(), Capabilities::empty());
    validator.validate(&module).map_err(|error| error.emit_to_string(source))?;
    Ok(module)
}

/// Parses a stage, whose one entry point has its name and workgroups of [`WORKGROUP`].
pub(crate) fn parse_stage(name: &str, source: &str) -> Module {
    let module = parse(source).unwrap_or_else(|error| panic!("{name}: {error}"));
    let entry: Vec<_> =
        module.entry_points.iter().map(|entry| (entry.name.as_str(), entry.workgroup_size)).collect();
    assert_eq!(entry, [(name, [WORKGROUP, 1, 1])]);
    module
}

/// Names and offsets of a struct's members, and its size.
pub(crate) fn members(module: &Module, name: &str) -> (Vec<(String, u32)>, u32) {
    let mut layouter = Layouter::default();
    layouter.update(module.to_ctx()).unwrap();
    let found = module.types.iter().find(|(_, ty)| ty.name.as_deref() == Some(name));
    let (handle, ty) = found.unwrap_or_else(|| panic!("no struct {name}"));
    let TypeInner::Struct { members, .. } = &ty.inner else { panic!("{name} is no struct") };
    let members = members.iter().map(|member| (member.name.clone().unwrap(), member.offset));
    (members.collect(), layouter[handle].to_stride())
}

/// Holds a struct against the words that Rust writes for it.
pub(crate) fn assert_layout<const N: usize>(module: &Module, name: &str, fields: [(&'static str, u32); N]) {
    let expected: Vec<(String, u32)> =
        fields.iter().zip(0..).map(|(field, at)| (field.0.to_owned(), 4 * at)).collect();
    assert_eq!(members(module, name), (expected, 4 * N as u32), "{name}");
}

/// The value of a constant.
pub(crate) fn constant(module: &Module, name: &str) -> f64 {
    let found = module.constants.iter().find(|(_, constant)| constant.name.as_deref() == Some(name));
    let (_, constant) = found.unwrap_or_else(|| panic!("no constant {name}"));
    match module.global_expressions[constant.init] {
        naga::Expression::Literal(Literal::U32(value)) => f64::from(value),
        naga::Expression::Literal(Literal::F32(value)) => f64::from(value),
        ref other => panic!("{name}: {other:?}"),
    }
}
