use flb_format::matter::{LeafAngles, TurbidMedium};

use super::*;
use crate::crown::{Crown, SeenSky};
use crate::downsample::downsample;
use crate::voxelise::tests::{LEAF_WOOD, quiet, settings};
use flb_scene::mesh::testing::soup;
use flb_transport::ordinates::{BandReport, TotalLight};

fn occupancy() -> Occupancy {
    let mesh = soup(&[[[0.0; 3], [1.0, 0.0, 0.3], [0.0, 1.0, 0.0]]]);
    quiet(&mesh, &LEAF_WOOD, &settings(64, 16))
}

fn field(value: f32) -> Field {
    Field::new(16, 1, vec![value; 4096])
}

/// Under which everything is kept here.
const KEY: &str = "5eed";

fn message<A: Artefact + std::fmt::Debug>(bytes: &[u8]) -> String {
    from_bytes::<A>(bytes, KEY).expect_err("bad bytes").to_string()
}

#[test]
fn every_artefact_comes_back_as_it_went() {
    let occupancy = occupancy();
    let medium = downsample(&occupancy).expect("good");
    let fields = vec![(0u8, field(1.5)), (7, field(0.25))];
    assert_eq!(from_bytes::<Occupancy>(&to_bytes(&occupancy, KEY).expect("bytes"), KEY), Ok(occupancy));
    assert_eq!(from_bytes::<Medium>(&to_bytes(&medium, KEY).expect("bytes"), KEY), Ok(medium));
    assert_eq!(
        from_bytes::<BaseArtefact>(&to_bytes(&fields[1], KEY).expect("bytes"), KEY),
        Ok(fields[1].clone())
    );
    assert_eq!(from_bytes::<Vec<BaseArtefact>>(&to_bytes(&fields, KEY).expect("bytes"), KEY), Ok(fields));
}

#[test]
fn a_slice_of_any_alignment_is_read() {
    let occupancy = occupancy();
    let bytes = to_bytes(&occupancy, KEY).expect("bytes");
    for shift in 0..16 {
        let mut moved = vec![0; shift];
        moved.extend_from_slice(&bytes);
        assert_eq!(from_bytes::<Occupancy>(&moved[shift..], KEY).as_ref(), Ok(&occupancy));
    }
}

#[test]
fn every_prefix_and_every_flipped_bit_is_refused() {
    let bytes = to_bytes(&occupancy(), KEY).expect("bytes");
    for end in (0..bytes.len()).step_by(7).chain(0..HEADER) {
        assert!(from_bytes::<Occupancy>(&bytes[..end], KEY).is_err(), "prefix of {end}");
    }
    for bit in (0..bytes.len() * 8).step_by(61).chain(0..HEADER * 8) {
        let mut flipped = bytes.clone();
        flipped[bit / 8] ^= 1 << (bit % 8);
        assert!(from_bytes::<Occupancy>(&flipped, KEY).is_err(), "bit {bit}");
    }
    let mut longer = bytes;
    longer.push(0);
    assert!(from_bytes::<Occupancy>(&longer, KEY).is_err());
}

#[test]
fn a_header_that_does_not_fit_is_refused_with_both_values() {
    let bytes = to_bytes(&occupancy(), KEY).expect("bytes");
    let changed = |at: usize, value: u8| {
        let mut changed = bytes.clone();
        changed[at] = value;
        message::<Occupancy>(&changed)
    };
    assert!(message::<Occupancy>(&bytes[..20]).contains("20 bytes: the header alone has 48"));
    assert!(changed(0, 0).contains("begins with"));
    assert!(changed(8, 99).contains(&format!("schema 99, expected {SCHEMA}")));
    assert!(message::<Medium>(&bytes).contains("kind 1, expected 2"));
    assert!(changed(100, !bytes[100]).contains("have digest"));
}

#[test]
fn an_artefact_under_the_key_of_another_is_refused() {
    let bytes = to_bytes(&occupancy(), "other").expect("bytes");
    assert!(message::<Occupancy>(&bytes).contains("key and payload have digest"));
    assert!(from_bytes::<Occupancy>(&bytes, "other").is_ok());
}

/// Bytes whose digest holds, around any payload.
fn sealed(kind: u32, payload: &[u8]) -> Vec<u8> {
    let mut bytes = [&MAGIC[..], &SCHEMA.to_le_bytes(), &kind.to_le_bytes()].concat();
    bytes.extend_from_slice(seal(KEY, payload).as_bytes());
    bytes.extend_from_slice(payload);
    bytes
}

#[test]
fn a_payload_that_rkyv_cannot_validate_is_refused_whatever_its_digest_says() {
    for payload in [vec![], vec![0xff; 64], vec![0x7f; 4096]] {
        assert!(message::<Occupancy>(&sealed(1, &payload)).contains("payload: "));
        assert!(message::<Vec<BaseArtefact>>(&sealed(4, &payload)).contains("payload: "));
    }
}

