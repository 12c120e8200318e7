//! Light that matter inside of one site sends to matter inside of the same site.
//!
//! A site of the solver is an even cloud. Of the light that it scatters, the cloud takes back 1 - e, with e the mean
//! share that escapes a cube of its extinction. Real matter takes back another share p, the *recollision probability*
//! [SS05]: leaves of a shoot shade each other more than a cloud that stops as much light from outside; a flat wall does
//! not shade itself at all. p follows from two areas: the cloud stops as much as the matter does, so its silhouette is
//! the matter's, and by reciprocity
//!
//! ```text
//! 1 - p = silhouette / mean projected area of the matter = kappa e
//! ```
//!
//! kappa is the extinction over that of the same area spread evenly (half of the leaf area density, a quarter of the
//! wood area density). p gives the two numbers that the solver and the fields need:
//!
//! - The albedo at which the cloud sends out as much as the matter does. Matter of albedo w sends out
//!   `S = w (1 - p) / (1 - p w)` of what it stops [SS05]; the cloud does at `w' = S / (e + S (1 - e))`.
//! - The fluence that matter receives in place of the cloud's mean:
//!   `phi_matter = (kappa e / e) (1 - (1 - e) w'_site) / (1 - p w) phi`, so that both absorb the same. A surface in it
//!   gets a quarter of it on each side. Of the beam that has met nothing it gets `kappa phi_beam`.
//!
//! Where everything is white (w = 1), w' is 1 and phi_matter = phi: a white plant stays invisible under an even sky.

use flb_format::{Grid, Medium};
use flb_transport::ordinates::SiteAlbedos;
use flb_transport::turbid::TurbidMedium;
use rayon::prelude::*;

use super::directions::measured_axes;
use super::estimate::Cubes;
use super::rays_per_site;
use crate::mixture::Albedos;

/// Least share of its mean projected area that matter shows as a silhouette.
const MIN_ESCAPE: f64 = 0.02;

/// Largest silhouettes of leaf and of wood that are believed, relative to the mean projected area: a splinter of a
/// triangle in its site shows any number. Rays that arrive at a wall come from one side and meet twice as much of it.
const MAX_RATIO: [f64; 2] = [2.0, 3.0];

/// Hits that the sites around count for beside a site's own.
const PRIOR_HITS: f64 = 8.0;

/// Mean chord of a cube, in edges: four volumes over the surface.
const MEAN_CHORD: f64 = 2.0 / 3.0;

/// Interreflection inside of the sites of a medium, in the order of [`TurbidMedium::sites`].
#[derive(Debug, Clone, PartialEq)]
pub struct Recollision {
    sites: Vec<OfSite>,
}

#[derive(Debug, Clone, Copy, PartialEq)]
struct OfSite {
    /// Leaf and wood.
    kinds: [OfKind; 2],
    /// Share of wood in the extinction.
    wood: f64,
}

#[derive(Debug, Clone, Copy, PartialEq)]
struct OfKind {
    /// Extinction over that of the same area spread evenly.
    kappa: f64,
    /// Mean share of light scattered inside that escapes the cloud.
    escape: f64,
    /// Recollision probability.
    within: f64,
}

/// Light that matter of one kind receives in a site, relative to the cloud.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Received {
    /// Ratio of the received light to the cloud's, of all light.
    pub total: f32,
    /// Ratio of the received light to the cloud's, of light that has met nothing.
    pub beam: f32,
    /// Share of the received light that the matter sends on.
    pub albedo: f32,
}

impl Recollision {
    /// Computes the recollisions in a crown that was measured on the sites of `medium`, before all extinctions were
    /// multiplied by `factor`.
    pub fn of(turbid: &TurbidMedium, factor: f64, medium: &Medium) -> Recollision {
        let cubes = Cubes::new(&measured_axes());
        let edge_m = turbid.grid.spacing_m;
        let sites = turbid.sites();
        let sums_of = |&site: &u32| {
            let site = site as usize;
            let escape = cubes.escape(f64::from(turbid.extinction(site)) / factor * edge_m);
            let areas = [0.5 * medium.leaf_area_density[site], 0.25 * medium.wood_area_density[site]];
            let extinctions = [turbid.leaf_per_m[site], turbid.wood_per_m[site]];
            std::array::from_fn(|kind| {
                let [even, extinction] = [areas[kind], extinctions[kind]].map(f64::from);
                let extinction = extinction.min(MAX_RATIO[kind] * factor / escape * even);
                Sums { even, extinction, seen: (extinction / factor * escape).min(even) }
            })
        };
        let own: Vec<[Sums; 2]> = sites.par_iter().map(sums_of).collect();
        let around = around(&turbid.grid, &sites, &own);
        let rays = rays_per_site(turbid.grid.lattice);
        let of_site = |((&site, own), around): ((&u32, &[Sums; 2]), &[Sums; 2])| {
            let extinction = turbid.extinction(site as usize);
            let kinds = std::array::from_fn(|kind| {
                // Hits that even matter would have had.
                let hits = own[kind].even * edge_m * MEAN_CHORD * rays;
                let Sums { even, extinction: stopped, seen } = own[kind].leaning_on(&around[kind], hits);
                if even <= 0.0 || stopped <= 0.0 {
                    let escape = cubes.escape(f64::from(extinction) * edge_m);
                    return OfKind { kappa: 1.0, escape, within: 1.0 - escape }; // as the cloud
                }
                let kappa = stopped / even;
                let escape = ((seen / even).max(MIN_ESCAPE) / kappa).min(1.0);
                OfKind { kappa, escape, within: 1.0 - kappa * escape }
            });
            OfSite { kinds, wood: f64::from(turbid.wood_per_m[site as usize] / extinction) }
        };
        Recollision { sites: sites.par_iter().zip(&own).zip(&around).map(of_site).collect() }
    }

