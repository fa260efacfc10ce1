//! Scene files: what is read, and what is said of what cannot be.

use std::fmt::Write as _;

use freshet_core::prelude::*;
use freshet_core::scene_file::{MAX_SCENE_BYTES, plan_from_ron};
use proptest::prelude::*;

/// A valid file. Its comments and strings hold what a careless search for a field would find.
const TANK: &str = r##"// volumes: [(shape: Sphere(radius: 9))], settings: (sound_speed: 9)
#![enable(implicit_some)]
FluidScene(
    name: "a \"tank\": volumes: [(center", /* settings: ( /* radius: 1 */ sound_speed: 2 */
    resolution: Spacing(0.1),
    gravity: (0, -9.81, 0),
    material: (
        name: r#"salt " water: ("#,
        rest_density: 1025,
        dynamic_viscosity: 1e-3,
    ),
    volumes: [
        (shape: Box(half_extents: (0.5, 0.5, 0.5)), center: (0.5, 0.5, 0.5)), // [1] center: (
        (
            shape: Sphere(
                radius: 0.2,
            ),
            center: (2.5, 0.5, 0.5),
            velocity: (0, 0.25, 0),
        ),
    ],
    emitters: [
        (
            center: (3, 2, 0.5),
            direction: (0, -1, 0),
            radius: 0.15,
            speed: 1.5,
            lifetime: 2,
        ),
    ],
    boundaries: [
        (shape: Container(half_extents: (2, 1.5, 0.5), open: (false, false, false, true, false, false)), center: (2, 1.5, 0.5)),
        (
            shape: Plane(half_extents: (4.5, 3.5)),
            center: (2, -1, 0.5),
            friction: (at_rest: 0.75, sliding: 0.625),
        ),
    ],
    bodies: [(name: "cork", samples: [
        (0.125, 0, 0),
        (-0.125, 0, 0),
    ])],
    settings: (
        support: Ratio(2),
        sound_speed: Some(90),
        artificial_viscosity: 0.07,
        near_pressure: 0.01,
        xsph: 0.25,
        widest_support: 1.25,
        courant_factor: 0.41,
        force_factor: 0.26,
        viscous_factor: 0.13,
        max_substeps: 2000,
        budget_milliseconds: 12.5,
        max_particles: 20000,
        bounds: ((-40, -41, -42), (40, 41, 42)),
    ),
)
"##;

/// The file with one thing changed, and the line of the change.
fn changed(from: &str, to: &str) -> (String, usize) {
    assert_eq!(TANK.matches(from).count(), 1, "{from}");
    let at = TANK.find(from).unwrap();
    (TANK.replace(from, to), 1 + TANK[..at].matches('\n').count())
}

fn assert_says(error: &SceneError, parts: &[&str]) {
    let message = error.to_string();
    for part in parts {
        assert!(message.contains(part), "{part:?} is missing in: {message}");
    }
}

#[test]
fn a_file_is_read_and_planned() {
    let (scene, plan) = plan_from_ron(TANK).unwrap();
    assert_eq!(scene.name, "a \"tank\": volumes: [(center");
    assert_eq!(scene.material.name, "salt \" water: (");
    assert_eq!(scene.volumes[1].shape, Shape::Sphere { radius: 0.2 });
    assert_eq!(scene.volumes[1].rotation, Quat::IDENTITY);
    assert_eq!(scene.settings.sound_speed, Some(90.0));
    assert_eq!(scene.settings.max_particles, Some(20_000));
    assert_eq!(scene.settings.kernel, KernelKind::WendlandC2);
    assert_eq!(scene.bodies[0].samples[1], Vec3::new(-0.125, 0.0, 0.0));
    assert_eq!(plan.volume_ids[0], (0, 1000));
    assert_eq!(FluidScene::from_ron_bytes(TANK.as_bytes()).unwrap(), scene);
}

#[test]
fn what_is_left_out_is_the_default() {
    let scene = FluidScene::from_ron("(resolution: Spacing(0.05))").unwrap();
    assert_eq!(scene, FluidScene::with_spacing(0.05));
    // As an editor of Windows writes it.
    assert_eq!(FluidScene::from_ron("\u{feff}(\r\nresolution: Spacing(0.05)\r\n)\r\n").unwrap(), scene);
}

