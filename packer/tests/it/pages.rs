//! What page tables say of pages: the error that each removes, and whose bytes it shares.

use crate::common::{pack, species, species_at};
use flb_format::container::records::*;
use flb_format::sample::{self, site_of};
use flb_format::{Codec, Container, Field, block};
use flb_packer::rate::Target;
use flb_packer::{EncodeSettings, StoredBlocks, copy_species, load_species, write_library_to};

fn squares(values: impl IntoIterator<Item = f32>) -> f64 {
    values.into_iter().map(|value| f64::from(value) * f64::from(value)).sum()
}

/// Squares of the texels of stored blocks of `a - b`.
fn difference(shared: &flb_format::blocks::Shared, a: &Field, b: &Field) -> f64 {
    let n = a.lattice as usize;
    let is_stored = |site: usize| shared.map.rank(site_of(site, a.lattice).map(|c| c / 4)).is_some();
    let near = (0..a.values().len()).filter(|i| is_stored(i % (n * n * n)));
    squares(near.map(|i| a.values()[i] - b.values()[i]))
}

fn assert_near(priority: f32, expected: f64, what: &str) {
    assert!(expected > 0.0, "{what}: nothing to compare");
    let ratio = f64::from(priority) / expected;
    assert!((0.999..1.001).contains(&ratio), "{what}: priority {priority}, the decoder says {expected}");
}

#[test]
fn the_priority_of_a_page_near_geometry_is_the_squared_error_that_a_decoder_sees_it_remove() {
    for codec in [Codec::Classed, Codec::Haar] {
        let target = Target::Psnr(60.0);
        let settings = EncodeSettings {
            codec,
            target,
            blocks: StoredBlocks::All,
            page_bytes: 20_480,
            ..EncodeSettings::papers()
        };
        let bytes = pack(&[species_at(32, "one", 3, &[0, 7])], &settings);
        let container = Container::open(&bytes).expect("the writer's own file opens");
        let shared = container.read_shared(&bytes, 0).expect("it has blocks");
        for base in &container.species()[0].bases {
            let mut read = container.read_averages(&bytes, 0, base.base, &shared).expect("it is there");
            let of_peak = f64::from(read.head().peak) * f64::from(read.head().peak);
            let detail = base.detail.expect("a base near geometry has detail");
            let mut before = read.field();
            let zeros = Field::zeros(before.lattice, before.bands);
            for page in container.pages(base.section) {
                assert_near(page.priority, difference(&shared, &before, &zeros) / of_peak, "averages");
            }
            assert!(container.pages(detail).len() > 1, "the test wants several pages");
            for (p, page) in (0u32..).zip(container.pages(detail)) {
                container.read_detail(&bytes, 0, base.base, p, &mut read).expect("it is there");
                let after = read.field();
                let removed = difference(&shared, &after, &before) / of_peak;
                assert_near(page.priority, removed, &format!("{} page {p}", codec.name()));
                before = after;
            }
        }
    }
}

#[test]
fn the_priority_of_other_pages_is_the_light_that_they_hold() {
    for codec in [Codec::RawF32, Codec::RawF16, Codec::HaarPaper] {
        let settings = EncodeSettings { codec, page_bytes: 20_480, ..EncodeSettings::papers() };
        let bytes = pack(&[species("one", 2, &[0, 7])], &settings);
        let container = Container::open(&bytes).expect("the writer's own file opens");
        for base in &container.species()[0].bases {
            let unit = if base.base == 0 { 18.0 * 18.0 } else { 1.0 };
            for (p, page) in (0u32..).zip(container.pages(base.section)) {
                let expected = if codec == Codec::HaarPaper {
                    let blocks = container.read_block_page(&bytes, base.section, p).expect("it is there");
                    let mut texels = [0.0; 2 * block::TEXELS];
                    let of_block = |b: usize| {
                        let (mask, coefficients) = blocks.block(b, 2);
                        block::decode(mask, coefficients, 2, &mut texels);
                        squares(texels)
                    };
                    (0..blocks.masks.len()).map(of_block).sum()
                } else {
                    squares(container.read_value_page(&bytes, base.section, p).expect("it is there"))
                };
                assert_near(page.priority, expected / unit, codec.name());
            }
        }
        let needed = |s: &&SectionEntry| matches!(s.key.kind, KIND_METADATA | KIND_MEDIUM);
        for (i, _) in container.sections().iter().enumerate().filter(|(_, s)| needed(s)) {
            assert!(container.pages(i).iter().all(|page| page.priority == 0.0), "read before any base");
        }
    }
}

