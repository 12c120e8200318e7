//! Rate control: the error that was asked for is the error that a reader finds, from the same bytes on any machine.

use std::sync::Arc;

use flb_format::blocks::{BlockMap, Classes, CodedBase, Coding, Shared};
use flb_format::sample::site_of;
use flb_format::{Field, sample};
use flb_packer::PackError;
use flb_packer::rate::{
    BasePayloads, DetailCoding, RateSettings, SLACK_DB, SpeciesPayloads, Target, code_harmonics, code_species,
};
use flb_packer::surface::{POINTS_PER_SITE, surface_point};

/// Sites along an edge.
const LATTICE: u32 = 32;
const SITES: usize = (LATTICE as usize).pow(3);

const SETTINGS: RateSettings = RateSettings {
    coding: DetailCoding::Classed,
    target: Target::Psnr(45.0),
    all_blocks: false,
    page_bytes: 20_480,
};

fn at(site: usize) -> [f64; 3] {
    site_of(site, LATTICE).map(f64::from)
}

/// Two crowns with gaps in them.
fn non_empty() -> Vec<bool> {
    let inside = |site: usize| {
        let [x, y, z] = at(site);
        let ball = |c: [f64; 3], r: f64| {
            (x - c[0]) * (x - c[0]) + (y - c[1]) * (y - c[1]) + (z - c[2]) * (z - c[2]) < r * r
        };
        (ball([10.0, 14.0, 12.0], 7.0) || ball([20.0, 20.0, 18.0], 5.0)) && site % 7 != 3
    };
    (0..SITES).map(inside).collect()
}

/// Light that fades into the crowns from one side, with grain, in `bands` bands of one hue.
fn field(seed: u64, bands: u32) -> Field {
    let mut field = Field::zeros(LATTICE, bands);
    for band in 0..bands as usize {
        for site in 0..SITES {
            let [x, y, z] = at(site);
            let grain = (site as u64 + 7 * seed).wrapping_mul(0x9E37_79B9_7F4A_7C15) >> 40;
            let depth = (x * (1 + seed % 3) as f64 + y + 0.5 * z) / 30.0;
            let light = libm::exp(-depth) * (1.0 + 0.1 * grain as f64 / (1 << 24) as f64);
            let hue = 1.0 - 0.2 * band as f64 * (1.0 - libm::exp(-0.3 * depth));
            field.values_mut()[band * SITES + site] = (light * hue) as f32;
        }
    }
    field
}

fn code(fields: &[Field], settings: &RateSettings) -> Result<SpeciesPayloads, PackError> {
    let bases: Vec<(u8, &Field)> = (0..).zip(fields).collect();
    code_species(LATTICE, non_empty()[..].into(), &bases, settings)
}

fn shared(species: &SpeciesPayloads) -> Arc<Shared> {
    Arc::new(Shared {
        map: BlockMap::from_bytes(&species.map, LATTICE).expect("a map"),
        coding: match &species.classes {
            Some(bytes) => Coding::Classed(Classes::from_bytes(bytes).expect("class tables")),
            None => Coding::Haar,
        },
    })
}

fn read(shared: &Arc<Shared>, base: &BasePayloads) -> CodedBase {
    let mut bytes = base.head.to_bytes();
    bytes.extend(&base.averages);
    let mut read = CodedBase::from_bytes(shared, base.head.bands, &bytes).expect("a base");
    for page in &base.pages {
        read.add(page.first, page.count, &page.payload).expect("a page");
    }
    assert!(read.is_whole());
    read
}

