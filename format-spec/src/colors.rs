//! Which bands are the colours of a picture: by their names, whatever their order and whatever bands are beside them.

use crate::material_surface::{self, MATERIALS};
use crate::{Model, SpeciesMeta};

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

impl SpeciesMeta {
    /// The places of its bands of red, green and blue light ([`color_bands`]).
    pub fn color_bands(&self) -> Option<[usize; 3]> {
        color_bands(self.bands())
    }

    /// The same of a species that has these of its bands alone, in this order.
    ///
    /// # Panics
    /// If there is no such band.
    #[must_use]
    pub fn with_bands(&self, bands: &[usize]) -> SpeciesMeta {
        let mut meta = self.clone();
        match &mut meta.model {
            Model::Paper { optics } => {
                optics.bands = bands.iter().map(|&b| optics.bands[b].clone()).collect()
            }
            Model::Physical { surfaces, .. } => {
                surfaces.bands = bands.iter().map(|&band| surfaces.bands[band].clone()).collect();
            }
        }
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
