//! Kinds 44 and 58: numbers that are none, and payloads that lie behind digests that are all sound.

use super::{Cases, PASSES};
use crate::Codec;

pub(super) fn cases(cases: &mut Cases) {
    area(cases);
    density(cases);
    let base = cases.subject.container.species()[0].bases[0];
    match base.codec {
        Codec::RawF32 => FLOATS.iter().for_each(|n| value(cases, base.section, n, &n.3.to_le_bytes())),
        Codec::RawF16 => HALVES.iter().for_each(|n| value(cases, base.section, n, &n.3.to_le_bytes())),
        Codec::HaarPaper => haar_paper(cases, base.section),
        Codec::Classed | Codec::Haar => blocks(cases),
    }
}

/// Label, what it is, code, bits.
type Number<T> = (&'static str, &'static str, u32, T);

const FLOATS: [Number<u32>; 6] = [
    ("nan", "NaN", 5006, 0x7FC0_0000),
    ("signalling-nan", "a signalling NaN", 5006, 0x7F80_0001),
    ("inf", "infinity", 5006, 0x7F80_0000),
    ("minus-0", "-0", 5006, 0x8000_0000),
    ("over-2-96", "2^97", 5006, 0x7000_0000),
    ("subnormal", "a subnormal number, which passes", PASSES, 1),
];

const HALVES: [Number<u16>; 4] = [
    ("nan", "NaN", 5006, 0x7E00),
    ("inf", "infinity", 5006, 0x7C00),
    ("minus-0", "-0", 5006, 0x8000),
    ("subnormal", "a subnormal number, which passes", PASSES, 1),
];

/// The leaf area density with one value, at its first site. Nothing else of a file depends on it.
fn area(cases: &mut Cases) {
    let area = cases.subject.area();
    let sites = cases.subject.container.sections()[area].units as usize;
    let payload = |masks: u64, values: &[u8]| {
        let mut payload = vec![0; sites / 8];
        payload[..8].copy_from_slice(&masks.to_le_bytes());
        payload.extend(values);
        payload
    };
    let more = [("zero", "0, which is stored without need", 5006, 0), ("minus-1", "-1", 5006, 0xBF80_0000)];
    for (label, what, code, bits) in FLOATS.into_iter().chain(more) {
        let done = format!("a leaf area density of {what}");
        let payload = payload(1, &u32::to_le_bytes(bits));
        cases.rebuild(44, &format!("area-{label}"), &done, code, |parts| parts.replace(area, &payload));
    }
    let one = 1f32.to_le_bytes();
    for (label, done, payload) in [
        ("fewer-values", "masks that promise a value more than there is", payload(3, &one)),
        ("more-values", "a value more than the masks promise", payload(0, &one)),
    ] {
        cases.rebuild(58, label, done, 4003, |parts| parts.replace(area, &payload));
    }
}

/// Density and class that speak of different sites.
fn density(cases: &mut Cases) {
    let [density, class, ..] = cases.subject.container.species()[0].medium;
    let sites = cases.subject.container.sections()[density].units as usize;
    let with_first = |value: &[u8]| {
        let mut payload = vec![0; sites / 8];
        payload[0] = 1;
        payload.extend(value);
        payload
    };
    let nothing = vec![0; sites / 8];
    let with = |density: f32| with_first(&density.to_le_bytes());
    let leaf = with_first(&[1]);
    for (label, done, densities, classes) in [
        ("class-without-density", "a site that is leaf and has no density", nothing.clone(), leaf.clone()),
        ("density-without-class", "a site that has a density and no class", with(0.5), nothing),
        ("density-above-1", "a density of 2", with(2.0), leaf),
    ] {
        cases.rebuild(58, label, done, 5008, |parts| {
            parts.replace(density, &densities);
            parts.replace(class, &classes);
        });
    }
    let classes = with_first(&[3]);
    cases.rebuild(58, "class-3", "a site of class 3", 5006, |parts| parts.replace(class, &classes));
}

/// A section's first page as its payload.
fn payload(cases: &Cases, section: usize) -> Vec<u8> {
    let subject = cases.subject;
    subject.container.read_page(&subject.file, section, 0).expect("the file was checked")
}

