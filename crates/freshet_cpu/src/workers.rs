//! Sharing a pass among cores.

use std::sync::atomic::{AtomicBool, AtomicUsize, Ordering};
use std::sync::{Mutex, OnceLock};

use freshet_core::error::InvalidInput;
use freshet_core::solver::SolverError;

/// Most threads of its own a solver may ask for.
const MOST_THREADS: usize = 256;

/// Particles that a thread must have to be worth waking.
const LEAST_PARTICLES: usize = 1000;

/// The threads of a solver. No other solver uses them: [`Workers::enter`] relies on that.
pub struct Workers {
    /// None for one thread, which is the caller's.
    pool: Option<rayon::ThreadPool>,
    /// Threads that share the passes of a tick: from the pool's `first` on, in a circle.
    active: AtomicUsize,
    first: AtomicUsize,
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
            return Ok(Self::of(None));
        }
        let pool = rayon::ThreadPoolBuilder::new()
            .num_threads(threads.unwrap_or(0))
            .thread_name(|index| format!("freshet {index}"))
            .build()
            .map_err(|error| SolverError::Device(error.to_string()))?;
        Ok(Self::of(Some(pool).filter(|pool| pool.current_num_threads() > 1)))
    }

    fn of(pool: Option<rayon::ThreadPool>) -> Self {
        Self { pool, active: AtomicUsize::new(1), first: AtomicUsize::new(0) }
    }

    /// Number of threads.
    pub fn threads(&self) -> usize {
        self.pool.as_ref().map_or(1, rayon::ThreadPool::current_num_threads)
    }

    /// Number of threads that share the passes of this tick; one outside of [`enter`](Self::enter).
    pub fn active(&self) -> usize {
        self.active.load(Ordering::Relaxed)
    }

    /// Place of the calling thread among those that are active.
    fn place(&self) -> usize {
        let place = |thread| (thread + self.threads() - self.first.load(Ordering::Relaxed)) % self.threads();
        rayon::current_thread_index().map_or(0, place)
    }

    /// Calls `body` on one of the threads and keeps others awake until it returns, as many as `particles` are worth it: a pass
    /// shared from there starts at once, where waking a core costs fifty microseconds and more, and that for every pass. What is
    /// shared must not wait for the pool itself: a thread that waits could be the one that is kept awake.
    pub fn enter<R: Send>(&self, particles: usize, body: impl FnOnce() -> R + Send) -> R {
        let active = self.threads().min(particles / LEAST_PARTICLES).max(1);
        let Some(pool) = self.pool.as_ref().filter(|_| active > 1) else {
            return body();
        };
        let over = &AtomicBool::new(false);
        pool.scope(|scope| {
            self.first.store(rayon::current_thread_index().unwrap_or(0), Ordering::Relaxed);
            scope.spawn_broadcast(move |_, _| {
                if (1..active).contains(&self.place()) {
                    while !over.load(Ordering::Relaxed) {
                        if rayon::yield_now() != Some(rayon::Yield::Executed) {
                            std::thread::yield_now();
                        }
                    }
                }
            });
            let _ending = Ending { over, active: &self.active };
            self.active.store(active, Ordering::Relaxed);
            body()
        })
    }

    /// Calls `body` for each task, in any order, on all threads; the results are in the order of the tasks.
    ///
    /// Each thread has a run of consecutive tasks, the same ones in every pass, whose data it still holds; who is done with them
    /// helps the others.
    pub fn map<T: Send, R: Send + Sync>(&self, tasks: Vec<T>, body: impl Fn(T) -> R + Sync + Send) -> Vec<R> {
        let threads = self.active();
        if threads == 1 {
            return tasks.into_iter().map(body).collect();
        }
        let count = tasks.len();
        let tasks: Vec<Mutex<Option<T>>> = tasks.into_iter().map(|task| Mutex::new(Some(task))).collect();
        let results: Vec<OnceLock<R>> = (0..count).map(|_| OnceLock::new()).collect();
        let next: Vec<AtomicUsize> = (0..threads).map(|thread| AtomicUsize::new(count * thread / threads)).collect();
        let work = || {
            let here = self.place().min(threads - 1);
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
        let ended = AtomicUsize::new(0);
        rayon::scope(|scope| {
            for _ in 1..threads {
                scope.spawn(|_| {
                    let _one = CountOnDrop(&ended);
                    work();
                });
            }
            work();
            // The scope's own waiting would fall asleep.
            while ended.load(Ordering::Relaxed) < threads - 1 {
                if rayon::yield_now() != Some(rayon::Yield::Executed) {
                    std::thread::yield_now();
                }
            }
        });
        results.into_iter().filter_map(OnceLock::into_inner).collect()
    }
}

/// Lets the threads go when a tick is over, also by a panic.
struct Ending<'a> {
    over: &'a AtomicBool,
    active: &'a AtomicUsize,
}

impl Drop for Ending<'_> {
    fn drop(&mut self) {
        self.active.store(1, Ordering::Relaxed);
        self.over.store(true, Ordering::Relaxed);
    }
}

/// Counts up when it goes, also by a panic.
struct CountOnDrop<'a>(&'a AtomicUsize);

impl Drop for CountOnDrop<'_> {
    fn drop(&mut self) {
        self.0.fetch_add(1, Ordering::Relaxed);
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
        let doubled = workers.enter(64_000, || {
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
    fn few_particles_wake_few_threads() {
        let workers = Workers::new(Some(3)).unwrap();
        for (particles, active) in [(0, 1), (1_999, 1), (2_000, 2), (3_000, 3), (64_000, 3)] {
            assert_eq!(workers.enter(particles, || workers.active()), active, "{particles} particles");
            assert_eq!(workers.active(), 1);
            let sum: u64 = workers.enter(particles, || workers.map(vec![1u64; 9], |i| i)).iter().sum();
            assert_eq!(sum, 9);
        }
    }

    #[test]
    fn a_panic_ends_the_waiting_and_comes_out() {
        let workers = Workers::new(Some(2)).unwrap();
        for _ in 0..2 {
            let outcome =
                std::panic::catch_unwind(std::panic::AssertUnwindSafe(|| workers.enter(64_000, || panic!("no"))));
            assert!(outcome.is_err());
            let outcome = std::panic::catch_unwind(std::panic::AssertUnwindSafe(|| {
                workers.enter(64_000, || workers.map(vec![1, 2, 3], |i| assert_ne!(i, 2)));
            }));
            assert!(outcome.is_err());
        }
        assert_eq!(workers.map(vec![1, 2], |i| i + 1), [2, 3]);
    }

    #[test]
    fn many_passes_of_many_solvers_with_more_threads_than_cores_end() {
        std::thread::scope(|scope| {
            for threads in [2, 3, 16, 16] {
                scope.spawn(move || {
                    let workers = Workers::new(Some(threads)).unwrap();
                    for _ in 0..200 {
                        let sums = workers.enter(64_000, || workers.map(vec![1u64; 9], |i| i));
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
