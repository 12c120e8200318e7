//! Laws of the matter that scene light is solved in. What the light itself obeys is tested with all rooms together
//! (`tests/tests/it/scene_light.rs`).

use std::path::PathBuf;

use flb_format::bases::BaseSet;
use flb_format::matter::Class;
use flb_format::{Placement, Transform};

use super::*;
use flb_scene::scene::{self, HeightMap, Scene, SceneSky, SceneSpecies, Terrain, light_digest};
use flb_transport::ordinates::{FieldKind, Ordinates, OrdinatesSettings, SunBasis, solve_among};

const HOME: [[f64; 3]; 3] = [[1.0, 0.0, 0.0], [0.0, 1.0, 0.0], [0.0, 0.0, 1.0]];
/// About no axis in particular.
const TILTED: [[f64; 3]; 3] = [[0.36, 0.48, -0.8], [-0.8, 0.6, 0.0], [0.48, 0.64, 0.6]];

fn instance(position_m: [f64; 3], scale: f64) -> Placement {
    Placement { species: 0, transform: Transform { rotation: HOME, position_m, scale } }
}

/// A ball of leaves with a core of wood, its lowest point the origin.
fn ball(lattice: u32, radius_m: f64, per_m: f32) -> TurbidMedium {
    let spacing_m = 2.0 * radius_m / f64::from(lattice - 6);
    let half = spacing_m * f64::from(lattice) / 2.0;
    let grid = Grid { lattice, origin_m: [-half, radius_m - half, -half], spacing_m };
    let zeros = || vec![0.0; grid.sites()];
    let (mut leaf_per_m, mut wood_per_m) = (zeros(), zeros());
    for z in 0..lattice {
        for y in 0..lattice {
            for x in 0..lattice {
                let from = [x, y, z].map(|c| (f64::from(c) + 0.5) * spacing_m - half);
                let square = from.iter().map(|c| c * c).sum::<f64>();
                let site = grid.index(x, y, z);
                if square < radius_m * radius_m {
                    leaf_per_m[site] = per_m;
                }
                if square < radius_m * radius_m / 16.0 {
                    wood_per_m[site] = 2.0 * per_m;
                }
            }
        }
    }
    TurbidMedium { grid, leaf_per_m, wood_per_m, angles: LeafAngles::spherical() }
}

fn plant(turbid: &TurbidMedium) -> Plant<'_> {
    Plant { name: "ball", turbid }
}

fn surfaces([reflectance, transmittance, wood]: [f64; 3]) -> BandSurfaces {
    band(reflectance, transmittance, wood)
}

fn plain(share: f64) -> Ground {
    let terrain = Terrain::Plane { height_m: 0.0 };
    Ground::of(&scene::Ground { terrain, color: [share; 3] }).expect("a plane")
}

/// Leaf and wood, m^2; the ground does not count.
fn areas(turbid: &TurbidMedium, is_ground: &[bool]) -> [f64; 2] {
    let volume = turbid.grid.spacing_m * turbid.grid.spacing_m * turbid.grid.spacing_m;
    [&turbid.leaf_per_m, &turbid.wood_per_m].map(|per_m| {
        let plants =
            per_m.iter().enumerate().filter(|(site, _)| !is_ground.get(*site).copied().unwrap_or(false));
        plants.map(|(_, per_m)| f64::from(*per_m) * volume).sum()
    })
}

/// Each site is rounded to an f32.
const ROUNDING: f64 = 1e-6;

#[track_caller]
fn assert_near(found: f64, expected: f64, tolerance: f64) {
    assert!((found / expected - 1.0).abs() < tolerance, "{found}, expected {expected}");
}

#[test]
fn area_is_kept_and_grows_with_the_square_of_the_scale() {
    let turbid = ball(32, 2.0, 0.7);
    let own = areas(&turbid, &[]);
    let plants = [plant(&turbid)];
    let turned = Placement {
        species: 0,
        transform: Transform { rotation: TILTED, ..instance([3.21, 0.43, -1.7], 1.3).transform },
    };
    for (instances, larger) in [
        (vec![instance([0.0; 3], 1.0)], 1.0),
        (vec![turned], 1.69),
        (vec![turned, instance([0.1; 3], 0.5), turned], 3.63),
    ] {
        // As coarse as sites can be, and finer than the plant's own.
        for (lattice, ground) in [(16, None), (128, None), (32, Some(plain(0.2)))] {
            let scenery = Scenery::new(&plants, &instances, ground.as_ref(), lattice).expect("a scene");
            let stand = scenery.stand(&[1.0], &[surfaces([0.1; 3])]);
            for (found, own) in areas(&stand.turbid, &stand.is_ground).into_iter().zip(own) {
                assert_near(found, own * larger, ROUNDING);
            }
        }
    }
}

