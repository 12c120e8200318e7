//! Species metadata to canonical JSON and back, with every limit on its values (SPEC.md section 9).

mod light;

use crate::meta::MAX_REASON_BYTES;

use crate::text::is_hidden;
use serde_json::Value;

use super::records::{LATTICES, MAX_BANDS, MAX_METADATA_BYTES};
use crate::SpeciesMeta;
use crate::canonical::{self, JsonFault};
use crate::error::{FormatError, Place};
use crate::mean_light::MeanLight;
use crate::meta::LeftOut;
use crate::model::Model;
use crate::optics::Optics;

/// Largest size of a name, in bytes, UTF-8.
pub const MAX_NAME_BYTES: usize = 255;
/// Largest magnitude of a coordinate, metres.
pub const MAX_COORDINATE_M: f64 = 1e9;
/// Smallest edge of a site, metres.
pub const MIN_SPACING_M: f64 = 1e-9;

/// A metadata value that breaks a rule.
pub struct MetaFault {
    /// Path of the value.
    pub field: String,
    /// Value found.
    pub found: String,
    /// Value expected.
    pub expected: &'static str,
}

impl MetaFault {
    fn at(self, place: Place) -> FormatError {
        let MetaFault { field, found, expected } = self;
        FormatError::MetaValue { place, field, found, expected: expected.to_owned() }
    }
}

/// Checks metadata and writes it as canonical JSON. `place` is only named in errors.
pub fn to_bytes(meta: &SpeciesMeta, place: Place) -> Result<Vec<u8>, FormatError> {
    check(meta).map_err(|fault| fault.at(place))?;
    let value = serde_json::to_value(meta).map_err(|e| FormatError::Json { place, reason: e.to_string() })?;
    let bytes = canonical::to_bytes(&value).map_err(|fault| json_error(fault, place))?;
    if bytes.len() as u64 > MAX_METADATA_BYTES {
        return Err(FormatError::Limit {
            place,
            what: "size of metadata",
            found: bytes.len() as u64,
            limit: MAX_METADATA_BYTES,
        });
    }
    Ok(bytes)
}

/// Parses metadata from canonical JSON and checks it.
pub fn from_bytes(bytes: &[u8], place: Place) -> Result<SpeciesMeta, FormatError> {
    let value: Value = canonical::from_bytes(bytes).map_err(|fault| json_error(fault, place))?;
    check_objects(&value).map_err(|fault| fault.at(place))?;
    let meta: SpeciesMeta = serde_json::from_value(value).map_err(|e| FormatError::MetaValue {
        place,
        field: "metadata".to_owned(),
        found: e.to_string(),
        expected: "the keys and types of SPEC.md section 9".to_owned(),
    })?;
    check(&meta).map_err(|fault| fault.at(place))?;
    Ok(meta)
}

/// Refuses arrays where objects belong: serde takes them for structs. What is missing, serde finds.
fn check_objects(value: &Value) -> Result<(), MetaFault> {
    let object = |field: &str, value: Option<&Value>| match value {
        Some(value) if !value.is_object() => {
            let (field, found) = (field.to_owned(), value.to_string().chars().take(80).collect());
            Err(MetaFault { field, found, expected: "an object" })
        }
        _ => Ok(()),
    };
    object("metadata", Some(value))?;
    for field in ["bounds_m", "grid", "left_out", "light", "mean_light", "triangles"] {
        object(field, value.get(field))?;
    }
    let items = |field| value.get(field).and_then(Value::as_array).into_iter().flatten().enumerate();
    for list in ["optics", "surfaces"] {
        for (i, band) in items(list) {
            object(&format!("{list}[{i}]"), Some(band))?;
            for class in ["leaf", "wood"] {
                object(&format!("{list}[{i}].{class}"), band.get(class))?;
            }
        }
    }
    let light = value.get("light");
    for field in ["suns", "error"] {
        object(&format!("light.{field}"), light.and_then(|light| light.get(field)))?;
    }
    let error = light.and_then(|light| light.get("error"));
    object("light.error.monte_carlo", error.and_then(|error| error.get("monte_carlo")))?;
    for (i, source) in items("sources") {
        object(&format!("sources[{i}]"), Some(source))?;
    }
    Ok(())
}

