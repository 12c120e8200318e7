//! A day of grown plants under a clear sky, baked light over paths: the table of docs/measurements/sky.md.
//!
//! ```text
//! cargo bench -p flb-tests --bench sky -- [quick] [shared] [plant...]
//! ```
//!
//! Plants are the oak and the spruce, or those that are named, at lattice 64. `quick` takes the first frame and the
//! fifth, in smaller pictures. First comes the sky by beams that a stand shares, over the sky of one plant; `shared`
//! stops there. A row is a frame: of all light the mean of the bands, then its bands; what is not the sun's beam, and
//! its bands; the sky without the sun, and its bands.

use flb_baker::bake::BakeSettings;
use flb_fixtures::PlantKind;
use flb_render::Indirect;
use flb_tests::day::{DAY, Frame, Subject};
use flb_tests::default_bake::{DefaultBake, grown};

fn main() {
    let words: Vec<String> = std::env::args().skip(1).filter(|word| !word.starts_with("--")).collect();
    let is_quick = words.iter().any(|word| word == "quick");
    let named = |kind: &PlantKind| words.iter().any(|word| word == kind.name());
    let mut kinds: Vec<PlantKind> = PlantKind::ALL.into_iter().filter(named).collect();
    if kinds.is_empty() {
        kinds = vec![PlantKind::Oak, PlantKind::Spruce];
    }
    let (edge, suns) = if is_quick { (64, vec![DAY[0], DAY[4]]) } else { (128, DAY.to_vec()) };
    for kind in kinds {
        let plant = grown(kind, kind.default_triangles());
        let bake = DefaultBake::with(plant, &BakeSettings { lattice: 64, ..BakeSettings::default() });
        let subject = Subject::new(&bake, edge, [4, 64]);
        println!("{}: azimuth, elevation | by beams that a stand shares: sky, and rms apart", kind.name());
        let beams = subject.beams();
        for [azimuth, elevation] in &suns {
            let [ratio, rms] = subject.shared_over_own(&beams, [*azimuth, *elevation]);
            println!("| {azimuth}, {elevation} | {ratio:.3} | {:.1} % |", 100.0 * rms);
        }
        if words.iter().any(|word| word == "shared") {
            continue;
        }
        println!("{}: azimuth, elevation | all light, R G B | indirect, R G B | sky, R G B", kind.name());
        for sun in &suns {
            let [azimuth, elevation] = sun;
            let parts = [(Indirect::On, false), (Indirect::Only, false), (Indirect::Only, true)];
            let cells = parts.map(|(part, sky_alone)| cell(&subject.frame(*sun, part, sky_alone)));
            println!("| {azimuth}, {elevation} | {} |", cells.join(" | "));
        }
    }
}

fn cell(frame: &Frame) -> String {
    let [red, green, blue] = frame.ratios();
    format!("{:.3} | {red:.3} {green:.3} {blue:.3}", frame.ratio())
}