#[test]
fn writing_and_reading_gives_the_same_scene() {
    let mut full = FluidScene::from_ron(TANK).unwrap();
    full.resolution = Resolution::Particles(8000);
    full.emitters[0].lifetime = f32::INFINITY;
    full.volumes[0].rotation = Quat::from_rotation_y(0.3);
    full.settings = Settings {
        kernel: KernelKind::Spiky,
        support: Support::Neighbours(40.0),
        equation_of_state: Some(EquationOfState::Harada { reference_pressure: 0.1, stiffness: 1e-6 }),
        clamp_negative_pressure: false,
        sound_speed: None,
        expected_speed: Some(f32::from_bits(0x3f80_0001)),
        allow_compressible: true,
        ..full.settings
    };
    for scene in [full, FluidScene::with_spacing(1e-4), FluidScene::from_ron(TANK).unwrap()] {
        let text = scene.to_ron().unwrap();
        assert_eq!(FluidScene::from_ron(&text).unwrap(), scene, "{text}");
    }
}

/// One boundary of each shape, as text.
const SHAPES: &str = "(
    resolution: Spacing(0.1),
    boundaries: [
        (shape: HalfSpace(half_extents: (2, 3)), center: (0, -9, 0)),
        (shape: Sphere(radius: 0.5, fluid: Inside), center: (0, 0, 0)),
        (shape: Cylinder(radius: 0.5, half_height: 0.4), center: (2, 0, 0)),
        (shape: Capsule(radius: 0.51, half_height: 0.4, fluid: Both), center: (4, 0, 0)),
        (shape: Cone(radius: 0.52, half_height: 0.4), center: (6, 0, 0)),
        (shape: Cup(radius: 0.53, half_height: 0.4, thickness: 0.2), center: (8, 0, 0)),
        (shape: ConvexHull(points: [(0, 0, 0), (1, 0, 0), (0, 1, 0), (0, 0, 1.5)]), center: (10, 0, 0)),
        (shape: Mesh(mesh: (
            vertices: [(0, 0, 0), (1, 0, 0), (0, 2.5, 0)],
            triangles: [(0, 1, 2)],
        )), center: (12, 0, 0)),
        (shape: HeightField(field: (size: (1.5, 1), counts: (2, 2),
            heights: [0, 1, 0, 0.25],
        )), center: (14, 0, 0)),
    ],
)";

#[test]
fn every_shape_of_a_boundary_is_read_written_and_planned() {
    let (scene, plan) = plan_from_ron(SHAPES).unwrap();
    let BoundaryShape::Cylinder { fluid: FluidSide::Outside, .. } = scene.boundaries[2].shape else { panic!() };
    let BoundaryShape::Mesh { ref mesh, fluid: None } = scene.boundaries[7].shape else { panic!() };
    assert_eq!(mesh.triangles(), [[0, 1, 2]]);
    let text = scene.to_ron().unwrap();
    assert_eq!(FluidScene::from_ron(&text).unwrap(), scene, "{text}");
    assert_eq!(plan.boundary.solids.len(), 9);
    for boundary in &scene.boundaries {
        let samples = plan.boundary.positions.iter().filter(|x| x.distance(boundary.center) < 1.0).count();
        assert!(samples > 30 || matches!(boundary.shape, BoundaryShape::ConvexHull { .. }), "{boundary:?}");
    }
    assert!(plan.to_string().contains(&format!("{} wall samples", plan.boundary.positions.len())));
}

