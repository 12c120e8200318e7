//! What the `physical` model keeps: the measured crown, and how the solves of its fields ended. The fields are
//! [`BaseArtefact`]s.
//!
//! [`BaseArtefact`]: super::BaseArtefact

use flb_format::matter::{INCLINATIONS, LeafAngles, TurbidMedium};
use rkyv::{Archive, Deserialize, Serialize};

use super::{Artefact, ArtefactError, MAX_BANDS, StoredGrid, check_length, fault};
use crate::crown::{Crown, SeenSky};
use flb_transport::ordinates::{BandReport, TotalLight};

#[doc(hidden)]
#[derive(Archive, Serialize, Deserialize)]
pub struct StoredCrown {
    grid: StoredGrid,
    leaf_per_m: Vec<f32>,
    wood_per_m: Vec<f32>,
    /// Shares of the inclinations.
    pub(super) angles: Vec<f64>,
    leaf_sides: Vec<f32>,
    open_sides: Vec<f32>,
    sides_to_wood: Vec<f32>,
    factor: f64,
    mesh_gap: f64,
    measured_gap: f64,
    gap: f64,
}

impl Artefact for Crown {
    const KIND: u32 = 5;
    type Stored = StoredCrown;

    fn store(&self) -> StoredCrown {
        let Crown { turbid, seen_sky, factor, mesh_gap, measured_gap, gap } = self;
        StoredCrown {
            grid: StoredGrid::store(&turbid.grid),
            leaf_per_m: turbid.leaf_per_m.clone(),
            wood_per_m: turbid.wood_per_m.clone(),
            angles: turbid.angles.shares().to_vec(),
            leaf_sides: seen_sky.sides.clone(),
            open_sides: seen_sky.open.clone(),
            sides_to_wood: seen_sky.wood.clone(),
            factor: *factor,
            mesh_gap: *mesh_gap,
            measured_gap: *measured_gap,
            gap: *gap,
        }
    }

    fn restore(stored: StoredCrown) -> Result<Crown, ArtefactError> {
        let StoredCrown { grid, leaf_per_m, wood_per_m, angles, leaf_sides, open_sides, .. } = stored;
        let StoredCrown { sides_to_wood, factor, mesh_gap, measured_gap, gap, .. } = stored;
        let grid = grid.restore()?;
        for (array, values) in [("leaf_per_m", &leaf_per_m), ("wood_per_m", &wood_per_m)] {
            check_length(array, values.len(), grid.sites())?;
            if let Some(site) = values.iter().position(|value| !(value.is_finite() && *value >= 0.0)) {
                let found = format!("{} per metre: expected a finite number from 0 up", values[site]);
                return fault(&format!("{array}, site {site}"), found);
            }
        }
        for (name, share) in [("mesh_gap", mesh_gap), ("measured_gap", measured_gap), ("gap", gap)] {
            if !(0.0..=1.0).contains(&share) {
                return fault(name, format!("{share}: expected a share from 0 to 1"));
            }
        }
        if !(factor.is_finite() && factor > 0.0) {
            return fault("factor", format!("{factor}: expected a finite number above 0"));
        }
        let found = format!("{angles:?}");
        let Some(angles) = angles.try_into().ok().and_then(LeafAngles::from_shares) else {
            return fault("angles", format!("{found}: expected {INCLINATIONS} shares whose sum is 1"));
        };
        let turbid = TurbidMedium { grid, leaf_per_m, wood_per_m, angles };
        // Of a medium that was made coarser, nothing is known of sides.
        let is_coarser = [&leaf_sides, &open_sides, &sides_to_wood].iter().all(|sides| sides.is_empty());
        let sites = if is_coarser { 0 } else { turbid.sites().len() };
        check_length("leaf_sides", leaf_sides.len(), sites)?;
        if let Some(place) = leaf_sides.iter().position(|sides| !sides.is_finite()) {
            return fault(&format!("leaf_sides, place {place}"), "expected a finite number".to_owned());
        }
        for (array, some) in [("open_sides", &open_sides), ("sides_to_wood", &sides_to_wood)] {
            check_length(array, some.len(), sites)?;
            let beyond = |(some, all): (&f32, &f32)| !(0.0..=*all).contains(some);
            if let Some(place) = some.iter().zip(&leaf_sides).position(beyond) {
                let found =
                    format!("{} of {} sides: expected no more than all", some[place], leaf_sides[place]);
                return fault(&format!("{array}, place {place}"), found);
            }
        }
        let seen_sky = SeenSky { sides: leaf_sides, open: open_sides, wood: sides_to_wood };
        Ok(Crown { turbid, seen_sky, factor, mesh_gap, measured_gap, gap })
    }
}

