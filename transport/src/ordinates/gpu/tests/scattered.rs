//! Whole solves, of several bands, suns and the sky.

use std::sync::Mutex;

use flb_format::beam::{Beam, Near};
use flb_format::ordinates::Ordinates;
use flb_format::progress::{Cancelled, Progress};

use super::super::super::scatter::{Lit, Scattering};
use super::super::super::suns::SolvePlan;
use super::super::super::{
    Backend, OrdinatesError, OrdinatesSettings, OrdinatesSolution, SunBasis, Surroundings, solve, solve_among,
};
use super::super::bands::scatter;
use super::super::rays::Rays;
use super::*;
use crate::gpu::{GpuError, find_gpu};
use crate::turbid::TurbidMedium;

fn quiet(_: f64) -> Result<(), Cancelled> {
    Ok(())
}

fn settings(backend: Backend) -> OrdinatesSettings {
    OrdinatesSettings { backend, ordinates: Ordinates::Lebedev50, ..OrdinatesSettings::default() }
}

fn assert_alike(found: &OrdinatesSolution, expected: &OrdinatesSolution, name: &str) {
    assert_eq!(found.fields.len(), expected.fields.len());
    assert_eq!(found.reports.len(), expected.reports.len());
    for (found, expected) in found.reports.iter().zip(&expected.reports) {
        assert_eq!((found.passes, found.solves), (expected.passes, expected.solves), "{name}");
        assert!(found.converged);
    }
    let of = |solution: &OrdinatesSolution| -> Vec<Vec<f32>> {
        let total = solution.total.values.iter().flatten().cloned();
        total.chain([solution.total.open_sky.clone()]).collect()
    };
    for (found, expected) in of(found).iter().zip(&of(expected)) {
        let (worst, _) = difference(found, expected);
        assert!(worst < ALIKE, "{name}: {worst:e}");
    }
}

#[test]
fn light_of_suns_and_sky_is_that_of_the_cpu() {
    let medium = medium();
    let suns = |degree| SunBasis::Harmonics { degree, single: true, leaning: false };
    let few = OrdinatesSettings { ordinates: Ordinates::Lattice18, ..settings(Backend::GPU) };
    // The rest of the second band's light is solved for harmonics of the sun, that of the others for every sun. The
    // last one has moments.
    let all = [leaves(0.5), leaves(0.1), bands()[1]];
    let cases = [
        ("default", &all[..], settings(Backend::GPU)),
        ("4 harmonics", &all[..2], OrdinatesSettings { suns: suns(1), rays: 2, ..few.clone() }),
        ("lattice18", &all[2..], OrdinatesSettings { suns: SunBasis::Lattice18, ..few.clone() }),
        ("cut sites", &all[1..2], OrdinatesSettings { parts: 2, suns: suns(1), ..few }),
    ];
    for (name, of_bands, settings) in cases {
        let found = solve(&medium, of_bands, &settings, &quiet).unwrap();
        let on_cpu = OrdinatesSettings { backend: Backend::Cpu, ..settings };
        assert_alike(&found, &solve(&medium, of_bands, &on_cpu, &quiet).unwrap(), name);
    }
}

#[test]
fn sites_of_their_own_and_a_dark_ground_are_those_of_the_cpu() {
    let medium = medium();
    let sites = medium.sites().len();
    let albedos = [(0..sites).map(|site| [(site % 5) as f32 * 0.2, 0.1]).collect::<Vec<_>>()];
    let transmitted = [(0..sites).map(|site| (site % 7) as f32 / 7.0).collect::<Vec<_>>()];
    let surroundings = Surroundings { below: 0.2, albedos: Some(&albedos), transmitted: Some(&transmitted) };
    let solved =
        |backend| solve_among(&medium, &[leaves(0.5)], &surroundings, &settings(backend), &quiet).unwrap();
    assert_alike(&solved(Backend::GPU), &solved(Backend::Cpu), "surroundings");
}

#[test]
fn nothing_is_solved_where_nothing_is() {
    let mut medium = medium();
    medium.leaf_per_m.fill(0.0);
    medium.wood_per_m.fill(0.0);
    let solved = |backend| solve(&medium, &[leaves(0.5)], &settings(backend), &quiet).unwrap();
    assert!(solved(Backend::GPU) == solved(Backend::Cpu));
}

/// Light of all suns in each band, from a GPU.
fn scattered(
    gpu: &Gpu,
    medium: &TurbidMedium,
    of_bands: &[BandScatter],
    progress: &Progress<'_>,
) -> Result<Vec<Lit>, OrdinatesError> {
    scattered_by(std::slice::from_ref(gpu), medium, of_bands, progress)
}

