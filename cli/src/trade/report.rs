//! What was measured, as JSON, CSV and text; and the folder that holds it.

use std::path::{Path, PathBuf};

use flb_eval::Trade;
use flb_eval::trade::{MeshRow, TruthError};
use flb_files::Existing;
use serde::Serialize;

use super::plot::{Against, plot};
use crate::args::TradeArgs;
use crate::exit::{Failure, INTERNAL};
use crate::folder;
use crate::print::{self, line};

/// What `--json` prints and trade.json holds (cli/schema/trade.json).
#[derive(Serialize)]
pub(super) struct Report {
    /// The folder.
    pub output: String,
    pub mesh: String,
    #[serde(flatten)]
    pub trade: Trade,
}

impl Report {
    pub(super) fn new(args: &TradeArgs, folder: &Path, trade: Trade) -> Report {
        Report { output: folder.display().to_string(), mesh: args.mesh_file.display().to_string(), trade }
    }

    /// For a terminal.
    pub(super) fn text(&self) -> String {
        let head = [
            "row",
            "choice",
            "seconds",
            "memory",
            "file",
            "fields",
            "mesh rms %",
            "furthest mean",
            "finest %",
            "paper %",
            "Monte Carlo %",
            "front",
            "preset",
        ];
        let mut table = vec![head.map(str::to_owned).to_vec()];
        table.extend(self.trade.rows.iter().map(|row| {
            vec![
                row.row.to_string(),
                format!("{:<46}", row.choice),
                format!("{:.2}", row.seconds),
                print::bytes(row.peak_bytes),
                print::bytes(row.bytes),
                row.fields.to_string(),
                row.mesh.as_ref().map_or("-".to_owned(), |mesh| format!("{:.1}", mesh.rms_percent)),
                row.mesh.as_ref().map_or("-".to_owned(), MeshRow::furthest_mean),
                format!("{:.2}", row.finest_percent),
                row.paper_percent.map_or("-".to_owned(), |percent| format!("{percent:.2}")),
                row.monte_carlo.map_or("-".to_owned(), |found| format!("{:.2}", found.rms_percent)),
                if row.pareto { "*" } else { "" }.to_owned(),
                row.presets.join(" "),
            ]
        }));
        let mut text = print::table(&table);
        text.push('\n');
        for skipped in &self.trade.skipped {
            text += &line!("skipped {}: {}", skipped.choice, skipped.reason);
        }
        for recommended in &self.trade.recommended {
            let row = recommended.row.map_or("none".to_owned(), |row| format!("row {row}"));
            text += &line!("{}: {row}: {}", recommended.preset, recommended.why);
        }
        text + &line!("{}: {FILES_TEXT}", self.output)
    }

    fn csv(&self) -> String {
        let mut csv = COLUMNS.join(",") + "\n";
        for row in &self.trade.rows {
            let or_empty = |value: Option<f64>| value.map_or(String::new(), |value| value.to_string());
            let number = |value: Option<u32>| value.map_or(String::new(), |value| value.to_string());
            let of_truth = |of: fn(&TruthError) -> f64| or_empty(row.monte_carlo.as_ref().map(of));
            let cells = [
                row.row.to_string(),
                quoted(&row.choice),
                quoted(&row.presets.join(" ")),
                row.model.to_owned(),
                row.lattice.to_string(),
                row.suns.clone().unwrap_or_default(),
                number(row.ordinates),
                number(row.rays),
                number(row.parts),
                row.field.to_owned(),
                row.tolerance.to_string(),
                row.codec.to_owned(),
                row.threshold.map_or(String::new(), |threshold| threshold.to_string()),
                or_empty(row.psnr_db),
                row.sites.to_string(),
                row.seconds.to_string(),
                row.peak_bytes.to_string(),
                row.predicted_bytes.to_string(),
                row.bytes.to_string(),
                row.fields.to_string(),
                row.converged.to_string(),
                or_empty(row.mesh.as_ref().map(|mesh| mesh.rms_percent)),
                or_empty(row.mesh.as_ref().map(|mesh| mesh.bias_percent)),
                quoted(row.mesh.as_ref().map_or("", |mesh| &mesh.furthest)),
                row.finest_percent.to_string(),
                or_empty(row.paper_percent),
                quoted(&row.worst_band),
                row.worst_band_percent.to_string(),
                of_truth(|found| found.rms_percent),
                of_truth(|found| found.standard_error_percent),
                of_truth(|found| found.bias_percent),
                row.pareto.to_string(),
                quoted(&row.flags),
            ];
            let cells: [String; COLUMNS.len()] = cells;
            csv += &(cells.join(",") + "\n");
        }
        csv
    }

