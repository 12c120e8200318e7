//! Multiple scattering on the GPU: x = x_1 + K W x by fixed-point steps and Anderson mixing. The host says after each
//! pass how every group of lanes goes on, by the same rules as [`super::super::source_iteration`].

use super::super::lanes::LANES;
use super::super::moments::{Moments, ScatteringMoments};
use super::super::source_iteration::{Course, MEMORY, Relaxed, least_squares, residual};
use super::stages::{PARTS, bind};
use super::work::{STORAGE, Work, run};
use crate::gpu::GpuError;
use crate::gpu::buffers::{WORD, empty};

/// Numbers of `Sums`.
const SUMS: usize = 8;

/// When a solve ends.
#[derive(Debug, Clone, Copy)]
pub(super) struct End {
    pub tolerance: f64,
    pub most: u32,
}

/// Solves for the light of each group from its first scattering, beginning with `starts`. Errors are relative to the
/// light of a lane, or to a greater one: `sizes` are sums of squares.
pub(super) fn relax<const M: usize>(
    work: &Work,
    gains: &ScatteringMoments,
    firsts: &[&Moments<M>],
    starts: &[&Moments<M>],
    sizes: &[[f64; LANES]],
    end: End,
) -> Result<Vec<Relaxed<M>>, GpuError> {
    let iteration = Iteration::new(work)?;
    work.write(&iteration.first, firsts);
    work.write(&work.light, starts);
    let mut courses: Vec<Course> = firsts.iter().map(|_| Course::new(gains)).collect();
    let mut at_work = vec![true; firsts.len()];
    let mut passes = 0;
    while passes < end.most && at_work.contains(&true) {
        let products = iteration.pass(passes)?;
        let mut weights = vec![[0.0_f32; 4]; work.params.lanes as usize];
        for (group, (course, at_work)) in courses.iter_mut().zip(&mut at_work).enumerate() {
            if !*at_work {
                continue;
            }
            let lanes = group * LANES..(group + 1) * LANES;
            let products = &products[lanes.clone()];
            let of = |number: fn(&Products) -> f64| std::array::from_fn(|lane| number(&products[lane]));
            let (steps, lights) = (of(|products| products.step), of(|products| products.light));
            course.note(residual(&steps, &lights, &sizes[group]));
            *at_work = course.error_estimate > end.tolerance;
            for (weights, products) in weights[lanes].iter_mut().zip(products) {
                // At the end the step itself is taken.
                let [a, b] = if *at_work { products.weights(passes) } else { [0.0; MEMORY] };
                *weights = [1.0, a, b, 0.0];
            }
        }
        iteration.mix(&weights);
        passes += 1;
    }
    let lights = work.fetch(&work.light)?;
    let relaxed = |(light, course): (Moments<M>, Course)| {
        let Course { passes, error_estimate, .. } = course;
        Relaxed { light, passes, error_estimate }
    };
    Ok(lights.into_iter().zip(courses).map(relaxed).collect())
}

/// `Sums` of a lane, over all sites.
#[derive(Clone, Copy, Default)]
struct Products {
    step: f64,
    light: f64,
    a_a: f64,
    a_b: f64,
    b_b: f64,
    a_step: f64,
    b_step: f64,
}

impl Products {
    /// Adds the sums of a run of sites.
    fn add(&mut self, part: &[f32]) {
        let Products { step, light, a_a, a_b, b_b, a_step, b_step } = self;
        let sums = [step, light, a_a, a_b, b_b, a_step, b_step];
        sums.into_iter().zip(part).for_each(|(sum, part)| *sum += f64::from(*part));
    }

    /// Weights of the changes a and b after pass number `pass`, from 0 up. Each pass but the first makes a change, a
    /// and b by turns.
    fn weights(&self, pass: u32) -> [f32; MEMORY] {
        let &Products { a_a, a_b, b_b, a_step, b_step, .. } = self;
        let a_is_older = pass.is_multiple_of(2);
        let table = match a_is_older {
            _ if pass == 1 => [[a_a, a_step, 0.0], [0.0; 3]],
            true => [[a_a, a_b, a_step], [a_b, b_b, b_step]],
            false => [[b_b, a_b, b_step], [a_b, a_a, a_step]],
        };
        let [older, newer] = least_squares((pass as usize).min(MEMORY), |i, j| table[i][j]);
        if a_is_older || pass == 1 { [older, newer] } else { [newer, older] }
    }
}

