//! The head of a base: what turns its integers into light, and the error that its coding made.

use super::{BlockFault, MAX_HALVINGS, Rule, TEXELS};

/// Bytes before the rotation.
const FIXED_BYTES: usize = 32;
/// Largest magnitude of a peak.
const MAX_MAGNITUDE: f32 = crate::container::records::MAX_MAGNITUDE;
/// Largest unit, 2^88: 64 components of i32 texels stay finite.
const MAX_UNIT: f32 = 309_485_009_821_345_068_724_781_056.0;

/// Head of a base: bands, axes, unit, steps and rotation.
///
/// Invariant: it obeys [`Rule::HeadField`]; [`Head::from_bytes`] and [`Head::checked`] make no other.
#[derive(Debug, Clone, PartialEq)]
pub struct Head {
    /// Bands of the field, 1..=64.
    pub bands: u32,
    /// Axis (0 = x) of each digit of a coefficient's place, lowest digit first: a permutation, strongest axis first.
    pub axes: [u8; 3],
    /// Light of a texel of 1, from 2^-126 to 2^88.
    pub unit: f32,
    /// A block has as many halvings of its steps as thresholds that the magnitude of its first average is below;
    /// descending, from 0 to 32768.
    pub thresholds: [i32; MAX_HALVINGS as usize],
    /// Largest magnitude of a sample of the uncoded field at surfaces, in the field's unit.
    pub peak: f32,
    /// Root of the mean square error of samples at surfaces, relative to `peak`.
    pub rms_error: f32,
    /// 99th percentile of the relative error over the darkest tenth of samples.
    pub dark_error: f32,
    /// `[component][band]`, orthonormal rows of all bands of the file; components that are not here are dropped.
    pub rotation: Vec<f32>,
}

impl Head {
    /// Number of components, 1..=bands of the file.
    pub fn components(&self) -> usize {
        self.rotation.len() / self.bands as usize
    }

    /// Returns the head for these bands alone, in this order. The components stay, which may be more than the bands.
    ///
    /// # Panics
    /// If there is no such band.
    #[must_use]
    pub fn with_bands(self, bands: &[usize]) -> Head {
        let rows = self.rotation.chunks_exact(self.bands as usize);
        let rotation = rows.flat_map(|row| bands.iter().map(|&band| row[band])).collect();
        Head { bands: bands.len() as u32, rotation, ..self }
    }

    /// Place of a coefficient in a class or mask to its index in the block.
    pub fn order(&self) -> [u8; TEXELS] {
        std::array::from_fn(|place| {
            (0..3).map(|digit| (place >> (2 * digit) & 3) as u8 * (1 << (2 * self.axes[digit]))).sum()
        })
    }

    /// Halvings of the steps of a block whose first component has this average.
    #[inline(always)]
    pub fn halvings(&self, average: i16) -> u32 {
        let magnitude = i32::from(average).abs();
        self.thresholds.iter().map(|threshold| u32::from(magnitude < *threshold)).sum()
    }

    /// `[component][band]`: light of a texel of 1.
    pub fn colors(&self) -> Vec<f32> {
        self.rotation.iter().map(|r| r * self.unit).collect()
    }

    /// The payload.
    pub fn to_bytes(&self) -> Vec<u8> {
        let mut bytes = vec![self.components() as u8];
        bytes.extend(self.axes);
        bytes.extend(self.unit.to_le_bytes());
        bytes.extend(self.thresholds.iter().flat_map(|t| t.to_le_bytes()));
        for value in [self.peak, self.rms_error, self.dark_error].iter().chain(&self.rotation) {
            bytes.extend(value.to_le_bytes());
        }
        bytes
    }

    /// Bytes of a payload that starts with this byte.
    pub fn len_bytes(first: u8, bands: u32) -> usize {
        FIXED_BYTES + 4 * usize::from(first) * bands as usize
    }

    /// Reads a payload for a field of `bands`, 1..=64.
    ///
    /// # Errors
    /// [`Rule::HeadLength`], [`Rule::HeadField`].
    pub fn from_bytes(bytes: &[u8], bands: u32) -> Result<Head, BlockFault> {
        let components = usize::from(bytes.first().copied().unwrap_or(0));
        if bytes.is_empty() || components == 0 || components > bands as usize {
            let rule = if bytes.is_empty() { Rule::HeadLength } else { Rule::HeadField };
            return Err(BlockFault::new(
                rule,
                "the number of components",
                components,
                format!("1 to {bands}"),
            ));
        }
        let expected = Head::len_bytes(bytes[0], bands);
        if bytes.len() != expected {
            return Err(BlockFault::length(Rule::HeadLength, "the head of a base", bytes.len(), expected));
        }
        let word = |i: usize| -> [u8; 4] { std::array::from_fn(|k| bytes[4 * i + k]) };
        let float = |i: usize| f32::from_le_bytes(word(i));
        Head {
            bands,
            axes: [bytes[1], bytes[2], bytes[3]],
            unit: float(1),
            thresholds: std::array::from_fn(|k| i32::from_le_bytes(word(2 + k))),
            peak: float(5),
            rms_error: float(6),
            dark_error: float(7),
            rotation: (8..expected / 4).map(float).collect(),
        }
        .checked()
    }

    /// Itself, if it obeys the rules.
    ///
    /// # Errors
    /// [`Rule::HeadField`].
    pub fn checked(self) -> Result<Head, BlockFault> {
        let fault = |what: &str, found: String, expected: &str| {
            Err(BlockFault::new(Rule::HeadField, what, found, expected))
        };
        let mut axes = self.axes;
        axes.sort_unstable();
        if axes != [0, 1, 2] {
            return fault("the order of axes", format!("{:?}", self.axes), "a permutation of 0, 1, 2");
        }
        if !(self.unit.is_normal() && self.unit > 0.0 && self.unit <= MAX_UNIT) {
            return fault("the unit", self.unit.to_string(), "2^-126 to 2^88");
        }
        let [first, second, third] = self.thresholds;
        if !(0 <= third && third <= second && second <= first && first <= 32768) {
            return fault("the thresholds", format!("{:?}", self.thresholds), "descending, from 32768 to 0");
        }
        for (what, value) in
            [("the peak", self.peak), ("the mean error", self.rms_error), ("the dark error", self.dark_error)]
        {
            // Bits, as -0 has one spelling too many.
            if !(value.is_sign_positive() && value <= MAX_MAGNITUDE) {
                return fault(what, format!("{value:?}"), "from +0 to 2^96");
            }
        }
        for (i, value) in self.rotation.iter().enumerate() {
            let fits = value.abs() <= 1.0 && value.to_bits() != (-0.0f32).to_bits();
            if !fits {
                let what = format!("number {i} of the rotation");
                return fault(&what, format!("{value:?}"), "from -1 to 1, and 0 written as +0");
            }
        }
        Ok(self)
    }
}
