//! What a bake is worth to those who draw it: bytes, time and grain of a sample, and the error on the mesh of the light
//! as a renderer draws it.
//!
//! ```text
//! cargo bench -p flb-tests --bench uses -- [quick] [PLANT]
//! ```
//!
//! Rows are bakes of a built-in plant (the oak) and ways to draw each of them: by marches, by rings and expanded
//! fields, by volumes, by suns that are prepared by themselves. *MB kept* is memory while it is drawn: of a volume that
//! of one sun and yaw, of rings that of two of them and the fields, else that of the whole species. *us* is of a point
//! under a sun, by `at`. *Grain* is by how much the light of two points a tenth of a millimetre apart differs, rms, in
//! % of the mean. *Mesh rms* and *furthest mean* are errors against paths on the mesh, as `flb trade` has them. `quick`
//! takes fewer points and lattices 32 and 64 alone.

use std::hint::black_box;
use std::sync::Arc;
use std::time::Instant;

use flb_baker::bake::BakeSettings;
use flb_eval::MeshTruth;
use flb_eval::trade::MeshRow;
use flb_fixtures::PlantKind;
use flb_format::{Codec, Quality};
use flb_packer::EncodeSettings;
use flb_runtime::light::{LightVolume, SunRings};
use flb_runtime::{Daylight, InstanceLight, SpeciesLight};
use flb_scene::Unobserved;
use flb_scene::surface_points::surface_points;
use flb_tests::default_bake::{DefaultBake, grown};
use flb_transport::monte_carlo::judge::suns;

const SUNS: usize = 8;
/// Distance at which a second look should find the same light, metres.
const BESIDE_M: f32 = 1e-4;

/// A bake by name.
type Bake = (&'static str, Quality, u32);

const BAKES: [Bake; 6] = [
    ("draft", Quality::Draft, 32),
    ("standard, lattice 32", Quality::Standard, 32),
    ("standard, lattice 64", Quality::Standard, 64),
    ("standard", Quality::Standard, 128),
    ("fine", Quality::Fine, 128),
    ("fine, lattice 256", Quality::Fine, 256),
];

/// Light at a point, per band.
type Light<'l> = Box<dyn Fn([f32; 3], &mut [f32]) + Sync + 'l>;

/// Light of the suns and of the sky, in some way.
struct Way<'l> {
    name: &'static str,
    bytes: usize,
    light: Vec<Light<'l>>,
}

