//! Solvers at the ends of their ranges: the tables of both.
//!
//! `flb doctor --extremes` prints them, docs/extremes.md keeps them. Their numbers do not depend on the machine.

pub use crate::ends::{End, Measured, Outcome};

use crate::{lattice, ordinates};

/// A solver's table of extremes.
pub struct Table {
    /// Model of the solver.
    pub model: &'static str,
    /// Description of the columns, and of the limits that are asked of them.
    pub legend: String,
    /// Header of the table.
    pub header: &'static str,
    /// Formats an outcome as a row, with its line end.
    pub row: fn(&Outcome) -> String,
    /// Outcomes of the cases, in the order of the table; each is solved as it is asked for.
    pub outcomes: Box<dyn Iterator<Item = Outcome>>,
}

/// The tables of all solvers.
pub fn tables() -> [Table; 2] {
    [
        Table {
            model: "physical",
            legend: ordinates::extremes::table::legend(),
            header: ordinates::extremes::table::HEADER,
            row: ordinates::extremes::table::row,
            outcomes: Box::new(ordinates::extremes::cases().into_iter().map(ordinates::extremes::run)),
        },
        Table {
            model: "paper",
            legend: lattice::extremes::table::legend(),
            header: lattice::extremes::table::HEADER,
            row: lattice::extremes::table::row,
            outcomes: Box::new(lattice::extremes::cases().into_iter().map(lattice::extremes::run)),
        },
    ]
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::ends::Limits;

    const DOCS_HEAD: &str = "\
# The solvers at the extremes

Written and checked by a test; `flb doctor --extremes` prints it.
";

    /// `FLB_WRITE_DOCS=1` writes the tables anew.
    #[test]
    fn every_extreme_ends_as_the_docs_say() {
        let (mut faults, mut text) = (Vec::new(), DOCS_HEAD.to_owned());
        for Table { model, legend, header, row, outcomes } in tables() {
            text += &format!("\n## The model `{model}`\n\n{legend}\n{header}");
            for outcome in outcomes {
                text += &row(&outcome);
                if !outcome.faults.is_empty() {
                    faults.push(format!("{outcome:?}"));
                }
            }
        }
        let path = concat!(env!("CARGO_MANIFEST_DIR"), "/../docs/extremes.md");
        if std::env::var_os("FLB_WRITE_DOCS").is_some() {
            std::fs::write(path, &text).unwrap();
        }
        assert!(faults.is_empty(), "{}", faults.join("\n"));
        let kept = std::fs::read_to_string(path).unwrap_or_default();
        for (line, (kept, found)) in kept.lines().zip(text.lines()).enumerate() {
            assert_eq!(kept, found, "docs/extremes.md, line {}; FLB_WRITE_DOCS=1 writes it anew", line + 1);
        }
        assert_eq!(kept.lines().count(), text.lines().count());
    }

    /// `too_sure` makes the estimate too small for the error.
    fn wrong_ends_are_faults(tree: Outcome, limits: &Limits, too_sure: fn(&mut Measured)) {
        assert!(tree.faults.is_empty());
        let found = tree.measured.unwrap();
        let judge = |end, measured| Outcome::new("", end, measured, limits).faults.len();
        let spoil = |change: &dyn Fn(&mut Measured)| {
            let mut spoilt = found.clone();
            change(&mut spoilt);
            judge(End::Converges, Ok(spoilt))
        };
        assert_eq!(spoil(&|_| {}), 0);
        assert_eq!(spoil(&|m| m.range = [f32::NAN; 2]), 1);
        assert_eq!(spoil(&|m| m.range[0] = -1e-9), 1);
        assert_eq!(spoil(&|m| m.converged -= 1), 1);
        assert_eq!(spoil(&too_sure), 1);
        assert_eq!(spoil(&|m| m.worst_site = 0.1), 1);
        assert_eq!(spoil(&|m| m.imbalance = 0.1), 1);
        assert_eq!(judge(End::Converges, Err("no bases")), 1);
        assert_eq!(judge(End::Refused("of matter"), Ok(found)), 1);
        assert_eq!(judge(End::Refused("of matter"), Err("no sweeps")), 1);
    }

    #[test]
    fn a_wrong_end_is_a_fault() {
        let [physical, paper] = tables().map(|mut table| {
            let tree = table.outcomes.next().expect("a first case");
            assert!(tree.name.starts_with("a tree"), "{}", tree.name);
            tree
        });
        let found = physical.measured.as_ref().unwrap();
        assert_eq!((found.compared, found.suns_rms), (4, None));
        wrong_ends_are_faults(physical, &ordinates::extremes::LIMITS, |m| {
            (m.relative_l2, m.error_estimate) = (9e-3, 1e-3);
        });
        wrong_ends_are_faults(paper, &lattice::extremes::LIMITS, |m| m.error_estimate = 0.0);
    }
}
