//! Which instruction set the kernels run on.

use core::{fmt, str::FromStr};

use super::dispatch;

/// An instruction set the kernels can run on. All give the same bits; they differ in speed only.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash)]
#[non_exhaustive]
pub enum SimdPath {
    /// One output at a time: the definition of the result.
    Scalar,
    /// x86-64, 4 lanes; every such processor has it.
    Sse2,
    /// x86-64, 8 lanes.
    Avx2,
    /// x86-64, 16 lanes; from Ice Lake on, where it does not slow the processor down.
    Avx512,
    /// AArch64, 4 lanes; every such processor has it.
    Neon,
    /// WebAssembly, 4 lanes; for modules built with `simd128`.
    Simd128,
}

impl SimdPath {
    /// All paths, narrow before wide.
    pub const ALL: [Self; 6] =
        [Self::Scalar, Self::Sse2, Self::Neon, Self::Simd128, Self::Avx2, Self::Avx512];

    /// The widest path this processor has.
    #[must_use]
    pub fn detect() -> Self {
        Self::ALL.into_iter().rfind(|path| path.is_available()).unwrap_or(Self::Scalar)
    }

    /// The paths this processor has, narrow before wide; the first is [`SimdPath::Scalar`].
    #[must_use]
    pub fn available() -> Vec<Self> {
        Self::ALL.into_iter().filter(|path| path.is_available()).collect()
    }

    /// Does this processor have the path?
    #[must_use]
    pub fn is_available(self) -> bool {
        dispatch::is_available(self)
    }

    /// The name [`FromStr`] reads: `scalar`, `sse2`, `avx2`, `avx512`, `neon` or `simd128`.
    #[must_use]
    pub const fn name(self) -> &'static str {
        match self {
            Self::Scalar => "scalar",
            Self::Sse2 => "sse2",
            Self::Avx2 => "avx2",
            Self::Avx512 => "avx512",
            Self::Neon => "neon",
            Self::Simd128 => "simd128",
        }
    }
}

impl Default for SimdPath {
    fn default() -> Self {
        Self::detect()
    }
}

impl fmt::Display for SimdPath {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        f.pad(self.name())
    }
}

/// A name that no [`SimdPath`] has.
#[derive(Clone, Debug, PartialEq, Eq, thiserror::Error)]
#[error("no SIMD path is called `{name}`; there are scalar, sse2, avx2, avx512, neon and simd128")]
pub struct UnknownPath {
    /// The name as given.
    pub name: String,
}

impl FromStr for SimdPath {
    type Err = UnknownPath;

    fn from_str(name: &str) -> Result<Self, UnknownPath> {
        Self::ALL
            .into_iter()
            .find(|path| path.name() == name)
            .ok_or_else(|| UnknownPath { name: name.into() })
    }
}
