//! From the name of an instruction set to the kernel compiled for it.

use fearless_simd::{Level, Simd, dispatch, prelude::*};

use super::{Full, Job, Rows, SimdPath, scalar, strip};

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
        dispatch!(level, simd => run_strips(simd, job));
    }
}

/// Appends rows without their zeros.
pub(crate) fn thin(path: SimdPath, full: Full<'_>, rows: &mut Rows) {
    // Without a shuffle by table, lane by lane is the fastest way to close gaps.
    if matches!(path, SimdPath::Scalar | SimdPath::Sse2) {
        scalar::thin(full, rows);
    } else {
        let level = level(path).unwrap_or(Level::baseline());
        dispatch!(level, simd => strip::thin(simd, full, rows));
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

/// Chooses the width of a strip: as many sums as the registers hold, with a few left for an input
/// and its products.
#[inline(always)]
fn run_strips<S: Simd>(simd: S, job: Job<'_>) {
    match <S::f32s as SimdBase<S>>::LEN {
        // AVX-512: 32 registers, 8 of them sums.
        16 => strip::run::<S, 8>(simd, job),
        // AVX2: 16 registers, 8 of them sums.
        8 => strip::run::<S, 4>(simd, job),
        // NEON: 32 registers, 16 of them sums.
        _ if cfg!(target_arch = "aarch64") => strip::run::<S, 4>(simd, job),
        // SSE2 and wasm: 16 registers, 8 of them sums.
        _ => strip::run::<S, 2>(simd, job),
    }
}
