//! Beams from all sides to all sites of a species, as harmonics of their direction: what the skies over all plants of a
//! stand share, however these are turned.
//!
//! ```text
//! SpeciesLight -> beams along Lebedev's 50 directions -> v_k per site and mean of the near beam, degree 3
//! sky over one plant -> L_k, and those of L times direction: 16 x 16 SkyFactors; site: sums of v_k L_k
//! ```
//!
//! With harmonics Y_k whose squares have the mean 1, a beam b(s) is the sum of v_k Y_k(s), so that what a sky L brings
//! by it is the sum of v_k times the integral of L Y_k. What is finer than degree 3 in both is lost: over a clear sky
//! that is little, since a crown lets light through here and there from everywhere. [`SkyLight::new`] loses nothing and
//! takes a sum over all sites for each plant.

use std::sync::Arc;

use flb_format::Transform;
use flb_format::beam::single::BESIDE;
use flb_format::beam::{MAX_MEANS, means};
use flb_format::ordinates::Ordinates;
use flb_format::sky_part::SkyPart;
use flb_format::sun::harmonics::{MAX_DEGREE, count, evaluate};

use super::{BANDS, OfSite, OfSites, SkyLight, Weighted, checked, for_each_beam, in_order};
use crate::RuntimeError;
use crate::light::SpeciesLight;
use crate::near_beam::MediumSites;
use crate::sun_terms::SpeciesSuns;

/// Harmonics of a beam.
pub(super) const HARMONICS: usize = count(MAX_DEGREE);

/// What a function of direction has of each harmonic.
pub(super) type Harmonics = [f32; HARMONICS];

/// The beams of a species, for the skies over many plants.
pub struct SkyBeams {
    suns: SpeciesSuns,
    medium: Arc<MediumSites>,
    /// Of the beam and of the near means, `[mean][place]`.
    means: Vec<Vec<Harmonics>>,
}

/// What a sky gives each harmonic of the beams that come to a plant: of the even sky and of each band, the light and
/// the light times its direction, and the light as often as its near beam counts.
pub(super) struct SkyFactors(pub(super) [[Harmonics; PARTS]; 1 + BANDS]);

/// What a sky gives a harmonic: light, that times x, y and z, and [`NEAR`].
pub(super) const PARTS: usize = 5;
/// Light as often as its near beam counts.
const NEAR: usize = 4;

impl SkyBeams {
    pub(in crate::light) fn new(light: &SpeciesLight) -> Result<SkyBeams, RuntimeError> {
        let medium = checked(light)?;
        let ordinates = Ordinates::Lebedev50.directions();
        let towards: Vec<[f64; 3]> = ordinates.iter().map(|ordinate| ordinate.direction).collect();
        // Before the long work: a stream asks each frame until all is there.
        towards.iter().try_for_each(|towards| light.check(Some(*towards), true))?;
        let suns = light.resident().species_suns();
        let single = suns.basis().needs_single();
        let near = medium.near(single);
        let mut own = vec![[0.0; HARMONICS]; medium.sites().len()];
        for_each_beam(&near, &towards, |number, beam| {
            let factors = evaluate(towards[number]).map(|y| (y * ordinates[number].weight) as f32);
            for (site, beam) in own.iter_mut().zip(&beam.mean) {
                site.iter_mut().zip(factors).for_each(|(sum, factor)| *sum += factor * beam);
            }
        });
        let mut all = vec![own];
        if suns.basis().has_near_beam() {
            let more = means(single) - 1;
            all.resize_with(1 + more, || vec![[0.0; HARMONICS]; medium.sites().len()]);
            let (own, around) = all.split_at_mut(1);
            let of = |k: usize| -> Vec<f32> { own[0].iter().map(|site| site[k]).collect() };
            in_order(
                HARMONICS.div_ceil(BESIDE),
                |some| {
                    let own: Vec<Vec<f32>> =
                        (some * BESIDE..HARMONICS.min((some + 1) * BESIDE)).map(of).collect();
                    near.around_each(&own.iter().map(Vec::as_slice).collect::<Vec<_>>())
                },
                |some, found| {
                    for (k, found) in (some * BESIDE..).zip(found) {
                        for (to, from) in around.iter_mut().zip(found) {
                            to.iter_mut().zip(from).for_each(|(site, value)| site[k] = value);
                        }
                    }
                },
            );
        }
        Ok(SkyBeams { suns: suns.clone(), medium: Arc::clone(medium), means: all })
    }