#[test]
fn instances_in_another_order_make_the_same_stand() {
    let turbid = ball(16, 1.0, 0.7);
    let plants = [plant(&turbid)];
    let mut instances: Vec<Placement> = (0..9)
        .map(|i| instance([f64::from(i) * 0.7, 0.0, f64::from(i * i % 5)], 1.0 + 0.1 * f64::from(i)))
        .collect();
    let stand = |instances: &[Placement]| {
        Scenery::new(&plants, instances, None, 32).expect("a scene").stand(&[1.0], &[surfaces([0.1; 3])])
    };
    let one = stand(&instances);
    instances.reverse();
    let other = stand(&instances);
    assert_eq!(one.turbid.grid, other.turbid.grid);
    for (a, b) in one.turbid.leaf_per_m.iter().zip(&other.turbid.leaf_per_m) {
        assert!((a - b).abs() <= 1e-6 * a.max(*b), "{a}, {b}");
    }
}

#[test]
fn a_scene_twice_as_large_has_sites_of_the_same_depth() {
    let turbid = ball(16, 1.0, 0.7);
    let plants = [plant(&turbid)];
    let ground = plain(0.2);
    let at = |times: f64| {
        let places = [[0.0, 0.0, 0.0], [2.5, 0.5, 1.0]];
        let instances = places.map(|place| instance(place.map(|c| c * times), times));
        let scenery = Scenery::new(&plants, &instances, Some(&ground), 32).expect("a scene");
        let alone = scenery.as_open(0, scenery.coarse(0).expect("a plant"));
        let stand = scenery.stand(&[alone.factor], &[surfaces([0.1; 3])]);
        (stand, alone)
    };
    let ((one, alone), (two, alone_of_two)) = (at(1.0), at(2.0));
    assert_eq!(one.turbid.grid.spacing_m * 2.0, two.turbid.grid.spacing_m);
    assert_eq!(one.albedos, two.albedos);
    let doubled: Vec<f32> = two.turbid.leaf_per_m.iter().map(|per_m| per_m * 2.0).collect();
    assert_eq!(one.turbid.leaf_per_m, doubled);
    // In its own metres the plant alone is the same.
    assert_eq!(alone, alone_of_two);
}

#[test]
fn mirrored_places_make_mirrored_matter() {
    let turbid = ball(16, 1.0, 0.7);
    let plants = [plant(&turbid)];
    let instances = [instance([-2.0, 0.0, 0.0], 1.0), instance([2.0, 0.0, 0.0], 1.0)];
    let stand =
        Scenery::new(&plants, &instances, None, 32).expect("a scene").stand(&[1.0], &[surfaces([0.1; 3])]);
    let n = stand.turbid.grid.lattice;
    for site in 0..stand.turbid.grid.sites() as u32 {
        let [x, y, z] = stand.turbid.grid.site(site as usize);
        let mirrored = stand.turbid.grid.index(n - 1 - x, y, z);
        let [here, there] = [site as usize, mirrored].map(|site| stand.turbid.leaf_per_m[site]);
        assert!((here - there).abs() <= 1e-5 * here.max(there), "{x}, {y}, {z}: {here}, {there}");
    }
}

#[test]
fn a_coarse_crown_is_as_open_as_the_fine_one_and_no_matter_is_made() {
    // Every other plane of sites is dense, and light passes between.
    let mut gappy = ball(64, 4.0, 2.0);
    let n = gappy.grid.lattice as usize;
    (0..gappy.grid.sites()).filter(|site| site / n % 8 < 4).for_each(|site| gappy.leaf_per_m[site] = 0.0);
    gappy.wood_per_m.fill(0.0);
    let instances = [instance([-15.0, 0.0, 0.0], 1.0), instance([15.0, 0.0, 0.0], 1.0)];
    let alone = |turbid: &TurbidMedium, lattice: u32| {
        let plants = [plant(turbid)];
        let scenery = Scenery::new(&plants, &instances, None, lattice).expect("a scene");
        scenery.as_open(0, scenery.coarse(0).expect("a plant"))
    };
    let crown = alone(&gappy, 64);
    assert!((crown.gap - crown.mesh_gap).abs() < 1e-4, "{} and {}", crown.gap, crown.mesh_gap);
    assert!(crown.measured_gap < crown.mesh_gap && crown.factor < 1.0, "{}", crown.factor);
    // A ball has no gaps to fill, and one smaller than a site is all but lost in it.
    let whole = alone(&ball(32, 4.0, 0.8), 64);
    assert!((0.95..=1.0).contains(&whole.factor), "{}", whole.factor);
    let lost = alone(&ball(32, 0.5, 0.8), 16);
    assert_eq!((lost.factor, lost.gap, lost.turbid.grid.lattice), (1.0, lost.measured_gap, 16));
}

