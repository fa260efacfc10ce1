//! Sharing a pass among cores.

use std::sync::atomic::{AtomicBool, AtomicUsize, Ordering};
use std::sync::{Mutex, OnceLock};

use freshet_core::error::InvalidInput;
use freshet_core::solver::SolverError;

/// Most threads of its own a solver may ask for.
const MOST_THREADS: usize = 256;

/// The threads of a solver. No other solver uses them: [`Workers::enter`] relies on that.
pub struct Workers {
    /// None for one thread, which is the caller's.
    pool: Option<rayon::ThreadPool>,
}

impl Workers {
    /// `threads`, or one for each core (`RAYON_NUM_THREADS` changes that number).
    ///
    /// # Errors
    /// [`SolverError::Invalid`] for none or more than 256, [`SolverError::Device`] if the system does not give them.
    pub fn new(threads: Option<usize>) -> Result<Self, SolverError> {
        if let Some(threads) = threads
            && !(1..=MOST_THREADS).contains(&threads)
        {
            let allowed = format!("1 to {MOST_THREADS}, or none for one of each core");
            return Err(InvalidInput::new("threads", threads, allowed).into());
        }
        if threads == Some(1) {
            return Ok(Self { pool: None });
        }
        let pool = rayon::ThreadPoolBuilder::new()
            .num_threads(threads.unwrap_or(0))
            .thread_name(|index| format!("freshet {index}"))
            .build()
            .map_err(|error| SolverError::Device(error.to_string()))?;
        Ok(Self { pool: Some(pool).filter(|pool| pool.current_num_threads() > 1) })
    }

    /// Number of threads.
    pub fn threads(&self) -> usize {
        self.pool.as_ref().map_or(1, rayon::ThreadPool::current_num_threads)
    }

    /// Calls `body` on one of the threads and keeps the others awake until it returns: a pass shared from there starts at
    /// once, where waking a core costs some fifty microseconds, and that for every pass.
    pub fn enter<R: Send>(&self, body: impl FnOnce() -> R + Send) -> R {
        let Some(pool) = self.pool.as_ref().filter(|pool| pool.current_thread_index().is_none()) else {
            return body();
        };
        let others = pool.current_num_threads() - 1;
        let (awake, over) = (&AtomicUsize::new(0), &AtomicBool::new(false));
        pool.scope(|scope| {
            let here = rayon::current_thread_index();
            scope.spawn_broadcast(move |_, context| {
                if Some(context.index()) != here {
                    awake.fetch_add(1, Ordering::Relaxed);
                    while !over.load(Ordering::Relaxed) {
                        if rayon::yield_now() != Some(rayon::Yield::Executed) {
                            std::thread::yield_now();
                        }
                    }
                }
            });
            let _ending = SetOnDrop(over);
            // All of them before the first pass: a thread that came to this while it waits inside a pass would hold it up.
            while awake.load(Ordering::Relaxed) < others {
                std::thread::yield_now();
            }
            body()
        })
    }

    /// Calls `body` for each task, in any order, on all threads; the results are in the order of the tasks.
    ///
    /// Each thread has a run of consecutive tasks, the same ones in every pass, whose data it still holds; who is done with them
    /// helps the others.
    pub fn map<T: Send, R: Send + Sync>(&self, tasks: Vec<T>, body: impl Fn(T) -> R + Sync + Send) -> Vec<R> {
        let threads = self.threads();
        if threads == 1 {
            return tasks.into_iter().map(body).collect();
        }
        let count = tasks.len();
        let tasks: Vec<Mutex<Option<T>>> = tasks.into_iter().map(|task| Mutex::new(Some(task))).collect();
        let results: Vec<OnceLock<R>> = (0..count).map(|_| OnceLock::new()).collect();
        let next: Vec<AtomicUsize> = (0..threads).map(|thread| AtomicUsize::new(count * thread / threads)).collect();
        let work = || {
            let here = rayon::current_thread_index().unwrap_or(0);
            for of in (here..threads).chain(0..here) {
                let end = count * (of + 1) / threads;
                loop {
                    let index = next[of].fetch_add(1, Ordering::Relaxed);
                    if index >= end {
                        break;
                    }
                    let task = tasks[index].lock().ok().and_then(|mut task| task.take());
                    if let Some(result) = task.map(&body) {
                        // Each task is taken once.
                        let _ = results[index].set(result);
                    }
                }
            }
        };
        self.enter(|| {
            rayon::scope(|scope| {
                for _ in 1..threads {
                    scope.spawn(|_| work());
                }
                work();
            });
        });
        results.into_iter().filter_map(OnceLock::into_inner).collect()
    }
}

/// Sets a flag when it goes, also when by a panic.
struct SetOnDrop<'a>(&'a AtomicBool);

impl Drop for SetOnDrop<'_> {
    fn drop(&mut self) {
        self.0.store(true, Ordering::Relaxed);
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
    use std::collections::HashSet;
    use std::time::Duration;

    use super::*;

    #[test]
    fn tasks_are_shared_and_results_keep_their_order() {
        let workers = Workers::new(Some(3)).unwrap();
        let threads = Mutex::new(HashSet::new());
        let doubled = workers.enter(|| {
            workers.map((0..64).collect(), |i: u32| {
                std::thread::sleep(Duration::from_millis(1));
                threads.lock().unwrap().insert(std::thread::current().id());
                2 * i
            })
        });
        assert_eq!(doubled, (0..64).map(|i| 2 * i).collect::<Vec<_>>());
        assert_eq!(threads.into_inner().unwrap().len(), 3);
    }

    #[test]
    fn a_panic_ends_the_waiting_and_comes_out() {
        let workers = Workers::new(Some(2)).unwrap();
        for _ in 0..2 {
            let outcome = std::panic::catch_unwind(std::panic::AssertUnwindSafe(|| workers.enter(|| panic!("no"))));
            assert!(outcome.is_err());
            let outcome = std::panic::catch_unwind(std::panic::AssertUnwindSafe(|| {
                workers.map(vec![1, 2, 3], |i| assert_ne!(i, 2));
            }));
            assert!(outcome.is_err());
        }
        assert_eq!(workers.map(vec![1, 2], |i| i + 1), [2, 3]);
    }

    #[test]
    fn many_passes_of_many_solvers_at_once_end() {
        std::thread::scope(|scope| {
            for _ in 0..4 {
                scope.spawn(|| {
                    let workers = Workers::new(Some(3)).unwrap();
                    for _ in 0..200 {
                        let sums = workers.enter(|| workers.map(vec![1u64; 9], |i| i));
                        assert_eq!(sums.iter().sum::<u64>(), 9);
                    }
                });
            }
        });
    }

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
