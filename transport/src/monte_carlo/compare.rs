//! How far a field is from the truth, the noise of the truth taken out.
//!
//! With x the field and A, B two estimates of other seeds, the noise of A and B is independent and has no mean, so the
//! mean of (x - A)(x - B) is that of the squared error alone. One estimate would add its own variance to it.

use super::{Fluence, MonteCarloError};

/// Part of the light that is compared.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum ComparedLight {
    /// Scattered light only.
    Scattered,
    /// Uncollided and scattered light.
    Total,
}

/// The error of a field, relative to the mean of the reference over the non-empty sites.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Difference {
    /// Root mean square. 0 where the noise hides it.
    pub rms: f64,
    /// Standard error of `rms`, as if sites were independent. They share photons, so it is rather too small.
    pub rms_error: f64,
    /// Mean difference; above 0 where the field is too bright.
    pub bias: f64,
    /// Standard error of `bias`.
    pub bias_error: f64,
    /// Mean of the reference: the unit of all the others.
    pub mean: f64,
}

/// Compares a field with two estimates of different seeds, over the non-empty sites in the order of
/// [`TurbidMedium::sites`](crate::turbid::TurbidMedium::sites).
pub fn compare(
    field: &[f64],
    estimates: [&Fluence; 2],
    part: ComparedLight,
) -> Result<Difference, MonteCarloError> {
    let value = |fluence: &Fluence, site: usize| match part {
        ComparedLight::Scattered => fluence.scattered[site],
        ComparedLight::Total => fluence.uncollided[site] + fluence.scattered[site],
    };
    let sites = estimates[0].scattered.len();
    for (name, values) in [
        ("first estimate", estimates[0].scattered.as_slice()),
        ("first estimate's uncollided light", &estimates[0].uncollided),
        ("second estimate", &estimates[1].scattered),
        ("second estimate's uncollided light", &estimates[1].uncollided),
        ("field", field),
    ] {
        if values.len() != sites {
            return Err(MonteCarloError::Fields { field: name, found: values.len(), expected: sites });
        }
        if let Some(site) = values.iter().position(|value| !value.is_finite()) {
            return Err(MonteCarloError::Value { field: name, site, found: values[site] });
        }
    }
    let n = sites as f64;
    let (mut mean, mut bias, mut square, mut fourth) = (0.0, 0.0, 0.0, 0.0);
    for (site, &x) in field.iter().enumerate() {
        let (a, b) = (value(estimates[0], site), value(estimates[1], site));
        let product = (x - a) * (x - b);
        mean += (a + b) / 2.0 / n;
        bias += (x - (a + b) / 2.0) / n;
        square += product / n;
        fourth += product * product / n;
    }
    if mean.is_nan() || mean <= 0.0 {
        return Err(MonteCarloError::Dark { found: mean });
    }
    let rms = square.max(0.0).sqrt();
    let square_error = ((fourth - square * square).max(0.0) / n).sqrt();
    let floor = square_error.sqrt();
    let errors = estimates.map(|fluence| fluence.mean_error);
    Ok(Difference {
        rms: rms / mean,
        rms_error: if floor > 0.0 { square_error / (2.0 * rms.max(floor)) / mean } else { 0.0 },
        bias: bias / mean,
        bias_error: (errors[0] * errors[0] + errors[1] * errors[1]).sqrt() / 2.0 / mean,
        mean,
    })
}
