//! Jobs of one thread each, several at a time.

use std::sync::Mutex;
use std::sync::atomic::{AtomicUsize, Ordering};
use std::sync::mpsc;

use crate::error::LabError;

/// Does all jobs, `workers` at a time, and hands on each result as it comes; the first error ends it.
pub fn side_by_side<J: Sync, R: Send>(
    jobs: &[J],
    workers: usize,
    work: impl Fn(&J) -> Result<R, LabError> + Sync,
    mut done: impl FnMut(R) -> Result<(), LabError>,
) -> Result<(), LabError> {
    let (next, stop) = (AtomicUsize::new(0), Mutex::new(false));
    let (sender, receiver) = mpsc::channel();
    std::thread::scope(|scope| {
        for _ in 0..workers.max(1) {
            let (sender, next, stop, work) = (sender.clone(), &next, &stop, &work);
            scope.spawn(move || {
                while let Some(job) = jobs.get(next.fetch_add(1, Ordering::Relaxed)) {
                    if stop.lock().is_ok_and(|stop| *stop) || sender.send(work(job)).is_err() {
                        return;
                    }
                }
            });
        }
        drop(sender);
        let mut outcome = Ok(());
        for result in receiver {
            if outcome.is_ok() {
                outcome = result.and_then(&mut done);
            }
            if outcome.is_err()
                && let Ok(mut stop) = stop.lock()
            {
                *stop = true;
            }
        }
        outcome
    })
}

/// Jobs at a time on the CPU unless given: one for each core.
pub fn cores() -> usize {
    std::thread::available_parallelism().map_or(1, |n| n.get())
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn all_are_done_unless_one_fails() {
        let jobs: Vec<u32> = (0..20).collect();
        let mut sum = 0;
        let work = |&job: &u32| Ok(job);
        assert!(
            side_by_side(&jobs, 3, work, |job| {
                sum += job;
                Ok(())
            })
            .is_ok()
        );
        assert_eq!(sum, 190);
        let fails = |&job: &u32| match job {
            3 => Err(LabError::Measure { what: "three", reason: "it is three".to_owned() }),
            _ => Ok(job),
        };
        assert!(
            side_by_side(&jobs, 1, fails, |job| {
                assert!(job < 3, "{job} after the error");
                Ok(())
            })
            .is_err()
        );
    }
}
