//! What scene light is worth: stands of three and of nine built-in plants, 0.7 crown widths apart, by one fine lattice
//! that holds all of them, and by the fine light of each plant alone: without scene light, with the papers' factor (its
//! light over that of an empty scene), and with its light over that of each plant alone. For plants of both models.
//!
//! ```text
//! cargo bench -p flb-tests --bench stand -- [quick]
//! ```
//!
//! Prints rms error and, in brackets, bias of the indirect light's luminance over all matter (of nine: of the middle
//! plant's), in % of its mean: of the day (the sun's scattered light, and the light of a sky of fluence 0.36), of the
//! sun's alone and of the sky's alone.

use std::time::Instant;

use flb_fixtures::PlantKind;
use flb_format::sun::towards_sun;
use flb_runtime::scene_light::{SceneFactor, SceneLight};
use flb_tests::stand::{Kind, Pair, Stand, SunAndSky, day, error, pairs};
use flb_transport::ordinates::{SunBasis, ico42};

/// Azimuth and elevation: low and high.
const SKIES: [[f64; 2]; 2] = [[90.0, 20.0], [200.0, 60.0]];
/// Distance of neighbours, of a crown's width.
const APART: f64 = 0.7;

/// Plants in a certain order.
struct Case {
    name: &'static str,
    /// In distances of neighbours.
    places: Vec<[f64; 2]>,
    /// Sites along each edge of the lattice that holds all of them.
    fine: u32,
    /// The one that is looked at; else all.
    only: Option<u32>,
    ways: Vec<(u32, &'static str, SunBasis)>,
}

fn cases(quick: bool) -> [Case; 2] {
    let harmonics = |degree, single| SunBasis::Harmonics { degree, single, leaning: false };
    let sh1 = |lattice| (lattice, "sh1", harmonics(1, false));
    let mut ways = vec![sh1(16), sh1(32)];
    if !quick {
        ways.extend([
            (32, "lattice18", SunBasis::Lattice18),
            (32, "ico42", ico42()),
            (32, "sh1s", harmonics(1, true)),
            (32, "sh2", harmonics(2, false)),
            (32, "sh2s", harmonics(2, true)),
            sh1(64),
        ]);
    }
    let three = vec![[0.0, 0.0], [1.0, 0.0], [0.5, 0.75_f64.sqrt()]];
    let nine = (0..9u32).map(|i| [i % 3, i / 3].map(f64::from)).collect();
    let of_nine = if quick { vec![sh1(32)] } else { vec![sh1(32), sh1(64)] };
    [
        Case { name: "3", places: three, fine: 64, only: None, ways },
        Case { name: "9, the middle", places: nine, fine: 128, only: Some(4), ways: of_nine },
    ]
}

fn main() {
    let quick = std::env::args().any(|word| word == "quick");
    println!(
        "| model | plants | sun | lattice | site, widths | suns | bake, s | day, without | empty | alone | sun, without | empty | alone | sky, without | empty | alone |"
    );
    println!("|---|---|---|---:|---:|---|---:|---|---|---|---|---|---|---|---|---|");
    for kind in [PlantKind::Oak, PlantKind::Spruce] {
        for case in cases(quick) {
            judge("physical", Kind::grown(kind, 20_000, 32), &case);
            judge("paper", Kind::grown_of_paper(kind, 20_000, 32), &case);
        }
    }
}

fn judge(model: &str, plant: Kind, case: &Case) {
    let name = plant.name.clone();
    let [low, high] = plant.extent_m();
    let width = high[0] - low[0];
    let places: Vec<(usize, usize, [f64; 2])> = case
        .places
        .iter()
        .enumerate()
        .map(|(index, place)| (0, [0, 1, 3, 2][index % 4], place.map(|c| c * APART * width)))
        .collect();
    let stand = Stand::in_step(vec![plant], &places);
    let is_paper = stand.kinds[0].optics.is_some();
    let (merged, places) = stand.merged(case.fine);
    let truths = SKIES
        .map(|[azimuth, elevation]| stand.kinds[0].light_at_sites(&merged, towards_sun(azimuth, elevation)));
    let mut last = None;
    for (lattice, suns_name, suns) in &case.ways {
        // The papers have suns of one kind.
        if is_paper && last.replace(*lattice) == Some(*lattice) {
            continue;
        }
        let start = Instant::now();
        let library = if is_paper { stand.paper_library(*lattice) } else { stand.library(*lattice, suns) };
        let suns_name = if is_paper { "lattice18" } else { suns_name };
        let seconds = start.elapsed().as_secs_f64();
        let site = library.container().species()[1].meta.grid.spacing_m / width;
        for ([azimuth, elevation], truth) in SKIES.into_iter().zip(&truths) {
            let towards = towards_sun(azimuth, elevation);
            let by = |factor| {
                let light = SceneLight::load(&library).and_then(|light| light.compared_with(factor));
                light.is_ok().then(|| {
                    let mut pairs = pairs(&stand, (&places, truth), (&library, factor), towards);
                    pairs.retain(|pair| case.only.is_none_or(|only| pair.instance == only));
                    pairs
                })
            };
            let (empty, alone) = (by(SceneFactor::Empty), by(SceneFactor::Alone));
            let alone = alone.expect("all libraries can be compared with plants alone");
            let parts = [day as fn(SunAndSky) -> f32, |light| light[0], |light| light[1]];
            let cell = |pairs: &[Pair], of: fn(SunAndSky) -> f32, found: fn(&Pair) -> SunAndSky| {
                let [rms, bias] = error(pairs, |pair| of(pair.truth), |pair| of(found(pair)));
                format!("{:.1} ({:+.1})", 100.0 * rms, 100.0 * bias)
            };
            let columns = parts.into_iter().flat_map(|of| {
                let empty = empty.as_ref().map_or("-".to_owned(), |pairs| cell(pairs, of, |pair| pair.whole));
                [cell(&alone, of, |pair| pair.own), empty, cell(&alone, of, |pair| pair.whole)]
            });
            println!(
                "| {model} | {} {name} | {azimuth}, {elevation} | {lattice} | {site:.3} | {suns_name} | {seconds:.1} | {} |",
                case.name,
                columns.collect::<Vec<_>>().join(" | ")
            );
        }
    }
}