#[test]
fn a_value_that_lies_is_refused() {
    let medium = downsample(&occupancy()).expect("good");
    let lie = |change: &dyn Fn(&mut Medium)| {
        let mut medium = medium.clone();
        change(&mut medium);
        message::<Medium>(&to_bytes(&medium, KEY).expect("bytes"))
    };
    let empty = medium.class.iter().position(|&class| class == Class::Empty).expect("an empty site");
    let full = medium.class.iter().position(|&class| class == Class::Leaf).expect("a leaf site");
    assert!(lie(&|m| m.density.truncate(9)).contains("density: 9 entries: expected 4096"));
    assert!(lie(&|m| m.density[full] = 1.5).contains("class 1 with density 1.5"));
    assert!(lie(&|m| m.density[full] = f32::NAN).contains("class 1 with density NaN"));
    assert!(lie(&|m| m.density[empty] = 0.5).contains("class 0 with density 0.5"));
    assert!(lie(&|m| m.leaf_area_density[empty] = 2.0).contains("class 0 with area density 2"));
    assert!(lie(&|m| m.wood_area_density[full] = -1.0).contains("area density -1"));
    assert!(lie(&|m| m.grid.lattice = 17).contains("lattice 17"));
    assert!(lie(&|m| m.grid.spacing_m = f64::INFINITY).contains("spacing inf"));
    let field_lie =
        |fields: Vec<BaseArtefact>| message::<Vec<BaseArtefact>>(&to_bytes(&fields, KEY).expect("bytes"));
    assert!(field_lie(vec![(3, field(f32::NAN))]).contains("base 3, band 0: value 0 is NaN"));
    assert!(field_lie(vec![(3, field(1.0)), (3, field(1.0))]).contains("base 3 is stored before base 3"));
    let of_bands = |bands| vec![(3, Field::new(16, bands, vec![1.0; 4096]))];
    assert!(field_lie(of_bands(2)).contains("1 entries: expected 2"));
    assert!(field_lie(of_bands(0)).contains("0 bands"));
    let short = vec![(3, Field::new(16, 1, vec![1.0; 4095]))];
    assert!(field_lie(short).contains("4095 entries: expected 4096"));
}

#[test]
fn a_field_of_cells_comes_back_as_one_and_takes_no_value_twice() {
    let cells = Cells::new((0..4096).map(|site: u32| site / 64).collect());
    let band = |factor: f32| CellBand::new(cells.clone(), (0..64).map(|cell| factor * cell as f32).collect());
    let fields: Vec<BaseArtefact> = vec![(3, Field::of_cells(16, vec![band(1.0), band(0.5)]))];
    let bytes = to_bytes(&fields, KEY).expect("bytes");
    assert!(bytes.len() < 2048, "{} bytes", bytes.len());
    let read: Vec<BaseArtefact> = from_bytes(&bytes, KEY).expect("it was written just now");
    assert_eq!(read, fields);
    assert!(read[0].1.cells().is_some());
    // Bands that share values in other ways are stored whole.
    let other = CellBand::new(Cells::new((0..4096).map(|site: u32| site % 64).collect()), vec![2.0; 64]);
    let fields: Vec<BaseArtefact> = vec![(3, Field::of_cells(16, vec![band(1.0), other]))];
    let read: Vec<BaseArtefact> =
        from_bytes(&to_bytes(&fields, KEY).expect("bytes"), KEY).expect("it was written just now");
    assert_eq!(read, fields);
}

#[test]
fn runs_that_lie_are_refused() {
    let of_runs = |runs: Vec<(u32, u32)>, values: usize| {
        let stored = StoredField { base: 3, lattice: 16, bands: 1, runs, values: vec![vec![1.0; values]] };
        BaseArtefact::restore(stored).map_err(|error| error.to_string())
    };
    assert!(of_runs(vec![(4000, 0), (4096, 1)], 2).is_ok());
    let refused = |runs: &[(u32, u32)], values| of_runs(runs.to_vec(), values).expect_err("it lies");
    assert!(refused(&[(4000, 0)], 1).contains("4000 entries: expected 4096"));
    assert!(refused(&[(4000, 0), (3000, 0)], 1).contains("ends at site 3000: expected 4001 to 4096"));
    assert!(refused(&[(5000, 0)], 1).contains("ends at site 5000: expected 1 to 4096"));
    assert!(refused(&[(4096, 7)], 7).contains("7 values: expected at least 8"));
}

fn crown() -> Crown {
    let grid = Grid { lattice: 16, origin_m: [0.5, -1.0, 0.0], spacing_m: 0.25 };
    let array = |value: f32| (0..grid.sites()).map(|site| value * (site % 7) as f32).collect();
    let (leaf_per_m, wood_per_m) = (array(0.3), array(1.5));
    let turbid = TurbidMedium { grid, leaf_per_m, wood_per_m, angles: LeafAngles::planophile() };
    let sites = turbid.sites().len();
    let seen_sky = SeenSky { sides: vec![8.0; sites], open: vec![2.5; sites], wood: vec![0.5; sites] };
    Crown { turbid, seen_sky, factor: 1.1, mesh_gap: 0.4, measured_gap: 0.45, gap: 0.4 }
}

