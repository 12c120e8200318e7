//! Whether the arrays of a species fit its metadata and hold values that the format takes.

use flb_format::bases::BaseSet;
use flb_format::container::records::MAX_MAGNITUDE;
use flb_format::matter::Class;
use flb_format::{Codec, Field};
use rayon::prelude::*;

use crate::PackError;
use flb_format::SpeciesFields;

/// The bases in ascending order, once their shapes and values fit the metadata and the codec.
pub(super) fn fields(fields: &SpeciesFields, codec: Codec) -> Result<Vec<&(u8, Field)>, PackError> {
    let name = &fields.meta.name;
    let shape = |what: String, found: String, expected: String| {
        let species = name.clone();
        Err(PackError::Shape { species, what, found, expected })
    };
    let (model, items) = (&fields.meta.model, fields.meta.model.items());
    let mut bases: Vec<&(u8, Field)> = fields.bases.iter().collect();
    bases.sort_by_key(|(base, _)| *base);
    if bases.is_empty() {
        return shape("number of bases".into(), "0".into(), format!("1 to {items}"));
    }
    if let Some(pair) = bases.windows(2).find(|pair| pair[0].0 == pair[1].0) {
        return shape(format!("base {}", pair[0].0), "given twice".into(), "given once".into());
    }
    let (lattice, bands) = (fields.meta.grid.lattice, fields.meta.band_count() as u32);
    for (base, field) in &bases {
        if u16::from(*base) >= items {
            return shape("base".into(), base.to_string(), format!("0 to {}", items - 1));
        }
        let found = (field.lattice, field.bands, field.len());
        let expected = (lattice, bands, fields.meta.grid.sites() * bands as usize);
        if found != expected {
            let what = format!("(lattice, bands, values) of base {base}");
            return shape(what, format!("{found:?}"), format!("{expected:?}"));
        }
    }
    let whole = fields.meta.physical().filter(|_| model.needs_all_items());
    if let Some((_, light)) = whole.filter(|_| bases.len() < usize::from(items)) {
        let (found, suns) = (bases.len().to_string(), light.suns.name());
        return shape("number of bases".into(), found, format!("all {items}, as the suns are {suns}"));
    }
    let left_out = fields.meta.left_out.as_ref().map_or(BaseSet::NONE, |left_out| left_out.bases);
    if let Some((base, _)) = bases.iter().find(|(base, _)| left_out.contains(*base)) {
        return shape(format!("base {base}"), "given".into(), "none, as the metadata leave it out".into());
    }
    bases.par_iter().try_for_each(|(base, field)| {
        let most = codec.max_magnitude();
        let bad = |value: &f32| !matches!(value.abs().partial_cmp(&most), Some(o) if o.is_le());
        match field.position(bad) {
            None => Ok(()),
            Some((band, site)) => {
                let (species, found) = (name.clone(), field.value(band, site));
                let most = match codec {
                    Codec::RawF16 => "65504, the largest that raw-f16 holds",
                    Codec::RawF32 | Codec::HaarPaper | Codec::Classed | Codec::Haar => "2^96",
                };
                Err(PackError::FieldValue { species, base: *base, band, site, found, most })
            }
        }
    })?;
    Ok(bases)
}

pub(super) fn medium(fields: &SpeciesFields) -> Result<(), PackError> {
    let (medium, species) = (&fields.medium, || fields.meta.name.clone());
    if medium.grid != fields.meta.grid {
        return Err(PackError::Shape {
            species: species(),
            what: "the medium's grid".into(),
            found: format!("{:?}", medium.grid),
            expected: format!("{:?}, as in the metadata", fields.meta.grid),
        });
    }
    let sites = medium.grid.sites();
    let arrays = [
        ("density", &medium.density, 1.0),
        ("leaf area density", &medium.leaf_area_density, MAX_MAGNITUDE),
        ("wood area density", &medium.wood_area_density, MAX_MAGNITUDE),
    ];
    for (array, values, most) in arrays {
        if values.len() != sites || medium.class.len() != sites {
            let (found, expected) = (values.len().min(medium.class.len()), sites.to_string());
            let what = format!("length of {array} or class");
            return Err(PackError::Shape { species: species(), what, found: found.to_string(), expected });
        }
        if let Some(site) = values.iter().position(|value| !(0.0..=most).contains(value)) {
            let found = values[site].to_string();
            let expected = if most == 1.0 { "0 to 1" } else { "0 to 2^96" };
            return Err(PackError::MediumValue { species: species(), array, site, found, expected });
        }
    }
    let empty_without_density =
        |site: &usize| (medium.class[*site] == Class::Empty) == (medium.density[*site] == 0.0);
    if let Some(site) = (0..sites).find(|site| !empty_without_density(site)) {
        let found = format!("{:?} at density {}", medium.class[site], medium.density[site]);
        let expected = "Empty exactly where the density is 0";
        return Err(PackError::MediumValue { species: species(), array: "class", site, found, expected });
    }
    Ok(())
}

/// Extinction goes with the model, and agrees with the metadata about places and leaf angles.
pub(super) fn turbid(fields: &SpeciesFields) -> Result<(), PackError> {
    let species = || fields.meta.name.clone();
    let shape = |what: &str, found: String, expected: String| {
        Err(PackError::Shape { species: species(), what: what.to_owned(), found, expected })
    };
    let (turbid, light) = match (&fields.turbid, fields.meta.physical()) {
        (None, None) => return Ok(()),
        (Some(turbid), Some((_, light))) => (turbid, light),
        (turbid, _) => {
            let found = if turbid.is_some() { "given" } else { "absent" };
            let expected = "given for the model \"physical\" and for no other";
            return shape("the extinction", found.to_owned(), expected.to_owned());
        }
    };
    if turbid.grid != fields.meta.grid {
        let expected = format!("{:?}, as in the metadata", fields.meta.grid);
        return shape("the extinction's grid", format!("{:?}", turbid.grid), expected);
    }
    if turbid.angles != light.leaf_angles {
        let (found, expected) = (format!("{:?}", turbid.angles.shares()), light.leaf_angles.shares());
        return shape("the leaf angles", found, format!("{expected:?}, as in the metadata"));
    }
    let sites = turbid.grid.sites();
    for (array, values) in [("leaf extinction", &turbid.leaf_per_m), ("wood extinction", &turbid.wood_per_m)]
    {
        if values.len() != sites {
            let what = format!("length of {array}");
            return shape(&what, values.len().to_string(), sites.to_string());
        }
        if let Some(site) = values.iter().position(|value| !(0.0..=MAX_MAGNITUDE).contains(value)) {
            let (found, expected) = (values[site].to_string(), "0 to 2^96");
            return Err(PackError::MediumValue { species: species(), array, site, found, expected });
        }
    }
    Ok(())
}
