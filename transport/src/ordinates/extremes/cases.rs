//! The table of extremes.

use flb_format::matter::{INCLINATIONS, LeafAngles, TurbidMedium};

use super::super::{FieldKind, Ordinates, OrdinatesSettings, SunBasis, ico12, ico42};
use super::Case;
use super::media::{ALL, N, filled, hollow, solid, tree};
use crate::ends::End;
use crate::turbid::{BandScatter, Phase, Scatter};

/// One unit in the last place inside 1.
const INSIDE: f64 = 1.0 - f64::EPSILON / 2.0;
const OUTSIDE: f64 = 1.0 + f64::EPSILON;

/// All cases, in the order of the table.
pub fn cases() -> Vec<Case> {
    [depths(), albedos(), angles(), bodies(), bands(), suns(), marches(), refusals()]
        .into_iter()
        .flatten()
        .collect()
}

/// Leaf of a reflectance and a transmittance, and green wood.
fn leaf(reflectance: f64, transmittance: f64) -> BandScatter {
    let albedo = reflectance + transmittance;
    let transmitted = if albedo > 0.0 { transmittance / albedo } else { 0.5 };
    BandScatter {
        leaf: Scatter { albedo, phase: Phase::BiLambert { transmitted } },
        wood: Scatter { albedo: 0.123, phase: Phase::BiLambert { transmitted: 0.0 } },
    }
}

fn green() -> BandScatter {
    leaf(0.125, 0.15)
}

/// Wood and leaf that absorb nothing.
fn white() -> BandScatter {
    let wood = Scatter { albedo: 1.0, phase: Phase::BiLambert { transmitted: 0.0 } };
    BandScatter { wood, ..leaf(0.5, 0.5) }
}

fn settings() -> OrdinatesSettings {
    OrdinatesSettings {
        suns: SunBasis::Lattice18,
        ordinates: Ordinates::Lebedev50,
        ..OrdinatesSettings::default()
    }
}

fn case(name: &'static str, medium: TurbidMedium, scatter: BandScatter) -> Case {
    Case { name, medium, bands: vec![scatter], settings: settings(), end: End::Converges }
}

fn depths() -> Vec<Case> {
    let all = |name, depth| case(name, solid(ALL, depth), green());
    vec![
        case("a tree, green light", tree(), green()),
        case("no matter", solid(ALL, 0.0), green()),
        all("optical depth the smallest subnormal a site", f64::from(f32::from_bits(1)) / 2.0),
        all("optical depth the smallest normal a site", f64::from(f32::MIN_POSITIVE)),
        all("optical depth 1e-6 a site", 1e-6),
        all("optical depth 1e-3 a site", 1e-3),
        all("optical depth 0.03 a site", 0.03),
        all("optical depth 1 a site", 1.0),
        all("optical depth 30 a site", 30.0),
        all("optical depth 1e4 a site", 1e4),
        all("the largest extinction", f64::from(f32::MAX) / 2.0),
    ]
}

fn albedos() -> Vec<Case> {
    let of = |name, reflectance, transmittance| case(name, tree(), leaf(reflectance, transmittance));
    vec![
        of("leaves absorb all", 0.0, 0.0),
        of("leaves scatter next to nothing", f64::from_bits(1), 0.0),
        of("leaves reflect alone", 0.5, 0.0),
        of("leaves transmit alone", 0.0, 0.5),
        of("leaves reflect all", 1.0, 0.0),
        of("leaves transmit all", 0.0, 1.0),
        of("leaf albedo one ulp below 1", INSIDE / 2.0, 0.5),
        case("leaves and wood absorb nothing", tree(), white()),
        case("depth 1e-3 a site, no absorption", solid(ALL, 1e-3), white()),
        case("depth 1 a site, no absorption", solid(ALL, 1.0), white()),
        case("depth 30 a site, no absorption", solid(ALL, 30.0), white()),
        case("depth 1e4 a site, no absorption", solid(ALL, 1e4), white()),
    ]
}

fn angles() -> Vec<Case> {
    let infrared = || leaf(0.45, 0.45);
    let leaning = |name, angles, scatter| case(name, TurbidMedium { angles, ..tree() }, scatter);
    let only = |bin: usize| {
        let areas = std::array::from_fn(|i| if i == bin { 1.0 } else { 0.0 });
        LeafAngles::from_areas(areas).expect("one bin has area")
    };
    vec![
        leaning("planophile leaves", LeafAngles::planophile(), green()),
        leaning("planophile leaves, near infrared", LeafAngles::planophile(), infrared()),
        leaning("erectophile leaves", LeafAngles::erectophile(), green()),
        leaning("erectophile leaves, near infrared", LeafAngles::erectophile(), infrared()),
        leaning("all leaves flat", only(INCLINATIONS - 1), green()),
        leaning("all leaves upright", only(0), green()),
    ]
}

