//! The surfaces of a species file: given per band, or computed from what the leaf is made of.

use flb_format::matter::{BandSurfaces, LeafSurface, Surfaces, WoodSurface};
use serde::Deserialize;

use super::{MAX_PATTERN_BYTES, MAX_PATTERNS, Malformed, validate_names};
use crate::color::SurfaceSet;
use crate::import::ImportError;
use crate::leaf::{Bands, LeafModel, Range, knapp_carter};

/// The table `[leaf_model]`. What is left out has the value of a common green leaf.
#[derive(Deserialize)]
#[serde(deny_unknown_fields)]
pub(super) struct RawLeafModel {
    structure: Option<f64>,
    chlorophyll_ug_cm2: Option<f64>,
    carotenoids_ug_cm2: Option<f64>,
    anthocyanins_ug_cm2: Option<f64>,
    water_cm: Option<f64>,
    dry_matter_g_cm2: Option<f64>,
    /// Reflectance of wood, one per band.
    wood: Option<Vec<f64>>,
    /// R, G, B if absent.
    bands: Option<Vec<RawRange>>,
}

#[derive(Deserialize)]
#[serde(deny_unknown_fields)]
struct RawRange {
    name: String,
    nm: [f64; 2],
}

/// A table of `[[surfaces]]`: a band of everything, or of the materials that a pattern matches.
#[derive(Deserialize)]
#[serde(deny_unknown_fields)]
pub(super) struct RawSurface {
    material: Option<String>,
    name: String,
    leaf: Option<LeafSurface>,
    wood: Option<WoodSurface>,
}

/// Surfaces of everything, if the file gives some, and of materials that have others.
pub(super) struct Resolved {
    pub surfaces: Option<Surfaces>,
    pub sets: Vec<SurfaceSet>,
}

/// The surfaces that the file gives, one way or the other.
pub(super) fn resolve(
    given: Option<Vec<RawSurface>>,
    model: Option<RawLeafModel>,
    malformed: &Malformed,
) -> Result<Resolved, ImportError> {
    let given = match given {
        Some(bands) if bands.is_empty() => {
            return Err(malformed("surfaces", "0 bands".to_owned(), "1..=64 bands"));
        }
        other => other.unwrap_or_default(),
    };
    let is_of_all = |(_, band): &(usize, RawSurface)| band.material.is_none();
    let (of_all, own): (Vec<_>, Vec<_>) = given.into_iter().enumerate().partition(is_of_all);
    let surfaces = match (of_all.is_empty(), model) {
        (true, None) => None,
        (false, None) => Some(validate(of_all, None, malformed)?),
        (true, Some(model)) => Some(compute(model, malformed)?),
        (false, Some(_)) => {
            return Err(malformed("surfaces", "[[surfaces]] and [leaf_model]".to_owned(), "one of them"));
        }
    };
    let rest = surfaces.clone().unwrap_or_else(knapp_carter);
    Ok(Resolved { surfaces, sets: sets(own, &rest, malformed)? })
}

/// Sets by pattern, in the order of their first bands.
fn sets(
    own: Vec<(usize, RawSurface)>,
    rest: &Surfaces,
    malformed: &Malformed,
) -> Result<Vec<SurfaceSet>, ImportError> {
    let mut groups: Vec<(String, Vec<(usize, RawSurface)>)> = Vec::new();
    for (index, band) in own {
        let pattern = band.material.clone().unwrap_or_default();
        if pattern.is_empty() || pattern.len() > MAX_PATTERN_BYTES {
            let found = format!("a pattern of {} bytes", pattern.len());
            return Err(malformed(&format!("surfaces[{index}].material"), found, "1 to 256 bytes"));
        }
        match groups.iter_mut().find(|(known, _)| *known == pattern) {
            Some((_, bands)) => bands.push((index, band)),
            None => groups.push((pattern, vec![(index, band)])),
        }
    }
    if groups.len() > MAX_PATTERNS {
        return Err(malformed("surfaces", format!("{} materials", groups.len()), "at most 256 materials"));
    }
    let set = |(pattern, bands): (String, Vec<(usize, RawSurface)>)| {
        Ok(SurfaceSet { pattern, surfaces: validate(bands, Some(rest), malformed)? })
    };
    groups.into_iter().map(set).collect()
}

