//! Volumes of a species at some yaws under one daylight: how they are made, and which light they have.

use std::collections::BTreeSet;
use std::sync::Arc;

use flb_format::Transform;

use super::plants::Plant;
use crate::light::LightVolume;
use crate::resident::{LightLevel, ResidentSpecies};
use crate::sun_terms::unit;
use crate::{Daylight, InstanceLight, SpeciesLight};

/// Share by which the strengths of sun and sky may change apart before volumes are made anew.
const STRENGTHS: f32 = 0.01;

/// Volumes that are shown before the others.
const PARTS: usize = 4;

/// Volumes to be made.
pub(super) struct Wanted {
    pub day: Daylight,
    /// Yaws.
    pub turns: Vec<u32>,
    /// Whether nothing is shown yet.
    pub is_first: bool,
}

/// The light of a plant at one of so many yaws.
pub(super) fn lit_at<'s>(
    species: &'s ResidentSpecies,
    day: &Daylight,
    turn: u32,
    yaws: u32,
) -> InstanceLight<'s> {
    let stands = Transform::from_yaw([0.0; 3], 360.0 * f64::from(turn) / f64::from(yaws), 1.0);
    let towards_sun = stands.model_from_world_direction(day.towards_sun);
    InstanceLight::new(species, &Daylight { towards_sun, ..*day })
}

/// Volumes that were made of a species.
#[derive(Debug, Clone)]
pub(super) struct Made {
    pub day: Daylight,
    /// `[yaw]`
    pub turns: Vec<Option<Turned>>,
}

/// The volume of a yaw, and how complete its light is.
#[derive(Debug, Clone)]
pub(super) struct Turned {
    pub volume: Arc<LightVolume>,
    pub level: LightLevel,
}

/// Volumes of a species under one daylight.
#[derive(Debug)]
pub(super) struct Volumes {
    pub day: Daylight,
    /// `[yaw]`
    turns: Vec<Option<Turned>>,
    /// `[yaw]`: itself, or the nearest that is there.
    nearest: Vec<usize>,
}

impl Volumes {
    /// With those of before that are of the same daylight and were not made anew; `None` where there is none.
    pub(super) fn of(made: Made, before: Option<&Volumes>) -> Option<Volumes> {
        let Made { day, mut turns } = made;
        if let Some(before) = before.filter(|before| before.day == day) {
            let all = turns.iter_mut().zip(&before.turns);
            all.filter(|(turn, _)| turn.is_none()).for_each(|(turn, before)| turn.clone_from(before));
        }
        let count = turns.len();
        let there: Vec<usize> = (0..count).filter(|turn| turns[*turn].is_some()).collect();
        let apart = |a: usize, b: usize| a.abs_diff(b).min(count - a.abs_diff(b));
        let nearest = |turn: usize| there.iter().copied().min_by_key(|other| apart(turn, *other));
        let nearest: Option<Vec<usize>> = (0..count).map(nearest).collect();
        Some(Volumes { day, nearest: nearest?, turns })
    }

    /// Those of every so manieth yaw, and of those that are asked for alone once all of these are there; `None` where
    /// none is left.
    pub(super) fn kept(all: Arc<Volumes>, stride: u32, asked: &BTreeSet<u32>) -> Option<Arc<Volumes>> {
        let is_whole = asked.iter().all(|turn| all.turns[*turn as usize].is_some());
        let stays = |turn: u32| if is_whole { asked.contains(&turn) } else { turn.is_multiple_of(stride) };
        let there = (0..).zip(&all.turns).filter(|(_, turned)| turned.is_some());
        if there.map(|(turn, _)| turn).all(stays) {
            return Some(all);
        }
        let of = |(turn, turned): (u32, &Option<Turned>)| turned.clone().filter(|_| stays(turn));
        let turns = (0..).zip(&all.turns).map(of).collect();
        Volumes::of(Made { day: all.day, turns }, None).map(Arc::new)
    }

    /// Completeness of the volume of a yaw.
    pub(super) fn level(&self, turn: u32) -> Option<LightLevel> {
        self.turns[turn as usize].as_ref().map(|turned| turned.level)
    }

    /// The volume that plants at a yaw have.
    pub(super) fn at_yaw(&self, yaw: u32) -> Option<&Arc<LightVolume>> {
        self.turns[self.nearest[yaw as usize]].as_ref().map(|turned| &turned.volume)
    }

    pub(super) fn volumes(&self) -> impl Iterator<Item = &Arc<LightVolume>> {
        self.turns.iter().flatten().map(|turned| &turned.volume)
    }

    /// Tells the volumes of a plant, with their shares of `share`.
    pub(super) fn tell<'v>(
        &'v self,
        plant: &Plant,
        share: f32,
        mut tell: impl FnMut(&'v Arc<LightVolume>, f32),
    ) {
        for (turn, weight) in plant.turn.both(self.turns.len() as u32) {
            if let Some(volume) = self.at_yaw(turn) {
                tell(volume, share * weight);
            }
        }
    }

    /// Whether they are of this daylight but for a factor.
    pub(super) fn fits(&self, day: &Daylight, step_deg: f64) -> bool {
        let scale = self.scale(day);
        let alike = |made: f32, asked: f32| (scale * made - asked).abs() <= STRENGTHS * asked.abs();
        if !(alike(self.day.sun, day.sun) && alike(self.day.sky, day.sky)) {
            return false;
        }
        match (unit(self.day.towards_sun), unit(day.towards_sun)) {
            _ if day.sun == 0.0 => true,
            (Some(made), Some(asked)) => {
                let cos: f64 = made.iter().zip(asked).map(|(a, b)| a * b).sum();
                cos >= libm::cos(step_deg.to_radians())
            }
            _ => false,
        }
    }

    /// Factor by which all of their light is brighter now.
    pub(super) fn scale(&self, day: &Daylight) -> f32 {
        let [made, asked] = [&self.day, day].map(|day| day.sun.abs().max(day.sky.abs()));
        if made > 0.0 { asked / made } else { 1.0 }
    }
}

/// Makes the light of a sun and a sky on a species at some yaws. Where nothing is shown yet, `some` takes those that
/// are made.
pub(super) fn make(
    species: &ResidentSpecies,
    Wanted { day, turns, is_first }: &Wanted,
    yaws: u32,
    some: impl Fn(Made),
) -> Made {
    // Lists of sites that sums need are of this work alone: they are larger than all that is read.
    let species = &species.clone();
    let light = SpeciesLight::streamed(species);
    let near = if day.sun != 0.0 { light.near() } else { None };
    let mut made = Made { day: *day, turns: vec![None; yaws as usize] };
    // Every fourth part of the circle first, so that no plant is far from one that is there.
    let parts = turns.len().div_ceil(PARTS);
    let spread = (0..parts).flat_map(|first| turns.iter().skip(first).step_by(parts));
    for (number, turn) in spread.enumerate() {
        let lit = lit_at(species, day, *turn, yaws);
        let level = lit.level();
        let volume = lit.prepared_by(near.as_ref()).volume();
        made.turns[*turn as usize] = volume.map(|volume| Turned { volume: Arc::new(volume), level });
        if *is_first && number % PARTS == PARTS - 1 {
            some(made.clone());
        }
    }
    made
}
