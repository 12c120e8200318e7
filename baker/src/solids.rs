//! Light that falls on solids: walls, trunks, twigs.
//!
//! A site that a wall crosses has no light to give: its mean is over what is in front of the wall and over the dark
//! behind it. So the light at a solid is *gathered*. From points on its surface rays go into the open hemisphere,
//! through the mesh itself, until they meet the sky or matter; matter sends out the light that the solve found in its
//! site. What is gathered becomes values of the sites in front of the surface (`fit.rs`), where readers sample it
//! ([`flb_format::sample::SOLID_OFFSET`]).
//!
//! A value is four times an irradiance: a reader takes a quarter of it on every surface, leaf or solid.

mod fit;
mod gather;
mod near;
mod points;
mod radiosity;
mod ringing;

use flb_format::light::SunBasis;
use flb_format::matter::TurbidMedium;
use flb_format::progress::{Cancelled, Progress};
use flb_format::{Field, Medium};
use flb_scene::ClassedMesh;
use flb_scene::extents::Walls;
use flb_scene::rays::{RayMesh, RayMeshError};
use flb_transport::ordinates::{Spread, TotalLight};
use rayon::prelude::*;

use crate::crown::{Received, SeenSky};

pub use points::SolidPoint;

/// Plant and solved light from which the light at solids is made.
pub struct Solids<'a> {
    /// The plant.
    pub classed: &'a ClassedMesh,
    /// Whether every texel is present; as the medium was voxelised.
    pub ignore_alpha: bool,
    /// Extinction of the plant.
    pub turbid: &'a TurbidMedium,
    /// Area densities of the plant.
    pub medium: &'a Medium,
    /// Light that matter in a site receives of the site's light, `[band][place][leaf, wood]`.
    pub received: &'a [Vec<[Received; 2]>],
    /// All light of the solve.
    pub total: &'a TotalLight,
    /// Dependence of the light's items on the sun.
    pub suns: &'a SunBasis,
    /// Share of the sky that the leaves see.
    pub seen_sky: &'a SeenSky,
    /// Walls of the plant.
    pub walls: Walls,
}

/// Reason why there is no light at solids.
#[derive(Debug, thiserror::Error)]
#[non_exhaustive]
pub enum SolidsError {
    /// A mesh that no ray can be traced in.
    #[error(transparent)]
    Mesh(#[from] RayMeshError),
    /// The caller stopped the work.
    #[error(transparent)]
    Cancelled(#[from] Cancelled),
}

/// Share of wood in what leaves see from which on walls enclose them.
const ENCLOSED: f32 = 0.02;

impl Solids<'_> {
    /// Writes the light at solids into the fields of what leaves receive, and makes the values of all other sites that
    /// hold no leaf anew. The same for any number of threads.
    ///
    /// # Errors
    /// A mesh that no ray can be traced in; [`SolidsError::Cancelled`].
    pub fn light(&self, fields: &mut [(u8, Field)], progress: &Progress<'_>) -> Result<(), SolidsError> {
        let rays = RayMesh::new(&self.classed.mesh, self.ignore_alpha)?;
        let places = self.places();
        let points = points::on_solids(self.classed, &rays, self.turbid.grid);
        let enclosed = |point: &SolidPoint| {
            gather::place_near(self, &places, point.at, point.normal)
                .is_some_and(|place| places.is_enclosed(place))
        };
        let leaves = (!places.enclosed.is_empty())
            .then(|| points::on_leaves(self.classed, &rays, self.turbid.grid, enclosed))
            .filter(|leaves| !leaves.points.is_empty());
        let mut gathered = match &leaves {
            None => gather::gather(self, &rays, &places, &points, progress)?,
            Some(leaves) => {
                radiosity::Surfaces::new(self, &rays, &places, [&points, leaves]).gather(progress)?
            }
        };
        let fit = fit::Fit::new(self, &places, &gathered);
        let spread = Spread::new(fit.sites(), self.turbid.grid.lattice);
        let items = &self.total.items;
        let (mut far, mut near): (Vec<_>, Vec<_>) = fields
            .iter_mut()
            .map(|(item, field)| (items.iter().position(|of| of == item), field))
            .partition(|(column, _)| column.is_some());
        if let Some(on_solids) = near::NearOnSolids::new(self, &places, &fit, &gathered) {
            let mut near: Vec<&mut Field> = near.iter_mut().map(|(_, field)| &mut **field).collect();
            let kept = |site: usize, band: u32| {
                places.of(site).map_or(0.0, |place| {
                    let [leaf, _] = self.received[band as usize][place];
                    leaf.beam - leaf.total
                })
            };
            on_solids.carry_on(&fit, &spread, &mut near, &kept, &mut gathered);
        }
        far.par_iter_mut().for_each(|(column, field)| {
            let Some(column) = *column else { return };
            for band in 0..field.bands {
                let received = |site| field.value(band, site);
                let values = fit.values(received, column, band as usize, &gathered);
                field.set_band(band, spread.band(&values));
            }
        });
        progress(1.0)?;
        Ok(())
    }

    fn places(&self) -> Places {
        let sites = self.turbid.sites();
        let mut of_site = vec![Places::NONE; self.turbid.grid.sites()];
        (0..).zip(&sites).for_each(|(place, &site)| of_site[site as usize] = place);
        let enclosed = |place| self.seen_sky.of_wood(place) > ENCLOSED;
        let enclosed = (self.walls != Walls::None).then(|| (0..sites.len()).map(enclosed).collect());
        Places { of_site, enclosed: enclosed.unwrap_or_default() }
    }
}

/// Where the non-empty sites are in their list, and which of them walls enclose.
pub(crate) struct Places {
    of_site: Vec<u32>,
    /// Per place; empty where the plant has no walls.
    enclosed: Vec<bool>,
}

impl Places {
    const NONE: u32 = u32::MAX;

    fn of(&self, site: usize) -> Option<usize> {
        Some(self.of_site[site]).filter(|place| *place != Places::NONE).map(|place| place as usize)
    }

    /// Whether walls enclose the leaves of the site at a place.
    fn is_enclosed(&self, place: usize) -> bool {
        self.enclosed.get(place).is_some_and(|enclosed| *enclosed)
    }
}

#[cfg(test)]
pub(crate) mod tests;
