//! The table of extremes.

use flb_format::Medium;
use flb_format::matter::{BandOptics, Class, ClassOptics, Optics};

use super::super::media;
use super::Case;
use super::shapes::{hollow, solid};
use crate::ends::End;

/// Scatters back only and absorbs nothing for good: the papers' wood.
const BACK: ClassOptics = ClassOptics { sigma_a: 0.1, g: -1.0 };
const MIRROR: ClassOptics = ClassOptics { sigma_a: 0.0, g: -1.0 };
/// One unit in the last place inside 1.
const INSIDE: f64 = 1.0 - f64::EPSILON / 2.0;
const OUTSIDE: f64 = 1.0 + f64::EPSILON;
/// The lattice of most cases: small enough for hundreds of f64 solves.
const N: u32 = 16;
/// All sites but the two outer layers.
const ALL: [[u32; 2]; 3] = [[2, N - 2]; 3];

/// All cases, in the order of the table.
pub fn cases() -> Vec<Case> {
    [asymmetry(), absorption(), density(), bodies(), closed(), bands(), refusals()]
        .into_iter()
        .flatten()
        .collect()
}

fn case(name: &'static str, medium: Medium, optics: Optics, end: End) -> Case {
    Case { name, medium, optics, end }
}

fn tree() -> Medium {
    media::tree(2 * N, 3)
}

fn one(leaf: ClassOptics, wood: ClassOptics) -> Optics {
    Optics { bands: vec![BandOptics { name: "X".to_owned(), leaf, wood }] }
}

fn leaf(sigma_a: f64, g: f64) -> Optics {
    one(ClassOptics { sigma_a, g }, BACK)
}

fn wood(sigma_a: f64, g: f64) -> Optics {
    one(ClassOptics { sigma_a: 0.1, g: 0.0 }, ClassOptics { sigma_a, g })
}

fn asymmetry() -> Vec<Case> {
    let of = |name, g| {
        case(
            name,
            tree(),
            one(ClassOptics { sigma_a: 0.1, g }, ClassOptics { sigma_a: 0.1, g }),
            End::Converges,
        )
    };
    vec![
        case("a tree, the papers' optics", tree(), Optics::paper(), End::Converges),
        of("g = -1", -1.0),
        of("g one ulp above -1", -INSIDE),
        of("g = -0.5", -0.5),
        of("g = 0", 0.0),
        of("g the smallest number above 0", f64::from_bits(1)),
        of("g = 0.5", 0.5),
        of("g one ulp below 1", INSIDE),
        of("g = 1", 1.0),
    ]
}

fn absorption() -> Vec<Case> {
    vec![
        case("leaf absorbs nothing", tree(), leaf(0.0, 0.0), End::Converges),
        case("leaf absorbs all", tree(), leaf(1.0, 0.0), End::Converges),
        case("wood absorbs nothing: mirrors", tree(), wood(0.0, -1.0), End::Converges),
        case("wood gives all back evenly", tree(), wood(1.0, -1.0), End::Converges),
        case("sigma_a one ulp below 1", tree(), leaf(INSIDE, 0.3), End::Converges),
        case("sigma_a the smallest number above 0", tree(), leaf(f64::from_bits(1), 0.3), End::Converges),
    ]
}

fn density() -> Vec<Case> {
    let optics = || leaf(0.1, 0.2);
    let all = |name, density, end| case(name, solid(N, ALL, Class::Leaf, density), optics(), end);
    vec![
        case("no matter", media::empty(N), Optics::paper(), End::Converges),
        all("density the smallest subnormal everywhere", f32::from_bits(1), End::Converges),
        all("density the smallest normal everywhere", f32::MIN_POSITIVE, End::Converges),
        all("optical depth 1e-6 a site", 1e-6, End::Converges),
        all("optical depth 1e-3 a site", 1e-3, End::Converges),
        all("density 1 everywhere", 1.0, End::Converges),
        all("density one ulp below 1 everywhere", 1.0 - f32::EPSILON / 2.0, End::Converges),
    ]
}

