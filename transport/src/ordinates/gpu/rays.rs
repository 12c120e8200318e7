//! The rays of a march -> buffers on the GPU, once for all bands.

use flb_gpu::Gpu;
use rayon::prelude::*;

use super::super::lanes::LANES;
use super::super::march::{March, SlantedTracks};
use super::layout::{self, AXIS_WORDS, Params};
use super::stages::PARTS;
use crate::gpu::GpuError;
use crate::gpu::buffers::{WORD, empty, filled};

/// Lanes that go side by side at most.
const MAX_LANES: usize = 32;

/// Bytes of a buffer that more than [`LANES`] lanes may fill: what WebGPU promises everywhere.
const WIDE_BYTES: u64 = 128 << 20;

/// Bytes between the `Axis` of two axes: the alignment that WebGPU asks for.
const AXIS_STRIDE: u64 = 256;

/// Axes whose words are made side by side.
const AXES_AT_ONCE: usize = 8;

/// Words of an axis, as the shaders read them.
struct AxisWords {
    /// First segment of each ray, and the end.
    starts: Vec<u32>,
    segments: Vec<u32>,
    slants: Vec<u32>,
    /// First slot of each site, and the end.
    offsets: Vec<u32>,
}

impl AxisWords {
    fn of(axis: &SlantedTracks, sites: usize) -> AxisWords {
        let mut offsets = vec![0_u32; sites + 1];
        for segment in axis.slanted_rays().flat_map(|(segments, ..)| segments) {
            offsets[segment.place() + 1] += 1;
        }
        for site in 0..sites {
            offsets[site + 1] += offsets[site];
        }
        let mut next = offsets.clone();
        let (mut starts, mut segments, mut slants) = (vec![0], Vec::new(), Vec::new());
        for (of_ray, slants_of_ray, _) in axis.slanted_rays() {
            for segment in of_ray {
                let slot = &mut next[segment.place()];
                segments.extend(layout::words(layout::segment_fields(segment, *slot)));
                *slot += 1;
            }
            slants.extend(slants_of_ray.iter().flat_map(|slant| layout::words(layout::slant_fields(slant))));
            starts.push(starts[starts.len() - 1] + of_ray.len() as u32);
        }
        AxisWords { starts, segments, slants, offsets }
    }
}

/// Rays along an ordinate on the GPU.
pub(super) struct AxisBuffers {
    pub rays: usize,
    pub starts: wgpu::Buffer,
    pub segments: wgpu::Buffer,
    pub slants: wgpu::Buffer,
    pub offsets: wgpu::Buffer,
}

/// All rays on the GPU.
pub(super) struct Rays {
    pub axes: Vec<AxisBuffers>,
    pub sites: usize,
    /// Segments of the axis that has the most.
    most_segments: u64,
    /// One `Axis` for each.
    uniforms: wgpu::Buffer,
}

impl Rays {
    /// Puts the rays of a march with sites on the GPU.
    ///
    /// # Errors
    /// [`GpuError::TooLarge`] where the segments of an axis do not fit into `buffer_bytes`.
    pub(super) fn upload(gpu: &Gpu, march: &March, buffer_bytes: u64) -> Result<Rays, GpuError> {
        let sites = march.escape.len();
        let uniform = wgpu::BufferUsages::UNIFORM | wgpu::BufferUsages::COPY_DST;
        let uniforms = empty(gpu, "axes", march.axes.len() as u64 * AXIS_STRIDE, uniform);
        let mut rays = Rays { axes: Vec::new(), sites, most_segments: 0, uniforms };
        for some in march.axes.chunks(AXES_AT_ONCE) {
            let words: Vec<AxisWords> = some.par_iter().map(|axis| AxisWords::of(axis, sites)).collect();
            for (axis, words) in some.iter().zip(words) {
                fits(gpu, sites, words.segments.len() as u64 * WORD, buffer_bytes)?;
                let (index, count) = (rays.axes.len(), words.starts.len() - 1);
                let of_axis = layout::axis_words(axis, index, count);
                let place = index as u64 * AXIS_STRIDE;
                gpu.queue.write_buffer(&rays.uniforms, place, bytemuck::cast_slice(&of_axis));
                rays.most_segments = rays.most_segments.max(words.segments.len() as u64 / 4);
                rays.axes.push(AxisBuffers {
                    rays: count,
                    starts: filled(gpu, "starts", &words.starts),
                    segments: filled(gpu, "segments", &words.segments),
                    slants: filled(gpu, "slants", &words.slants),
                    offsets: filled(gpu, "offsets", &words.offsets),
                });
            }
            gpu.check()?;
        }
        Ok(rays)
    }

    /// The `Axis` of an index.
    pub(super) fn uniform(&self, index: usize) -> wgpu::BufferBinding<'_> {
        wgpu::BufferBinding {
            buffer: &self.uniforms,
            offset: index as u64 * AXIS_STRIDE,
            size: wgpu::BufferSize::new(AXIS_WORDS as u64 * WORD),
        }
    }

    /// Numbers of the largest buffer of a lane: slots, moments, light of a beam, or sums.
    pub(super) fn most_of_lane(&self, moments: usize) -> u64 {
        let sites = self.sites as u64;
        let params = Params { sites: 0, lanes: 0, moments: moments as u32 };
        let slots = self.most_segments * u64::from(params.parities());
        slots.max(sites * moments.max(4) as u64).max(8 * u64::from(PARTS))
    }

    /// Numbers of the slots of a lane.
    pub(super) fn slots_of_lane(&self, params: &Params) -> u64 {
        self.most_segments * u64::from(params.parities())
    }

    /// Lanes that go side by side: a multiple of [`LANES`], as the lanes of a group of suns end their passes together.
    /// The bytes of a lane do not depend on how many there are.
    ///
    /// # Errors
    /// [`GpuError::TooLarge`] where not even [`LANES`] fit.
    pub(super) fn lanes_that_fit(
        &self,
        gpu: &Gpu,
        moments: usize,
        buffer_bytes: u64,
    ) -> Result<usize, GpuError> {
        let lane_bytes = self.most_of_lane(moments) * WORD;
        fits(gpu, self.sites, lane_bytes * LANES as u64, buffer_bytes)?;
        let wide = (WIDE_BYTES.min(buffer_bytes) / lane_bytes) as usize / LANES * LANES;
        Ok(wide.clamp(LANES, MAX_LANES))
    }
}

fn fits(gpu: &Gpu, sites: usize, needed: u64, limit: u64) -> Result<(), GpuError> {
    if needed <= limit {
        return Ok(());
    }
    Err(GpuError::TooLarge { adapter: gpu.name.clone(), sites, needed, limit })
}