#[test]
fn two_versions_of_a_species_store_what_is_the_same_in_both_once() {
    let settings = EncodeSettings { codec: Codec::RawF32, ..EncodeSettings::papers() };
    let first = species("first", 3, &[0, 4]);
    let mut second = species("second", 3, &[0, 4]);
    second.bases[1].1.values_mut().iter_mut().for_each(|value| *value *= 0.5); // base 0 and the medium stay
    let alone =
        [pack(std::slice::from_ref(&first), &settings), pack(std::slice::from_ref(&second), &settings)];
    let both = pack(&[first, second], &settings);
    let shared_bytes: usize = {
        let container = Container::open(&alone[0]).expect("it opens");
        let is_same = |key: SectionKey| key.kind == KIND_MEDIUM || key == base_key(0, 0);
        let same = container.sections().iter().filter(|section| is_same(section.key));
        same.map(|section| section.data_bytes as usize).sum()
    };
    let saved = alone[0].len() + alone[1].len() - both.len();
    assert!(saved >= shared_bytes, "{saved} bytes saved of {shared_bytes} that are the same");

    let container = Container::open(&both).expect("it opens");
    flb_format::container::verify::check_pages(&container, &both).expect("every page has its digest");
    flb_format::container::verify::check_padding(&container, &both).expect("no holes");
    flb_format::container::verify::check_root(&container, &both).expect("its root");
    let of = |key| container.sections().iter().position(|s| s.key == key).expect("it is there");
    let [base_of_first, base_of_second] = [0, 1].map(|species| of(base_key(species, 0)));
    assert_eq!(container.sections()[base_of_second].data_bytes, 0);
    let pairs = container.pages(base_of_first).iter().zip(container.pages(base_of_second));
    for (a, b) in pairs {
        assert_eq!((a.offset, a.stored_bytes), (b.offset, b.stored_bytes));
        assert_ne!(a.digest, b.digest, "a digest binds a page to its species");
    }
    for (i, alone) in alone.iter().enumerate() {
        let by_itself = Container::open(alone).expect("it opens");
        let field = |c: &Container, bytes: &Vec<u8>, species, base| {
            c.read_field(bytes, species, base).expect("it is there")
        };
        for base in [0, 4] {
            assert!(field(&container, &both, i, base) == field(&by_itself, alone, 0, base), "base {base}");
        }
        // Copied out of the library again, the species has all its pages.
        let copied = copy_species(&container, &both, i).expect("it can be copied");
        let mut bytes = Vec::new();
        write_library_to(&mut bytes, &[&copied]).expect("a sound library");
        assert!(bytes == *alone, "species {i} is another after it was in a library");
    }
}

fn base_key(species: u32, item: u32) -> SectionKey {
    SectionKey { kind: KIND_BASE, species, item }
}

#[test]
fn haar_paper_near_geometry_reads_as_all_blocks_do_at_matter_and_is_smaller() {
    let fields = species_at(64, "one", 3, &[0, 7]);
    let of = |blocks| {
        let settings = EncodeSettings { blocks, ..EncodeSettings::papers() };
        let bytes = pack(std::slice::from_ref(&fields), &settings);
        let container = Container::open(&bytes).expect("the writer's own file opens");
        let read = load_species(&container, &bytes, 0).expect("it has all its bases");
        (bytes.len(), read)
    };
    let (all_bytes, all) = of(StoredBlocks::All);
    let (near_bytes, near) = of(StoredBlocks::NearGeometry);
    assert!(2 * near_bytes < all_bytes, "{near_bytes} of {all_bytes}");
    let n = fields.meta.grid.lattice as usize;
    let matter: Vec<usize> = (0..n.pow(3)).filter(|&site| fields.medium.density[site] > 0.0).collect();
    assert!(!matter.is_empty());
    let mut away = 0;
    for ((_, all), (_, near)) in all.bases.iter().zip(&near.bases) {
        for &site in &matter {
            let at = [site % n, site / n % n, site / (n * n)].map(|c| c as f64);
            for offset in [0.0, 0.3, 0.5, 0.99] {
                let [mut whole, mut part] = [[0.0; 3]; 2];
                sample::trilinear(all, at.map(|c| c + offset), &mut whole);
                sample::trilinear(near, at.map(|c| c + offset), &mut part);
                assert_eq!(whole, part, "{at:?} + {offset}");
            }
        }
        away += near.values().iter().filter(|value| **value == 0.0).count();
    }
    assert!(away > n.pow(3), "{away} texels without light");
}