#[test]
fn matter_below_the_ground_comes_to_lie_on_it() {
    let turbid = ball(16, 1.0, 0.7);
    let plants = [plant(&turbid)];
    let ground = plain(0.3);
    let instances = [instance([0.0, -0.8, 0.0], 1.0), instance([6.0, 0.0, 3.0], 1.0)];
    let scenery = Scenery::new(&plants, &instances, Some(&ground), 32).expect("a scene");
    let stand = scenery.stand(&[1.0], &[surfaces([0.1, 0.1, 0.3])]);
    let level = scenery.grid().lattice_from_model([0.0; 3])[1];
    assert!((level - level.round()).abs() < 1e-9, "the plane lies between sites: {level}");
    for (site, is_ground) in stand.is_ground.iter().enumerate() {
        let y = f64::from(stand.turbid.grid.site(site)[1]);
        let has_leaves = stand.turbid.leaf_per_m[site] > 0.0;
        let is_wrong = if y < level { has_leaves } else { *is_ground };
        assert!(!is_wrong, "site {site}");
    }
    let ground_albedo = stand.albedos.iter().map(|albedo| albedo[1]).fold(0.0, f32::max);
    assert!(ground_albedo > 0.5 && stand.below == 0.3, "{ground_albedo}, {}", stand.below);
}

#[test]
fn sites_of_two_species_scatter_as_the_mean_of_both_by_area() {
    let (turbid, denser) = (ball(16, 1.0, 0.5), ball(16, 1.0, 1.5));
    let plants = [plant(&turbid), plant(&denser)];
    let other = Placement { species: 1, transform: instance([0.0; 3], 1.0).transform };
    let instances = [instance([0.0; 3], 1.0), other];
    let stand = Scenery::new(&plants, &instances, None, 16)
        .expect("a scene")
        .stand(&[1.0; 2], &[surfaces([0.1, 0.1, 0.0]), surfaces([0.3, 0.3, 0.0])]);
    // A quarter is of albedo 0.2, three of 0.6.
    assert!(stand.albedos.iter().all(|albedo| (albedo[0] - 0.5).abs() < 1e-5), "{:?}", stand.albedos[0]);
    let leaf = stand.surfaces.leaf;
    assert_near(leaf.reflectance + leaf.transmittance, 0.5, 1e-6);
}

/// The ground is a few layers of scattering matter and no surface, and reflects the sky less than the sun.
const OFF_IN_SUN: f64 = 0.15;
const OFF_UNDER_SKY: f64 = 0.45;

#[test]
fn ground_throws_back_about_what_its_reflectance_says() {
    // Balls that are all but nothing hear what comes from the ground.
    let turbid = ball(16, 1.0, 1e-6);
    let plants = [plant(&turbid)];
    for share in [0.05, 0.22, 0.4] {
        let ground = plain(share);
        let instances =
            [[-8.0, 0.0, -8.0], [8.0, 0.0, 8.0], [0.0; 3]].map(|position_m| instance(position_m, 1.0));
        let scenery = Scenery::new(&plants, &instances, Some(&ground), 32).expect("a scene");
        let stand = scenery.stand(&[1.0], &[surfaces([0.0; 3])]);
        let settings = OrdinatesSettings {
            ordinates: Ordinates::Lebedev50,
            rays: 2,
            suns: SunBasis::Lattice18,
            bases: BaseSet::ALL,
            field: FieldKind::Scattered,
            ..OrdinatesSettings::default()
        };
        let solution =
            solve_among(&stand.turbid, &[stand.scatter()], &stand.surroundings(), &settings, &|_| Ok(()));
        let [x, y, z] = scenery.grid().lattice_from_model([0.1; 3]).map(|c| c as u32);
        let site = scenery.grid().index(x, y, z);
        let fields = solution.expect("light").fields;
        // Over a wide Lambertian plain: twice the reflectance times the cosine; under half a sky of fluence 1, half of
        // it.
        let [sky, overhead, slanted] = [0, 4, 8].map(|item| f64::from(fields[item].1.value(0, site)));
        assert_near(overhead / 2.0, share, OFF_IN_SUN);
        assert_near(slanted / 2.0_f64.sqrt(), share, OFF_IN_SUN);
        assert_near(2.0 * (sky - 0.5), share, OFF_UNDER_SKY);
    }
}

