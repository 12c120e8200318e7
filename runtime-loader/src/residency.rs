//! Which units of a library should be in memory, frame by frame: a state machine without files, threads or a GPU.
//!
//! ```text
//! Units (what there is)   Needs (what the frame shows)
//!            └──────────┬───────────┘
//!                 Residency::plan ──> LoadPlan: evictions, requests
//! loaded, lost, failed ──┘
//! ```
//!
//! The best set within the budget is found anew for every frame, greedily: what light cannot be complete without
//! (block maps, averages of the bases that have weight, extinctions), then averages of bases that will have weight
//! soon, then pages of detail by the error in the picture that each removes per byte. What is loaded counts [`HELD`]
//! times as much as what is not, so that a sun at the edge of a triangle does not make two bases take turns; and what
//! is not of the set stays until its memory is wanted.

mod essential;
mod need;
mod units;

pub use essential::{Essential, Lack};
pub use need::{Need, NeedFinder, Placed, SpeciesNeed};
pub use units::{BaseUnits, Runs, Unit, UnitId, UnitKind, Units};

use std::sync::Arc;

/// Factor on the worth of a loaded unit over one that would have to be loaded.
pub const HELD: f32 = 1.5;
/// Times that a unit may fail before it is given up.
pub const ATTEMPTS: u8 = 5;
/// The last tier of what light cannot be complete without: block maps come before it.
const ESSENTIAL_TIER: u8 = 1;
/// Frames before the second attempt; the pause doubles with each.
const PAUSE_FRAMES: u64 = 15;

/// Limits of memory and of requests on their way.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub struct ResidencySettings {
    /// Largest amount of memory of what is loaded and of what is on its way, bytes.
    pub budget_bytes: u64,
    /// Largest number of units on their way at once.
    pub max_requests: usize,
    /// Largest number of bytes of the file on their way at once; one unit may always go.
    pub max_request_bytes: u64,
}

impl Default for ResidencySettings {
    /// 32 MiB, 64 units and 2 MiB on their way.
    fn default() -> ResidencySettings {
        ResidencySettings { budget_bytes: 32 << 20, max_requests: 64, max_request_bytes: 2 << 20 }
    }
}

/// Units that a frame drops and requests.
#[derive(Debug, Clone, Default, PartialEq)]
pub struct LoadPlan {
    /// Units to be dropped before anything is requested, pages before what they refine.
    pub evictions: Vec<UnitId>,
    /// Units to be read, the most urgent first.
    pub requests: Vec<UnitId>,
    /// Share of the worth of everything that the frame could use that is loaded, 0 to 1.
    pub quality: f32,
    /// Whether block maps, averages and extinctions of all that is seen and has weight are loaded, so that nothing
    /// stands in for light. At a budget below [`Residency::least_budget`] it never is.
    pub is_complete: bool,
    /// Whether all that the frame could use and that fits is loaded: while what is seen and the budget stay, no more
    /// comes.
    pub is_final: bool,
    /// Memory that the plan cannot be complete without and has no room for, by species.
    pub lacks: Vec<Lack>,
}

/// Where a unit is.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
enum State {
    Absent,
    OnItsWay,
    Loaded,
}

/// A unit's history.
#[derive(Debug, Clone, Copy)]
struct Record {
    state: State,
    failures: u8,
    /// Not before this frame.
    paused_until: u64,
    /// The last frame that could use it.
    used: u64,
}

impl Record {
    fn is_given_up(&self) -> bool {
        self.failures >= ATTEMPTS
    }
}

/// A unit that a frame could use.
#[derive(Debug, Clone, Copy)]
struct Candidate {
    unit: UnitId,
    tier: u8,
    /// Squared error in the picture that it removes.
    worth: f32,
    /// The same per byte, [`HELD`] times where it is loaded.
    rank: f32,
}

/// Units that are loaded or on their way. Invariant: their memory is at most the budget.
#[derive(Debug)]
pub struct Residency {
    units: Arc<Units>,
    settings: ResidencySettings,
    records: Vec<Record>,
    /// `[species][base]`: largest value of a base, once its averages are loaded; 1 before.
    peaks: Vec<Vec<f32>>,
    /// `[species]`, once its block map is loaded.
    runs: Vec<Option<Runs>>,
    frame: u64,
    loaded_bytes: u64,
    requested: usize,
    /// Memory of what is on its way.
    requested_bytes: u64,
    /// Bytes of the file on their way.
    reading_bytes: u64,
}

