//! The bounds of the benchmark.

use super::flatness::{FLAT_SIZES, FlatRun, most_over_least};
use super::scene::AIM_PARTICLES;
use super::{BenchScene, Configuration, Run, Skipped, nanoseconds, over};
use crate::backend::Backend;
use crate::method::Method;
use crate::verdict::{Bound, Verdict};

/// Most nanoseconds per particle-step on two threads.
const AIM_NANOSECONDS: f64 = 150.0;
/// Least speed-up from one to two threads.
const AIM_SCALING: f64 = 1.8;
/// Most time of the GPU solver over the CPU solver's on two threads, for a software driver.
const AIM_RATIO: f64 = 8.0;
/// Most bytes of GPU memory for a particle, with its grid.
const AIM_BYTES: f64 = 120.0;
/// Most of the slowest size's time per particle-step over the fastest's.
const AIM_FLATNESS: f64 = 1.2;

/// The bounds of all runs; the aims count in the full form only, each where its configurations ran. Of one for which
/// `--budget` left a configuration out, the verdict says that it was not measured. `flat` are the sizes that ran in turn.
pub fn verdict(runs: &[Run], skipped: &[Skipped], flat: &[FlatRun], quick: bool) -> Verdict {
    let mut verdict = Verdict::default();
    for run in runs {
        let name = |what: &str| format!("{}, run {}: {what}", run.configuration, run.repeat);
        verdict.check(name("time scale"), run.account.time_scale, "", Bound::AtLeast(0.999));
        verdict.check(name("particles lost"), run.account.lost as f64, "", Bound::AtMost(0.0));
    }
    if quick {
        return verdict;
    }
    let tank = |backend, threads, particles| Configuration { scene: BenchScene::Tank, backend, threads, particles };
    let on_cpu = |threads, particles| tank(Backend::Cpu, Some(threads), particles);
    let [one, two] = [1, 2].map(|threads| on_cpu(threads, AIM_PARTICLES));
    let on_gpu = tank(Backend::Gpu, None, AIM_PARTICLES);
    let time = |of: &Configuration| over(runs, of, nanoseconds).0;
    let ran = |of: &Configuration| runs.iter().any(|run| run.configuration == *of);
    let was_skipped = |of: &Configuration| skipped.iter().any(|skipped| skipped.configuration == *of);
    let mut aim = |name: String, needed: &[Configuration], value: &dyn Fn() -> f64, unit, bound| {
        if needed.iter().all(ran) {
            verdict.check(name, value(), unit, bound);
        } else if needed.iter().all(|of| ran(of) || was_skipped(of)) {
            verdict.leave_open(name, unit, bound);
        }
    };
    let name = |what: &str| format!("tank, {AIM_PARTICLES} particles, {what}");
    aim(name("cpu, 2 threads: median"), &[two], &|| time(&two), "ns", Bound::AtMost(AIM_NANOSECONDS));
    aim(name("cpu: 2 threads over 1"), &[one, two], &|| time(&one) / time(&two), "x", Bound::AtLeast(AIM_SCALING));
    aim(name("gpu over cpu, 2 threads"), &[on_gpu, two], &|| time(&on_gpu) / time(&two), "x", Bound::AtMost(AIM_RATIO));
    let bytes = || over(runs, &on_gpu, |run| run.bytes_per_particle).0;
    aim(name("gpu: memory"), &[on_gpu], &bytes, "B/particle", Bound::AtMost(AIM_BYTES));
    let sizes = FLAT_SIZES.map(|size| on_cpu(2, size));
    for method in Method::ALL {
        let name =
            format!("tank, 8000 to 125000 particles in turn, {}, cpu, 2 threads: most over least", method.name());
        if flat.iter().any(|run| run.method == method) {
            verdict.check(name, most_over_least(flat, method), "x", Bound::AtMost(AIM_FLATNESS));
        } else if sizes.iter().all(|of| ran(of) || was_skipped(of)) {
            verdict.leave_open(name, "x", Bound::AtMost(AIM_FLATNESS));
        }
    }
    verdict
}

#[cfg(test)]
mod tests {
    use super::super::flatness::tests::flat_runs;
    use super::super::tests::run;
    use super::*;

