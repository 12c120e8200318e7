//! What a user sees of solids: baked light on their walls against paths, at rising lattices; and no trace of the
//! lattice on a smooth wall.

use flb_baker::bake::{BakeSettings, ModelSettings, PhysicalSettings, SunChoice};
use flb_eval::figures::{ClassJudgement, Figures};
use flb_fixtures::PlantKind;
use flb_format::light::SunBasis;
use flb_format::matter::{LeafSurface, WoodSurface};
use flb_runtime::{Daylight, SpeciesLight};
use flb_scene::{MaterialClass, Mesh, Plant};
use flb_testkit::solids;
use flb_tests::default_bake::grown;
use flb_tests::mesh_light::{Fineness, Judged, judged};
use flb_transport::ordinates::Ordinates;

fn ball() -> Mesh {
    solids::beside_a_wall(solids::ball())
}

fn settings(lattice: u32) -> BakeSettings {
    let model = PhysicalSettings {
        suns: SunChoice::Fixed(SunBasis::Harmonics { degree: 1, single: true, leaning: false }),
        ordinates: Ordinates::Lebedev50,
        ..PhysicalSettings::default()
    };
    BakeSettings { lattice, voxels: 256, model: ModelSettings::Physical(model), ..BakeSettings::default() }
}

fn of(name: &str, mesh: Mesh, lattice: u32) -> Judged {
    let plant = Plant::new(name, mesh, vec![MaterialClass::Wood]);
    judged(plant, &settings(lattice), Fineness { suns: 1, points: 600, samples: 64 })
}

fn sky(judged: &Judged) -> &Figures {
    judged.mesh.wood.as_ref().and_then(|wood| wood.sky.as_ref()).expect("wood under the sky")
}

#[test]
fn light_on_solids_is_nearer_to_the_truth_the_finer_the_lattice() {
    for (name, mesh, bounds) in [
        ("ball by a wall", ball as fn() -> Mesh, [0.08, 0.05, 0.04]),
        ("pot", solids::pot, [0.3, 0.2, 0.15]),
        ("trunk", solids::trunk, [0.1, 0.06, 0.05]),
    ] {
        let errors = [16, 32, 64].map(|lattice| {
            let judged = of(name, mesh(), lattice);
            let Figures { ratio, rms, .. } = sky(&judged);
            println!("{name} {lattice}: ratio {:.3}, rms {:.3}, {} bytes", ratio[1], rms[1], judged.bytes);
            assert!((ratio[1] - 1.0).abs() < bounds[0], "{name} at lattice {lattice}: {ratio:?}");
            rms[1]
        });
        for (error, bound) in errors.into_iter().zip(bounds) {
            assert!(error < bound, "{name}: {errors:?}");
        }
        assert!(errors[2] < errors[0], "{name}: {errors:?}");
    }
}

#[test]
fn a_flat_leaf_receives_the_sky_that_it_sees_whichever_way_it_faces() {
    const HALF: f32 = std::f32::consts::FRAC_1_SQRT_2;
    // Level and upright, it lies in a face between two layers of sites.
    for (name, right, up, bound) in [
        ("level", [1.0, 0.0, 0.0], [0.0, 0.0, 1.0], 0.02),
        ("upright", [1.0, 0.0, 0.0], [0.0, 1.0, 0.0], 0.02),
        ("leaning", [1.0, 0.0, 0.0], [0.0, HALF, HALF], 0.02),
        ("across the lattice", [HALF, 0.0, HALF], [0.0, 1.0, 0.0], 0.02),
    ] {
        let plant = Plant::new(name, solids::sheet(right, up), vec![MaterialClass::Leaf]);
        let model = ModelSettings::Physical(PhysicalSettings::default());
        let settings = BakeSettings { model, ..settings(32) };
        let judged = judged(plant, &settings, Fineness { suns: 6, points: 400, samples: 16 });
        let leaf = judged.mesh.leaf.expect("a leaf");
        let (sky, seen) = (leaf.sky.expect("under the sky"), leaf.seen.expect("under suns"));
        println!("{name}: sky {:.3?}, suns {:.3?}, rms {:.3?}", sky.ratio, seen.ratio, seen.rms);
        for band in 0..3 {
            assert!((sky.ratio[band] - 1.0).abs() < bound, "{name}: {:?}", sky.ratio);
            assert!(sky.rms[band] < bound + 0.01, "{name}: {:?}", sky.rms);
        }
    }
}

