//! The example's command line: what is wrong is one clear line, and exit code 2, or 1 if it goes wrong while it runs.

use std::path::PathBuf;
use std::process::{Command, Output};

/// The example, which `cargo test` builds beside the tests.
fn dam_break(arguments: &[&str]) -> Output {
    dam_break_in(&[], arguments)
}

/// The same with some variables of its environment set.
fn dam_break_in(variables: &[(&str, &str)], arguments: &[&str]) -> Output {
    let mut folder = std::env::current_exe().expect("a test has a path");
    // target/debug/deps/it-... -> target/debug/examples
    folder.pop();
    folder.pop();
    let program: PathBuf = folder.join("examples").join(format!("dam_break{}", std::env::consts::EXE_SUFFIX));
    let mut command = Command::new(&program);
    command.args(arguments).envs(variables.iter().copied()).current_dir(env!("CARGO_MANIFEST_DIR"));
    command.output().unwrap_or_else(|error| panic!("{}: {error}", program.display()))
}

/// What stands behind a name in a summary.
fn field<'a>(summary: &'a str, name: &str) -> &'a str {
    let start = format!("\"{name}\": ");
    let line = summary.lines().find_map(|line| line.trim().strip_prefix(&start));
    line.unwrap_or_else(|| panic!("no {name} in {summary}")).trim_end_matches(',')
}

fn number(summary: &str, name: &str) -> f64 {
    field(summary, name).parse().unwrap_or_else(|error| panic!("{name}: {error} in {summary}"))
}

fn is_refused(arguments: &[&str], word: &str) {
    let output = dam_break(arguments);
    let said = String::from_utf8_lossy(&output.stderr);
    assert_eq!(output.status.code(), Some(2), "{arguments:?}: {said}");
    assert_eq!(said.lines().count(), 1, "{arguments:?}: {said}");
    assert!(said.starts_with("error: ") && said.contains(word), "{arguments:?}: {said}");
}

#[test]
fn a_bad_argument_is_one_line_and_exit_code_2() {
    is_refused(&["--particles", "many"], "allowed: 100 to 2000000");
    is_refused(&["--particles", "-5"], "-5");
    is_refused(&["--seconds", "NaN"], "allowed: 0.01 to 600");
    is_refused(&["--backend", "tpu"], "allowed: auto, gpu, cpu");
    is_refused(&["--style", "mist"], "allowed: surface, spheres");
    is_refused(&["--fast"], "--fast");
    is_refused(&["--scene", "no/such/file.ron"], "no/such/file.ron");
}

#[test]
fn a_bad_scene_file_is_one_line_that_names_the_place_and_exit_code_2() {
    let folder = std::env::temp_dir().join(format!("freshet_scenes_{}", std::process::id()));
    std::fs::create_dir_all(&folder).expect("a temporary folder");
    for (name, text, word) in [
        ("empty", "", "line 1"),
        ("unknown", "FluidScene(\n    resolution: Spacing(0.1),\n    viscosty: 1.0,\n)", "line 3"),
        ("negative", "FluidScene(\n    resolution: Spacing(-0.1),\n)", "resolution"),
    ] {
        let path = folder.join(format!("{name}.ron"));
        std::fs::write(&path, text).expect("a scene file");
        is_refused(&["--scene", &path.display().to_string()], word);
    }
    std::fs::remove_dir_all(&folder).expect("the temporary folder");
}

#[test]
fn help_lists_the_options() {
    let output = dam_break(&["--help"]);
    let said = String::from_utf8_lossy(&output.stdout);
    assert_eq!(output.status.code(), Some(0));
    for option in ["--particles", "--seconds", "--backend", "--style", "--headless", "--out", "--scene <FILE.ron>"] {
        assert!(said.contains(option), "{option}: {said}");
    }
}

#[test]
fn a_scene_without_end_is_refused_and_so_is_a_folder_that_is_a_file() {
    #[cfg(unix)]
    is_refused(&["--scene", "/dev/zero"], "16777216");
    let file = std::env::temp_dir().join(format!("freshet_out_{}", std::process::id()));
    std::fs::write(&file, "a file").expect("a temporary file");
    let path = file.display().to_string();
    is_refused(&["--headless", "--out", &path], &path);
    is_refused(&["--headless", "--out", &file.join("in_it").display().to_string()], &path);
    std::fs::remove_file(&file).expect("the temporary file");
}