/// Result of the solves of a species.
#[derive(Debug, Clone, PartialEq)]
pub struct LightArtefact {
    /// Reports, one per band.
    pub reports: Vec<BandReport>,
    /// Suns that were held out.
    pub held_out: u32,
    /// All light at the non-empty sites.
    pub total: TotalLight,
}

#[doc(hidden)]
#[derive(Archive, Serialize, Deserialize)]
pub struct StoredLight {
    reports: Vec<StoredReport>,
    held_out: u32,
    items: Vec<u8>,
    total: Vec<Vec<Vec<f32>>>,
    near: Vec<Vec<Vec<f32>>>,
    beyond: Vec<Vec<f32>>,
    open_sky: Vec<f32>,
}

#[doc(hidden)]
#[derive(Archive, Serialize, Deserialize)]
pub struct StoredReport {
    solves: u32,
    passes: u32,
    error_estimate: f64,
    converged: bool,
    suns_rms: Option<f64>,
}

impl Artefact for LightArtefact {
    const KIND: u32 = 6;
    type Stored = StoredLight;

    fn store(&self) -> StoredLight {
        let of_band = |report: &BandReport| {
            let &BandReport { band: _, solves, passes, error_estimate, converged, suns_rms } = report;
            StoredReport { solves, passes, error_estimate, converged, suns_rms }
        };
        StoredLight {
            reports: self.reports.iter().map(of_band).collect(),
            held_out: self.held_out,
            items: self.total.items.clone(),
            total: self.total.values.clone(),
            near: self.total.near.clone(),
            beyond: self.total.beyond.clone(),
            open_sky: self.total.open_sky.clone(),
        }
    }

    fn restore(stored: StoredLight) -> Result<LightArtefact, ArtefactError> {
        let StoredLight { reports, held_out, items, total, near, beyond, open_sky } = stored;
        if !(1..=MAX_BANDS as usize).contains(&reports.len()) {
            return fault("reports", format!("{} bands: expected 1 to {MAX_BANDS}", reports.len()));
        }
        let mut restored = Vec::with_capacity(reports.len());
        for (band, report) in (0u32..).zip(reports) {
            let StoredReport { solves, passes, error_estimate, converged, suns_rms } = report;
            for (name, error) in [("error_estimate", error_estimate), ("suns_rms", suns_rms.unwrap_or(0.0))] {
                if !(error.is_finite() && error >= 0.0) {
                    let place = format!("band {band}, {name}");
                    return fault(&place, format!("{error}: expected a finite number from 0 up"));
                }
            }
            restored.push(BandReport { band, solves, passes, error_estimate, converged, suns_rms });
        }
        if total.len() != restored.len() || total.iter().any(|of_band| of_band.len() != items.len()) {
            let found = format!("light of {} bands and {} items", total.len(), items.len());
            return fault(
                "total",
                format!("{found}: expected {} bands, each with all items", restored.len()),
            );
        }
        let sites = total.first().and_then(|of_band| of_band.first()).map_or(0, Vec::len);
        if items.first() == Some(&0) {
            check_length("open_sky", open_sky.len(), sites)?;
        }
        let values = || total.iter().chain(&near).flatten().chain(&beyond).chain([&open_sky]).flatten();
        if let Some(value) = values().find(|value| !value.is_finite()) {
            return fault("total", format!("{value}: expected finite numbers"));
        }
        Ok(LightArtefact {
            reports: restored,
            held_out,
            total: TotalLight { items, values: total, near, beyond, open_sky },
        })
    }
}
