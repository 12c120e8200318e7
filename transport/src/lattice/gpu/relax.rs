//! One group of solves on the GPU: links and optics -> the light that every site sends, per lane.
//!
//! Two buffers of light take turns as what is read and what is written. The host looks at the residuals after every
//! [`BATCH`] iterations only, and takes each lane off the work when its own residual says so; where a lane's light
//! ended is its side.

use std::ops::Range;

use flb_format::direction::MOVING;
use flb_format::matter::Optics;
use flb_format::progress::Cancelled;

use super::super::SolveSettings;
use super::super::course::{CROSSINGS, Course};
use super::super::dense;
use super::super::error::SolveError;
use super::super::kernel::{LANES, Lanes};
use super::super::sites::{Domain, Sites};
use super::device::Gpu;
use super::layout::{self, Params};
use super::stages::PARTS;
use crate::gpu::GpuError;
use crate::gpu::buffers::{WORD, empty, filled, workgroups};

/// Iterations between two looks at the residuals. Even, so that a lane taken off lies in the first buffer of light.
const BATCH: u32 = 8;

/// Lanes of a group at most; more would fill no GPU better.
const MAX_LANES: usize = 128;

/// Bytes between two `Params`: the alignment that WebGPU asks for.
const PARAMS_STRIDE: u64 = 256;

/// Bytes read back at a time.
const PIECE_BYTES: u64 = 16 << 20;

/// The rows of a domain as [`dense::write`](super::super::dense::write) takes them, boundary light included, for every
/// [`LANES`] lanes.
pub(super) type Light = Vec<Vec<Lanes>>;

/// What all groups of a solve share.
pub(super) struct SharedBuffers {
    links: wgpu::Buffer,
    sites: wgpu::Buffer,
}

/// Lanes whose light fits buffers of `buffer_bytes`.
pub(super) fn lanes_that_fit(gpu: &Gpu, sites: usize, buffer_bytes: u64) -> Result<usize, GpuError> {
    let lane_bytes = lane_rows_bytes(sites).max(lane_sums_bytes());
    match usize::try_from(buffer_bytes / lane_bytes).unwrap_or(usize::MAX) {
        0 => {
            let adapter = gpu.opened.name.clone();
            Err(GpuError::TooLarge { adapter, sites, needed: lane_bytes, limit: buffer_bytes })
        }
        lanes => Ok(lanes.min(MAX_LANES)),
    }
}

/// Bytes of one lane's light. The links take 72 bytes a site, and thus fit where it does.
fn lane_rows_bytes(sites: usize) -> u64 {
    (sites as u64 + 1) * MOVING as u64 * WORD
}

fn lane_sums_bytes() -> u64 {
    u64::from(BATCH) * u64::from(PARTS) * 2 * WORD
}

/// Puts sites and links on the GPU.
pub(super) fn upload(gpu: &Gpu, sites: &Sites) -> Result<SharedBuffers, GpuError> {
    let nothing = Domain::default();
    let domain = sites.domains.first().unwrap_or(&nothing);
    let words: Vec<u32> =
        (0..domain.len()).flat_map(|site| layout::words(layout::site_fields(domain, site))).collect();
    let matter = SharedBuffers {
        links: filled(&gpu.opened, "links", domain.links.as_flattened()),
        sites: filled(&gpu.opened, "sites", &words),
    };
    gpu.opened.check()?;
    Ok(matter)
}

/// Iterates until every lane, a base and a band, has reached the tolerance or cannot within the iterations allowed.
pub(super) fn relax(
    gpu: &Gpu,
    matter: &SharedBuffers,
    sites: &Sites,
    optics: &Optics,
    lanes: &[(u8, u32)],
    settings: &SolveSettings,
    tick: &dyn Fn(f64, u32) -> Result<(), Cancelled>,
) -> Result<(Light, Vec<Course>), SolveError> {
    let mut courses = vec![Course::default(); lanes.len()];
    if sites.count == 0 {
        return Ok((vec![Vec::new(); lanes.len().div_ceil(LANES)], courses));
    }
    let group = GroupBuffers::new(gpu, matter, sites.count, optics, lanes)?;
    let mut at_work: Vec<u32> = (0..lanes.len() as u32).collect();
    let mut sides = vec![0; lanes.len()];
    let mut done = 0;
    while !at_work.is_empty() && done < settings.max_sweeps {
        let count = BATCH.min(settings.max_sweeps - done);
        let moves = group.iterate(gpu, &at_work, done, count)?;
        done += count;
        for moves in moves.chunks(at_work.len()) {
            for (lane, [change, norm]) in at_work.iter().zip(moves) {
                courses[*lane as usize].note(*change, *norm);
            }
        }
        tick(courses.iter().map(Course::error_estimate).fold(0.0, f64::max), done)?;
        at_work.iter().for_each(|lane| sides[*lane as usize] = done as usize % 2);
        // Before light has crossed the lattice a few times, a lack of progress says nothing.
        let crossed = done as usize > CROSSINGS * sites.lattice;
        at_work.retain(|lane| {
            let course = &courses[*lane as usize];
            !(course.is_converged(settings) || crossed && course.is_hopeless(settings))
        });
    }
    Ok((group.fetch(gpu, &sides)?, courses))
}

