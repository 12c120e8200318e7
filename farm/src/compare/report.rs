//! What a comparison of two libraries found, and its verdict.

use std::cmp::Ordering;
use std::path::PathBuf;

use serde::Serialize;

/// Comparison of two libraries. It is what `--json` prints (cli/schema/library-diff.json).
#[derive(Debug, Clone, PartialEq, Serialize)]
pub struct Comparison {
    /// Folder or file before.
    pub old: String,
    /// Folder or file now.
    pub new: String,
    /// Largest rms difference that passes, as a share of the mean light; `None`: everything does.
    pub fail_above: Option<f64>,
    /// Whether no species fails.
    pub passes: bool,
    /// Number of species of each state, and of those that fail.
    pub count: Count,
    /// Species of both: those whose light cannot be compared, those that changed, the worst first, and the others.
    pub species: Vec<SpeciesComparison>,
}

/// Number of species.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default, Serialize)]
pub struct Count {
    /// Species of the same bytes.
    pub unchanged: usize,
    /// Species of other bytes.
    pub changed: usize,
    /// Species that are new.
    pub added: usize,
    /// Species that are gone.
    pub removed: usize,
    /// Species beyond the tolerance.
    pub failed: usize,
}

/// State of a species.
#[derive(Debug, Clone, Copy, PartialEq, Eq, PartialOrd, Ord, Serialize)]
#[serde(rename_all = "lowercase")]
pub enum State {
    /// Has other bytes.
    Changed,
    /// Is in the old library alone.
    Removed,
    /// Is in the new library alone.
    Added,
    /// Has equal bytes.
    Unchanged,
}

/// One species.
#[derive(Debug, Clone, PartialEq, Serialize)]
pub struct SpeciesComparison {
    /// Name of the species.
    pub name: String,
    /// State of the species.
    pub state: State,
    /// Why it is beyond the tolerance.
    pub failure: Option<String>,
    /// Why the lights cannot be compared.
    pub incomparable: Option<String>,
    /// Difference of the light of a species that changed.
    pub light: Option<LightChange>,
    /// Sentences on what else differs: lattice, bounds, settings of the light.
    pub differs: Vec<String>,
    /// Pictures before and after, where both have some.
    #[serde(skip)]
    pub pictures: Option<[PathBuf; 2]>,
}

/// Difference of light at the plant's sites, as shares of the mean light before.
#[derive(Debug, Clone, PartialEq, Serialize)]
pub struct LightChange {
    /// Root mean square.
    pub rms: f64,
    /// No more than this at 99 of 100 samples.
    pub p99: f64,
    /// Mean; above 0 where the light became brighter.
    pub mean: f64,
    /// Number of points.
    pub points: usize,
    /// The largest.
    pub worst: Worst,
}

/// The largest difference.
#[derive(Debug, Clone, PartialEq, Serialize)]
pub struct Worst {
    /// Point of the model at rest, metres.
    pub point_m: [f32; 3],
    /// Azimuth and elevation of the sun, degrees; `None` is the sky.
    pub sun_deg: Option<[f64; 2]>,
    /// Name of the band.
    pub band: String,
    /// Light before.
    pub old: f32,
    /// Light now.
    pub new: f32,
    /// Magnitude of the difference, as a share of the mean light.
    pub share: f64,
}

impl SpeciesComparison {
    pub(super) fn new(name: String, state: State) -> SpeciesComparison {
        SpeciesComparison {
            name,
            state,
            failure: None,
            incomparable: None,
            light: None,
            differs: Vec::new(),
            pictures: None,
        }
    }

    /// Says why it fails, if it does.
    fn judged(self, fail_above: Option<f64>) -> SpeciesComparison {
        let failure = fail_above.and_then(|most| match (self.state, &self.incomparable, &self.light) {
            (State::Removed, ..) => Some("the species is gone".to_owned()),
            (State::Changed, Some(reason), _) => Some(format!("the light cannot be compared: {reason}")),
            (State::Changed, None, Some(light)) if light.rms > most => {
                Some(format!("the light differs by {} rms, above {}", percent(light.rms), percent(most)))
            }
            _ => None,
        });
        SpeciesComparison { failure, ..self }
    }