fn bodies() -> Vec<Case> {
    let green_of = |name, medium| case(name, medium, green());
    let wood_in = |ranges: [[u32; 2]; 3], depth: f64| {
        let leaf = solid(ranges, depth);
        TurbidMedium {
            wood_per_m: leaf.leaf_per_m.clone(),
            leaf_per_m: vec![0.0; leaf.leaf_per_m.len()],
            ..leaf
        }
    };
    let slab = [[2, N - 2], [6, 10], [2, N - 2]];
    vec![
        green_of("one site of leaf", solid([[8, 9]; 3], 0.7)),
        green_of("one site of wood", wood_in([[8, 9]; 3], 4.0)),
        green_of("a slab of leaf", solid(slab, 2.0)),
        green_of("a slab of wood", wood_in(slab, 4.0)),
        case("a slab without absorption", solid(slab, 2.0), white()),
        green_of("a needle, 1 x 1 x 12 sites", solid([[8, 9], [8, 9], [2, 14]], 0.7)),
        green_of("a plate, 12 x 12 x 1 sites", solid([[2, 14], [2, 14], [8, 9]], 0.7)),
        green_of(
            "a plate of wood across the corners",
            filled(|[x, y, z]| {
                let is_plate = x + y == N && [x, y, z].iter().all(|c| (2..N - 2).contains(c));
                [0.0, if is_plate { 4.0 } else { 0.0 }]
            }),
        ),
        green_of("a closed box of leaf", hollow(2.0, 0.0)),
        green_of("a closed wooden box", hollow(0.0, 4.0)),
        case("a closed box without absorption", hollow(0.0, 4.0), white()),
    ]
}

fn bands() -> Vec<Case> {
    let of = |name, count: usize| {
        let band = |at: usize| {
            // Evenly from what absorbs all to what absorbs nothing.
            let share = at as f64 / (count - 1).max(1) as f64;
            leaf(share / 2.0, share / 2.0)
        };
        let settings = OrdinatesSettings::default();
        Case { bands: (0..count).map(band).collect(), settings, ..case(name, tree(), green()) }
    };
    vec![
        of("1 band, all absorbed, `sh2s`", 1),
        of("2 bands, albedos 0 and 1, `sh2s`", 2),
        of("9 bands, albedos 0 to 1, `sh2s`", 9),
        of("64 bands, albedos 0 to 1, `sh2s`", 64),
    ]
}

fn suns() -> Vec<Case> {
    let of = |name, suns| {
        let settings = OrdinatesSettings { suns, ..settings() };
        Case { settings, ..case(name, tree(), green()) }
    };
    let harmonics = |degree, single| SunBasis::Harmonics { degree, single, leaning: true };
    vec![
        of("suns `sh1`", harmonics(1, false)),
        of("suns `sh1s`", harmonics(1, true)),
        of("suns `sh2`", harmonics(2, false)),
        of("suns `sh2s`", harmonics(2, true)),
        of("suns `sh3`", harmonics(3, false)),
        of("suns `sh3s`", harmonics(3, true)),
        of("suns `ico12`", ico12()),
        of("suns `ico42`", ico42()),
    ]
}

fn marches() -> Vec<Case> {
    let of = |name, settings| Case { settings, ..case(name, tree(), leaf(0.45, 0.45)) };
    vec![
        of(
            "18 ordinates, near infrared",
            OrdinatesSettings { ordinates: Ordinates::Lattice18, ..settings() },
        ),
        of(
            "50 ordinates, near infrared",
            OrdinatesSettings { ordinates: Ordinates::Lebedev50, ..settings() },
        ),
        of("110 ordinates, near infrared", settings()),
        of("8 rays a site edge", OrdinatesSettings { rays: 8, ..settings() }),
        of("sites cut in 8", OrdinatesSettings { parts: 2, ..settings() }),
        of("tolerance 1e-6", OrdinatesSettings { tolerance: 1e-6, ..settings() }),
        Case { end: End::GivesUp, ..of("1 pass", OrdinatesSettings { max_passes: 1, ..settings() }) },
        of("fields that hold the beam, `sh2s`", OrdinatesSettings::of_field(FieldKind::Total)),
    ]
}

fn refusals() -> Vec<Case> {
    let refused = |name, words, medium, bands, settings| Case {
        name,
        medium,
        bands,
        settings,
        end: End::Refused(words),
    };
    let of_albedo =
        |name, albedo: f64| refused(name, "expected 0 to 1", tree(), vec![leaf(albedo, 0.0)], settings());
    let of_extinction = |name, per_m: f32| {
        let mut medium = tree();
        medium.leaf_per_m[medium.grid.index(8, 8, 8)] = per_m;
        refused(name, "expected a finite number from 0 up", medium, vec![green()], settings())
    };
    let of_settings = |name, words, settings| refused(name, words, tree(), vec![green()], settings);
    let mut flat = tree();
    flat.grid.spacing_m = 0.0;
    let sh4 = SunBasis::Harmonics { degree: 4, single: false, leaning: true };
    vec![
        of_albedo("leaf albedo one ulp above 1", OUTSIDE),
        of_albedo("leaf albedo below 0", -f64::from_bits(1)),
        of_albedo("leaf albedo not a number", f64::NAN),
        of_extinction("extinction below 0", -f32::from_bits(1)),
        of_extinction("extinction not finite", f32::INFINITY),
        of_extinction("extinction not a number", f32::NAN),
        refused("no bands", "0 bands", tree(), vec![], settings()),
        refused("65 bands", "65 bands", tree(), vec![green(); 65], settings()),
        refused("sites of no size", "sites above 0 m", flat, vec![green()], settings()),
        of_settings("no rays", "expected 1 to 8", OrdinatesSettings { rays: 0, ..settings() }),
        of_settings("sites cut in 27", "expected 1 or 2", OrdinatesSettings { parts: 3, ..settings() }),
        of_settings("tolerance 0", "between 0 and 1", OrdinatesSettings { tolerance: 0.0, ..settings() }),
        of_settings("no passes", "expected 1 or more", OrdinatesSettings { max_passes: 0, ..settings() }),
        of_settings(
            "harmonics of degree 4",
            "expected 1 to 3",
            OrdinatesSettings { suns: sh4, ..settings() },
        ),
    ]
}