/// PSNR of the samples at surfaces, and the 99th percentile of the relative error of the darkest tenth.
fn measured(field: &Field, base: &CodedBase) -> (f64, f64) {
    let bands = field.bands as usize;
    let (mut truth, mut coded) = (vec![0.0f32; bands], vec![0.0f32; bands]);
    let (mut square, mut peak, mut points) = (0.0, 0.0f32, Vec::new());
    for (site, _) in (0u32..).zip(non_empty()).filter(|(_, is)| *is) {
        for k in 0..POINTS_PER_SITE {
            let point = surface_point(site, k, LATTICE);
            sample::trilinear(field, point, &mut truth);
            base.sample(point, &mut coded);
            let norm = |v: &mut dyn Iterator<Item = f64>| v.map(|v| v * v).sum::<f64>();
            let error = norm(&mut truth.iter().zip(&coded).map(|(a, b)| f64::from(a - b)));
            points.push((norm(&mut truth.iter().map(|v| f64::from(*v))), error));
            square += error;
            peak = truth.iter().fold(peak, |p, v| p.max(v.abs()));
        }
    }
    points.sort_by(|a, b| a.0.total_cmp(&b.0));
    let db = -10.0 * libm::log10(square / (points.len() * bands) as f64 / f64::from(peak * peak));
    points.truncate(points.len().div_ceil(10));
    let mut dark: Vec<f64> = points.iter().map(|(light, error)| libm::sqrt(error / light)).collect();
    dark.sort_by(f64::total_cmp);
    (db, dark[(dark.len() - 1) * 99 / 100])
}

/// What f32 in another order of sums may change of a measured error.
const MEASURE_DB: f64 = 0.01;

/// How much better than its target the better side of a jump is in these small fields: mean errors hardly jump, but a
/// percentile of few points does.
const MEAN_JUMP_DB: f64 = 1.0;
const DARK_JUMP_DB: f64 = 6.0;

/// Whether a base that is so many decibels better than its target meets it.
fn is_met(off: f64, jump: f64) -> bool {
    (-SLACK_DB - MEASURE_DB..=jump + MEASURE_DB).contains(&off)
}

#[test]
fn every_base_has_the_error_that_was_asked_for() {
    let fields = [field(1, 3), field(2, 3), field(3, 3)];
    for coding in [DetailCoding::Classed, DetailCoding::Haar] {
        let mut last = 0;
        for db in [30.0, 40.0, 50.0] {
            let settings = RateSettings { coding, target: Target::Psnr(db), ..SETTINGS };
            let species = code(&fields, &settings).expect("a target in reach");
            let shared = shared(&species);
            for (base, field) in species.bases.iter().zip(&fields) {
                let (found, dark) = measured(field, &read(&shared, base));
                assert!(is_met(found - db, MEAN_JUMP_DB), "{coding:?}: {found} dB, expected {db}");
                let written = -20.0 * libm::log10(f64::from(base.head.rms_error));
                assert!((written - found).abs() <= MEASURE_DB, "{written} dB in the head, {found} found");
                let off = 20.0 * libm::fabs(libm::log10(dark / f64::from(base.head.dark_error)));
                assert!(off <= MEASURE_DB, "{} in the head, {dark} found", base.head.dark_error);
            }
            assert!(species.bytes() > last, "{db} dB takes {} bytes, less {last}", species.bytes());
            last = species.bytes();
        }
    }
}

#[test]
fn the_darkest_tenth_has_the_relative_error_that_was_asked_for() {
    let fields = [field(1, 3), field(5, 2)];
    for coding in [DetailCoding::Classed, DetailCoding::Haar] {
        for share in [0.1, 0.03] {
            let settings = RateSettings { coding, target: Target::Relative(share), ..SETTINGS };
            let species = code(&fields, &settings).expect("a target in reach");
            let shared = shared(&species);
            for (base, field) in species.bases.iter().zip(&fields) {
                let (_, dark) = measured(field, &read(&shared, base));
                let off = -20.0 * libm::log10(dark / share);
                assert!(is_met(off, DARK_JUMP_DB), "{coding:?}: {dark}, expected {share}");
                assert!(base.head.thresholds[0] > 0, "dark blocks are finer");
            }
        }
    }
}

