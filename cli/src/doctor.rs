//! `flb doctor`: what this machine offers, and whether the solver does as it must at its extremes.

use flb_format::container::records::LATEST_VERSION;
use flb_transport::extremes::{self, Measured, Outcome, Table};
use flb_transport::lattice::find_gpu;
use serde::Serialize;

use crate::args::DoctorArgs;
use crate::exit::{Failure, VERDICT};
use crate::print::{self, line};

#[derive(Serialize)]
struct Report {
    tool: &'static str,
    format_version: String,
    threads: usize,
    /// Name of the GPU that `--backend gpu` would take.
    gpu: Option<String>,
    /// Why there is none.
    gpu_error: Option<String>,
    extremes: Option<Vec<ExtremeReport>>,
}

#[derive(Serialize)]
struct ExtremeReport {
    /// Model of the solver.
    model: &'static str,
    name: &'static str,
    /// What is not as it must be.
    faults: Vec<String>,
    refused: Option<String>,
    measured: Option<Numbers>,
}

#[derive(Serialize)]
struct Numbers {
    sites: usize,
    /// Solves of which each ends by itself: the bases in all bands, or the bands.
    solves: usize,
    converged: usize,
    /// Sweeps of `paper`, passes of `physical`.
    iterations: u32,
    error_estimate: f64,
    compared: usize,
    relative_l2: f64,
    worst_site: f64,
    imbalance: f64,
    /// Error of the fit or the blend over suns; `paper` has none.
    suns_rms: Option<f64>,
    least_light: f32,
    most_light: f32,
}

/// Prints the report. With `--extremes`, exits with 1 if a case does not end as it must.
pub(crate) fn run(args: &DoctorArgs) -> Result<u8, Failure> {
    let (gpu, gpu_error) = match find_gpu() {
        Ok(name) => (Some(name), None),
        Err(error) => (None, Some(error.to_string())),
    };
    let mut report = Report {
        tool: concat!("flb ", env!("CARGO_PKG_VERSION")),
        format_version: format!("{}.{}", LATEST_VERSION.0, LATEST_VERSION.1),
        threads: rayon::current_num_threads(),
        gpu,
        gpu_error,
        extremes: None,
    };
    if !args.json {
        print::out(&text(&report))?;
    }
    let mut healthy = true;
    if args.extremes {
        let print = |text: &str| if args.json { Ok(()) } else { print::out(text) };
        let mut reports = Vec::new();
        for Table { model, legend, header, row, outcomes } in extremes::tables() {
            print(&format!("\nThe model {model}\n\n{legend}\n{header}"))?;
            for outcome in outcomes {
                print(&row(&outcome))?;
                reports.push(extreme(model, outcome));
            }
        }
        healthy = reports.iter().all(|report| report.faults.is_empty());
        report.extremes = Some(reports);
    }
    if args.json {
        print::json(&report)?;
    }
    Ok(if healthy { 0 } else { VERDICT })
}

fn text(report: &Report) -> String {
    let gpu = match (&report.gpu, &report.gpu_error) {
        (Some(name), _) => name.clone(),
        (None, error) => format!("none ({})", error.as_deref().unwrap_or("unknown")),
    };
    let rows = [("format", &report.format_version), ("threads", &report.threads.to_string()), ("GPU", &gpu)];
    let rows = rows.map(|(name, value)| line!("{name:<8} {value}"));
    line!("{}", report.tool) + &rows.concat()
}

fn extreme(model: &'static str, outcome: Outcome) -> ExtremeReport {
    let Outcome { name, measured, faults } = outcome;
    let refused = measured.as_ref().err().cloned();
    ExtremeReport { model, name, faults, refused, measured: measured.ok().map(numbers) }
}

fn numbers(found: Measured) -> Numbers {
    let [least_light, most_light] = found.range;
    Numbers {
        sites: found.sites,
        solves: found.solves,
        converged: found.converged,
        iterations: found.iterations,
        error_estimate: found.error_estimate,
        compared: found.compared,
        relative_l2: found.relative_l2,
        worst_site: found.worst_site,
        imbalance: found.imbalance,
        suns_rms: found.suns_rms,
        least_light,
        most_light,
    }
}
