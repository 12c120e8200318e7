//! Limits on what a `physical` species says of its surfaces and its light (SPEC.md section 9.1).

use super::{MetaFault, check_band_names};
use crate::light::{Light, SunBasis};
use crate::sun::harmonics::MAX_DEGREE;
use crate::surfaces::Surfaces;

/// Numbers of directions along which light may have been marched.
const ORDINATES: [u32; 3] = [18, 50, 110];
/// Most rays per site edge.
const MAX_RAYS: u32 = 8;
/// Largest integer that JSON holds (M32).
const MAX_COUNT: u64 = crate::canonical::MAX_INTEGER;

pub(super) fn check_surfaces(surfaces: &Surfaces) -> Result<(), MetaFault> {
    let names: Vec<&str> = surfaces.bands.iter().map(|band| band.name.as_str()).collect();
    check_band_names("surfaces", &names)?;
    for (i, band) in surfaces.bands.iter().enumerate() {
        let shares = [
            ("leaf.reflectance", band.leaf.reflectance),
            ("leaf.transmittance", band.leaf.transmittance),
            ("wood.reflectance", band.wood.reflectance),
        ];
        for (name, share) in shares {
            let field = || format!("surfaces[{i}].{name}");
            rule((0.0..=1.0).contains(&share), field, &share, "a share from 0 to 1")?;
        }
        let sum = band.leaf.reflectance + band.leaf.transmittance;
        let field = || format!("surfaces[{i}].leaf.reflectance + transmittance");
        rule(sum <= 1.0, field, &sum, "at most 1")?;
    }
    Ok(())
}

pub(super) fn check_light(light: &Light) -> Result<(), MetaFault> {
    let named = |name: &'static str| move || format!("light.{name}");
    rule(ORDINATES.contains(&light.ordinates), named("ordinates"), &light.ordinates, "18, 50 or 110")?;
    rule((1..=MAX_RAYS).contains(&light.rays), named("rays"), &light.rays, "1 to 8")?;
    if let SunBasis::Harmonics { degree, .. } = light.suns {
        rule((1..=MAX_DEGREE).contains(&degree), named("suns.degree"), &degree, "1 to 3")?;
    }
    let leaning = light.suns.is_leaning();
    let fits = light.suns == light.suns.clone().of_leaves(&light.leaf_angles).of_field(light.field);
    let expected = "none, where leaf_angles are \"spherical\" or field is \"total\"";
    rule(fits, named("suns.leaning"), &leaning, expected)?;
    let error = &light.error;
    let mut shares = vec![("error.suns_rms", error.suns_rms), ("error.solver", error.solver)];
    if let Some(measured) = &error.monte_carlo {
        shares.push(("error.monte_carlo.rms", measured.rms));
        rule(measured.bias.is_finite(), named("error.monte_carlo.bias"), &measured.bias, "a number")?;
        let photons = measured.photons;
        rule(photons <= MAX_COUNT, named("error.monte_carlo.photons"), &photons, "at most 2^53")?;
    }
    for (name, share) in shares {
        rule(share >= 0.0 && share.is_finite(), named(name), &share, "a number of at least 0")?;
    }
    Ok(())
}

fn rule(
    holds: bool,
    field: impl FnOnce() -> String,
    found: &dyn std::fmt::Display,
    expected: &'static str,
) -> Result<(), MetaFault> {
    if holds { Ok(()) } else { Err(MetaFault { field: field(), found: found.to_string(), expected }) }
}