    /// The light of a sky on a plant that stands where `world_from_model` says, for
    /// [`InstanceLight::with_sky`](crate::InstanceLight::with_sky). It costs some ten microseconds for each 100 parts.
    ///
    /// # Errors
    /// [`RuntimeError::UnevenSky`] for parts that are not the whole sphere; [`RuntimeError::NoDirection`] for one
    /// without a direction.
    pub fn sky(&self, parts: &[SkyPart], world_from_model: &Transform) -> Result<SkyLight<'_>, RuntimeError> {
        let in_model = |part: &SkyPart| SkyPart {
            towards: world_from_model.model_from_world_direction(part.towards),
            ..*part
        };
        let parts: Vec<SkyPart> = parts.iter().map(in_model).collect();
        let weights = Weighted::of(&self.suns, &parts)?;
        let factors = OfSites::Beams(self, Box::new(SkyFactors::of(&parts, &weights)));
        Ok(SkyLight::with_sites(&self.suns, Arc::clone(&self.medium), &parts, weights, factors))
    }

    /// Memory that it takes.
    pub fn size_bytes(&self) -> usize {
        self.means.iter().map(|mean| size_of_val(&mean[..])).sum()
    }

    /// The medium that the beams go through.
    #[cfg(feature = "gpu")]
    pub(crate) fn medium(&self) -> &MediumSites {
        &self.medium
    }

    /// Of the beam and of the near means, `[mean][place]`.
    #[cfg(feature = "gpu")]
    pub(crate) fn means(&self) -> &[Vec<Harmonics>] {
        &self.means
    }

    /// Whether the near beam needs light scattered once.
    #[cfg(feature = "gpu")]
    pub(crate) fn needs_single(&self) -> bool {
        self.suns.basis().needs_single()
    }

    /// What a sky of such fluence brings to a point; `None` where no matter is near.
    pub(super) fn at(
        &self,
        medium: &MediumSites,
        point_m: [f32; 3],
        factors: &SkyFactors,
        fluence: [f32; BANDS],
    ) -> Option<OfSite> {
        let (mut sums, mut weights) = ([[0.0; HARMONICS]; MAX_MEANS], 0.0);
        medium.around(point_m, |place, weight| {
            for (sum, mean) in sums.iter_mut().zip(&self.means) {
                sum.iter_mut().zip(&mean[place]).for_each(|(sum, of_site)| *sum += weight * of_site);
            }
            weights += weight;
        });
        if weights <= 0.0 {
            return None;
        }
        sums.iter_mut().flatten().for_each(|sum| *sum /= weights);
        let moments = |of: &[Harmonics; PARTS]| [0, 1, 2, 3].map(|part| dot(&sums[0], &of[part]));
        let [even, sky @ ..] = &factors.0;
        let mut site = OfSite {
            even: moments(even),
            sky: [0, 1, 2].map(|band| moments(&sky[band])),
            ..OfSite::default()
        };
        for (j, sum) in sums.iter().enumerate().take(self.means.len()) {
            site.near[j] = dot(sum, &even[NEAR]);
            (0..BANDS).for_each(|band| {
                site.beyond[band][j] = dot(sum, &sky[band][NEAR]) - fluence[band] * site.near[j];
            });
        }
        Some(site)
    }
}

impl SkyFactors {
    /// Of parts in the frame of the model.
    fn of(parts: &[SkyPart], weighted: &Weighted) -> SkyFactors {
        let mut sums = [[[0.0f64; HARMONICS]; PARTS]; 1 + BANDS];
        for (part, (weights, near)) in parts.iter().zip(weighted.weights.iter().zip(&weighted.near)) {
            let [x, y, z] = part.towards;
            let harmonics = evaluate(part.towards);
            for (sums, (weight, near)) in sums.iter_mut().zip(weights.iter().zip(near)) {
                let weight = f64::from(*weight);
                let factors = [weight, x * weight, y * weight, z * weight, f64::from(*near)];
                for (sum, factor) in sums.iter_mut().zip(factors) {
                    sum.iter_mut().zip(&harmonics).for_each(|(sum, y)| *sum += factor * y);
                }
            }
        }
        SkyFactors(sums.map(|of| of.map(|along| along.map(|sum| sum as f32))))
    }
}

fn dot(a: &Harmonics, b: &Harmonics) -> f32 {
    a.iter().zip(b).map(|(a, b)| a * b).sum()
}
