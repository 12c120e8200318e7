//! The volumes of one species: which are wanted, and which are shown.

use std::collections::{BTreeMap, BTreeSet};
use std::sync::Arc;

use super::ForestSettings;
use super::room::Wish;
use super::snapshot::Shown;
use super::stand::Stand;
use super::suns::{Extent, Suns};
use super::volumes::{Made, Volumes, Wanted, lit_at};
use crate::light::LightVolume;
use crate::resident::{LightLevel, ResidentSpecies};
use crate::{Daylight, InstanceLight};

/// Part of a step that the sun moves before plants are counted anew.
const AIM: f64 = 0.125;

/// Light of a species.
pub(super) struct Lit {
    /// Those of the volumes that are wanted.
    suns: Suns,
    /// By yaw: upright plants that ask for it.
    upright: BTreeMap<u32, u32>,
    /// By cell of the suns: tilted plants that ask for it.
    tilted: BTreeMap<u32, u32>,
    now: Option<Arc<Volumes>>,
    before: Option<Arc<Volumes>>,
    /// Frames that `now` has been there, as far as it counts.
    age: u16,
    blend_frames: u16,
    /// Frames that nothing of it was seen.
    unseen: u32,
    /// Volumes are being made.
    pub is_awaited: bool,
}

impl Lit {
    pub(super) fn new(settings: &ForestSettings) -> Lit {
        Lit {
            suns: Suns::of([0.0, 1.0, 0.0], settings.yaws),
            upright: BTreeMap::new(),
            tilted: BTreeMap::new(),
            now: None,
            before: None,
            age: 0,
            blend_frames: settings.blend_frames,
            unseen: 0,
            is_awaited: false,
        }
    }

    /// Counts a plant that comes (1) or goes (-1).
    pub(super) fn count(&mut self, stand: Stand, plants: i32) {
        fn count(all: &mut BTreeMap<u32, u32>, places: impl Iterator<Item = (u32, f32)>, plants: i32) {
            for (place, _) in places {
                let count = all.entry(place).or_default();
                *count = count.saturating_add_signed(plants);
                if *count == 0 {
                    all.remove(&place);
                }
            }
        }
        match stand {
            Stand::Upright(turn) => count(&mut self.upright, self.suns.yaws_of(turn), plants),
            Stand::Tilted(_) => count(&mut self.tilted, self.suns.cells(stand, 1), plants),
        }
    }

    /// Takes the suns of the daylight for those of which volumes are wanted, unless some are being made or blended in.
    /// True where tilted plants are to be counted again.
    pub(super) fn aim(&mut self, day: &Daylight, settings: &ForestSettings) -> bool {
        let suns = match &self.now {
            _ if self.is_awaited || !self.is_shown() => return false,
            Some(now) if now.fits(day, settings.step_deg) => now.suns,
            _ if self.suns.are_near(day.towards_sun, AIM * settings.step_deg) => return false,
            _ => Suns::of(day.towards_sun, settings.yaws),
        };
        let is_other = suns != self.suns && !self.tilted.is_empty();
        self.suns = suns;
        if is_other {
            self.tilted.clear();
        }
        is_other
    }

    /// Room that its volumes ask for, where it is seen at so many pixels.
    pub(super) fn wish(&self, species: &ResidentSpecies, pixels: f32) -> Wish {
        let map = species.shared().map(|shared| &shared.map);
        let bytes = map.map_or(0, |map| LightVolume::bytes_of(map, species.bands())) as u64;
        let there = [&self.now, &self.before].into_iter().flatten().map(|volumes| volumes.extent);
        let extent = there.fold(self.suns.extent(self.cells()), Extent::max);
        Wish { bytes, extent, pixels, has_some: self.has_volumes() }
    }

    /// Cells that plants ask for; some twice.
    pub(super) fn cells(&self) -> impl Iterator<Item = u32> {
        let first = self.suns.own * self.suns.yaws;
        self.upright.keys().map(move |yaw| first + yaw).chain(self.tilted.keys().copied())
    }

    /// Whether there are volumes of it.
    pub(super) fn has_volumes(&self) -> bool {
        self.now.is_some()
    }

    /// Drops volumes but for those of every so manieth row and yaw, or all of them.
    pub(super) fn keep(&mut self, stride: Option<u32>) {
        let Some(stride) = stride.filter(|_| self.has_volumes()) else {
            (self.now, self.before) = (None, None);
            return;
        };
        let kept = |volumes: Option<Arc<Volumes>>| {
            let volumes = volumes?;
            let stride = self.stride_by(&volumes.day, stride);
            Volumes::kept(volumes, stride, &self.suns, &self.asked(stride))
        };
        let (now, before) = (kept(self.now.clone()), kept(self.before.clone()));
        self.before = before.filter(|_| now.is_some());
        self.now = now;
    }

