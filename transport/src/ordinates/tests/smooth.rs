//! Light that was scattered often, solved for harmonics of the sun in place of every sun.

use super::*;

/// Leaves that let a third of what they scatter through, and wood.
fn leaves(albedo: f64) -> BandScatter {
    let scatter = |albedo, transmitted| Scatter { albedo, phase: Phase::BiLambert { transmitted } };
    BandScatter { leaf: scatter(albedo, 0.33), wood: scatter(0.15, 0.0) }
}

/// A medium, a third of whose sites are wood.
fn tree(lattice: u32) -> TurbidMedium {
    with_wood(lattice, 3)
}

/// A medium of which one site in `every` is wood.
fn with_wood(lattice: u32, every: usize) -> TurbidMedium {
    let mut medium = clumps(lattice);
    for (site, wood) in medium.wood_per_m.iter_mut().enumerate() {
        if site % every == 0 {
            std::mem::swap(wood, &mut medium.leaf_per_m[site]);
        }
    }
    medium
}

/// Scattered light of each sun and of the sky.
fn light(medium: &TurbidMedium, bands: &[BandScatter], may_be_smooth: bool) -> (Vec<Lit>, Vec<Beam>) {
    let sites = medium.sites();
    let settings = OrdinatesSettings { ordinates: Ordinates::Lebedev50, ..OrdinatesSettings::default() };
    let plan = suns::SolvePlan::new(&settings);
    let near = Near::new(medium, &sites, false);
    let beams: Vec<Beam> = plan.suns.iter().map(|sun| near.uncollided(sun.towards, 2)).collect();
    let march = March::new(medium, &sites, settings.ordinates, 1);
    let own = Own { albedos: None, transmitted: None };
    let bands: Vec<Band> = bands.iter().map(|band| Band::new(medium, &sites, band, &own)).collect();
    let scattering = Scattering {
        march: &march,
        plan: &plan,
        beams: &beams.iter().collect::<Vec<_>>(),
        below: 1.0,
        open_sky: Some(&march.sky::<1>(1.0).into_flattened()),
        settings: &settings,
        may_be_smooth,
    };
    (scattering.scatter(&bands, &|_| Ok(())).unwrap(), beams)
}

#[test]
fn the_rest_is_nearly_what_each_sun_would_have_alone() {
    let bands = [0.06, 0.275, 0.3].map(leaves);
    let medium = tree(24);
    let (smooth, beams) = light(&medium, &bands, true);
    let (alone, _) = light(&medium, &bands, false);
    for ((smooth, alone), most) in smooth.iter().zip(&alone).zip([0.0003, 0.003, 0.006]) {
        assert_eq!(smooth.light.len(), 56);
        // Suns that are held out and the sky go to the end by themselves.
        for (smooth, alone) in smooth.light[50..].iter().zip(&alone.light[50..]) {
            assert!(relative_rms(smooth, alone, &vec![0.0; alone.len()]) < 2e-3);
        }
        let mut worst = 0.0_f64;
        for ((smooth, alone), beam) in smooth.light.iter().zip(&alone.light).zip(&beams) {
            worst = worst.max(relative_rms(smooth, alone, &beam.mean));
            let sum = |light: &[f32]| light.iter().map(|light| f64::from(*light)).sum::<f64>();
            let share = sum(smooth) / sum(alone);
            assert!((share - 1.0).abs() < 0.01, "a sun has {share} of its light");
        }
        assert!(worst < most, "{worst}, at most {most}");
        assert!(worst > 0.0, "nothing was projected");
    }
}

#[test]
fn a_few_pale_sites_do_not_keep_the_rest_from_being_smooth() {
    let bark = Scatter { albedo: 0.7, phase: Phase::BiLambert { transmitted: 0.0 } };
    let bands = [BandScatter { wood: bark, ..leaves(0.25) }];
    let medium = with_wood(24, 100);
    let (smooth, beams) = light(&medium, &bands, true);
    let (alone, _) = light(&medium, &bands, false);
    assert!(smooth[0].light[..50] != alone[0].light[..50], "nothing was projected");
    for ((smooth, alone), beam) in smooth[0].light.iter().zip(&alone[0].light).zip(&beams) {
        assert!(relative_rms(smooth, alone, &beam.mean) < 0.004);
    }
}

#[test]
fn bright_leaves_are_solved_for_every_sun() {
    let bands = [leaves(0.9)];
    let medium = tree(16);
    let (smooth, _) = light(&medium, &bands, true);
    let (alone, _) = light(&medium, &bands, false);
    assert!(smooth[0].light == alone[0].light);
}

#[test]
fn bands_side_by_side_have_the_light_of_each_alone() {
    let bands = [0.06, 0.9, 0.3].map(leaves);
    let medium = tree(16);
    let (together, _) = light(&medium, &bands, true);
    for (band, together) in bands.iter().zip(&together) {
        assert!(light(&medium, &[*band], true).0[0].light == together.light);
    }
}