#[test]
fn of_two_errors_asked_for_both_are_met_and_one_is_not_better() {
    let fields = [field(1, 3), field(5, 3)];
    for relative in [0.2, 0.02] {
        let settings = RateSettings { target: Target::Both { psnr_db: 40.0, relative }, ..SETTINGS };
        let species = code(&fields, &settings).expect("a target in reach");
        let shared = shared(&species);
        for (base, field) in species.bases.iter().zip(&fields) {
            let (db, dark) = measured(field, &read(&shared, base));
            let off = (db - 40.0).min(-20.0 * libm::log10(dark / relative));
            assert!(is_met(off, DARK_JUMP_DB), "{db} dB and {dark}, expected 40 dB and {relative}");
        }
    }
}

/// Light of suns in terms of their direction: the mean, and a slope along x and one along z that cross 0.
fn harmonics() -> Vec<Field> {
    let mut terms = vec![field(1, 3), field(1, 3), field(2, 3)];
    for (site, [x, z]) in (0..SITES).map(|site| (site, [at(site)[0], at(site)[2]])) {
        for band in 0..3 {
            terms[1].values_mut()[band * SITES + site] *= 0.4 * libm::sin(x / 5.0) as f32;
            terms[2].values_mut()[band * SITES + site] *= 0.02 * libm::cos(z / 3.0) as f32;
        }
    }
    terms
}

#[test]
fn light_of_suns_has_the_error_asked_for_though_its_terms_are_judged_together() {
    let ambient = field(3, 3);
    let terms = harmonics();
    let bases: Vec<(u8, &Field)> = (0..).zip(std::iter::once(&ambient).chain(&terms)).collect();
    let settings = RateSettings { target: Target::Psnr(40.0), ..SETTINGS };
    let code = |harmonics| code_harmonics(LATTICE, non_empty()[..].into(), &bases, harmonics, &settings);
    let species = code(3).expect("a target in reach");
    let shared = shared(&species);
    let read: Vec<CodedBase> = species.bases.iter().map(|base| read(&shared, base)).collect();
    assert!(is_met(measured(&ambient, &read[0]).0 - 40.0, MEAN_JUMP_DB), "the ambient light is by itself");
    // The mean over suns of the square error of their light is the sum of those of the terms.
    let peak = f64::from(species.bases[1].head.peak);
    let square = |(field, base): (&Field, &CodedBase)| {
        let own_peak = terms_peak(field);
        libm::exp10(-measured(field, base).0 / 10.0) * own_peak * own_peak / (peak * peak)
    };
    let squares: Vec<f64> = terms.iter().zip(&read[1..]).map(square).collect();
    let db = -10.0 * libm::log10(squares.iter().sum());
    assert!(is_met(db - 40.0, MEAN_JUMP_DB), "{db} dB");
    for (base, square) in species.bases[1..].iter().zip(&squares) {
        assert_eq!(
            (base.head.peak, base.head.unit),
            (species.bases[1].head.peak, species.bases[1].head.unit)
        );
        assert_eq!(base.head.thresholds, [0; 3]);
        let written = f64::from(base.head.rms_error);
        assert!(
            (written * written / square - 1.0).abs() < 0.01,
            "{written} in the head, {} found",
            square.sqrt()
        );
    }
    // A term that is hardly there takes fewer bytes for the same step.
    let detail = |base: usize| species.bases[base].pages.iter().map(|page| page.payload.len()).sum::<usize>();
    assert!(detail(3) < detail(1), "{} and {} bytes", detail(3), detail(1));
    // Terms of the near beam add to the light that errors are measured against.
    assert!(code(1).expect("a target in reach").bases[1].head.peak > species.bases[1].head.peak);
}

/// Largest magnitude of a sample at surfaces.
fn terms_peak(field: &Field) -> f64 {
    let mut out = [0.0; 3];
    let mut peak = 0.0f32;
    for (site, _) in (0u32..).zip(non_empty()).filter(|(_, is)| *is) {
        for k in 0..POINTS_PER_SITE {
            sample::trilinear(field, surface_point(site, k, LATTICE), &mut out);
            peak = out.iter().fold(peak, |peak, v| peak.max(v.abs()));
        }
    }
    f64::from(peak)
}