fn light() -> LightArtefact {
    let report = |band: u32, suns_rms| BandReport {
        band,
        solves: 32,
        passes: 9 + band,
        error_estimate: 1e-3,
        converged: true,
        suns_rms,
    };
    let total = TotalLight {
        items: vec![0, 1],
        values: vec![vec![vec![0.5, 0.25]; 2]; 2],
        near: vec![vec![vec![0.25, 1.0]; 3]],
        beyond: vec![vec![-0.5, 1.5]; 1],
        open_sky: vec![0.5, 0.125],
    };
    LightArtefact { reports: vec![report(0, Some(0.01)), report(1, None)], held_out: 5, total }
}

#[test]
fn what_the_physical_model_keeps_comes_back_as_it_went() {
    let fields = vec![(0u8, field(1.5)), (255, field(0.25))];
    let coarser = Crown { seen_sky: SeenSky::default(), ..crown() };
    for crown in [crown(), coarser] {
        assert_eq!(from_bytes::<Crown>(&to_bytes(&crown, KEY).expect("bytes"), KEY), Ok(crown));
    }
    assert_eq!(from_bytes::<LightArtefact>(&to_bytes(&light(), KEY).expect("bytes"), KEY), Ok(light()));
    assert_eq!(from_bytes::<Vec<BaseArtefact>>(&to_bytes(&fields, KEY).expect("bytes"), KEY), Ok(fields));
}

#[test]
fn a_crown_or_a_report_that_lies_is_refused() {
    let lie = |change: &dyn Fn(&mut Crown)| {
        let mut crown = crown();
        change(&mut crown);
        message::<Crown>(&to_bytes(&crown, KEY).expect("bytes"))
    };
    assert!(lie(&|c| c.turbid.wood_per_m.truncate(9)).contains("wood_per_m: 9 entries: expected 4096"));
    assert!(lie(&|c| c.turbid.leaf_per_m[3] = -1.0).contains("leaf_per_m, site 3: -1 per metre"));
    assert!(lie(&|c| c.turbid.wood_per_m[5] = f32::NAN).contains("wood_per_m, site 5: NaN per metre"));
    assert!(lie(&|c| c.turbid.grid.lattice = 17).contains("lattice 17"));
    let lie_of_sides = lie(&|c| _ = c.seen_sky.open.pop());
    assert!(lie_of_sides.contains("open_sides: "), "{lie_of_sides}");
    assert!(lie(&|c| c.seen_sky.open[2] = 9.0).contains("open_sides, place 2: 9 of 8 sides"));
    assert!(lie(&|c| c.seen_sky.wood[1] = -1.0).contains("sides_to_wood, place 1: -1 of 8 sides"));
    assert!(lie(&|c| c.seen_sky.sides[1] = f32::INFINITY).contains("leaf_sides, place 1: expected a finite"));
    assert!(lie(&|c| c.gap = 1.5).contains("gap: 1.5: expected a share from 0 to 1"));
    assert!(lie(&|c| c.factor = 0.0).contains("factor: 0: expected a finite number above 0"));
    let mut bent = crown().store();
    bent.angles[0] += 0.5;
    assert!(Crown::restore(bent).expect_err("no shares").to_string().contains("32 shares whose sum is 1"));
    let mut short = crown().store();
    short.angles.pop();
    assert!(Crown::restore(short).expect_err("no shares").to_string().contains("32 shares whose sum is 1"));

    let lie = |change: &dyn Fn(&mut LightArtefact)| {
        let mut light = light();
        change(&mut light);
        message::<LightArtefact>(&to_bytes(&light, KEY).expect("bytes"))
    };
    assert!(lie(&|l| l.reports.clear()).contains("reports: 0 bands: expected 1 to 64"));
    assert!(lie(&|l| l.reports[0].suns_rms = Some(-1.0)).contains("band 0, suns_rms: -1: expected a finite"));
    assert!(lie(&|l| _ = l.total.open_sky.pop()).contains("open_sky: 1 entries: expected 2"));
    assert!(lie(&|l| l.total.beyond[0][1] = f32::NAN).contains("total: NaN: expected finite"));
    assert!(lie(&|l| l.total.open_sky[1] = f32::NAN).contains("total: NaN: expected finite"));
    assert!(lie(&|l| l.reports[1].error_estimate = f64::INFINITY).contains("band 1, error_estimate: inf"));
}

#[test]
fn keys_differ_wherever_an_input_differs() {
    let keys = [
        key("voxelise", &[b"ab", b"c"], "voxels=1024"),
        key("voxelise", &[b"a", b"bc"], "voxels=1024"),
        key("voxelise", &[b"abc"], "voxels=1024"),
        key("voxelise", &[b"ab", b"c"], "voxels=512"),
        key("downsample", &[b"ab", b"c"], "voxels=1024"),
    ];
    for (i, a) in keys.iter().enumerate() {
        assert_eq!(a.len(), 64);
        assert!(keys[..i].iter().all(|b| a != b));
    }
    assert_eq!(keys[0], key("voxelise", &[b"ab", b"c"], "voxels=1024"));
}