fn json_error(fault: JsonFault, place: Place) -> FormatError {
    match fault {
        JsonFault::Syntax(reason) => FormatError::Json { place, reason },
        JsonFault::Form(reason) => FormatError::JsonForm { place, reason },
    }
}

/// Finds the first value that breaks a rule.
pub fn check(meta: &SpeciesMeta) -> Result<(), MetaFault> {
    let rule = |holds: bool, field: &str, found: &dyn std::fmt::Display, expected: &'static str| {
        if holds {
            return Ok(());
        }
        Err(MetaFault { field: field.to_owned(), found: found.to_string(), expected })
    };
    check_name("name", &meta.name)?;
    check_text("tool", &meta.tool)?;

    let grid = &meta.grid;
    let lattice_fits = LATTICES.contains(&grid.lattice) && grid.lattice.is_power_of_two();
    rule(lattice_fits, "grid.lattice", &grid.lattice, "a power of two from 16 to 256")?;
    let spacing_fits = (MIN_SPACING_M..=MAX_COORDINATE_M).contains(&grid.spacing_m);
    rule(spacing_fits, "grid.spacing_m", &grid.spacing_m, "metres from 1e-9 to 1e9")?;
    let coordinate = |value: f64| value.abs() <= MAX_COORDINATE_M; // false for NaN
    for axis in 0..3 {
        let field = format!("grid.origin_m[{axis}]");
        let (origin, low, high) = (grid.origin_m[axis], meta.bounds_m.min[axis], meta.bounds_m.max[axis]);
        rule(coordinate(origin), &field, &origin, "metres within 1e9")?;
        let field = format!("bounds_m.min[{axis}]");
        rule(coordinate(low) && low <= high, &field, &low, "metres within 1e9, at most max")?;
        rule(coordinate(high), &format!("bounds_m.max[{axis}]"), &high, "metres within 1e9")?;
    }

    meta.optics().map_or(Ok(()), check_optics)?;
    if let Some((surfaces, light)) = meta.physical() {
        light::check_surfaces(surfaces)?;
        light::check_light(light)?;
    }
    if let Some(left_out) = &meta.left_out {
        check_left_out(left_out, &meta.model)?;
    }

    let triangles = &meta.triangles;
    let sum = triangles.leaf.checked_add(triangles.wood);
    let sum_fits = sum.is_some_and(|sum| sum <= triangles.total);
    rule(sum_fits, "triangles.total", &triangles.total, "at least leaf + wood")?;

    for source in &meta.sources {
        check_name("sources.name", &source.name)?;
        check_digest("sources.blake3", &source.blake3)?;
    }
    meta.mean_light.as_ref().map_or(Ok(()), |mean| check_mean_light(mean, meta.band_count()))?;
    if let Some(averages) = meta.sky_averages.as_ref().filter(|all| all.len() != meta.band_count()) {
        let found = format!("{} numbers", averages.len());
        return Err(MetaFault { field: "sky_averages".to_owned(), found, expected: "one for each band" });
    }
    meta.mesh_blake3.as_deref().map_or(Ok(()), |digest| check_digest("mesh_blake3", digest))
}

/// A number per band, of each harmonic that counts up to a degree.
fn check_mean_light(mean: &MeanLight, bands: usize) -> Result<(), MetaFault> {
    let fault = |field: String, found: String, expected| Err(MetaFault { field, found, expected });
    if !mean.sun.is_empty() && !MeanLight::HARMONICS.contains(&mean.sun.len()) {
        let found = format!("{} harmonics", mean.sun.len());
        return fault("mean_light.sun".to_owned(), found, "0, 1, 4, 9 or 16 harmonics");
    }
    let sky = (!mean.sky.is_empty()).then_some(("mean_light.sky".to_owned(), &mean.sky));
    let sun = mean.sun.iter().enumerate().map(|(k, row)| (format!("mean_light.sun[{k}]"), row));
    for (field, row) in sky.into_iter().chain(sun) {
        if row.len() != bands {
            return fault(field, format!("{} numbers", row.len()), "one for each band");
        }
    }
    Ok(())
}

