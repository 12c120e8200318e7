//! The volumes of one species: which are wanted, and which are shown.

use std::collections::BTreeMap;
use std::sync::Arc;

use super::ForestSettings;
use super::room::{Wish, strides};
use super::snapshot::Shown;
use super::stand::Stand;
use super::suns::Suns;
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
    /// By stride: cells that are asked for, ascending; as far as that was looked up.
    asked: BTreeMap<u32, Arc<[u32]>>,
    /// Whether there was room for a volume in the last frame.
    has_room: bool,
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
            asked: BTreeMap::new(),
            has_room: true,
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
        fn count(
            all: &mut BTreeMap<u32, u32>,
            places: impl Iterator<Item = (u32, f32)>,
            plants: i32,
        ) -> bool {
            let before = all.len();
            for (place, _) in places {
                let count = all.entry(place).or_default();
                *count = count.saturating_add_signed(plants);
                if *count == 0 {
                    all.remove(&place);
                }
            }
            all.len() != before
        }
        let is_other = match stand {
            Stand::Upright(turn) => count(&mut self.upright, self.suns.yaws_of(turn), plants),
            Stand::Tilted(_) => count(&mut self.tilted, self.suns.cells(stand, 1), plants),
        };
        if is_other {
            self.asked.clear();
        }
    }

    /// Takes the suns of the daylight for those of which volumes are wanted, unless some are being made or blended in.
    /// True where tilted plants are to be counted again.
    pub(super) fn aim(&mut self, day: &Daylight, settings: &ForestSettings) -> bool {
        let suns = match &self.now {
            // Where there is no room, the suns do not matter.
            _ if self.is_awaited || !self.is_shown() || !self.has_room => return false,
            Some(now) if now.fits(day, settings.step_deg) => now.suns,
            _ if self.suns.are_near(day.towards_sun, AIM * settings.step_deg) => return false,
            _ => Suns::of(day.towards_sun, settings.yaws),
        };
        let is_other = suns != self.suns && !self.tilted.is_empty();
        if suns != self.suns {
            self.asked.clear();
        }
        self.suns = suns;
        if is_other {
            self.tilted.clear();
        }
        is_other
    }

    /// Room that its volumes ask for, where it is seen at so many pixels.
    pub(super) fn wish(&mut self, species: &ResidentSpecies, pixels: f32) -> Wish {
        let map = species.shared().map(|shared| &shared.map);
        let bytes = map.map_or(0, |map| LightVolume::bytes_of(map, species.bands())) as u64;
        let mut volumes: Vec<u32> =
            strides(self.suns.yaws).map(|stride| self.asked(stride).len() as u32).collect();
        for there in [&self.now, &self.before].into_iter().flatten() {
            volumes.iter_mut().zip(&there.counts).for_each(|(all, there)| *all = (*all).max(*there));
        }
        Wish { bytes, volumes, pixels, has_some: self.has_volumes() }
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

    /// Drops volumes but for those of every so manieth row and yaw, or all of them where there is no room.
    pub(super) fn keep(&mut self, stride: Option<u32>) {
        self.has_room = stride.is_some();
        let Some(stride) = stride.filter(|_| self.has_volumes()) else {
            (self.now, self.before) = (None, None);
            return;
        };
        let (now, before) = (self.now.clone(), self.before.clone());
        let mut kept = |volumes: Option<Arc<Volumes>>| {
            let volumes = volumes?;
            let stride = self.stride_by(&volumes.day, stride);
            let asked = self.asked(stride);
            Volumes::kept(volumes, stride, &self.suns, &asked)
        };
        let (now, before) = (kept(now), kept(before));
        self.before = before.filter(|_| now.is_some());
        self.now = now;
    }

    /// Cells of which volumes are wanted, of every so manieth row and yaw.
    fn asked(&mut self, stride: u32) -> Arc<[u32]> {
        if let Some(known) = self.asked.get(&stride) {
            return Arc::clone(known);
        }
        let mut cells: Vec<u32> = self.cells().flat_map(|cell| self.suns.around(cell, stride)).collect();
        cells.sort_unstable();
        cells.dedup();
        let cells: Arc<[u32]> = cells.into();
        self.asked.insert(stride, Arc::clone(&cells));
        cells
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
        &mut self,
        species: &ResidentSpecies,
        day: &Daylight,
        settings: &ForestSettings,
        stride: u32,
    ) -> Option<Wanted> {
        if day.sun == 0.0 && day.sky == 0.0 {
            // Of no light at all nothing could be shown that is brighter later.
            return None;
        }
        let now = self.now.clone();
        let now = now.filter(|now| now.suns == self.suns && now.fits(day, settings.step_deg));
        let is_aimed = day.sun == 0.0 || self.suns.are_near(day.towards_sun, settings.step_deg);
        // Those that can be made, and whether they would be better than what is there.
        let of_suns = Daylight { towards_sun: self.suns.towards_sun, ..*day };
        let day = now.as_ref().map_or(of_suns, |now| now.day);
        let stride = self.stride_by(&day, stride);
        let cells: Vec<u32> = self
            .asked(stride)
            .iter()
            .copied()
            .filter(|cell| {
                let level = lit_at(species, &day, self.suns.sun(*cell)).level();
                let is_better = now.as_ref().is_none_or(|now| now.level(*cell) < Some(level));
                level >= LightLevel::Averages && is_better
            })
            .collect();
        if cells.is_empty() {
            return None;
        }
        let waits = self.is_awaited || !self.is_shown() || (now.is_none() && !is_aimed);
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
