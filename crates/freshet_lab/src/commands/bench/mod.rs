//! `bench`: what a step costs, by size, scene, solver and number of threads.

mod aims;
mod budget;
mod configuration;
mod flatness;
mod report;
mod scene;
mod simulate;
mod tables;

use std::thread::available_parallelism;
use std::time::Instant;

use clap::Args;

pub use aims::verdict;
pub use budget::{Budget, Skipped};
pub use configuration::Configuration;
pub use scene::BenchScene;
pub use simulate::{Run, simulate};

use self::report::Results;
use crate::backend::Backend;
use crate::error::LabError;
use crate::measure::machine::Rates;
use crate::measure::statistics::{median, spread};
use crate::options::{BackendChoice, CommonOptions};
use crate::output::{Output, say, say_files};
use crate::progress::Progress;
use crate::verdict::Verdict;

/// Speed: time per particle and step, by pass, thread and size, beside what others published and what the machine can do.
///
/// Scenes: the benchmark tank (2.0 x 1.5 x 1.0 m with six walls, a cubic metre of water in a corner, default settings) with
/// 4K to 512K particles, Pirovano's cube (2011) and Krog's test scene (2010), these two beside their published times.
///
/// Times are of the stepping alone, everything in it included (sort, walls, step control). Nothing is drawn, so nothing of
/// drawing is in them. The configurations of one size run in turn, tick by tick, and that several times, so that a change of the
/// machine's pace meets all; given are the median and the spread. What a size will cost is forecast from smaller ones; what does not
/// fit into --budget any more is left out and named.
///
/// Arithmetic and bytes per particle-step are counted from the schedule, for the neighbours of water at rest, without walls and
/// without candidates that turn out to be too far away. That is too few for a fluid that is compressed, as Krog's is; the table
/// says by how much. They are given as fractions of what this machine was measured to do on as many threads: multiply-adds, and
/// copies that no cache holds. Not for a GPU that is no program on the processor.
///
/// Bounds: every run keeps time (time scale 1) and loses no particle; in the full form also the aims, on the median: in the tank
/// with 64,000 particles at most 150 ns per particle-step on two threads, at least 1.8 times as fast as one, the GPU solver at
/// most 8 times the CPU solver's time (meant for software drivers) with at most 120 bytes a particle. Where 8,000, 64,000 and
/// 125,000 particles ran on two threads, they run once more, all in turn, weakly compressible and incompressible: no size more than
/// 1.2 times as slow as another. Other work on the machine makes those miss. The GPU, scenes other than the tank, and sizes above
/// 128K run once. Writes bench.csv (a row a run, columns explained), bench.svg, and bench_flat.csv of the sizes in turn.
#[derive(Args, Clone, Debug)]
pub struct BenchArgs {
    /// Options every command has.
    #[command(flatten)]
    pub common: CommonOptions,
    /// Scenes [default: all; the tank alone if sizes are given].
    #[arg(long, value_enum, value_name = "SCENE,...", value_delimiter = ',')]
    pub scene: Vec<BenchScene>,
    /// Sizes; in the tank each is rounded to the next cube of a whole number, the other scenes have their published ones
    /// [default: 4K to 512K; quick: 8000, and the smallest of other scenes].
    #[arg(long, value_name = "N,N,...", value_delimiter = ',', value_parser = clap::value_parser!(u32).range(125..=8_000_000))]
    pub particles: Vec<u32>,
    /// Numbers of threads of the CPU solver.
    #[arg(long, value_name = "N,N,...", value_delimiter = ',', value_parser = clap::value_parser!(u16).range(1..=256), default_values_t = [1, 2])]
    pub threads: Vec<u16>,
    /// Time to simulate, s [default: 0.5 in the tank with 64000, otherwise 0.1, Krog 0.25; less above 128K; quick: 0.1].
    #[arg(long, value_name = "S", value_parser = seconds)]
    pub seconds: Option<f64>,
    /// Runs of each configuration of the tank up to 128K on the CPU [default: 3; quick: 1].
    #[arg(long, value_name = "N", value_parser = clap::value_parser!(u16).range(1..=100))]
    pub repeats: Option<u16>,
    /// Wall time that all of it may take, s, 1 to 100000 [default: 1800; quick: 45].
    #[arg(long, value_name = "S", value_parser = budget_seconds)]
    pub budget: Option<f64>,
}

fn seconds(text: &str) -> Result<f64, String> {
    match text.parse() {
        Ok(value) if (0.01..=10.0).contains(&value) => Ok(value),
        _ => Err("allowed: 0.01 to 10".to_owned()),
    }
}