#[test]
fn the_largest_lattice_is_coded_to_its_target() {
    let n = 256usize;
    let at = |site: usize| site_of(site, n as u32).map(f64::from);
    let mut field = Field::zeros(n as u32, 1);
    // A shell around the middle, and a site in each of two corners.
    let non_empty: Vec<bool> = (0..n.pow(3))
        .map(|site| {
            let [x, y, z] = at(site).map(|c| c - 128.0);
            let radius = libm::sqrt(x * x + y * y + z * z);
            field.values_mut()[site] = libm::exp(0.01 * (y + 3.0 * libm::sin(x / 4.0))) as f32;
            (radius - 90.0).abs() < 2.0 || site == 0 || site == n.pow(3) - 1
        })
        .collect();
    let species =
        code_species(n as u32, non_empty[..].into(), &[(0, &field)], &SETTINGS).expect("a target in reach");
    let shared = Shared {
        map: BlockMap::from_bytes(&species.map, n as u32).expect("a map"),
        coding: Coding::Classed(
            Classes::from_bytes(species.classes.as_ref().expect("classes")).expect("tables"),
        ),
    };
    let read = read(&Arc::new(shared), &species.bases[0]);
    let (mut square, mut peak, mut points) = (0.0f64, 0.0f32, 0u32);
    let (mut truth, mut coded) = ([0.0f32], [0.0f32]);
    for (site, _) in (0u32..).zip(&non_empty).filter(|(_, is)| **is) {
        for k in 0..POINTS_PER_SITE {
            let point = surface_point(site, k, n as u32);
            sample::trilinear(&field, point, &mut truth);
            read.sample(point, &mut coded);
            square += f64::from((truth[0] - coded[0]) * (truth[0] - coded[0]));
            peak = peak.max(truth[0]);
            points += 1;
        }
    }
    let db = -10.0 * libm::log10(square / f64::from(points) / f64::from(peak * peak));
    assert!(is_met(db - 45.0, MEAN_JUMP_DB), "{db} dB");
}

#[test]
fn any_number_of_threads_gives_the_same_bytes() {
    let fields = [field(1, 3), field(2, 1), field(3, 5)];
    for coding in [DetailCoding::Classed, DetailCoding::Haar] {
        let with = |threads: usize| {
            let pool = rayon::ThreadPoolBuilder::new().num_threads(threads).build().expect("threads");
            pool.install(|| code(&fields, &RateSettings { coding, ..SETTINGS }).expect("a target in reach"))
        };
        assert_eq!(with(1), with(3));
    }
}

#[test]
fn a_stray_sample_is_near_the_light_and_all_blocks_leave_none() {
    let fields = [field(1, 3)];
    let worst = |settings: &RateSettings| {
        let species = code(&fields, settings).expect("a target in reach");
        let shared = shared(&species);
        let decoded = read(&shared, &species.bases[0]).field();
        let (decoded, original) = (decoded.values(), fields[0].values());
        let errors = decoded.iter().zip(original.iter()).map(|(a, b)| (a - b).abs());
        (species.bytes(), errors.fold(0.0, f32::max))
    };
    let (near_bytes, near) = worst(&SETTINGS);
    let (all_bytes, all) = worst(&RateSettings { all_blocks: true, ..SETTINGS });
    assert!(all_bytes > near_bytes);
    // At most the fall of light from a corner, 1.1, to the first coarse average 8 sites along each axis.
    assert!(near < 1.1 - libm::expf(-(2.0 + 1.0 + 0.5) * 8.0 / 30.0), "{near}");
    assert!(all < 0.1 && all < near, "{all}");
}