    #[test]
    fn aims_count_at_their_size_and_in_the_full_form_only() {
        let slow = [run(1, 64_000, 500), run(2, 64_000, 300)];
        assert!(!verdict(&slow, &[], &[], false).passes());
        assert!(verdict(&slow, &[], &[], true).passes());
        assert!(verdict(&[run(2, 8_000, 300)], &[], &[], false).passes());
        assert!(verdict(&[run(1, 64_000, 265), run(2, 64_000, 145)], &[], &[], false).passes());
        assert!(!verdict(&[run(1, 64_000, 250), run(2, 64_000, 145)], &[], &[], false).passes(), "scales by 1.72 only");
        let gpu = |nanoseconds, bytes| {
            let run = run(0, 64_000, nanoseconds);
            let configuration = Configuration { backend: Backend::Gpu, threads: None, ..run.configuration };
            [self::run(2, 64_000, 145), Run { configuration, bytes_per_particle: bytes, ..run }]
        };
        assert!(verdict(&gpu(1150, 100.0), &[], &[], false).passes());
        assert!(!verdict(&gpu(1220, 100.0), &[], &[], false).passes(), "8.4 times as slow");
        assert!(!verdict(&gpu(1150, 121.0), &[], &[], false).passes(), "too large");
    }

    #[test]
    fn other_scenes_have_no_aims() {
        let mut krog = run(2, 64_000, 900);
        krog.configuration.scene = BenchScene::Krog;
        assert!(verdict(&[krog], &[], &[], false).passes());
    }

    #[test]
    fn time_is_to_be_flat_over_sizes() {
        let of = |times: [f64; 3]| {
            [Method::WeaklyCompressible, Method::DivergenceFree].map(|method| {
                let verdict = verdict(&[], &[], &flat_runs(method, times), false);
                assert_eq!(verdict.checks.len(), 1, "no word on the method that did not run");
                verdict.passes()
            })
        };
        assert_eq!(of([150.0, 125.0, 149.0]), [true; 2]);
        assert_eq!(of([150.0, 124.0, 140.0]), [false; 2], "1.21 between 8,000 and 64,000");
        assert_eq!(of([125.0, 130.0, 151.0]), [false; 2], "1.21 between 8,000 and 125,000");
        let without_the_last = verdict(&[run(2, 8_000, 150), run(2, 64_000, 100)], &[], &[], false);
        let said = (without_the_last.checks.len(), without_the_last.unmeasured.len());
        assert_eq!(said, (2 * 2 + 1, 0), "no word on what did not run");
    }

    #[test]
    fn what_the_budget_left_out_is_not_measured_and_said_to_be_so() {
        let skipped = |threads, particles| {
            let configuration = run(threads, particles, 1).configuration;
            Skipped { configuration, estimate: 300.0, left: 20.0 }
        };
        let open = |runs: &[Run], skipped: &[Skipped]| -> Vec<String> {
            let verdict = verdict(runs, skipped, &[], false);
            assert!(verdict.passes());
            verdict.unmeasured.into_iter().map(|(name, ..)| name).collect()
        };
        let runs = [run(1, 8_000, 250), run(2, 8_000, 140)];
        let names = open(&runs, &[skipped(1, 64_000), skipped(2, 64_000), skipped(2, 125_000)]);
        assert_eq!(names.len(), 4, "{names:?}");
        let said =
            ["2 threads: median", "2 threads over 1", "WCSPH, cpu, 2 threads: most", "DFSPH, cpu, 2 threads: most"];
        for (name, what) in names.iter().zip(said) {
            assert!(name.contains(what), "{name}");
        }
        let names = open(&[run(2, 64_000, 140)], &[skipped(1, 64_000)]);
        assert!(matches!(&names[..], [name] if name.contains("2 threads over 1")), "{names:?}");
        assert!(open(&runs, &[]).is_empty(), "nobody asked for more");
        let quick = verdict(&runs, &[skipped(2, 64_000)], &[], true);
        assert!(quick.unmeasured.is_empty(), "no aims in the quick form");
    }

    #[test]
    fn the_median_counts_not_the_worst() {
        let runs = [run(2, 64_000, 140), run(2, 64_000, 900), run(2, 64_000, 150)];
        assert_eq!(over(&runs, &runs[0].configuration, nanoseconds), (150.0, 140.0, 900.0));
        assert!(verdict(&runs, &[], &[], false).passes());
    }
}
