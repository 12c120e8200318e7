use flb_format::bases::BaseSet;
use flb_format::light::SunBasis;
use flb_format::{Grid, sample};
use flb_scene::MaterialClass::{Leaf, Wood};
use flb_scene::mesh::testing::soup;
use flb_scene::{ClassedMesh, Mesh};
use flb_transport::ordinates::{OrdinatesSettings, OrdinatesSolution, Surroundings, solve_among};
use flb_transport::turbid::{BandScatter, scatter};

use super::*;
use crate::bake::{on_matter, received_by};
use crate::crown::{Crown, CrownSettings, Recollision, measure_crown};
use crate::downsample::downsample;
use crate::voxelise::{VoxelSettings, voxelise};

/// The corners of a box's quads, seen from outside counter-clockwise; some sides may be left out.
fn quads(low: [f32; 3], high: [f32; 3], sides: &[usize]) -> Vec<[[f32; 3]; 3]> {
    let corner =
        |i: usize| std::array::from_fn(|axis| if i >> axis & 1 == 1 { high[axis] } else { low[axis] });
    const QUADS: [[usize; 4]; 6] =
        [[0, 4, 6, 2], [1, 3, 7, 5], [0, 1, 5, 4], [2, 6, 7, 3], [0, 2, 3, 1], [4, 5, 7, 6]];
    sides
        .iter()
        .flat_map(|side| {
            let [a, b, c, d] = QUADS[*side].map(corner);
            [[a, b, c], [a, c, d]]
        })
        .collect()
}

const ALL: [usize; 6] = [0, 1, 2, 3, 4, 5];

/// The sky's light at solids, and a way to ask for it at a point with its normal.
struct Lit {
    field: Field,
    grid: Grid,
}

/// A mesh of wood and leaves with the light of its voxels, before solids have theirs.
struct Plant {
    classed: ClassedMesh,
    turbid: TurbidMedium,
    medium: Medium,
    received: Vec<Vec<[Received; 2]>>,
    solution: OrdinatesSolution,
    suns: SunBasis,
    seen_sky: SeenSky,
    walls: Walls,
}

impl Plant {
    fn new(mesh: Mesh, lattice: u32, suns: SunBasis) -> Plant {
        let classed = ClassedMesh { mesh, classes: vec![Wood, Leaf] };
        let voxels = VoxelSettings { voxels: 256, lattice, ignore_alpha: false };
        let quiet = |_| Ok(());
        let medium =
            downsample(&voxelise(&classed.mesh, &classed.classes, &voxels, &quiet).unwrap()).unwrap();
        let crown =
            measure_crown(&classed.mesh, &classed.classes, &medium, &CrownSettings::default(), &quiet)
                .unwrap();
        let bands: Vec<BandScatter> =
            flb_scene::leaf::knapp_carter().bands[1..2].iter().map(scatter).collect();
        let recollision = Recollision::of(&crown.turbid, crown.factor, &medium);
        let albedos = recollision.albedos(&bands);
        let surroundings = Surroundings { albedos: Some(&albedos), ..Surroundings::NONE };
        let settings = OrdinatesSettings {
            bases: if suns == SunBasis::Lattice18 { [0].into_iter().collect() } else { BaseSet::ALL },
            suns,
            ordinates: flb_transport::ordinates::Ordinates::Lebedev50,
            ..OrdinatesSettings::default()
        };
        let mut solution = solve_among(&crown.turbid, &bands, &surroundings, &settings, &quiet).unwrap();
        let received = received_by(&recollision, &bands, &solution.total);
        on_matter(&mut solution.fields, &crown, &received, &solution.total.open_sky, &settings.suns);
        let Crown { turbid, seen_sky, .. } = crown;
        let walls = flb_scene::extents::walls(&classed);
        Plant { classed, turbid, medium, received, solution, suns: settings.suns, seen_sky, walls }
    }