/// What an iteration keeps beside the light.
struct Iteration<'a> {
    work: &'a Work<'a>,
    /// Light scattered once.
    first: wgpu::Buffer,
    light_before: wgpu::Buffer,
    step_before: wgpu::Buffer,
    parts: wgpu::Buffer,
    weights: wgpu::Buffer,
    step: wgpu::BindGroup,
    /// Into the change a, and into b.
    remember: [wgpu::BindGroup; MEMORY],
    measure: wgpu::BindGroup,
    mix: wgpu::BindGroup,
}

impl<'a> Iteration<'a> {
    fn new(work: &'a Work<'a>) -> Result<Iteration<'a>, GpuError> {
        let gpu = work.gpu;
        let lanes = u64::from(work.params.lanes);
        let of_moments = |label: &str| empty(&gpu.opened, label, work.light.size(), STORAGE);
        let [first, light_before, step_before] = ["first", "light before", "step before"].map(of_moments);
        let [light_a, step_a, light_b, step_b] = ["light a", "step a", "light b", "step b"].map(of_moments);
        let parts_bytes = u64::from(PARTS) * lanes * SUMS as u64 * WORD;
        let parts = empty(&gpu.opened, "parts", parts_bytes, STORAGE);
        let weights = empty(&gpu.opened, "weights", lanes * 4 * WORD, STORAGE);
        let (light, steps) = (&work.light, &work.sums);
        let bound = |stage: &wgpu::ComputePipeline, buffers: &[&wgpu::Buffer]| {
            bind(&gpu.opened.device, stage, &work.uniform, None, buffers)
        };
        let step = bound(&gpu.stages.step, &[&work.matter, &first, &work.source, light, steps]);
        let remember = [[&light_a, &step_a], [&light_b, &step_b]].map(|[light_change, step_change]| {
            let buffers = [light, steps, &light_before, &step_before, light_change, step_change];
            bound(&gpu.stages.remember, &buffers)
        });
        let measure = bound(&gpu.stages.measure, &[light, steps, &step_a, &step_b, &parts]);
        let mix = bound(&gpu.stages.mix, &[light, steps, &light_a, &step_a, &light_b, &step_b, &weights]);
        gpu.opened.check()?;
        Ok(Iteration { work, first, light_before, step_before, parts, weights, step, remember, measure, mix })
    }

    /// Does pass number `pass`, from 0 up: light -> step, and sums of both for each lane.
    fn pass(&self, pass: u32) -> Result<Vec<Products>, GpuError> {
        let Iteration { work, .. } = self;
        let stages = &work.gpu.stages;
        work.submit(|encoder| {
            {
                let mut recorded = encoder.begin_compute_pass(&Default::default());
                work.pass(&mut recorded);
                run(&mut recorded, &stages.step, &self.step, work.per_site());
                if let Some(before) = pass.checked_sub(1) {
                    let change = &self.remember[before as usize % MEMORY];
                    run(&mut recorded, &stages.remember, change, work.per_number());
                }
            }
            if pass == 0 {
                encoder.copy_buffer_to_buffer(&work.light, 0, &self.light_before, 0, None);
                encoder.copy_buffer_to_buffer(&work.sums, 0, &self.step_before, 0, None);
            }
            let mut recorded = encoder.begin_compute_pass(&Default::default());
            let lanes = work.params.lanes as usize;
            run(&mut recorded, &stages.measure, &self.measure, PARTS as usize * lanes);
        });
        let lanes = work.params.lanes as usize;
        work.read(&self.parts, |parts| {
            let mut sums = vec![Products::default(); lanes];
            for (at, part) in parts.chunks(SUMS).enumerate() {
                sums[at % lanes].add(part);
            }
            sums
        })
    }

    /// Takes the light on, by the weights of each lane.
    fn mix(&self, weights: &[[f32; 4]]) {
        let Iteration { work, .. } = self;
        work.gpu.opened.queue.write_buffer(&self.weights, 0, bytemuck::cast_slice(weights));
        work.submit(|encoder| {
            let mut recorded = encoder.begin_compute_pass(&Default::default());
            run(&mut recorded, &work.gpu.stages.mix, &self.mix, work.per_number());
        });
    }
}
