//! Moments of the light over directions, and what sites scatter of them.

use super::lanes::Lanes;

/// Moments of the light per site: 1 (isotropic scattering), 4 (with its mean direction) or 9.
pub(super) type Moments<const M: usize> = Vec<[Lanes; M]>;

/// A site in a pass. What is read and what is added to lie together: the time of a pass goes by waiting for them.
#[derive(Clone, Copy)]
#[repr(align(64))]
pub(super) struct Exchange<const M: usize> {
    /// Light that it sends out.
    pub source: [Lanes; M],
    /// Light that arrives beyond that.
    pub excess: [Lanes; M],
}

impl<const M: usize> Exchange<M> {
    /// All light that arrives.
    pub(super) fn arrives(&self) -> [Lanes; M] {
        std::array::from_fn(|a| self.source[a] + self.excess[a])
    }
}

/// What sites scatter, in one band: albedo x Legendre moment of the phase function, `[site][degree]`.
pub(super) struct ScatteringMoments(pub Vec<[f32; 3]>);

impl ScatteringMoments {
    /// The largest albedo.
    pub(super) fn albedo(&self) -> f64 {
        f64::from(self.0.iter().fold(0.0_f32, |most, gain| most.max(gain[0])))
    }

    /// The root of the mean square of the albedos over the sites. A few pale sites, as every bark has them, do not
    /// raise it.
    pub(super) fn rms_albedo(&self) -> f64 {
        let squares: f64 = self.0.iter().map(|gain| f64::from(gain[0]) * f64::from(gain[0])).sum();
        libm::sqrt(squares / self.0.len().max(1) as f64)
    }
}

/// Degree of moment `a`.
pub(super) const fn degree(a: usize) -> usize {
    match a {
        0 => 0,
        1..=3 => 1,
        _ => 2,
    }
}
