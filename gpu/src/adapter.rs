//! Chooses an adapter: the one that wgpu ranks highest; software only if there is no other.

use crate::{DeviceError, error::chain};

/// A GPU that could be opened.
#[derive(Debug, Clone, PartialEq, Eq)]
pub struct Found {
    /// Name and interface, for people.
    pub name: String,
    /// Whether it is software that stands in for a GPU, on the same cores as everything else.
    pub is_software: bool,
}

/// The GPU that [`Gpu::open`](crate::Gpu::open) would open.
///
/// # Errors
/// [`DeviceError::NoAdapter`].
pub fn find() -> Result<Found, DeviceError> {
    adapter().map(|(_, found)| found)
}

/// OpenGL is asked only where nothing better is there: its drivers talk on stderr.
pub(crate) fn adapter() -> Result<(wgpu::Adapter, Found), DeviceError> {
    let wanted = wgpu::InstanceDescriptor::new_without_display_handle_from_env().backends;
    let [first, last] = [wanted & wgpu::Backends::PRIMARY, wanted & !wgpu::Backends::PRIMARY];
    let adapter = match request(first) {
        Err(_) if !last.is_empty() => request(last),
        found => found,
    };
    let adapter = adapter.map_err(|error| DeviceError::NoAdapter {
        looked_for: wanted.iter_names().map(|(name, _)| name).collect::<Vec<_>>().join(", "),
        message: chain(&error),
    })?;
    let found = describe(&adapter.get_info());
    Ok((adapter, found))
}

pub(crate) fn describe(info: &wgpu::AdapterInfo) -> Found {
    Found {
        name: format!("{} ({:?}, {:?})", info.name, info.backend, info.device_type),
        is_software: info.device_type == wgpu::DeviceType::Cpu,
    }
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
