//! Chooses an adapter: the one that wgpu ranks highest; software only if there is no other.

use std::sync::{Mutex, PoisonError};

use crate::{DeviceError, error::chain};

/// A GPU that could be opened.
#[derive(Debug, Clone, PartialEq, Eq)]
pub struct Found {
    /// Name and interface, for people.
    pub name: String,
    /// Whether the adapter is software that stands in for a GPU, on the same cores as everything else.
    pub is_software: bool,
}

/// The GPU that [`Gpu::open`](crate::Gpu::open) would open.
///
/// # Errors
/// [`DeviceError::NoAdapter`].
pub fn find() -> Result<Found, DeviceError> {
    adapter().map(|(_, found)| found)
}

/// The GPUs that [`Gpu::open_alike`](crate::Gpu::open_alike) would open.
///
/// # Errors
/// [`DeviceError::NoAdapter`].
pub fn find_alike(most: usize) -> Result<Vec<Found>, DeviceError> {
    Ok(alike(most)?.into_iter().map(|(_, found)| found).collect())
}

/// The GPU that wgpu ranks highest and others of its name, one at least.
pub(crate) fn alike(most: usize) -> Result<Vec<(wgpu::Adapter, Found)>, DeviceError> {
    adapters(most, |best, other| best == other)
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

/// That one, and after it so many others that are `wanted` beside it and reached in the same way, so that none is named
/// twice; software only if it is software itself.
pub(crate) fn adapters(
    most: usize,
    wanted: impl Fn(&Found, &Found) -> bool,
) -> Result<Vec<(wgpu::Adapter, Found)>, DeviceError> {
    let (best, found) = adapter()?;
    if most <= 1 {
        return Ok(vec![(best, found)]);
    }
    let backends = wgpu::Backends::from(best.get_info().backend);
    let all = pollster::block_on(instance(backends).enumerate_adapters(backends));
    let with_found = |adapter: wgpu::Adapter| {
        let found = describe(&adapter.get_info());
        (adapter, found)
    };
    let mut all: Vec<_> =
        all.into_iter().map(with_found).filter(|(_, other)| other.is_software == found.is_software).collect();
    match all.iter().position(|(_, other)| *other == found) {
        Some(first) => all[..=first].rotate_right(1),
        None => all.insert(0, (best, found.clone())),
    }
    all.retain(|(_, other)| wanted(&found, other));
    all.truncate(most);
    Ok(all)
}

pub(crate) fn describe(info: &wgpu::AdapterInfo) -> Found {
    Found {
        name: format!("{} ({:?}, {:?})", info.name, info.backend, info.device_type),
        is_software: info.device_type == wgpu::DeviceType::Cpu,
    }
}

/// Every device of the process comes from one instance for its backends, which stays: each further one would load the
/// driver again, and drivers do not give back all that they took (NVIDIA's was refused, and crashed, after about
/// thirty).
fn instance(backends: wgpu::Backends) -> wgpu::Instance {
    static MADE: Mutex<Vec<(wgpu::Backends, wgpu::Instance)>> = Mutex::new(Vec::new());
    let mut made = MADE.lock().unwrap_or_else(PoisonError::into_inner);
    if let Some((_, one)) = made.iter().find(|(of, _)| *of == backends) {
        return one.clone();
    }
    let one = wgpu::Instance::new(wgpu::InstanceDescriptor {
        backends,
        ..wgpu::InstanceDescriptor::new_without_display_handle_from_env()
    });
    made.push((backends, one.clone()));
    one
}

fn request(backends: wgpu::Backends) -> Result<wgpu::Adapter, wgpu::RequestAdapterError> {
    pollster::block_on(instance(backends).request_adapter(&wgpu::RequestAdapterOptions {
        power_preference: wgpu::PowerPreference::HighPerformance,
        ..wgpu::RequestAdapterOptions::default()
    }))
}