/// The buffers of a group.
struct GroupBuffers {
    sites: usize,
    lanes: usize,
    /// Light, by side.
    rows: [wgpu::Buffer; 2],
    sums: wgpu::Buffer,
    picks: wgpu::Buffer,
    /// One `Params` per iteration of a batch.
    params: wgpu::Buffer,
    staging: wgpu::Buffer,
    /// Reads the side of its index, writes the other.
    bindings: [wgpu::BindGroup; 2],
}

impl GroupBuffers {
    fn new(
        gpu: &Gpu,
        matter: &SharedBuffers,
        sites: usize,
        optics: &Optics,
        lanes: &[(u8, u32)],
    ) -> Result<GroupBuffers, GpuError> {
        use wgpu::BufferUsages as Usage;
        let count = lanes.len() as u64;
        let storage = Usage::STORAGE | Usage::COPY_DST | Usage::COPY_SRC;
        let of_class = |class: usize| {
            let fields = move |lane: &(u8, u32)| layout::gain_fields(&optics.bands[lane.1 as usize], class);
            lanes.iter().flat_map(move |lane| layout::words(fields(lane)))
        };
        let gains = filled(&gpu.opened, "gains", &(0..2).flat_map(of_class).collect::<Vec<u32>>());
        let rows_bytes = lane_rows_bytes(sites) * count;
        let rows = [0, 1].map(|_| empty(&gpu.opened, "light", rows_bytes, storage));
        let boundary: Vec<u32> = (1..=MOVING)
            .flat_map(|m| lanes.iter().map(move |lane| dense::is_lit(usize::from(lane.0), m)))
            .map(|lit| if lit { 1.0_f32.to_bits() } else { 0 })
            .collect();
        for rows in &rows {
            let place = (sites * MOVING * lanes.len()) as u64 * WORD;
            gpu.opened.queue.write_buffer(rows, place, bytemuck::cast_slice(&boundary));
        }
        let phi = empty(&gpu.opened, "phi", sites as u64 * count * 2 * WORD, storage);
        let sums_bytes = lane_sums_bytes() * count;
        let sums = empty(&gpu.opened, "sums", sums_bytes, storage);
        let picks = empty(&gpu.opened, "picks", count * WORD, storage);
        let params =
            empty(&gpu.opened, "params", u64::from(BATCH) * PARAMS_STRIDE, Usage::UNIFORM | Usage::COPY_DST);
        let staging_bytes = PIECE_BYTES.max(sums_bytes);
        let staging = empty(&gpu.opened, "staging", staging_bytes, Usage::MAP_READ | Usage::COPY_DST);
        let bindings = [0, 1].map(|side| {
            let one_params = wgpu::BindingResource::Buffer(wgpu::BufferBinding {
                buffer: &params,
                offset: 0,
                size: wgpu::BufferSize::new(4 * WORD),
            });
            let others =
                [&matter.links, &matter.sites, &gains, &picks, &rows[side], &rows[1 - side], &phi, &sums];
            let resources =
                std::iter::once(one_params).chain(others.map(wgpu::Buffer::as_entire_binding)).zip(0..);
            let entries: Vec<wgpu::BindGroupEntry> =
                resources.map(|(resource, binding)| wgpu::BindGroupEntry { binding, resource }).collect();
            gpu.opened.device.create_bind_group(&wgpu::BindGroupDescriptor {
                label: Some("flb"),
                layout: &gpu.stages.layout,
                entries: &entries,
            })
        });
        gpu.opened.check()?;
        Ok(GroupBuffers { sites, lanes: lanes.len(), rows, sums, picks, params, staging, bindings })
    }

