//! What light cannot be complete without: block maps, averages, extinctions.

use std::borrow::Cow;

use super::{Need, Residency, SpeciesNeed, UnitId, UnitKind, Units};

/// What of a species is essential to a frame, by what it serves.
#[derive(Debug, Clone, Copy, PartialEq, Eq, PartialOrd, Ord)]
pub enum Essential {
    /// The block map, and averages of the sky's base.
    Sky,
    /// Averages of the bases of the sun, and the extinction where suns have a near beam.
    Sun,
}

/// What a species lacks for want of memory.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub struct Lack {
    /// Number of the species.
    pub species: usize,
    /// What its light has not.
    pub essential: Essential,
    /// Memory that the budget is short of it.
    pub bytes: u64,
}

impl Lack {
    /// The same for people: "oak: the sun's light needs 1.1 MB more".
    pub fn describe(&self, species_name: &str) -> String {
        let what = match self.essential {
            Essential::Sky => "the light",
            Essential::Sun => "the sun's light",
        };
        // Never less than it is.
        let megabytes = (self.bytes as f64 / 1e5).ceil() / 10.0;
        format!("{species_name}: {what} needs {megabytes:.1} MB more; the plant's mean light stands in")
    }
}

/// Essential units of a species that serve one thing.
#[derive(Debug, Clone, Copy)]
pub(super) struct Group {
    pub species: usize,
    pub essential: Essential,
    /// Memory of all its units.
    pub bytes: u64,
}

/// What a unit of a species serves that is essential now; `None` for what light can be complete without.
pub(super) fn serves(
    residency: &Residency,
    species: usize,
    seen: &SpeciesNeed,
    unit: UnitId,
) -> Option<Essential> {
    let unit = residency.units.get(unit);
    match unit.kind {
        UnitKind::Shared => Some(Essential::Sky),
        UnitKind::Averages { base } if !seen.is_now[base as usize] => None,
        UnitKind::Averages { base } => {
            let item = residency.units.bases(species)[base as usize].item;
            Some(if item == 0 { Essential::Sky } else { Essential::Sun })
        }
        UnitKind::Extinction => residency.has_sun_now(species, seen).then_some(Essential::Sun),
        UnitKind::Detail { .. } => None,
    }
}

/// Groups of what is seen, those of the sky first, then those of the sun by the pixels that show them.
pub(super) fn of_need(residency: &Residency, need: &Need) -> impl Iterator<Item = Group> {
    let mut groups = Vec::new();
    for (species, seen) in need.species.iter().enumerate().filter(|(_, seen)| seen.pixels > 0.0) {
        for essential in [Essential::Sky, Essential::Sun] {
            let units = residency.units.of_species(species);
            let of_group = units.filter(|unit| serves(residency, species, seen, *unit) == Some(essential));
            let bytes: u64 = of_group.map(|unit| residency.units.get(unit).memory_bytes).sum();
            if bytes > 0 {
                groups.push((Group { species, essential, bytes }, seen.pixels));
            }
        }
    }
    groups.sort_by(|(a, of_a), (b, of_b)| {
        a.essential.cmp(&b.essential).then(of_b.total_cmp(of_a)).then(a.species.cmp(&b.species))
    });
    groups.into_iter().map(|(group, _)| group)
}

/// Whether a species is of harmonics, of which all are needed.
fn has_near_beam(units: &Units, species: usize) -> bool {
    units.of_species(species).any(|unit| units.get(unit).kind == UnitKind::Extinction)
}

/// The need where the sky's light stands in for a sun's that has no room: it has the pixels of that.
pub(super) fn with_stand_ins<'n>(units: &Units, need: &'n Need, lacks: &[Lack]) -> Cow<'n, Need> {
    let mut need = Cow::Borrowed(need);
    for lack in lacks.iter().filter(|lack| lack.essential == Essential::Sun) {
        let sky = units.bases(lack.species).iter().position(|base| base.item == 0);
        if let (Some(sky), true) = (sky, has_near_beam(units, lack.species)) {
            let seen = &mut need.to_mut().species[lack.species];
            for weights in [&mut seen.bases, &mut seen.detail] {
                weights[sky] = weights.iter().copied().fold(0.0, f32::max);
            }
        }
    }
    need
}

/// What has no room within the budget, and whether a unit is to be left out for it: harmonics of which one is missing
/// are no light, so that their memory is better used for others.
pub(super) fn without_room(
    residency: &Residency,
    need: &Need,
) -> (Vec<Lack>, impl Fn(&Units, UnitId) -> bool + use<>) {
    let mut room = residency.settings.budget_bytes;
    let mut lacks: Vec<Lack> = Vec::new();
    for Group { species, essential, bytes } in of_need(residency, need) {
        // All stands on the block map.
        if lacks.iter().any(|lack| (lack.species, lack.essential) == (species, Essential::Sky)) {
            continue;
        }
        match room.checked_sub(bytes) {
            Some(left) => room = left,
            None => lacks.push(Lack { species, essential, bytes: bytes - room }),
        }
    }
    let needs_all =
        |lack: &&Lack| lack.essential == Essential::Sun && has_near_beam(&residency.units, lack.species);
    let without_sun = lacks.iter().filter(needs_all);
    let without_sun: Vec<usize> = without_sun.map(|lack| lack.species).collect();
    let is_left_out = move |units: &Units, unit: UnitId| {
        let unit = units.get(unit);
        without_sun.contains(&(unit.species as usize))
            && match unit.kind {
                UnitKind::Shared => false,
                UnitKind::Extinction => true,
                UnitKind::Averages { base } | UnitKind::Detail { base, .. } => {
                    units.bases(unit.species as usize)[base as usize].item != 0
                }
            }
    };
    (lacks, is_left_out)
}
