//! Scene light under one sun to the buffers by which each plant's light is told among its neighbours, and the stage
//! that reads them.

use flb_format::{Grid, Placement, Transform};
use flb_gpu::Gpu;
use flb_runtime::scene_light::export::{FlatSceneLight, FlatVolumeBlend};

use crate::ForestError;
use crate::buffers::storage;
use crate::layout::{NONE, Words};
use crate::stages::{self, Among};

const VOLUMES: &str = "volumes of scene light";
const SMALLER: &str = "with a smaller lattice of the scene, or fewer plants that are tilted";
/// Words before the volumes: the scene's own, and the light of an empty scene.
const SCENE_WORDS: usize = 4;
/// Words before a volume's values; `HEAD`.
const HEAD: u64 = 6;

/// What plants do to each other's light, on the GPU.
pub(crate) struct Neighbours {
    stage: Among,
    /// `None` before the first shade, and once instances have changed.
    sent: Option<Sent>,
}

struct Sent {
    blends: wgpu::Buffer,
    volumes: wgpu::Buffer,
    group: wgpu::BindGroup,
}

impl Neighbours {
    pub(crate) fn new(
        gpu: &Gpu,
        light: &wgpu::BindGroupLayout,
        frame: [&wgpu::BindGroupLayout; 2],
    ) -> Neighbours {
        Neighbours { stage: stages::compile_among(&gpu.device, light, frame), sent: None }
    }

    /// Sends a shade of the plants that stand in this order, whose lights these are.
    pub(crate) fn send(
        &mut self,
        gpu: &Gpu,
        shade: &FlatSceneLight<'_>,
        order: &[u32],
        lights: &wgpu::Buffer,
    ) -> Result<(), ForestError> {
        if shade.plants.len() != order.len() {
            let (found, expected) = (shade.plants.len(), order.len());
            return Err(ForestError::Neighbours { found, expected });
        }
        // Both at once may not fit.
        self.sent = None;
        let words: u64 = shade.volumes.iter().map(|volume| HEAD + volume.values.len() as u64).sum();
        let (needed, limit) = (4 * words, gpu.largest_buffer_bytes());
        if needed > limit {
            return Err(ForestError::TooLarge { what: VOLUMES, needed, limit, remedy: SMALLER });
        }
        let (words, firsts) = volume_words(shade);
        let scene = shade.volumes[shade.scene_sky].grid;
        let mut blends = Words::default();
        for &number in order {
            let (placed, blend) = &shade.plants[number as usize];
            blend_words(&mut blends, placed, blend.as_ref(), scene, &firsts);
        }
        let blends = storage(gpu, "aims of scene light", &blends.0, "with fewer instances")?;
        let volumes = storage(gpu, VOLUMES, &words.0, SMALLER)?;
        let buffers = [lights, &blends, &volumes].map(wgpu::Buffer::as_entire_binding);
        let group = stages::group(&gpu.device, "flb among", &self.stage.lights, &buffers);
        self.sent = Some(Sent { blends, volumes, group });
        Ok(())
    }

    pub(crate) fn forget(&mut self) {
        self.sent = None;
    }

    /// The stage and the lights among their neighbours; nothing where none were sent.
    pub(crate) fn stage(&self) -> Option<(&wgpu::ComputePipeline, &wgpu::BindGroup)> {
        self.sent.as_ref().map(|sent| (&self.stage.pipeline, &sent.group))
    }

    pub(crate) fn size_bytes(&self) -> u64 {
        self.sent.as_ref().map_or(0, |sent| sent.blends.size() + sent.volumes.size())
    }
}

/// All volumes, and the first word of each.
fn volume_words(shade: &FlatSceneLight<'_>) -> (Words, Vec<u32>) {
    let mut words = Words(vec![0; SCENE_WORDS]);
    let mut firsts = Vec::new();
    for volume in &shade.volumes {
        firsts.push(words.0.len() as u32);
        let grid = volume.grid;
        words.rounded(grid.origin_m).rounded([1.0 / grid.spacing_m]).whole(grid.lattice).float(volume.mean);
        words.0.extend(volume.values.iter().map(|v| if v.is_nan() { NONE } else { v.to_bits() }));
    }
    words.0[0] = firsts[shade.scene_sky];
    words.0[1] = shade.scene_sun.map_or(NONE, |sun| firsts[sun]);
    // No light of an empty scene is 0, by which a shader tells that there is none.
    let empty = shade.empty.unwrap_or([0.0; 2]).map(f32::to_bits);
    words.0[2..SCENE_WORDS].copy_from_slice(&empty);
    (words, firsts)
}

fn blend_words(
    words: &mut Words,
    placed: &Placement,
    blend: Option<&FlatVolumeBlend>,
    scene: &Grid,
    firsts: &[u32],
) {
    let Transform { rotation, position_m, scale } = placed.transform;
    for (axis, row) in rotation.iter().enumerate() {
        let sites = |metres: f64| metres / scene.spacing_m;
        words.rounded(row.map(|along| sites(along * scale)));
        words.rounded([sites(position_m[axis] - scene.origin_m[axis])]);
    }
    let first = |volume: usize| firsts[volume];
    words.whole(blend.map_or(NONE, |blend| first(blend.sky)));
    words.0.extend(blend.and_then(|blend| blend.sun).map_or([NONE; 3], |volumes| volumes.map(first)));
    words.float(0.0);
    words.0.extend(blend.map_or([0.0; 3], |blend| blend.weights).map(f32::to_bits));
}