    fn solids(&self) -> Solids<'_> {
        Solids {
            classed: &self.classed,
            ignore_alpha: false,
            turbid: &self.turbid,
            medium: &self.medium,
            received: &self.received,
            total: &self.solution.total,
            suns: &self.suns,
            seen_sky: &self.seen_sky,
            walls: self.walls,
        }
    }

    /// All fields, with the light on solids.
    fn lit(&self) -> Vec<(u8, Field)> {
        let mut fields = self.solution.fields.clone();
        self.solids().light(&mut fields, &|_| Ok(())).unwrap();
        fields
    }
}

impl Lit {
    fn new(mesh: Mesh, lattice: u32) -> Lit {
        let plant = Plant::new(mesh, lattice, SunBasis::Lattice18);
        Lit { field: plant.lit().remove(0).1, grid: plant.turbid.grid }
    }

    /// Irradiance of a sky of fluence 1, where 1/4 is that in the open.
    fn at(&self, point: [f64; 3], normal: [f64; 3]) -> f64 {
        let offset_m = flb_format::sample::SOLID_OFFSET * self.grid.spacing_m;
        let asked = std::array::from_fn(|axis| point[axis] + offset_m * normal[axis]);
        let mut light = [0.0];
        sample::trilinear(&self.field, self.grid.lattice_from_model(asked), &mut light);
        f64::from(light[0]) / 4.0
    }
}

#[test]
fn an_open_wall_has_the_light_of_half_a_sky_at_every_lattice() {
    let solid = quads([-0.31, -0.27, -0.35], [0.33, 0.29, 0.3], &ALL);
    for lattice in [16, 32, 64] {
        let lit = Lit::new(soup(&solid), lattice);
        for (point, normal) in [
            ([0.1, 0.29, -0.05], [0.0, 1.0, 0.0]),
            ([-0.31, 0.04, 0.02], [-1.0, 0.0, 0.0]),
            ([0.05, 0.03, 0.3], [0.0, 0.0, 1.0]),
        ] {
            let found = lit.at(point, normal);
            assert!((found - 0.25).abs() < 0.005, "lattice {lattice}, {normal:?}: {found}");
        }
    }
}

#[test]
fn a_closed_box_is_dark_inside_and_an_open_one_is_lit_through_its_mouth() {
    // A wall of 0.1 m around a hollow; the second box has no lid.
    let outer = ([-0.5; 3], [0.5; 3]);
    let inner = ([-0.4; 3], [0.4; 3]);
    let hollow = |sides: &[usize]| {
        let mut walls = quads(outer.0, outer.1, sides);
        // Turned inside out, so that its faces look into the hollow.
        walls.extend(quads(inner.0, inner.1, sides).into_iter().map(|[a, b, c]| [a, c, b]));
        soup(&walls)
    };
    let closed = Lit::new(hollow(&ALL), 64);
    let (floor, up) = ([0.03, -0.4, 0.07], [0.0, 1.0, 0.0]);
    assert!(closed.at(floor, up) < 5e-3, "{}", closed.at(floor, up));
    assert!((closed.at([0.03, 0.5, 0.07], up) - 0.25).abs() < 0.01);
    let open = Lit::new(hollow(&[0, 1, 2, 4, 5]), 64);
    // The mouth as it is seen from the floor: a square of 0.8 m at 0.8 m has the share 0.24 of the light of half a sky
    // (four corners of 0.4 x 0.4 at 0.8: Howell's configuration factor C-11); the walls send back a tenth of theirs.
    let found = open.at(floor, up) / 0.25;
    assert!((0.2..0.32).contains(&found), "{found}");
}

#[test]
fn a_wall_without_thickness_keeps_its_sides_apart() {
    // A box of sheets without a lid: on either side of its floor there is other light.
    let sheet = quads([-0.4; 3], [0.4; 3], &[0, 1, 2, 4, 5]);
    let (floor, up, down) = ([0.05, -0.4, -0.03], [0.0, 1.0, 0.0], [0.0, -1.0, 0.0]);
    for lattice in [32, 64] {
        let lit = Lit::new(soup(&sheet), lattice);
        let [above, below] = [lit.at(floor, up), lit.at(floor, down)];
        assert!((below - 0.25).abs() < 0.01, "lattice {lattice}: {below} below");
        assert!((0.05..0.075).contains(&above), "lattice {lattice}: {above} above");
    }
}

