//! Which row each preset of `flb bake` should be on this plant, and why.

use flb_format::Quality;
use flb_format::size_text::bytes;
use serde::Serialize;

use super::row::Row;

/// Largest distance from the finest light that a preset may have, % of its mean total fluence. Small, because only
/// scattered light is compared, which real leaves have little of. The last takes the smallest that was measured.
const TARGETS: [(Quality, Option<f64>); 4] = [
    (Quality::Draft, Some(5.0)),
    (Quality::Standard, Some(2.0)),
    (Quality::Fine, Some(1.0)),
    (Quality::Reference, None),
];

/// Preset, the row that serves it, and the row that it is today.
#[derive(Debug, Clone, PartialEq, Serialize)]
pub struct Recommended {
    /// Name of the preset.
    pub preset: &'static str,
    /// Largest distance from the finest light that it may have; null where nothing was measured that could be one.
    pub target_percent: Option<f64>,
    /// Number of the row; null where none meets the target.
    pub row: Option<usize>,
    /// Cost of the row: the geometric mean of seconds, megabytes of memory and megabytes of file.
    pub cost: Option<f64>,
    /// Reason, in words.
    pub why: String,
    /// Number of the row that is the preset as built in; null where it was not tried.
    pub built_in: Option<usize>,
}

/// One for each preset. Rows count that are on the front and hold scattered light of the `physical` model, coded as
/// presets are: the sun's beam is the renderer's to add.
pub(super) fn recommend(rows: &[Row]) -> Vec<Recommended> {
    let possible = |row: &&Row| row.field == "scattered" && row.codec == "classed" && row.converged;
    let front: Vec<&Row> = rows.iter().filter(|row| row.pareto).filter(possible).collect();
    TARGETS.iter().map(|(quality, percent)| of_preset(*quality, *percent, &front, rows)).collect()
}

fn of_preset(quality: Quality, percent: Option<f64>, front: &[&Row], rows: &[Row]) -> Recommended {
    let nearest = front.iter().min_by(|a, b| a.finest_percent.total_cmp(&b.finest_percent));
    let target = percent.or(nearest.map(|row| row.finest_percent));
    let meets = |row: &&&Row| target.is_some_and(|target| row.finest_percent <= target);
    let chosen = front.iter().filter(meets).min_by(|a, b| a.cost().total_cmp(&b.cost()));
    let built_in = rows.iter().find(|row| row.presets.contains(&quality.name()));
    let why = match (chosen, nearest) {
        (Some(row), _) => format!(
            "{} is off by {:.2} % ({}), and costs least of what is on the front and that near (rows: {}): {}",
            row.choice,
            row.finest_percent,
            match percent {
                Some(percent) => format!("at most {percent} % are asked for"),
                None => "the smallest that was measured".to_owned(),
            },
            front.iter().filter(meets).count(),
            price(row)
        ),
        (None, Some(nearest)) => format!(
            "no row is off by at most {} %; the nearest is {} with {:.2} %",
            target.unwrap_or_default(),
            nearest.choice,
            nearest.finest_percent
        ),
        (None, None) => "no row of scattered light was measured that a preset can be".to_owned(),
    };
    let today = match built_in {
        Some(row) if chosen.is_some_and(|chosen| chosen.row == row.row) => {
            "this is the preset as built in".to_owned()
        }
        Some(row) => format!(
            "the preset as built in is {}, off by {:.2} %, for {}",
            row.choice,
            row.finest_percent,
            price(row)
        ),
        None => "the preset as built in was not tried".to_owned(),
    };
    Recommended {
        preset: quality.name(),
        target_percent: target,
        row: chosen.map(|row| row.row),
        cost: chosen.map(|row| row.cost()),
        why: format!("{why}; {today}."),
        built_in: built_in.map(|row| row.row),
    }
}

fn price(row: &Row) -> String {
    let (memory, file) = (bytes(row.peak_bytes), bytes(row.bytes));
    let mesh = row
        .mesh
        .as_ref()
        .map_or(String::new(), |mesh| format!(", {:.1} % off on the mesh", mesh.rms_percent));
    format!("{:.1} s, {memory} of memory, {file} of file{mesh}", row.seconds)
}

#[cfg(test)]
mod tests {
    use super::super::choice::{Solve, Store, choices};
    use super::super::transport::PAPERS;
    use super::*;
    use flb_format::Codec;

    /// A row of scattered light with seconds and distance; memory and file take a megabyte.
    fn row(number: usize, seconds: f64, percent: f64) -> Row {
        let solve = choices(&[32], false).0[0].solve;
        let store = Store { codec: Codec::Classed, threshold: 0.0, psnr_db: 40.0, dark_error: 0.1 };
        Row {
            row: number,
            seconds,
            peak_bytes: 1_000_000,
            bytes: 1_000_000,
            finest_percent: percent,
            pareto: true,
            converged: true,
            ..Row::new(&solve, &store)
        }
    }

    fn chosen(rows: &[Row]) -> Vec<Option<usize>> {
        recommend(rows).iter().map(|recommended| recommended.row).collect()
    }

    #[test]
    fn the_cheapest_row_that_meets_a_target_is_chosen() {
        let rows = [row(1, 8.0, 0.2), row(2, 4.0, 0.9), row(3, 3.0, 1.9), row(4, 2.0, 4.0), row(5, 1.0, 5.1)];
        assert_eq!(chosen(&rows), [Some(4), Some(3), Some(2), Some(1)]);
        let draft = &recommend(&rows)[0];
        assert!(draft.why.contains("at most 5 %") && draft.why.contains("(rows: 4)"), "{}", draft.why);
        assert!((draft.cost.expect("a cost") - libm::cbrt(2.0)).abs() < 1e-9);
    }

    #[test]
    fn a_target_that_no_row_meets_is_said() {
        let rows = [row(1, 1.0, 1.5)];
        assert_eq!(chosen(&rows), [Some(1), Some(1), None, Some(1)]);
        let fine = &recommend(&rows)[2];
        assert!(
            fine.why.contains("no row is off by at most 1 %") && fine.why.contains("1.50 %"),
            "{}",
            fine.why
        );
        assert_eq!(chosen(&[]), [None; 4]);
    }

    #[test]
    fn rows_that_no_preset_can_be_are_passed_over() {
        let paper = Solve { lattice: 32, transport: PAPERS[0] };
        let store = Store { codec: Codec::Classed, threshold: 0.0, psnr_db: 40.0, dark_error: 0.1 };
        let rows = [
            Row { pareto: false, ..row(1, 1.0, 1.0) },
            Row { codec: "raw-f32", ..row(2, 1.0, 1.0) },
            Row { finest_percent: 1.0, pareto: true, converged: true, ..Row::new(&paper, &store) },
            Row { converged: false, ..row(4, 1.0, 1.0) },
        ];
        assert_eq!(chosen(&rows), [None; 4]);
    }

    #[test]
    fn the_preset_as_built_in_stands_beside_it() {
        let mut rows = [row(1, 2.0, 1.0), row(2, 4.0, 9.0)];
        rows[1].presets = vec!["draft"];
        let draft = &recommend(&rows)[0];
        assert_eq!((draft.row, draft.built_in), (Some(1), Some(2)));
        assert!(draft.why.contains("as built in is") && draft.why.contains("9.00 %"), "{}", draft.why);
        rows[0].presets = vec!["fine"];
        let all = recommend(&rows);
        assert!(all[2].why.contains("this is the preset as built in"), "{}", all[2].why);
        assert!(all[1].why.contains("was not tried"), "{}", all[1].why);
    }
}
