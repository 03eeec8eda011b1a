//! What the networks train on.

use std::{fmt, str::FromStr};

use burn::tensor::Device;
use serde::{Deserialize, Serialize};

use crate::TrainError;

/// What the networks train on. Only [`Processor::Cpu`] gives the same bits in every run.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Serialize, Deserialize)]
#[serde(rename_all = "lowercase")]
#[non_exhaustive]
pub enum Processor {
    /// The main processor.
    #[default]
    Cpu,
    /// An NVIDIA GPU (feature `cuda`).
    Cuda,
    /// Any GPU, by way of WebGPU (feature `wgpu`).
    Wgpu,
}

impl fmt::Display for Processor {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        f.pad(match self {
            Self::Cpu => "cpu",
            Self::Cuda => "cuda",
            Self::Wgpu => "wgpu",
        })
    }
}

impl FromStr for Processor {
    type Err = TrainError;

    fn from_str(name: &str) -> Result<Self, TrainError> {
        [Self::Cpu, Self::Cuda, Self::Wgpu]
            .into_iter()
            .find(|processor| processor.to_string() == name)
            .ok_or_else(|| TrainError::Option {
                option: "device".into(),
                value: format!("`{name}`"),
                expected: "`cpu`, `cuda` or `wgpu`",
            })
    }
}

impl Processor {
    /// Burn's handle for it, without gradients.
    pub(crate) fn device(self) -> Result<Device, TrainError> {
        match self {
            Self::Cpu => Ok(Device::flex()),
            #[cfg(feature = "cuda")]
            Self::Cuda => Ok(Device::cuda(0usize)),
            #[cfg(feature = "wgpu")]
            Self::Wgpu => Ok(Device::wgpu(burn::tensor::DeviceKind::DefaultDevice)),
            #[cfg(not(all(feature = "cuda", feature = "wgpu")))]
            missing => Err(TrainError::Processor { processor: missing }),
        }
    }
}