#[test]
fn light_at_solids_is_the_same_for_any_number_of_threads_and_inside_out() {
    let solid = quads([-0.31, -0.27, -0.35], [0.33, 0.29, 0.3], &ALL);
    let inward: Vec<_> = solid.iter().map(|[a, b, c]| [*a, *c, *b]).collect();
    let of = |threads: usize, triangles: &[[[f32; 3]; 3]]| {
        let pool = rayon::ThreadPoolBuilder::new().num_threads(threads).build().unwrap();
        pool.install(|| Lit::new(soup(triangles), 16))
    };
    assert_eq!(of(1, &solid).field, of(3, &solid).field);
    let found = of(2, &inward).at([0.1, 0.29, -0.05], [0.0, 1.0, 0.0]);
    assert!((found - 0.25).abs() < 0.005, "{found}");
}

/// Leaves at random in a cube of 1 m, a twig among them, and a block of wood beside.
fn leaves_with_a_twig_and_a_block() -> Mesh {
    let mut triangles = quads([-0.03, -0.45, -0.03], [0.03, 0.45, 0.03], &ALL);
    triangles.extend(quads([1.3, -0.4, -0.4], [1.7, 0.4, 0.4], &ALL));
    let wood = triangles.len();
    let mut state = 7u64;
    let mut draw = || {
        state = state.wrapping_mul(6364136223846793005).wrapping_add(1442695040888963407);
        (state >> 40) as f32 / (1u64 << 24) as f32 - 0.5
    };
    for _ in 0..900 {
        let at: [f32; 3] = std::array::from_fn(|_| 0.9 * draw());
        triangles.push(std::array::from_fn(|_| at.map(|c| c + 0.12 * draw())));
    }
    let mut mesh = soup(&triangles);
    mesh.triangle_material[wood..].fill(1);
    mesh
}

#[test]
fn twigs_take_the_near_beam_of_the_leaves_around_and_the_harmonics_hold_the_rest() {
    let plant = Plant::new(
        leaves_with_a_twig_and_a_block(),
        32,
        SunBasis::Harmonics { degree: 1, single: true, leaning: false },
    );
    let fields = plant.lit();
    let solids = plant.solids();
    let rays = RayMesh::new(&plant.classed.mesh, false).unwrap();
    let places = solids.places();
    let points = points::on_solids(&plant.classed, &rays, plant.turbid.grid);
    let gathered = gather::gather(&solids, &rays, &places, &points, &|_| Ok(())).unwrap();
    // Items: sky, 4 harmonics, the means. The mean over all suns of what a reader finds is what was gathered.
    let near = &plant.solution.total.near;
    assert_eq!((fields.len(), near.len(), near[0].len()), (8, 4, 3));
    let (mut found, mut truth) = (0.0, 0.0);
    let single_at = |side: &gather::Side| {
        let mut value = [0.0];
        sample::trilinear(&fields[7].1, side.sample, &mut value);
        f64::from(value[0])
    };
    let (mut of_twig, mut of_block) = (Vec::new(), Vec::new());
    let twig = plant.turbid.grid.lattice_from_model([0.6, 0.0, 0.0])[0];
    for (number, side) in gathered.sides.iter().enumerate() {
        let mut met = [0.0f64; 4];
        let low = side.sample.map(|c| (c - 0.5).floor());
        for corner in 0..8 {
            let at: [f64; 3] = std::array::from_fn(|axis| low[axis] + f64::from(corner >> axis & 1));
            let weight: f64 = (0..3).map(|axis| 1.0 - (side.sample[axis] - 0.5 - at[axis]).abs()).product();
            let site = plant.turbid.grid.index(at[0] as u32, at[1] as u32, at[2] as u32);
            if let Some(place) = places.of(site) {
                (0..3).for_each(|mean| met[mean] += weight * f64::from(near[0][mean][place]));
                met[3] += weight;
            }
        }
        if met[3] > 0.0 {
            let value = |item: usize| {
                let mut value = [0.0];
                sample::trilinear(&fields[item].1, side.sample, &mut value);
                f64::from(value[0])
            };
            let light = value(1) + (0..3).map(|mean| value(5 + mean) * met[mean] / met[3]).sum::<f64>();
            let expected = f64::from(gathered.of(number, 1, 0));
            (found, truth) = (found + light, truth + expected);
        }
        if side.sample[0] < twig { &mut of_twig } else { &mut of_block }.push(single_at(side));
    }
    assert!((found / truth - 1.0).abs() < 0.06, "{found} of {truth}");
    // The twig's light scattered once is that of the leaves; what the block sees of it is little.
    let mean = |values: &[f64]| values.iter().sum::<f64>() / values.len() as f64;
    let leaves: Vec<f64> = plant
        .turbid
        .sites()
        .into_iter()
        .filter(|&site| plant.turbid.leaf_per_m[site as usize] > 0.0)
        .map(|site| f64::from(fields[7].1.band(0)[site as usize]))
        .collect();
    assert!(mean(&of_twig) > 0.5 * mean(&leaves), "{} of {}", mean(&of_twig), mean(&leaves));
    assert!(mean(&of_block) < 0.3 * mean(&leaves), "{} of {}", mean(&of_block), mean(&leaves));
}

