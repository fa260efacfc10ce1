//! Sharing a pass among cores.

use std::sync::Mutex;
use std::sync::atomic::{AtomicBool, AtomicUsize, Ordering};

use arrayvec::ArrayVec;
use freshet_core::error::InvalidInput;
use freshet_core::solver::SolverError;

use crate::tasks::{Cut, Each, Piece, Tasks, Total};

/// Most threads of its own a solver may ask for, and that share a pass on a processor with more cores.
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
        let active = self.threads().min(particles / LEAST_PARTICLES).clamp(1, MOST_THREADS);
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

    /// A value for each thread, to lend to the tasks of a pass.
    pub fn spaces<S: Default>(&self) -> Vec<S> {
        std::iter::repeat_with(S::default).take(self.threads().min(MOST_THREADS)).collect()
    }

    /// Calls `body` for each task, in any order, on all threads; returns the total of the results.
    pub fn share<P, E, V, R>(&self, tasks: Tasks<P, E, V>, body: impl Fn((&P, E::One, V)) -> R + Sync) -> R
    where
        P: Piece,
        E: Each,
        V: Cut,
        R: Total,
    {
        // Values of no size take no memory.
        self.share_with(&mut self.spaces(), tasks, |(), task| body(task))
    }

    /// Calls `body` for each task, in any order, on all threads, never with the same one of the `spaces` at the same time, of which
    /// there is one for each thread; returns the total of the results. Nothing is allocated.
    ///
    /// Each thread has a run of consecutive tasks, the same ones in every pass, whose data it still holds; who is done with them
    /// helps the others.
    pub fn share_with<S, P, E, V, R>(
        &self,
        spaces: &mut [S],
        mut tasks: Tasks<P, E, V>,
        body: impl Fn(&mut S, (&P, E::One, V)) -> R + Sync,
    ) -> R
    where
        S: Send,
        P: Piece,
        E: Each,
        V: Cut,
        R: Total,
    {
        let threads = self.active();
        let [space, others @ ..] = &mut spaces[..threads] else { return R::default() };
        if others.is_empty() {
            return tasks.fold(R::default(), |total, task| total.and(body(space, task)));
        }
        let count = tasks.len();
        let end = |thread: usize| count * thread / threads;
        let runs: ArrayVec<_, MOST_THREADS> =
            (0..threads).map(|thread| Mutex::new(tasks.cut(end(thread + 1) - end(thread)))).collect();
        let work = |space: &mut S| {
            let here = self.place().min(threads - 1);
            let mut total = R::default();
            for run in (here..threads).chain(0..here).map(|of| &runs[of]) {
                while let Some(task) = run.lock().ok().and_then(|mut run| run.next()) {
                    total = total.and(body(space, task));
                }
            }
            total
        };
        let ended = AtomicUsize::new(0);
        offer(others, &ended, &work, || {
            let total = work(space);
            // A join's own waiting would fall asleep.
            while ended.load(Ordering::Relaxed) < threads - 1 {
                if rayon::yield_now() != Some(rayon::Yield::Executed) {
                    std::thread::yield_now();
                }
            }
            total
        })
    }
}

/// Offers `work` with each of the `spaces` to other threads, then calls `own`; returns the total of the results. The calling thread
/// offers all of it: a thread that takes some waits for nobody.
fn offer<S: Send, R: Total>(
    spaces: &mut [S],
    ended: &AtomicUsize,
    work: &(impl Fn(&mut S) -> R + Sync),
    own: impl FnOnce() -> R + Send,
) -> R {
    let Some((space, others)) = spaces.split_first_mut() else {
        return own();
    };
    let (total, other) = rayon::join(
        || offer(others, ended, work, own),
        || {
            let _one = CountOnDrop(ended);
            work(space)
        },
    );
    total.and(other)
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

/// A run of cells and the particles in them.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct Chunk {
    /// Cells.
    pub cells: std::ops::Range<usize>,
    /// Particles of these cells.
    pub particles: std::ops::Range<usize>,
}

/// Cuts the cells into about `count` chunks of about equally many particles.
pub fn cut_into_chunks(chunks: &mut Vec<Chunk>, cell_starts: &[u32], count: usize) {
    let cells = cell_starts.len() - 1;
    let particles = cell_starts[cells] as usize;
    chunks.clear();
    chunks.reserve(count);
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
}

#[cfg(test)]
mod tests {
    use std::collections::HashSet;
    use std::sync::mpsc;
    use std::time::{Duration, Instant};

    use super::*;

    /// How many tasks there were, and their sum.
    #[derive(Clone, Copy, Debug, Default, PartialEq)]
    struct Sum(usize, u64);

    impl Total for Sum {
        fn and(self, other: Self) -> Self {
            Self(self.0 + other.0, self.1 + other.1)
        }
    }

