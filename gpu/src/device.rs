//! An open device, and the first fault that it reported.

use std::sync::{Arc, Mutex, PoisonError};

use crate::{
    DeviceError, Found,
    adapter::{self, describe},
    error::chain,
};

/// An open GPU. A clone is the same one.
#[derive(Clone)]
pub struct Gpu {
    /// The device.
    pub device: wgpu::Device,
    /// Queue of the device.
    pub queue: wgpu::Queue,
    /// Name and interface, for people.
    pub name: String,
    /// Whether the device is software that stands in for a GPU.
    pub is_software: bool,
    pub(crate) fault: Arc<Mutex<Option<Fault>>>,
}

/// What the device reported first.
#[derive(Debug, Clone)]
pub(crate) enum Fault {
    OutOfMemory(String),
    Other(String),
}

impl Gpu {
    /// Opens the GPU that wgpu ranks highest, with WebGPU's default limits and those of `wanted` that it has; a
    /// software one only if there is no other.
    ///
    /// # Errors
    /// [`DeviceError::NoAdapter`], [`DeviceError::Refused`].
    pub fn open(wanted: wgpu::Features) -> Result<Gpu, DeviceError> {
        open(wanted, |_| wgpu::Limits::default())
    }

    /// Opens the GPU of [`Gpu::open`] and the next ones, up to so many as are asked for and as there are: at least one.
    ///
    /// # Errors
    /// As [`Gpu::open`], of any of them.
    pub fn open_up_to(wanted: wgpu::Features, most: usize) -> Result<Vec<Gpu>, DeviceError> {
        let all = adapter::adapters(most, |_, _| true)?.into_iter();
        all.map(|one| open_on(one, wanted, |_| wgpu::Limits::default())).collect()
    }

    /// Opens the GPU of [`Gpu::open`] and others of its kind, up to so many as are asked for and as there are: at least
    /// one; with buffers, and bindings of them, as large as they have, up to so many bytes. All compute the same.
    ///
    /// # Errors
    /// As [`Gpu::open`], of any of them.
    pub fn open_alike(wanted: wgpu::Features, most_bytes: u64, most: usize) -> Result<Vec<Gpu>, DeviceError> {
        let all = adapter::alike(most)?.into_iter();
        let limits = |offered: wgpu::Limits| wgpu::Limits {
            max_storage_buffer_binding_size: offered.max_storage_buffer_binding_size.min(most_bytes),
            max_buffer_size: offered.max_buffer_size.min(most_bytes),
            ..wgpu::Limits::default()
        };
        all.map(|one| open_on(one, wanted, limits)).collect()
    }

    /// Watches a device that is open already, as a renderer's. The handlers of its errors are replaced.
    pub fn adopt(adapter: &wgpu::Adapter, device: wgpu::Device, queue: wgpu::Queue) -> Gpu {
        watched(describe(&adapter.get_info()), device, queue)
    }

    /// Bytes of the largest buffer that a shader can bind.
    pub fn largest_buffer_bytes(&self) -> u64 {
        let limits = self.device.limits();
        limits.max_storage_buffer_binding_size.min(limits.max_buffer_size)
    }

    /// Returns the first fault of the device so far, if there was one.
    ///
    /// # Errors
    /// [`DeviceError::OutOfMemory`], [`DeviceError::Failed`].
    pub fn check(&self) -> Result<(), DeviceError> {
        let fault = self.fault.lock().map_or(None, |fault| fault.clone());
        match fault {
            None => Ok(()),
            Some(Fault::OutOfMemory(message)) => {
                Err(DeviceError::OutOfMemory { adapter: self.name.clone(), message })
            }
            Some(Fault::Other(message)) => Err(self.failed(message)),
        }
    }

    pub(crate) fn failed(&self, message: String) -> DeviceError {
        DeviceError::Failed { adapter: self.name.clone(), message }
    }
}

pub(crate) fn open(
    wanted: wgpu::Features,
    limits: impl FnOnce(wgpu::Limits) -> wgpu::Limits,
) -> Result<Gpu, DeviceError> {
    open_on(adapter::adapter()?, wanted, limits)
}

fn open_on(
    (adapter, found): (wgpu::Adapter, Found),
    wanted: wgpu::Features,
    limits: impl FnOnce(wgpu::Limits) -> wgpu::Limits,
) -> Result<Gpu, DeviceError> {
    let descriptor = wgpu::DeviceDescriptor {
        label: Some("flb"),
        required_features: adapter.features() & wanted,
        required_limits: limits(adapter.limits()),
        ..wgpu::DeviceDescriptor::default()
    };
    let refused = |error: wgpu::RequestDeviceError| DeviceError::Refused {
        adapter: found.name.clone(),
        message: chain(&error),
    };
    // One after the other: NVIDIA's driver was seen to hang where threads opened devices at once.
    static OPENING: Mutex<()> = Mutex::new(());
    let one_at_a_time = OPENING.lock().unwrap_or_else(PoisonError::into_inner);
    let (device, queue) = pollster::block_on(adapter.request_device(&descriptor)).map_err(refused)?;
    drop(one_at_a_time);
    Ok(watched(found, device, queue))
}

fn watched(found: Found, device: wgpu::Device, queue: wgpu::Queue) -> Gpu {
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
    Gpu { device, queue, name: found.name, is_software: found.is_software, fault }
}

pub(crate) fn note(fault: &Mutex<Option<Fault>>, found: Fault) {
    if let Ok(mut fault) = fault.lock() {
        fault.get_or_insert(found);
    }
}
