//! Sharing a pass among cores.

use freshet_core::error::InvalidInput;
use freshet_core::solver::SolverError;
use rayon::prelude::*;

/// Most threads of its own a solver may ask for.
const MOST_THREADS: usize = 256;

/// The threads of a solver.
pub struct Workers {
    pool: Option<rayon::ThreadPool>,
    threads: usize,
}

impl Workers {
    /// `threads` of its own, or rayon's shared ones.
    ///
    /// # Errors
    /// [`SolverError::Invalid`] for none or more than 256, [`SolverError::Device`] if the system does not give them.
    pub fn new(threads: Option<usize>) -> Result<Self, SolverError> {
        let Some(threads) = threads else {
            return Ok(Self { pool: None, threads: rayon::current_num_threads() });
        };
        if !(1..=MOST_THREADS).contains(&threads) {
            let allowed = format!("1 to {MOST_THREADS}, or none for one of each core");
            return Err(InvalidInput::new("threads", threads, allowed).into());
        }
        let pool = rayon::ThreadPoolBuilder::new()
            .num_threads(threads)
            .build()
            .map_err(|error| SolverError::Device(error.to_string()))?;
        Ok(Self { pool: Some(pool), threads })
    }

    /// Number of threads.
    pub fn threads(&self) -> usize {
        self.threads
    }

    /// Calls `body` on one of the threads: passes shared from there start without waking it first.
    pub fn enter<R: Send>(&self, body: impl FnOnce() -> R + Send) -> R {
        match &self.pool {
            _ if self.threads == 1 => body(),
            Some(pool) => pool.install(body),
            None => rayon::scope(|_| body()),
        }
    }

    /// Calls `body` for each task, in any order, on all threads; the results are in the order of the tasks.
    pub fn map<T: Send, R: Send>(&self, tasks: Vec<T>, body: impl Fn(T) -> R + Sync + Send) -> Vec<R> {
        if self.threads == 1 {
            return tasks.into_iter().map(body).collect();
        }
        self.enter(|| tasks.into_par_iter().with_max_len(1).map(body).collect())
    }
}

/// Splits `values` at the ends of consecutive `ranges` that cover it from 0.
pub fn split<'a, T>(mut values: &'a mut [T], ranges: &[Chunk]) -> Vec<&'a mut [T]> {
    let mut parts = Vec::with_capacity(ranges.len());
    for range in ranges {
        let (part, rest) = values.split_at_mut(range.particles.len());
        parts.push(part);
        values = rest;
    }
    parts
}

/// A run of cells and the particles in them.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct Chunk {
    /// Cells.
    pub cells: std::ops::Range<usize>,
    /// Particles of these cells.
    pub particles: std::ops::Range<usize>,
}

/// Cuts the cells into about `count` chunks of about equally many particles.
pub fn chunks(cell_starts: &[u32], count: usize) -> Vec<Chunk> {
    let cells = cell_starts.len() - 1;
    let particles = cell_starts[cells] as usize;
    let mut chunks = Vec::with_capacity(count);
    let mut first = 0;
    for part in 1..=count {
        let target = (particles * part / count) as u32;
        let end = if part == count { cells } else { cell_starts.partition_point(|&start| start < target).min(cells) };
        if end > first {
            let particles = cell_starts[first] as usize..cell_starts[end] as usize;
            chunks.push(Chunk { cells: first..end, particles });
            first = end;
        }
    }
    chunks
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn chunks_cover_all_cells_once() {
        for count in [1, 2, 3, 7, 64] {
            let starts = [0, 0, 3, 3, 10, 11, 11, 30, 30];
            let chunks = chunks(&starts, count);
            assert_eq!(chunks.first().map(|chunk| chunk.cells.start), Some(0));
            assert_eq!(chunks.last().map(|chunk| (chunk.cells.end, chunk.particles.end)), Some((8, 30)));
            for pair in chunks.windows(2) {
                assert_eq!(pair[0].cells.end, pair[1].cells.start);
                assert_eq!(pair[0].particles.end, pair[1].particles.start);
            }
        }
    }
}
