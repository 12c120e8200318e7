//! The volumes of one species: which are wanted, and which are shown.

use std::collections::BTreeSet;
use std::sync::Arc;

use super::ForestSettings;
use super::plants::Turn;
use super::room::kept;
use super::snapshot::Shown;
use super::volumes::{Made, Volumes, Wanted, lit_at};
use crate::light::LightVolume;
use crate::resident::{LightLevel, ResidentSpecies};
use crate::{Daylight, InstanceLight};

/// Light of a species.
pub(super) struct Lit {
    /// `[yaw]`: plants that ask for it.
    used: Vec<u32>,
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
        let (used, blend_frames) = (vec![0; settings.yaws as usize], settings.blend_frames);
        Lit { used, now: None, before: None, age: 0, blend_frames, unseen: 0, is_awaited: false }
    }

    /// Counts a plant that comes (1) or goes (-1).
    pub(super) fn count(&mut self, turn: Turn, plants: i32) {
        for (turn, _) in turn.both(self.used.len() as u32) {
            let used = &mut self.used[turn as usize];
            *used = used.saturating_add_signed(plants);
        }
    }

    /// Yaws that plants ask for.
    pub(super) fn yaws(&self) -> u32 {
        self.used.iter().filter(|used| **used > 0).count() as u32
    }

    /// Memory of one of its volumes, as far as is known.
    pub(super) fn volume_bytes(&self, species: &ResidentSpecies) -> u64 {
        species.shared().map_or(0, |shared| LightVolume::bytes_of(&shared.map, species.bands())) as u64
    }

    /// Whether there are volumes of it.
    pub(super) fn has_volumes(&self) -> bool {
        self.now.is_some()
    }

    /// Drops volumes but for those of every so manieth yaw, or all of them.
    pub(super) fn keep(&mut self, stride: Option<u32>) {
        let Some(stride) = stride.filter(|_| self.has_volumes()) else {
            (self.now, self.before) = (None, None);
            return;
        };
        let asked = self.asked(stride);
        let kept = |volumes: Option<Arc<Volumes>>| Volumes::kept(volumes?, stride, &asked);
        self.now = kept(self.now.take());
        self.before = kept(self.before.take()).filter(|_| self.now.is_some());
    }

    /// Yaws of which volumes are wanted, of every so manieth.
    fn asked(&self, stride: u32) -> BTreeSet<u32> {
        let used = (0..).zip(&self.used).filter(|(_, used)| **used > 0);
        used.map(|(turn, _)| kept(turn, self.used.len() as u32, stride)).collect()
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
        let now = self.now.as_ref().filter(|now| now.fits(day, settings.step_deg));
        // Those that can be made, and whether they would be better than what is there.
        let turns: Vec<u32> = self
            .asked(stride)
            .into_iter()
            .filter(|turn| {
                let level = lit_at(species, day, *turn, settings.yaws).level();
                level >= LightLevel::Averages && now.is_none_or(|now| now.level(*turn) < Some(level))
            })
            .collect();
        if turns.is_empty() {
            return None;
        }
        let waits = self.is_awaited || !self.is_shown();
        let day = now.map_or(*day, |now| now.day);
        let is_first = self.now.is_none();
        Some(Wanted { day, turns: if waits { Vec::new() } else { turns }, is_first })
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
        let mut all: Vec<&Arc<LightVolume>> =
            [&self.now, &self.before].into_iter().flatten().flat_map(|volumes| volumes.volumes()).collect();
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
            yaws: self.used.len() as u32,
        }
    }
}
