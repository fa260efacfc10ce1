//! `float`: a rapier ball of half the density of water in a pool.

mod report;
mod scene;
mod simulate;
mod sway;

use clap::Args;

pub use scene::{BALL_DENSITY, Pool};
pub use simulate::{Run, simulate};
pub use sway::Sway;

use crate::backend::Backend;
use crate::error::LabError;
use crate::measure::statistics::mean;
use crate::method::Method;
use crate::options::{BackendChoice, CommonOptions, ThreadOption};
use crate::output::{Output, say, say_files};
use crate::progress::Progress;
use crate::verdict::{Bound, Verdict};

/// A rapier ball of density 500 floats in an open pool, coupled both ways.
///
/// Balls of 6 and 12 spacings, released a tenth of their diameter above where they should float. The draft is the depth of
/// the ball's lowest point below the surface, over its diameter: once below the level that the water's volume and the
/// ball's submerged part give, once below the measured surface away from the ball. Archimedes: 0.5.
///
/// From half time on: mean draft within 5 % of that, 0.475 to 0.525, both ways; the envelope of the ball's heave does not grow. The momentum
/// ledger closes to 1e-4 of the impulses exchanged, against rapier's own momentum too. Rapier hears of the fluid's
/// impulses in the same tick (lockstep, or 0 ticks late) or 1 to 3 ticks late (pipelined, on both backends by holding reports
/// back). Writes float.csv (tick by tick) and float.svg.
#[derive(Args, Clone, Debug)]
pub struct FloatArgs {
    /// Options every command has. The GPU runs the smallest size only.
    #[command(flatten)]
    pub common: CommonOptions,
    /// Threads of the CPU solver.
    #[command(flatten)]
    pub threads: ThreadOption,
    /// Diameters of the ball in spacings, 6 or 12 [default: 6,12; quick: 6].
    #[arg(long, value_name = "N,N", value_delimiter = ',', value_parser = clap::value_parser!(u32).range(6..=12))]
    pub sizes: Vec<u32>,
    /// When rapier hears of a tick's impulse: `lockstep`, or ticks later, 0 to 3 [default: lockstep,2; quick: 2].
    #[arg(long, value_name = "A,A,...", value_delimiter = ',')]
    pub latency: Vec<Latency>,
    /// Time to simulate, s, 3 to 600 [default: 20; quick: 4].
    #[arg(long, value_name = "S", value_parser = seconds)]
    pub seconds: Option<f64>,
    /// How pressure is found. Files of another method than the default have its name.
    #[arg(long, value_enum, default_value_t)]
    pub method: Method,
}

fn seconds(text: &str) -> Result<f64, String> {
    match text.parse() {
        Ok(value) if (3.0..=600.0).contains(&value) => Ok(value),
        _ => Err("allowed: 3 to 600".to_owned()),
    }
}

/// When rapier hears of a tick's impulse.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash)]
pub enum Latency {
    /// Before its own step of that tick.
    Lockstep,
    /// So many ticks later, 0 to 3; 0 is lockstep.
    Ticks(u8),
}

impl Latency {
    /// In ticks.
    pub fn ticks(self) -> u64 {
        match self {
            Latency::Lockstep => 0,
            Latency::Ticks(ticks) => ticks.into(),
        }
    }
}

impl std::str::FromStr for Latency {
    type Err = String;
    fn from_str(text: &str) -> Result<Self, String> {
        match (text, text.parse()) {
            ("lockstep", _) => Ok(Latency::Lockstep),
            (_, Ok(ticks)) if ticks <= 3 => Ok(Latency::Ticks(ticks)),
            _ => Err("allowed: lockstep, 0, 1, 2, 3".to_owned()),
        }
    }
}

impl std::fmt::Display for Latency {
    fn fmt(&self, f: &mut std::fmt::Formatter<'_>) -> std::fmt::Result {
        match self {
            Latency::Lockstep => f.write_str("lockstep"),
            Latency::Ticks(1) => f.write_str("1 tick late"),
            Latency::Ticks(ticks) => write!(f, "{ticks} ticks late"),
        }
    }
}

/// Draft over diameter by Archimedes.
pub const ARCHIMEDES: f64 = 0.5;
/// How far the mean draft may be from it, over the diameter: a twentieth of the draft.
pub const DRAFT_BOUND: f64 = 0.05 * ARCHIMEDES;
/// Growth of the envelope of heave from half time to the end.
pub const GROWTH_BOUND: f64 = 1.1;
/// Momentum lost over impulses exchanged.
pub const LEDGER_BOUND: f64 = 1e-4;

/// One run to make.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Case {
    /// Where.
    pub backend: Backend,
    /// How pressure is found.
    pub method: Method,
    /// Which pool and ball.
    pub pool: Pool,
    /// How late.
    pub latency: Latency,
    /// Time to simulate, s.
    pub seconds: f64,
}

impl std::fmt::Display for Case {
    fn fmt(&self, f: &mut std::fmt::Formatter<'_>) -> std::fmt::Result {
        let method = if self.method == Method::default() { String::new() } else { format!("{}, ", self.method.name()) };
        write!(f, "ball of {} d, {method}{}, {}", self.pool.diameter, self.backend, self.latency)
    }
}

impl Case {
    /// Particle-steps up to a factor.
    fn work(&self) -> f64 {
        let per_particle_step = if self.backend == Backend::Gpu { 8.0 } else { 1.0 };
        self.pool.particles() * f64::from(self.pool.depth).sqrt() * self.seconds * per_particle_step
    }
}

