//! Libraries for the tests of streaming, opened here: of [`Library`], `flb_testkit` would know another build.

use std::collections::BTreeMap;
use std::sync::{Arc, Mutex};

use flb_format::{Codec, SpeciesFields};
pub(crate) use flb_testkit::plants::*;

use crate::Library;

/// An open library in memory.
pub(crate) fn library(plants: &[SpeciesFields], codec: Codec) -> Arc<Library> {
    opened(bytes(plants, codec))
}

fn opened(bytes: Vec<u8>) -> Arc<Library> {
    Arc::new(Library::from_source("plants.flb", Box::new(bytes)).expect("it opens"))
}

/// The bytes of [`three`], coded once for all tests.
pub(crate) fn bytes_of_three(codec: Codec) -> Vec<u8> {
    static CODED: Mutex<BTreeMap<&str, Vec<u8>>> = Mutex::new(BTreeMap::new());
    let mut coded = CODED.lock().expect("these are good fields");
    coded.entry(codec.name()).or_insert_with(|| bytes(&three(), codec)).clone()
}

/// [`three`], each time opened anew.
pub(crate) fn library_of_three(codec: Codec) -> Arc<Library> {
    opened(bytes_of_three(codec))
}
