use super::*;

const POSITIONS: [[f32; 3]; 4] = [[0.0, 0.0, 0.0], [1.0, 0.0, 0.0], [0.0, 2.0, 0.0], [0.0, 0.0, 3.0]];
const TRIANGLES: [[u32; 3]; 3] = [[0, 1, 2], [0, 2, 3], [1, 2, 3]];

#[test]
fn a_digest_is_of_the_triangles_as_a_set() {
    // Of these triangles, by hashes.py beside SPEC.md too.
    let known = "a6166f85d2c10fe2d4be6dd224ce51679fbb9660773fee9a03b28de1415dac1c";
    let of = |positions: &[[f32; 3]], triangles: &[[u32; 3]]| digest(positions, triangles).expect("a mesh");
    let whole = of(&POSITIONS, &TRIANGLES);
    assert_eq!(whole, known, "the digest is part of the format");
    // Other orders of triangles, corners and vertices, vertices that no triangle uses, and those that are there twice.
    assert_eq!(of(&POSITIONS, &[[3, 1, 2], [2, 0, 1], [3, 2, 0]]), whole);
    let [a, b, c, d] = POSITIONS;
    assert_eq!(of(&[[9.0; 3], d, c, b, a, a], &[[4, 3, 2], [5, 2, 1], [3, 2, 1]]), whole);
    assert_eq!(of(&[[-0.0, 0.0, -0.0], b, c, d], &TRIANGLES), whole, "-0 is 0");

    let other = [
        of(&POSITIONS, &TRIANGLES[..2]),
        of(&POSITIONS, &[TRIANGLES[0], TRIANGLES[1], TRIANGLES[1]]),
        of(&POSITIONS, &[TRIANGLES[0], TRIANGLES[1], TRIANGLES[2], TRIANGLES[2]]),
        of(&[a, b, c, [0.0, 0.0, 3.000_000_2]], &TRIANGLES),
        of(&POSITIONS.map(|point| point.map(|x| x * 0.01)), &TRIANGLES),
        of(&POSITIONS.map(|[x, y, z]| [x, z, -y]), &TRIANGLES),
    ];
    for (i, digest) in other.iter().enumerate() {
        assert!(*digest != whole && digest.len() == 64, "{i}: {digest}");
        assert!(!other[..i].contains(digest), "{i}");
    }
}

#[test]
fn what_is_no_mesh_has_no_mark() {
    assert_eq!(digest(&POSITIONS, &[]), None);
    assert_eq!(digest(&[], &TRIANGLES), None);
    assert_eq!(MeshMark::of(&POSITIONS, &[[0, 1, 4]]), None);
    for odd in [f32::NAN, f32::INFINITY] {
        assert_eq!(MeshMark::of(&[[0.0; 3], [odd; 3], [1.0; 3]], &[[0, 1, 2]]), None);
    }
    let used = MeshMark::of(&[[f32::NAN; 3], POSITIONS[0], POSITIONS[1], POSITIONS[2]], &[[1, 2, 3]]);
    assert_eq!(used.map(|mark| mark.bounds_m), Some(Bounds { min: [0.0; 3], max: [1.0, 2.0, 0.0] }));
}

fn meta() -> SpeciesMeta {
    let bytes =
        std::fs::read(concat!(env!("CARGO_MANIFEST_DIR"), "/golden/mesh.flb")).expect("it is committed");
    crate::Container::open(&bytes).expect("it opens").species()[0].meta.clone()
}

#[test]
fn the_light_of_a_mesh_is_of_that_mesh_and_fits_those_of_its_size() {
    let meta = meta();
    let baked = meta.mesh_blake3.clone().expect("the golden file says it");
    let Bounds { min, max } = meta.bounds_m;
    let longest_m = 1.5;
    assert_eq!((min, max), ([-0.75, 0.25, -0.75], [0.75, 1.75, 0.75]));
    let same = MeshMark { blake3: baked, bounds_m: meta.bounds_m };
    assert_eq!(MeshMatch::of(&meta, &same), MeshMatch::Same);
    let other = |bounds_m: Bounds| MeshMatch::of(&meta, &MeshMark { blake3: "0".repeat(64), bounds_m });
    let differs = |off_m: f64| MeshMatch::Differs(MeshFit { off_m, longest_m });
    let moved = |by: f64| Bounds { min: min.map(|c| c + by), max: max.map(|c| c + by) };
    assert_eq!(other(meta.bounds_m), differs(0.0));
    assert_eq!((other(moved(0.125)), other(moved(0.125)).fits()), (differs(0.125), true));
    assert_eq!((other(moved(-0.25)), other(moved(-0.25)).fits()), (differs(0.25), false));
    // One side alone is enough; so is another unit or up axis.
    assert!(!other(Bounds { max: [0.75, 1.5, 0.75], ..meta.bounds_m }).fits());
    assert!(!other(Bounds { min: min.map(|c| c * 100.0), max: max.map(|c| c * 100.0) }).fits());
    assert!(!other(Bounds { min: min.map(|c| c * 0.01), max: max.map(|c| c * 0.01) }).fits());
    assert!(!other(Bounds { min: [min[0], min[2], -max[1]], max: [max[0], max[2], -min[1]] }).fits());
    assert!(!other(Bounds { min: [f64::NAN; 3], max: [f64::NAN; 3] }).fits());

    let old = SpeciesMeta { mesh_blake3: None, ..meta.clone() };
    let found = MeshMatch::of(&old, &same);
    assert_eq!(
        (found, found.fits(), found.name()),
        (MeshMatch::Unknown(MeshFit { off_m: 0.0, longest_m }), true, "unknown")
    );
}