fn bodies() -> Vec<Case> {
    let slab = [[2, N - 2], [6, 10], [2, N - 2]];
    let paper = Optics::paper;
    vec![
        case(
            "one voxel of leaf in a site",
            solid(N, [[8, 9]; 3], Class::Leaf, 1.0 / 512.0),
            paper(),
            End::Converges,
        ),
        case(
            "one voxel of wood in a site",
            solid(N, [[8, 9]; 3], Class::Wood, 1.0 / 512.0),
            paper(),
            End::Converges,
        ),
        case("one full site of wood", solid(N, [[8, 9]; 3], Class::Wood, 1.0), paper(), End::Converges),
        case("a solid slab of leaf", solid(N, slab, Class::Leaf, 1.0), paper(), End::Converges),
        case("a solid slab of wood", solid(N, slab, Class::Wood, 1.0), paper(), End::Converges),
        case(
            "a slab of leaf without absorption",
            solid(N, slab, Class::Leaf, 1.0),
            leaf(0.0, 0.0),
            End::Converges,
        ),
        case(
            "all leaf, no absorption, backwards",
            solid(N, ALL, Class::Leaf, 1.0),
            leaf(0.0, -0.9),
            End::GivesUp,
        ),
        case(
            "all leaf, no absorption, forwards",
            solid(N, ALL, Class::Leaf, 1.0),
            leaf(0.0, 0.9),
            End::Converges,
        ),
        case(
            "a needle, 1 x 1 x 12 sites",
            solid(N, [[8, 9], [8, 9], [2, 14]], Class::Leaf, 0.7),
            paper(),
            End::Converges,
        ),
        case(
            "a plate, 12 x 12 x 1 sites",
            solid(N, [[2, 14], [2, 14], [8, 9]], Class::Leaf, 0.7),
            paper(),
            End::Converges,
        ),
        case("a plate of wood across the corners", diagonal_plate(), paper(), End::Converges),
    ]
}

fn diagonal_plate() -> Medium {
    super::shapes::filled(N, ALL, Class::Wood, |[x, y, _]| if x + y == N { 1.0 } else { 0.0 })
}

fn closed() -> Vec<Case> {
    let shell = |wall| hollow(N, [3, 13], wall, Class::Wood, 1.0);
    vec![
        case("a closed box of mirrors", shell(1), one(BACK, MIRROR), End::Converges),
        case("a closed wooden box, wall 1 site", shell(1), Optics::paper(), End::Converges),
        case("a closed wooden box, wall 3 sites", shell(3), Optics::paper(), End::Converges),
        case(
            "a closed box of leaf",
            hollow(N, [3, 13], 2, Class::Leaf, 1.0),
            Optics::paper(),
            End::Converges,
        ),
        case("solid wood", solid(N, [[3, 13]; 3], Class::Wood, 1.0), Optics::paper(), End::Converges),
        case(
            "solid wood at lattice 32",
            solid(32, [[8, 24]; 3], Class::Wood, 1.0),
            leaf(0.1, 0.0),
            End::Converges,
        ),
    ]
}

fn bands() -> Vec<Case> {
    let of = |name, count: usize| {
        let band = |at: usize| {
            // Evenly over both ranges, their ends included.
            let share = at as f64 / (count - 1).max(1) as f64;
            BandOptics {
                name: format!("b{at}"),
                leaf: ClassOptics { sigma_a: share, g: 1.0 - 2.0 * share },
                wood: BACK,
            }
        };
        case(name, tree(), Optics { bands: (0..count).map(band).collect() }, End::Converges)
    };
    vec![of("1 band", 1), of("2 bands", 2), of("9 bands", 9), of("64 bands", 64)]
}

fn refusals() -> Vec<Case> {
    let refused = |name, optics, words| case(name, tree(), optics, End::Refused(words));
    let dense = |name, density, words| case(name, unchecked(density), Optics::paper(), End::Refused(words));
    let many = Optics { bands: vec![Optics::paper().bands[0].clone(); 65] };
    vec![
        refused("sigma_a one ulp above 1", leaf(OUTSIDE, 0.0), "expected 0 to 1"),
        refused("sigma_a below 0", leaf(-f64::from_bits(1), 0.0), "expected 0 to 1"),
        refused("sigma_a not a number", wood(f64::NAN, 0.0), "expected 0 to 1"),
        refused("g one ulp above 1", leaf(0.1, OUTSIDE), "expected -1 to 1"),
        refused("g one ulp below -1", wood(0.1, -OUTSIDE), "expected -1 to 1"),
        refused("g not a number", leaf(0.1, f64::NAN), "expected -1 to 1"),
        refused("no bands", Optics { bands: vec![] }, "0 bands"),
        refused("65 bands", many, "65 bands"),
        dense("optical depth 1e4 a site", 1e4, "expected 0 to 1"),
        dense("density one ulp above 1", 1.0 + f32::EPSILON, "expected 0 to 1"),
        dense("density below 0", -f32::from_bits(1), "expected 0 to 1"),
        dense("density not a number", f32::NAN, "expected 0 to 1"),
        case(
            "matter at the boundary",
            solid(N, [[1, 2]; 3], Class::Leaf, 0.5),
            Optics::paper(),
            End::Refused("outer two layers"),
        ),
    ]
}

fn unchecked(density: f32) -> Medium {
    let mut medium = media::empty(N);
    media::put(&mut medium, [8, 8, 8], Class::Leaf, density);
    medium
}
