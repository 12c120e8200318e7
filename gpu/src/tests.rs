//! They need an adapter, and fail without one; lavapipe (`scripts/setup test` installs it) will do.

use std::time::Duration;

use super::device::{Fault, note};
use super::*;

fn gpu() -> Gpu {
    // The message says what to install.
    Gpu::open(wgpu::Features::empty()).unwrap_or_else(|error| panic!("{error}"))
}

fn buffer(gpu: &Gpu, label: &str, size: u64, usage: wgpu::BufferUsages) -> wgpu::Buffer {
    gpu.device.create_buffer(&wgpu::BufferDescriptor {
        label: Some(label),
        size,
        usage,
        mapped_at_creation: false,
    })
}

#[test]
fn the_first_fault_is_the_one_that_is_told() {
    let gpu = gpu();
    assert_eq!(gpu.check(), Ok(()));
    note(&gpu.fault, Fault::OutOfMemory("heap 0 is full".to_owned()));
    note(&gpu.fault, Fault::Other("what followed from it".to_owned()));
    let error = gpu.wait().unwrap_err();
    assert!(matches!(error, DeviceError::OutOfMemory { .. }), "{error:?}");
    for part in [&gpu.name, "out of memory", "heap 0 is full"] {
        assert!(error.to_string().contains(part), "{error}");
    }
}

#[test]
fn what_the_device_refuses_is_an_error() {
    let gpu = gpu();
    // WebGPU has no buffer that is mapped for reading and bound to a shader.
    buffer(&gpu, "impossible", 16, wgpu::BufferUsages::MAP_READ | wgpu::BufferUsages::STORAGE);
    let error = gpu.check().unwrap_err();
    assert!(
        matches!(&error, DeviceError::Failed { message, .. } if message.contains("impossible")),
        "{error:?}"
    );
    assert!(error.to_string().contains(&gpu.name), "{error}");
}

#[test]
fn a_lost_device_is_an_error_wherever_results_are_taken() {
    let gpu = gpu();
    let kept = buffer(&gpu, "kept", 16, wgpu::BufferUsages::COPY_SRC);
    gpu.device.destroy();
    for error in [gpu.wait().unwrap_err(), gpu.read(&kept).unwrap_err()] {
        assert!(matches!(&error, DeviceError::Failed { adapter, .. } if *adapter == gpu.name), "{error:?}");
    }
}

#[test]
fn more_than_the_gpu_has_is_refused_with_its_name() {
    let found = find().unwrap_or_else(|error| panic!("{error}"));
    let opened = device::open(wgpu::Features::empty(), |offered| wgpu::Limits {
        max_texture_dimension_1d: u32::MAX,
        ..offered
    });
    let error = opened.err().expect("no GPU has textures so long");
    assert!(matches!(&error, DeviceError::Refused { adapter, .. } if *adapter == found.name), "{error:?}");
    assert!(error.to_string().contains("cannot be opened"), "{error}");
}

#[test]
fn no_more_gpus_are_opened_than_asked_for_and_the_best_is_the_first() {
    let best = find().unwrap();
    let names = |most| -> Vec<String> {
        let opened = Gpu::open_up_to(wgpu::Features::empty(), most).unwrap();
        opened.iter().for_each(|gpu| assert_eq!((gpu.check(), gpu.is_software), (Ok(()), best.is_software)));
        opened.into_iter().map(|gpu| gpu.name).collect()
    };
    assert_eq!((names(0), names(1)), (vec![best.name.clone()], vec![best.name.clone()]));
    let all = names(usize::MAX);
    assert_eq!(all[0], best.name);
    assert_eq!(names(2), all[..all.len().min(2)]);
}

#[test]
fn buffers_are_as_large_as_was_asked_for() {
    const BYTES: u64 = 64 << 20;
    let gpu = Gpu::open_alike(wgpu::Features::empty(), BYTES, 1).unwrap().remove(0);
    assert_eq!(gpu.largest_buffer_bytes(), BYTES);
    assert_eq!(gpu.name, find().unwrap().name);
}

