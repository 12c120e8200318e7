use flb_format::beam::means;
use flb_format::matter::{BandSurfaces, LeafAngles, LeafSurface, Surfaces, WoodSurface};
use flb_format::meta::{Bounds, LeftOut, TriangleCounts};
use flb_format::model::Model;
use flb_format::sun::{self, directions::SunDirections, harmonics};
use flb_format::{Codec, Field, Medium, SpeciesFields, SpeciesMeta};
use flb_packer::{EncodeSettings, encode_species, write_library_to};
use flb_testkit::model::scattered;

use super::*;
use crate::near_beam::dense;
use crate::sampler::SpeciesSampler;

const N: u32 = 16;
const BANDS: usize = 2;
const DEGREE_2: SunBasis = SunBasis::Harmonics { degree: 2, single: false, leaning: true };
const WITH_SINGLE: SunBasis = SunBasis::Harmonics { degree: 2, single: true, leaning: true };
const UPRIGHT: SunBasis = SunBasis::Harmonics { degree: 2, single: true, leaning: false };
/// Up to 14 products of magnitude 1, each of a sum of 64.
const ROUNDING: f32 = 2e-5;

fn grid() -> Grid {
    Grid { lattice: N, origin_m: [-0.8, 0.1, 2.0], spacing_m: 0.25 }
}

/// A ragged ball: seven of ten sites of it hold leaf, some wood as well.
fn turbid() -> TurbidMedium {
    let (mut leaf_per_m, mut wood_per_m) = (vec![0.0; grid().sites()], vec![0.0; grid().sites()]);
    for site in 0..grid().sites() {
        let at = grid().site(site).map(|c| c as f32 - 7.5);
        let noise = site.wrapping_mul(2_654_435_761) >> 7 & 255;
        if at.iter().map(|c| c * c).sum::<f32>() < 30.0 && noise > 76 {
            leaf_per_m[site] = noise as f32 / 128.0;
            wood_per_m[site] = if noise > 220 { 2.0 } else { 0.0 };
        }
    }
    TurbidMedium { grid: grid(), leaf_per_m, wood_per_m, angles: LeafAngles::planophile() }
}

/// Smooth, different for every base and band, of either sign.
fn field(base: u8) -> Field {
    let mut field = Field::zeros(N, BANDS as u32);
    for (i, value) in field.values_mut().iter_mut().enumerate() {
        let (x, y, z, band) = (i % 16, i / 16 % 16, i / 256 % 16, i / 4096);
        let ramp = (x * (1 + usize::from(base) % 3) + y * 2 + z + band * 5) as f32 / 100.0;
        *value = if base == 0 { 1.0 + ramp } else { ramp - 0.4 + f32::from(base) * 0.02 };
    }
    field
}

fn fields(suns: &SunBasis) -> SpeciesFields {
    let turbid = turbid();
    let light = scattered(suns, &turbid);
    let band = |b: usize| BandSurfaces {
        name: format!("band{b}"),
        leaf: LeafSurface { reflectance: 0.25, transmittance: 0.25 },
        wood: WoodSurface { reflectance: 0.5 },
    };
    SpeciesFields {
        meta: SpeciesMeta {
            name: "oak".to_owned(),
            model: Model::Physical { surfaces: Surfaces { bands: (0..BANDS).map(band).collect() }, light },
            grid: grid(),
            bounds_m: Bounds { min: [0.0, 1.0, 3.0], max: [1.0, 2.0, 4.0] },
            triangles: TriangleCounts::default(),
            mesh_blake3: None,
            mean_light: None,
            sky_averages: None,
            sources: Vec::new(),
            settings: Default::default(),
            tool: "test".to_owned(),
            left_out: None,
            extra: Default::default(),
        },
        medium: Medium::empty(grid()),
        turbid: Some(turbid),
        bases: suns.item_numbers().map(|base| (base, field(base))).collect(),
    }
}

