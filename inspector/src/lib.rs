//! Inspect, validate, diff and extract .flb files