impl Residency {
    /// Makes a residency in which nothing is loaded yet.
    pub fn new(units: Arc<Units>, settings: ResidencySettings) -> Residency {
        let fresh = Record { state: State::Absent, failures: 0, paused_until: 0, used: 0 };
        let peaks = (0..units.species()).map(|species| vec![1.0; units.bases(species).len()]).collect();
        Residency {
            records: vec![fresh; units.len()],
            peaks,
            runs: vec![None; units.species()],
            units,
            settings,
            frame: 0,
            loaded_bytes: 0,
            requested: 0,
            requested_bytes: 0,
            reading_bytes: 0,
        }
    }

    /// The catalogue.
    pub fn units(&self) -> &Arc<Units> {
        &self.units
    }

    /// The limits.
    pub fn settings(&self) -> &ResidencySettings {
        &self.settings
    }

    /// A new budget; the next plan keeps it, but for what is on its way by then, which is dropped when it comes.
    pub fn set_budget(&mut self, budget_bytes: u64) {
        self.settings.budget_bytes = budget_bytes;
    }

    /// Memory of what is loaded, by the catalogue's upper bounds.
    pub fn loaded_bytes(&self) -> u64 {
        self.loaded_bytes
    }

    /// Units on their way.
    pub fn requested(&self) -> usize {
        self.requested
    }

    /// Whether a unit is loaded.
    pub fn is_loaded(&self, unit: UnitId) -> bool {
        self.records[unit.index()].state == State::Loaded
    }

    /// Units that failed too often.
    pub fn given_up(&self) -> impl Iterator<Item = UnitId> {
        (0..).zip(&self.records).filter(|(_, record)| record.is_given_up()).map(|(i, _)| UnitId(i))
    }

    /// The largest value of a base, by which its pages' priorities are scaled (SPEC.md, section 5.1).
    pub fn set_peak(&mut self, species: usize, base: usize, peak: f32) {
        self.peaks[species][base] = peak;
    }

    /// Sets the boxes of a species' blocks, by which pages outside the view are left for later.
    pub fn set_runs(&mut self, species: usize, runs: Runs) {
        self.runs[species] = Some(runs);
    }

    /// Chooses the units to drop and to read for a frame. A unit that it names is from then on dropped, or on its way
    /// until [`Residency::loaded`], [`Residency::lost`] or [`Residency::failed`] tells its fate.
    pub fn plan(&mut self, need: &Need) -> LoadPlan {
        self.frame += 1;
        let lacks = essential::lacks(self, need);
        let need = &*essential::with_stand_ins(&self.units, need, &lacks);
        let (mut candidates, given_up) = self.candidates(need);
        candidates.sort_unstable_by(|a, b| {
            a.tier.cmp(&b.tier).then(b.rank.total_cmp(&a.rank)).then(a.unit.cmp(&b.unit))
        });
        let mut plan = LoadPlan { is_complete: true, is_final: true, ..LoadPlan::default() };
        let (mut wanted, mut there) = (given_up, 0.0);
        let mut wish = Wish::new(self);
        for candidate in &candidates {
            let index = candidate.unit.index();
            self.records[index].used = self.frame;
            wanted += f64::from(candidate.worth);
            let state = self.records[index].state;
            if state == State::Loaded {
                there += f64::from(candidate.worth);
            } else {
                plan.is_complete &= candidate.tier > ESSENTIAL_TIER;
            }
            if !essential::is_left_out(&self.units, &lacks, candidate.unit) {
                wish.offer(&self.units, candidate.unit);
            }
        }
        plan.lacks = lacks;
        plan.quality = if wanted > 0.0 { (there / wanted) as f32 } else { 1.0 };
        self.evict_over_budget(&wish, &mut plan);
        self.request(&candidates, &wish, &mut plan);
        plan
    }

    /// Memory below which no plan for what is seen is complete: block maps, averages and extinctions.
    pub fn least_budget(&self, need: &Need) -> u64 {
        essential::of_need(self, need).iter().map(|group| group.bytes).sum()
    }

    /// Whether a sun shines on what is seen of a species.
    fn has_sun_now(&self, species: usize, seen: &SpeciesNeed) -> bool {
        self.units.bases(species).iter().zip(&seen.is_now).any(|(base, now)| base.item != 0 && *now)
    }

    /// Whether a sun shines on what is seen of a species, or may soon.
    fn has_sun(&self, species: usize, seen: &SpeciesNeed) -> bool {
        let may_soon = |base: usize| self.units.bases(species)[base].item != 0 && seen.bases[base] > 0.0;
        self.has_sun_now(species, seen) || (0..seen.bases.len()).any(may_soon)
    }

