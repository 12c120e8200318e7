//! What light cannot be complete without: block maps, averages, extinctions.

use std::borrow::Cow;

use flb_format::Container;

use super::{Need, Residency, SpeciesNeed, UnitId, UnitKind, Units};

/// Essential units of a species, without which a frame's light is incomplete, by the light that they serve.
#[derive(Debug, Clone, Copy, PartialEq, Eq, PartialOrd, Ord)]
pub enum Essential {
    /// The block map, and averages of the sky's base.
    Sky,
    /// Averages of the bases of the sun, and the extinction where suns have a near beam.
    Sun,
}

/// Memory that a species lacks.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub struct Lack {
    /// Number of the species.
    pub species: usize,
    /// Light that the species cannot show.
    pub essential: Essential,
    /// Memory that the budget is short of it.
    pub bytes: u64,
}

impl Lack {
    /// Describes the lack for people, of a species of the container: "oak: the sun's light needs 1.1 MB more; ...".
    ///
    /// # Panics
    /// If the container has no such species.
    pub fn describe(&self, container: &Container) -> String {
        let name = &container.species()[self.species].meta.name;
        let what = match self.essential {
            Essential::Sky => "the light",
            Essential::Sun => "the sun's light",
        };
        // Never less than it is.
        let megabytes = (self.bytes as f64 / 1e5).ceil() / 10.0;
        format!("{name}: {what} needs {megabytes:.1} MB more; the plant's mean light stands in")
    }
}

/// Essential units of a species that serve one thing.
#[derive(Debug)]
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

/// Groups of what is seen, those of the sky first, then those of the sun by the pixels that show them. What was given
/// up wants no memory; a species whose block map was given up wants none at all.
pub(super) fn of_need(residency: &Residency, need: &Need) -> Vec<Group> {
    let mut groups = Vec::new();
    for (species, seen) in need.seen() {
        let mut both =
            [Essential::Sky, Essential::Sun].map(|essential| Group { species, essential, bytes: 0 });
        let is_given_up = |unit: &UnitId| residency.records[unit.index()].is_given_up();
        let mut units = residency.units.coarse(species).peekable();
        if units.peek().is_some_and(is_given_up) {
            continue;
        }
        for unit in units.filter(|unit| !is_given_up(unit)) {
            if let Some(essential) = serves(residency, species, seen, unit) {
                both[essential as usize].bytes += residency.units.get(unit).memory_bytes;
            }
        }
        groups.extend(both.into_iter().filter(|group| group.bytes > 0));
    }
    let pixels = |group: &Group| need.species[group.species].pixels;
    groups.sort_by(|a, b| {
        a.essential.cmp(&b.essential).then(pixels(b).total_cmp(&pixels(a))).then(a.species.cmp(&b.species))
    });
    groups
}

/// What has no room within the budget.
pub(super) fn lacks(residency: &Residency, need: &Need) -> Vec<Lack> {
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
    lacks
}

/// Species of harmonics that lack their sun's light: harmonics of which one is missing are no light, so that none is
/// loaded, and their memory serves others.
fn without_sun<'l>(units: &'l Units, lacks: &'l [Lack]) -> impl Iterator<Item = usize> + 'l {
    let of_sun = lacks.iter().filter(|lack| lack.essential == Essential::Sun);
    of_sun.map(|lack| lack.species).filter(|species| units.extinction(*species).is_some())
}

/// Whether a unit is left out: of a species that lacks its sky's light, since all stands on the block map, and as
/// [`without_sun`] says.
pub(super) fn is_left_out(units: &Units, lacks: &[Lack], unit: UnitId) -> bool {
    let unit = units.get(unit);
    let species = unit.species as usize;
    let is_of_sun = match unit.kind {
        UnitKind::Shared => false,
        UnitKind::Extinction => true,
        UnitKind::Averages { base } | UnitKind::Detail { base, .. } => {
            units.bases(species)[base as usize].item != 0
        }
    };
    lacks.iter().any(|lack| (lack.species, lack.essential) == (species, Essential::Sky))
        || is_of_sun && without_sun(units, lacks).any(|other| other == species)
}

/// The need where the sky's light stands in for a sun's that has no room: it has the pixels of that.
pub(super) fn with_stand_ins<'n>(units: &Units, need: &'n Need, lacks: &[Lack]) -> Cow<'n, Need> {
    let mut need = Cow::Borrowed(need);
    for species in without_sun(units, lacks) {
        if let Some(sky) = units.bases(species).iter().position(|base| base.item == 0) {
            let seen = &mut need.to_mut().species[species];
            for weights in [&mut seen.bases, &mut seen.detail] {
                weights[sky] = weights.iter().copied().fold(0.0, f32::max);
            }
        }
    }
    need
}
