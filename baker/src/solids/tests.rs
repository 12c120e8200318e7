use flb_format::{Grid, sample};
use flb_scene::MaterialClass::{Leaf, Wood};
use flb_scene::mesh::testing::soup;
use flb_scene::{ClassedMesh, Mesh};
use flb_transport::ordinates::{OrdinatesSettings, Surroundings, solve_among};
use flb_transport::turbid::scatter;

use super::*;
use crate::bake::received_by;
use crate::crown::{CrownSettings, Recollision, measure_crown};
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

impl Lit {
    fn new(mesh: Mesh, lattice: u32) -> Lit {
        let classed = ClassedMesh { mesh, classes: vec![Wood, Leaf] };
        let voxels = VoxelSettings { voxels: 256, lattice, ignore_alpha: false };
        let quiet = |_| ();
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
            suns: flb_format::SunBasis::Lattice18,
            ordinates: flb_transport::ordinates::Ordinates::Lebedev50,
            bases: [0].into_iter().collect(),
            ..OrdinatesSettings::default()
        };
        let mut solution = solve_among(&crown.turbid, &bands, &surroundings, &settings, &quiet).unwrap();
        let received = received_by(&recollision, &bands, &solution.total);
        let solids = Solids {
            classed: &classed,
            ignore_alpha: false,
            turbid: &crown.turbid,
            medium: &medium,
            received: &received,
            bands: &bands,
            total: &solution.total,
        };
        solids.light(&mut solution.fields, &quiet).unwrap();
        Lit { field: solution.fields.remove(0).1, grid: crown.turbid.grid }
    }

    /// Irradiance of a sky of fluence 1, where 1/4 is that in the open.
    fn at(&self, point: [f64; 3], normal: [f64; 3]) -> f64 {
        let offset_m = flb_format::SOLID_OFFSET * self.grid.spacing_m;
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