fn budget_seconds(text: &str) -> Result<f64, String> {
    match text.parse() {
        Ok(value) if (1.0..=100_000.0).contains(&value) => Ok(value),
        _ => Err("allowed: 1 to 100000".to_owned()),
    }
}

impl BenchArgs {
    fn scenes(&self) -> Vec<BenchScene> {
        match (self.scene.is_empty(), self.particles.is_empty()) {
            (true, true) => BenchScene::ALL.into_iter().filter(|&scene| !self.is_too_long(scene)).collect(),
            (true, false) => vec![BenchScene::Tank],
            (false, _) => BenchScene::ALL.into_iter().filter(|scene| self.scene.contains(scene)).collect(),
        }
    }

    /// Krog's smallest size is no short form, unless it is asked for.
    fn is_too_long(&self, scene: BenchScene) -> bool {
        self.common.quick && scene == BenchScene::Krog
    }

    fn sizes(&self, scene: BenchScene) -> Result<Vec<u32>, LabError> {
        if self.particles.is_empty() {
            return Ok(if self.common.quick { scene.quick_sizes() } else { scene.sizes() }.to_vec());
        }
        let mut sizes = Vec::new();
        for &asked in &self.particles {
            let size = match scene {
                BenchScene::Tank => crate::scenes::tank::count(asked),
                _ if scene.sizes().contains(&asked) => asked,
                _ => {
                    let allowed: Vec<String> = scene.sizes().iter().map(u32::to_string).collect();
                    let reason = format!("{asked} is not a size of {}; allowed: {}", scene.name(), allowed.join(", "));
                    return Err(LabError::Argument { argument: "--particles", reason });
                }
            };
            if !sizes.contains(&size) {
                sizes.push(size);
            }
        }
        Ok(sizes)
    }

    /// Groups of configurations that run in turn: those of a scene and a size. What is small and what has aims comes first.
    fn groups(&self) -> Result<Vec<Vec<Configuration>>, LabError> {
        let mut groups = Vec::new();
        for scene in self.scenes() {
            for particles in self.sizes(scene)? {
                let of = |backend, threads| Configuration { scene, backend, threads, particles };
                let mut group: Vec<Configuration> = Vec::new();
                for &backend in self.common.backends(BackendChoice::Both) {
                    match backend {
                        Backend::Cpu => {
                            for &threads in &self.threads {
                                let configuration = of(backend, Some(usize::from(threads)));
                                if !group.contains(&configuration) {
                                    group.push(configuration);
                                }
                            }
                        }
                        Backend::Gpu => group.push(of(backend, None)),
                    }
                }
                groups.push(group);
            }
        }
        groups.sort_by_key(|group| group.first().map(|first| first.particles > LARGE));
        Ok(groups)
    }

    fn repeats(&self, configuration: &Configuration) -> u16 {
        match (configuration.scene, configuration.backend) {
            (BenchScene::Tank, Backend::Cpu) if configuration.particles <= LARGE => {
                self.repeats.unwrap_or(if self.common.quick { 1 } else { 3 })
            }
            _ => 1,
        }
    }

    fn simulated(&self, configuration: &Configuration) -> f64 {
        let usual = || configuration.scene.seconds(configuration.particles, self.common.quick);
        self.seconds.unwrap_or_else(usual)
    }
}

/// Sizes above this wait until all others have run, and run once.
const LARGE: u32 = 131_072;

/// Runs the command.
pub fn run(args: &BenchArgs) -> Result<Verdict, LabError> {
    let output = Output::new(&args.common.out)?;
    let quick = args.common.quick;
    let groups = args.groups()?;
    let seconds = args.budget.unwrap_or(if quick { 45.0 } else { 1800.0 });
    let mut budget = Budget::new(seconds);
    let mut progress = Progress::new(seconds);
    progress.begin("what the machine can do", 0.0);
    let start = Instant::now();
    let mut results = Results { rates: rates(&groups)?, ..Results::default() };
    budget.spend(start.elapsed());
    let mut compared = quick;
    for group in groups {
        // Before what is large takes what is left of the budget.
        if !compared && group.first().is_some_and(|first| first.particles > LARGE) {
            compare_sizes(args, &mut results, &mut budget, &mut progress)?;
            compared = true;
        }
        let admitted = admit(args, &group, &budget, &mut results.skipped);
        let most = admitted.iter().map(|configuration| args.repeats(configuration)).max().unwrap_or(0);
        for repeat in 1..=most {
            let now: Vec<Configuration> =
                admitted.iter().copied().filter(|configuration| repeat <= args.repeats(configuration)).collect();
            let Some(first) = now.first() else { continue };
            let simulated = args.simulated(first);
            let work = now.iter().map(|configuration| budget.estimate(configuration, simulated)).sum();
            progress.begin(format!("{first} and {} more in turn, run {repeat}", now.len() - 1), work);
            for run in simulate(&now, repeat, simulated, &mut progress)? {
                budget.learn(run.configuration, run.account.particle_steps, run.account.mean_substep(), run.elapsed);
                results.runs.push(run);
            }
            report::write(&output, &results)?;
        }
    }
    if !compared {
        compare_sizes(args, &mut results, &mut budget, &mut progress)?;
    }
    drop(progress);
    if let ([], Some(first)) = (results.runs.as_slice(), results.skipped.first()) {
        let reason = format!("{seconds} s are too few for any run; the first is {first}");
        return Err(LabError::Argument { argument: "--budget", reason });
    }
    report::write(&output, &results)?;
    tables::print(&results);
    say_files(&output, &report::FILES);
    if !results.flat.is_empty() {
        say_files(&output, &[flatness::FILE]);
    }
    Ok(verdict(&results.runs, &results.skipped, &results.flat, quick))
}

