//! Suns of a band side by side on the GPU: their light -> what arrives of it after one scattering.

use flb_format::beam::Beam;
use rayon::prelude::*;

use super::super::first::{self, SiteScattering, Turned};
use super::super::lanes::{LANES, Lanes};
use super::super::march::March;
use super::super::moments::{Moments, ScatteringMoments, none_below_0};
use super::device::Gpu;
use super::layout::{self, Params};
use super::rays::Rays;
use super::stages::bind;
use crate::gpu::GpuError;
use crate::gpu::buffers::{WORD, empty, filled, workgroups};

/// Buffers of so many lanes, and what the stages bind of them.
pub(super) struct Work<'a> {
    pub gpu: &'a Gpu,
    rays: &'a Rays,
    pub params: Params,
    pub uniform: wgpu::Buffer,
    /// One `Matter` for each site.
    pub matter: wgpu::Buffer,
    /// `[site][moment][lane]`: light; what is sent out of it; what arrives beyond that.
    pub light: wgpu::Buffer,
    pub source: wgpu::Buffer,
    pub sums: wgpu::Buffer,
    slots: wgpu::Buffer,
    send: wgpu::BindGroup,
    arrive: wgpu::BindGroup,
    /// One per axis.
    march: Vec<wgpu::BindGroup>,
    gather: Vec<wgpu::BindGroup>,
}

/// Buffers that are copied from and to, too.
pub(super) const STORAGE: wgpu::BufferUsages =
    wgpu::BufferUsages::STORAGE.union(wgpu::BufferUsages::COPY_DST).union(wgpu::BufferUsages::COPY_SRC);

