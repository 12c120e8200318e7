//! Finds and opens a GPU, for programs that have none open: tests, benchmarks, the command. A renderer hands in its own.

use std::sync::{Arc, Mutex};

use super::GpuError;

/// An open GPU.
pub struct Gpu {
    /// The device.
    pub device: wgpu::Device,
    /// Its queue.
    pub queue: wgpu::Queue,
    /// Name and interface, for people.
    pub name: String,
    fault: Arc<Mutex<Option<String>>>,
}

impl Gpu {
    /// Opens the GPU that wgpu ranks highest, with WebGPU's default limits and those of `wanted` that it has; a software
    /// one only if there is no other.
    ///
    /// # Errors
    /// [`GpuError::NoAdapter`], [`GpuError::Refused`].
    pub fn open(wanted: wgpu::Features) -> Result<Gpu, GpuError> {
        let (adapter, name) = adapter()?;
        let descriptor = wgpu::DeviceDescriptor {
            label: Some("flb"),
            required_features: adapter.features() & wanted,
            ..wgpu::DeviceDescriptor::default()
        };
        let refused = |error: wgpu::RequestDeviceError| GpuError::Refused {
            adapter: name.clone(),
            message: chain(&error),
        };
        let (device, queue) = pollster::block_on(adapter.request_device(&descriptor)).map_err(refused)?;
        let fault: Arc<Mutex<Option<String>>> = Arc::default();
        let noted = Arc::clone(&fault);
        device.on_uncaptured_error(Arc::new(move |error: wgpu::Error| note(&noted, chain(&error))));
        let noted = Arc::clone(&fault);
        device.set_device_lost_callback(move |reason, message| {
            note(&noted, format!("device lost ({reason:?}): {message}"));
        });
        Ok(Gpu { device, queue, name, fault })
    }

    /// The first thing that went wrong so far, if anything did. Nothing that was computed since can be trusted.
    ///
    /// # Errors
    /// [`GpuError::Failed`].
    pub fn check(&self) -> Result<(), GpuError> {
        match self.fault.lock().map_or(None, |fault| fault.clone()) {
            None => Ok(()),
            Some(message) => Err(self.failed(message)),
        }
    }

    /// Waits until all submitted work is done.
    ///
    /// # Errors
    /// [`GpuError::Failed`].
    pub fn wait(&self) -> Result<(), GpuError> {
        // Waiting on a lost device would end in a panic.
        self.check()?;
        let waited = self.device.poll(wgpu::PollType::wait_indefinitely());
        self.check()?;
        waited.map(drop).map_err(|error| self.failed(chain(&error)))
    }

    /// The bytes of a buffer that can be copied from.
    ///
    /// # Errors
    /// [`GpuError::Failed`].
    pub fn read(&self, buffer: &wgpu::Buffer) -> Result<Vec<u8>, GpuError> {
        let staging = self.device.create_buffer(&wgpu::BufferDescriptor {
            label: Some("flb staging"),
            size: buffer.size(),
            usage: wgpu::BufferUsages::MAP_READ | wgpu::BufferUsages::COPY_DST,
            mapped_at_creation: false,
        });
        let mut encoder = self.device.create_command_encoder(&Default::default());
        encoder.copy_buffer_to_buffer(buffer, 0, &staging, 0, buffer.size());
        self.queue.submit([encoder.finish()]);
        let mapped = Arc::new(Mutex::new(Err("it was not mapped".to_owned())));
        let result = Arc::clone(&mapped);
        staging.map_async(wgpu::MapMode::Read, .., move |done| {
            if let Ok(mut result) = result.lock() {
                *result = done.map_err(|error| chain(&error));
            }
        });
        self.wait()?;
        let outcome = mapped.lock().map_or(Ok(()), |mapped| mapped.clone());
        outcome.map_err(|message| self.failed(format!("reading back: {message}")))?;
        let view = staging.get_mapped_range(..).map_err(|error| self.failed(chain(&error)))?;
        Ok(view.to_vec())
    }

    fn failed(&self, message: String) -> GpuError {
        GpuError::Failed { adapter: self.name.clone(), message }
    }
}

fn note(fault: &Mutex<Option<String>>, found: String) {
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
    fn what_the_device_refuses_is_an_error_and_the_first_is_told() {
        let gpu = Gpu::open(wgpu::Features::empty()).unwrap_or_else(|error| panic!("{error}"));
        assert_eq!(gpu.check(), Ok(()));
        // WebGPU has no buffer that is mapped for reading and bound to a shader.
        let _ = gpu.device.create_buffer(&wgpu::BufferDescriptor {
            label: Some("impossible"),
            size: 16,
            usage: wgpu::BufferUsages::MAP_READ | wgpu::BufferUsages::STORAGE,
            mapped_at_creation: false,
        });
        note(&gpu.fault, "what followed from it".to_owned());
        let error = gpu.wait().unwrap_err().to_string();
        assert!(error.contains("impossible") && error.contains(&gpu.name), "{error}");
    }
}
