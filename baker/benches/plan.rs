//! How long a scene of 100,000 plants takes: reading its TOML, planning it.

use std::fmt::Write;
use std::hint::black_box;
use std::path::Path;

use criterion::{Criterion, criterion_group, criterion_main};
use flb_baker::plan::plan;
use flb_format::meta::Bounds;
use flb_scene::scene::Scene;

/// Two species, one upright, one tilted a little; no two plants are turned alike, so that none is spared; a walk past
/// all.
fn scene_text() -> String {
    let mut text = "\
[camera]
path_m = [[-400.0, 1.7, -90.0], [0.0, 1.7, 0.0], [400.0, 1.7, 90.0]]
fov_deg = 40.0
height_px = 1080
[sun]
path = { latitude_deg = 52.5, longitude_deg = 13.4, from = 2026-06-01, to = 2026-08-31 }
[[species]]
name = \"oak\"
[[species]]
name = \"fir\"
"
    .to_owned();
    for i in 0..100_000 {
        let (x, z) = (i % 317 * 3 - 475, i / 317 * 3 - 475);
        let name = if i % 2 == 0 { "oak" } else { "fir" };
        let turn = match i % 2 {
            0 => format!("yaw_deg = {}", 10.0 + f64::from(i) * 1e-5),
            _ => {
                let half = (3.0 + f64::from(i) * 1e-5f64).to_radians() / 2.0;
                format!("rotation = [{}, 0, 0, {}]", libm::sin(half), libm::cos(half))
            }
        };
        writeln!(text, "[[instance]]\nspecies = {name:?}\nposition_m = [{x}, 0, {z}]\n{turn}")
            .expect("a string grows");
    }
    text
}

fn benches(criterion: &mut Criterion) {
    let text = scene_text();
    let read = || Scene::parse("scene.toml", Path::new(""), &text).expect("the scene is sound");
    let bounds = Some(Bounds { min: [-2.0, 0.0, -2.0], max: [2.0, 5.0, 2.0] });
    let scene = read();
    let mut group = criterion.benchmark_group("plan");
    group.sample_size(10);
    group.bench_function("read 100,000 instances", |b| b.iter(|| black_box(read())));
    group.bench_function("plan 100,000 instances", |b| {
        b.iter(|| black_box(plan(black_box(&scene), &[bounds, bounds])))
    });
    group.finish();
}

criterion_group!(plan_benches, benches);
criterion_main!(plan_benches);