    /// Cells of which volumes are wanted, of every so manieth row and yaw.
    fn asked(&self, stride: u32) -> BTreeSet<u32> {
        self.cells().flat_map(|cell| self.suns.around(cell, stride)).collect()
    }

    /// Every how-manieth row and yaw has a volume: one alone without a sun, as all are alike.
    fn stride_by(&self, day: &Daylight, stride: u32) -> u32 {
        if day.sun == 0.0 { self.suns.yaws } else { stride }
    }

    /// A frame passes.
    pub(super) fn pass(&mut self, is_seen: bool, settings: &ForestSettings) {
        self.age = self.age.saturating_add(1).min(settings.blend_frames);
        if self.age == settings.blend_frames {
            self.before = None;
        }
        self.unseen = if is_seen { 0 } else { self.unseen.saturating_add(1) };
        if self.unseen > settings.keep_frames {
            (self.now, self.before) = (None, None);
        }
    }

    /// Volumes that are wanted; `None` where what is there is what is asked for, or as near to it as what is loaded
    /// allows. They are none while others are being made or were not blended in yet.
    pub(super) fn wanted(
        &self,
        species: &ResidentSpecies,
        day: &Daylight,
        settings: &ForestSettings,
        stride: u32,
    ) -> Option<Wanted> {
        if day.sun == 0.0 && day.sky == 0.0 {
            // Of no light at all nothing could be shown that is brighter later.
            return None;
        }
        let fits = |now: &&Arc<Volumes>| now.suns == self.suns && now.fits(day, settings.step_deg);
        let now = self.now.as_ref().filter(fits);
        // Those that can be made, and whether they would be better than what is there.
        let day = now.map_or(Daylight { towards_sun: self.suns.towards_sun, ..*day }, |now| now.day);
        let stride = self.stride_by(&day, stride);
        let cells: Vec<u32> = self
            .asked(stride)
            .into_iter()
            .filter(|cell| {
                let level = lit_at(species, &day, self.suns.sun(*cell)).level();
                level >= LightLevel::Averages && now.is_none_or(|now| now.level(*cell) < Some(level))
            })
            .collect();
        if cells.is_empty() {
            return None;
        }
        let waits = self.is_awaited || !self.is_shown();
        let is_first = self.now.is_none();
        let cells = if waits { Vec::new() } else { cells };
        Some(Wanted { day, suns: self.suns, stride, cells, is_first })
    }

    /// Whether nothing is being blended in.
    pub(super) fn is_shown(&self) -> bool {
        self.now.is_none() || self.age == self.blend_frames
    }

    /// Takes volumes, after which others of the same work come unless they are the last.
    pub(super) fn take(&mut self, made: Option<Made>, is_last: bool) {
        self.is_awaited &= !is_last;
        let Some(volumes) = made.and_then(|made| Volumes::of(made, self.now.as_deref())) else { return };
        let is_first = self.now.is_none();
        let more = self.now.replace(Arc::new(volumes));
        // More of what is being blended in goes on with that.
        if is_first || self.is_shown() {
            (self.before, self.age) = (more, 0);
        }
    }

    /// Memory of the volumes, each counted once.
    pub(super) fn size_bytes(&self) -> usize {
        let mut all: Vec<&Arc<LightVolume>> = [&self.now, &self.before]
            .into_iter()
            .flatten()
            .flat_map(|volumes| volumes.volumes().map(|(_, volume)| volume))
            .collect();
        all.sort_unstable_by_key(|volume| Arc::as_ptr(volume));
        all.dedup_by_key(|volume| Arc::as_ptr(volume));
        all.iter().map(|volume| volume.size_bytes()).sum()
    }

    /// What a snapshot shows of it. Of `outside` nothing is loaded: it has the mean light.
    pub(super) fn shown(&self, outside: &ResidentSpecies, day: &Daylight) -> Shown {
        let share = f32::from(self.age) / f32::from(self.blend_frames);
        let mut mean = vec![0.0; outside.bands()];
        InstanceLight::new(outside, day).at([0.0; 3], &mut mean);
        let scaled = |volumes: &Arc<Volumes>| (Arc::clone(volumes), volumes.scale(day));
        Shown {
            now: self.now.as_ref().map(scaled),
            before: self.before.as_ref().map(scaled),
            share,
            mean,
            yaws: self.suns.yaws,
        }
    }
}