/// The same from several.
fn scattered_by(
    gpus: &[Gpu],
    medium: &TurbidMedium,
    of_bands: &[BandScatter],
    progress: &Progress<'_>,
) -> Result<Vec<Lit>, OrdinatesError> {
    let sites = medium.sites();
    let settings = OrdinatesSettings { ordinates: Ordinates::Lattice18, ..settings(Backend::GPU) };
    let plan = SolvePlan::new(&settings);
    let near = Near::new(medium, &sites, false);
    let beams: Vec<Beam> = plan.suns.iter().map(|sun| near.uncollided(sun.towards, 1)).collect();
    let march = March::new(medium, &sites, settings.ordinates, 1);
    let bands: Vec<Band> = of_bands.iter().map(|scatter| band(medium, scatter)).collect();
    let scattering = Scattering {
        march: &march,
        plan: &plan,
        beams: &beams.iter().collect::<Vec<_>>(),
        below: 1.0,
        open_sky: Some(&march.sky::<1>(1.0).into_flattened()),
        settings: &settings,
        may_be_smooth: true,
    };
    scatter(gpus, &scattering, &bands, progress)
}

#[test]
fn neither_repetition_nor_how_many_go_side_by_side_change_the_bytes() {
    let medium = medium();
    let bands = [leaves(0.2), bands()[1]];
    let mut gpu = gpu();
    let march = March::new(&medium, &medium.sites(), Ordinates::Lattice18, 1);
    let rays = Rays::upload(&gpu.opened, &march, u64::MAX).unwrap();
    let group_bytes = rays.most_of_lane(4) * 4 * LANES as u64;
    let whole = scattered(&gpu, &medium, &bands, &quiet).unwrap();
    for groups in [4, 3, 1] {
        gpu.buffer_bytes = groups * group_bytes;
        let found = scattered(&gpu, &medium, &bands, &quiet).unwrap();
        for (found, whole) in found.iter().zip(&whole) {
            assert!(found.light == whole.light, "{groups} groups differ");
            assert_eq!((found.passes, found.error_estimate), (whole.passes, whole.error_estimate));
        }
    }
    gpu.buffer_bytes = group_bytes - 1;
    let refused = scattered(&gpu, &medium, &bands, &quiet).err().unwrap();
    assert!(matches!(refused, OrdinatesError::Gpu(GpuError::TooLarge { .. })), "{refused:?}");
}

#[test]
fn a_lost_gpu_is_an_error() {
    let gpu = gpu();
    gpu.opened.device.destroy();
    let error = scattered(&gpu, &medium(), &[leaves(0.5)], &quiet).err().unwrap();
    let name = find_gpu().unwrap();
    let is_lost = matches!(&error, OrdinatesError::Gpu(GpuError::Failed { adapter, .. }) if *adapter == name);
    assert!(is_lost, "{error:?}");
}

#[test]
fn progress_never_falls_and_a_solve_stops_when_it_is_told_to() {
    let seen = Mutex::new(vec![]);
    let note = |share: f64| {
        seen.lock().unwrap().push(share);
        Ok(())
    };
    scattered(&gpu(), &medium(), &[leaves(0.2), leaves(0.3)], &note).unwrap();
    let seen = seen.into_inner().unwrap();
    assert!(seen.windows(2).all(|pair| pair[0] <= pair[1]), "{seen:?}");
    assert!(seen.len() == 4 && *seen.last().unwrap() == 1.0, "{seen:?}");
    let error = scattered(&gpu(), &medium(), &[leaves(0.2)], &|_| Err(Cancelled)).err().unwrap();
    assert_eq!(error, OrdinatesError::Cancelled(Cancelled));
}

#[test]
fn several_gpus_of_a_kind_share_bands_to_the_same_bytes() {
    // Devices of one adapter: none of them knows of the others.
    let gpus: Vec<Gpu> = (0..3).map(|_| gpu()).collect();
    let medium = medium();
    let bands = [leaves(0.2), bands()[1], leaves(0.5), leaves(0.1)];
    let seen = Mutex::new(vec![]);
    let note = |share: f64| {
        seen.lock().unwrap().push(share);
        Ok(())
    };
    let found = scattered_by(&gpus, &medium, &bands, &note).unwrap();
    let alone = scattered(&gpus[0], &medium, &bands, &quiet).unwrap();
    assert_eq!(found.len(), bands.len());
    assert!(found.iter().zip(&alone).all(|(found, alone)| found.light == alone.light));
    let seen = seen.into_inner().unwrap();
    assert!(seen.windows(2).all(|pair| pair[0] <= pair[1]) && *seen.last().unwrap() == 1.0, "{seen:?}");
    gpus[1].opened.device.destroy();
    let lost = scattered_by(&gpus, &medium, &bands, &quiet).err().unwrap();
    assert!(matches!(lost, OrdinatesError::Gpu(GpuError::Failed { .. })), "{lost:?}");
    let stopped = scattered_by(&gpus[2..], &medium, &bands, &|_| Err(Cancelled)).err().unwrap();
    assert_eq!(stopped, OrdinatesError::Cancelled(Cancelled));
}