    /// Shares `count` tasks of three values each, calls `body` for each and checks that each had its own.
    fn shared(workers: &Workers, count: usize, body: impl Fn(usize) + Sync) -> Sum {
        let pieces: Vec<_> = (0..count).map(|i| 3 * i..3 * i + 3).collect();
        let mut values = vec![0; 3 * count];
        let sum = workers.share(Tasks::new(&pieces, (), &mut *values), |(piece, (), values)| {
            body(piece.start / 3);
            for (i, value) in piece.clone().zip(&mut *values) {
                *value += i + 1;
            }
            Sum(1, piece.start as u64)
        });
        assert!(values.into_iter().eq(1..=3 * count));
        sum
    }

    #[test]
    fn tasks_are_shared_each_once() {
        let workers = Workers::new(Some(3)).unwrap();
        let threads = Mutex::new(HashSet::new());
        let sum = workers.enter(64_000, || {
            shared(&workers, 64, |_| {
                std::thread::sleep(Duration::from_millis(1));
                threads.lock().unwrap().insert(std::thread::current().id());
            })
        });
        assert_eq!(sum, Sum(64, (0..64).map(|i| 3 * i).sum()));
        assert_eq!(threads.into_inner().unwrap().len(), 3);
    }

    #[test]
    fn no_two_tasks_have_a_space_at_the_same_time() {
        let workers = Workers::new(Some(3)).unwrap();
        let mut spaces: Vec<u64> = workers.spaces();
        let pieces: Vec<_> = (0..64).map(|i| i..i + 1).collect();
        let sum = workers.enter(64_000, || {
            workers.share_with(&mut spaces, Tasks::new(&pieces, (), ()), |space, _| {
                let before = *space;
                std::thread::sleep(Duration::from_millis(1));
                *space = before + 1;
                Sum(1, 0)
            })
        });
        assert_eq!(sum.0, 64);
        assert_eq!(spaces.iter().sum::<u64>(), 64);
    }

    #[test]
    fn few_particles_wake_few_threads() {
        let workers = Workers::new(Some(3)).unwrap();
        for (particles, active) in [(0, 1), (1_999, 1), (2_000, 2), (3_000, 3), (64_000, 3)] {
            assert_eq!(workers.enter(particles, || workers.active()), active, "{particles} particles");
            assert_eq!(workers.active(), 1);
            assert_eq!(workers.enter(particles, || shared(&workers, 9, |_| {})).0, 9);
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
                workers.enter(64_000, || shared(&workers, 3, |i| assert_ne!(i, 1)));
            }));
            assert!(outcome.is_err());
        }
        assert_eq!(shared(&workers, 2, |_| {}).0, 2);
    }

    #[test]
    fn many_passes_of_many_solvers_with_more_threads_than_cores_end() {
        // A thread that waits for another for ever cannot be stopped: it is left behind, and the test fails.
        const DEADLINE: Duration = Duration::from_secs(120);
        let (done, outcome) = mpsc::channel();
        for threads in [2, 3, 16, 16] {
            let done = done.clone();
            std::thread::spawn(move || {
                let workers = Workers::new(Some(threads)).unwrap();
                let counted = (0..200).all(|_| workers.enter(64_000, || shared(&workers, 9, |_| {})).0 == 9);
                // Nobody listens any more after the deadline.
                let _ = done.send((threads, counted));
            });
        }
        drop(done);
        let begin = Instant::now();
        for ended in 0..4 {
            match outcome.recv_timeout(DEADLINE.saturating_sub(begin.elapsed())) {
                Ok((threads, counted)) => assert!(counted, "with {threads} threads a task was lost"),
                Err(mpsc::RecvTimeoutError::Timeout) => {
                    panic!(
                        "only {ended} of 4 solvers had ended after {} s: threads wait for each other",
                        DEADLINE.as_secs()
                    )
                }
                Err(mpsc::RecvTimeoutError::Disconnected) => panic!("a solver panicked after {ended} of 4 had ended"),
            }
        }
    }

    #[test]
    fn chunks_cover_all_cells_once() {
        for count in [1, 2, 3, 7, 64] {
            let starts = [0, 0, 3, 3, 10, 11, 11, 30, 30];
            let mut chunks = vec![Chunk { cells: 0..1, particles: 0..0 }];
            cut_into_chunks(&mut chunks, &starts, count);
            assert_eq!(chunks.first().map(|chunk| chunk.cells.start), Some(0));
            assert_eq!(chunks.last().map(|chunk| (chunk.cells.end, chunk.particles.end)), Some((8, 30)));
            for pair in chunks.windows(2) {
                assert_eq!(pair[0].cells.end, pair[1].cells.start);
                assert_eq!(pair[0].particles.end, pair[1].particles.start);
            }
        }
    }
}