#[test]
fn headless_simulates_what_was_asked_for_and_ends_with_a_picture() {
    // At 0, 0.1, 0.2 and 0.3 s; and at 0 and 0.5 s, in updates longer than Bevy allows by default.
    for (seconds, rate, expected) in [(0.3, "10", 4), (0.5, "1", 2)] {
        let folder = std::env::temp_dir().join(format!("freshet_run_{rate}_{}", std::process::id()));
        let (out, asked) = (folder.display().to_string(), seconds.to_string());
        let output = dam_break(&[
            "--headless",
            "--particles",
            "300",
            "--seconds",
            &asked,
            "--pictures",
            rate,
            "--backend",
            "cpu",
            "--out",
            &out,
        ]);
        let said = String::from_utf8_lossy(&output.stderr);
        assert_eq!(output.status.code(), Some(0), "{said}");
        let summary = std::fs::read_to_string(folder.join("summary.json")).expect("a summary");
        let simulated = number(&summary, "simulated_s");
        assert!((simulated - seconds).abs() < 1e-3, "{simulated}");
        // Simulating and drawing are timed apart: frames without a tick came after those with one, all within the whole.
        let still: Vec<f64> = field(&summary, "still_frames_wall_s")
            .trim_matches(['[', ']'])
            .split(", ")
            .map(|time| time.parse().expect("a number"))
            .collect();
        assert_eq!(still.len(), 10, "{summary}");
        assert!(still.iter().all(|time| *time > 0.0), "{summary}");
        let (ticks, of_tick) = (number(&summary, "ticks"), number(&summary, "solver_wall_s_per_tick"));
        assert_eq!(ticks, (60.0 * seconds).round(), "{summary}");
        assert!(of_tick > 0.0, "{summary}");
        assert!(ticks * of_tick + still.iter().sum::<f64>() < number(&summary, "wall_s"), "{summary}");
        let text = std::fs::read_to_string(folder.join("summary.txt")).expect("a summary");
        for line in ["wall time of a tick, solver only", "wall time of a frame without a tick"] {
            assert!(text.contains(line), "{text}");
        }
        let pictures = std::fs::read_dir(&folder).expect("the folder").flatten();
        let is_picture = |path: PathBuf| path.extension().is_some_and(|extension| extension == "png");
        let pictures = pictures.filter(|file| is_picture(file.path())).count();
        assert_eq!(pictures, expected, "{summary}");
        std::fs::remove_dir_all(&folder).expect("the temporary folder");
    }
}

#[test]
fn a_missing_picture_is_one_line_and_exit_code_1() {
    let folder = std::env::temp_dir().join(format!("freshet_wrong_{}", std::process::id()));
    std::fs::create_dir_all(&folder).expect("a temporary folder");
    // A picture cannot be written where there is a folder of its name.
    std::fs::create_dir_all(folder.join("frame_0001.png")).expect("a temporary folder");
    let out = folder.display().to_string();
    let short = ["--headless", "--particles", "300", "--seconds", "0.1", "--backend", "cpu", "--out"];
    let output = dam_break(&[short.as_slice(), &[&out]].concat());
    let said = String::from_utf8_lossy(&output.stderr);
    assert_eq!(output.status.code(), Some(1), "{said}");
    let last = said.lines().last().unwrap_or_default();
    assert!(last.starts_with("error: ") && last.contains("frame_0001.png"), "{said}");
    std::fs::remove_dir_all(&folder).expect("the temporary folder");
}

/// An empty folder, and the arguments of a short run that writes to it.
fn short_run(name: &str) -> (PathBuf, [String; 8]) {
    let folder = std::env::temp_dir().join(format!("freshet_{name}_{}", std::process::id()));
    std::fs::create_dir_all(&folder).expect("a temporary folder");
    let out = folder.display().to_string();
    let arguments = ["--particles", "300", "--seconds", "0.05", "--backend", "cpu", "--out", &out];
    let arguments = arguments.map(str::to_owned);
    (folder, arguments)
}

#[cfg(target_os = "linux")]
#[test]
fn a_display_that_cannot_be_reached_is_one_line_and_pictures() {
    let (folder, arguments) = short_run("unreachable");
    let output =
        dam_break_in(&[("DISPLAY", ":9753"), ("WAYLAND_DISPLAY", "")], &arguments.each_ref().map(String::as_str));
    let said = String::from_utf8_lossy(&output.stderr);
    assert_eq!(output.status.code(), Some(0), "{said}");
    let lines: Vec<_> = said.lines().filter(|line| line.contains("no display, so pictures in ")).collect();
    assert_eq!(lines.len(), 1, "{said}");
    assert!(lines[0].contains(&arguments[7]) && !said.contains("panicked"), "{said}");
    assert!(folder.join("frame_0000.png").is_file() && folder.join("summary.json").is_file(), "{said}");
    std::fs::remove_dir_all(&folder).expect("the temporary folder");
}

#[cfg(target_os = "linux")]
#[test]
fn without_an_adapter_there_is_a_summary_and_a_plot_or_exit_code_1() {
    let none =
        [("VK_DRIVER_FILES", "/dev/null"), ("VK_ICD_FILENAMES", "/dev/null"), ("DISPLAY", ""), ("WAYLAND_DISPLAY", "")];
    let (folder, arguments) = short_run("no_adapter");
    let arguments = arguments.each_ref().map(String::as_str);
    let output = dam_break_in(&none, &arguments);
    let said = String::from_utf8_lossy(&output.stderr);
    assert_eq!(output.status.code(), Some(0), "{said}");
    assert!(said.contains("no GPU adapter, so no pictures"), "{said}");
    for file in ["summary.txt", "summary.json", "front.svg"] {
        assert!(folder.join(file).is_file(), "{file}: {said}");
    }
    // Nothing draws: no time of it, but that of simulating.
    let summary = std::fs::read_to_string(folder.join("summary.json")).expect("a summary");
    assert_eq!(field(&summary, "still_frames_wall_s"), "[]", "{summary}");
    assert!(number(&summary, "solver_wall_s_per_tick") > 0.0, "{summary}");
    // A summary cannot be written where there is a folder of its name.
    std::fs::remove_file(folder.join("summary.txt")).expect("the summary");
    std::fs::create_dir(folder.join("summary.txt")).expect("a folder");
    let output = dam_break_in(&none, &arguments);
    let said = String::from_utf8_lossy(&output.stderr);
    assert_eq!(output.status.code(), Some(1), "{said}");
    let last = said.lines().last().unwrap_or_default();
    assert!(last.starts_with("error: ") && last.contains("summary.txt"), "{said}");
    std::fs::remove_dir_all(&folder).expect("the temporary folder");
}