#[test]
fn what_makes_no_scene_is_refused_by_name() {
    let turbid = ball(16, 1.0, 0.5);
    let plants = [plant(&turbid)];
    let one = [instance([0.0; 3], 1.0)];
    let refused = |plants: &[Plant], instances: &[Placement], lattice| {
        Scenery::new(plants, instances, None, lattice).unwrap_err().to_string()
    };
    assert_eq!(refused(&plants, &[], 32), "the scene has no instances, expected one or more");
    let expected = "a lattice of 48 sites, expected a power of two from 16 to 256";
    assert_eq!(refused(&plants, &one, 48), expected);
    let stranger = [one[0], Placement { species: 3, ..one[0] }];
    assert_eq!(refused(&plants, &stranger, 32), "instance 1 is of species 3, expected one of 0 to 0");
    let nothing = ball(16, 1.0, 0.0);
    let expected = "species \"ball\" holds no matter, expected extinction above 0 in some site";
    assert_eq!(refused(&[plant(&nothing)], &one, 32), expected);
    // A pole that lies aslant is longer than the box around it.
    let mut pole = ball(16, 1.0, 0.0);
    (2..14).for_each(|y| pole.wood_per_m[pole.grid.index(8, y, 8)] = 1.0);
    let plants = [plant(&pole)];
    let aslant = [Placement { transform: Transform { rotation: TILTED, ..one[0].transform }, ..one[0] }];
    let error =
        Scenery::new(&plants, &aslant, None, 256).expect("a scene").coarse(0).unwrap_err().to_string();
    let [start, end] =
        ["species \"ball\" covers ", " sites of the scene's lattice along an edge, expected up to 250"];
    assert!(error.starts_with(start) && error.ends_with(end), "{error}");
    let mut surfaces = flb_scene::leaf::knapp_carter();
    surfaces.bands.pop();
    let expected =
        "species \"oak\" has the bands R, G, expected R, G and B among them, of which luminance is made";
    assert_eq!(luminance("oak", &surfaces).unwrap_err().to_string(), expected);
    // By their names, whatever their order.
    let mut turned = flb_scene::leaf::knapp_carter();
    let of_colors = luminance("oak", &turned).expect("R, G, B");
    turned.bands.reverse();
    turned
        .bands
        .insert(1, flb_format::matter::BandSurfaces { name: "NIR".to_owned(), ..turned.bands[0].clone() });
    assert_eq!(luminance("oak", &turned).expect("B, NIR, G, R"), of_colors);
    let file = PathBuf::from("no-such-map.png");
    let map = HeightMap { file, origin_m: [0.0; 3], size_m: [1.0; 2], height_m: [0.0, 1.0] };
    let ground = Ground::of(&scene::Ground { terrain: Terrain::Map(map), color: [0.2; 3] });
    assert!(ground.unwrap_err().to_string().contains("no-such-map.png"));
}

#[test]
fn densities_of_lattice_plants_let_as_much_pass_on_sites_of_any_size() {
    // A block of leaves beside one of wood.
    let grid = Grid { lattice: 32, origin_m: [-4.0, 0.0, -4.0], spacing_m: 0.25 };
    let mut fine = flb_format::Medium::empty(grid);
    for z in 8..24 {
        for y in 8..24 {
            for x in 8..24 {
                let site = grid.index(x, y, z);
                let is_wood = x >= 16;
                fine.density[site] = if is_wood { 0.3 } else { 0.1 };
                fine.class[site] = if is_wood { Class::Wood } else { Class::Leaf };
            }
        }
    }
    let turbid = extinction(&fine);
    let again = coarse_medium(&turbid);
    assert_eq!(again.class, fine.class);
    for (found, density) in again.density.iter().zip(&fine.density) {
        assert!((found - density).abs() < 1e-6, "{found}, {density}");
    }
    // On sites four times as large, in the middle of each block.
    let plants = [plant(&turbid)];
    let one = [instance([0.0; 3], 1.0)];
    let scenery = Scenery::new(&plants, &one, None, 16).expect("a scene");
    let matter = scenery.matter(&[1.0]);
    let large = coarse_medium(&matter);
    let steps = matter.grid.spacing_m / grid.spacing_m;
    for (x_m, density, class) in [(-1.0, 0.1_f64, Class::Leaf), (1.0, 0.3, Class::Wood)] {
        let at = matter.grid.lattice_from_model([x_m, 4.0, 0.0]).map(|c| c as u32);
        let site = matter.grid.index(at[0], at[1], at[2]);
        let expected = 1.0 - libm::pow(1.0 - density, steps);
        assert!(
            (f64::from(large.density[site]) - expected).abs() < 0.01,
            "{} {expected}",
            large.density[site]
        );
        assert_eq!(large.class[site], class);
    }
    let [areas] = scenery.areas_m2(&[1.0])[..] else { panic!("one species") };
    for (found, own) in areas.into_iter().zip(self::areas(&turbid, &[])) {
        assert_near(found, own, ROUNDING);
    }
    // A full site stops what a file's lattice can hold, and no more.
    fine.density[grid.index(8, 8, 8)] = 1.0;
    assert!(extinction(&fine).leaf_per_m.iter().all(|per_m| per_m.is_finite()));
}