    /// Albedos to solve with, per band.
    pub fn albedos(&self, bands: &[impl Albedos]) -> Vec<SiteAlbedos> {
        let of_band = |band: &dyn Albedos| {
            let of_site = |(place, site): (usize, &OfSite)| {
                site.albedos(band.albedos(place)).map(|albedo| albedo as f32)
            };
            self.sites.iter().enumerate().map(of_site).collect()
        };
        bands.iter().map(|band| of_band(band)).collect()
    }

    /// Returns the light that leaf and wood receive in every site, in a band, `[place]`. `sky` is all light of the
    /// sites under an even sky of fluence 1, where it is known: no surface receives more of it than 1, as none is
    /// brighter than the sky.
    pub fn all_received(&self, band: &impl Albedos, sky: Option<&[f32]>) -> Vec<[Received; 2]> {
        let of_site = |place: usize| {
            let most = sky.map_or(f32::INFINITY, |sky| sky[place].recip());
            self.received(place, band).map(|Received { total, beam, albedo }| {
                let kept = (most / total).min(1.0);
                Received { total: kept * total, beam: kept * beam, albedo }
            })
        };
        (0..self.sites.len()).into_par_iter().map(of_site).collect()
    }

    /// Returns the light that leaf and wood receive in the site at a place of the list, in a band.
    pub fn received(&self, place: usize, band: &impl Albedos) -> [Received; 2] {
        let site = &self.sites[place];
        let [leaf, wood] = &site.kinds;
        let of_matter = band.albedos(place);
        let albedos = site.albedos(of_matter);
        let kept = |kind: &OfKind, albedo: f64| (1.0 - kind.escape) * albedo;
        let cloud = 1.0 - (1.0 - site.wood) * kept(leaf, albedos[0]) - site.wood * kept(wood, albedos[1]);
        std::array::from_fn(|kind| {
            let OfKind { kappa, within, .. } = site.kinds[kind];
            let total = kappa * cloud / (1.0 - within * of_matter[kind]);
            Received { total: total as f32, beam: kappa as f32, albedo: of_matter[kind] as f32 }
        })
    }
}

/// Sums over sites, per metre: what the area would stop if it were even, what it stops, and what it shows of itself.
#[derive(Debug, Clone, Copy, Default)]
struct Sums {
    even: f64,
    extinction: f64,
    seen: f64,
}

impl Sums {
    /// What is known of a site from so many hits and from the sites around it.
    fn leaning_on(&self, around: &Sums, hits: f64) -> Sums {
        if self.even <= 0.0 || around.even <= 0.0 {
            return *self;
        }
        let own = hits / (hits + PRIOR_HITS);
        let scale = self.even / around.even;
        let mix = |own_value: f64, value: f64| own * own_value + (1.0 - own) * scale * value;
        Sums {
            even: self.even,
            extinction: mix(self.extinction, around.extinction),
            seen: mix(self.seen, around.seen),
        }
    }
}

/// Sums over each site and the sites around it, of leaf and of wood: rays miss a splinter of a leaf, or find it twice.
fn around(grid: &Grid, sites: &[u32], own: &[[Sums; 2]]) -> Vec<[Sums; 2]> {
    let mut places = vec![u32::MAX; grid.sites()];
    (0u32..).zip(sites).for_each(|(place, &site)| places[site as usize] = place);
    let of_site = |&site: &u32| {
        let mut sums = [Sums::default(); 2];
        for near in grid.cube_around(grid.site(site as usize)) {
            let Some(own) = own.get(places[near] as usize) else { continue };
            for (sum, own) in sums.iter_mut().zip(own) {
                sum.even += own.even;
                sum.extinction += own.extinction;
                sum.seen += own.seen;
            }
        }
        sums
    };
    sites.par_iter().map(of_site).collect()
}

impl OfSite {
    fn albedos(&self, albedos: [f64; 2]) -> [f64; 2] {
        std::array::from_fn(|kind| {
            let OfKind { escape, within, .. } = self.kinds[kind];
            let sent = albedos[kind] * (1.0 - within) / (1.0 - within * albedos[kind]);
            (sent / (escape + sent * (1.0 - escape))).clamp(0.0, 1.0)
        })
    }
}

impl Cubes {
    /// Mean share of light that starts anywhere in a cube, in any direction, and leaves it, at an extinction times
    /// edge. By reciprocity it is the share of light from outside that the cube stops, over the mean depth.
    pub(super) fn escape(&self, depth: f64) -> f64 {
        let mean = MEAN_CHORD * depth;
        if mean < 1e-3 { 1.0 - mean } else { (self.stopped(depth) / mean).min(1.0) }
    }
}

#[cfg(test)]
mod tests;
