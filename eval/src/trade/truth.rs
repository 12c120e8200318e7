//! How far a solve is from Monte Carlo in the physical medium of its lattice, over the non-empty sites, the noise taken
//! out by two seeds.

use flb_format::Field;
use flb_format::progress::Progress;
use flb_transport::monte_carlo::judge::{self, Judgement, photons};
use flb_transport::ordinates::{OrdinatesSettings, OrdinatesSolution, SiteAlbedos, TotalLight, near};
use flb_transport::turbid::{BandScatter, TurbidMedium};
use serde::Serialize;

use super::transport::Transport;
use crate::EvalError;

/// Finest lattice that is traced: beyond, photons enough take longer than the solves.
pub(super) const FINEST_TRACED: u32 = 128;

/// Most bytes that the truth of a lattice may take.
const MAX_BYTES: u64 = 1 << 30;

/// Light of all bands and suns by Monte Carlo.
pub(super) struct Truth {
    sites: Vec<u32>,
    bands: u32,
    of_suns: Vec<judge::Truth>,
    /// Photons of every sun, band and seed.
    pub photons: u64,
}

/// The error of a solve's light, in % of the mean total fluence: over the sites, the mean over suns and bands.
#[derive(Debug, Clone, Copy, PartialEq, Serialize)]
pub struct TruthError {
    /// Root mean square.
    pub rms_percent: f64,
    /// Standard error of the rms.
    pub standard_error_percent: f64,
    /// Mean; above 0 where the light is too bright.
    pub bias_percent: f64,
}

impl Truth {
    /// Traces all bands and suns, or says why not. `albedos` are those that sites scattered with in the solve.
    pub(super) fn trace(
        turbid: &TurbidMedium,
        bands: &[BandScatter],
        albedos: &[SiteAlbedos],
        suns: &[[f64; 3]],
        progress: &Progress<'_>,
    ) -> Result<Result<Truth, String>, EvalError> {
        let lattice = turbid.grid.lattice;
        if lattice > FINEST_TRACED {
            return Ok(Err(format!(
                "Monte Carlo at lattice {lattice} would take longer than the solves; the finest that is traced is {FINEST_TRACED}"
            )));
        }
        let sites = turbid.sites();
        let values = (sites.len() * suns.len() * bands.len()) as u64;
        let bytes = values * 2 * 3 * size_of::<f64>() as u64;
        if bytes > MAX_BYTES {
            return Ok(Err(format!(
                "the Monte Carlo light of {} sites, {} suns and {} bands would take {bytes} bytes, at most {MAX_BYTES} are kept",
                sites.len(),
                suns.len(),
                bands.len()
            )));
        }
        let photons = photons(sites.len());
        let kinds = [false, true].map(|single| near(turbid, &sites, single));
        let of_sun = |(at, sun): (usize, &[f64; 3])| {
            let part = |share: f64| progress((at as f64 + share) / suns.len() as f64);
            judge::Truth::trace(turbid, &kinds, bands, Some(albedos), *sun, photons, &part)
        };
        let of_suns = suns.iter().enumerate().map(of_sun).collect::<Result<_, _>>()?;
        Ok(Ok(Truth { bands: bands.len() as u32, of_suns, photons, sites }))
    }

    /// The error of solved fields, the mean fluence of sites; they come back as they were. `None` where the truth is
    /// dark.
    pub(super) fn error(&self, transport: &Transport, fields: &mut Vec<(u8, Field)>) -> Option<TruthError> {
        let (suns, field) = (transport.suns(), transport.field());
        let settings = OrdinatesSettings { suns, field, ..OrdinatesSettings::default() };
        let solution = OrdinatesSolution {
            fields: std::mem::take(fields),
            reports: Vec::new(),
            held_out: 0,
            total: TotalLight::default(),
        };
        let of_band = |truth: &judge::Truth, band| truth.difference(&solution, &settings, band, &self.sites);
        let differences: Result<Vec<_>, _> = (0..self.bands)
            .flat_map(|band| self.of_suns.iter().map(move |truth| (truth, band)))
            .map(|(truth, band)| of_band(truth, band))
            .collect();
        *fields = solution.fields;
        let found = Judgement::over(&differences.ok()?)?;
        let percent = |share: f64| 100.0 * share;
        Some(TruthError {
            rms_percent: percent(found.rms),
            standard_error_percent: percent(found.rms_error),
            bias_percent: percent(found.bias),
        })
    }
}

#[cfg(test)]
mod tests {
    use super::super::transport::Marched;
    use super::*;
    use flb_transport::lattice::media;
    use flb_transport::ordinates::{self, NamedSuns, OrdinatesSettings};
    use flb_transport::turbid::{LeafAngles, Phase, Scatter};

    #[test]
    fn a_solve_is_near_the_truth_and_a_planted_error_is_found() {
        let medium = media::tree(16, 3);
        let extinction = |density: &f32| 4.0 * density;
        let leaf_per_m: Vec<f32> = medium.density.iter().map(extinction).collect();
        let wood_per_m = vec![0.0; leaf_per_m.len()];
        let turbid =
            TurbidMedium { grid: medium.grid, leaf_per_m, wood_per_m, angles: LeafAngles::spherical() };
        let scatter = Scatter { albedo: 0.5, phase: Phase::ISOTROPIC };
        let bands = [BandScatter { leaf: scatter, wood: scatter }; 2];
        let suns = judge::suns(2);
        let albedos = vec![vec![[0.5; 2]; turbid.sites().len()]; 2];
        let truth = Truth::trace(&turbid, &bands, &albedos, &suns, &|_| Ok(()))
            .expect("a valid medium")
            .expect("small");
        assert_eq!(truth.photons, photons(1));

        let settings = OrdinatesSettings::default();
        let solution = ordinates::solve(&turbid, &bands, &settings, &|_| Ok(())).expect("a valid medium");
        let transport = super::super::choice::finest(16).transport;
        let finest = *transport.marched().expect("the finest solve marches");
        let suns = NamedSuns::Sh2s;
        assert_eq!(suns.basis(), settings.suns);
        let transport = Transport::from(Marched { suns, ..finest });
        let mut fields = solution.fields.clone();
        let good = truth.error(&transport, &mut fields).expect("there is light");
        assert_eq!(fields, solution.fields);
        assert!(good.rms_percent < 2.0 && good.standard_error_percent < 0.5, "{good:?}");

        for (_, field) in &mut fields {
            field.values_mut().iter_mut().for_each(|value| *value *= 1.5);
        }
        let bad = truth.error(&transport, &mut fields).expect("there is light");
        assert!(bad.rms_percent > 3.0 * good.rms_percent, "{good:?}, {bad:?}");
        assert!(bad.bias_percent > 5.0 * good.bias_percent.abs(), "{good:?}, {bad:?}");
    }

    #[test]
    fn a_fine_lattice_is_not_traced_and_says_so() {
        let medium = media::empty(256);
        let extinction = vec![0.0; medium.grid.sites()];
        let turbid = TurbidMedium {
            grid: medium.grid,
            leaf_per_m: extinction.clone(),
            wood_per_m: extinction,
            angles: LeafAngles::spherical(),
        };
        let reason =
            Truth::trace(&turbid, &[], &[], &[], &|_| Ok(())).expect("no work").err().expect("a reason");
        assert!(reason.contains("lattice 256"), "{reason}");
    }
}
