//! Libraries for the tests of streaming, opened here: of [`Library`], `flb_testkit` would know another build.

use std::sync::Arc;

use flb_format::Codec;
use flb_packer::SpeciesFields;
pub use flb_testkit::plants::*;

use crate::Library;

/// An open library in memory.
pub fn library(plants: &[SpeciesFields], codec: Codec) -> Arc<Library> {
    let bytes = bytes(plants, codec);
    Arc::new(Library::from_source("plants.flb", Box::new(bytes)).expect("it opens"))
}