/// Of everything, or, with `rest`, of some materials among that: the same bands, and what is not said is the rest's.
fn validate(
    bands: Vec<(usize, RawSurface)>,
    rest: Option<&Surfaces>,
    malformed: &Malformed,
) -> Result<Surfaces, ImportError> {
    let names: Vec<&str> = bands.iter().map(|(_, band)| band.name.as_str()).collect();
    if let Some(rest) = rest {
        let expected: Vec<&str> = rest.bands.iter().map(|band| band.name.as_str()).collect();
        if names != expected {
            let place = format!("surfaces[{}].name", bands[0].0);
            let wanted = format!("{}, as everything else has", expected.join(", "));
            return Err(malformed(&place, format!("the bands {}", names.join(", ")), &wanted));
        }
    }
    validate_names("surfaces", names.into_iter(), malformed)?;
    let mut found = Vec::with_capacity(bands.len());
    for (at, (index, band)) in bands.into_iter().enumerate() {
        let place = |key: &str| format!("surfaces[{index}].{key}");
        let of_rest = rest.map(|rest| &rest.bands[at]);
        let missing = |key: &str| malformed(&place(key), "nothing".to_owned(), "a table");
        let leaf = band.leaf.or(of_rest.map(|rest| rest.leaf)).ok_or_else(|| missing("leaf"))?;
        let wood = band.wood.or(of_rest.map(|rest| rest.wood)).ok_or_else(|| missing("wood"))?;
        let (reflectance, transmittance) = (leaf.reflectance, leaf.transmittance);
        within(&place("leaf.reflectance"), reflectance, 0.0, 1.0, malformed)?;
        within(&place("leaf.transmittance"), transmittance, 0.0, 1.0, malformed)?;
        within(&place("wood.reflectance"), wood.reflectance, 0.0, 1.0, malformed)?;
        if reflectance + transmittance > 1.0 {
            let found = format!("reflectance + transmittance = {}", reflectance + transmittance);
            return Err(malformed(&place("leaf"), found, "at most 1"));
        }
        found.push(BandSurfaces { name: band.name, leaf, wood });
    }
    Ok(Surfaces { bands: found })
}

fn compute(raw: RawLeafModel, malformed: &Malformed) -> Result<Surfaces, ImportError> {
    let common = LeafModel::default();
    let model = LeafModel {
        structure: raw.structure.unwrap_or(common.structure),
        chlorophyll_ug_cm2: raw.chlorophyll_ug_cm2.unwrap_or(common.chlorophyll_ug_cm2),
        carotenoids_ug_cm2: raw.carotenoids_ug_cm2.unwrap_or(common.carotenoids_ug_cm2),
        anthocyanins_ug_cm2: raw.anthocyanins_ug_cm2.unwrap_or(common.anthocyanins_ug_cm2),
        water_cm: raw.water_cm.unwrap_or(common.water_cm),
        dry_matter_g_cm2: raw.dry_matter_g_cm2.unwrap_or(common.dry_matter_g_cm2),
    };
    for (key, value, low, high) in model.parameters() {
        within(&format!("leaf_model.{key}"), value, low, high, malformed)?;
    }
    let bands = match raw.bands {
        Some(ranges) => Bands::Ranges(validate_ranges(ranges, malformed)?),
        None => Bands::Rgb,
    };
    let mut surfaces = model.surfaces(&bands);
    if let Some(wood) = raw.wood {
        if wood.len() != surfaces.bands.len() {
            let expected = format!("{}, one per band", surfaces.bands.len());
            return Err(malformed("leaf_model.wood", format!("{} values", wood.len()), &expected));
        }
        for (index, (band, value)) in surfaces.bands.iter_mut().zip(wood).enumerate() {
            within(&format!("leaf_model.wood[{index}]"), value, 0.0, 1.0, malformed)?;
            band.wood.reflectance = value;
        }
    }
    Ok(surfaces)
}

fn validate_ranges(ranges: Vec<RawRange>, malformed: &Malformed) -> Result<Vec<Range>, ImportError> {
    validate_names("leaf_model.bands", ranges.iter().map(|range| range.name.as_str()), malformed)?;
    let (first, last) = Bands::LIMITS_NM;
    for (index, RawRange { nm: [low, high], .. }) in ranges.iter().enumerate() {
        if !(first <= *low && low < high && *high <= last) {
            let expected = format!("two rising wavelengths within {first}..={last} nm");
            return Err(malformed(
                &format!("leaf_model.bands[{index}].nm"),
                format!("[{low}, {high}]"),
                &expected,
            ));
        }
    }
    Ok(ranges
        .into_iter()
        .map(|range| Range { name: range.name, low_nm: range.nm[0], high_nm: range.nm[1] })
        .collect())
}

fn within(place: &str, value: f64, low: f64, high: f64, malformed: &Malformed) -> Result<(), ImportError> {
    match (low..=high).contains(&value) {
        true => Ok(()),
        false => Err(malformed(place, value.to_string(), &format!("{low}..={high}"))),
    }
}

#[cfg(test)]
mod tests;
