//! All stored fields of a species, expanded.

use std::sync::Arc;

use flb_format::Grid;
use flb_format::beam::MAX_MEANS;
use flb_format::blocks::{Cursor, EDGE};

use super::channels::Channels;
use crate::SpeciesLight;
use crate::resident::Terms;

/// Channels that a sample adds up without memory of its own.
const FEW: usize = 64;

/// All stored fields of a species at the sites near geometry, in 8 bits each
/// ([`SpeciesLight::field_volume`]).
///
/// Coded fields are small, and a point far from the last one pays for reading them. Here they lie side by side, so that
/// such a point costs a tenth, for five to ten times the memory. Plants of the species share it under any sun.
#[derive(Debug, Clone)]
pub struct FieldVolume {
    grid: Grid,
    bands: usize,
    /// `[base][band]`
    channels: Channels,
}

impl FieldVolume {
    /// Memory that it takes, bytes, without the block map, which it shares with the species.
    pub fn size_bytes(&self) -> usize {
        self.channels.size_bytes()
    }

    /// Adds the light of terms at a point, where these shares of sun and sky are left.
    pub(in crate::light) fn add(
        &self,
        terms: &Terms,
        near: [f32; MAX_MEANS],
        shares: [f32; 2],
        point_m: [f32; 3],
        out: &mut [f32],
    ) {
        let (mut few, mut many) = ([0.0; FEW], Vec::new());
        let count = self.channels.count();
        let found = match few.get_mut(..count) {
            Some(few) => few,
            None => {
                many.resize(count, 0.0);
                &mut many[..]
            }
        };
        self.channels.add(self.grid.lattice_from_model(point_m.map(f64::from)), found);
        for (place, factor) in terms.at_point(terms.factors(shares), near) {
            let light = &found[usize::from(place) * self.bands..];
            out.iter_mut().zip(light).for_each(|(out, light)| *out += factor * light);
        }
    }
}

impl SpeciesLight<'_> {
    /// Expands what is loaded of the species' fields, for
    /// [`InstanceLight::with_fields`](crate::InstanceLight::with_fields): it takes some tenths of a second, may be done
    /// on any thread, and is for any sun. `None` where the file's codec does not store blocks near geometry (`classed`
    /// and `haar` do), or nothing of it is loaded.
    pub fn field_volume(&self) -> Option<FieldVolume> {
        let species = self.resident();
        let shared = Arc::clone(species.shared()?);
        let (grid, bands, bases) = (*species.grid(), species.bands(), species.items().len());
        // Of a base that is not there the sum is 0, and nothing asks for it.
        let sums: Vec<Vec<_>> =
            (0..bases).map(|base| species.base(base).map(|base| (base, 1.0)).into_iter().collect()).collect();
        if sums.iter().all(Vec::is_empty) {
            return None;
        }
        let mut cursor = Cursor::of_sums(sums);
        let channels = Channels::fill(shared, bases * bands, |first, out| {
            cursor.block(first.map(|texel| (texel / EDGE) as u32), out);
        });
        let channels = channels.with_coarse(|point, out| cursor.sample(point, out));
        Some(FieldVolume { grid, bands, channels })
    }
}
