//! The examples that are played, without a window: what is wrong is one clear line, and games end as they should.

use std::path::{Path, PathBuf};
use std::process::{Command, Output};

/// An example, which `cargo test` builds beside the tests.
fn run(example: &str, arguments: &[&str]) -> Output {
    let mut folder = std::env::current_exe().expect("a test has a path");
    // target/debug/deps/it-... -> target/debug/examples
    folder.pop();
    folder.pop();
    let program = folder.join("examples").join(format!("{example}{}", std::env::consts::EXE_SUFFIX));
    let mut command = Command::new(&program);
    command.args(arguments).current_dir(env!("CARGO_MANIFEST_DIR"));
    command.output().unwrap_or_else(|error| panic!("{}: {error}", program.display()))
}

/// What an example printed that went well.
fn summary(example: &str, arguments: &[&str]) -> String {
    let output = run(example, arguments);
    let said = String::from_utf8_lossy(&output.stderr);
    assert_eq!(output.status.code(), Some(0), "{example} {arguments:?}: {said}");
    String::from_utf8(output.stdout).expect("a summary is text")
}

/// What stands behind a name in the JSON of one object without others in it.
fn field<'a>(json: &'a str, name: &str) -> &'a str {
    let start = format!("\"{name}\": ");
    let from = json.find(&start).unwrap_or_else(|| panic!("no {name} in {json}")) + start.len();
    json[from..].split([',', '\n', '}']).next().unwrap_or_default().trim().trim_matches('"')
}

fn number(json: &str, name: &str) -> f32 {
    field(json, name).parse().unwrap_or_else(|error| panic!("{name}: {error} in {json}"))
}

/// One clear line and exit code 2.
fn is_refused(example: &str, arguments: &[&str], words: &[&str]) {
    let output = run(example, arguments);
    let said = String::from_utf8_lossy(&output.stderr);
    assert_eq!(output.status.code(), Some(2), "{arguments:?}: {said}");
    assert_eq!(said.lines().count(), 1, "{arguments:?}: {said}");
    for word in words {
        assert!(said.starts_with("error: ") && said.contains(word), "{arguments:?}: {said}, not {word}");
    }
}

/// An empty folder that is gone at the end.
struct Folder(PathBuf);

impl Folder {
    fn new(name: &str) -> Self {
        let path = std::env::temp_dir().join(format!("freshet_{name}_{}", std::process::id()));
        std::fs::create_dir_all(&path).expect("a temporary folder");
        Self(path)
    }

    fn path(&self) -> String {
        self.0.display().to_string()
    }
}

impl Drop for Folder {
    fn drop(&mut self) {
        // A test that has failed already shall not fail again here.
        let _ = std::fs::remove_dir_all(&self.0);
    }
}

#[test]
fn floating_bodies_float_as_deep_as_they_are_dense() {
    let arguments = ["--headless", "--backend", "cpu", "--particles", "4000", "--seconds", "6"];
    let printed = summary("floating_bodies", &arguments);
    assert_eq!(field(&printed, "backend"), "cpu", "{printed}");
    assert_eq!(number(&printed, "removed"), 0.0, "{printed}");
    // What drops from 0.3 m has 2.4 m/s; what it squeezes out is faster, but is not blown away.
    assert!(number(&printed, "max_speed_m_s") < 12.0, "{printed}");
    let bodies: Vec<&str> = printed.lines().filter(|line| line.contains("\"shape\"")).collect();
    assert_eq!(bodies.len(), 8, "{printed}");
    for body in bodies {
        let (density, force) = (number(body, "density"), number(body, "force_over_weight"));
        let (shape, under_water) = (field(body, "shape"), number(body, "under_water"));
        if density > 2000.0 {
            // It lies on the ground, which carries what the water does not.
            assert!(under_water > 0.99 && force < 1000.0 / density + 0.05, "{body}");
            continue;
        }
        assert!((force - 1.0).abs() < 0.06, "what floats is carried by the water: {body}");
        assert!(number(body, "wetted") > 0.1 && under_water < 0.98, "what floats looks out: {body}");
        // Thicker than four particles, and neither awash nor hollow.
        if matches!(shape, "ball" | "cube") {
            assert!((under_water - density / 1000.0).abs() < 0.05, "{body}");
        }
    }
}

