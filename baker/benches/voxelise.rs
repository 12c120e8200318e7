//! Voxelising 300,000 triangles at 1024^3, and down to 128^3: a crown of nothing but cut leaf cards, and the built-in
//! oak with its wood.
//!
//! `cargo bench -p flb-baker --bench voxelise`

use std::hint::black_box;

use criterion::{Criterion, criterion_group, criterion_main};
use flb_baker::downsample;
use flb_baker::voxelise::{VoxelSettings, voxelise};
use flb_fixtures::PlantKind;
use flb_scene::classify::classify;
use flb_scene::import::import;
use flb_scene::mesh::{AlphaMode, Filter, Image, Material, Texture, Wrap};
use flb_scene::{ClassRules, ImportSettings, MaterialClass, Mesh};

const CARDS: usize = 150_000;

/// A leaf of 40 % of its square image.
fn leaf(edge: u32) -> Image {
    let mut rgba = Vec::with_capacity((edge * edge * 4) as usize);
    for (x, y) in (0..edge).flat_map(|y| (0..edge).map(move |x| (x, y))) {
        let [x, y] = [x, y].map(|c| 2.0 * (f64::from(c) + 0.5) / f64::from(edge) - 1.0);
        let present = x.abs() < 0.63 * (1.0 - y * y);
        rgba.extend([80, 150, 50, if present { 255 } else { 0 }]);
    }
    Image { name: "leaf".to_owned(), width: edge, height: edge, rgba, has_cut: true }
}

/// Cards of 8 cm at random angles, eight to a twig, twigs at random places of a ball: a crown 12 m wide that
/// fills about as many sites as the densest real plants do.
fn crown() -> Mesh {
    let mut state = 1u64;
    let mut random = move || {
        // SplitMix64 (Steele, Lea and Flood 2014).
        state = state.wrapping_add(0x9e37_79b9_7f4a_7c15);
        let mixed = (state ^ (state >> 30)).wrapping_mul(0xbf58_476d_1ce4_e5b9);
        let mixed = (mixed ^ (mixed >> 27)).wrapping_mul(0x94d0_49bb_1331_11eb);
        ((mixed ^ (mixed >> 31)) >> 40) as f32 / (1u64 << 24) as f32 * 2.0 - 1.0
    };
    let mut in_ball = move || loop {
        let p = [random(), random(), random()];
        let square = p[0] * p[0] + p[1] * p[1] + p[2] * p[2];
        if (0.01..1.0).contains(&square) {
            return (p, square.sqrt());
        }
    };
    let mut mesh = Mesh {
        materials: vec![Material {
            color_texture: Some(Texture {
                image: 0,
                wrap: [Wrap::Repeat; 2],
                transform: [[1.0, 0.0, 0.0], [0.0, 1.0, 0.0]],
                filter: Filter::Linear,
            }),
            alpha_mode: AlphaMode::Cut { cutoff: 0.5 },
            ..Material::opaque("leaf")
        }],
        images: vec![leaf(1024)],
        ..Mesh::default()
    };
    let mut twig = [0.0f32; 3];
    for card in 0..CARDS as u32 {
        if card % 8 == 0 {
            twig = in_ball().0.map(|c| c * 6.0);
        }
        let leaf = in_ball().0.map(|c| c * 0.12);
        let ((a, a_length), (b, _)) = (in_ball(), in_ball());
        let u = a.map(|c| c / a_length * 0.04);
        let cross = [u[1] * b[2] - u[2] * b[1], u[2] * b[0] - u[0] * b[2], u[0] * b[1] - u[1] * b[0]];
        let length = (cross[0] * cross[0] + cross[1] * cross[1] + cross[2] * cross[2]).sqrt().max(1e-6);
        let v = cross.map(|c| c / length * 0.04);
        for (s, t) in [(-1.0, -1.0), (1.0, -1.0), (1.0, 1.0), (-1.0, 1.0)] {
            mesh.positions
                .push(std::array::from_fn(|axis| twig[axis] + leaf[axis] + s * u[axis] + t * v[axis]));
            mesh.normals.push([0.0, 1.0, 0.0]);
            mesh.uvs.push([s / 2.0 + 0.5, t / 2.0 + 0.5]);
        }
        mesh.triangles
            .extend([[0, 1, 2], [0, 2, 3]].map(|corners| corners.map(|corner: u32| 4 * card + corner)));
        mesh.triangle_material.extend([0; 2]);
    }
    mesh
}

/// The built-in oak of 300,000 triangles as `flb bake` reads it.
fn oak() -> (Mesh, Vec<MaterialClass>) {
    let folder = tempfile::tempdir().expect("a temporary folder");
    let path = folder.path().join("oak.glb");
    let plant = flb_fixtures::grow(PlantKind::Oak, 1, 300_000).expect("enough triangles");
    std::fs::write(&path, plant.to_glb()).expect("room for the plant");
    let mesh = import(&path, &ImportSettings::default()).expect("a good mesh");
    let classes = classify(&mesh, &ClassRules::default()).expect("materials that tell");
    (mesh, classes.into_iter().map(|decision| decision.class).collect())
}

fn voxelise_plants(criterion: &mut Criterion) {
    let settings = VoxelSettings { voxels: 1024, lattice: 128, ignore_alpha: false };
    let plants = [("leaf cards", (crown(), vec![MaterialClass::Leaf])), ("oak", oak())];
    for (name, (mesh, classes)) in plants {
        let mut group = criterion.benchmark_group(format!("300,000 triangles, {name}"));
        group.sample_size(10);
        let run = || voxelise(black_box(&mesh), &classes, &settings, &|_| Ok(())).expect("a good mesh");
        group.bench_function("voxelise 1024", |bencher| bencher.iter(run));
        let occupancy = run();
        group.bench_function("downsample to 128", |bencher| {
            bencher.iter(|| downsample(black_box(&occupancy)).expect("a good occupancy"));
        });
        group.finish();
    }
}

criterion_group!(benches, voxelise_plants);
criterion_main!(benches);
