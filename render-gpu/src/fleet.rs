//! Several GPUs at one picture: it is cut into more tiles than there are GPUs, and each takes another tile when it is
//! done with one, so that a slow one holds up no other. A GPU that is lost on the way leaves its tiles to the others.
//!
//! A GPU keeps the fragments of the tiles that it traced and lights those again. It lights a tile of another only when
//! it has none of its own left, and has to trace that first.

use std::collections::BTreeMap;
use std::sync::{Mutex, PoisonError};
use std::thread;

use flb_gpu::DeviceError;
use flb_render::forest::View;
use flb_render::{Lighting, Look, Picture};
use flb_runtime::scene_light::SceneLightAtSun;

use crate::forest::Traced;
use crate::part::{PictureRect, tiles};
use crate::queue::Queue;
use crate::{CameraHit, ForestError, GpuForest, LightSet};

/// Tiles for each GPU, where there are several: what is left of a picture when the first has nothing more to do is less
/// than a tile for each.
const TILES_EACH: usize = 8;

/// One forest on several GPUs.
pub struct Fleet {
    members: Vec<Member>,
    view: Option<View>,
    tiles: Vec<PictureRect>,
}

struct Member {
    forest: GpuForest,
    lights: LightSet,
    /// By the number of the tile, what the camera sees there.
    traced: BTreeMap<usize, Traced>,
    /// Tiles of an older view, whose buffers may do for new ones.
    old: Vec<Traced>,
    /// Whether it has been told the light of the picture that is made now.
    is_aimed: bool,
    lost: Option<DeviceError>,
}

impl Fleet {
    /// Makes a fleet of one forest on each GPU, with its lights. One alone draws pictures whole.
    ///
    /// # Errors
    /// [`ForestError::NoGpu`].
    pub fn new(members: impl IntoIterator<Item = (GpuForest, LightSet)>) -> Result<Fleet, ForestError> {
        let member = |(forest, lights)| Member {
            forest,
            lights,
            traced: BTreeMap::new(),
            old: Vec::new(),
            is_aimed: false,
            lost: None,
        };
        let members: Vec<Member> = members.into_iter().map(member).collect();
        if members.is_empty() {
            return Err(ForestError::NoGpu);
        }
        Ok(Fleet { members, view: None, tiles: Vec::new() })
    }

    /// Finds what every ray of a picture meets first, as [`GpuForest::trace`], and waits until it is done.
    ///
    /// # Errors
    /// As [`GpuForest::trace`]; [`ForestError::Device`] only when the last GPU was lost.
    pub fn trace(&mut self, view: &View) -> Result<(), ForestError> {
        view.check()?;
        for member in &mut self.members {
            member.old = std::mem::take(&mut member.traced).into_values().collect();
        }
        let count = self.members.len();
        self.tiles = tiles(view, if count == 1 { 1 } else { (count * TILES_EACH) as u32 });
        self.view = Some(*view);
        let tiles = &self.tiles;
        let traced = share(&mut self.members, tiles.len(), |member, tile| member.trace(view, tiles, tile));
        self.members.iter_mut().for_each(|member| member.old.clear());
        traced.map(|_| ())
    }

    /// Sets the scene light, as [`GpuForest::set_scene_light`], on every GPU.
    ///
    /// # Errors
    /// As that; a GPU that is lost on the way is left out from then on.
    pub fn set_scene_light(&mut self, shade: Option<&SceneLightAtSun<'_>>) -> Result<(), ForestError> {
        for member in self.members.iter_mut().filter(|member| member.lost.is_none()) {
            match member.forest.set_scene_light(shade) {
                Err(ForestError::Device(error)) => member.lose(error),
                other => other?,
            }
        }
        Ok(())
    }

    /// Lights what was traced last, as [`GpuForest::relight`] with [`GpuForest::picture`] after it.
    ///
    /// # Errors
    /// As those; [`ForestError::Device`] only when the last GPU was lost.
    pub fn relight(&mut self, lighting: &Lighting, look: &Look) -> Result<Picture, ForestError> {
        let view = self.view.ok_or(ForestError::NotTraced)?;
        let tiles = &self.tiles;
        self.members.iter_mut().for_each(|member| member.is_aimed = false);
        let pictures = share(&mut self.members, tiles.len(), |member, tile| {
            if !member.traced.contains_key(&tile) {
                member.trace(&view, tiles, tile)?;
            }
            member.relight((lighting, look), view.eye.position_m, tile)
        })?;
        let mut picture = Picture {
            width: view.width,
            height: view.height,
            rgb: vec![0.0; 3 * (view.width * view.height) as usize],
        };
        for (part, tile) in tiles.iter().zip(&pictures) {
            for (y, row) in (part.top..).zip(tile.rgb.chunks_exact(3 * part.width as usize)) {
                let first = 3 * (y as usize * view.width as usize + part.left as usize);
                picture.rgb[first..first + row.len()].copy_from_slice(row);
            }
        }
        Ok(picture)
    }

