//! Plants of the model `paper` on a scene's lattice: from densities of sites of one size to those of another.
//!
//! A site of density d lets 1 - d of the light along a step pass, so a run of k sites lets (1 - d)^k pass, which is
//! what an extinction of -ln(1 - d) over an edge does. Extinctions of species add up, and can be read at sites of any
//! size. The papers say of the density of a coarse site only that it is estimated from the plants that meet the site.

use flb_format::matter::{BandOptics, ClassOptics, LeafAngles, Optics, TurbidMedium};
use flb_format::{Medium, matter::Class};

use super::{LUMINANCE, SceneLightError, colors_of, entry};

/// Densities above this count as this: a full site would have no finite extinction.
const MAX_DENSITY: f64 = 0.999;

/// The extinction, in m^-1, that lets as much light pass along an edge as the densities of a medium do.
pub fn extinction(medium: &Medium) -> TurbidMedium {
    let per_m = |class: Class| {
        let of = |(density, own): (&f32, &Class)| match *own == class {
            true => (-libm::log1p(-f64::from(*density).min(MAX_DENSITY)) / medium.grid.spacing_m) as f32,
            false => 0.0,
        };
        medium.density.iter().zip(&medium.class).map(of).collect()
    };
    let (leaf_per_m, wood_per_m) = (per_m(Class::Leaf), per_m(Class::Wood));
    TurbidMedium { grid: medium.grid, leaf_per_m, wood_per_m, angles: LeafAngles::spherical() }
}

/// The medium whose densities stop as much light along an edge as an extinction does. A site is wood where wood stops
/// more than leaves do.
pub fn coarse_medium(turbid: &TurbidMedium) -> Medium {
    entry::medium(turbid, &[])
}

/// Optics in the one band of a scene's light.
///
/// # Errors
/// [`SceneLightError::Bands`] unless red, green and blue are among the bands.
pub fn optics_in_luminance(species: &str, optics: &Optics) -> Result<BandOptics, SceneLightError> {
    let colors = colors_of(species, optics.bands.iter().map(|band| band.name.as_str()))?;
    let bands = colors.iter().zip(LUMINANCE).map(|(&band, weight)| (&optics.bands[band], [weight; 2]));
    Ok(mean(bands))
}

/// Mean optics of a scene's matter by its area, `[species][leaf, wood]`.
pub fn mean_optics(optics: &[BandOptics], areas_m2: &[[f64; 2]]) -> BandOptics {
    mean(optics.iter().zip(areas_m2.iter().copied()))
}

/// Weighted mean of optics; a class of no weight gets the plain mean.
fn mean<'o>(optics: impl Iterator<Item = (&'o BandOptics, [f64; 2])> + Clone) -> BandOptics {
    let class = |kind: usize, of: fn(&BandOptics) -> ClassOptics| {
        let total: f64 = optics.clone().map(|(_, weight)| weight[kind]).sum();
        let count = optics.clone().count() as f64;
        let share = |weight: [f64; 2]| if total > 0.0 { weight[kind] / total } else { 1.0 / count };
        let mean = |value: fn(ClassOptics) -> f64| -> f64 {
            optics.clone().map(|(band, weight)| share(weight) * value(of(band))).sum()
        };
        ClassOptics { sigma_a: mean(|class| class.sigma_a), g: mean(|class| class.g) }
    };
    let (leaf, wood) = (class(0, |band| band.leaf), class(1, |band| band.wood));
    BandOptics { name: flb_format::scene_light::LUMINANCE.to_owned(), leaf, wood }
}