#[test]
fn a_bad_shape_of_a_boundary_is_reported_with_line_and_field() {
    for (from, to, parts) in [
        ("half_extents: (2, 3)", "half_extents: (2, -3)", ["boundaries[0].shape.half_extents: -3", "0.00001 to"]),
        ("radius: 0.5, fluid: Inside", "radius: 0, fluid: Inside", ["boundaries[1].shape.radius: 0 ", "0.00001 to"]),
        (
            "radius: 0.5, half_height: 0.4)",
            "radius: 0.5, half_height: -1)",
            ["[2].shape.half_height: -1", "0.00001 to"],
        ),
        ("radius: 0.51", "radius: 2e6", ["boundaries[3].shape.radius: 2000000", "to 1000000 m"]),
        ("radius: 0.52", "radius: 1e-6", ["boundaries[4].shape.radius: 0.000001", "0.00001 to"]),
        ("thickness: 0.2", "thickness: 0", ["boundaries[5].shape.thickness: 0", "0.00001 to"]),
        ("(0, 0, 1.5)", "(0.5, 0.5, 0)", ["boundaries[6].shape.points: points of one plane", "span a volume"]),
        ("(0, 0, 1.5)", "(0, 0, NaN)", ["boundaries[6].shape.points[3]: [0, 0, NaN]", "within 1000000 m"]),
        ("(0, 2.5, 0)", "(0, NaN, 0)", ["boundaries[7].shape.mesh.vertices[2]: [0, NaN, 0]", "within 1000000 m"]),
        ("triangles: [(0, 1, 2)]", "triangles: [(0, 1, 3)]", ["boundaries[7].shape.mesh.triangles[0]: 3 ", "0 to 2"]),
        ("triangles: [(0, 1, 2)]", "triangles: []", ["boundaries[7].shape.mesh.triangles: 0 of them", "1 to"]),
        ("heights: [0, 1, 0, 0.25]", "heights: [0, 1, 0]", ["boundaries[8].shape.field.heights: 3 of them", "4, as"]),
        ("heights: [0, 1, 0, 0.25]", "heights: [0, 1, 0, inf]", ["boundaries[8].shape.field.heights[3]: inf", "m"]),
        ("counts: (2, 2)", "counts: (1, 4)", ["boundaries[8].shape.field.counts: 1 x 4", "at least 2"]),
    ] {
        assert_eq!(SHAPES.matches(from).count(), 1, "{from}");
        let line = 1 + SHAPES[..SHAPES.find(from).unwrap()].matches('\n').count();
        let error = FluidScene::from_ron(&SHAPES.replace(from, to)).unwrap_err();
        assert_says(&error, &parts);
        assert_says(&error, &[&format!("line {line}: ")]);
    }
}

#[test]
fn what_could_not_be_read_again_is_not_written() {
    let error = FluidScene::with_spacing(f32::NAN).to_ron().unwrap_err();
    assert_says(&error, &["resolution", "NaN", "0.0001 to 100"]);
    let body = Body { samples: vec![Vec3::splat(0.123_456_7); 1 << 20], ..Body::default() };
    let large = FluidScene { bodies: vec![body], ..FluidScene::with_spacing(0.1) };
    assert!(matches!(large.to_ron(), Err(SceneError::TooLarge { .. })));
}

