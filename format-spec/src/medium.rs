//! The medium that light travels through: density, class and surface area density per site.

use crate::field::Grid;

/// Class of the matter of a site. One site has one class: wood where wood fills more of it than leaf does.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Hash, PartialOrd, Ord)]
#[repr(u8)]
pub enum Class {
    /// Nothing: density 0.
    Empty = 0,
    /// Leaf ("green" in the papers).
    Leaf = 1,
    /// Wood ("brown" in the papers).
    Wood = 2,
}

/// A voxelised plant, downsampled to a lattice. Every array is `[z][y][x]`, x fastest, N^3 long.
#[derive(Debug, Clone, PartialEq)]
pub struct Medium {
    /// Grid of the sites.
    pub grid: Grid,
    /// Share of the site's fine voxels that are occupied, 0..=1.
    pub density: Vec<f32>,
    /// Class; `Empty` exactly where the density is 0.
    pub class: Vec<Class>,
    /// One-sided leaf area per volume, m^2/m^3, alpha-cut parts left out.
    pub leaf_area_density: Vec<f32>,
    /// Wood surface area per volume, m^2/m^3.
    pub wood_area_density: Vec<f32>,
}

impl Medium {
    /// A medium of empty sites.
    pub fn empty(grid: Grid) -> Medium {
        let zeros = || vec![0.0; grid.sites()];
        Medium {
            grid,
            density: zeros(),
            class: vec![Class::Empty; grid.sites()],
            leaf_area_density: zeros(),
            wood_area_density: zeros(),
        }
    }

    /// Number of sites with matter.
    pub fn nonempty_sites(&self) -> usize {
        self.class.iter().filter(|class| **class != Class::Empty).count()
    }

    /// One-sided leaf area of all sites, square metres.
    pub fn leaf_area_m2(&self) -> f64 {
        self.area_m2(&self.leaf_area_density)
    }

    /// Wood surface area of all sites, square metres.
    pub fn wood_area_m2(&self) -> f64 {
        self.area_m2(&self.wood_area_density)
    }

    fn area_m2(&self, density: &[f32]) -> f64 {
        let spacing_m = self.grid.spacing_m;
        density.iter().map(|&density| f64::from(density)).sum::<f64>() * spacing_m * spacing_m * spacing_m
    }
}

/// Bits of the significand that area densities and extinctions keep, the leading one counted: to 0.1 %. The digits
/// behind are noise of how they are measured, and noise does not compress.
pub(crate) const SIGNIFICANT_BITS: u32 = 10;

/// A finite number that is not negative, rounded to 10 bits of its significand; a subnormal one stays as it is.
pub fn rounded(value: f32) -> f32 {
    if !value.is_normal() {
        return value;
    }
    let cut = f32::MANTISSA_DIGITS - SIGNIFICANT_BITS;
    // Half of the last bit that stays, so that the carry runs into the exponent where it must.
    let bits = (value.to_bits() + (1 << (cut - 1))) >> cut << cut;
    f32::from_bits(bits)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn rounding_keeps_ten_bits_and_never_makes_a_number_zero_or_infinite() {
        assert_eq!(rounded(0.0), 0.0);
        assert_eq!(rounded(1.0), 1.0);
        assert_eq!(rounded(1023.0), 1023.0);
        assert_eq!(rounded(1025.0), 1026.0);
        assert_eq!(rounded(2047.0), 2048.0);
        for value in [
            f32::from_bits(1),
            f32::MIN_POSITIVE,
            1.23e-30,
            0.333,
            5.4321e7,
            79_228_162_514_264_337_593_543_950_336.0,
        ] {
            let found = rounded(value);
            assert!(found > 0.0 && found.is_finite(), "{value}");
            assert!((found - value).abs() <= value / 1024.0, "{value} became {found}");
            assert_eq!(rounded(found), found);
        }
    }
}