#[test]
fn sluice_is_won_by_the_moves_of_each_level() {
    for level in ["1", "2", "3"] {
        let arguments = ["--headless", "--backend", "cpu", "--particles", "1500", "--level", level, "--autoplay"];
        let printed = summary("sluice", &arguments);
        assert_eq!(field(&printed, "outcome"), "won", "{printed}");
        // Counted with the stream.
        assert!(number(&printed, "turns") >= 1.5 && number(&printed, "score") > 1000.0, "{printed}");
        assert!(number(&printed, "litres") > 150.0, "{printed}");
    }
}

#[test]
fn sluice_is_lost_without_moves() {
    let printed = summary("sluice", &["--headless", "--backend", "cpu", "--particles", "1000"]);
    assert_eq!(field(&printed, "outcome"), "time is over", "{printed}");
    assert_eq!((number(&printed, "litres"), number(&printed, "score")), (0.0, 0.0), "{printed}");
    assert!(number(&printed, "turns").abs() < 0.1, "{printed}");
}

/// A level of the game with something changed, alone in a folder.
fn changed_level(folder: &Folder, level: &str, change: impl Fn(&str) -> String) {
    let own = Path::new(env!("CARGO_MANIFEST_DIR")).join("assets/sluice").join(level);
    let text = std::fs::read_to_string(own).expect("a level");
    let changed = change(&text);
    assert_ne!(text, changed);
    std::fs::write(folder.0.join("changed.ron"), changed).expect("a level");
}

#[test]
fn sluice_is_lost_when_the_water_falls_through_the_grating() {
    let folder = Folder::new("leak");
    changed_level(&folder, "2_the_leak.ron", |text| text.replace("(at: 0.2, what: Crate((3.15, 0.9))),", ""));
    let path = folder.path();
    let arguments = ["--headless", "--backend", "cpu", "--particles", "1500", "--autoplay", "--levels", &path];
    let printed = summary("sluice", &arguments);
    assert_eq!(field(&printed, "outcome"), "water is lost", "{printed}");
    assert!(number(&printed, "removed") > 500.0 && number(&printed, "turns") > 0.5, "{printed}");
}

#[test]
fn a_bad_level_is_one_line_with_file_field_value_and_range() {
    let folder = Folder::new("levels");
    let path = folder.path();
    is_refused("sluice", &["--levels", &path], &["no level", "*.ron"]);
    is_refused("sluice", &["--levels", "no/such/folder"], &["no/such/folder"]);
    is_refused("sluice", &["--level", "9"], &["--level 9", "1 to 3"]);
    for (from, to, words) in [
        ("blades: 8", "blades: 99", ["wheel.blades: 99", "4 to 12"]),
        ("radius: 0.5", "radius: NaN", ["wheel.radius: NaN", "0.3 to 1 m"]),
        ("high: (1.2, 2.0)", "high: (1.2, 1.0)", ["gates[0].high.y: 1", "at least 1.59"]),
        ("Gate(0)", "Gate(7)", ["moves[0].what: 7", "less than 1"]),
        ("litres: 180.0", "liters: 180.0", ["liters", "litres"]),
        ("name: \"First water\"", "name: \"\"", ["name", "not empty"]),
    ] {
        changed_level(&folder, "1_first_water.ron", |text| text.replace(from, to));
        is_refused("sluice", &["--levels", &path], &[["changed.ron"].as_slice(), &words].concat());
    }
}

#[test]
fn a_bad_argument_of_a_game_is_one_line() {
    is_refused("floating_bodies", &["--particles", "7"], &["allowed: 1000 to 500000"]);
    is_refused("floating_bodies", &["--seconds", "NaN"], &["allowed: 0.01 to 600"]);
    is_refused("sluice", &["--particles", "many"], &["allowed: 500 to 200000"]);
    is_refused("sluice", &["--backend", "tpu"], &["allowed: auto, gpu, cpu"]);
}

#[test]
fn a_picture_of_the_end_is_written() {
    let folder = Folder::new("end");
    let path = folder.0.join("end.png");
    let (name, seconds) = (path.display().to_string(), "0.2");
    let arguments = ["--headless", "--backend", "cpu", "--particles", "1000", "--seconds", seconds, "--picture", &name];
    summary("floating_bodies", &arguments);
    let picture = image::open(&path).expect("a picture").to_rgb8();
    assert_eq!(picture.dimensions(), (1280, 720));
    // Water is blue, bodies are red and yellow.
    let count = |is: fn([u8; 3]) -> bool| picture.pixels().filter(|pixel| is(pixel.0)).count();
    assert!(count(|[red, _, blue]| blue > 60 && blue > red.saturating_add(30)) > 20_000);
    assert!(count(|[red, _, blue]| red > 120 && red > blue.saturating_add(60)) > 4_000);
}
