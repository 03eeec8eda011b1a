//! The blocked kernel, compiled for instruction sets that not every x86-64 processor has.
#![expect(unsafe_code, reason = "calls into functions compiled for a detected instruction set")]

use super::{Job, SimdPath, tile};

/// Runs on `path`, or on the widest narrower one where the processor lacks it.
pub(super) fn run(path: SimdPath, job: Job<'_>) {
    if path == SimdPath::Avx512 && path.is_available() {
        // SAFETY: the processor has AVX-512F, as just checked.
        unsafe { avx512(job) }
    } else if SimdPath::Avx2.is_available() {
        // SAFETY: the processor has AVX2, as just checked.
        unsafe { avx2(job) }
    } else {
        tile::baseline(job);
    }
}

/// 32 registers of 16 lanes: 16 sums.
#[target_feature(enable = "avx512f")]
fn avx512(job: Job<'_>) {
    tile::run::<8, 2, 4>(job);
}

/// 16 registers of 8 lanes: 8 sums.
#[target_feature(enable = "avx2")]
fn avx2(job: Job<'_>) {
    tile::run::<4, 1, 2>(job);
}