/// A wall of one sheet on the sides of a box that are given, and a small leaf in it, level, 0.15 m above its floor.
fn leaf_behind(sides: &[usize]) -> Mesh {
    let mut triangles = quads([-0.4; 3], [0.4; 3], sides);
    let walls = triangles.len();
    triangles.extend([[[-0.1, -0.25, -0.1], [-0.1, -0.25, 0.1], [0.1, -0.25, 0.0]]]);
    let mut mesh = soup(&triangles);
    mesh.triangle_material = (0..triangles.len()).map(|triangle| u32::from(triangle >= walls)).collect();
    mesh
}

/// Light of the sky on the leaf, where 1/4 is that in the open.
fn on_the_leaf(sides: &[usize], lattice: u32) -> f64 {
    let plant = Plant::new(leaf_behind(sides), lattice, SunBasis::Lattice18);
    let lit = Lit { field: plant.lit().remove(0).1, grid: plant.turbid.grid };
    lit.at([0.02, -0.25, 0.0], [0.0; 3])
}

#[test]
fn a_leaf_in_a_closed_box_of_sheets_is_dark_and_one_in_a_pot_sees_its_mouth() {
    for lattice in [16, 32] {
        let closed = on_the_leaf(&ALL, lattice) / 0.25;
        assert!(closed.abs() < 5e-3, "lattice {lattice}: {closed}");
        // Up it sees the mouth, 0.8 m wide and 0.65 m above: the share 0.32 of the light of half a sky (four corners of
        // 0.4 x 0.4 at 0.65, Howell's C-11), so 0.16 of the whole. The walls send back a seventh of theirs.
        let open = on_the_leaf(&[0, 1, 2, 4, 5], lattice) / 0.25;
        assert!((0.16..0.21).contains(&open), "lattice {lattice}: {open}");
    }
}

#[test]
fn a_pot_and_a_leaf_that_absorb_nothing_are_as_bright_as_the_sky() {
    let mut plant = Plant::new(leaf_behind(&[0, 1, 2, 4, 5]), 32, SunBasis::Lattice18);
    plant.received.iter_mut().flatten().flatten().for_each(|received| received.albedo = 1.0);
    let places = plant.solids().places();
    assert!((0..plant.turbid.sites().len()).any(|place| places.is_enclosed(place)));
    let lit = Lit { field: plant.lit().remove(0).1, grid: plant.turbid.grid };
    let leaf = lit.at([0.02, -0.25, 0.0], [0.0; 3]);
    assert!((leaf / 0.25 - 1.0).abs() < 0.03, "{leaf}");
}