/// BLAKE3 as text.
fn check_digest(field: &str, digest: &str) -> Result<(), MetaFault> {
    let hexadecimal = |b: u8| b.is_ascii_digit() || (b'a'..=b'f').contains(&b);
    if digest.len() == 64 && digest.bytes().all(hexadecimal) {
        return Ok(());
    }
    let found = digest.chars().take(80).collect();
    Err(MetaFault { field: field.to_owned(), found, expected: "64 lower-case hexadecimal digits" })
}

fn check_optics(optics: &Optics) -> Result<(), MetaFault> {
    let names: Vec<&str> = optics.bands.iter().map(|band| band.name.as_str()).collect();
    check_band_names("optics", &names)?;
    for (i, band) in optics.bands.iter().enumerate() {
        for (class, optics) in [("leaf", band.leaf), ("wood", band.wood)] {
            let field = |name| format!("optics[{i}].{class}.{name}");
            let (sigma_a, g) = (optics.sigma_a, optics.g);
            if !(0.0..=1.0).contains(&sigma_a) {
                let expected = "a share from 0 to 1";
                return Err(MetaFault { field: field("sigma_a"), found: sigma_a.to_string(), expected });
            }
            if !(-1.0..=1.0).contains(&g) {
                return Err(MetaFault { field: field("g"), found: g.to_string(), expected: "-1 to 1" });
            }
        }
    }
    Ok(())
}

/// 1 to 64 bands, each with a name of its own.
fn check_band_names(list: &str, names: &[&str]) -> Result<(), MetaFault> {
    if names.is_empty() || names.len() > MAX_BANDS as usize {
        let (field, found) = (list.to_owned(), format!("{} bands", names.len()));
        return Err(MetaFault { field, found, expected: "1 to 64 bands" });
    }
    for (i, name) in names.iter().enumerate() {
        let field = format!("{list}[{i}].name");
        check_name(&field, name)?;
        if names[..i].contains(name) {
            let expected = "a name that no band before it has";
            return Err(MetaFault { field, found: (*name).to_owned(), expected });
        }
    }
    Ok(())
}

/// The list names something, and no band that is there. That its bases are not there is a check of the container.
fn check_left_out(left_out: &LeftOut, model: &Model) -> Result<(), MetaFault> {
    let fault = |field: &str, found: String, expected| {
        Err(MetaFault { field: format!("left_out.{field}"), found, expected })
    };
    if left_out.bases.is_empty() && left_out.bands.is_empty() {
        return fault("bases", "[]".to_owned(), "a base or a band that was left out");
    }
    if model.needs_all_items() && !left_out.bases.is_empty() {
        return fault(
            "bases",
            format!("{:?}", left_out.bases),
            "[], as only species of 18 lattice directions leave out bases",
        );
    }
    for (i, name) in left_out.bands.iter().enumerate() {
        check_name(&format!("left_out.bands[{i}]"), name)?;
        let taken = (0..model.band_count()).any(|band| model.band(band) == name)
            || left_out.bands[..i].contains(name);
        if taken {
            let expected = "a name that no band of the species and no other of the list has";
            return fault(&format!("bands[{i}]"), name.clone(), expected);
        }
    }
    check_text("left_out.reason", &left_out.reason)
}

/// A text for people, of one line.
fn check_text(field: &str, text: &str) -> Result<(), MetaFault> {
    if (1..=MAX_REASON_BYTES).contains(&text.len()) && !text.chars().any(char::is_control) {
        return Ok(());
    }
    let found = format!("{:?}", text.chars().take(80).collect::<String>());
    Err(MetaFault { field: field.to_owned(), found, expected: "1 to 1000 bytes without control characters" })
}

/// Names become file names and table cells: no folders, nothing that cannot be seen.
fn check_name(field: &str, name: &str) -> Result<(), MetaFault> {
    let plain = |c: char| !is_hidden(c) && c != '/' && c != '\\';
    let fits = (1..=MAX_NAME_BYTES).contains(&name.len()) && name != "." && name != "..";
    if fits && name.chars().all(plain) {
        return Ok(());
    }
    Err(MetaFault {
        field: field.to_owned(),
        found: format!("{name:?}"),
        expected: "1 to 255 bytes without /, \\, control and invisible characters, not . or ..",
    })
}
