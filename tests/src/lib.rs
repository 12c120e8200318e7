//! Whole-pipeline tests
