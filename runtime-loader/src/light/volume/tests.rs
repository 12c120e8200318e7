use flb_format::light::SunBasis;
use flb_format::sun::towards_sun;
use flb_format::{Codec, Transform};

use super::*;
use crate::plants::{BANDS, noise, plant};
use crate::{Daylight, SpeciesLight};

const LATTICE: u32 = 32;
const DAY: Daylight = Daylight { towards_sun: [0.6, 0.5, -0.62], sun: 1.3, sky: 0.2 };

fn kinds() -> [Option<SunBasis>; 4] {
    let harmonics = |single| Some(SunBasis::Harmonics { degree: 2, single, leaning: true });
    [None, Some(SunBasis::Lattice18), harmonics(false), harmonics(true)]
}

fn species(suns: Option<&SunBasis>, codec: Codec) -> SpeciesLight<'static> {
    let library = crate::plants::library(&[plant("oak", suns, LATTICE, 7)], codec);
    SpeciesLight::load(&library, 0).expect("a sound file")
}

fn lit<'l>(light: &'l SpeciesLight, daylight: &Daylight) -> InstanceLight<'l> {
    light.lit_by(daylight, &Transform::IDENTITY).expect("a sun")
}

/// A point in the plant, whose blocks are stored.
fn point(seed: u32) -> [f32; 3] {
    let along = |axis: u32| 2.0 * noise(seed * 3 + axis, 5) - 1.0;
    [along(0), 2.0 + along(1), along(2)]
}

fn at(mut light: impl FnMut([f32; 3], &mut [f32]), point: [f32; 3]) -> [f32; BANDS] {
    let mut rgb = [0.0; BANDS];
    light(point, &mut rgb);
    rgb
}

/// Root of the mean square and mean of the differences over the plant, as shares of the mean.
fn error(found: impl Fn([f32; 3], &mut [f32]), expected: impl Fn([f32; 3], &mut [f32])) -> [f64; 2] {
    let (mut squares, mut sum, mut mean, mut count) = (0.0, 0.0, 0.0, 0.0);
    for point in (0..2000).map(point) {
        for (found, expected) in at(&found, point).into_iter().zip(at(&expected, point)) {
            let off = f64::from(found - expected);
            (squares, sum) = (squares + off * off, sum + off);
            (mean, count) = (mean + f64::from(expected), count + 1.0);
        }
    }
    [libm::sqrt(squares / count), sum / count].map(|error| error / (mean / count).abs())
}

#[test]
fn a_volume_has_the_light_of_its_sun_and_sky() {
    for (suns, codec) in kinds().iter().flat_map(|suns| [(suns, Codec::Classed), (suns, Codec::Haar)]) {
        let species = species(suns.as_ref(), codec);
        let lit = lit(&species, &DAY).prepared();
        let volume = lit.volume().expect("blocks near geometry");
        assert_eq!(volume.bands(), BANDS);
        let [rms, bias] = error(|point, out| volume.at(point, out), |point, out| lit.at(point, out));
        // Without a near beam, what is between texels is linear in either: the bits alone count. The product of a beam
        // with these fields, which are noise, is not.
        let most = if lit.terms().needs_near() { 0.03 } else { 0.002 };
        assert!(rms < most && bias.abs() < most / 3.0, "{suns:?} {codec:?}: {rms} {bias}");
        // A texel has three codes of a byte, of which a block shares its bounds.
        let blocks = species.resident().shared().expect("a map").map.len();
        let map = &species.resident().shared().expect("a map").map;
        assert_eq!(volume.size_bytes(), LightVolume::bytes_of(map, BANDS));
        assert!(volume.size_bytes() >= blocks * BANDS * (64 + 8), "{} bytes", volume.size_bytes());
        assert!(volume.size_bytes() < blocks * BANDS * (64 + 8) + BANDS * 4 * 64);
    }
}

