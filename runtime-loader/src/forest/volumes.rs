//! Volumes of a species under one daylight: how they are made, and which light they have.

use std::collections::BTreeMap;
use std::sync::Arc;

use super::plants::Plant;
use super::room::strides;
use super::suns::Suns;
use crate::light::LightVolume;
use crate::resident::{LightLevel, ResidentSpecies};
use crate::{Daylight, InstanceLight, SpeciesLight};

/// Share by which the strengths of sun and sky may change apart before volumes are made anew.
const STRENGTHS: f32 = 0.01;

/// Volumes that are shown before the others.
const PARTS: usize = 4;

/// Volumes to be made.
pub(super) struct Wanted {
    pub day: Daylight,
    pub suns: Suns,
    /// Every how-manieth row and yaw has a volume.
    pub stride: u32,
    /// Cells of the suns.
    pub cells: Vec<u32>,
    /// Whether nothing is shown yet.
    pub is_first: bool,
}

/// The light of plants under one of the suns, which is a vector in the model's frame.
pub(super) fn lit_at<'s>(
    species: &'s ResidentSpecies,
    day: &Daylight,
    towards_sun: [f64; 3],
) -> InstanceLight<'s> {
    InstanceLight::new(species, &Daylight { towards_sun, ..*day })
}

/// Volumes that were made of a species.
#[derive(Debug, Clone)]
pub(super) struct Made {
    pub day: Daylight,
    pub suns: Suns,
    pub stride: u32,
    /// By the cell of the suns.
    pub lit: BTreeMap<u32, CellLight>,
}

/// The volume of a cell, and how complete its light is.
#[derive(Debug, Clone)]
pub(super) struct CellLight {
    pub volume: Arc<LightVolume>,
    pub level: LightLevel,
}

/// Volumes of a species under one daylight.
#[derive(Debug)]
pub(super) struct Volumes {
    pub day: Daylight,
    pub suns: Suns,
    /// Every how-manieth row and yaw plants lie between.
    pub stride: u32,
    /// How many of them are left at each of the [`strides`].
    pub counts: Vec<u32>,
    /// By the cell of the suns.
    lit: BTreeMap<u32, CellLight>,
    /// `[cell]`: itself, or the nearest that is there.
    nearest: Vec<u32>,
}

impl Volumes {
    /// With those of before that are of the same daylight and were not made anew; `None` where there is none.
    pub(super) fn of(made: Made, before: Option<&Volumes>) -> Option<Volumes> {
        let Made { day, suns, stride, mut lit } = made;
        if let Some(before) = before.filter(|before| before.day == day) {
            for (cell, one) in &before.lit {
                lit.entry(*cell).or_insert_with(|| one.clone());
            }
        }
        let left = |stride: u32| lit.keys().filter(|cell| suns.around(**cell, stride) == [**cell; 4]).count();
        let counts = strides(suns.yaws).map(|stride| left(stride) as u32).collect();
        let nearest = suns.nearest(lit.keys().copied());
        (!lit.is_empty()).then_some(Volumes { day, suns, stride, counts, lit, nearest })
    }

    /// Those of every so manieth row and yaw, and of those that are asked for of the same suns alone once all of these
    /// are there; `None` where none is left.
    pub(super) fn kept(all: Arc<Volumes>, stride: u32, suns: &Suns, asked: &[u32]) -> Option<Arc<Volumes>> {
        let is_whole = all.suns == *suns && asked.iter().all(|cell| all.lit.contains_key(cell));
        let stays = |cell: u32| match is_whole {
            true => asked.binary_search(&cell).is_ok(),
            false => all.suns.around(cell, stride) == [cell; 4],
        };
        let stride = if is_whole { stride } else { stride.max(all.stride) };
        if stride == all.stride && all.lit.keys().all(|cell| stays(*cell)) {
            return Some(all);
        }
        let there = all.lit.iter().filter(|(cell, _)| stays(**cell));
        let lit = there.map(|(cell, one)| (*cell, one.clone())).collect();
        Volumes::of(Made { day: all.day, suns: all.suns, stride, lit }, None).map(Arc::new)
    }

    /// Completeness of the volume of a cell.
    pub(super) fn level(&self, cell: u32) -> Option<LightLevel> {
        self.lit.get(&cell).map(|lit| lit.level)
    }

    /// The volume of a cell, or the nearest.
    pub(super) fn at_cell(&self, cell: u32) -> Option<&Arc<LightVolume>> {
        self.lit.get(self.nearest.get(cell as usize)?).map(|lit| &lit.volume)
    }

    /// Each volume with its cell.
    pub(super) fn volumes(&self) -> impl Iterator<Item = (u32, &Arc<LightVolume>)> {
        self.lit.iter().map(|(cell, lit)| (*cell, &lit.volume))
    }

    /// `[cell]`: the cell whose volume it has.
    pub(super) fn nearest(&self) -> &[u32] {
        &self.nearest
    }

    /// Tells the volumes of a plant, with their shares of `share`.
    pub(super) fn tell<'v>(
        &'v self,
        plant: &Plant,
        share: f32,
        mut tell: impl FnMut(&'v Arc<LightVolume>, f32),
    ) {
        for (cell, weight) in self.suns.cells(plant.stand, self.stride) {
            if let Some(volume) = self.at_cell(cell) {
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
        day.sun == 0.0 || self.suns.are_near(day.towards_sun, step_deg)
    }

    /// Factor by which all of their light is brighter now.
    pub(super) fn scale(&self, day: &Daylight) -> f32 {
        let [made, asked] = [&self.day, day].map(|day| day.sun.abs().max(day.sky.abs()));
        if made > 0.0 { asked / made } else { 1.0 }
    }
}

/// Makes the light of suns and a sky on a species. Where nothing is shown yet, `some` takes those that are made.
pub(super) fn make(
    species: &ResidentSpecies,
    Wanted { day, suns, stride, cells, is_first }: &Wanted,
    some: impl Fn(Made),
) -> Made {
    // Lists of sites that sums need are of this work alone: they are larger than all that is read.
    let species = &species.clone();
    let light = SpeciesLight::streamed(species);
    let near = if day.sun != 0.0 { light.near() } else { None };
    let mut made = Made { day: *day, suns: *suns, stride: *stride, lit: BTreeMap::new() };
    for (number, cell) in suns.spread(cells, PARTS).into_iter().enumerate() {
        let lit = lit_at(species, day, suns.sun(cell));
        let level = lit.level();
        if let Some(volume) = lit.prepared_by(near.as_ref()).volume() {
            made.lit.insert(cell, CellLight { volume: Arc::new(volume), level });
        }
        if *is_first && number % PARTS == PARTS - 1 {
            some(made.clone());
        }
    }
    made
}