fn library(fields: &SpeciesFields, codec: Codec) -> Library {
    let settings = EncodeSettings { codec, ..EncodeSettings::papers() };
    let encoded = encode_species(fields, &settings, &|_| Ok(())).expect("it encodes");
    let mut bytes = Vec::new();
    write_library_to(&mut bytes, &[&encoded]).expect("it fits");
    Library::from_source("oak.flb", Box::new(bytes)).expect("it opens")
}

/// The fields as a file gives them back.
fn as_stored(library: &Library) -> Vec<(u8, Field)> {
    let bases = library.container().species()[0].bases.iter().map(|base| base.base);
    let field = |base| library.container().read_field(library.source(), 0, base).expect("the base reads");
    bases.map(|base| (base, field(base))).collect()
}

fn sampler(fields: &SpeciesFields, codec: Codec) -> PhysicalSampler {
    PhysicalSampler::load(&library(fields, codec), 0).expect("it loads")
}

fn model_from_lattice(point: [f64; 3]) -> [f32; 3] {
    std::array::from_fn(|axis| (grid().origin_m[axis] + point[axis] * grid().spacing_m) as f32)
}

fn center(site: u32) -> [f64; 3] {
    grid().site(site as usize).map(|c| f64::from(c) + 0.5)
}

/// Points of the unit cube, evenly spread: the R3 sequence (Roberts 2018).
fn offsets_from(first: u32, count: u32) -> Vec<[f32; 3]> {
    let turn = [0.819_172_513_4, 0.671_043_606_7, 0.549_700_477_9];
    (first..first + count).map(|i| turn.map(|t: f64| ((0.5 + f64::from(i) * t) % 1.0) as f32)).collect()
}

#[test]
fn light_in_the_middle_of_a_site_is_the_sum_of_the_specification() {
    let (turbid, direction) = (turbid(), [0.48, 0.6, -0.64]);
    let sites = turbid.sites();
    let y = harmonics::evaluate(direction);
    let cases = Codec::ALL
        .map(|codec| (codec, DEGREE_2))
        .into_iter()
        .chain([(Codec::RawF32, WITH_SINGLE), (Codec::RawF32, UPRIGHT)]);
    for (codec, suns) in cases {
        let fields = fields(&suns);
        let beam = Near::new(&turbid, &sites, suns.needs_single()).beam(direction, 2);
        let library = library(&fields, codec);
        let (sampler, stored) = (PhysicalSampler::load(&library, 0).expect("it loads"), as_stored(&library));
        let near = sampler.near();
        // Any length of the vector will do.
        let terms = sampler.terms(direction.map(|c| c * 1e-200)).expect("a direction");
        let prepared = sampler.prepare(&near, terms, 2);
        for (place, &site) in sites.iter().enumerate().step_by(7) {
            let mut found = [f32::NAN; BANDS];
            sampler.fluence(&prepared, 2.0, 0.25, model_from_lattice(center(site)), &mut found);
            for (band, found) in found.into_iter().enumerate() {
                let of = |base: usize| stored[base].1.band(band as u32)[site as usize];
                let smooth: f32 = (0..9).map(|k| of(1 + k) * y[k] as f32).sum();
                let sharp: f32 =
                    (0..means(suns.needs_single())).map(|j| of(10 + j) * beam.mean(j, place)).sum();
                let factor =
                    if suns.is_leaning() { turbid.angles.relative(direction[1]) as f32 } else { 1.0 };
                let expected = (2.0 * (smooth + factor * sharp) + 0.25 * of(0)).max(0.0);
                assert!(
                    (found - expected).abs() < ROUNDING,
                    "{codec:?}, {suns:?}, {site}: {found} for {expected}"
                );
            }
        }
    }
}

#[test]
fn light_is_never_below_zero() {
    let mut fields = fields(&DEGREE_2);
    fields.bases[1].1.values_mut().fill(-3.0);
    let sampler = sampler(&fields, Codec::RawF32);
    let terms = sampler.terms([0.0, 1.0, 0.0]).expect("a direction");
    let prepared = sampler.prepare(&sampler.near(), terms, 1);
    let mut out = [f32::NAN; BANDS];
    sampler.fluence(&prepared, 1.0, 0.0, model_from_lattice([7.5; 3]), &mut out);
    assert_eq!(out, [0.0; BANDS]);
    sampler.fluence(&prepared, 0.0, 1.0, model_from_lattice([7.5; 3]), &mut out);
    let mut sky = [f32::NAN; BANDS];
    sampler.sky(model_from_lattice([7.5; 3]), &mut sky);
    assert_eq!(sky, out, "the sky alone is what is left without a sun");
    assert!(out.iter().all(|value| *value > 1.0), "the sky alone: {out:?}");
}

