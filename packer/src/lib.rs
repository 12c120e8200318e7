//! From fields to a published .flb file
