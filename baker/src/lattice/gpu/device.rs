//! Finds a GPU, opens it, and turns everything that goes wrong on it into an error.

use std::sync::{Arc, Mutex};

use super::super::error::GpuError;
use super::stages::{self, Stages};

/// Light of one group is kept in buffers of at most so many bytes each, whatever the GPU would allow: the host holds a
/// copy of one when a group is done.
const MOST_BUFFER_BYTES: u64 = 768 << 20;

/// An open GPU.
pub struct Gpu {
    pub device: wgpu::Device,
    pub queue: wgpu::Queue,
    /// Name and interface, for people.
    pub name: String,
    pub stages: Stages,
    fault: Arc<Mutex<Option<Fault>>>,
}

/// What the device reported first. Nothing that it computed since can be trusted.
#[derive(Debug, Clone)]
enum Fault {
    OutOfMemory(String),
    Other(String),
}

/// The name of the GPU that [`open`] would open.
pub fn find() -> Result<String, GpuError> {
    adapter().map(|(_, name)| name)
}

/// Opens the GPU that wgpu ranks highest; a software one only if there is no other.
pub fn open() -> Result<Gpu, GpuError> {
    let (adapter, name) = adapter()?;
    let offered = adapter.limits();
    let limits = wgpu::Limits {
        max_storage_buffer_binding_size: offered.max_storage_buffer_binding_size.min(MOST_BUFFER_BYTES),
        max_buffer_size: offered.max_buffer_size.min(MOST_BUFFER_BYTES),
        ..wgpu::Limits::default()
    };
    let wanted = wgpu::DeviceDescriptor {
        label: Some("flb"),
        required_limits: limits,
        ..wgpu::DeviceDescriptor::default()
    };
    let refused =
        |error: wgpu::RequestDeviceError| GpuError::Refused { adapter: name.clone(), message: chain(&error) };
    let (device, queue) = pollster::block_on(adapter.request_device(&wanted)).map_err(refused)?;
    let fault: Arc<Mutex<Option<Fault>>> = Arc::default();
    let noted = Arc::clone(&fault);
    device.on_uncaptured_error(Arc::new(move |error: wgpu::Error| {
        let message = chain(&error);
        note(
            &noted,
            match error {
                wgpu::Error::OutOfMemory { .. } => Fault::OutOfMemory(message),
                wgpu::Error::Validation { .. } | wgpu::Error::Internal { .. } => Fault::Other(message),
            },
        );
    }));
    let noted = Arc::clone(&fault);
    device.set_device_lost_callback(move |reason, message| {
        note(&noted, Fault::Other(format!("device lost ({reason:?}): {message}")));
    });
    let stages = stages::compile(&device);
    let gpu = Gpu { device, queue, name, stages, fault };
    gpu.check()?;
    Ok(gpu)
}

impl Gpu {
    /// Bytes of the largest buffer that a stage can bind.
    pub fn largest_buffer_bytes(&self) -> u64 {
        let limits = self.device.limits();
        limits.max_storage_buffer_binding_size.min(limits.max_buffer_size)
    }

    /// The first thing that went wrong so far, if anything did.
    pub fn check(&self) -> Result<(), GpuError> {
        let fault = self.fault.lock().map_or(None, |fault| fault.clone());
        let adapter = self.name.clone();
        match fault {
            None => Ok(()),
            Some(Fault::OutOfMemory(message)) => Err(GpuError::OutOfMemory { adapter, message }),
            Some(Fault::Other(message)) => Err(GpuError::Failed { adapter, message }),
        }
    }

    /// Waits until all submitted work is done.
    pub fn wait(&self) -> Result<(), GpuError> {
        // Waiting on a lost device would end in a panic.
        self.check()?;
        let waited = self.device.poll(wgpu::PollType::wait_indefinitely());
        self.check()?;
        waited
            .map(drop)
            .map_err(|error| GpuError::Failed { adapter: self.name.clone(), message: chain(&error) })
    }

