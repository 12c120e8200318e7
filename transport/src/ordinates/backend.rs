//! Where light is marched: on the cores, or on a GPU.

use flb_format::progress::Progress;

use super::band::Band;
use super::error::OrdinatesError;
#[cfg(feature = "gpu")]
use super::gpu;
use super::scatter::{Lit, Scattering};
use crate::gpu::GpuError;

/// Machine that a solve marches light on.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default)]
pub enum Backend {
    /// Every core. The bytes are the same on every machine.
    #[default]
    Cpu,
    /// GPU that [`find_gpu`](crate::gpu::find_gpu) names. Its light is that of the cores within 1e-4, with the same
    /// bytes on the same GPU and driver. Needs the feature `gpu`.
    Gpu {
        /// Most GPUs of its kind that share the bands of a solve ([`find_gpus`](crate::gpu::find_gpus)); they change no
        /// bit of it.
        most: usize,
    },
}

impl Backend {
    /// The GPU that is ranked highest.
    pub const GPU: Backend = Backend::Gpu { most: 1 };

    /// Whether a GPU solves.
    pub fn is_gpu(self) -> bool {
        self != Backend::Cpu
    }
}

/// A backend that is ready.
pub(super) enum Marcher {
    Cpu,
    #[cfg(feature = "gpu")]
    Gpus(Vec<gpu::Gpu>),
}

impl Backend {
    pub(super) fn open(self) -> Result<Marcher, GpuError> {
        match self {
            Backend::Cpu => Ok(Marcher::Cpu),
            #[cfg(feature = "gpu")]
            Backend::Gpu { most } => Ok(Marcher::Gpus(gpu::open(most)?)),
            #[cfg(not(feature = "gpu"))]
            Backend::Gpu { .. } => Err(GpuError::NotBuilt),
        }
    }
}

impl Marcher {
    /// See [`Scattering::scatter`].
    pub(super) fn scatter(
        &self,
        scattering: &Scattering,
        bands: &[Band],
        progress: &Progress<'_>,
    ) -> Result<Vec<Lit>, OrdinatesError> {
        match self {
            Marcher::Cpu => Ok(scattering.scatter(bands, progress)?),
            #[cfg(feature = "gpu")]
            Marcher::Gpus(gpus) => gpu::scatter(gpus, scattering, bands, progress),
        }
    }
}
