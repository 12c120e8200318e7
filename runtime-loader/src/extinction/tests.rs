use flb_format::matter::LeafAngles;

use super::*;
use crate::near_beam::dense;

const N: u32 = 32;

/// Clumps of leaves and a stem, most blocks empty.
fn clumps() -> TurbidMedium {
    let grid = Grid { lattice: N, origin_m: [-0.8, 0.1, 2.0], spacing_m: 0.25 };
    let (mut leaf_per_m, mut wood_per_m) = (vec![0.0; grid.sites()], vec![0.0; grid.sites()]);
    for site in 0..grid.sites() {
        let [x, y, z] = grid.site(site);
        let noise = crate::plants::noise(site as u32, 5);
        let is_clump = crate::plants::noise(x / 5 + y / 5 * 7 + z / 5 * 49, 6) < 0.2;
        if is_clump && noise < 0.6 {
            leaf_per_m[site] = noise;
        }
        if (15..17).contains(&x) && (15..17).contains(&z) && y < 20 {
            wood_per_m[site] = 3.0;
        }
    }
    TurbidMedium { grid, leaf_per_m, wood_per_m, angles: LeafAngles::planophile() }
}

/// Points inside and outside, and directions: any, along axes, and through edges of sites.
fn rays() -> impl Iterator<Item = ([f32; 3], [f32; 3])> {
    let random = |i: u32| {
        let at = |k: u32| crate::plants::noise(i * 6 + k, 9);
        let point = [at(0), at(1), at(2)].map(|c| (c * 1.5 - 0.25) * N as f32);
        let mut direction = [at(3), at(4), at(5)].map(|c| c * 2.0 - 1.0);
        match i % 8 {
            0 => direction = [0.0, direction[1].signum(), 0.0],
            1 => direction[(i / 8 % 3) as usize] = 0.0,
            2 => direction = direction.map(f32::signum),
            _ => {}
        }
        let length = direction.iter().map(|c| c * c).sum::<f32>().sqrt();
        let point = if i.is_multiple_of(5) { point.map(f32::round) } else { point };
        (point, direction.map(|c| c / length))
    };
    (0..20_000).map(random)
}

#[test]
fn a_ray_through_blocks_meets_what_one_through_all_sites_does() {
    let turbid = clumps();
    let extinction = Extinction::of(&turbid);
    assert!(extinction.map().len() < 300, "of 512 blocks most of the air is left out");
    let mut farthest = 0.0_f64;
    for (point, direction) in rays() {
        let expected = dense::depth(&turbid, point.map(f64::from), direction.map(f64::from));
        let Travel::Out { depth } = extinction.travel(&extinction.ray(point, direction), f32::INFINITY)
        else {
            panic!("{point:?} {direction:?}: nothing stops a ray that may cross any depth");
        };
        // Along a face between two sites, either is right.
        let on_face = (0..3).any(|axis| direction[axis].abs() < 1e-6 && point[axis].fract() == 0.0);
        let off = (f64::from(depth) - expected).abs();
        assert!(on_face || off < 2e-5 * expected.max(1.0), "{point:?} {direction:?}: {depth} for {expected}");
        farthest = farthest.max(expected);
    }
    assert!(farthest > 5.0, "some rays go down the stem: {farthest}");
}

#[test]
fn a_ray_stops_where_it_has_crossed_what_it_may() {
    let extinction = Extinction::of(&clumps());
    let mut stopped = 0;
    for (point, direction) in rays() {
        let ray = extinction.ray(point, direction);
        let Travel::Stopped { t } = extinction.travel(&ray, 0.3) else { continue };
        stopped += 1;
        // The same ray, cut there by starting at its end and going back, crosses as much.
        let end = std::array::from_fn(|axis| point[axis] + t * direction[axis]);
        let Travel::Out { depth: behind } = extinction.travel(&Ray { point: end, ..ray }, f32::INFINITY)
        else {
            panic!("nothing stops it");
        };
        let Travel::Out { depth: whole } = extinction.travel(&ray, f32::INFINITY) else {
            panic!("nothing stops it");
        };
        assert!((whole - behind - 0.3).abs() < 1e-3, "{point:?} {direction:?}: {whole} - {behind}");
    }
    assert!(stopped > 1000, "{stopped}");
}

#[test]
fn what_is_not_a_number_ends() {
    let extinction = Extinction::of(&clumps());
    for value in [f32::NAN, f32::INFINITY, f32::NEG_INFINITY, f32::MAX] {
        for axis in 0..3 {
            let (mut point, mut direction) = ([8.0; 3], [0.6, 0.0, 0.8]);
            point[axis] = value;
            let ray = Ray { point, direction, relative: 1.0 };
            assert_eq!(extinction.travel(&ray, 1.0), Travel::Out { depth: 0.0 });
            direction[axis] = value;
            extinction.travel(&Ray { point: [8.0; 3], direction, relative: 1.0 }, f32::INFINITY);
        }
    }
}

#[test]
fn nothing_takes_a_block_and_stops_nothing() {
    let grid = Grid { lattice: 16, origin_m: [0.0; 3], spacing_m: 1.0 };
    let none = || vec![0.0; grid.sites()];
    let turbid =
        TurbidMedium { grid, leaf_per_m: none(), wood_per_m: none(), angles: LeafAngles::spherical() };
    let extinction = Extinction::of(&turbid);
    let ray = extinction.ray([8.0; 3], [0.0, 1.0, 0.0]);
    assert_eq!(extinction.travel(&ray, 0.0), Travel::Out { depth: 0.0 });
    assert_eq!((extinction.blocks().len(), extinction.depths().len()), (1, 0));
}

#[test]
fn sites_keep_their_depths_and_air_takes_no_memory() {
    let turbid = clumps();
    let extinction = Extinction::of(&turbid);
    let dense = extinction.to_dense();
    for (found, expected) in
        [(&dense.leaf_per_m, &turbid.leaf_per_m), (&dense.wood_per_m, &turbid.wood_per_m)]
    {
        let off = found.iter().zip(expected).map(|(found, expected)| (found - expected).abs());
        assert!(off.fold(0.0, f32::max) < 1e-6);
    }
    assert_eq!(extinction.depths().len(), turbid.sites().len());
    let all =
        extinction.blocks().len() as u64 * BLOCK_BYTES + extinction.depths().len() as u64 * DEPTHS_BYTES;
    assert_eq!(extinction.size_bytes() as u64, all + extinction.map().size_bytes() as u64);
}