impl FloatArgs {
    /// The runs to make.
    pub fn cases(&self) -> Result<Vec<Case>, LabError> {
        let quick = self.common.quick;
        let or = |given: &[u32], default: &[u32]| if given.is_empty() { default.to_vec() } else { given.to_vec() };
        let mut sizes = or(&self.sizes, if quick { &[6] } else { &[6, 12] });
        sizes.sort_unstable();
        sizes.dedup();
        let pools: Vec<Pool> = sizes
            .iter()
            .map(|&diameter| {
                let reason = || format!("{diameter} is not allowed; allowed: 6, 12");
                Pool::for_ball(diameter).ok_or_else(|| LabError::Argument { argument: "--sizes", reason: reason() })
            })
            .collect::<Result<_, _>>()?;
        let latencies = match (self.latency.is_empty(), quick) {
            (false, _) => self.latency.clone(),
            (true, true) => vec![Latency::Ticks(2)],
            (true, false) => vec![Latency::Lockstep, Latency::Ticks(2)],
        };
        let seconds = self.seconds.unwrap_or(if quick { 4.0 } else { 20.0 });
        let mut cases = Vec::new();
        for &backend in self.common.backends(BackendChoice::Both) {
            let count = if backend == Backend::Gpu { 1 } else { pools.len() };
            for &pool in &pools[..count] {
                cases.extend(latencies.iter().map(|&latency| Case {
                    backend,
                    method: self.method,
                    pool,
                    latency,
                    seconds,
                }));
            }
        }
        Ok(cases)
    }
}

/// Runs the command.
pub fn run(args: &FloatArgs) -> Result<Verdict, LabError> {
    let cases = args.cases()?;
    let output = Output::new(&args.common.out)?;
    let mut progress = Progress::new(cases.iter().map(Case::work).sum());
    let mut runs: Vec<Run> = Vec::new();
    for case in &cases {
        progress.begin(case.to_string(), case.work());
        let solver = |plan| case.backend.open(plan, args.threads.count());
        runs.push(simulate(case, solver, &mut progress)?);
        report::write(&output, args.method, &runs)?;
    }
    drop(progress);
    say(report::table(&runs));
    say_files(&output, &report::files(args.method).each_ref().map(String::as_str));
    Ok(verdict(&runs))
}

/// The bounds of all runs.
pub fn verdict(runs: &[Run]) -> Verdict {
    let mut verdict = Verdict::default();
    for run in runs {
        let name = |what: &str| format!("{}: {what}", run.case);
        let draft = Bound::Within(ARCHIMEDES - DRAFT_BOUND, ARCHIMEDES + DRAFT_BOUND);
        let late = |curve: &crate::measure::curve::Curve| mean(curve.values_from(run.settled())).unwrap_or(f64::NAN);
        verdict.check(name("draft by volume"), late(&run.draft), "D", draft);
        verdict.check(name("draft by surface"), late(&run.draft_by_surface), "D", draft);
        verdict.check(name("growth of heave"), run.sway().growth, "", Bound::AtMost(GROWTH_BOUND));
        verdict.check(name("ledger"), run.ledger, "", Bound::AtMost(LEDGER_BOUND));
        verdict.check(name("rapier's momentum against the ledger"), run.momentum, "", Bound::AtMost(LEDGER_BOUND));
        verdict.check(name("particles lost"), run.lost as f64, "", Bound::AtMost(0.0));
        verdict.check(name("time scale"), run.time_scale, "", Bound::AtLeast(0.999));
    }
    verdict
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::measure::curve::Curve;

    fn afloat(draft: f64, swell: f64) -> Result<Run, LabError> {
        let pool = Pool::for_ball(6).ok_or(LabError::Measure { what: "a pool", reason: "no such size".to_owned() })?;
        let case =
            Case { backend: Backend::Cpu, method: Method::default(), pool, latency: Latency::Ticks(2), seconds: 20.0 };
        let steady = |value: f64| (1..=1200).map(|tick| (f64::from(tick) / 60.0, value)).collect::<Curve>();
        let heave = |time: f64| 0.6 + 0.005 * (swell * time).exp() * (7.0 * time).sin();
        Ok(Run {
            draft: steady(draft),
            draft_by_surface: steady(0.5),
            height: steady(0.0).samples().iter().map(|&(time, _)| (time, heave(time))).collect(),
            ledger: 1e-8,
            momentum: 1e-8,
            time_scale: 1.0,
            ..Run::new(case)
        })
    }

    #[test]
    fn each_bound_can_be_missed() -> Result<(), LabError> {
        let passes = |run| verdict(&[run]).passes();
        assert!(passes(afloat(0.5, -0.05)?));
        assert!(passes(afloat(0.476, -0.05)?) && passes(afloat(0.524, -0.05)?));
        assert!(!passes(afloat(0.474, -0.05)?), "too high in the water");
        assert!(!passes(afloat(0.526, -0.05)?), "too deep in the water");
        assert!(!passes(afloat(0.5, 0.05)?), "heave grows");
        assert!(!passes(Run { ledger: 2e-4, ..afloat(0.5, 0.0)? }), "momentum is lost");
        assert!(!passes(Run { momentum: f64::NAN, ..afloat(0.5, 0.0)? }), "momentum is not known");
        assert!(!passes(Run { draft_by_surface: Curve::default(), ..afloat(0.5, 0.0)? }), "nothing was measured");
        Ok(())
    }

    #[test]
    fn latencies_are_read() {
        assert_eq!("lockstep".parse(), Ok(Latency::Lockstep));
        assert_eq!("3".parse(), Ok(Latency::Ticks(3)));
        assert!("4".parse::<Latency>().is_err() && "late".parse::<Latency>().is_err());
    }
}
