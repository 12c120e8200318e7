//! A CPU ray tracer that relights a mesh from an .flb file