/// Runs the sizes that are compared in turn, if all of them ran by themselves and it fits into what is left.
fn compare_sizes(
    args: &BenchArgs,
    results: &mut Results,
    budget: &mut Budget,
    progress: &mut Progress,
) -> Result<(), LabError> {
    let (scene, backend, threads) = (BenchScene::Tank, Backend::Cpu, Some(flatness::THREADS));
    let sizes = flatness::FLAT_SIZES.map(|particles| Configuration { scene, backend, threads, particles });
    if !sizes.iter().all(|size| results.runs.iter().any(|run| run.configuration == *size)) {
        return Ok(());
    }
    let opening: f64 = sizes.iter().map(|size| budget.estimate(size, simulate::OPENING)).sum();
    let repeats = args.repeats.unwrap_or(3);
    let work = flatness::WORK_OVER_OPENING * opening * f64::from(repeats);
    if work > budget.left() {
        say(format_args!("sizes in turn: about {work:.1} s, {:.1} s left of --budget", budget.left()));
        return Ok(());
    }
    let (runs, elapsed) = flatness::simulate(repeats, progress, work)?;
    results.flat = runs;
    budget.spend(elapsed);
    Ok(())
}

/// Those of a group that fit together.
fn admit(args: &BenchArgs, group: &[Configuration], budget: &Budget, skipped: &mut Vec<Skipped>) -> Vec<Configuration> {
    let mut admitted = Vec::new();
    let mut reserved = 0.0;
    for &configuration in group {
        match budget.admit(configuration, args.simulated(&configuration), args.repeats(&configuration), reserved) {
            Ok(estimate) => {
                reserved += estimate;
                admitted.push(configuration);
            }
            Err(left_out) => skipped.push(left_out),
        }
    }
    admitted
}

/// The machine's rates on every number of threads that occurs, and on all cores for the GPU solver in software.
fn rates(groups: &[Vec<Configuration>]) -> Result<Vec<Rates>, LabError> {
    let mut threads: Vec<usize> = groups.iter().flatten().map(threads_of).collect();
    threads.sort_unstable();
    threads.dedup();
    threads.into_iter().map(Rates::measure).collect()
}

/// Threads that a configuration occupies, a GPU driver in software all.
fn threads_of(configuration: &Configuration) -> usize {
    configuration.threads.unwrap_or_else(|| available_parallelism().map_or(1, usize::from))
}

/// Median and spread of a quantity over the runs of a configuration.
fn over(runs: &[Run], configuration: &Configuration, value: impl Fn(&Run) -> f64) -> (f64, f64, f64) {
    let of = runs.iter().filter(|run| run.configuration == *configuration);
    let values: Vec<f64> = of.map(value).collect();
    let (least, most) = spread(&values).unwrap_or((f64::NAN, f64::NAN));
    (median(&values).unwrap_or(f64::NAN), least, most)
}

fn nanoseconds(run: &Run) -> f64 {
    run.account.nanoseconds_per_particle_step()
}

fn opening_nanoseconds(run: &Run) -> f64 {
    run.opening_nanoseconds
}

#[cfg(test)]
mod tests {
    use std::time::Duration;

    use clap::Parser;

    use super::*;
    use crate::backend::Hardware;
    use crate::drive::Account;

    pub(super) fn run(threads: usize, particles: u32, nanoseconds: u64) -> Run {
        let configuration =
            Configuration { scene: BenchScene::Tank, backend: Backend::Cpu, threads: Some(threads), particles };
        let account = Account {
            wall: Duration::from_nanos(nanoseconds * 1000),
            particle_steps: 1000.0,
            simulated: 0.5,
            substeps: 10,
            time_scale: 1.0,
            passes: vec![("density".to_owned(), nanoseconds as f64 * 1000.0 / 1e6 / 2.0)],
            ..Account::default()
        };
        Run {
            configuration,
            repeat: 1,
            hardware: Hardware { name: "a processor".to_owned(), is_processor: true },
            particles: particles as usize,
            front: vec![],
            bytes_per_particle: 100.0,
            bytes: 1,
            operations: 2000.0,
            moved_bytes: 200.0,
            opening_nanoseconds: nanoseconds as f64,
            elapsed: account.wall,
            account,
        }
    }