/// Each: what is changed into what, then field, value and allowed range as the message must name them.
const INVALID: [(&str, &str, [&str; 3]); 55] = [
    ("Spacing(0.1)", "Spacing(-0.1)", ["resolution", "-0.1", "0.0001 to 100"]),
    ("Spacing(0.1)", "Spacing(0)", ["resolution", "0", "0.0001 to 100"]),
    ("Spacing(0.1)", "Spacing(1e-5)", ["resolution", "0.00001", "0.0001 to 100"]),
    ("Spacing(0.1)", "Spacing(NaN)", ["resolution", "NaN", "0.0001 to 100"]),
    ("Spacing(0.1)", "Spacing(1e99)", ["resolution", "inf", "0.0001 to 100"]),
    ("Spacing(0.1)", "Particles(0)", ["resolution", "0", "1 to 67108864"]),
    ("Spacing(0.1)", "Particles(67108865)", ["resolution", "67108865", "1 to 67108864"]),
    ("gravity: (0, -9.81, 0)", "gravity: (0, -10001, 0)", ["gravity", "-10001", "-10000 to 10000"]),
    ("gravity: (0, -9.81, 0)", "gravity: (0, 0, NaN)", ["gravity", "NaN", "-10000 to 10000"]),
    ("rest_density: 1025", "rest_density: -1000", ["material.rest_density", "-1000", "0.001 to 50000"]),
    ("rest_density: 1025", "rest_density: 0", ["material.rest_density", "0", "0.001 to 50000"]),
    ("rest_density: 1025", "rest_density: inf", ["material.rest_density", "inf", "0.001 to 50000"]),
    ("dynamic_viscosity: 1e-3", "dynamic_viscosity: -1", ["material.dynamic_viscosity", "-1", "0 to 1000000"]),
    (r##"r#"salt " water: ("#"##, "\"\"", ["material.name", "empty", "a name"]),
    (
        "(0.5, 0.5, 0.5)), center",
        "(0.5, 0, 0.5)), center",
        ["volumes[0].shape.half_extents", "0", "0.00001 to 1000000"],
    ),
    ("center: (0.5, 0.5, 0.5)", "center: (0.5, NaN, 0.5)", ["volumes[0].center", "NaN", "1000000 m of the origin"]),
    ("center: (2.5, 0.5, 0.5)", "center: (2e6, 0, 0)", ["volumes[1].center", "2000000", "1000000 m of the origin"]),
    ("radius: 0.2,", "radius: -0.2,", ["volumes[1].shape.radius", "-0.2", "0.00001 to 1000000"]),
    ("velocity: (0, 0.25, 0)", "velocity: (0, inf, 0)", ["volumes[1].velocity", "inf", "-10000 to 10000"]),
    ("velocity: (0, 0.25, 0)", "rotation: (0, 0, 0, 2)", ["volumes[1].rotation", "2", "unit quaternion"]),
    ("direction: (0, -1, 0)", "direction: (0, 0, 0)", ["emitters[0].direction", "[0, 0, 0]", "1e-6 to 1e6 long"]),
    ("direction: (0, -1, 0)", "direction: (0, NaN, 0)", ["emitters[0].direction", "NaN", "1e-6 to 1e6 long"]),
    ("direction: (0, -1, 0)", "direction: (0, 1e30, 0)", ["emitters[0].direction", "100000", "1e-6 to 1e6 long"]),
    ("center: (3, 2, 0.5)", "center: (3, 1e7, 0.5)", ["emitters[0].center", "10000000", "1000000 m of the origin"]),
    ("radius: 0.15", "radius: 0", ["emitters[0].radius", "0", "0.00001 to 10000"]),
    ("speed: 1.5", "speed: 0", ["emitters[0].speed", "0", "0.001 to 1000"]),
    ("lifetime: 2", "lifetime: 0", ["emitters[0].lifetime", "0", "more than 0 s"]),
    ("lifetime: 2", "lifetime: NaN", ["emitters[0].lifetime", "NaN", "more than 0 s"]),
    (
        "open: (false, false, false, true, false, false)",
        "open: (true, true, true, true, true, true)",
        ["boundaries[0].shape.open", "true", "at least one false"],
    ),
    ("(4.5, 3.5)", "(4.5, -3.5)", ["boundaries[1].shape.half_extents", "-3.5", "0.00001 to 1000000"]),
    ("(-0.125, 0, 0)", "(NaN, 0, 0)", ["bodies[0].samples[1]", "NaN", "1000000 m of the origin"]),
    ("support: Ratio(2)", "support: Ratio(1)", ["settings.support", "1", "1.5 to 4"]),
    ("support: Ratio(2)", "support: Neighbours(1000)", ["settings.support", "1000", "14 to 270"]),
    ("sound_speed: Some(90)", "sound_speed: Some(-90)", ["settings.sound_speed", "-90", "0.001 to 10000"]),
    ("support: Ratio(2)", "expected_speed: 0", ["settings.expected_speed", "0", "0.0001 to 10000"]),
    ("artificial_viscosity: 0.07", "artificial_viscosity: 1.5", ["settings.artificial_viscosity", "1.5", "0 to 1"]),
    ("near_pressure: 0.01", "near_pressure: 0.2", ["settings.near_pressure", "0.2", "0 to 0.1"]),
    ("sliding: 0.625", "sliding: -0.5", ["boundaries[1].friction.sliding", "-0.5", "0 to 10"]),
    ("at_rest: 0.75", "at_rest: 0.5", ["boundaries[1].friction.at_rest", "0.5", "0.625 to 10"]),
    ("xsph: 0.25", "relaxation: (calm: 2)", ["settings.relaxation.calm", "2", "0.000001 to 1"]),
    ("xsph: 0.25", "relaxation: (max_substeps: 0)", ["settings.relaxation.max_substeps", "0", "1 to 1000000"]),
    ("xsph: 0.25", "xsph: 1.5", ["settings.xsph", "1.5", "0 to 1"]),
    ("xsph: 0.25", "integrator: ForwardEuler", ["settings.integrator", "forward Euler", "leapfrog, Clavet"]),
    ("xsph: 0.25", "integrator: PositionCorrectedBeeman", ["settings.integrator", "position-corrected", "grows"]),
    ("widest_support: 1.25", "widest_support: 0.5", ["settings.widest_support", "0.5", "1 to 3"]),
    ("widest_support: 1.25", "widest_support: NaN", ["settings.widest_support", "NaN", "1 to 3"]),
    ("courant_factor: 0.41", "courant_factor: 0", ["settings.courant_factor", "0", "0.01 to 1"]),
    ("force_factor: 0.26", "force_factor: 2", ["settings.force_factor", "2", "0.01 to 1"]),
    ("viscous_factor: 0.13", "viscous_factor: NaN", ["settings.viscous_factor", "NaN", "0.01 to 1"]),
    ("max_substeps: 2000", "max_substeps: 0", ["settings.max_substeps", "0", "1 to 100000"]),
    ("budget_milliseconds: 12.5", "budget_milliseconds: -1", ["settings.budget_milliseconds", "-1", "0.01 to 1000000"]),
    ("max_particles: 20000", "max_particles: 0", ["settings.max_particles", "0", "1 to 67108864"]),
    ("((-40, -41, -42), (40, 41, 42))", "((0, 0, 0), (1, 0, 1))", ["settings.bounds", "[1, 0, 1]", "below the second"]),
    (
        "sound_speed: Some(90)",
        "sound_speed: 90, equation_of_state: Linear(sound_speed: 90)",
        ["settings.sound_speed", "90", "equation_of_state has its own"],
    ),
    (
        "sound_speed: Some(90)",
        "equation_of_state: Some(Tait(exponent: 0.5, sound_speed: 90))",
        ["settings.equation_of_state.exponent", "0.5", "1 to 20"],
    ),
];

#[test]
fn an_invalid_value_is_reported_with_line_field_value_and_range() {
    for (from, to, [field, value, allowed]) in INVALID {
        let (text, line) = changed(from, to);
        let error = FluidScene::from_ron(&text).expect_err(to);
        assert!(matches!(error, SceneError::InFile { .. }), "{error:?}");
        let start = format!("line {line}: {field}");
        assert!(error.to_string().starts_with(&start), "{start} expected, not {error}");
        assert_says(&error, &[value, allowed]);
    }
}

/// As [`INVALID`], for what only the plan can see; after the change, the text on whose line the error must be.
const UNPLANNABLE: [(&str, &str, &str, [&str; 3]); 14] = [
    // A spacing larger than the volume.
    ("radius: 0.2,", "radius: 0.02,", "radius: 0.02", ["volumes[1].shape.radius", "0.02", "at least 0.05 m"]),
    (
        "(0.5, 0.5, 0.5)), center",
        "(0.5, 0.02, 0.5)), center",
        "(0.5, 0.02",
        ["volumes[0].shape.half_extents.y", "0.02", "at least 0.025 m at this spacing"],
    ),
    ("Spacing(0.1)", "Spacing(1)", "radius: 0.2,", ["volumes[1].shape.radius", "0.2", "at least 0.5 m"]),
    (
        "center: (2.5, 0.5, 0.5)",
        "center: (1.1, 0.5, 0.5)",
        "(\n            shape: Sphere",
        ["volumes[0] and volumes[1]", "near [", "allowed: shapes that share no space"],
    ),
    // A column 1.1 m deep: 20 sqrt(9.81 1.1) = 65.7; the emitter falls farther: 10 sqrt(1.5^2 + 2 9.81 3.05) = 78.8.
    (
        "sound_speed: Some(90)",
        "sound_speed: 20",
        "sound_speed: 20",
        ["settings.sound_speed", "20 m/s", "at least 78.17"],
    ),
    (
        "sound_speed: Some(90)",
        "equation_of_state: IdealGas(stiffness: 3)",
        "IdealGas",
        ["settings.equation_of_state", "1.73", "at least 78.17"],
    ),
    // Refused before anything is allocated: 8e18 and 3e8 particles, 4e13 samples.
    (
        "(0.5, 0.5, 0.5)), center",
        "(1e6, 1e3, 1e6)), center",
        "Spacing(",
        ["resolution", "spacing 0.1 m", "up to 67108864 particles in all; this one makes 8.000e18"],
    ),
    ("Spacing(0.1)", "Spacing(1.5e-3)", "Spacing(", ["resolution", "spacing 0.0015 m", "up to 67108864"]),
    (
        "(4.5, 3.5)",
        "(1e5, 1e6)",
        "Spacing(",
        ["resolution", "spacing 0.1 m", "up to 67108864 wall samples in all; this one makes 4.000e13"],
    ),
    (
        "radius: 0.15",
        "radius: 1e4",
        "speed: 1.5",
        ["emitters[0].speed", "1.5", "up to 67108864 particles a second; this one sends 4.712e11"],
    ),
    (
        "max_particles: 20000",
        "max_particles: 999",
        "max_particles: 999",
        ["settings.max_particles", "999", "the particles of the start"],
    ),
    ("center: (2.5, 0.5, 0.5)", "center: (2.5, 9e5, 0.5)", "Spacing(", ["resolution", "spacing 0.1 m", "at least 6.8"]),
    (
        "sound_speed: Some(90)",
        "expected_speed: 5000",
        "settings: (\n        supp",
        ["settings.sound_speed", "50000", "up to 10000"],
    ),
    ("support: Ratio(2)", "kernel: Viscosity", "kernel: V", ["settings.kernel", "viscosity", "wendland"]),
];

#[test]
fn an_error_of_the_plan_has_its_line_too() {
    for (from, to, anchor, [field, value, allowed]) in UNPLANNABLE {
        let (text, _) = changed(from, to);
        assert!(FluidScene::from_ron(&text).is_ok(), "{to}");
        let error = plan_from_ron(&text).expect_err(to);
        assert!(matches!(error, SceneError::InFile { .. }), "{error:?}");
        let line = 1 + text[..text.rfind(anchor).expect(anchor)].matches('\n').count();
        let start = format!("line {line}: {field}");
        assert!(error.to_string().starts_with(&start), "{start} expected, not {error}");
        assert_says(&error, &[value, allowed]);
    }
}

#[test]
fn a_field_left_out_is_reported_at_what_encloses_it() {
    // The emitter flows for ever, so settings.max_particles is missing.
    let text =
        "(\n resolution: Spacing(0.1),\n emitters: [(center: (0, 0, 0), direction: (0, 1, 0), radius: 1, speed: 1)],\n";
    let with_settings = format!("{text}\n\n settings: (\n ),\n)");
    let (without, with) = (plan_from_ron(&format!("{text})")).unwrap_err(), plan_from_ron(&with_settings).unwrap_err());
    assert_says(&without, &["line 1: settings.max_particles", "none", "emitters[0] flows for ever"]);
    assert_says(&with, &["line 6: settings.max_particles"]);
}

#[test]
fn compressible_flow_by_request_is_noted_in_the_plan() {
    let (text, _) = changed("sound_speed: Some(90)", "sound_speed: 20, allow_compressible: true");
    let (_, plan) = plan_from_ron(&text).unwrap();
    assert!(plan.notes.iter().any(|note| note.contains("compressible by request") && note.contains("20 m/s")));
    assert!(!plan_from_ron(TANK).unwrap().1.notes.iter().any(|note| note.contains("compressible")));
}

#[test]
fn text_that_is_no_scene_is_reported_with_line_and_path() {
    let cases = [
        ("radius: 0.2,", "radius: 0.2, colour: 7,", ["volumes[1].shape.colour", "expected `radius`"]),
        ("    settings: (", "    setings: (", ["setings", "`settings`"]),
        ("artificial_viscosity", "artifical_viscosity", ["settings.artifical_viscosity", "`artificial_viscosity`"]),
        ("radius: 0.2,", "radius: \"large\",", ["volumes[1].shape.radius: Expected float", "found `\"large\"`"]),
        ("name: \"a \\\"tank\\\": volumes: [(center\",", "name: 5,", ["name: Expected string", "found `5`"]),
        ("max_substeps: 2000", "max_substeps: -2000", ["settings.max_substeps", "0 to 4294967295, found `-2000`"]),
        ("max_particles: 20000", "max_particles: 9999999999", ["settings.max_particles", "0 to 4294967295"]),
        ("max_substeps: 2000", "max_substeps: 2.5", ["settings.max_substeps", "found `2.5`"]),
        ("shape: Sphere(\n", "shape: Cylinder(\n", ["volumes[1].shape", "either `Box` or `Sphere`"]),
        ("Spacing(0.1)", "0.1", ["resolution: Expected a name", "found `0.1`"]),
        ("Spacing(0.1)", "Spacing(0.1)]", ["Expected comma", "found `]`"]),
        ("(4.5, 3.5)", "(4.5)", ["boundaries[1].shape.half_extents", "2"]),
        ("center: (3, 2, 0.5)", "center: (3, 2)", ["emitters[0].center", "found 2 elements"]),
        ("radius: 0.15", "radius: 0.15, radius: 0.2", ["emitters[0].radius", "duplicate"]),
        ("force_factor: 0.26", "force_factor: 0.2 6", ["settings.force_factor", "Expected comma, found `6`"]),
    ];
    for (from, to, parts) in cases {
        let (text, line) = changed(from, to);
        let error = FluidScene::from_ron(&text).expect_err(to);
        assert!(
            matches!(&error, SceneError::Parse { line: found, column, .. } if *found == line && *column > 1),
            "{error}"
        );
        assert_says(&error, &parts);
    }
    let missing = FluidScene::from_ron("(\n  resolution: Spacing(1),\n  volumes: [\n    (center: (0, 0, 0)),\n  ],\n)");
    assert_says(&missing.unwrap_err(), &["line 4", "volumes[0]", "`shape`"]);
}

#[test]
fn a_truncated_file_is_reported_at_its_end() {
    let end = TANK.rfind(')').unwrap();
    for length in 0..=end {
        let error = FluidScene::from_ron(&TANK[..length]).expect_err("truncated");
        assert!(matches!(error, SceneError::Parse { .. }), "{length}: {error}");
    }
    for empty in ["", " ", "\n"] {
        assert_says(
            &FluidScene::from_ron(empty).unwrap_err(),
            &["line 1, column 1", "`FluidScene`", "end of the file"],
        );
    }
    assert_says(&FluidScene::from_ron("// nothing\n").unwrap_err(), &["`FluidScene`", "end of the file"]);
}

#[test]
fn bytes_that_are_no_text_are_reported_with_their_line() {
    let error = FluidScene::from_ron_bytes(b"(\n  name: \"\xc3\xa4 \xff\",\n)").unwrap_err();
    assert_says(&error, &["line 2, column 12", "0xff", "UTF-8"]);
}

#[test]
fn a_file_too_large_is_refused_unread() {
    let brackets = vec![b'['; 100 << 20];
    let error = FluidScene::from_ron_bytes(&brackets).unwrap_err();
    assert_eq!(error, SceneError::TooLarge { bytes: 100 << 20, allowed: MAX_SCENE_BYTES as u64 });
    assert_says(&error, &["104857600", "16777216"]);
    // One byte less is read.
    let spaces = " ".repeat(MAX_SCENE_BYTES - 27);
    assert!(FluidScene::from_ron(&format!("(resolution: Spacing(0.1)){spaces} ")).is_ok());
    assert!(matches!(
        FluidScene::from_ron(&format!("(resolution: Spacing(0.1)){spaces}  ")),
        Err(SceneError::TooLarge { .. })
    ));
}

#[test]
fn nested_brackets_exhaust_neither_stack_nor_patience() {
    let check = || {
        for unit in
            ["(", "[", "{", "Some(", "(a:", "[(", "/*", "\"", "r#", "Spacing(", "#![enable(", "[],", "a", "-", "9"]
        {
            let bomb = unit.repeat((1 << 20) / unit.len());
            for text in [
                bomb.clone(),
                format!("(resolution: {bomb}"),
                format!("(resolution: Spacing({bomb}"),
                format!("(resolution: Spacing(1), volumes: {bomb}"),
                format!("(resolution: Spacing(1), volumes: [{bomb}"),
                format!("(resolution: Spacing(1), gravity: {bomb}"),
                format!("(resolution: Spacing(1), settings: (bounds: {bomb}"),
                format!("(resolution: Spacing(1), unknown: {bomb}"),
                format!("(resolution: Spacing(1)) {bomb}"),
            ] {
                match FluidScene::from_ron(&text) {
                    Err(SceneError::Parse { message, .. }) => assert!(message.len() < 2000),
                    other => panic!("{unit}: {other:?}"),
                }
            }
        }
    };
    std::thread::Builder::new().stack_size(512 << 10).spawn(check).unwrap().join().unwrap();
}

#[test]
fn a_long_file_is_searched_once_for_its_error() {
    // As many volumes as there may be, of five lines each.
    let file = |count: usize| {
        let mut text = "(resolution: Spacing(1), volumes: [\n".to_owned();
        for index in 0..count {
            let radius = if index == 9_999 { -1.0 } else { 1.0 };
            writeln!(text, "(\nshape: Sphere(\nradius: {radius}),\ncenter: ({}, 0, 0)\n),", 3 * index).unwrap();
        }
        text + "])"
    };
    let error = FluidScene::from_ron(&file(10_000)).unwrap_err();
    assert_says(&error, &["line 49999: volumes[9999].shape.radius: -1"]);
    // One more is too many, whatever is in them.
    let error = FluidScene::from_ron(&file(10_001)).unwrap_err();
    assert_says(&error, &["line 1: volumes: 10001 of them is not allowed; allowed: up to 10000"]);
}

proptest! {
    #![proptest_config(ProptestConfig { failure_persistence: None, ..ProptestConfig::with_cases(400) })]

    #[test]
    fn any_bytes_give_a_scene_or_an_error(bytes in proptest::collection::vec(any::<u8>(), 0..300)) {
        let _ = FluidScene::from_ron_bytes(&bytes);
        let mut text = b"(resolution: Spacing(0.1), ".to_vec();
        text.extend(bytes);
        let _ = FluidScene::from_ron_bytes(&text);
    }

    #[test]
    fn a_damaged_file_gives_a_scene_or_an_error_on_a_line_of_it(
        edits in proptest::collection::vec((any::<proptest::sample::Index>(), 0..5, any::<u8>(), 0..TOKENS.len()), 1..6),
    ) {
        let mut bytes = TANK.as_bytes().to_vec();
        for (at, kind, byte, token) in edits {
            let at = at.index(bytes.len());
            match kind {
                0 => bytes[at] = byte,
                1 => drop(bytes.remove(at)),
                2 => bytes.insert(at, byte),
                3 => drop(bytes.splice(at..at, TOKENS[token].bytes())),
                _ => {
                    let piece = bytes[at..(at + 60).min(bytes.len())].to_vec();
                    bytes.splice(at..at, piece);
                }
            }
        }
        match FluidScene::from_ron_bytes(&bytes) {
            Ok(scene) => prop_assert!(scene.validate().is_ok()),
            Err(SceneError::Parse { line, .. } | SceneError::InFile { line, .. }) => {
                let lines = 1 + bytes.iter().filter(|&&byte| byte == b'\n').count();
                prop_assert!((1..=lines).contains(&line));
            }
            Err(error) => prop_assert!(false, "{error}"),
        }
    }

    #[test]
    fn numbers_are_written_so_that_they_are_read_exactly(x in -1e6f32..1e6, y in any::<f32>(), density in 1e-3f32..5e4) {
        let mut scene = FluidScene::with_spacing(0.1);
        scene.material.rest_density = density;
        scene.volumes.push(Volume::block(Vec3::splat(0.5), Vec3::new(x, y.clamp(-1e6, 1e6), -x)));
        if scene.validate().is_ok() {
            prop_assert_eq!(FluidScene::from_ron(&scene.to_ron().unwrap()).unwrap(), scene);
        }
    }
}

const TOKENS: [&str; 14] =
    ["(", ")", "[", "]", ",", ":", "\"", "/*", "Some(", "NaN", "-", "1e39", "r#\"", "settings: (support: Ratio(-1)),"];