    /// The units that the frame could use, and the worth of those that were given up.
    fn candidates(&self, need: &Need) -> (Vec<Candidate>, f64) {
        let (mut candidates, mut given_up) = (Vec::new(), 0.0);
        for (species, seen) in need.seen() {
            for unit in self.units.of_species(species) {
                let record = &self.records[unit.index()];
                let worth = self.worth(species, seen, unit);
                if record.is_given_up() {
                    given_up += f64::from(worth);
                } else if worth > 0.0 {
                    let bytes = self.units.get(unit).memory_bytes.max(1) as f32;
                    let held = if record.state == State::Absent { 1.0 } else { HELD };
                    let (tier, rank) = (self.tier(species, seen, unit), held * worth / bytes);
                    candidates.push(Candidate { unit, tier, worth, rank });
                }
            }
        }
        (candidates, given_up)
    }

    /// Units of a lower tier are loaded first, whatever they are worth: block maps, what else is essential now, what is
    /// of use soon, detail.
    fn tier(&self, species: usize, seen: &SpeciesNeed, unit: UnitId) -> u8 {
        match self.units.get(unit).kind {
            UnitKind::Shared => 0,
            _ if essential::serves(self, species, seen, unit).is_some() => ESSENTIAL_TIER,
            UnitKind::Detail { .. } => ESSENTIAL_TIER + 2,
            _ => ESSENTIAL_TIER + 1,
        }
    }

    /// Squared error in the picture that a unit removes: pixels times weight squared, times the mean square over the
    /// base's texels of what it adds.
    fn worth(&self, species: usize, seen: &SpeciesNeed, id: UnitId) -> f32 {
        let unit = self.units.get(id);
        let per_texel = |base: usize| {
            let peak = self.peaks[species][base];
            // At least a little, so that pages of nothing come last and not never.
            unit.priority.max(1e-6) / self.units.texels(species) * peak * peak
        };
        match unit.kind {
            UnitKind::Shared => seen.pixels,
            UnitKind::Extinction => {
                if self.has_sun(species, seen) {
                    seen.pixels
                } else {
                    0.0
                }
            }
            UnitKind::Averages { base } => seen.bases[base as usize] * per_texel(base as usize),
            UnitKind::Detail { base, .. } => {
                let worth = seen.detail[base as usize] * per_texel(base as usize);
                match (&seen.windows, &self.runs[species]) {
                    (Some(windows), Some(runs)) if worth > 0.0 => {
                        let [min, max] = self.units.box_m(id, runs);
                        if windows.iter().any(|window| window.sees_box(min, max)) { worth } else { 0.0 }
                    }
                    _ => worth,
                }
            }
        }
    }

    /// Evicts while more is loaded than the budget allows, as after [`Residency::set_budget`].
    fn evict_over_budget(&mut self, wish: &Wish, plan: &mut LoadPlan) {
        if self.loaded_bytes + self.requested_bytes > self.settings.budget_bytes {
            let over = self.loaded_bytes + self.requested_bytes - self.settings.budget_bytes;
            let mut spare = self.spare(wish);
            self.free(over, &mut spare, plan);
        }
    }

    fn request(&mut self, candidates: &[Candidate], wish: &Wish, plan: &mut LoadPlan) {
        let mut spare: Option<Vec<UnitId>> = None;
        for candidate in candidates.iter().filter(|candidate| wish.has(candidate.unit)) {
            let record = self.records[candidate.unit.index()];
            if record.state != State::Absent {
                plan.is_final &= record.state == State::Loaded;
                continue;
            }
            plan.is_final = false;
            let unit = *self.units.get(candidate.unit);
            let stands = self.units.stands_on(candidate.unit).is_none_or(|below| match unit.kind {
                // Pages may come before the averages that they refine.
                UnitKind::Detail { .. } => self.records[below.index()].state != State::Absent,
                _ => self.is_loaded(below),
            });
            let is_room = self.requested == 0
                || self.reading_bytes + unit.stored_bytes <= self.settings.max_request_bytes;
            if !stands
                || record.paused_until > self.frame
                || self.requested >= self.settings.max_requests
                || !is_room
            {
                continue;
            }
            let after = self.loaded_bytes + self.requested_bytes + unit.memory_bytes;
            if after > self.settings.budget_bytes {
                let over = after - self.settings.budget_bytes;
                let spare = spare.get_or_insert_with(|| self.spare(wish));
                if !self.free(over, spare, plan) {
                    continue;
                }
            }
            self.records[candidate.unit.index()].state = State::OnItsWay;
            self.requested += 1;
            self.requested_bytes += unit.memory_bytes;
            self.reading_bytes += unit.stored_bytes;
            plan.requests.push(candidate.unit);
        }
    }

    /// What is loaded and not wished for, in the order of eviction from the end: what was of use longest ago, and of
    /// those pages first.
    fn spare(&self, wish: &Wish) -> Vec<UnitId> {
        let mut spare: Vec<UnitId> =
            self.units.all().filter(|unit| self.is_loaded(*unit) && !wish.has(*unit)).collect();
        let tier = |unit: &UnitId| self.units.get(*unit).tier();
        let used = |unit: &UnitId| self.records[unit.index()].used;
        spare.sort_unstable_by(|a, b| used(b).cmp(&used(a)).then(tier(a).cmp(&tier(b))).then(a.cmp(b)));
        spare
    }