#[test]
fn pages_hold_what_they_may_and_cover_the_map() {
    let settings = RateSettings { page_bytes: 128, ..SETTINGS };
    let species = code(&[field(1, 3)], &settings).expect("a target in reach");
    let pages = &species.bases[0].pages;
    assert!(pages.len() > 2);
    let mut next = 0;
    for page in pages {
        assert_eq!(page.first, next);
        next += page.count;
        assert!(page.payload.len() <= 128, "{} bytes", page.payload.len());
    }
    assert_eq!(next as usize, shared(&species).map.len());
}

#[test]
fn darkness_takes_next_to_nothing() {
    let species = code(&[Field::zeros(LATTICE, 3)], &SETTINGS).expect("darkness has no error");
    let shared = shared(&species);
    assert!(read(&shared, &species.bases[0]).field().values().iter().all(|v| *v == 0.0));
}

/// Values without order.
fn noise() -> Field {
    let mut field = Field::zeros(LATTICE, 1);
    for (i, value) in (1u64..).zip(field.values_mut()) {
        let hash = i.wrapping_mul(0x9E37_79B9_7F4A_7C15);
        *value = ((hash ^ (hash >> 29)).wrapping_mul(0xBF58_476D_1CE4_E5B9) >> 40) as f32 / (1 << 24) as f32;
    }
    field
}

#[test]
fn a_target_out_of_reach_is_named_and_the_nearest_that_was_found_is_coded() {
    let settings = RateSettings { target: Target::Psnr(80.0), ..SETTINGS };
    let species = code(&[noise(), Field::zeros(LATTICE, 1)], &settings).expect("it is coded");
    let [missed] = species.missed[..] else { panic!("{:?}", species.missed) };
    let text = missed.to_string();
    assert!(
        text.starts_with("base 0 has ")
            && text.ends_with("in dark places, expected 80 dB")
            && missed.is_loss(),
        "{text}"
    );
    let (found, _) = measured(&noise(), &read(&shared(&species), &species.bases[0]));
    assert!((found - missed.psnr_db).abs() < MEASURE_DB && found > 40.0, "{found} dB: {text}");
}

#[test]
fn what_cannot_be_coded_is_refused() {
    let refused = |settings: RateSettings, edit: &dyn Fn(&mut Field)| {
        let mut field = field(1, 3);
        edit(&mut field);
        code(&[field], &settings).map(|coded| coded.bytes()).expect_err("it should be refused").to_string()
    };
    let target = |target| refused(RateSettings { target, ..SETTINGS }, &|_| ());
    assert_eq!(target(Target::Psnr(f64::NAN)), "the target PSNR is NaN dB, expected 10 to 80 dB");
    assert_eq!(target(Target::Psnr(90.0)), "the target PSNR is 90 dB, expected 10 to 80 dB");
    assert_eq!(target(Target::Relative(0.0)), "the target relative error is 0, expected 0.005 to 0.5");
    let shape = refused(SETTINGS, &|field| field.bands = 2);
    assert_eq!(shape, "a field is base 0 of 2 bands and 98304 values, expected 1 to 64 bands of N^3 values");
    let value = refused(SETTINGS, &|field| field.values_mut()[SITES + 5] = f32::INFINITY);
    assert!(
        value.contains("band 1, site 5: value inf, expected a finite number of magnitude up to 2^96"),
        "{value}"
    );
    let dim = refused(SETTINGS, &|field| {
        let occupied = non_empty();
        // A site that no sample reads, in a stored block.
        let far = (0..SITES).find(|s| at(*s) == [10.0, 14.0, 4.0]).expect("a site");
        assert!(!occupied[far]);
        field.values_mut()[far] = 1e12;
    });
    assert!(
        dim.starts_with("the light near surfaces is ") && dim.ends_with("expected up to 16,000 times"),
        "{dim}"
    );
    assert!(matches!(code(&[], &SETTINGS), Err(PackError::Empty)));
    let error =
        code_species(24, [][..].into(), &[(0, &field(1, 3))], &SETTINGS).expect_err("a lattice of 24");
    assert_eq!(
        error.to_string(),
        "the number of sites is 0 for a lattice of 24, expected N^3, N a power of two from 16 to 256"
    );
}
