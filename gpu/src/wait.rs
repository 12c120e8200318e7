//! Waits for what was submitted, and brings bytes back. Both end: with what was asked for, or with an error.

use std::ops::Range;
use std::sync::{Arc, Mutex};
use std::time::Duration;

use crate::{DeviceError, Gpu, error::chain};

/// Longest wait for what was submitted. No work of ours takes so long in one submission, not even in software; a driver
/// that hangs does.
const MAX_WAIT: Duration = Duration::from_secs(600);

impl Gpu {
    /// Waits until all submitted work is done, for ten minutes at most.
    ///
    /// # Errors
    /// As [`Gpu::check`]; [`DeviceError::Failed`] as well where it does not answer.
    pub fn wait(&self) -> Result<(), DeviceError> {
        self.wait_for(MAX_WAIT)
    }

    pub(crate) fn wait_for(&self, longest: Duration) -> Result<(), DeviceError> {
        // Waiting on a lost device would end in a panic.
        self.check()?;
        let waited =
            self.device.poll(wgpu::PollType::Wait { submission_index: None, timeout: Some(longest) });
        self.check()?;
        waited.map(drop).map_err(|error| match error {
            wgpu::PollError::Timeout => self.failed(format!("no answer within {} s", longest.as_secs_f64())),
            error => self.failed(chain(&error)),
        })
    }

    /// The bytes of a buffer that can be copied from.
    ///
    /// # Errors
    /// As [`Gpu::wait`].
    pub fn read(&self, buffer: &wgpu::Buffer) -> Result<Vec<u8>, DeviceError> {
        let staging = self.device.create_buffer(&wgpu::BufferDescriptor {
            label: Some("flb staging"),
            size: buffer.size(),
            usage: wgpu::BufferUsages::MAP_READ | wgpu::BufferUsages::COPY_DST,
            mapped_at_creation: false,
        });
        let mut bytes = Vec::new();
        self.read_through(buffer, 0..buffer.size(), &staging, |view| bytes = view.to_vec())?;
        Ok(bytes)
    }

    /// Copies bytes of a buffer to the host through `staging` (MAP_READ) and hands them to `take`.
    ///
    /// # Errors
    /// As [`Gpu::wait`].
    pub fn read_through(
        &self,
        buffer: &wgpu::Buffer,
        bytes: Range<u64>,
        staging: &wgpu::Buffer,
        take: impl FnOnce(&[u8]),
    ) -> Result<(), DeviceError> {
        let length = bytes.end - bytes.start;
        let mut encoder = self.device.create_command_encoder(&Default::default());
        encoder.copy_buffer_to_buffer(buffer, bytes.start, staging, 0, length);
        self.queue.submit([encoder.finish()]);
        let mapped = Arc::new(Mutex::new(Err("it was not mapped".to_owned())));
        let result = Arc::clone(&mapped);
        staging.map_async(wgpu::MapMode::Read, 0..length, move |done| {
            if let Ok(mut result) = result.lock() {
                *result = done.map_err(|error| chain(&error));
            }
        });
        self.wait()?;
        let outcome = mapped.lock().map_or(Ok(()), |mapped| mapped.clone());
        outcome.map_err(|message| self.failed(format!("reading back: {message}")))?;
        let view = staging.get_mapped_range(0..length).map_err(|error| self.failed(chain(&error)))?;
        take(&view);
        drop(view);
        staging.unmap();
        Ok(())
    }
}