fn way<'l>(name: &'static str, bytes: usize, all: Vec<InstanceLight<'l>>) -> Way<'l> {
    let light = all
        .into_iter()
        .map(|lit| -> Light<'l> { Box::new(move |point, out: &mut [f32]| lit.at(point, out)) });
    Way { name, bytes, light: light.collect() }
}

fn main() {
    let words: Vec<String> = std::env::args().skip(1).filter(|word| !word.starts_with("--")).collect();
    let quick = words.iter().any(|word| word == "quick");
    let kind = PlantKind::ALL.into_iter().find(|kind| words.iter().any(|word| word == kind.name()));
    let kind = kind.unwrap_or(PlantKind::Oak);
    let (count, samples) = if quick { (500, 32) } else { (2000, 64) };
    let plant = grown(kind, kind.default_triangles());
    let suns = suns(SUNS);
    let mut truth: Option<MeshTruth> = None;
    println!("{}\n", kind.name());
    println!("| bake | bake, s | file, MB | drawn by | kept, MB | us | grain | mesh rms | furthest mean |");
    println!("|---|---:|---:|---|---:|---:|---:|---:|---|");
    for (name, quality, lattice) in BAKES.into_iter().filter(|(_, _, lattice)| !quick || *lattice <= 64) {
        let settings = BakeSettings { lattice, ..BakeSettings::of(quality) };
        let begin = Instant::now();
        let baked =
            DefaultBake::coded(plant.clone(), &settings, &EncodeSettings::of(quality, Codec::Classed));
        let bake_s = begin.elapsed().as_secs_f64();
        let (library, surfaces) = (baked.library(), baked.surfaces());
        let truth = truth.get_or_insert_with(|| {
            let points = surface_points(&baked.mesh, count, false).expect("good textures");
            MeshTruth::trace(&baked.mesh, surfaces, points, &suns, samples, name, &Unobserved)
                .expect("a good mesh")
        });
        let offset_m = library.container().species()[0].meta.solid_offset_m();
        let asked = truth.asked(offset_m.map(|offset_m| offset_m as f32));
        let species = SpeciesLight::load(&library, 0).expect("a sound file");
        let near = species.near().expect("suns of harmonics");
        let days: Vec<Daylight> = suns
            .iter()
            .map(|sun| Daylight { towards_sun: *sun, sun: 1.0, sky: 0.0 })
            .chain([Daylight { towards_sun: [0.0, 1.0, 0.0], sun: 0.0, sky: 1.0 }])
            .collect();
        let lit = |day: &Daylight| species.lit_by_in_model(day).expect("a direction");
        let prepared = |day: &Daylight| lit(day).prepared_by(Some(&near));
        let fields = species.field_volume().expect("blocks near geometry");
        let volumes: Vec<LightVolume> = days.iter().filter_map(|day| prepared(day).volume()).collect();
        let file = species.size_bytes();
        let mut ring_bytes = 0;
        let by_rings: Vec<InstanceLight> = days
            .iter()
            .map(|day| {
                let mut rings = SunRings::default();
                for step in SunRings::steps(day.towards_sun).into_iter().filter(|_| day.sun > 0.0) {
                    let ring = species.sun_ring(&near, step).expect("suns of harmonics");
                    rings.insert(step, Arc::new(ring));
                }
                ring_bytes = ring_bytes.max(rings.size_bytes());
                lit(day).with_rings(&rings).with_fields(&fields)
            })
            .collect();
        let ways = [
            way("marches", file, days.iter().map(lit).collect()),
            way("rings and fields", ring_bytes + fields.size_bytes(), by_rings),
            Way {
                name: "a volume",
                bytes: volumes.iter().map(LightVolume::size_bytes).max().unwrap_or_default(),
                light: volumes
                    .iter()
                    .map(|volume| -> Light<'_> { Box::new(|point, out: &mut [f32]| volume.at(point, out)) })
                    .collect(),
            },
            way("a prepared sun", file, days.iter().map(prepared).collect()),
        ];
        for Way { name: way, bytes, light } in ways {
            let found = |source: usize, point: [f32; 3], phi: &mut [f32; 3]| light[source](point, phi);
            let row = MeshRow::of(&truth.compare(&surfaces, &found)).expect("light falls on the mesh");
            let [micros, grain] = cost(&light[..SUNS], &asked);
            println!(
                "| {name} | {bake_s:.1} | {:.2} | {way} | {:.2} | {micros:.2} | {:.1} % | {:.1} % | {} |",
                baked.file.len() as f64 / 1e6,
                bytes as f64 / 1e6,
                100.0 * grain,
                row.rms_percent,
                row.furthest_mean()
            );
        }
    }
}

/// Microseconds of a sample under a sun, and by how much two samples side by side differ, as a share of the mean.
fn cost(light: &[Light<'_>], points: &[[f32; 3]]) -> [f64; 2] {
    let (mut squares, mut sum, mut count) = (0.0, 0.0, 0.0);
    let mut seconds = 0.0;
    for light in light {
        let begin = Instant::now();
        let mut all = vec![[0.0_f32; 3]; points.len()];
        points.iter().zip(&mut all).for_each(|(point, rgb)| light(*point, rgb));
        seconds += black_box(begin.elapsed().as_secs_f64());
        for (point, here) in points.iter().zip(all) {
            let mut beside = [0.0; 3];
            light(point.map(|x| x + BESIDE_M), &mut beside);
            for (here, beside) in here.into_iter().zip(beside) {
                let off = f64::from(here - beside);
                (squares, sum, count) = (squares + off * off / 2.0, sum + f64::from(here), count + 1.0);
            }
        }
    }
    let samples = (light.len() * points.len()) as f64;
    [1e6 * seconds / samples, libm::sqrt(squares / count) / (sum / count)]
}
