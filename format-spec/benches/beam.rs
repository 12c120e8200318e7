//! The beam of a sun, site by site and ray by ray: `cargo bench -p flb-format --bench beam`.

use criterion::{Criterion, criterion_group, criterion_main};
use flb_format::Grid;
use flb_format::beam::walk::uncollided_ray_by_ray;
use flb_format::beam::{BEAM_RAYS, Near, Sites, single, uncollided};
use flb_format::matter::{LeafAngles, TurbidMedium};

/// A crown: a ball of clumps that fill a third of it, thin inside.
fn crown(lattice: u32) -> TurbidMedium {
    let grid = Grid { lattice, spacing_m: 12.0 / f64::from(lattice), origin_m: [0.0; 3] };
    let middle = f64::from(lattice) / 2.0;
    let density = |site: usize| {
        let at = grid.site(site).map(|c| f64::from(c) + 0.5 - middle);
        let radius = libm::sqrt(at.iter().map(|c| c * c).sum()) / middle;
        let clump = at.map(|c| libm::sin(0.7 * c)).iter().product::<f64>();
        if radius < 0.95 && clump > 0.1 { (4.0 * radius * clump) as f32 } else { 0.0 }
    };
    let leaf_per_m: Vec<f32> = (0..grid.sites()).map(density).collect();
    TurbidMedium {
        wood_per_m: vec![0.0; leaf_per_m.len()],
        grid,
        leaf_per_m,
        angles: LeafAngles::spherical(),
    }
}

fn beams(criterion: &mut Criterion) {
    for lattice in [64, 128] {
        let medium = crown(lattice);
        let sites = medium.sites();
        let places = Sites::new(&medium.grid, &sites);
        let towards_sun = [0.48, 0.6, 0.64];
        println!("lattice {lattice}: {} sites with matter", sites.len());
        let mut group = criterion.benchmark_group(format!("beam, lattice {lattice}"));
        group.sample_size(10);
        group.bench_function("site by site", |bench| {
            bench.iter(|| uncollided(&medium, &places, &sites, towards_sun, BEAM_RAYS));
        });
        group.bench_function("ray by ray", |bench| {
            bench.iter(|| uncollided_ray_by_ray(&medium, &sites, towards_sun, BEAM_RAYS));
        });
        let near = Near::new(&medium, &sites, true);
        let mean = near.uncollided(towards_sun, BEAM_RAYS).mean;
        group.bench_function("means around it", |bench| bench.iter(|| near.around(&mean)));
        group.bench_function("tracks of an axis", |bench| {
            bench.iter(|| single::OrdinateTracks::lay(&medium, &places, &sites, &single::axes()[0]));
        });
    }
}

criterion_group!(benches, beams);
criterion_main!(benches);
