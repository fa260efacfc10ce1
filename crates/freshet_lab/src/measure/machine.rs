//! What the machine itself can do: how fast it copies memory and multiplies and adds, on as many threads as a solver gets.

use std::hint::black_box;
use std::time::Instant;

use pulp::{Arch, Simd, WithSimd};
use rayon::prelude::*;
use rayon::{ThreadPool, ThreadPoolBuilder};

use super::statistics::median;
use crate::error::LabError;

/// Rates of the processor on a number of threads.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Rates {
    /// Threads at work.
    pub threads: usize,
    /// Bytes read and written per second while copying what no cache holds. Lines that the processor reads only in order to
    /// overwrite them are not counted.
    pub copied_bytes: f64,
    /// Additions and multiplications per second in single precision, two for each multiply-add, in the widest lanes.
    pub operations: f64,
}

/// Repeats of each measurement, of which the median counts.
const REPEATS: usize = 7;
/// Values in each array of the copy: 128 MiB, several times the caches of any processor of today's desktops.
const COPIED: usize = 32 << 20;
/// Values that a thread copies at once.
const BLOCK: usize = 1 << 18;
/// Multiply-adds of each chain.
const ROUNDS: usize = 4_000_000;
/// Independent chains: two units of a latency of four cycles need eight, and twelve with two constants still fit into sixteen
/// registers.
const CHAINS: usize = 12;

impl Rates {
    /// Measures them; takes about a second and 256 MiB.
    ///
    /// # Errors
    /// If the threads cannot be started.
    pub fn measure(threads: usize) -> Result<Self, LabError> {
        Self::measure_with(threads, COPIED, ROUNDS)
    }

    fn measure_with(threads: usize, copied: usize, rounds: usize) -> Result<Self, LabError> {
        let failed = |error: rayon::ThreadPoolBuildError| LabError::Measure {
            what: "the machine's pace",
            reason: format!("{threads} threads cannot be started: {error}"),
        };
        let pool = ThreadPoolBuilder::new().num_threads(threads).build().map_err(failed)?;
        Ok(Self { threads, copied_bytes: copy_rate(&pool, copied), operations: multiply_add_rate(&pool, rounds) })
    }
}

fn copy_rate(pool: &ThreadPool, count: usize) -> f64 {
    let (from, mut to) = (vec![1.0_f32; count], vec![0.0_f32; count]);
    let bytes = 2.0 * (count * size_of::<f32>()) as f64;
    steady(|| {
        let start = Instant::now();
        pool.install(|| {
            let blocks = to.par_chunks_mut(BLOCK).zip(from.par_chunks(BLOCK));
            blocks.for_each(|(to, from)| to.copy_from_slice(black_box(from)));
        });
        black_box(&to);
        bytes / start.elapsed().as_secs_f64()
    })
}

fn multiply_add_rate(pool: &ThreadPool, rounds: usize) -> f64 {
    let arch = Arch::new();
    steady(|| {
        let start = Instant::now();
        let operations = pool.broadcast(|_| arch.dispatch(MultiplyAdds { rounds }));
        operations.iter().sum::<f64>() / start.elapsed().as_secs_f64()
    })
}

/// Median of the repeats after one that is thrown away: it touches the memory and wakes the threads.
fn steady(mut rate: impl FnMut() -> f64) -> f64 {
    rate();
    let rates: Vec<f64> = (0..REPEATS).map(|_| rate()).collect();
    median(&rates).unwrap_or(f64::NAN)
}

/// Chains of multiply-adds; returns how many operations they were.
struct MultiplyAdds {
    rounds: usize,
}

impl WithSimd for MultiplyAdds {
    type Output = f64;

    #[inline(always)]
    fn with_simd<S: Simd>(self, simd: S) -> f64 {
        let factor = simd.splat_f32s(black_box(0.999));
        let summand = simd.splat_f32s(black_box(0.001));
        let mut chains = [simd.splat_f32s(black_box(0.5)); CHAINS];
        for _ in 0..self.rounds {
            for chain in &mut chains {
                *chain = simd.mul_add_f32s(*chain, factor, summand);
            }
        }
        let mut sum = simd.splat_f32s(0.0);
        for chain in chains {
            sum = simd.add_f32s(sum, chain);
        }
        black_box(simd.reduce_sum_f32s(sum));
        2.0 * (self.rounds * CHAINS * S::F32_LANES) as f64
    }
}

/// What the processor calls itself, or its architecture where it cannot be asked.
pub fn processor_name() -> String {
    let info = std::fs::read_to_string("/proc/cpuinfo").unwrap_or_default();
    let name = info.lines().find_map(|line| line.strip_prefix("model name")?.split_once(':'));
    name.map_or_else(|| std::env::consts::ARCH.to_owned(), |(_, name)| name.trim().to_owned())
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn rates_are_of_this_world() -> Result<(), LabError> {
        let rates = Rates::measure_with(2, 1 << 20, 20_000)?;
        assert_eq!(rates.threads, 2);
        // From a tenth of what an old laptop does to ten times what a server does.
        assert!((1e8..1e13).contains(&rates.copied_bytes), "{rates:?}");
        assert!((1e8..1e14).contains(&rates.operations), "{rates:?}");
        Ok(())
    }

    #[test]
    fn the_processor_has_a_name() {
        assert!(!processor_name().is_empty());
    }
}
