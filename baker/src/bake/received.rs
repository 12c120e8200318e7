//! From the light of the even cloud in each site to the light that matter there receives
//! ([`crate::crown::Recollision`]).

use flb_format::Field;
use flb_format::beam::BEAM_RAYS;
use flb_format::light::SunBasis;
use flb_transport::ordinates::{Spread, TotalLight, near};
use rayon::prelude::*;

use crate::crown::{Crown, Received, Recollision};
use crate::mixture::Albedos;

/// Of a pair for leaf and wood.
const LEAF: usize = 0;

/// Turns fields of scattered light into what leaves receive (and wood in sites without leaves), in place. Values of
/// empty sites are made anew. `received` is what matter receives, `[band][place][leaf, wood]`; `open_sky` is the light
/// of the sky that has met nothing, per place.
///
/// What a site's matter scatters of a beam lights its cloud, but not the matter as much. Leaves that lean scatter more
/// or less of the beam, so more or less is taken back, too: the near beam's own coefficient counts as often.
pub(crate) fn on_matter(
    fields: &mut [(u8, Field)],
    crown: &Crown,
    received: &[Vec<[Received; 2]>],
    open_sky: &[f32],
    suns: &SunBasis,
) {
    let Crown { turbid, seen_sky, .. } = crown;
    let sites = turbid.sites();
    let kind = |site: u32| usize::from(turbid.leaf_per_m[site as usize] <= 0.0);
    let near = near(turbid, &sites, false);
    let spread = Spread::new(&sites, turbid.grid.lattice);
    fields.par_iter_mut().for_each(|(item, field)| {
        // The beam, and how much of it leaves meet.
        let beam: Option<(Vec<f32>, f32)> = beam_of(*item, suns).map(|beam| match beam {
            OwnBeam::Coefficient => (vec![1.0; sites.len()], 1.0),
            OwnBeam::Towards(sun) => {
                (near.beam(sun, BEAM_RAYS).beam.mean, turbid.angles.relative(sun[1]) as f32)
            }
        });
        let straight = (*item == 0).then_some(open_sky);
        for (band, received) in (0..field.bands).zip(received) {
            let value = |(place, &site): (usize, &u32)| {
                let Received { total, beam: of_beam, .. } = received[place][kind(site)];
                let direct = beam.as_ref().map_or(0.0, |(beam, relative)| match kind(site) {
                    LEAF => relative * beam[place],
                    _ => beam[place],
                });
                let light = total * field.value(band, site as usize) + (total - of_beam) * direct;
                match straight {
                    Some(sky) if kind(site) == LEAF => seen_sky.on_leaves(place, light, of_beam * sky[place]),
                    _ => light,
                }
            };
            let values: Vec<f32> = sites.iter().enumerate().map(value).collect();
            field.set_band(band, spread.band(&values));
        }
    });
}

/// What matter receives of the light of its site, `[band][place]`.
pub(crate) fn received_by(
    recollision: &Recollision,
    bands: &[impl Albedos],
    total: &TotalLight,
) -> Vec<Vec<[Received; 2]>> {
    let bands = bands.iter().zip(&total.values).map(|(band, light)| {
        let sky = (total.items.first() == Some(&0)).then(|| light[0].as_slice());
        recollision.all_received(band, sky)
    });
    bands.collect()
}

/// What a field of scattered light lacks of the beam at its own site.
enum OwnBeam {
    /// The field is the coefficient of the beam at the site.
    Coefficient,
    /// The field is of the sun in this direction.
    Towards([f64; 3]),
}

fn beam_of(item: u8, suns: &SunBasis) -> Option<OwnBeam> {
    match suns.first_near_item() == Some(item) {
        true => Some(OwnBeam::Coefficient),
        false => suns.sun_of(item).map(OwnBeam::Towards),
    }
}
