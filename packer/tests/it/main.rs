//! What the packer writes of fields that are made from formulas.

mod common;

mod golden;
mod pages;
mod rate;
mod refusals;
