//! An uneven sky on a GPU: the beams of a species among its words, and the sky over a plant as terms. sky.wgsl says how
//! they are laid out.
//!
//! ```text
//! SkyBeams -GpuLight::set_sky_beams-> words
//! SkyBeams::sky -SkyLight-> SkyOnGpu -GpuSpecies::sky_terms, Follower::sky_terms-> Term -> GpuLight::set_terms
//! ```

use flb_format::light::SunBasis;
use half::f16;

use super::{GpuError, GpuLight, GpuSpeciesId, Term};
use crate::extinction::Extinction;
use crate::light::{OTHER_ROWS, SkyBeams, SkyLight, SkyRows};

/// The sky over a plant, as a shader takes it.
#[derive(Debug, Clone, PartialEq)]
pub struct SkyOnGpu(SkyRows);

impl SkyOnGpu {
    /// Takes a sky of beams; `None` for one that was found for its plant alone
    /// ([`SpeciesLight::sky`](crate::SpeciesLight::sky)).
    pub fn of(sky: &SkyLight<'_>) -> Option<SkyOnGpu> {
        sky.rows().map(SkyOnGpu)
    }

    /// Largest number of terms of the sky over a plant of such suns.
    pub fn most_terms(suns: &SunBasis) -> u32 {
        // Of counts and the even sky; of each base, itself and its row.
        2 + 3 * suns.items() as u32 + 2 * OTHER_ROWS as u32
    }

    /// Fluence of the sky, R, G, B.
    pub fn fluence(&self) -> [f32; 3] {
        let [[red, green, blue, _], ..] = self.0.rows[..] else { return [0.0; 3] };
        [red, green, blue]
    }

    /// The terms, with the index of each base on the GPU; the base that is not there as an error.
    pub(super) fn terms(&self, index: impl Fn(u8) -> Option<u32>) -> Result<Vec<Term>, u8> {
        let SkyRows { of_sun, of_near, bases, rows } = &self.0;
        let counts = Term { base: *of_sun as u32 | (*of_near as u32) << 16, factor: 1.0 };
        let mut terms = vec![counts];
        for base in bases {
            terms.push(Term { base: index(*base).ok_or(*base)?, factor: 1.0 });
        }
        let pairs = rows.as_flattened().as_chunks::<2>().0;
        terms.extend(pairs.iter().map(|[base, factor]| Term { base: base.to_bits(), factor: *factor }));
        Ok(terms)
    }
}

impl GpuLight {
    /// Sends the beams of a species that skies need, for `flb_sky`, and its extinction where that is not there: 32
    /// bytes for each site with matter and each mean of its near beam, 1 to 4 of them. They go with the extinction.
    ///
    /// # Errors
    /// [`GpuError::NoSpecies`]; [`GpuError::OtherExtinction`] for beams of another lattice; [`GpuError::Full`], when
    /// the beams that were there are gone.
    pub fn set_sky_beams(&mut self, species: GpuSpeciesId, beams: &SkyBeams) -> Result<(), GpuError> {
        let turbid = beams.medium().turbid();
        if self.known(species)?.grid != turbid.grid {
            return Err(GpuError::OtherExtinction { species });
        }
        let extinction = Extinction::of(turbid);
        if self.known(species)?.extinction.is_none() {
            self.set_extinction(species, &extinction, beams.needs_single())?;
        }
        if let Some((before, _)) = self.known_mut(species)?.sky.take() {
            self.words.give_back(before);
        }
        let span = self.place(&words(beams, &extinction));
        self.known_mut(species)?.sky = match span {
            Ok(span) => Some((span, beams.means().len() as u32)),
            Err(error) => {
                self.write_species(species)?;
                return Err(error);
            }
        };
        self.write_species(species)
    }

    /// Whether the beams of a species that skies need are on the GPU.
    pub fn has_sky_beams(&self, species: GpuSpeciesId) -> bool {
        self.known(species).is_ok_and(|known| known.sky.is_some())
    }
}

/// The words of beams, in the order of an extinction of the same medium.
fn words(beams: &SkyBeams, extinction: &Extinction) -> Vec<u32> {
    let half = |value: f32| u32::from(f16::from_f32_const(value).to_bits());
    let mut words = vec![4 * extinction.blocks().len() as u32];
    for number in extinction.sites().map(|site| beams.medium().place_of(site)) {
        for mean in beams.means() {
            let harmonics = number.map_or([0.0; 16], |number| mean[number]);
            let pairs = harmonics.as_chunks::<2>().0;
            words.extend(pairs.iter().map(|[low, high]| half(*low) | half(*high) << 16));
        }
    }
    words
}
