//! Kinds 44 and 58: numbers that are none, and payloads that lie behind digests that are all sound.

use flb_format::Codec;

use super::draft::Draft;
use super::{Cases, PASSES};

pub(super) fn cases(cases: &mut Cases) {
    area(cases);
    density(cases);
    let base = cases.subject.container.species()[0].bases[0];
    match base.codec {
        Codec::RawF32 => {
            values(cases, base.section, &FLOATS.map(|(l, d, c, v)| (l, d, c, v.to_le_bytes().to_vec())))
        }
        Codec::RawF16 => {
            values(cases, base.section, &HALVES.map(|(l, d, c, v)| (l, d, c, v.to_le_bytes().to_vec())))
        }
        Codec::HaarPaper => haar_paper(cases, base.section),
        Codec::Classed | Codec::Haar => blocks(cases),
    }
}

/// Label, what it is, code, bits.
type Number<T> = (&'static str, &'static str, Option<u32>, T);

const FLOATS: [Number<u32>; 6] = [
    ("nan", "NaN", Some(5006), 0x7FC0_0000),
    ("signalling-nan", "a signalling NaN", Some(5006), 0x7F80_0001),
    ("inf", "infinity", Some(5006), 0x7F80_0000),
    ("minus-0", "-0", Some(5006), 0x8000_0000),
    ("over-2-96", "2^97", Some(5006), 0x7000_0000),
    ("subnormal", "a subnormal number, which passes", PASSES, 1),
];

const HALVES: [Number<u16>; 4] = [
    ("nan", "NaN", Some(5006), 0x7E00),
    ("inf", "infinity", Some(5006), 0x7C00),
    ("minus-0", "-0", Some(5006), 0x8000),
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
    let more = [
        ("zero", "0, which is stored without need", Some(5006), 0),
        ("minus-1", "-1", Some(5006), 0xBF80_0000),
    ];
    for (label, what, code, bits) in FLOATS.into_iter().chain(more) {
        let done = format!("a leaf area density of {what}");
        let payload = payload(1, &u32::to_le_bytes(bits));
        cases.rebuild(44, &format!("area-{label}"), done, code, |draft| draft.replace(area, &payload));
    }
    let one = 1f32.to_le_bytes();
    for (label, done, payload) in [
        ("fewer-values", "masks that promise a value more than there is", payload(3, &one)),
        ("more-values", "a value more than the masks promise", payload(0, &one)),
    ] {
        cases.rebuild(58, label, done, 4003, |draft| draft.replace(area, &payload));
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
    for (label, done, densities, classes) in [
        (
            "class-without-density",
            "a site that is leaf and has no density",
            nothing.clone(),
            with_first(&[1]),
        ),
        (
            "density-without-class",
            "a site that has a density and no class",
            with_first(&0.5f32.to_le_bytes()),
            nothing,
        ),
        ("density-above-1", "a density of 2", with_first(&2f32.to_le_bytes()), with_first(&[1])),
    ] {
        cases.rebuild(58, label, done, 5008, |draft| {
            draft.replace(density, &densities);
            draft.replace(class, &classes);
        });
    }
    let classes = with_first(&[3]);
    cases.rebuild(58, "class-3", "a site of class 3", 5006, |draft| draft.replace(class, &classes));
}

/// A section's first page as its payload.
fn payload(cases: &Cases, section: usize) -> Vec<u8> {
    let subject = cases.subject;
    subject.container.read_page(&subject.file, section, 0).expect("the file was checked")
}

/// Gives a section's first page another payload, of as many units.
fn set_page(draft: &mut Draft, section: usize, payload: &[u8]) {
    let pages = draft.sections[section].pages.clone();
    let rest = &pages[1..];
    draft.sections[section].pages.truncate(1);
    draft.replace(section, payload);
    draft.sections[section].pages.extend_from_slice(rest);
}

/// Of plain values, the first.
fn values(cases: &mut Cases, section: usize, numbers: &[(&str, &str, Option<u32>, Vec<u8>)]) {
    let good = payload(cases, section);
    for (label, what, code, bytes) in numbers {
        let mut payload = good.clone();
        payload[..bytes.len()].copy_from_slice(bytes);
        let done = format!("a value of {what} in the first base");
        cases.rebuild(44, &format!("base-{label}"), done, *code, |draft| set_page(draft, section, &payload));
    }
}

/// The first page: masks, indices, coefficients.
fn haar_paper(cases: &mut Cases, section: usize) {
    let good = payload(cases, section);
    let count = cases.subject.container.pages(section)[0].count as usize;
    let mut given = |kind, label: &str, done: &str, code: u32, payload: Vec<u8>| {
        cases.rebuild(kind, label, done, code, |draft| set_page(draft, section, &payload));
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
        cases.rebuild(44, &format!("base-{label}"), done, 5006, |draft| set_page(draft, section, &payload));
    }
    let payload = average(0.0);
    cases.rebuild(58, "kept-without-need", "a coefficient of 0 that is stored", 5007, |draft| {
        set_page(draft, section, &payload);
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
        cases.rebuild(kind, label, done, code, |draft| draft.replace(section, &payload));
    };
    given(58, "empty-map", "a block map without a block", 5010, shared.map, vec![0; map.len()]);
    if let Some((section, tables)) = tables {
        given(
            58,
            "cut-tables",
            "class tables cut by a byte",
            5011,
            section,
            tables[..tables.len() - 1].to_vec(),
        );
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
    cases.rebuild(58, "detail-too-long", "four bytes more than a page of detail takes", 5014, |draft| {
        set_page(draft, detail, &longer);
    });
}
