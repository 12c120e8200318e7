//! Solvers at the ends of their ranges: what the tables of [`lattice`](crate::lattice::extremes) and
//! [`ordinates`](crate::ordinates::extremes) share.
//!
//! `flb doctor --extremes` prints both tables, docs/extremes.md keeps them. Their numbers do not depend on the machine.

use std::fmt::Display;

/// End that a solve must have.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum End {
    /// Every solve converges.
    Converges,
    /// No solve converges, and the solver says so and ends early.
    GivesUp,
    /// Refused, with these words in the reason.
    Refused(&'static str),
}

/// A case and how it went.
pub struct Outcome<M, E> {
    /// Name of the case.
    pub name: &'static str,
    /// The numbers, or why the input was refused.
    pub measured: Result<M, E>,
    /// Faults of the outcome; empty if all is as it must be.
    pub faults: Vec<String>,
}

impl<M, E: Display> Outcome<M, E> {
    /// Reason of a refusal.
    pub fn refused(&self) -> Option<String> {
        self.measured.as_ref().err().map(ToString::to_string)
    }

    /// The faults, or that there are none.
    pub(crate) fn verdict(&self) -> String {
        if self.faults.is_empty() { "as it must".to_owned() } else { self.faults.join("; ") }
    }
}

/// Faults of an end; `of` finds those of the numbers where there are some and should be.
pub(crate) fn faults<M, E: Display>(
    end: End,
    measured: &Result<M, E>,
    of: impl FnOnce(&M, &mut Faults),
) -> Vec<String> {
    let mut faults = Faults(Vec::new());
    match (measured, end) {
        (Err(error), End::Refused(words)) => {
            faults.expect(error.to_string().contains(words), || {
                format!("refused without \"{words}\": {error}")
            });
        }
        (Err(error), _) => faults.0.push(format!("refused: {error}")),
        (Ok(_), End::Refused(words)) => faults.0.push(format!("not refused (\"{words}\" expected)")),
        (Ok(found), _) => of(found, &mut faults),
    }
    faults.0
}

/// Faults of numbers.
pub(crate) struct Faults(Vec<String>);

impl Faults {
    /// Expects light that is finite and not below 0.
    pub(crate) fn expect_light(&mut self, [low, high]: [f32; 2]) {
        self.expect(low >= 0.0 && high.is_finite(), || format!("light from {low} to {high}"));
    }

    /// Expects that none of the solves converged where they are to be given up, else all.
    pub(crate) fn expect_converged(&mut self, end: End, converged: usize, solves: usize) {
        let expected = if end == End::GivesUp { 0 } else { solves };
        self.expect(converged == expected, || {
            format!("{converged} of {solves} converged, {expected} expected")
        });
    }

    /// Expects numbers up to their limits.
    pub(crate) fn expect_at_most<const N: usize>(&mut self, limits: [(&str, f64, f64); N]) {
        for (name, value, most) in limits {
            self.expect(value <= most, || format!("{name} {value:.1e}, at most {most:.0e} expected"));
        }
    }

    fn expect(&mut self, holds: bool, fault: impl FnOnce() -> String) {
        if !holds {
            self.0.push(fault());
        }
    }
}

/// The smallest and the largest of some numbers; NaN if any is not finite.
pub(crate) fn range_of(numbers: impl Iterator<Item = f32>) -> [f32; 2] {
    numbers.fold([f32::MAX, f32::MIN], |[low, high], number| match number.is_finite() {
        // A NaN stays: `min` and `max` would drop it.
        true if low.is_finite() => [low.min(number), high.max(number)],
        _ => [f32::NAN; 2],
    })
}

/// A message whose numbers of hundreds of digits are cut: they say nothing.
pub(crate) fn short(message: &str) -> String {
    let word = |word: &str| match word.len() {
        0..=24 => word.to_owned(),
        _ => format!("{}...", &word[..word.floor_char_boundary(12)]),
    };
    message.split(' ').map(word).collect::<Vec<_>>().join(" ")
}

#[cfg(test)]
mod tests {
    use crate::{lattice, ordinates};

    const DOCS_HEAD: &str = "\
# The solvers at the extremes

Written and checked by a test; `flb doctor --extremes` prints it.

## The model `physical`
";

    /// `FLB_WRITE_DOCS=1` writes the tables anew.
    #[test]
    fn every_extreme_ends_as_the_docs_say() {
        let (mut faults, mut rows) = (Vec::new(), [String::new(), String::new()]);
        for case in ordinates::extremes::cases() {
            let outcome = ordinates::extremes::run(&case);
            rows[0] += &ordinates::extremes::table::row(&outcome);
            if !outcome.faults.is_empty() {
                faults.push(format!("{}: {:?}: {:?}", outcome.name, outcome.faults, outcome.measured));
            }
        }
        for case in lattice::extremes::cases() {
            let outcome = lattice::extremes::run(&case);
            rows[1] += &lattice::extremes::table::row(&outcome);
            if !outcome.faults.is_empty() {
                faults.push(format!("{}: {:?}: {:?}", outcome.name, outcome.faults, outcome.measured));
            }
        }
        let [physical, paper] = rows;
        let text = format!(
            "{DOCS_HEAD}\n{}\n{}{physical}\n## The model `paper`\n\n{}\n{}{paper}",
            ordinates::extremes::table::legend(),
            ordinates::extremes::table::HEADER,
            lattice::extremes::table::legend(),
            lattice::extremes::table::HEADER,
        );
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
}
