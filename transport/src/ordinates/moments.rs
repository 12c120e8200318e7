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

/// What sites scatter, in one band.
pub(super) struct ScatteringMoments {
    /// Albedo x Legendre moment of the phase function, `[site][degree]`.
    pub gains: Vec<[f32; 3]>,
    /// Albedo of the leaves x their share of the site x second moment of how they lean ([`up_moment`]), `[site]`: how
    /// much more of the light they meet where it comes across them. Counted where 9 moments are known.
    pub leaning: Vec<f32>,
}

/// Second moment about the vertical of a function of the direction, from its moments of degree 2: those are about z,
/// and y is up.
pub(super) fn up_moment(of_degree_2: [Lanes; 5]) -> Lanes {
    let [_, _, along_z, _, across_z] = of_degree_2;
    -0.5 * along_z - 0.866_025_4 * across_z
}

impl ScatteringMoments {
    /// The largest albedo.
    pub(super) fn albedo(&self) -> f64 {
        f64::from(self.gains.iter().fold(0.0_f32, |most, gain| most.max(gain[0])))
    }

    /// The root of the mean square of the albedos over the sites. A few pale sites, as every bark has them, do not
    /// raise it.
    pub(super) fn rms_albedo(&self) -> f64 {
        let squares: f64 = self.gains.iter().map(|gain| f64::from(gain[0]) * f64::from(gain[0])).sum();
        libm::sqrt(squares / self.gains.len().max(1) as f64)
    }
}

/// Light whose fluence is nowhere below 0. Sources that change along straight lines within dense sites may send out
/// less than nothing at their far ends.
pub(super) fn none_below_0<const M: usize>(mut light: Moments<M>) -> Moments<M> {
    light
        .iter_mut()
        .for_each(|moments| moments[0].0.iter_mut().for_each(|fluence| *fluence = fluence.max(0.0)));
    light
}

/// Degree of moment `a`.
pub(super) const fn degree(a: usize) -> usize {
    match a {
        0 => 0,
        1..=3 => 1,
        _ => 2,
    }
}
