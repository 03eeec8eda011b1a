//! From the name of an instruction set to the kernel compiled for it.

use fearless_simd::{Level, Simd, dispatch, prelude::*};

use super::{Job, SimdPath, scalar, tile};

/// Does this processor have the path?
pub(super) fn is_available(path: SimdPath) -> bool {
    path == SimdPath::Scalar || level(path).is_some()
}

/// Runs a layer. A path that this processor lacks gives way to what every processor of the target
/// has, with the same bits.
pub(crate) fn run(path: SimdPath, job: Job<'_>) {
    if path == SimdPath::Scalar {
        scalar::run(job);
    } else {
        let level = level(path).unwrap_or(Level::baseline());
        dispatch!(level, simd => run_tiles(simd, job));
    }
}

/// The proof that this processor has the path.
fn level(path: SimdPath) -> Option<Level> {
    match path {
        #[cfg(target_arch = "x86_64")]
        SimdPath::Sse2 => Level::new().as_sse2().map(Simd::level),
        #[cfg(target_arch = "x86_64")]
        SimdPath::Avx2 => Level::new().as_avx2().map(Simd::level),
        #[cfg(target_arch = "x86_64")]
        SimdPath::Avx512 => Level::new().as_avx512().map(Simd::level),
        #[cfg(target_arch = "aarch64")]
        SimdPath::Neon => Level::new().as_neon().map(Simd::level),
        #[cfg(all(target_arch = "wasm32", target_feature = "simd128"))]
        SimdPath::Simd128 => Level::new().as_wasm_simd128().map(Simd::level),
        _ => None,
    }
}

/// Chooses the rows and panels of a tile: as many sums as the registers hold, with a few left for
/// weights and products.
#[inline(always)]
fn run_tiles<S: Simd>(simd: S, job: Job<'_>) {
    match <S::f32s as SimdBase<S>>::LEN {
        // AVX-512: 32 registers, 16 of them sums.
        16 => tile::run::<S, 8, 2, 4>(simd, job),
        // AVX2: 16 registers, 8 of them sums.
        8 => tile::run::<S, 4, 1, 2>(simd, job),
        // NEON: 32 registers, 16 of them sums.
        _ if cfg!(target_arch = "aarch64") => tile::run::<S, 4, 1, 4>(simd, job),
        // SSE2 and wasm: 16 registers, 8 of them sums.
        _ => tile::run::<S, 2, 1, 2>(simd, job),
    }
}