/// Most that a white plant may differ from the white sky around it: in the mean, and root mean square over points.
const FURNACE: [f64; 2] = [0.02, 0.04];

#[test]
fn a_white_plant_is_invisible_under_a_white_sky() {
    let mut plant = grown(PlantKind::Oak, 6_000);
    for band in &mut plant.surfaces.bands {
        band.leaf = LeafSurface { reflectance: 0.6, transmittance: 0.4 };
        band.wood = WoodSurface { reflectance: 1.0 };
    }
    // Texels of bark and leaves tint: white ones do not.
    plant.classed.mesh.materials.iter_mut().for_each(|material| material.color_texture = None);
    let judged = judged(plant, &settings(32), Fineness { suns: 1, points: 600, samples: 16 });
    let of = |class: &Option<ClassJudgement>| class.as_ref().and_then(|class| class.sky.clone());
    let [leaf, wood] = [&judged.mesh.leaf, &judged.mesh.wood].map(|class| of(class).expect("points of both"));
    for (name, figures) in [("leaf", leaf), ("wood", wood)] {
        println!("{name}: truth {:.4?}, ratio {:.4?}, rms {:.4?}", figures.truth, figures.ratio, figures.rms);
        for band in 0..3 {
            // A surface in a fluence of 1 from all sides receives a quarter.
            let found = figures.truth[band] * figures.ratio[band];
            assert!((4.0 * found - 1.0).abs() < FURNACE[0], "{name}: {found} of 0.25");
            assert!(figures.rms[band] < FURNACE[1], "{name}: {}", figures.rms[band]);
        }
    }
}

#[test]
fn the_lattice_leaves_no_rings_on_a_smooth_wall() {
    let judged = of("ball", ball(), 32);
    let light = SpeciesLight::load(&judged.library, 0).expect("a valid file");
    let even = Daylight { towards_sun: [0.0, 1.0, 0.0], sun: 0.0, sky: 1.0 };
    let lit = light.lit_by_in_model(&even).expect("a direction");
    let spacing_m = judged.library.container().species()[0].meta.grid.spacing_m;
    let offset_m = f64::from(judged.surfaces.solid_offset_m.expect("light at solids is off them"));
    // Around the ball at half its height and along a meridian: 16 samples a site.
    const PER_SITE: f64 = 16.0;
    let radius = 0.5;
    let count = (std::f64::consts::TAU * radius / spacing_m * PER_SITE) as usize;
    for upright in [false, true] {
        let sample = |k: usize| {
            let turn = std::f64::consts::TAU * k as f64 / count as f64;
            let normal = match upright {
                false => [libm::cos(turn), 0.0, libm::sin(turn)],
                true => [libm::cos(turn) * 0.6, libm::sin(turn), libm::cos(turn) * 0.8],
            };
            let middle = [0.0, radius, 0.0];
            let at = std::array::from_fn(|axis| (middle[axis] + (radius + offset_m) * normal[axis]) as f32);
            let mut rgb = [0.0; 3];
            lit.at(at, &mut rgb);
            f64::from(rgb[1])
        };
        let values: Vec<f64> = (0..count).map(sample).collect();
        let mean = values.iter().sum::<f64>() / count as f64;
        // The share of the light that waves of half to two sites have: its rms, over the mean.
        let sites = count as f64 / PER_SITE;
        let amplitude = |waves: usize| {
            let sum = |f: fn(f64) -> f64| -> f64 {
                let phase = |k: usize| std::f64::consts::TAU * (waves * k) as f64 / count as f64;
                values.iter().enumerate().map(|(k, value)| value * f(phase(k))).sum()
            };
            let (a, b) = (sum(libm::cos), sum(libm::sin));
            2.0 * libm::sqrt(a * a + b * b) / count as f64
        };
        let power: f64 =
            ((sites / 2.0) as usize..=(2.0 * sites) as usize).map(amplitude).map(|a| a * a / 2.0).sum();
        let ripple = libm::sqrt(power) / mean;
        println!("upright {upright}: mean {mean:.4}, ripple {ripple:.4}");
        assert!((0.7..0.98).contains(&mean), "{mean}");
        let [least, most] =
            [f64::min, f64::max].map(|pick| values.iter().copied().reduce(pick).expect("values"));
        assert!(most - least > 0.2, "the wall shades one side: {least} to {most}");
        assert!(ripple < 0.02, "{ripple} of the light has the lattice's wavelength");
    }
}
