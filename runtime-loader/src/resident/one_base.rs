//! The light of one base by itself.

use super::ResidentSpecies;

impl ResidentSpecies {
    /// Light of one base, by its place among those of the file, per band at a point of the model, metres; what is
    /// loaded of it. Whether anything is: without, `out` is 0. A base is no light by itself where suns are harmonics:
    /// values may be below 0.
    pub fn base_at(&self, base: usize, point_model_m: [f32; 3], out: &mut [f32]) -> bool {
        out.fill(0.0);
        match self.bases.get(base) {
            Some(Some(base)) => {
                self.point(point_model_m).add(base, 1.0, out);
                true
            }
            _ => false,
        }
    }
}
