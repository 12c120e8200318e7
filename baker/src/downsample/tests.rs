use proptest::prelude::*;

use super::*;
use crate::voxelise::tests::{LEAF_WOOD, cut_soup, quiet, settings, triangles};
use flb_scene::mesh::testing::soup;

proptest! {
    #![proptest_config(ProptestConfig::with_cases(40))]

    #[test]
    fn mean_density_is_the_same_at_every_level(mesh in cut_soup()) {
        prop_assume!((0..3).any(|axis| mesh.bounds().is_some_and(|b| b.max[axis] > b.min[axis])));
        for voxels in [16, 64, 256] {
            let occupancy = quiet(&mesh, &LEAF_WOOD, &settings(voxels, 16));
            let voxel_mean = occupancy.counts()[2] as f64 / u64::from(voxels).pow(3) as f64;
            let means: Vec<f64> = levels(&occupancy, 0).map(|level| level.mean_density()).collect();
            prop_assert_eq!(means.len() as u32, (voxels / 16).ilog2() + 1);
            prop_assert!(means.iter().all(|&mean| mean == voxel_mean), "{:?} {}", means, voxel_mean);
        }
    }

    #[test]
    fn density_is_the_count_of_voxels_over_all_of_them(triangles in triangles(6), voxels in prop_oneof![Just(48u32), Just(64), Just(80)]) {
        let mut mesh = soup(&triangles);
        prop_assume!((0..3).any(|axis| mesh.bounds().is_some_and(|b| b.max[axis] > b.min[axis])));
        mesh.triangle_material[0] = 1;
        let occupancy = quiet(&mesh, &LEAF_WOOD, &settings(voxels, 16));
        let medium = downsample(&occupancy).expect("a good occupancy");
        let per_site = voxels / 16;
        let mut counts = vec![[0u32; 3]; medium.grid.sites()];
        for cluster in occupancy.clusters() {
            for i in 0..512usize {
                let bit = |words: &[u64; 8]| (words[i / 64] >> (i % 64) & 1) as u32;
                let inner = [i % 8, i / 8 % 8, i / 64];
                let site: [u32; 3] = std::array::from_fn(|axis| {
                    (u32::from(cluster.position[axis]) * 8 + inner[axis] as u32) / per_site
                });
                let (leaf, wood) = (bit(&cluster.leaf), bit(&cluster.wood));
                let count = &mut counts[medium.grid.index(site[0], site[1], site[2])];
                *count = [count[0] + leaf, count[1] + wood, count[2] + (leaf | wood)];
            }
        }
        for (site, &[leaf, wood, either]) in counts.iter().enumerate() {
            let expected = (f64::from(either) / u64::from(per_site).pow(3) as f64) as f32;
            // Where 3 or 5 divides, two roundings may differ from one in the last bit.
            let bound = if per_site.is_power_of_two() { 0.0 } else { f32::EPSILON };
            prop_assert!((medium.density[site] - expected).abs() <= bound * expected);
            let class = match (either, wood > leaf) {
                (0, _) => Class::Empty,
                (_, true) => Class::Wood,
                (_, false) => Class::Leaf,
            };
            prop_assert_eq!(medium.class[site], class);
        }
    }
}

#[test]
fn area_density_times_volume_is_the_area() {
    let mut mesh = soup(&[
        [[0.0, 0.0, 0.0], [3.0, 0.0, 0.0], [0.0, 4.0, 0.0]],
        [[0.0, 0.0, 1.0], [0.0, 2.0, 1.0], [0.0, 0.0, 3.0]],
    ]);
    mesh.triangle_material[1] = 1;
    let occupancy = quiet(&mesh, &LEAF_WOOD, &settings(64, 16));
    let medium = downsample(&occupancy).expect("a good occupancy");
    let site_m3 = libm::pow(medium.grid.spacing_m, 3.0);
    let total = |densities: &[f32]| densities.iter().map(|&d| f64::from(d)).sum::<f64>() * site_m3;
    // Ten bits per site, and snapping.
    assert!((total(&medium.leaf_area_density) - 6.0).abs() < 6.0 / 2048.0);
    assert!((total(&medium.wood_area_density) - 2.0).abs() < 2.0 / 2048.0);
    assert!(medium.leaf_area_density.iter().all(|&density| rounded(density) == density));
}

#[test]
fn finer_voxels_or_other_lattices_keep_the_area() {
    let mesh = soup(&[[[0.1, -0.7, 0.3], [1.0, 0.0, 0.9], [-1.0, 1.0, 0.0]]]);
    let area = |voxels, lattice| quiet(&mesh, &LEAF_WOOD, &settings(voxels, lattice)).area_m2()[0];
    for (voxels, lattice) in [(128, 16), (512, 64), (512, 256), (256, 256)] {
        assert!((area(voxels, lattice) / area(64, 16) - 1.0).abs() < 1e-4);
    }
}
