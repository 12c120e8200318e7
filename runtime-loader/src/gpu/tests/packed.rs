//! The words that a species of the default kind is packed into, which shaders read; packing needs no adapter. Golden:
//! numbers that change are a change of the product.

use flb_format::container::digest::plain;

use super::super::layout::{self, SpeciesPlaces};
use super::super::pack::pack_page;
use crate::Library;
use crate::extinction::Extinction;

/// A file of the kind that `flb bake` makes by default, but small.
const SHRUB: &str = concat!(env!("CARGO_MANIFEST_DIR"), "/golden/shrub.flb");

/// Of each kind of words. The species tells of its map at word 1 and its extinction at word 2, bases of records at 3
/// and coarse averages at 4; nibbles begin at word 5.
const GOLDEN: &str = "species: 12 words, 7cd2fe88c1edae37
map: 4 words, 5a3aa18f3472d058
extinction: 1146 words, b15e7bed00e79f3e
bases: 208 words, 9c96f583c84ad9e4
coarse: 13 words, 56166c1edbe0c6a8
records: 1612 words, a4773fb7f61767be
nibbles: 1256 words, fe458c83b3326a35
";

/// How many, and xxh3 of them.
fn line(name: &str, words: &[u32]) -> String {
    let bytes: Vec<u8> = words.iter().flat_map(|word| word.to_le_bytes()).collect();
    format!("{name}: {} words, {:016x}\n", words.len(), plain(&bytes))
}

#[test]
fn words_of_the_default_kind_are_golden() {
    let library = Library::open(SHRUB).expect("a file of this crate");
    let (container, source) = (library.container(), library.source());
    let entry = &container.species()[0];
    let shared = container.read_shared(source, 0).expect("coded near geometry");
    let turbid = container.read_turbid(source, 0).expect("of the default model");
    let places = SpeciesPlaces { map: 1, extinction: 2, single: true, sky: [3, 4] };
    let mut found = line("species", &layout::species_words(&entry.meta.grid, &shared, places));
    found += &line("map", &layout::map_words(&shared.map));
    found += &line("extinction", &layout::extinction_words(&Extinction::of(&turbid)));
    let (mut heads, mut coarse, mut records, mut nibbles) = (Vec::new(), Vec::new(), Vec::new(), Vec::new());
    for base in entry.bases.iter().map(|entry| entry.base) {
        let coded = container.read_coded_base(source, 0, base, &shared).expect("a good file");
        heads.extend(layout::base_words(&coded, 3, 4));
        coarse.extend(layout::coarse_words(&coded));
        let mut page = pack_page(&coded, 0, shared.map.len());
        page.place(coded.head().components(), 5);
        records.extend(page.records);
        nibbles.extend(page.nibbles);
    }
    for (name, words) in [("bases", heads), ("coarse", coarse), ("records", records), ("nibbles", nibbles)] {
        found += &line(name, &words);
    }
    assert_eq!(found, GOLDEN);
}
