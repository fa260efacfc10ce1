//! Figures of a run, as text and as JSON.

use std::fmt::Write;
use std::path::Path;

/// One line of the run.
#[derive(Clone, Copy, Debug)]
pub struct Sample {
    /// Simulated time, s.
    pub time: f64,
    /// Front, m.
    pub front: f32,
}

/// Figures of a run.
#[derive(Clone, Debug, Default)]
pub struct Summary {
    /// What simulated.
    pub backend: String,
    /// The adapter that drew, if one did.
    pub adapter: String,
    /// Particles at the end.
    pub particles: u32,
    /// Distance of particles, m.
    pub spacing: f32,
    /// Simulated time, s.
    pub simulated: f64,
    /// Wall time in the solver, s.
    pub solver: f64,
    /// Wall time in all, s.
    pub wall: f64,
    /// Ticks made.
    pub ticks: u64,
    /// Wall times of frames at the end of the run in which nothing was simulated and no picture was taken, s: all that Bevy does in
    /// a frame, until the adapter has drawn it. None if nothing draws.
    pub still_frames: Vec<f64>,
    /// Substeps in all.
    pub substeps: u64,
    /// Smallest time scale of a tick.
    pub least_time_scale: f32,
    /// Largest mean compression of a tick.
    pub mean_compression: f32,
    /// Largest compression of a particle.
    pub max_compression: f32,
    /// Largest speed, m/s.
    pub max_speed: f32,
    /// Particles removed.
    pub removed: u64,
    /// Pictures written.
    pub pictures: u32,
    /// The front over time.
    pub fronts: Vec<Sample>,
}

impl Summary {
    /// Wall time in the solver for a simulated second, s.
    pub fn cost(&self) -> f64 {
        self.solver / self.simulated.max(1e-9)
    }

    /// Wall time in the solver for a tick, mean of all, s.
    fn of_tick(&self) -> f64 {
        self.solver / self.ticks.max(1) as f64
    }

    /// The median of the still frames, s.
    fn of_drawing(&self) -> Option<f64> {
        let mut frames = self.still_frames.clone();
        frames.sort_by(f64::total_cmp);
        frames.get(frames.len() / 2).copied()
    }

    /// For people.
    pub fn text(&self) -> String {
        let mut text = String::new();
        let mut line = |name: &str, value: String| {
            let _ = writeln!(text, "{name:<44} {value}");
        };
        line("backend", self.backend.clone());
        line("adapter that draws", self.adapter.clone());
        line("particles", self.particles.to_string());
        line("spacing", format!("{:.5} m", self.spacing));
        line("simulated time", format!("{:.3} s in {} substeps", self.simulated, self.substeps));
        line("wall time per simulated second, solver only", format!("{:.3} s", self.cost()));
        line("wall time of a tick, solver only", format!("{:.3} ms on average", 1e3 * self.of_tick()));
        if let Some(frame) = self.of_drawing() {
            // A frame with a tick costs both, where the solver runs on the same processor as what draws.
            line("wall time of a frame without a tick", format!("{:.3} ms until it is drawn, the median", 1e3 * frame));
        }
        line("wall time, pictures and all", format!("{:.3} s", self.wall));
        line("least time scale", format!("{:.3}", self.least_time_scale));
        line(
            "compression, mean and of one particle",
            format!("{:.2} % and {:.2} %", 100.0 * self.mean_compression, 100.0 * self.max_compression),
        );
        line("largest speed", format!("{:.3} m/s", self.max_speed));
        line("particles removed", self.removed.to_string());
        line("pictures", self.pictures.to_string());
        if let Some(last) = self.fronts.last() {
            line("front at the end", format!("{:.3} m", last.front));
        }
        text
    }

    /// For programs.
    pub fn json(&self) -> String {
        let still: Vec<String> = self.still_frames.iter().map(|seconds| format!("{seconds:.6}")).collect();
        let fronts: Vec<String> =
            self.fronts.iter().map(|sample| format!("[{:.5}, {:.5}]", sample.time, sample.front)).collect();
        format!(
            "{{\n  \"backend\": {:?},\n  \"adapter\": {:?},\n  \"particles\": {},\n  \"spacing_m\": {},\n  \"simulated_s\": {},\n  \
             \"substeps\": {},\n  \"solver_wall_s\": {},\n  \"solver_wall_s_per_simulated_s\": {},\n  \
             \"ticks\": {},\n  \"solver_wall_s_per_tick\": {},\n  \"still_frames_wall_s\": [{}],\n  \"wall_s\": {},\n  \
             \"least_time_scale\": {},\n  \"mean_compression\": {},\n  \"max_compression\": {},\n  \"max_speed_m_s\": {},\n  \
             \"removed\": {},\n  \"pictures\": {},\n  \"front_s_m\": [{}]\n}}\n",
            self.backend,
            self.adapter,
            self.particles,
            self.spacing,
            self.simulated,
            self.substeps,
            self.solver,
            self.cost(),
            self.ticks,
            self.of_tick(),
            still.join(", "),
            self.wall,
            self.least_time_scale,
            self.mean_compression,
            self.max_compression,
            self.max_speed,
            self.removed,
            self.pictures,
            fronts.join(", ")
        )
    }

    /// Writes `summary.txt`, `summary.json` and `front.svg`, and prints the text.
    pub fn write(&self, folder: &Path) -> Result<(), String> {
        let write = |name: &str, text: String| {
            std::fs::write(folder.join(name), text).map_err(|error| format!("{}: {error}", folder.join(name).display()))
        };
        write("summary.txt", self.text())?;
        write("summary.json", self.json())?;
        crate::plot::write(&folder.join("front.svg"), &self.fronts)?;
        print!("{}", self.text());
        println!("{:<44} {}", "written to", folder.display());
        Ok(())
    }
}
