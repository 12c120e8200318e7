//! Which bands are the colours of a picture: by their names, whatever their order and whatever bands are beside them.

use crate::SpeciesMeta;
use crate::material_surface::{self, MATERIALS};

/// Names of the bands of red, green and blue light (SPEC.md, section 9.3).
pub const COLORS: [&str; 3] = ["R", "G", "B"];

/// The places of red, green and blue among bands; `None` unless each is there.
///
/// ```
/// use flb_format::colors::color_bands;
///
/// assert_eq!(color_bands(["B", "G", "NIR", "R"]), Some([3, 1, 0]));
/// assert_eq!(color_bands(["NIR", "SWIR", "G"]), None);
/// ```
pub fn color_bands<'n>(names: impl IntoIterator<Item = &'n str>) -> Option<[usize; 3]> {
    let names: Vec<&str> = names.into_iter().collect();
    let [red, green, blue] = COLORS.map(|color| names.iter().position(|name| *name == color));
    Some([red?, green?, blue?])
}

/// Reason why a species cannot be shown in a picture.
#[derive(Debug, Clone, PartialEq, Eq, thiserror::Error)]
#[non_exhaustive]
pub enum BandsError {
    /// The surfaces of its materials cannot be read.
    #[error("species {species:?}: {message}")]
    Surfaces {
        /// Name of the species.
        species: String,
        /// Fault of the surfaces.
        message: String,
    },
    /// A band that was named is not there.
    #[error("species {species:?} has no band {wanted:?}; it has {}", .found.join(", "))]
    NoSuchBand {
        /// Name of the species.
        species: String,
        /// The band that was named.
        wanted: String,
        /// Bands of the species.
        found: Vec<String>,
    },
    /// A number of bands other than 1 or 3 was named.
    #[error("found {found} names of bands, expected 1 or 3")]
    Count {
        /// Number of names.
        found: usize,
    },
    /// No band was named, and R, G or B is missing.
    #[error("species {species:?} has the bands {}; a picture needs R, G and B{left_out}", .found.join(", "))]
    NoColors {
        /// Name of the species.
        species: String,
        /// Bands of the species.
        found: Vec<String>,
        /// Bands that a plan left out, in words; empty if none were.
        left_out: String,
    },
}

impl SpeciesMeta {
    /// The places of its bands of red, green and blue light ([`color_bands`]).
    pub fn color_bands(&self) -> Option<[usize; 3]> {
        color_bands(self.bands())
    }

    /// Finds the bands that a picture shows as red, green and blue: R, G and B by their names, or the bands that
    /// `wanted` names: three in this order, or one, which is grey. Looks at the surfaces of materials, too, which a
    /// picture needs.
    ///
    /// # Errors
    /// [`BandsError`].
    pub fn picture_bands(&self, wanted: &[String]) -> Result<[usize; 3], BandsError> {
        let species = || self.name.clone();
        let message = self.material_surfaces().err();
        if let Some(message) = message {
            return Err(BandsError::Surfaces { species: species(), message });
        }
        let names: Vec<&str> = self.bands().collect();
        let found = || names.iter().map(|name| (*name).to_owned()).collect();
        let place = |name: &String| {
            let place = names.iter().position(|one| one == name);
            place.ok_or_else(|| BandsError::NoSuchBand {
                species: species(),
                wanted: name.clone(),
                found: found(),
            })
        };
        let places = wanted.iter().map(place).collect::<Result<Vec<_>, _>>()?;
        match places[..] {
            [] => self.color_bands().ok_or_else(|| {
                let left_out = self.left_out.as_ref().filter(|left_out| !left_out.bands.is_empty());
                let left_out = left_out.map(|left_out| {
                    format!("; left out: {} ({})", left_out.bands.join(", "), left_out.reason)
                });
                BandsError::NoColors {
                    species: species(),
                    found: found(),
                    left_out: left_out.unwrap_or_default(),
                }
            }),
            [grey] => Ok([grey; 3]),
            [red, green, blue] => Ok([red, green, blue]),
            _ => Err(BandsError::Count { found: places.len() }),
        }
    }

    /// Returns the metadata of the species with these bands alone, in this order.
    ///
    /// # Panics
    /// If there is no such band.
    #[must_use]
    pub fn with_bands(&self, bands: &[usize]) -> SpeciesMeta {
        let mut meta = self.clone();
        meta.model.keep_bands(bands);
        // What cannot be read stays, for those who say so.
        if let Ok(Some(surfaces)) = self.material_surfaces() {
            let of_bands: Vec<_> = surfaces
                .iter()
                .map(|surface| surface.as_ref().map(|surface| surface.of_bands(bands)))
                .collect();
            if let Some(setting) = material_surface::setting(&of_bands) {
                meta.settings.insert(MATERIALS.to_owned(), setting);
            }
        }
        meta
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn colors_are_found_by_name_in_any_order() {
        for (names, expected) in [
            (&["R", "G", "B"][..], Some([0, 1, 2])),
            (&["G", "R", "B"], Some([1, 0, 2])),
            (&["NIR", "B", "G", "R"], Some([3, 2, 1])),
            (&["r", "g", "b"], None),
            (&["R", "G"], None),
            (&["R", "G", "NIR"], None),
            (&["B1", "G1", "R1"], None),
            (&[], None),
        ] {
            assert_eq!(color_bands(names.iter().copied()), expected, "{names:?}");
        }
    }
}