#[test]
fn what_was_written_is_read_whole_and_in_part() {
    let gpu = gpu();
    let usage = wgpu::BufferUsages::COPY_SRC | wgpu::BufferUsages::COPY_DST;
    let source = buffer(&gpu, "source", 16, usage);
    let bytes: Vec<u8> = (1..=16).collect();
    gpu.queue.write_buffer(&source, 0, &bytes);
    assert_eq!(gpu.read(&source).unwrap(), bytes);
    let staging = buffer(&gpu, "staging", 8, wgpu::BufferUsages::MAP_READ | wgpu::BufferUsages::COPY_DST);
    let mut part = Vec::new();
    gpu.read_through(&source, 4..12, &staging, |view| part = view.to_vec()).unwrap();
    assert_eq!(part, bytes[4..12]);
}

#[test]
fn a_device_that_a_program_opened_itself_is_watched_too() {
    let (adapter, found) = adapter::adapter().unwrap();
    let (device, queue) = pollster::block_on(adapter.request_device(&Default::default())).unwrap();
    let gpu = Gpu::adopt(&adapter, device, queue);
    assert_eq!((&gpu.name, gpu.is_software), (&found.name, found.is_software));
    buffer(&gpu, "impossible", 16, wgpu::BufferUsages::MAP_READ | wgpu::BufferUsages::STORAGE);
    assert!(gpu.check().is_err());
}

#[test]
fn a_device_that_does_not_answer_is_an_error() {
    let gpu = gpu();
    // How fast a device is, and how long this thread is kept from asking it, is unknown: more work until it is late.
    let dispatches = std::iter::successors(Some(64), |&most| (most < 1 << 18).then_some(4 * most));
    let late = dispatches.into_iter().find_map(|dispatches| {
        keep_busy(&gpu, dispatches);
        gpu.wait_for(Duration::from_millis(1)).err()
    });
    let error = late.expect("a quarter of a million dispatches were answered in time");
    assert!(error.to_string().contains("no answer within 0.001 s"), "{error}");
    // Let it finish: a device that is dropped at work waits for it.
    gpu.wait().unwrap();
}

/// Some tenths of a millisecond of work for each dispatch: they are done one after another, as all write the same
/// buffer.
fn keep_busy(gpu: &Gpu, dispatches: u32) {
    let module = gpu.device.create_shader_module(wgpu::ShaderModuleDescriptor {
        label: Some("busy"),
        source: wgpu::ShaderSource::Wgsl(BUSY.into()),
    });
    let pipeline = gpu.device.create_compute_pipeline(&wgpu::ComputePipelineDescriptor {
        label: Some("busy"),
        layout: None,
        module: &module,
        entry_point: Some("busy"),
        compilation_options: Default::default(),
        cache: None,
    });
    let kept = buffer(gpu, "kept", 4 * 64, wgpu::BufferUsages::STORAGE);
    let group = gpu.device.create_bind_group(&wgpu::BindGroupDescriptor {
        label: Some("busy"),
        layout: &pipeline.get_bind_group_layout(0),
        entries: &[wgpu::BindGroupEntry { binding: 0, resource: kept.as_entire_binding() }],
    });
    let mut encoder = gpu.device.create_command_encoder(&Default::default());
    {
        let mut pass = encoder.begin_compute_pass(&Default::default());
        pass.set_pipeline(&pipeline);
        pass.set_bind_group(0, &group, &[]);
        (0..dispatches).for_each(|_| pass.dispatch_workgroups(1, 1, 1));
    }
    gpu.queue.submit([encoder.finish()]);
}

// Mesa's software ends the loops of an invocation after 65,535 rounds.
const BUSY: &str = "
@group(0) @binding(0) var<storage, read_write> kept: array<u32>;
@compute @workgroup_size(64)
fn busy(@builtin(local_invocation_index) at: u32) {
    var value = kept[at] ^ at;
    for (var round = 0u; round < 50000u; round++) {
        value = (value ^ (value >> 15u)) * 747796405u + 1u;
    }
    kept[at] = value;
}
";

#[test]
fn a_process_may_open_as_many_as_it_likes() {
    let open = || {
        for _ in 0..12 {
            assert_eq!(gpu().check(), Ok(()));
        }
    };
    std::thread::scope(|scope| (0..4).for_each(|_| drop(scope.spawn(open))));
}