    pub(super) fn results(runs: &[Run]) -> Results {
        let rates = [1, 2].map(|threads| Rates { threads, copied_bytes: 10e9, operations: 100e9 });
        Results { runs: runs.to_vec(), rates: rates.to_vec(), ..Results::default() }
    }

    pub(super) fn in_scene(scene: BenchScene, run: Run) -> Run {
        Run { configuration: Configuration { scene, ..run.configuration }, ..run }
    }

    #[derive(Parser)]
    struct Line {
        #[command(flatten)]
        args: BenchArgs,
    }

    fn parse(line: &[&str]) -> Result<BenchArgs, String> {
        let line = ["bench"].iter().chain(line);
        Line::try_parse_from(line).map(|line| line.args).map_err(|error| error.to_string())
    }

    #[test]
    fn small_sizes_come_before_large_ones_of_any_scene() -> Result<(), String> {
        let groups = parse(&[])?.groups().map_err(|error| error.to_string())?;
        let firsts: Vec<Configuration> = groups.iter().filter_map(|group| group.first().copied()).collect();
        let large = firsts.iter().position(|first| first.particles > LARGE);
        assert_eq!(large, Some(6 + 2 + 3), "{firsts:?}");
        assert_eq!(firsts.len(), 8 + 2 + 5);
        assert_eq!(groups[0].len(), 3, "one thread, two threads, GPU");
        let sizes: Vec<u32> = firsts.iter().take(6).map(|first| first.particles).collect();
        assert_eq!(sizes, [4_096, 8_000, 15_625, 32_768, 64_000, 125_000]);
        Ok(())
    }

    #[test]
    fn what_is_asked_for_is_run_and_nothing_else() -> Result<(), String> {
        let args = parse(&["--particles", "8000,8001,27000", "--threads", "2,2", "--backend", "cpu"])?;
        let groups = args.groups().map_err(|error| error.to_string())?;
        let sizes: Vec<u32> = groups.iter().flatten().map(|configuration| configuration.particles).collect();
        assert_eq!(sizes, [8_000, 27_000]);
        let args = parse(&["--scene", "krog", "--particles", "65536", "--backend", "gpu"])?;
        let groups = args.groups().map_err(|error| error.to_string())?;
        assert_eq!(groups.len(), 1);
        assert_eq!(groups[0][0].scene, BenchScene::Krog);
        assert_eq!(parse(&["--quick"])?.scenes(), [BenchScene::Tank, BenchScene::Pirovano]);
        Ok(())
    }

    #[test]
    fn bad_arguments_name_what_is_allowed() -> Result<(), String> {
        let args = parse(&["--scene", "pirovano", "--particles", "5000"])?;
        let error = args.groups().map_err(|error| error.to_string());
        assert_eq!(error.err().as_deref(), Some("--particles: 5000 is not a size of pirovano; allowed: 4096, 32768"));
        let message = |line: &[&str]| parse(line).err().unwrap_or_default();
        assert!(message(&["--budget", "0"]).contains("'0' for '--budget <S>': allowed: 1 to 100000"));
        assert!(message(&["--seconds", "1e9"]).contains("allowed: 0.01 to 10"));
        let scene = message(&["--scene", "bath"]);
        assert!(scene.contains("bath") && scene.contains("tank, pirovano, krog"), "{scene}");
        Ok(())
    }

    #[test]
    fn a_group_shares_what_is_left() -> Result<(), String> {
        let args = parse(&["--particles", "64000", "--backend", "cpu", "--repeats", "1", "--seconds", "0.1"])?;
        let groups = args.groups().map_err(|error| error.to_string())?;
        let budget = Budget::new(1000.0);
        let both: f64 =
            groups[0].iter().map(|configuration| budget.estimate(configuration, args.simulated(configuration))).sum();
        let mut skipped = Vec::new();
        let admitted = admit(&args, &groups[0], &Budget::new(both * 0.99), &mut skipped);
        assert_eq!(admitted, groups[0][..1]);
        assert_eq!(skipped.len(), 1);
        assert_eq!(skipped[0].configuration, groups[0][1]);
        assert_eq!(admit(&args, &groups[0], &Budget::new(both * 1.01), &mut skipped).len(), 2);
        Ok(())
    }
}