#[test]
fn sites_with_matter_have_their_light_to_the_bits() {
    for suns in kinds() {
        let species = species(suns.as_ref(), Codec::Classed);
        let lit = lit(&species, &DAY).prepared();
        let volume = lit.volume().expect("blocks near geometry");
        let turbid_sites = (0..LATTICE.pow(3)).filter(|site| {
            let sites = species.resident().sites();
            sites.is_some_and(|sites| sites.place_of(*site as usize).is_some())
        });
        let grid = *species.grid();
        for site in turbid_sites.step_by(7) {
            let center = grid.model_from_lattice(grid.site(site as usize).map(|x| f64::from(x) + 0.5));
            let center = center.map(|x| x as f32);
            let (found, expected) =
                (at(|p, out| volume.at(p, out), center), at(|p, out| lit.at(p, out), center));
            for (found, expected) in found.iter().zip(expected) {
                assert!((found - expected).abs() < 0.02, "{suns:?}: {found} {expected}");
            }
        }
    }
}

#[test]
fn expanded_fields_have_the_light_of_coded_ones_for_any_sun() {
    for suns in kinds() {
        let species = species(suns.as_ref(), Codec::Classed);
        let fields = species.field_volume().expect("blocks near geometry");
        for (azimuth_deg, elevation_deg) in [(0.0, 30.0), (200.0, 5.0), (77.0, 80.0)] {
            let daylight = Daylight { towards_sun: towards_sun(azimuth_deg, elevation_deg), ..DAY };
            let coded = lit(&species, &daylight).prepared();
            let expanded = lit(&species, &daylight).prepared().with_fields(&fields);
            let expected = |point: [f32; 3], out: &mut [f32]| coded.at(point, out);
            let [rms, bias] = error(|point, out| expanded.at(point, out), expected);
            assert!(rms < 0.004 && bias.abs() < 0.001, "{suns:?}: {rms} {bias}");
            // A cursor asks the same fields.
            let mut cursor = expanded.cursor();
            for point in (0..20).map(point) {
                let mut rgb = [0.0; BANDS];
                cursor.at(point, &mut rgb);
                assert_eq!(rgb, at(|point, out| expanded.at(point, out), point));
            }
        }
    }
}

#[test]
fn outside_of_the_lattice_and_of_its_blocks_the_light_goes_on() {
    let species = species(kinds()[3].as_ref(), Codec::Classed);
    let day = || lit(&species, &DAY).prepared();
    let (lit, volume) = (day(), day().volume().expect("blocks near geometry"));
    let fields = species.field_volume().expect("blocks near geometry");
    let expanded = day().with_fields(&fields);
    let corner = at(|point, out| volume.at(point, out), [-1.99, 0.01, -1.99]);
    for far in [[-90.0, -5.0, -3.0], [f32::NAN, f32::NEG_INFINITY, f32::NAN]] {
        let found = at(|point, out| volume.at(point, out), far);
        assert!(
            found.iter().zip(corner).all(|(found, near)| (found - near).abs() < 0.05),
            "{found:?} {corner:?}"
        );
        assert!(at(|point, out| expanded.at(point, out), far).iter().all(|light| light.is_finite()));
    }
    // No block is stored in the corners of a round plant: what stands in is as bright as the light there.
    let map = &species.resident().shared().expect("a map").map;
    assert!(map.rank([0; 3]).is_none() && !map.is_full());
    let expected = at(|point, out| lit.at(point, out), [-1.8, 0.2, -1.8]);
    let found = at(|point, out| volume.at(point, out), [-1.8, 0.2, -1.8]);
    assert!(
        found.iter().zip(expected).all(|(found, light)| (found / light - 1.0).abs() < 0.3),
        "{found:?} {expected:?}"
    );
}

#[test]
fn other_codecs_have_no_volumes() {
    let species = species(kinds()[1].as_ref(), Codec::HaarPaper);
    assert!(lit(&species, &DAY).volume().is_none());
    assert!(species.field_volume().is_none());
}