    /// Names of the files and what they hold. `page` makes the HTML, of a title and the plots.
    fn files(
        &self,
        page: impl Fn(&Report, &str, [&str; 4]) -> String,
    ) -> Result<Vec<(String, String)>, Failure> {
        let json = serde_json::to_string_pretty(self).map_err(|error| Failure::new(INTERNAL, error))?;
        let subject =
            Path::new(&self.mesh).file_name().map_or(self.mesh.clone(), |n| n.to_string_lossy().into_owned());
        let plots = Against::ALL.map(|against| (against, plot(&self.trade.rows, against, &subject)));
        let html = page(self, &subject, plots.each_ref().map(|(_, svg)| svg.as_str()));
        let mut files = vec![("trade.csv".to_owned(), self.csv())];
        files.extend(plots.into_iter().map(|(against, svg)| (plot_name(against), svg)));
        files.extend([("trade.html".to_owned(), html), ("trade.json".to_owned(), json + "\n")]);
        Ok(files)
    }
}

const FILES_TEXT: &str = "trade.html (plots, table, what is recommended), trade.csv, trade.json, trade-*.svg";

const COLUMNS: [&str; 33] = [
    "row",
    "choice",
    "presets",
    "model",
    "lattice",
    "suns",
    "ordinates",
    "rays",
    "parts",
    "field",
    "tolerance",
    "codec",
    "threshold",
    "psnr_db",
    "sites",
    "seconds",
    "peak_bytes",
    "predicted_bytes",
    "bytes",
    "fields",
    "converged",
    "mesh_rms_percent",
    "mesh_bias_percent",
    "mesh_furthest",
    "finest_percent",
    "paper_percent",
    "worst_band",
    "worst_band_percent",
    "monte_carlo_rms_percent",
    "monte_carlo_standard_error_percent",
    "monte_carlo_bias_percent",
    "pareto",
    "flags",
];

/// A cell of words; RFC 4180. What a spreadsheet would take for a formula begins with an apostrophe, which it takes for
/// text.
fn quoted(text: &str) -> String {
    if text.starts_with(['=', '+', '-', '@', '\t', '\r']) {
        return format!("\"'{}\"", text.replace('"', "\"\""));
    }
    match text.contains([',', '"', '\n', '\r']) {
        true => format!("\"{}\"", text.replace('"', "\"\"")),
        false => text.to_owned(),
    }
}

fn plot_name(against: Against) -> String {
    format!("trade-{}.svg", against.name())
}

fn names() -> Vec<String> {
    let plots = Against::ALL.map(plot_name);
    plots.into_iter().chain(["trade.csv", "trade.html", "trade.json"].map(str::to_owned)).collect()
}

/// Refuses, before any work, a folder that the files cannot be written to.
pub(super) fn check_folder(folder: &Path, inputs: &[&PathBuf], existing: Existing) -> Result<(), Failure> {
    let inputs: Vec<&Path> = inputs.iter().map(|path| path.as_path()).collect();
    let names = names();
    folder::check_folder(folder, &names.iter().map(String::as_str).collect::<Vec<_>>(), &inputs, existing)
}

/// Refuses to write over what was read: what a mesh names is known once it is read.
pub(super) fn check_unread(folder: &Path) -> Result<(), Failure> {
    Ok(names().iter().try_for_each(|name| flb_files::check_unread(&folder.join(name)))?)
}

/// Writes every file whole, or none.
pub(super) fn publish_all(
    report: &Report,
    page: impl Fn(&Report, &str, [&str; 4]) -> String,
    folder: &Path,
    existing: Existing,
) -> Result<(), Failure> {
    let files = report.files(page)?;
    let files: Vec<_> =
        files.iter().map(|(name, content)| (name.as_str(), content.clone().into_bytes())).collect();
    folder::publish_all(folder, &files, existing)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn no_cell_of_words_is_a_formula() {
        for text in ["=1+1", "+1", "-1", "@SUM(A1)", "--lattice 32", "\t=1", "\r=1"] {
            assert_eq!(quoted(text), format!("\"'{text}\""));
        }
        assert_eq!(quoted("=\"a\""), "\"'=\"\"a\"\"\"");
        assert_eq!((quoted("a=1"), quoted("a, b")), ("a=1".to_owned(), "\"a, b\"".to_owned()));
    }

    #[test]
    fn cells_are_quoted_where_they_must_be() {
        assert_eq!(quoted("physical 32 sh2/110"), "physical 32 sh2/110");
        assert_eq!(quoted("red, \"far\""), "\"red, \"\"far\"\"\"");
    }
}