#[test]
fn optics_of_a_stand_are_those_of_its_matter_by_area() {
    let optics = flb_format::matter::Optics::paper();
    let oak = optics_in_luminance("oak", &optics).expect("R, G, B");
    let of = |value: fn(&flb_format::matter::BandOptics) -> f64| {
        optics.bands.iter().zip(LUMINANCE).map(|(band, weight)| weight * value(band)).sum::<f64>()
    };
    assert_near(oak.leaf.sigma_a, of(|band| band.leaf.sigma_a), 1e-12);
    assert_near(oak.leaf.g, of(|band| band.leaf.g), 1e-12);
    assert_eq!((oak.wood.g, oak.name.as_str()), (-1.0, "luminance"));
    let mut dark = oak.clone();
    (dark.leaf.sigma_a, dark.wood.sigma_a) = (0.5, 0.7);
    let both = mean_optics(&[oak.clone(), dark], &[[3.0, 0.0], [1.0, 0.0]]);
    assert_near(both.leaf.sigma_a, 0.75 * oak.leaf.sigma_a + 0.25 * 0.5, 1e-12);
    // Without wood there is none to weigh by.
    assert_near(both.wood.sigma_a, f64::midpoint(oak.wood.sigma_a, 0.7), 1e-12);
    let mut two = optics;
    two.bands.pop();
    let expected =
        "species \"oak\" has the bands R, G, expected R, G and B among them, of which luminance is made";
    assert_eq!(optics_in_luminance("oak", &two).unwrap_err().to_string(), expected);
}

#[test]
fn a_digest_tells_plants_and_ground_apart_and_nothing_else() {
    let species = |name: &str| SceneSpecies { name: name.to_owned(), ..SceneSpecies::default() };
    let scene = Scene {
        bands: None,
        light: None,
        ambient: None,
        sky: SceneSky::Even,
        backdrop: None,
        suns: scene::Suns::Sky,
        sunlight: scene::Sunlight::default(),
        highlight: scene::HighlightChoice::default(),
        camera: None,
        ground: Some(scene::Ground { terrain: Terrain::Plane { height_m: 0.0 }, color: [0.2; 3] }),
        water: None,
        species: vec![species("oak"), species("pine")],
        instances: vec![instance([1.0, 0.0, 2.0], 1.0), instance([4.0, 0.0, 2.0], 1.0)],
    };
    let own = light_digest(&scene);
    assert_eq!(own.len(), 64);
    let file = Some(PathBuf::from("elsewhere.glb"));
    let seen = Scene {
        ambient: Some(0.5),
        suns: scene::Suns::Fixed(vec![[0.0, 10.0]]),
        sunlight: scene::Sunlight { irradiance: [0.5; 3], ..Default::default() },
        light: file.clone(),
        water: Some(scene::Water { height_m: 0.5, color: [0.1; 3], waves: None }),
        species: vec![SceneSpecies { file, ..species("oak") }, species("pine")],
        ..scene.clone()
    };
    assert_eq!(light_digest(&seen), own);
    let changed = |change: &dyn Fn(&mut Scene)| {
        let mut other = scene.clone();
        change(&mut other);
        assert_ne!(light_digest(&other), own);
    };
    changed(&|scene| scene.instances[1].transform.position_m[2] += 1e-9);
    changed(&|scene| scene.instances[0].transform.scale = 1.1);
    changed(&|scene| scene.instances[0].transform.rotation = TILTED);
    changed(&|scene| scene.instances[0].species = 1);
    changed(&|scene| scene.instances.swap(0, 1));
    changed(&|scene| scene.species[0].name = "ash".to_owned());
    changed(&|scene| scene.ground = None);
    changed(&|scene| {
        scene.ground = Some(scene::Ground { terrain: Terrain::Plane { height_m: 0.1 }, color: [0.2; 3] })
    });
}
