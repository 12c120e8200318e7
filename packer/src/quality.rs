//! What a coding costs and what it spoils: bytes, and the error of trilinear samples where surfaces are.
//!
//! Samples are taken as a renderer takes them: at points inside non-empty sites, from the one block that
//! answers them, straight from its kept coefficients.

use flb_format::container::payload::BlockPage;
use flb_format::{Field, sample};
use rayon::prelude::*;
use serde::Serialize;

use crate::rate::Missed;
use crate::surface::{POINTS_PER_SITE, surface_point};

/// Sites that are measured at once; sums are taken in their order.
const SITES_AT_ONCE: usize = 4096;

/// Sizes and errors of a coded species.
#[derive(Debug, Clone, PartialEq, Serialize)]
pub struct CodingReport {
    /// Bytes of all bases as plain floats.
    pub raw_bytes: u64,
    /// Bytes of all bases' pages as stored.
    pub coded_bytes: u64,
    /// `raw_bytes / coded_bytes`.
    pub ratio: f64,
    /// Error of all bases pooled, each relative to its own peak, or of the sky's light and the sun's, where bases that
    /// are coded near geometry make it together; `None` where no sample has an error.
    pub surface_psnr_db: Option<f64>,
    /// Reports of the bases, ascending by base.
    pub bases: Vec<BaseReport>,
    /// Bases that missed the error that they were to be coded to.
    #[serde(skip)]
    pub missed: Vec<Missed>,
}

/// Sizes and error of one coded base.
#[derive(Debug, Clone, PartialEq, Serialize)]
pub struct BaseReport {
    /// Base index.
    pub base: u8,
    /// Bytes as plain floats.
    pub raw_bytes: u64,
    /// Bytes of its pages as stored.
    pub coded_bytes: u64,
    /// Largest magnitude of a sample of the uncoded field at the surface points, in the field's unit.
    pub peak: f64,
    /// Largest error of a sample, in the field's unit.
    pub max_error: f64,
    /// `-10 log10(mean(error^2) / peak^2)`; `None` where no sample has an error.
    pub surface_psnr_db: Option<f64>,
    /// Mean square of error / peak.
    #[serde(skip)]
    relative_square: f64,
}

impl BaseReport {
    pub(crate) fn new(base: u8, raw_bytes: u64, coded_bytes: u64, error: SurfaceError) -> BaseReport {
        let SurfaceError { mean_square, peak, max_error } = error;
        // Errors in a field that is 0 at every point have no peak to be compared with: take 1.
        let scale = if peak > 0.0 { peak } else { 1.0 };
        let relative_square = mean_square / (scale * scale);
        let surface_psnr_db = decibels(relative_square);
        BaseReport { base, raw_bytes, coded_bytes, peak, max_error, surface_psnr_db, relative_square }
    }
}

impl CodingReport {
    /// Of all bases; `together` says that all but base 0 make the light of a sun together, so that their errors add up.
    pub(crate) fn pool(bases: Vec<BaseReport>, together: bool) -> CodingReport {
        let raw_bytes = bases.iter().map(|base| base.raw_bytes).sum();
        let coded_bytes = bases.iter().map(|base| base.coded_bytes).sum();
        let lights = if together { 2 } else { bases.len() };
        let mean = bases.iter().map(|base| base.relative_square).sum::<f64>() / lights.max(1) as f64;
        let ratio = raw_bytes as f64 / coded_bytes as f64;
        CodingReport {
            raw_bytes,
            coded_bytes,
            ratio,
            surface_psnr_db: decibels(mean),
            bases,
            missed: Vec::new(),
        }
    }
}

fn decibels(relative_square: f64) -> Option<f64> {
    (relative_square > 0.0).then(|| -10.0 * libm::log10(relative_square))
}

/// Error of the samples of one base.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(crate) struct SurfaceError {
    mean_square: f64,
    /// Largest magnitude of a sample, or what else the error is to be compared with.
    pub peak: f64,
    max_error: f64,
}

impl SurfaceError {
    /// Of a coding without loss: only the peak is measured.
    pub(crate) fn exact(sites: &[u32], field: &Field) -> SurfaceError {
        SurfaceError::measure(sites, field, |_, out, original| out.copy_from_slice(original))
    }

    /// Of a field against what is stored of it, texel by texel.
    pub(crate) fn of_texels(sites: &[u32], field: &Field, stored: &Field) -> SurfaceError {
        SurfaceError::measure(sites, field, |point, out, _| sample::trilinear(stored, point, out))
    }

    /// Of a field against its coded blocks, which are all blocks in order.
    pub(crate) fn of_blocks(sites: &[u32], field: &Field, pages: &[BlockPage]) -> SurfaceError {
        let bands = field.bands as usize;
        SurfaceError::measure(sites, field, |point, out, _| {
            let at = sample::locate(field.lattice, point);
            let b = at.block_index(field.lattice);
            let page = &pages[pages.partition_point(|page| page.first_block <= b) - 1];
            let (mask, coefficients) = page.block((b - page.first_block) as usize, bands);
            sample::sample(mask, coefficients, bands, at.local, out);
        })
    }

    /// Of a field against whatever samples at points in lattice coordinates.
    pub(crate) fn of_samples(
        sites: &[u32],
        field: &Field,
        sample: impl Fn([f64; 3], &mut [f32]) + Sync,
    ) -> SurfaceError {
        SurfaceError::measure(sites, field, |point, out, _| sample(point, out))
    }

    /// `coded` writes what is read at a point, in lattice coordinates, in place of the original's values, which it is
    /// given.
    fn measure(
        sites: &[u32],
        field: &Field,
        coded: impl Fn([f64; 3], &mut [f32], &[f32]) + Sync,
    ) -> SurfaceError {
        let bands = field.bands as usize;
        let of_some = |sites: &[u32]| {
            let (mut original, mut other) = (vec![0.0f32; bands], vec![0.0f32; bands]);
            let (mut square, mut peak, mut max_error) = (0.0f64, 0.0f64, 0.0f64);
            for &site in sites {
                for k in 0..POINTS_PER_SITE {
                    let point = surface_point(site, k, field.lattice);
                    sample::trilinear(field, point, &mut original);
                    coded(point, &mut other, &original);
                    for (a, b) in original.iter().zip(&other) {
                        let error = f64::from(*a) - f64::from(*b);
                        square += error * error;
                        peak = peak.max(f64::from(a.abs())); // coefficients of harmonics may be negative
                        max_error = max_error.max(error.abs());
                    }
                }
            }
            (square, peak, max_error)
        };
        let of_all: Vec<(f64, f64, f64)> = sites.par_chunks(SITES_AT_ONCE).map(of_some).collect();
        let count = (sites.len() * POINTS_PER_SITE as usize * bands).max(1);
        SurfaceError {
            mean_square: of_all.iter().map(|(square, ..)| square).sum::<f64>() / count as f64,
            peak: of_all.iter().map(|(_, peak, _)| *peak).fold(0.0, f64::max),
            max_error: of_all.iter().map(|(.., error)| *error).fold(0.0, f64::max),
        }
    }
}
