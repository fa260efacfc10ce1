//! A progress bar with the time left, drawn on standard error and only there, so that tables can be piped.

use std::time::Duration;

use indicatif::{ProgressBar, ProgressStyle};

/// Progress of a command through work of known size, in any unit.
#[derive(Debug)]
pub struct Progress {
    bar: ProgressBar,
    /// Work of the parts that are finished.
    done: f64,
    /// Work of the part that runs.
    part: f64,
    total: f64,
}

/// Steps of the bar; indicatif counts in integers.
const RESOLUTION: u64 = 10_000;

impl Progress {
    /// A bar for `total` units of work.
    pub fn new(total: f64) -> Self {
        let bar = ProgressBar::new(RESOLUTION);
        if let Ok(style) = ProgressStyle::with_template("{bar:32} {percent:>3} %  {elapsed} gone, {eta} left  {msg}") {
            bar.set_style(style);
        }
        bar.enable_steady_tick(Duration::from_millis(250));
        Self { bar, done: 0.0, part: 0.0, total: total.max(f64::MIN_POSITIVE) }
    }

    /// A bar that is never drawn, for tests.
    pub fn hidden() -> Self {
        Self { bar: ProgressBar::hidden(), done: 0.0, part: 0.0, total: 1.0 }
    }

    /// Ends the running part and begins one of `work` units.
    pub fn begin(&mut self, name: impl Into<String>, work: f64) {
        self.done += self.part;
        self.part = work;
        self.bar.set_message(name.into());
        self.at(0.0);
    }

    /// How much of the running part is done, 0 to 1.
    pub fn at(&mut self, fraction: f64) {
        let done = (self.done + self.part * fraction.clamp(0.0, 1.0)) / self.total;
        self.bar.set_position((done.min(1.0) * RESOLUTION as f64) as u64);
    }
}

impl Drop for Progress {
    fn drop(&mut self) {
        self.bar.finish_and_clear();
    }
}
