//! The surfaces of a species file: given per band, or computed from what the leaf is made of.

use flb_format::{BandSurfaces, Surfaces};
use serde::Deserialize;

use super::{Malformed, validate_names};
use crate::import::ImportError;
use crate::leaf::{Bands, LeafModel, Range};

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

/// The surfaces that the file gives, one way or the other; `None` if neither.
pub(super) fn resolve(
    given: Option<Vec<BandSurfaces>>,
    model: Option<RawLeafModel>,
    malformed: &Malformed,
) -> Result<Option<Surfaces>, ImportError> {
    match (given, model) {
        (None, None) => Ok(None),
        (Some(bands), None) => validate(bands, malformed).map(Some),
        (None, Some(model)) => compute(model, malformed).map(Some),
        (Some(_), Some(_)) => {
            Err(malformed("surfaces", "[[surfaces]] and [leaf_model]".to_owned(), "one of them"))
        }
    }
}

fn validate(bands: Vec<BandSurfaces>, malformed: &Malformed) -> Result<Surfaces, ImportError> {
    validate_names("surfaces", bands.iter().map(|band| band.name.as_str()), malformed)?;
    for (index, band) in bands.iter().enumerate() {
        let place = |key: &str| format!("surfaces[{index}].{key}");
        let (reflectance, transmittance) = (band.leaf.reflectance, band.leaf.transmittance);
        within(&place("leaf.reflectance"), reflectance, 0.0, 1.0, malformed)?;
        within(&place("leaf.transmittance"), transmittance, 0.0, 1.0, malformed)?;
        within(&place("wood.reflectance"), band.wood.reflectance, 0.0, 1.0, malformed)?;
        if reflectance + transmittance > 1.0 {
            let found = format!("reflectance + transmittance = {}", reflectance + transmittance);
            return Err(malformed(&place("leaf"), found, "at most 1"));
        }
    }
    Ok(Surfaces { bands })
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