    /// Does `count` iterations after `done` of them. Sums of (phi - before)^2 and phi^2, `[iteration][pick]`.
    fn iterate(&self, gpu: &Gpu, at_work: &[u32], done: u32, count: u32) -> Result<Vec<[f64; 2]>, GpuError> {
        self.set(gpu, at_work);
        let mut encoder = gpu.opened.device.create_command_encoder(&Default::default());
        {
            let mut pass = encoder.begin_compute_pass(&Default::default());
            let per_site = self.sites * at_work.len();
            let mut run = |pipeline: &wgpu::ComputePipeline, reads: u32, slot: u32, invocations: usize| {
                pass.set_pipeline(pipeline);
                pass.set_bind_group(0, &self.bindings[reads as usize % 2], &[slot * PARAMS_STRIDE as u32]);
                let [x, y] = workgroups(invocations);
                pass.dispatch_workgroups(x, y, 1);
            };
            for slot in 0..count {
                run(&gpu.stages.collide, done + slot, slot, per_site);
                run(&gpu.stages.measure, done + slot, slot, PARTS as usize * at_work.len());
            }
        }
        gpu.opened.queue.submit([encoder.finish()]);
        let per_slot = PARTS as usize * at_work.len();
        let mut sums = vec![[0.0; 2]; count as usize * at_work.len()];
        let bytes = (count as usize * per_slot) as u64 * 2 * WORD;
        gpu.opened.read_through(&self.sums, 0..bytes, &self.staging, |parts| {
            let parts: &[f32] = bytemuck::cast_slice(parts);
            for (slot, parts) in parts.chunks(per_slot * 2).enumerate() {
                for (at, part) in parts.chunks(2).enumerate() {
                    let sum = &mut sums[slot * at_work.len() + at % at_work.len()];
                    *sum = [sum[0] + f64::from(part[0]), sum[1] + f64::from(part[1])];
                }
            }
        })?;
        Ok(sums)
    }

    /// Tells the next stages which lanes are at work.
    fn set(&self, gpu: &Gpu, picks: &[u32]) {
        gpu.opened.queue.write_buffer(&self.picks, 0, bytemuck::cast_slice(picks));
        for slot in 0..BATCH {
            let params = Params {
                sites: self.sites as u32,
                lanes: self.lanes as u32,
                picks: picks.len() as u32,
                slot,
            };
            let words = layout::words(params.fields());
            let place = u64::from(slot) * PARAMS_STRIDE;
            gpu.opened.queue.write_buffer(&self.params, place, bytemuck::cast_slice(&words));
        }
    }

    /// The light of every lane from the side where it ended.
    fn fetch(&self, gpu: &Gpu, sides: &[usize]) -> Result<Light, GpuError> {
        let rows = (self.sites + 1) * MOVING;
        let mut light: Light = vec![vec![Lanes::default(); rows]; self.lanes.div_ceil(LANES)];
        for side in 0..2 {
            let here: Vec<u32> =
                (0..self.lanes as u32).filter(|&lane| sides[lane as usize] == side).collect();
            if here.is_empty() {
                continue;
            }
            self.set(gpu, &here);
            let mut encoder = gpu.opened.device.create_command_encoder(&Default::default());
            {
                let mut pass = encoder.begin_compute_pass(&Default::default());
                pass.set_pipeline(&gpu.stages.settle);
                pass.set_bind_group(0, &self.bindings[1 - side], &[0]);
                let [x, y] = workgroups(self.sites * here.len());
                pass.dispatch_workgroups(x, y, 1);
            }
            gpu.opened.queue.submit([encoder.finish()]);
            let rows_per_piece = (PIECE_BYTES / WORD) as usize / self.lanes;
            for start in (0..rows).step_by(rows_per_piece) {
                let piece: Range<usize> = start..(start + rows_per_piece).min(rows);
                let bytes = (piece.start * self.lanes) as u64 * WORD..(piece.end * self.lanes) as u64 * WORD;
                gpu.opened.read_through(&self.rows[side], bytes, &self.staging, |values| {
                    let values: &[f32] = bytemuck::cast_slice(values);
                    for (row, values) in piece.zip(values.chunks(self.lanes)) {
                        for lane in here.iter().map(|&lane| lane as usize) {
                            light[lane / LANES][row].0[lane % LANES] = values[lane];
                        }
                    }
                })?;
            }
        }
        Ok(light)
    }
}