#[test]
fn suns_light_a_leaf_in_a_pot_by_way_of_its_walls() {
    let suns = SunBasis::Harmonics { degree: 1, single: false, leaning: false };
    let plant = Plant::new(leaf_behind(&[0, 1, 2, 4, 5]), 16, suns);
    let fields = plant.lit();
    let (_, mean) = fields.into_iter().find(|(item, _)| *item == 1).expect("the mean over all suns");
    let lit = Lit { field: mean, grid: plant.turbid.grid };
    let mean = lit.at([0.02, -0.25, 0.0], [0.0; 3]) / 0.25;
    // The mean over all suns of what comes to the leaf by way of walls is what the walls send of the even sky's light.
    let straight = 0.16;
    let by_walls = on_the_leaf(&[0, 1, 2, 4, 5], 16) / 0.25 - straight;
    assert!((mean - by_walls).abs() < 0.02, "{mean} {by_walls}");
}

/// Leaves deep in a pot with thin walls: among what they receive of a sun, dark lies beside light.
pub(crate) fn leaves_deep_in_a_pot() -> Mesh {
    let mut triangles = quads([-0.2, -0.5, -0.2], [0.2, 0.5, 0.2], &[0, 1, 2, 4, 5]);
    let walls = triangles.len();
    for i in 0..16u8 {
        let [x, z] = [i % 4, i / 4].map(|at| 0.08 * (f32::from(at) - 1.5));
        let y = -0.45 + 0.03 * f32::from(i % 7);
        triangles.push([[x, y, z], [x + 0.06, y + 0.02, z], [x, y, z + 0.06]]);
    }
    let mut mesh = soup(&triangles);
    mesh.triangle_material = (0..triangles.len()).map(|triangle| u32::from(triangle >= walls)).collect();
    mesh
}

#[test]
fn a_fit_within_bounds_keeps_what_is_behind_walls_darker_than_a_clamp_does() {
    let plant = Plant::new(leaves_deep_in_a_pot(), 32, SunBasis::Lattice18);
    assert!(matches!(plant.walls, Walls::Enclosing(_)), "{:?}", plant.walls);
    let solids = plant.solids();
    let rays = RayMesh::new(&plant.classed.mesh, false).unwrap();
    let places = solids.places();
    let wood = points::on_solids(&plant.classed, &rays, plant.turbid.grid);
    let leaves = points::on_leaves(&plant.classed, &rays, plant.turbid.grid, |_| true);
    let gathered =
        radiosity::Surfaces::new(&solids, &rays, &places, [&wood, &leaves]).gather(&|_| Ok(())).unwrap();
    // Sides of leaves come last. What a reader finds at them, and what came to them.
    let sides = gathered.sides.len() - 2 * leaves.points.len()..gathered.sides.len();
    let truth: f32 = sides.clone().map(|side| gathered.of(side, 0, 0)).sum();
    let of = |rounds: usize| -> f32 {
        let mut fit = fit::Fit::new(&solids, &places, &gathered);
        fit.rounds = rounds;
        let values = fit.values(|_| 0.0, 0, 0, &gathered);
        let at = |(site, weight): (usize, f32)| {
            weight * values[fit.sites().binary_search(&(site as u32)).unwrap()]
        };
        sides.clone().map(|side| fit.corner_sites(side).map(at).sum::<f32>()).sum::<f32>() / truth - 1.0
    };
    let [clamped, fitted] = [of(1), of(4)];
    println!("{clamped} {fitted}");
    assert!(clamped > 0.1 && fitted.abs() < 0.4 * clamped, "{clamped} {fitted}");
}

#[test]
fn light_at_solids_stops_when_it_is_told_to_with_walls_and_without() {
    let plant = Plant::new(leaf_behind(&[0, 1, 2, 4, 5]), 16, SunBasis::Lattice18);
    let stopped = plant.solids().light(&mut plant.solution.fields.clone(), &|_| Err(Cancelled));
    assert!(matches!(stopped, Err(SolidsError::Cancelled(Cancelled))), "{stopped:?}");

    // It asks at every 1024th point.
    let plant = Plant::new(leaves_with_a_twig_and_a_block(), 32, SunBasis::Lattice18);
    let solids = plant.solids();
    let rays = RayMesh::new(&plant.classed.mesh, false).unwrap();
    let points = points::on_solids(&plant.classed, &rays, plant.turbid.grid);
    let gathered = gather::gather(&solids, &rays, &solids.places(), &points, &|_| Err(Cancelled));
    assert!(gathered.is_err(), "{} points", points.points.len());
}