    /// Rays of what was traced last that met a plant, the ground, nothing, and water.
    ///
    /// # Errors
    /// [`ForestError::NotTraced`], [`ForestError::Device`].
    pub fn counts(&mut self) -> Result<[usize; 4], ForestError> {
        let view = self.view.ok_or(ForestError::NotTraced)?;
        let tiles = &self.tiles;
        let all = share(&mut self.members, tiles.len(), |member, tile| {
            if !member.traced.contains_key(&tile) {
                member.trace(&view, tiles, tile)?;
            }
            member.counts(tile)
        })?;
        Ok(std::array::from_fn(|kind| all.iter().map(|counts| counts[kind]).sum()))
    }

    /// GPUs that were lost, by their numbers, and what happened to them.
    pub fn lost(&self) -> impl Iterator<Item = (usize, &DeviceError)> {
        self.members.iter().enumerate().filter_map(|(number, member)| Some((number, member.lost.as_ref()?)))
    }

    /// Memory of light on all GPUs.
    pub fn light_bytes(&self) -> u64 {
        self.members.iter().map(|member| member.lights.size_bytes()).sum()
    }
}

impl Member {
    fn trace(&mut self, view: &View, tiles: &[PictureRect], tile: usize) -> Result<(), ForestError> {
        self.old.pop().into_iter().for_each(|old| self.forest.take_up(old));
        self.forest.trace_part(view, tiles[tile])?;
        self.forest.wait()?;
        self.traced.extend(self.forest.put_aside().map(|traced| (tile, traced)));
        Ok(())
    }

    /// Lights a tile that was traced here. What all tiles share is sent with the first of them.
    fn relight(
        &mut self,
        (lighting, look): (&Lighting, &Look),
        camera_m: [f64; 3],
        tile: usize,
    ) -> Result<Picture, ForestError> {
        if !self.is_aimed {
            self.forest.aim(&mut self.lights, lighting, look, camera_m)?;
            self.is_aimed = true;
        }
        self.with(tile, |forest, lights| {
            forest.light_aimed(lights.light())?;
            forest.picture()
        })
    }

    fn counts(&mut self, tile: usize) -> Result<[usize; 4], ForestError> {
        self.with(tile, |forest, _| {
            let mut counts = [0; 4];
            for met in forest.fragments()? {
                counts[match met {
                    CameraHit::Plant { .. } => 0,
                    CameraHit::Ground { .. } => 1,
                    CameraHit::Sky => 2,
                    CameraHit::Water { .. } => 3,
                }] += 1;
            }
            Ok(counts)
        })
    }

    /// Does something with a tile that was traced here.
    fn with<T>(
        &mut self,
        tile: usize,
        work: impl FnOnce(&mut GpuForest, &mut LightSet) -> Result<T, ForestError>,
    ) -> Result<T, ForestError> {
        let traced = self.traced.remove(&tile).ok_or(ForestError::NotTraced)?;
        self.forest.take_up(traced);
        let done = work(&mut self.forest, &mut self.lights);
        self.traced.extend(self.forest.put_aside().map(|traced| (tile, traced)));
        done
    }

    fn lose(&mut self, error: DeviceError) {
        self.traced.clear();
        self.old.clear();
        self.lost = Some(error);
    }
}

/// Lets every GPU that is left do one tile after the other, in a thread of its own: its own tiles first, then those of
/// none, then those of others. What comes of the tiles, in their order.
fn share<T: Send>(
    members: &mut [Member],
    tiles: usize,
    work: impl Fn(&mut Member, usize) -> Result<T, ForestError> + Sync,
) -> Result<Vec<T>, ForestError> {
    let mut is_traced = vec![false; tiles];
    members.iter().flat_map(|member| member.traced.keys()).for_each(|tile| is_traced[*tile] = true);
    let queue = Queue::new(tiles);
    let done: Mutex<Vec<Option<T>>> = Mutex::new((0..tiles).map(|_| None).collect());
    let failed: Mutex<Option<ForestError>> = Mutex::new(None);
    thread::scope(|scope| {
        for member in members.iter_mut().filter(|member| member.lost.is_none()) {
            let (queue, done, failed, work, is_traced) = (&queue, &done, &failed, &work, &is_traced);
            scope.spawn(move || {
                let rank = |member: &Member, tile: usize| match member.traced.contains_key(&tile) {
                    true => tile,
                    false if !is_traced[tile] => tiles + tile,
                    // From the other end, which its GPU comes to last.
                    false => 3 * tiles - tile,
                };
                while let Some(piece) = queue.take(|tile| rank(member, tile)) {
                    match work(member, piece.number) {
                        Ok(result) => {
                            done.lock().unwrap_or_else(PoisonError::into_inner)[piece.number] = Some(result);
                            piece.finish();
                        }
                        Err(ForestError::Device(error)) => return member.lose(error),
                        Err(error) => {
                            failed.lock().unwrap_or_else(PoisonError::into_inner).get_or_insert(error);
                            return queue.stop();
                        }
                    }
                }
            });
        }
    });
    if let Some(error) = failed.into_inner().unwrap_or_else(PoisonError::into_inner) {
        return Err(error);
    }
    let done: Option<Vec<T>> =
        done.into_inner().unwrap_or_else(PoisonError::into_inner).into_iter().collect();
    let last = || members.iter().filter_map(|member| member.lost.clone()).next_back();
    done.ok_or_else(|| last().map_or(ForestError::NoGpu, ForestError::Device))
}