/// With b_0 = 1 and all else 0 the light is near_0 itself.
fn beam_alone() -> SpeciesFields {
    let mut fields = fields(&SunBasis::Harmonics { degree: 2, single: false, leaning: false });
    fields
        .bases
        .iter_mut()
        .for_each(|(base, field)| field.values_mut().fill(if *base == 10 { 1.0 } else { 0.0 }));
    fields
}

#[test]
fn empty_sites_do_not_darken_or_light_the_near_beam_beside_them() {
    let sampler = sampler(&beam_alone(), Codec::RawF32);
    let direction = [0.0, 1.0, 0.0];
    let prepared = sampler.prepare(&sampler.near(), sampler.terms(direction).expect("a direction"), 4);
    let light = |point: [f64; 3]| {
        let mut out = [f32::NAN; BANDS];
        sampler.fluence(&prepared, 1.0, 0.0, model_from_lattice(point), &mut out);
        out[0]
    };
    let is_there = |site: usize| sampler.sites.place_of(site).is_some();
    let pair = (0..grid().sites() - 1).find(|site| is_there(*site) && !is_there(site + 1));
    let site = pair.expect("the ball has an edge") as u32;
    let middle = center(site);
    let alone = prepared.near[sampler.sites.place_of(site as usize).expect("matter")][0];
    assert!((light(middle) - alone).abs() < 1e-6);
    assert!(
        (light([middle[0] + 0.4, middle[1], middle[2]]) - alone).abs() < 1e-6,
        "half-way to the empty site"
    );
    // No matter around: the beam at the point itself, open above and shaded below the ball.
    assert_eq!(light([7.5, 15.5, 7.5]), 1.0);
    let below = light([7.5, 0.5, 7.5]);
    assert!(below < 0.2 && below == dense::transmittance(&turbid(), [7.5, 0.5, 7.5], direction), "{below}");
}

#[test]
fn light_of_lattice_directions_is_their_blend_and_a_missing_one_is_refused() {
    let mut fields = fields(&SunBasis::Lattice18);
    fields.bases.retain(|(base, _)| ![7, 9].contains(base));
    let reason = "no low sun".to_owned();
    fields.meta.left_out = Some(LeftOut { bases: [9].into_iter().collect(), bands: vec![], reason });
    let sampler = sampler(&fields, Codec::RawF32);
    let direction = [0.2, 0.9, 0.4];
    let prepared = sampler.prepare(&sampler.near(), sampler.terms(direction).expect("all there"), 2);
    assert_eq!(prepared.size_bytes(), 0, "no near beam is needed");
    let (blend, site) = (SunBasis::Lattice18.blend(direction).expect("a direction"), grid().index(7, 8, 9));
    let of = |base: u8| fields.bases.iter().find(|(b, _)| *b == base).expect("kept").1.band(1)[site];
    let sun: f32 = (0..3).map(|i| blend.weights[i] * of(blend.bases[i])).sum();
    let mut out = [f32::NAN; BANDS];
    sampler.fluence(&prepared, 1.5, 0.5, model_from_lattice(center(site as u32)), &mut out);
    assert!((out[1] - (1.5 * sun + 0.5 * of(0)).max(0.0)).abs() < ROUNDING, "{out:?}");

    let refusal = |direction| sampler.terms(direction).expect_err("refused").to_string();
    assert!(refusal([-1.0, -1.0, 0.0]).contains("has no base 7, which the light needs; it has 0, 1,"));
    assert!(
        refusal([-1.0, 1.0, 0.0])
            .contains("has no base 9, which the light needs: it was left out (no low sun)")
    );
    assert!(refusal([0.0; 3]).starts_with("the direction towards the sun is [0.0, 0.0, 0.0], expected"));
    assert!(refusal([f64::NAN, 1.0, 0.0]).contains("NaN"));
}

