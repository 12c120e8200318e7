use super::*;

/// Midpoint sum of `f` over 0..=1.
fn mean(f: impl Fn(f64) -> f64) -> f64 {
    const STEPS: usize = 20_000;
    (0..STEPS).map(|i| f((i as f64 + 0.5) / STEPS as f64)).sum::<f64>() / STEPS as f64
}

#[test]
fn leaves_of_any_inclination_show_half_of_their_area_in_the_mean() {
    for angles in [LeafAngles::spherical(), LeafAngles::planophile(), LeafAngles::erectophile()] {
        assert!((mean(|up| angles.relative(up)) - 1.0).abs() < 1e-4);
        assert!((angles.shares().iter().sum::<f64>() - 1.0).abs() < 1e-12);
    }
}

#[test]
fn flat_leaves_block_light_from_above_as_their_cosine_says() {
    let mut areas = [0.0; INCLINATIONS];
    areas[INCLINATIONS - 1] = 3.0;
    let flat = LeafAngles::from_areas(areas).unwrap();
    // G of flat leaves is |up|; the last bin also holds leaves a little off.
    for up in [0.3, 0.7, 1.0] {
        assert!((flat.relative(up) - 2.0 * up).abs() < 0.04, "{up}: {}", flat.relative(up));
    }
    assert!(LeafAngles::planophile().relative(1.0) > 1.5 && LeafAngles::erectophile().relative(1.0) < 0.9);
}

#[test]
fn areas_that_are_no_distribution_are_refused() {
    let mut areas = [0.0; INCLINATIONS];
    assert!(LeafAngles::from_areas(areas).is_none());
    areas[0] = f64::NAN;
    assert!(LeafAngles::from_areas(areas).is_none());
    areas[0] = -1.0;
    assert!(LeafAngles::from_areas(areas).is_none());
}

#[test]
fn extinction_follows_the_direction_for_leaves_only() {
    let grid = Grid { lattice: 16, origin_m: [0.0; 3], spacing_m: 0.1 };
    let mut leaf_per_m = vec![0.0; grid.sites()];
    let mut wood_per_m = vec![0.0; grid.sites()];
    (leaf_per_m[5], wood_per_m[5], wood_per_m[9]) = (2.0, 1.0, 4.0);
    let turbid = TurbidMedium { grid, leaf_per_m, wood_per_m, angles: LeafAngles::planophile() };
    assert_eq!(turbid.sites(), [5, 9]);
    assert_eq!(turbid.extinction(5), 3.0);
    assert_eq!(turbid.extinction_along(9, 1.0), 4.0);
    let above = 2.0 * turbid.angles.relative(1.0) + 1.0;
    assert!((turbid.extinction_along(5, -1.0) - above).abs() < 1e-12);
}