    /// Evicts spare units until `bytes` are free; evicts nothing and says so if they are not enough.
    fn free(&mut self, bytes: u64, spare: &mut Vec<UnitId>, plan: &mut LoadPlan) -> bool {
        let held: u64 = spare
            .iter()
            .filter(|unit| self.is_loaded(**unit))
            .map(|unit| self.units.get(*unit).memory_bytes)
            .sum();
        if held < bytes && self.loaded_bytes + self.requested_bytes <= self.settings.budget_bytes {
            return false;
        }
        let mut left = bytes;
        while left > 0 {
            let Some(unit) = spare.pop() else { return false };
            if self.is_loaded(unit) {
                left = left.saturating_sub(self.evict(unit, plan));
            }
        }
        true
    }

    /// Evicts a unit and all that stands on it, the latter first; returns the bytes.
    fn evict(&mut self, unit: UnitId, plan: &mut LoadPlan) -> u64 {
        let units = Arc::clone(&self.units);
        let mut freed = 0;
        for above in units.standing_on(unit) {
            if self.is_loaded(above) {
                freed += self.evict(above, plan);
            }
        }
        self.records[unit.index()].state = State::Absent;
        let bytes = units.get(unit).memory_bytes;
        self.loaded_bytes -= bytes;
        plan.evictions.push(unit);
        freed + bytes
    }

    fn arrived(&mut self, unit: UnitId) {
        assert_eq!(self.records[unit.index()].state, State::OnItsWay, "{unit:?} was not requested");
        self.requested -= 1;
        self.requested_bytes -= self.units.get(unit).memory_bytes;
        self.reading_bytes -= self.units.get(unit).stored_bytes;
    }

    /// Whether a unit is on its way.
    pub fn is_on_its_way(&self, unit: UnitId) -> bool {
        self.records[unit.index()].state == State::OnItsWay
    }

    /// Whether a unit that came can be kept: not where the budget has shrunk, or the unit that it stands on is gone.
    pub fn can_keep(&self, unit: UnitId) -> bool {
        let stands = self.units.stands_on(unit).is_none_or(|below| self.is_loaded(below));
        // Its own bytes are among those requested.
        stands && self.loaded_bytes + self.requested_bytes <= self.settings.budget_bytes
    }

    /// A requested unit is there.
    ///
    /// # Panics
    /// If the unit was not requested, or cannot be kept.
    pub fn loaded(&mut self, unit: UnitId) {
        assert!(self.can_keep(unit), "{unit:?} cannot be kept");
        self.arrived(unit);
        self.records[unit.index()].state = State::Loaded;
        self.records[unit.index()].failures = 0;
        self.loaded_bytes += self.units.get(unit).memory_bytes;
    }

    /// A requested unit came and is not kept; it may be requested again.
    ///
    /// # Panics
    /// If the unit was not requested.
    pub fn lost(&mut self, unit: UnitId) {
        self.arrived(unit);
        self.records[unit.index()].state = State::Absent;
    }

    /// A requested unit did not come. It is tried again after a pause; returns whether it is given up instead, at once
    /// if the failure is `lasting` (the file itself is wrong there).
    ///
    /// # Panics
    /// If the unit was not requested.
    pub fn failed(&mut self, unit: UnitId, lasting: bool) -> bool {
        self.arrived(unit);
        let record = &mut self.records[unit.index()];
        record.state = State::Absent;
        record.failures = if lasting { ATTEMPTS } else { record.failures + 1 };
        record.paused_until = self.frame + (PAUSE_FRAMES << record.failures.min(ATTEMPTS));
        record.is_given_up()
    }

    /// Whether a unit has failed once since it was there last.
    pub(crate) fn has_failed_once(&self, unit: UnitId) -> bool {
        self.records[unit.index()].failures == 1
    }
}

/// The set that a frame would have loaded: within the budget, and nothing without what it stands on.
struct Wish {
    has: Vec<bool>,
    room: u64,
}

impl Wish {
    fn new(residency: &Residency) -> Wish {
        Wish { has: vec![false; residency.units.len()], room: residency.settings.budget_bytes }
    }

    fn has(&self, unit: UnitId) -> bool {
        self.has[unit.index()]
    }

    fn offer(&mut self, units: &Units, unit: UnitId) {
        let bytes = units.get(unit).memory_bytes;
        let stands = units.stands_on(unit).is_none_or(|below| self.has(below));
        if stands && bytes <= self.room {
            self.room -= bytes;
            self.has[unit.index()] = true;
        }
    }
}

#[cfg(test)]
mod tests;
