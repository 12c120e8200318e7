//! Cost against the number of non-empty sites.

use std::fmt::Write;
use std::path::Path;
use std::time::Instant;

use flb_format::matter::Optics;
use flb_transport::lattice::{SolveSettings, solve};

use crate::{HEAP, oak};

const LATTICES: [u32; 4] = [32, 64, 128, 256];
/// The fastest of so many runs counts.
const RUNS: usize = 2;

/// One lattice.
struct Point {
    lattice: u32,
    sites: f64,
    seconds: f64,
}

pub(crate) fn print(plot: Option<&Path>) {
    println!("\n### Cost: oak, all 57 solves at the default tolerance\n");
    println!(
        "| lattice | N^3 | non-empty sites | sweeps | seconds | peak MB | ns per site, sweep and solve |"
    );
    println!("|---:|---:|---:|---:|---:|---:|---:|");
    let points: Vec<Point> = LATTICES.into_iter().map(measure).collect();
    if let Some(path) = plot {
        std::fs::write(path, draw(&points)).unwrap_or_else(|error| panic!("{}: {error}", path.display()));
    }
}

fn measure(lattice: u32) -> Point {
    let (medium, optics, settings) = (oak::medium(lattice), Optics::paper(), SolveSettings::default());
    let (mut seconds, mut sweeps, mut peak) = (f64::INFINITY, 0, 0);
    for _ in 0..RUNS {
        HEAP.reset_peak_usage();
        let held = HEAP.current_usage();
        let start = Instant::now();
        let solution = solve(&medium, &optics, &settings, &|_| Ok(())).expect("a good medium");
        seconds = seconds.min(start.elapsed().as_secs_f64());
        peak = HEAP.peak_usage() - held;
        sweeps = solution.reports.iter().filter(|report| report.base > 0).map(|report| report.sweeps).sum();
    }
    let sites = oak::sites_of(&medium) as f64;
    println!(
        "| {lattice} | {} | {sites} | {:.1} | {seconds:.3} | {:.0} | {:.2} |",
        u64::from(lattice).pow(3),
        f64::from(sweeps) / 54.0,
        peak as f64 / 1e6,
        seconds / (sites * f64::from(sweeps)) * 1e9
    );
    Point { lattice, sites, seconds }
}

/// Seconds against non-empty sites, both axes logarithmic, with straight lines of cost in proportion to the sites and
/// to N^3 from the first point on.
fn draw(points: &[Point]) -> String {
    let (width, height, margin) = (640.0, 440.0, 60.0);
    let [first, .., last] = points else { panic!("expected at least two lattices") };
    let cubes = |point: &Point| libm::pow(f64::from(point.lattice) / f64::from(first.lattice), 3.0);
    let (left, right) = (libm::log10(first.sites).floor(), libm::log10(last.sites).ceil());
    let (bottom, top) = (libm::log10(first.seconds).floor(), libm::log10(first.seconds * cubes(last)).ceil());
    let x = |sites: f64| margin + (libm::log10(sites) - left) / (right - left) * (width - 2.0 * margin);
    let y = |seconds: f64| {
        height - margin - (libm::log10(seconds) - bottom) / (top - bottom) * (height - 2.0 * margin)
    };
    let mut svg = format!(
        "<svg xmlns=\"http://www.w3.org/2000/svg\" viewBox=\"0 0 {width} {height}\" font-family=\"sans-serif\" font-size=\"13\">\n\
         <rect width=\"{width}\" height=\"{height}\" fill=\"#fff\"/>\n"
    );
    let mut line = |text: String| writeln!(svg, "{text}").expect("a string grows");
    for power in left as i32..=right as i32 {
        let at = x(libm::exp10(f64::from(power)));
        line(format!("<path d=\"M{at:.1} {margin}V{:.1}\" stroke=\"#ddd\"/>", height - margin));
        line(format!(
            "<text x=\"{at:.1}\" y=\"{:.1}\" text-anchor=\"middle\">10<tspan dy=\"-5\" font-size=\"9\">{power}</tspan></text>",
            height - margin + 18.0
        ));
    }
    for power in bottom as i32..=top as i32 {
        let at = y(libm::exp10(f64::from(power)));
        line(format!("<path d=\"M{margin} {at:.1}H{:.1}\" stroke=\"#ddd\"/>", width - margin));
        line(format!(
            "<text x=\"{:.1}\" y=\"{:.1}\" text-anchor=\"end\">10<tspan dy=\"-5\" font-size=\"9\">{power}</tspan></text>",
            margin - 6.0,
            at + 4.0
        ));
    }
    line(format!(
        "<text x=\"{:.1}\" y=\"{:.1}\" text-anchor=\"middle\">non-empty sites</text>",
        width / 2.0,
        height - 14.0
    ));
    line(format!(
        "<text x=\"16\" y=\"{0:.1}\" text-anchor=\"middle\" transform=\"rotate(-90 16 {0:.1})\">seconds, 57 solves</text>",
        height / 2.0
    ));
    let mut curve = |name: &str, style: &str, seconds: &dyn Fn(&Point) -> f64| {
        let path: Vec<String> =
            points.iter().map(|point| format!("{:.1} {:.1}", x(point.sites), y(seconds(point)))).collect();
        line(format!("<path d=\"M{}\" fill=\"none\" {style}/>", path.join("L")));
        let (x, y) = (x(last.sites) + 5.0, y(seconds(last)) + 4.0);
        line(format!("<text x=\"{x:.1}\" y=\"{y:.1}\">{name}</text>"));
    };
    curve("~ N\u{b3}", "stroke=\"#b33\" stroke-dasharray=\"6 4\"", &|point| first.seconds * cubes(point));
    curve("~ sites", "stroke=\"#888\" stroke-dasharray=\"2 4\"", &|point| {
        first.seconds * point.sites / first.sites
    });
    curve("solve", "stroke=\"#27632a\" stroke-width=\"2\"", &|point| point.seconds);
    for point in points {
        let (x, y) = (x(point.sites), y(point.seconds));
        line(format!("<circle cx=\"{x:.1}\" cy=\"{y:.1}\" r=\"4\" fill=\"#27632a\"/>"));
        line(format!("<text x=\"{:.1}\" y=\"{:.1}\">{}\u{b3}</text>", x - 4.0, y + 20.0, point.lattice));
    }
    svg + "</svg>\n"
}
