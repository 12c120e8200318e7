//! What the false colours say of a place.

use flb_format::blocks::EDGE;
use flb_runtime::resident::{LightLevel, ResidentSpecies, Terms};

/// Relative error that is white.
const WHITE_ERROR: f32 = 0.1;
/// Where it is darker than this share of the light outside, errors are relative to that.
const DARK: f32 = 0.02;
/// A species without light.
const UNLIT: [f32; 3] = [0.1, 0.1, 0.3];

/// Light of one base, per band.
pub(crate) fn base(species: &ResidentSpecies, base: u16, point_model_m: [f32; 3]) -> [f32; 3] {
    let mut light = [0.0; 3];
    let bands = species.bands().min(3);
    species.base_at(usize::from(base), point_model_m, &mut light[..bands]);
    light.map(|value| value.max(0.0))
}

/// Red, orange, yellow, green.
pub(crate) fn level(level: Option<LightLevel>) -> [f32; 3] {
    match level {
        None => UNLIT,
        Some(LightLevel::Outside) => [0.7, 0.02, 0.02],
        Some(LightLevel::Other) => [0.7, 0.2, 0.02],
        Some(LightLevel::Averages) => [0.7, 0.6, 0.05],
        Some(LightLevel::Whole) => [0.05, 0.5, 0.08],
    }
}

/// Share of the terms' bases whose detail is loaded at a point.
pub(crate) fn residency(
    species: Option<&ResidentSpecies>,
    terms: Option<&Terms>,
    point_model_m: [f32; 3],
) -> [f32; 3] {
    let (Some(species), Some(terms)) = (species, terms) else { return UNLIT };
    let near = terms.near_bases().0;
    let bases: Vec<u16> = terms.bases().map(|(base, _)| base).chain(near).collect();
    let last = f64::from(species.grid().lattice - 1);
    let block = species
        .grid()
        .lattice_from_model(point_model_m.map(f64::from))
        .map(|c| c.clamp(0.0, last) as u32 / EDGE as u32);
    let is_there = |base: &&u16| {
        species.base(usize::from(**base)).is_some_and(|coded| {
            coded.shared().map.rank(block).is_none_or(|rank| coded.is_detailed(rank as usize))
        })
    };
    let share = bases.iter().filter(is_there).count() as f32 / bases.len().max(1) as f32;
    [share; 3]
}

/// How far light is from what it should be.
pub(crate) fn error(found: [f32; 3], expected: [f32; 3], outside: f32) -> [f32; 3] {
    let luminance = |light: [f32; 3]| 0.2126 * light[0] + 0.7152 * light[1] + 0.0722 * light[2];
    let (found, expected) = (luminance(found), luminance(expected));
    let relative = (found - expected).abs() / expected.max(DARK * outside).max(f32::MIN_POSITIVE);
    [(relative / WHITE_ERROR).min(1.0); 3]
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn an_error_is_relative_to_the_light_but_not_where_there_is_hardly_any() {
        assert_eq!(error([1.0; 3], [1.0; 3], 1.0), [0.0; 3]);
        assert!((error([1.05; 3], [1.0; 3], 1.0)[0] - 0.5).abs() < 1e-5);
        assert_eq!(error([2.0; 3], [1.0; 3], 1.0), [1.0; 3]);
        let in_the_dark = error([0.001; 3], [0.0; 3], 1.0)[0];
        assert!((in_the_dark - 0.5).abs() < 1e-5, "{in_the_dark}");
        assert_eq!(error([0.0; 3], [0.0; 3], 0.0), [0.0; 3]);
    }

    #[test]
    fn levels_can_be_told_apart() {
        let all = [
            None,
            Some(LightLevel::Outside),
            Some(LightLevel::Other),
            Some(LightLevel::Averages),
            Some(LightLevel::Whole),
        ];
        let colors: Vec<_> = all.map(level).to_vec();
        for (i, one) in colors.iter().enumerate() {
            let apart = |other: &[f32; 3]| one.iter().zip(other).map(|(a, b)| (a - b).abs()).sum::<f32>();
            assert!(colors.iter().skip(i + 1).all(|other| apart(other) > 0.15), "{i}");
        }
    }
}