    /// By what is worse: light that cannot be compared, then the larger difference, then the name.
    fn order(&self, other: &SpeciesComparison) -> Ordering {
        let rank = |one: &SpeciesComparison| (one.state, one.incomparable.is_none());
        let rms = |one: &SpeciesComparison| one.light.as_ref().map_or(0.0, |light| light.rms);
        let by_rank = rank(self).cmp(&rank(other));
        by_rank.then(rms(other).total_cmp(&rms(self))).then_with(|| self.name.cmp(&other.name))
    }

    /// A sentence for people, without the name.
    pub fn told(&self) -> String {
        let differs: String = self.differs.iter().map(|one| format!("; {one}")).collect();
        match (self.state, &self.incomparable, &self.light) {
            (State::Unchanged, ..) => "the same bytes".to_owned(),
            (State::Added, ..) => "is new".to_owned(),
            (State::Removed, ..) => "is gone".to_owned(),
            (State::Changed, Some(reason), _) => format!("light cannot be compared: {reason}{differs}"),
            (State::Changed, None, Some(light)) => format!("{}{differs}", light.told()),
            (State::Changed, None, None) => format!("other bytes{differs}"),
        }
    }
}

impl LightChange {
    fn told(&self) -> String {
        let LightChange { rms, p99, mean, worst, .. } = self;
        if worst.share == 0.0 {
            return "other bytes, the same light".to_owned();
        }
        let Worst { point_m: [x, y, z], sun_deg, band, old, new, share } = worst;
        format!(
            "light differs by {} rms, {} at the 99th percentile, {}{} in the mean; worst {}: {band} {old:.4} -> \
             {new:.4} at {x:.3} {y:.3} {z:.3} m under {}",
            percent(*rms),
            percent(*p99),
            if *mean > 0.0 { "+" } else { "" },
            percent(*mean),
            percent(*share),
            shown_sun(*sun_deg)
        )
    }
}

impl Comparison {
    /// Judges species, and puts the worst first.
    pub(super) fn of(
        [old, new]: [String; 2],
        fail_above: Option<f64>,
        species: Vec<SpeciesComparison>,
    ) -> Comparison {
        let mut species: Vec<SpeciesComparison> =
            species.into_iter().map(|one| one.judged(fail_above)).collect();
        species.sort_by(SpeciesComparison::order);
        let mut count = Count::default();
        for one in &species {
            *match one.state {
                State::Unchanged => &mut count.unchanged,
                State::Changed => &mut count.changed,
                State::Added => &mut count.added,
                State::Removed => &mut count.removed,
            } += 1;
            count.failed += usize::from(one.failure.is_some());
        }
        Comparison { old, new, fail_above, passes: count.failed == 0, count, species }
    }

    /// One sentence on all.
    pub fn summary(&self) -> String {
        let Count { unchanged, changed, added, removed, failed } = self.count;
        let verdict = self
            .fail_above
            .map_or(String::new(), |most| format!("; {failed} fail, with a tolerance of {}", percent(most)));
        format!("{changed} changed, {removed} removed, {added} added, {unchanged} unchanged{verdict}")
    }
}

/// A light as it is told.
pub(super) fn shown_sun(sun_deg: Option<[f64; 2]>) -> String {
    sun_deg.map_or("the sky".to_owned(), |[azimuth, elevation]| format!("the sun at {azimuth},{elevation}"))
}

/// A share as a percentage.
pub fn percent(share: f64) -> String {
    let percent = 100.0 * share;
    match percent.abs() {
        0.0 => "0 %".to_owned(),
        small if small < 0.01 => format!("{percent:.1e} %"),
        _ => format!("{percent:.2} %"),
    }
}
