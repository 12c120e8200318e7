//! From spectra to bands: what a band sees of each wavelength.
//!
//! R, G and B are those of linear sRGB under daylight, not boxes of 100 nm. Textures, suns and displays of a renderer
//! are linear sRGB, so a leaf that is lit directly gets the colour that a camera would see, and light that was
//! scattered twice comes closer to the truth too: with a common leaf the product of two sRGB albedos is within 6 % in
//! green and 12 % in red of the colour of the squared spectrum; with boxes it is 25 % and 35 % off (a test holds that).

use libm::exp;

use super::matter::{FIRST_NM, LAST_NM};

/// The bands of a leaf model's surfaces.
#[derive(Debug, Clone, PartialEq)]
pub enum Bands {
    /// R, G, B: linear sRGB (Rec. 709 primaries) under daylight D65; white is 1, 1, 1.
    Rgb,
    /// The plain mean over ranges of wavelengths.
    Ranges(Vec<Range>),
}

/// A band of wavelengths within 400..=900 nm.
#[derive(Debug, Clone, PartialEq)]
pub struct Range {
    /// The band's name.
    pub name: String,
    /// First wavelength, nm.
    pub low_nm: f64,
    /// Last wavelength, nm, above the first.
    pub high_nm: f64,
}

/// From CIE XYZ to linear sRGB (IEC 61966-2-1).
pub(crate) const FROM_XYZ: [[f64; 3]; 3] =
    [[3.2406, -1.5372, -0.4986], [-0.9689, 1.8758, 0.0415], [0.0557, -0.2040, 1.0570]];

/// Wavelengths, nm, and their weights, which sum to 1; those of sRGB may be negative.
pub type Response = Vec<(f64, f64)>;

impl Bands {
    /// Range of wavelengths, nm, that a band may lie in: where the matter of leaves is known.
    pub const LIMITS_NM: (f64, f64) = (FIRST_NM, LAST_NM);

    /// Name and response of every band, in order.
    pub fn responses(&self) -> Vec<(String, Response)> {
        match self {
            Bands::Rgb => ["R", "G", "B"].map(str::to_owned).into_iter().zip(srgb()).collect(),
            Bands::Ranges(ranges) => ranges.iter().map(|range| (range.name.clone(), even(range))).collect(),
        }
    }
}

/// The mean of a spectrum, as a band sees it.
pub(super) fn mean(response: &Response, spectrum: impl Fn(f64) -> f64) -> f64 {
    response.iter().map(|&(nm, weight)| weight * spectrum(nm)).sum()
}

/// Middles of equal steps of 1 nm or less.
fn even(range: &Range) -> Response {
    let width = range.high_nm - range.low_nm;
    let steps = (width.ceil() as usize).max(1);
    let middle = |i: usize| range.low_nm + width * (i as f64 + 0.5) / steps as f64;
    (0..steps).map(|i| (middle(i), 1.0 / steps as f64)).collect()
}

/// What linear sRGB's R, G and B see of daylight that a surface reflects, every 5 nm. Starts where leaves are known, at
/// 400 nm: below lie 0.2 % of what the observer's z sees of daylight, and less of x and y. Colours outside sRGB exist:
/// a mean may be negative.
fn srgb() -> [Response; 3] {
    FROM_XYZ.map(|row| {
        let sees = |step: u32| {
            let nm = FIRST_NM + 5.0 * f64::from(step);
            let xyz = color_matching(nm);
            (nm, (row[0] * xyz[0] + row[1] * xyz[1] + row[2] * xyz[2]) * daylight(nm))
        };
        let raw: Response = (0..=76).map(sees).collect();
        let white: f64 = raw.iter().map(|&(_, weight)| weight).sum();
        raw.into_iter().map(|(nm, weight)| (nm, weight / white)).collect()
    })
}

/// x, y and z of the CIE 1931 standard observer: the fit of Wyman, Sloan and Shirley (2013), equation 4.
pub(crate) fn color_matching(nm: f64) -> [f64; 3] {
    let lobe = |height: f64, center: f64, below: f64, above: f64| {
        let x = (nm - center) / if nm < center { below } else { above };
        height * exp(-0.5 * x * x)
    };
    [
        lobe(1.056, 599.8, 37.9, 31.0) + lobe(0.362, 442.0, 16.0, 26.7) + lobe(-0.065, 501.1, 20.4, 26.2),
        lobe(0.821, 568.8, 46.9, 40.5) + lobe(0.286, 530.9, 16.3, 31.1),
        lobe(1.217, 437.0, 11.8, 36.0) + lobe(0.681, 459.0, 26.0, 13.8),
    ]
}

/// Relative power of daylight, CIE standard illuminant D65 (ISO 11664-2), 400 to 780 nm, linear between its rows.
fn daylight(nm: f64) -> f64 {
    const D65: [f64; 39] = [
        82.7549, 91.4860, 93.4318, 86.6823, 104.865, 117.008, 117.812, 114.861, 115.923, 108.811, 109.354,
        107.802, 104.790, 107.689, 104.405, 104.046, 100.000, 96.3342, 95.7880, 88.6856, 90.0062, 89.5991,
        87.6987, 83.2886, 83.6992, 80.0268, 80.2146, 82.2778, 78.2842, 69.7213, 71.6091, 74.3490, 61.6040,
        69.8856, 75.0870, 63.5927, 46.4182, 66.8054, 63.3828,
    ];
    let x = ((nm - 400.0) / 10.0).clamp(0.0, 38.0);
    let i = (x as usize).min(37);
    D65[i] + (D65[i + 1] - D65[i]) * (x - i as f64)
}

#[cfg(test)]
mod tests;