/// Suns straight up, straight down, and 58 around the horizon: more bases than any other species has.
fn bipyramid() -> SunDirections {
    const AROUND: u32 = 58;
    let mut directions = vec![[0.0, 1.0, 0.0], [0.0, -1.0, 0.0]];
    directions.extend((0..AROUND).map(|k| sun::towards_sun(360.0 * f64::from(k) / f64::from(AROUND), 0.0)));
    let pairs = || (0..AROUND).map(|k| [2 + k, 2 + (k + 1) % AROUND]);
    let mut triangles: Vec<[u32; 3]> =
        pairs().map(|[k, next]| [0, next, k]).chain(pairs().map(|[k, next]| [1, k, next])).collect();
    triangles.sort_unstable();
    SunDirections::new(directions, triangles).expect("a bipyramid covers the sphere once")
}

#[test]
fn light_of_a_list_of_directions_is_the_blend_of_a_triangle() {
    let suns = SunBasis::Directions(bipyramid().into());
    let fields = fields(&suns);
    for codec in Codec::ALL {
        let library = library(&fields, codec);
        let (sampler, stored) = (PhysicalSampler::load(&library, 0).expect("it loads"), as_stored(&library));
        assert_eq!((stored.len(), sampler.suns()), (61, &suns));
        let site = grid().index(7, 8, 9);
        let of = |base: usize| stored[base].1.band(1)[site];
        let light = |direction: [f64; 3]| {
            let terms = sampler.terms(direction).expect("all bases are there");
            let prepared = sampler.prepare(&sampler.near(), terms, 2);
            assert_eq!(prepared.size_bytes(), 0, "no near beam is needed");
            let mut out = [f32::NAN; BANDS];
            sampler.fluence(&prepared, 1.5, 0.5, model_from_lattice(center(site as u32)), &mut out);
            out[1]
        };
        // Half-way up from the middle of two suns of the horizon, 57 and 58; they are bases 59 and 60.
        let [a, b] = [57, 56].map(|k| sun::towards_sun(360.0 * f64::from(k) / 58.0, 0.0));
        let between: [f64; 3] = std::array::from_fn(|i| (a[i] + b[i]) * 5e-200);
        let up = [between[0], 1e-199, between[2]];
        let expected = 1.5 * (0.5 * of(1) + 0.25 * of(59) + 0.25 * of(60)) + 0.5 * of(0);
        assert!((light(up) - expected).abs() < ROUNDING, "{codec:?}: {} for {expected}", light(up));
        let alone = 1.5 * of(60) + 0.5 * of(0);
        assert!((light(a) - alone).abs() < ROUNDING, "{codec:?}: {} for {alone}", light(a));
    }
}

#[test]
fn a_sampler_refuses_the_other_model() {
    let library = library(&fields(&DEGREE_2), Codec::HaarPaper);
    let error = SpeciesSampler::load(&library, 0, &[0, 1]).err().expect("refused").to_string();
    assert_eq!(error, "oak.flb: species \"oak\" is of the model \"physical\", expected \"paper\"");
    let error = PhysicalSampler::load(&library, 3).err().expect("refused").to_string();
    assert_eq!(error, "oak.flb: asked for species 3, the library holds 1");
    let golden = concat!(env!("CARGO_MANIFEST_DIR"), "/../format-spec/golden/physical.flb");
    let library = Library::open(golden).expect("the golden file opens");
    let error = PhysicalSampler::load(&library, 2).err().expect("refused").to_string();
    assert!(error.ends_with("species \"paper\" is of the model \"paper\", expected \"physical\""), "{error}");
    PhysicalSampler::load(&library, 0).expect("its first species is physical");
}