impl<'a> Work<'a> {
    /// For `lanes` that [fit](Rays::lanes_that_fit), in a band whose light has `moments`.
    pub(super) fn new(
        gpu: &'a Gpu,
        rays: &'a Rays,
        escape: &[f32],
        gains: &ScatteringMoments,
        moments: usize,
        lanes: usize,
    ) -> Result<Work<'a>, GpuError> {
        let params = Params { sites: rays.sites as u32, lanes: lanes as u32, moments: moments as u32 };
        let usage = wgpu::BufferUsages::UNIFORM | wgpu::BufferUsages::COPY_DST;
        let uniform = empty(&gpu.opened, "params", 4 * WORD, usage);
        let words = layout::words(params.fields());
        gpu.opened.queue.write_buffer(&uniform, 0, bytemuck::cast_slice(&words));
        let of_site = |((gains, leaning), escape): ((&[f32; 3], &f32), &f32)| {
            layout::words(layout::matter_fields(*gains, *escape, *leaning))
        };
        let of_sites: Vec<u32> =
            gains.gains.iter().zip(&gains.leaning).zip(escape).flat_map(of_site).collect();
        let matter = filled(&gpu.opened, "matter", &of_sites);
        let of_moments = numbers(&params) * WORD;
        let [light, source, sums] =
            ["light", "source", "sums"].map(|label| empty(&gpu.opened, label, of_moments, STORAGE));
        let slots_bytes = rays.slots_of_lane(&params) * lanes as u64 * WORD;
        let slots = empty(&gpu.opened, "slots", slots_bytes, STORAGE);
        let (device, stages) = (&gpu.opened.device, &gpu.stages);
        let send = bind(device, &stages.send, &uniform, None, &[&matter, &light, &source, &sums]);
        let arrive = bind(device, &stages.arrive, &uniform, None, &[&source, &sums]);
        let axes = || rays.axes.iter().enumerate().map(|(at, axis)| (Some(rays.uniform(at)), axis));
        let march = axes().map(|(uniform_of, axis)| {
            let buffers = [&axis.segments, &axis.starts, &source, &slots];
            bind(device, &stages.march, &uniform, uniform_of, &buffers)
        });
        let gather = axes().map(|(uniform_of, axis)| {
            bind(device, &stages.gather, &uniform, uniform_of, &[&axis.offsets, &slots, &sums])
        });
        let (march, gather) = (march.collect(), gather.collect());
        gpu.opened.check()?;
        Ok(Work {
            gpu,
            rays,
            params,
            uniform,
            matter,
            light,
            source,
            sums,
            slots,
            send,
            arrive,
            march,
            gather,
        })
    }

    fn lanes(&self) -> usize {
        self.params.lanes as usize
    }

    /// Invocations of a stage that serves each site in each lane.
    pub(super) fn per_site(&self) -> usize {
        self.rays.sites * self.lanes()
    }

    /// Invocations of a stage that serves each number.
    pub(super) fn per_number(&self) -> usize {
        numbers(&self.params) as usize
    }

    /// Moments of the light of the beams of each group after one scattering: see [`March::first_scattering`].
    pub(super) fn first_scattering<const M: usize>(
        &self,
        march: &March,
        matter: &SiteScattering,
        groups: &[&[&Beam]],
    ) -> Result<Vec<Moments<M>>, GpuError> {
        let opened = &self.gpu.opened;
        let lights = filled(opened, "lights", bytemuck::cast_slice(&self.lights(groups)));
        let albedos: &[f32] = matter.albedos.as_flattened();
        let albedos = filled(opened, "albedos", bytemuck::cast_slice(albedos));
        let turned = filled(opened, "turned", bytemuck::cast_slice(&self.turned(march, matter, groups)));
        let bound: Vec<wgpu::BindGroup> = (self.rays.axes.iter().enumerate())
            .map(|(at, axis)| {
                let buffers =
                    [&axis.segments, &axis.starts, &axis.slants, &lights, &albedos, &turned, &self.slots];
                let axis = Some(self.rays.uniform(at));
                bind(&opened.device, &self.gpu.stages.first, &self.uniform, axis, &buffers)
            })
            .collect();
        opened.check()?;
        self.submit(|encoder| {
            encoder.clear_buffer(&self.sums, 0, None);
            self.along_axes(
                &mut encoder.begin_compute_pass(&Default::default()),
                &self.gpu.stages.first,
                &bound,
            );
        });
        Ok(self.fetch(&self.sums)?.into_iter().map(none_below_0).collect())
    }

    /// Light of the beams, `[site][mean, slope along x, y, z][lane]`.
    fn lights(&self, groups: &[&[&Beam]]) -> Vec<f32> {
        let lanes = self.lanes();
        let mut lights = vec![0.0_f32; self.rays.sites * 4 * lanes];
        lights.par_chunks_mut(4 * lanes).enumerate().for_each(|(site, lights)| {
            for (group, beams) in groups.iter().enumerate() {
                for (lane, beam) in (group * LANES..).zip(*beams) {
                    lights[lane] = beam.mean[site];
                    (1..).zip(beam.slope[site]).for_each(|(i, slope)| lights[i * lanes + lane] = slope);
                }
            }
        });
        lights
    }

    /// What matter of albedo 1 scatters of each beam, `[axis][way][leaf, wood][lane]`.
    fn turned(&self, march: &March, matter: &SiteScattering, groups: &[&[&Beam]]) -> Vec<f32> {
        let of_groups: Vec<Vec<Turned<1>>> =
            groups.iter().map(|beams| first::turned(march, [matter], beams)).collect();
        let mut turned = vec![0.0_f32; march.axes.len() * 4 * self.lanes()];
        turned.par_chunks_mut(4 * self.lanes()).enumerate().for_each(|(axis, turned)| {
            for (group, of_axes) in of_groups.iter().enumerate() {
                let rows = of_axes[axis].iter().flat_map(|[of_band]| of_band);
                for (row, Lanes(values)) in turned.chunks_mut(self.lanes()).zip(rows) {
                    row[group * LANES..][..LANES].copy_from_slice(values);
                }
            }
        });
        turned
    }

    /// All that arrives of light, scattered once more: see
    /// [`arrives`](super::super::source_iteration::arrives).
    pub(super) fn arrives<const M: usize>(
        &self,
        lights: &[&Moments<M>],
    ) -> Result<Vec<Moments<M>>, GpuError> {
        self.write(&self.light, lights);
        self.submit(|encoder| {
            let mut pass = encoder.begin_compute_pass(&Default::default());
            self.pass(&mut pass);
            run(&mut pass, &self.gpu.stages.arrive, &self.arrive, self.per_number());
        });
        Ok(self.fetch(&self.sums)?.into_iter().take(lights.len()).collect())
    }

    /// From the light to what is sent out, and what arrives beyond that.
    pub(super) fn pass(&self, pass: &mut wgpu::ComputePass<'_>) {
        run(pass, &self.gpu.stages.send, &self.send, self.per_site());
        self.along_axes(pass, &self.gpu.stages.march, &self.march);
    }

    /// Takes the rays of each axis through a stage, and adds up what it leaves.
    fn along_axes(
        &self,
        pass: &mut wgpu::ComputePass<'_>,
        stage: &wgpu::ComputePipeline,
        bound: &[wgpu::BindGroup],
    ) {
        for ((axis, bound), gather) in self.rays.axes.iter().zip(bound).zip(&self.gather) {
            run(pass, stage, bound, axis.rays * self.lanes());
            run(pass, &self.gpu.stages.gather, gather, self.per_site());
        }
    }

    pub(super) fn submit(&self, record: impl FnOnce(&mut wgpu::CommandEncoder)) {
        let mut encoder = self.gpu.opened.device.create_command_encoder(&Default::default());
        record(&mut encoder);
        self.gpu.opened.queue.submit([encoder.finish()]);
    }

    /// Writes the light of groups side by side; lanes without a group get 0.
    pub(super) fn write<const M: usize>(&self, buffer: &wgpu::Buffer, groups: &[&Moments<M>]) {
        let lanes = self.lanes();
        let mut values = vec![0.0_f32; self.per_number()];
        values.par_chunks_mut(M * lanes).enumerate().for_each(|(site, values)| {
            for (group, light) in groups.iter().enumerate() {
                for (values, Lanes(of_group)) in values.chunks_mut(lanes).zip(&light[site]) {
                    values[group * LANES..][..LANES].copy_from_slice(of_group);
                }
            }
        });
        self.gpu.opened.queue.write_buffer(buffer, 0, bytemuck::cast_slice(&values));
    }

    /// The light of each group.
    pub(super) fn fetch<const M: usize>(&self, buffer: &wgpu::Buffer) -> Result<Vec<Moments<M>>, GpuError> {
        let lanes = self.lanes();
        self.read(buffer, |values: &[f32]| {
            let of_group = |group: usize| -> Moments<M> {
                let of_site = |site: usize| {
                    let of_moment = |a: usize| &values[(site * M + a) * lanes + group * LANES..][..LANES];
                    std::array::from_fn(|a| Lanes(std::array::from_fn(|lane| of_moment(a)[lane])))
                };
                (0..self.rays.sites).into_par_iter().map(of_site).collect()
            };
            (0..lanes / LANES).map(of_group).collect()
        })
    }

    /// Hands all numbers of a buffer to `take`.
    pub(super) fn read<T>(
        &self,
        buffer: &wgpu::Buffer,
        take: impl FnOnce(&[f32]) -> T,
    ) -> Result<T, GpuError> {
        let opened = &self.gpu.opened;
        let usage = wgpu::BufferUsages::MAP_READ | wgpu::BufferUsages::COPY_DST;
        let staging = empty(opened, "staging", buffer.size(), usage);
        let mut taken = None;
        opened.read_through(buffer, 0..buffer.size(), &staging, |bytes| {
            taken = Some(take(bytemuck::cast_slice(bytes)));
        })?;
        Ok(taken.expect("what is read without a fault is taken"))
    }
}

/// Numbers of the light at all sites.
fn numbers(params: &Params) -> u64 {
    u64::from(params.sites) * u64::from(params.moments) * u64::from(params.lanes)
}

/// Does a stage by so many invocations.
pub(super) fn run(
    pass: &mut wgpu::ComputePass<'_>,
    stage: &wgpu::ComputePipeline,
    bound: &wgpu::BindGroup,
    invocations: usize,
) {
    pass.set_pipeline(stage);
    pass.set_bind_group(0, bound, &[]);
    let [x, y] = workgroups(invocations);
    pass.dispatch_workgroups(x, y, 1);
}
