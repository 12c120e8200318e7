//! The page: plots, what is recommended, and the table, in one HTML file that needs nothing else.

use std::fmt::Write;

use flb_eval::trade::MeshRow;

use super::plot::escape;
use super::report::Report;
use crate::print;

const STYLE: &str = "\
body { font-family: sans-serif; color: #222; margin: 2em auto; max-width: 76em; line-height: 1.45; padding: 0 1em; }
svg { max-width: 100%; height: auto; display: block; margin: 1em 0; }
table { border-collapse: collapse; font-size: 0.85em; }
th, td { padding: 0.2em 0.6em; text-align: right; border-bottom: 1px solid #ddd; white-space: nowrap; }
th:nth-child(2), td:nth-child(2), td:last-child, th:last-child { text-align: left; }
tr.front { background: #eef6ee; font-weight: bold; }
tr:target { outline: 2px solid #0072b2; }
.scroll { overflow-x: auto; }";

/// The whole page; `plots` are SVG elements.
pub(super) fn page(report: &Report, subject: &str, plots: [&str; 4]) -> String {
    let subject = escape(subject);
    let mut html = format!(
        "<!DOCTYPE html>\n<html lang=\"en\">\n<head>\n<meta charset=\"utf-8\">\n<title>flb trade: {subject}</title>\n<style>\n{STYLE}\n</style>\n</head>\n<body>\n<h1>What to choose for {subject}</h1>\n"
    );
    html += &explanation(report);
    html += "<h2>Recommended</h2>\n<ul>\n";
    for recommended in &report.trade.recommended {
        let row = match recommended.row {
            Some(row) => format!("<a href=\"#row{row}\">row {row}</a>"),
            None => "none".to_owned(),
        };
        let _ = writeln!(
            html,
            "<li><b>{}</b>: {row}. {}</li>",
            recommended.preset,
            escape(&sentence(&recommended.why))
        );
    }
    html += "</ul>\n<p>Among the rows on the front that hold scattered light and are coded as presets are, the cheapest that meets the \
             target is taken; cost is the geometric mean of seconds, megabytes of memory and megabytes of file.</p>\n";
    html += "<h2>Plots</h2>\n<p>Marks tell their choice where the mouse rests on them.</p>\n";
    html += &plots.concat();
    html += "<h2>All rows</h2>\n<div class=\"scroll\">\n";
    html += &table(report);
    html += "</div>\n";
    html += &left_out(report);
    html + "</body>\n</html>\n"
}

fn sentence(why: &str) -> String {
    let mut letters = why.chars();
    letters.next().map_or(String::new(), |first| first.to_uppercase().collect::<String>() + letters.as_str())
}

fn explanation(report: &Report) -> String {
    let finest = report.trade.rows.first().map_or(String::new(), |row| escape(&row.choice));
    format!(
        "<p>Every row is a bake of <code>{}</code>, from import to the written file. <b>Mesh rms %</b> is how far its light is off \
         from paths traced on the mesh, at points of leaves and wood by area, under these suns without their beams and under an even sky, in % of \
         the mean truth; <b>furthest mean</b> is the mean light of leaves or wood that is furthest off. <b>Finest %</b> is the rms distance of its light from that \
         of row 1 ({finest}), sampled from the bytes of both files at {} points of the plant's surface under {} suns in every band, in % of \
         the mean total fluence there, {:.3} of the sun's, of which {:.3} are scattered, without the sky. Rows that hold the sun's beam (all of <code>paper</code>, and \
         <code>total</code>) are compared with the scattered light and the beam of row 1. <b>Monte Carlo %</b> is the rms distance over \
         the sites that hold matter from photons traced in the physical medium of the row's own lattice, the noise taken out by two \
         seeds, with its standard error and, behind, the mean difference. Rows on the Pareto front, which no other row beats \
         in seconds, memory, file and distance together (in steps of 10 %), are bold.</p>\n",
        escape(&report.mesh),
        report.trade.points,
        report.trade.suns.len(),
        report.trade.mean_fluence.total,
        report.trade.mean_fluence.scattered
    )
}

fn table(report: &Report) -> String {
    let head = [
        "row",
        "choice",
        "seconds",
        "memory",
        "file",
        "fields",
        "mesh rms %",
        "furthest mean %",
        "finest %",
        "paper %",
        "worst band %",
        "Monte Carlo %",
        "bias %",
        "converged",
        "preset",
    ];
    let mut html = String::from("<table>\n<tr>");
    head.iter().for_each(|name| html += &format!("<th>{name}</th>"));
    html += "</tr>\n";
    for row in &report.trade.rows {
        let (truth, bias) = match &row.monte_carlo {
            Some(found) => (
                format!("{:.2} &plusmn; {:.2}", found.rms_percent, found.standard_error_percent),
                format!("{:+.2}", found.bias_percent),
            ),
            None => ("-".to_owned(), "-".to_owned()),
        };
        let cells = [
            row.row.to_string(),
            format!("<span title=\"{}\">{}</span>", escape(&row.flags), escape(&row.choice)),
            format!("{:.2}", row.seconds),
            print::bytes(row.peak_bytes),
            print::bytes(row.bytes),
            row.fields.to_string(),
            row.mesh.as_ref().map_or("-".to_owned(), |mesh| format!("{:.1}", mesh.rms_percent)),
            row.mesh.as_ref().map_or("-".to_owned(), MeshRow::furthest_mean),
            format!("{:.2}", row.finest_percent),
            row.paper_percent.map_or("-".to_owned(), |percent| format!("{percent:.2}")),
            format!("{:.2} ({})", row.worst_band_percent, escape(&row.worst_band)),
            truth,
            bias,
            if row.converged { "yes" } else { "no" }.to_owned(),
            row.presets.join(" "),
        ];
        let class = if row.pareto { " class=\"front\"" } else { "" };
        let _ = write!(html, "<tr id=\"row{}\"{class}>", row.row);
        cells.iter().for_each(|cell| html += &format!("<td>{cell}</td>"));
        html += "</tr>\n";
    }
    html + "</table>\n"
}

/// What was not tried or traced.
fn left_out(report: &Report) -> String {
    let skipped =
        report.trade.skipped.iter().map(|skipped| format!("{}: {}", skipped.choice, skipped.reason));
    let untraced = report
        .trade
        .monte_carlo
        .iter()
        .filter_map(|of| Some(format!("lattice {}: {}", of.lattice, of.missing.as_ref()?)));
    let lines: Vec<String> = skipped.chain(untraced).collect();
    if lines.is_empty() {
        return String::new();
    }
    let mut html = String::from("<h2>Left out</h2>\n<ul>\n");
    lines.iter().for_each(|line| html += &format!("<li>{}</li>\n", escape(line)));
    html + "</ul>\n"
}