#[test]
fn a_march_follows_the_exponential_of_what_it_crosses() {
    let (leaf_per_m, wood_per_m) = (vec![0.3; grid().sites()], vec![0.2; grid().sites()]);
    let full = TurbidMedium { grid: grid(), leaf_per_m, wood_per_m, angles: LeafAngles::erectophile() };
    let diagonal = libm::sqrt(0.5);
    // Point in lattice coordinates, direction, way inside the lattice in site edges.
    let table = [
        ([8.0, 8.0, 8.0], [0.0, 1.0, 0.0], 8.0),
        ([8.3, 8.2, 8.1], [-1.0, 0.0, 0.0], 8.3),
        ([8.0, 8.0, 3.0], [diagonal, 0.0, diagonal], 8.0 / diagonal),
        ([2.25, 1.5, 15.9], [0.6, 0.0, -0.8], 15.9 / 0.8),
        ([-4.0, 5.0, 5.0], [1.0, 0.0, 0.0], 16.0),
        ([-4.0, 5.0, 5.0], [-1.0, 0.0, 0.0], 0.0),
        ([3.0, 20.0, 5.0], [0.0, 0.0, 1.0], 0.0),
        ([f64::NAN, 1.0, 1.0], [0.6, 0.8, 0.0], 0.0),
    ];
    for (point, direction, way) in table {
        let per_m = full.extinction_along(0, direction[1]);
        let expected = libm::exp(-per_m * way * grid().spacing_m);
        let found = dense::transmittance(&full, point, direction);
        assert!((f64::from(found) - expected).abs() < 1e-6, "{point:?}: {found} for {expected}");
    }
}

#[test]
fn marched_means_agree_with_the_prepared_beam() {
    let samplers = [DEGREE_2, WITH_SINGLE].map(|suns| sampler(&fields(&suns), Codec::RawF32));
    let directions = [[0.0, 1.0, 0.0], [0.48, 0.6, -0.64]];
    for (sampler, direction) in samplers.iter().flat_map(|sampler| directions.map(|d| (sampler, d))) {
        let (marcher, single) = (sampler.marcher(), sampler.suns().needs_single());
        let terms = sampler.terms(direction).expect("a direction");
        let prepared = sampler.prepare(&sampler.near(), terms, 8);
        let (mut marched, mut expected, mut square) = ([0.0; MAX_MEANS], [0.0; MAX_MEANS], [0.0; MAX_MEANS]);
        let mut count = 0.0;
        for (number, &site) in (0..).zip(sampler.sites.sites()).step_by(2) {
            let within = offsets_from(7 * number, 1)[0];
            let corner = center(site).map(|c| c - 0.5);
            // In the middle of a site, where no other counts, and between sites.
            for part in [[0.5; 3], within.map(f64::from)] {
                let point = model_from_lattice(std::array::from_fn(|axis| corner[axis] + part[axis]));
                // The same offsets everywhere would be off to the same side everywhere.
                let found = marcher.near(point, direction, &offsets_from(site * 64, 64));
                let wanted = sampler.sites.near_at(&prepared, single, point);
                for j in 0..means(single) {
                    marched[j] += found[j];
                    expected[j] += wanted[j];
                    square[j] += (found[j] - wanted[j]) * (found[j] - wanted[j]);
                }
                count += 1.0;
            }
        }
        for j in 0..means(single) {
            let (bias, rms) = (marched[j] / expected[j] - 1.0, (square[j] / count).sqrt());
            // 64 places per mean, of values from 0 to 1; some hundred means.
            assert!(
                bias.abs() < 0.01 && rms < 0.05,
                "{single}, near_{j} towards {direction:?}: bias {bias}, rms {rms}"
            );
        }
    }
}

#[test]
fn a_march_far_from_matter_has_the_beam_of_the_point_in_every_mean() {
    let sampler = sampler(&fields(&WITH_SINGLE), Codec::RawF32);
    let mut lone = turbid();
    lone.leaf_per_m.fill(0.0);
    lone.wood_per_m.fill(0.0);
    let sampler = PhysicalSampler { sites: Arc::new(MediumSites::new(lone).expect("memory")), ..sampler };
    let near = sampler.marcher().near(model_from_lattice([3.0; 3]), [0.0, 1.0, 0.0], &offsets_from(0, 4));
    assert_eq!(near, [1.0, 1.0, 0.0, 0.0], "nothing scatters");
}
