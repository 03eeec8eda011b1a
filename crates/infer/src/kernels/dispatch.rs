//! From the name of an instruction set to the kernel compiled for it.

use fearless_simd::{Level, Simd};

use super::{Job, SimdPath, scalar, tile};

/// Does this processor have the path?
pub(super) fn is_available(path: SimdPath) -> bool {
    let level = Level::new();
    match path {
        SimdPath::Scalar => true,
        #[cfg(target_arch = "x86_64")]
        SimdPath::Sse2 => level.as_sse2().is_some(),
        #[cfg(target_arch = "x86_64")]
        SimdPath::Avx2 => level.as_avx2().is_some(),
        #[cfg(target_arch = "x86_64")]
        SimdPath::Avx512 => level.as_avx512().is_some(),
        #[cfg(target_arch = "aarch64")]
        SimdPath::Neon => level.as_neon().is_some(),
        #[cfg(all(target_arch = "wasm32", target_feature = "simd128"))]
        SimdPath::Simd128 => level.as_wasm_simd128().is_some(),
        _ => false,
    }
}

/// Runs a layer. A path that this processor lacks gives way to a narrower one with the same bits.
///
/// The numbers are the rows and panels of a tile: as many sums as the registers hold, with a few
/// left for weights and products.
pub(crate) fn run(path: SimdPath, job: Job<'_>) {
    let level = Level::new();
    #[cfg(target_arch = "x86_64")]
    {
        let wide = matches!(path, SimdPath::Avx512 | SimdPath::Avx2);
        if let (SimdPath::Avx512, Some(simd)) = (path, level.as_avx512()) {
            // 32 registers of 16 lanes.
            return simd.vectorize(
                #[inline(always)]
                || tile::run::<_, 8, 2, 4>(simd, job),
            );
        }
        if let (true, Some(simd)) = (wide, level.as_avx2()) {
            // 16 registers of 8 lanes.
            return simd.vectorize(
                #[inline(always)]
                || tile::run::<_, 4, 1, 2>(simd, job),
            );
        }
        if let (true, Some(simd)) = (path != SimdPath::Scalar, level.as_sse2()) {
            // 16 registers of 4 lanes.
            return simd.vectorize(
                #[inline(always)]
                || tile::run::<_, 2, 1, 2>(simd, job),
            );
        }
    }
    #[cfg(target_arch = "aarch64")]
    if let (true, Some(simd)) = (path != SimdPath::Scalar, level.as_neon()) {
        // 32 registers of 4 lanes.
        return simd.vectorize(
            #[inline(always)]
            || tile::run::<_, 4, 1, 4>(simd, job),
        );
    }
    #[cfg(all(target_arch = "wasm32", target_feature = "simd128"))]
    if let (true, Some(simd)) = (path != SimdPath::Scalar, level.as_wasm_simd128()) {
        return simd.vectorize(
            #[inline(always)]
            || tile::run::<_, 2, 1, 2>(simd, job),
        );
    }
    let _ = (path, level);
    scalar::run(job);
}
