//! Load .flb files and sample their light