/// The first of plain values.
fn value<T>(cases: &mut Cases, section: usize, (label, what, code, _): &Number<T>, bytes: &[u8]) {
    let mut payload = payload(cases, section);
    payload[..bytes.len()].copy_from_slice(bytes);
    let done = format!("a value of {what} in the first base");
    cases
        .rebuild(44, &format!("base-{label}"), &done, *code, |parts| parts.set_payload(section, 0, &payload));
}

/// The first page: masks, indices, coefficients.
fn haar_paper(cases: &mut Cases, section: usize) {
    let good = payload(cases, section);
    let count = cases.subject.container.pages(section)[0].count as usize;
    let mut given = |kind, label: &str, done: &str, code: u32, payload: Vec<u8>| {
        cases.rebuild(kind, label, done, code, |parts| parts.set_payload(section, 0, &payload));
    };
    let mut index = good.clone();
    index[8 * count] ^= 1;
    given(58, "block-index", "the index of a block off by one", 5005, index);
    given(58, "page-too-long", "four bytes more than the masks promise", 4003, [&good[..], &[0; 4]].concat());
    // One block that keeps its average alone, all others nothing.
    let bands = cases.subject.container.sections()[section].bands as usize;
    let average = |value: f32| {
        let mut payload = vec![0; 12 * count];
        payload[0] = 1;
        (1..count).for_each(|block| payload[8 * count + 4 * block] = 1);
        payload.extend((0..bands).flat_map(|_| value.to_le_bytes()));
        payload
    };
    for (label, what, _, bits) in &FLOATS[..5] {
        let done = format!("a coefficient of {what} in the first base");
        let payload = average(f32::from_bits(*bits));
        cases.rebuild(44, &format!("base-{label}"), &done, 5006, |parts| {
            parts.set_payload(section, 0, &payload)
        });
    }
    let payload = average(0.0);
    cases.rebuild(58, "kept-without-need", "a coefficient of 0 that is stored", 5007, |parts| {
        parts.set_payload(section, 0, &payload);
    });
}

/// What the bases of blocks near geometry share, the head and averages of the first, its detail.
fn blocks(cases: &mut Cases) {
    let species = &cases.subject.container.species()[0];
    let (shared, base) = (species.blocks.expect("its codec says so"), species.bases[0]);
    let whole = |section: usize| {
        let subject = cases.subject;
        let page = |p| subject.container.read_page(&subject.file, section, p).expect("the file was checked");
        (0..subject.container.pages(section).len() as u32).flat_map(page).collect::<Vec<u8>>()
    };
    let (map, averages) = (whole(shared.map), whole(base.section));
    let tables = shared.classes.map(|section| (section, whole(section)));
    let detail = base.detail.expect("every such base has detail");
    let mut given = |kind, label: &str, done: &str, code: u32, section: usize, payload: Vec<u8>| {
        cases.rebuild(kind, label, done, code, |parts| parts.replace(section, &payload));
    };
    given(58, "empty-map", "a block map without a block", 5010, shared.map, vec![0; map.len()]);
    if let Some((section, tables)) = tables {
        let cut = tables[..tables.len() - 1].to_vec();
        given(58, "cut-tables", "class tables cut by a byte", 5011, section, cut);
        let mut wide = tables.clone();
        wide[4] = 0xFF;
        given(58, "wide-class", "a class of widths of 15 bits", 5011, section, wide);
    }
    for (label, what, _, bits) in &FLOATS[..5] {
        let mut head = averages.clone();
        head[4..8].copy_from_slice(&bits.to_le_bytes());
        given(44, &format!("unit-{label}"), &format!("a unit of {what} in a head"), 5012, base.section, head);
    }
    let longer = [&averages[..], &[0; 4]].concat();
    given(58, "averages-too-long", "four bytes more than the averages take", 5013, base.section, longer);
    let longer = [&payload(cases, detail)[..], &[0; 4]].concat();
    cases.rebuild(58, "detail-too-long", "four bytes more than a page of detail takes", 5014, |parts| {
        parts.set_payload(detail, 0, &longer);
    });
}