    /// Copies bytes of a buffer to the host through `staging` (MAP_READ) and hands them to `take`.
    pub fn read(
        &self,
        buffer: &wgpu::Buffer,
        bytes: std::ops::Range<u64>,
        staging: &wgpu::Buffer,
        take: impl FnOnce(&[f32]),
    ) -> Result<(), GpuError> {
        let length = bytes.end - bytes.start;
        let mut encoder = self.device.create_command_encoder(&Default::default());
        encoder.copy_buffer_to_buffer(buffer, bytes.start, staging, 0, length);
        self.queue.submit([encoder.finish()]);
        let failed = |message: String| GpuError::Failed { adapter: self.name.clone(), message };
        let mapped = Arc::new(Mutex::new(Err("it was not mapped".to_owned())));
        let result = Arc::clone(&mapped);
        staging.map_async(wgpu::MapMode::Read, 0..length, move |done| {
            if let Ok(mut result) = result.lock() {
                *result = done.map_err(|error| chain(&error));
            }
        });
        self.wait()?;
        let outcome = mapped.lock().map_or(Ok(()), |mapped| mapped.clone());
        outcome.map_err(|message| failed(format!("reading back: {message}")))?;
        let view = staging.get_mapped_range(0..length).map_err(|error| failed(chain(&error)))?;
        take(bytemuck::cast_slice(&view));
        drop(view);
        staging.unmap();
        Ok(())
    }
}

fn note(fault: &Mutex<Option<Fault>>, found: Fault) {
    if let Ok(mut fault) = fault.lock() {
        fault.get_or_insert(found);
    }
}

/// OpenGL is asked only where nothing better is there: its drivers talk on stderr.
fn adapter() -> Result<(wgpu::Adapter, String), GpuError> {
    let wanted = wgpu::InstanceDescriptor::new_without_display_handle_from_env().backends;
    let [first, last] = [wanted & wgpu::Backends::PRIMARY, wanted & !wgpu::Backends::PRIMARY];
    let adapter = match request(first) {
        Err(_) if !last.is_empty() => request(last),
        found => found,
    };
    let adapter = adapter.map_err(|error| GpuError::NoAdapter {
        looked_for: wanted.iter_names().map(|(name, _)| name).collect::<Vec<_>>().join(", "),
        message: chain(&error),
    })?;
    let info = adapter.get_info();
    let name = format!("{} ({:?}, {:?})", info.name, info.backend, info.device_type);
    Ok((adapter, name))
}

fn request(backends: wgpu::Backends) -> Result<wgpu::Adapter, wgpu::RequestAdapterError> {
    let instance = wgpu::Instance::new(wgpu::InstanceDescriptor {
        backends,
        ..wgpu::InstanceDescriptor::new_without_display_handle_from_env()
    });
    pollster::block_on(instance.request_adapter(&wgpu::RequestAdapterOptions {
        power_preference: wgpu::PowerPreference::HighPerformance,
        ..wgpu::RequestAdapterOptions::default()
    }))
}

/// An error and its causes, in one line.
fn chain(error: &dyn std::error::Error) -> String {
    let mut text = error.to_string();
    let mut cause = error.source();
    while let Some(error) = cause {
        text = format!("{text}: {error}");
        cause = error.source();
    }
    text.split_whitespace().collect::<Vec<_>>().join(" ")
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_first_fault_is_the_one_that_is_told() {
        let gpu = open().unwrap_or_else(|error| panic!("{error}"));
        assert_eq!(gpu.check(), Ok(()));
        note(&gpu.fault, Fault::OutOfMemory("heap 0 is full".to_owned()));
        note(&gpu.fault, Fault::Other("what followed from it".to_owned()));
        let error = gpu.wait().unwrap_err();
        assert!(matches!(error, GpuError::OutOfMemory { .. }), "{error:?}");
        for part in [&gpu.name, "out of memory", "heap 0 is full"] {
            assert!(error.to_string().contains(part), "{error}");
        }
    }

    #[test]
    fn what_the_device_refuses_is_an_error() {
        let gpu = open().unwrap_or_else(|error| panic!("{error}"));
        // WebGPU has no buffer that is mapped for reading and bound to a shader.
        let _ = gpu.device.create_buffer(&wgpu::BufferDescriptor {
            label: Some("impossible"),
            size: 16,
            usage: wgpu::BufferUsages::MAP_READ | wgpu::BufferUsages::STORAGE,
            mapped_at_creation: false,
        });
        let error = gpu.check().unwrap_err();
        assert!(
            matches!(&error, GpuError::Failed { message, .. } if message.contains("impossible")),
            "{error:?}"
        );
    }
}
