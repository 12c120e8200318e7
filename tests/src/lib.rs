//! Whole-pipeline tests of `flb`; see `tests/`. This crate's library holds what they share.
