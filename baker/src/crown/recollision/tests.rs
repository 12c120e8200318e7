use flb_format::Grid;
use flb_transport::turbid::{BandScatter, LeafAngles, Phase, Scatter};

use super::*;

const EDGE_M: f64 = 0.5;

/// A lattice with one site of leaves of this extinction and one-sided area density.
fn site(leaf_per_m: f64, area_per_m: f64) -> (TurbidMedium, Medium) {
    let grid = Grid { lattice: 16, origin_m: [0.0; 3], spacing_m: EDGE_M };
    let at = grid.index(8, 8, 8);
    let mut medium = Medium::empty(grid);
    medium.leaf_area_density[at] = area_per_m as f32;
    let mut turbid = TurbidMedium {
        grid,
        leaf_per_m: vec![0.0; grid.sites()],
        wood_per_m: vec![0.0; grid.sites()],
        angles: LeafAngles::spherical(),
    };
    turbid.leaf_per_m[at] = leaf_per_m as f32;
    (turbid, medium)
}

fn grey(albedo: f64) -> BandScatter {
    let scatter = Scatter { albedo, phase: Phase::ISOTROPIC };
    BandScatter { leaf: scatter, wood: scatter }
}

fn of(leaf_per_m: f64, area_per_m: f64) -> Recollision {
    let (turbid, medium) = site(leaf_per_m, area_per_m);
    Recollision::of(&turbid, 1.0, &medium)
}

fn leaf_in(recollision: &Recollision, albedo: f64) -> (f64, Received) {
    let band = grey(albedo);
    (f64::from(recollision.albedos(&[band])[0][0][0]), recollision.received(0, &band)[0])
}

#[test]
fn leaves_that_are_spread_evenly_are_the_cloud() {
    for depth in [0.01, 0.3, 2.0] {
        let extinction = depth / EDGE_M;
        let (albedo, received) = leaf_in(&of(extinction, 2.0 * extinction), 0.4);
        assert!((albedo - 0.4).abs() < 1e-6, "{depth}: {albedo}");
        assert!((received.total - 1.0).abs() < 1e-5 && (received.beam - 1.0).abs() < 1e-5, "{received:?}");
    }
}

#[test]
fn a_clump_receives_and_sends_out_less_and_both_absorb_the_same() {
    let (extinction, albedo) = (0.6 / EDGE_M, 0.5);
    // A third of what its area would stop if it were even.
    let clump = of(extinction, 6.0 * extinction);
    let (sent, received) = leaf_in(&clump, albedo);
    assert!(sent < 0.6 * albedo, "{sent}");
    assert!((received.beam - 1.0 / 3.0).abs() < 1e-5, "{received:?}");
    assert!(received.total > received.beam, "light within the clump is light that its leaves receive");
    // The cloud absorbs extinction (1 - w') phi, the leaves area / 2 (1 - w) phi_matter, per volume.
    let cloud = extinction * (1.0 - sent);
    let leaves = 3.0 * extinction * (1.0 - albedo) * f64::from(received.total);
    assert!((leaves / cloud - 1.0).abs() < 1e-5, "{leaves}, {cloud}");
}

#[test]
fn a_sheet_that_no_part_of_itself_shades_receives_more_than_the_mean_of_its_site() {
    // A sheet across the site: what is behind its lit side is dark, and so the mean.
    let area = 1.0 / EDGE_M;
    let cubes = Cubes::new(&measured_axes());
    // The silhouette of a flat sheet is half of it, a third of that of the cube.
    let depth =
        (1..4000).map(|i| f64::from(i) * 1e-3).find(|d| cubes.stopped(*d) >= 1.0 / 3.0).expect("in reach");
    let (sent, received) = leaf_in(&of(depth / EDGE_M, area), 0.4);
    assert!((received.beam - (2.0 * depth) as f32).abs() < 1e-3, "{received:?}");
    assert!(sent > 0.4, "the cloud would keep some of what the sheet sends out: {sent}");
}

#[test]
fn what_is_white_stays_invisible() {
    for (extinction, area) in [(1.0, 8.0), (1.0, 2.0), (3.0, 2.0), (1e-6, 5.0), (20.0, 0.1)] {
        let (albedo, received) = leaf_in(&of(extinction, area), 1.0);
        assert!((albedo - 1.0).abs() < 1e-6, "{extinction}, {area}: {albedo}");
        assert!((received.total - 1.0).abs() < 1e-5, "{extinction}, {area}: {received:?}");
    }
}

#[test]
fn no_surface_receives_more_of_the_sky_than_there_is() {
    let recollision = of(4.0 / EDGE_M, 2.0 / EDGE_M);
    let free = recollision.all_received(&grey(0.2), None)[0][0];
    assert!(free.total > 2.0, "{free:?}");
    let [leaf, _] = recollision.all_received(&grey(0.2), Some(&[0.8]))[0];
    assert!((leaf.total * 0.8 - 1.0).abs() < 1e-6, "{leaf:?}");
    assert!((leaf.beam / leaf.total - free.beam / free.total).abs() < 1e-6, "{leaf:?}, {free:?}");
}

#[test]
fn a_splinter_that_no_ray_found_leans_on_the_sites_around() {
    let (mut turbid, mut medium) = site(1.0, 2.0);
    let beside = turbid.grid.index(9, 8, 8);
    (turbid.leaf_per_m[beside], medium.leaf_area_density[beside]) = (1e-7, 1e-4);
    let received = Recollision::of(&turbid, 1.0, &medium).received(1, &grey(0.3))[0];
    assert!((received.total - 1.0).abs() < 0.05, "{received:?}");
    // By itself nothing would be known of it.
    let alone = of(1e-7, 1e-4).received(0, &grey(0.3))[0];
    assert!(alone.total < 0.1, "{alone:?}");
}
