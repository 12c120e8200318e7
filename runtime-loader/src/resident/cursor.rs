//! The light of one instance at points that lie near one another.

use flb_format::beam::MOST_MEANS;
use flb_format::blocks::{CodedBase, Cursor};

use super::{ResidentSpecies, Terms};

/// Samples one blend of a species like [`ResidentSpecies::light`], with a memory of the blocks last read ([`Cursor`]): of three bands 64 KiB for
/// a blend of bases, 256 KiB at most where the near beam has bases of its own. Where several points lie in each block, as the pixels of a
/// near plant do, a sample costs about as much as one of uncoded fields, and less the more bases there are; where points lie far apart it costs several times
/// that of [`ResidentSpecies::light`] (`cargo bench -p flb-runtime --bench blend`).
pub struct LightCursor<'a> {
    /// The blend's sum first, if it has bases, then one for each base of the near beam.
    cursor: Option<Cursor<'a>>,
    grid: flb_format::Grid,
    bands: usize,
    /// Added to every band.
    constant: f32,
    /// Sums before those of the near beam.
    first_near: usize,
    /// `[sum][band]`
    found: Vec<f32>,
}

impl ResidentSpecies {
    /// Samples terms of this state of the species at points that lie near one another.
    ///
    /// # Panics
    /// If a base of the terms was dropped meanwhile.
    pub fn cursor(&self, terms: &Terms) -> LightCursor<'_> {
        let base = |base: u16| -> &CodedBase {
            self.bases[usize::from(base)].as_ref().expect("terms are of the bases that are there")
        };
        let blend: Vec<_> = terms.bases().iter().map(|(at, factor)| (base(*at), *factor)).collect();
        let (near, sun) = terms.near_bases();
        let first_near = usize::from(!blend.is_empty());
        let blend = (!blend.is_empty()).then_some(blend);
        let sums: Vec<_> = blend.into_iter().chain(near.map(|at| vec![(base(at), sun)])).collect();
        LightCursor {
            grid: self.grid,
            bands: self.bands,
            constant: terms.constant,
            first_near,
            found: vec![0.0; sums.len() * self.bands],
            cursor: (!sums.is_empty()).then(|| Cursor::of_sums(sums)),
        }
    }
}

impl LightCursor<'_> {
    /// Light per band at a point of model space; never below 0. `near` is that of [`ResidentSpecies::near`] where [`Terms::needs_near`] says
    /// so, else it does not count.
    ///
    /// # Panics
    /// If `out` is not as long as the bands.
    pub fn light(&mut self, near: [f32; MOST_MEANS], point_model_m: [f32; 3], out: &mut [f32]) {
        assert_eq!(out.len(), self.bands, "a value per band");
        out.fill(self.constant);
        if let Some(cursor) = &mut self.cursor {
            cursor.sample(self.grid.lattice_from_model(point_model_m.map(f64::from)), &mut self.found);
            let factors = std::iter::repeat_n(1.0, self.first_near).chain(near);
            for (sum, factor) in self.found.chunks_exact(self.bands).zip(factors) {
                out.iter_mut().zip(sum).for_each(|(out, light)| *out += factor * light);
            }
        }
        out.iter_mut().for_each(|value| *value = value.max(0.0));
    }
}
