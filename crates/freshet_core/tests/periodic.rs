//! Domains that repeat themselves, viscosity models and walls that move: what is planned and what is refused.

use freshet_core::grid::Grid;
use freshet_core::prelude::*;

/// A channel along x between two plates, a slab of 0.8 m along z.
fn channel() -> FluidScene {
    let (size, center) = (Vec3::new(1.0, 0.5, 0.8), Vec3::new(0.5, 0.25, 0.4));
    let shape = BoundaryShape::Container { half_extents: size / 2.0, open: [true, true, false, false, true, true] };
    let mut scene = FluidScene {
        gravity: Vec3::X * 0.1,
        volumes: vec![Volume::block(size / 2.0, center)],
        boundaries: vec![Boundary::new(shape, center)],
        periodic: Periodic { x: Some((0.0, 1.0)), y: None, z: Some((0.0, 0.8)) },
        ..FluidScene::with_spacing(0.1)
    };
    scene.settings.expected_speed = Some(1.0);
    scene.settings.viscosity_model = Some(ViscosityModel::Morris1997);
    scene.material.dynamic_viscosity = 2.0;
    scene
}

fn refused(change: impl FnOnce(&mut FluidScene)) -> String {
    let mut scene = channel();
    change(&mut scene);
    Plan::new(&scene).unwrap_err().to_string()
}

#[test]
fn cells_divide_the_periods() {
    let plan = Plan::new(&channel()).unwrap();
    assert_eq!(plan.grid.periodic, channel().periodic);
    let (cells, edges) = (plan.grid.dimensions(), plan.grid.cell_edges());
    assert_eq!((cells.x, cells.z), (4, 4), "a metre has room for five cells of 0.2 m, which is no power of two");
    assert!(edges.distance(Vec3::new(0.25, 0.2, 0.2)) < 1e-6, "{edges}");
    // What rounds to the upper end stays in the last cell.
    assert_eq!(plan.grid.coordinates(Vec3::new(1.0, 0.0, 0.8)).x, 3);
    assert_eq!(plan.grid.coordinates(Vec3::new(0.0, 0.0, -1e-9)).z, 0);
    assert_eq!(Grid::fitting(0.2, Vec3::ONE, 4096).cell_edges(), Vec3::splat(0.2));
}

#[test]
fn every_sample_of_a_wall_without_an_end_weighs_the_same() {
    let plan = Plan::new(&channel()).unwrap();
    let first = plan.boundary.volumes[0];
    assert!(plan.boundary.volumes.iter().all(|volume| (volume / first - 1.0).abs() < 1e-4));
    let open = Plan::new(&FluidScene { gravity: Vec3::ZERO, periodic: Periodic::default(), ..channel() }).unwrap();
    assert!(
        open.boundary.volumes.iter().any(|volume| volume / first > 1.2),
        "the ends of a plate have fewer neighbours"
    );
}

#[test]
fn a_force_along_a_period_presses_nothing_together() {
    let plan = Plan::new(&channel()).unwrap();
    let lattice = Plan::new(&FluidScene { gravity: Vec3::ZERO, ..channel() }).unwrap();
    assert_eq!(plan.positions, lattice.positions);
    assert!(plan.to_string().contains("repeats itself along x, from 0 to 1 m"), "{plan}");
    assert!(!lattice.to_string().contains("along y"));
}

#[test]
fn viscosity_is_planned_only_with_a_model_and_a_number() {
    let plan = Plan::new(&channel()).unwrap();
    assert_eq!(plan.parameters.dynamic_viscosity, 2.0);
    // nu = 2e-3 m2/s and h = 0.1 m, beside the artificial one of alpha c h / 10 = 3e-3 m2/s.
    assert!((plan.parameters.viscous_limit() - 0.125 * 0.01 / 5e-3).abs() < 1e-4);
    let mut scene = channel();
    scene.settings.viscosity_model = None;
    assert_eq!(Plan::new(&scene).unwrap().parameters.dynamic_viscosity, 0.0);
    scene = channel();
    scene.material.dynamic_viscosity = 0.0;
    let plan = Plan::new(&scene).unwrap();
    assert!(!plan.to_string().contains("dynamic viscosity") && !plan.stages[2].reason.contains("material"));
}

#[test]
fn moving_walls_have_velocities_and_others_take_no_memory() {
    assert!(Plan::new(&channel()).unwrap().boundary.velocities.is_empty());
    let mut scene = channel();
    scene.boundaries[0].velocity = Vec3::new(0.5, 0.0, -0.5);
    let plan = Plan::new(&scene).unwrap();
    assert_eq!(plan.boundary.velocities, vec![Vec3::new(0.5, 0.0, -0.5); plan.boundary.positions.len()]);
}

#[test]
fn periods_have_to_make_sense() {
    let error = refused(|scene| scene.periodic.x = Some((1.0, 0.0)));
    assert_eq!(error, "periodic.x: (1, 0) is not allowed; allowed: the lower end, then the upper");
    assert!(refused(|scene| scene.periodic.y = Some((0.0, f32::NAN))).starts_with("periodic.y: "));
    let error = refused(|scene| {
        scene.volumes[0].shape = Shape::Box { half_extents: Vec3::new(0.5, 0.25, 0.35) };
        scene.boundaries.clear();
        scene.periodic.z = Some((0.0, 0.7));
    });
    assert!(error.starts_with("periodic.z: a period of 0.7 m") && error.contains("at least 0.8 m"), "{error}");
    let error = refused(|scene| scene.periodic.x = Some((0.0, 0.9)));
    assert!(error.starts_with("periodic.x: (0, 0.9)") && error.contains("all volumes"), "{error}");
    let error = refused(|scene| scene.settings.bounds = Some((Vec3::splat(0.01), Vec3::splat(2.0))));
    assert!(error.starts_with("settings.bounds: "), "{error}");
    let error = refused(|scene| scene.settings.expected_speed = None);
    assert!(error.starts_with("settings.expected_speed: none") && error.contains("gravity drives"), "{error}");
    let wide = vec![Vec3::X * 0.6, Vec3::NEG_X * 0.6];
    let error = refused(|scene| scene.bodies.push(Body { name: "plank".to_owned(), samples: wide, ..Body::default() }));
    assert!(error.starts_with("bodies[0].samples: up to 0.6 m"), "{error}");
}

#[test]
fn a_wall_across_a_period_is_refused() {
    let closed = Boundary::closed_box(Vec3::new(1.0, 0.5, 0.8), Vec3::new(0.5, 0.25, 0.4));
    let error = refused(|scene| scene.boundaries = vec![closed]);
    assert!(error.starts_with("periodic.x: (0, 1)") && error.contains("boundaries[0] has samples at x = "), "{error}");
    // A pillar in the middle of the channel is no wall across.
    let mut scene = channel();
    let pillar = BoundaryShape::Box { half_extents: Vec3::new(0.2, 0.2, 0.2) };
    scene.boundaries.push(Boundary::new(pillar, Vec3::new(0.5, -1.0, 0.4)));
    Plan::new(&scene).unwrap();
}

#[test]
fn walls_move_along_themselves_and_only_where_something_feels_it() {
    let across = Vec3::Y * 0.1;
    let error = refused(|scene| scene.boundaries[0].velocity = across);
    assert!(error.starts_with("boundaries[0].velocity: ") && error.contains("along every viscous face"), "{error}");
    assert!(refused(|scene| scene.boundaries[0].velocity = Vec3::X * 1e5).contains("-10000 to 10000 m/s"));
    let error = refused(|scene| {
        scene.settings.viscosity_model = None;
        scene.boundaries[0].velocity = Vec3::X;
    });
    assert!(error.contains("no settings.viscosity_model"), "{error}");
}

#[test]
fn a_file_can_say_all_of_it_and_errors_name_the_line() {
    let text = channel().to_ron().unwrap();
    assert_eq!(FluidScene::from_ron(&text).unwrap(), channel());
    let scene = FluidScene::from_ron(
        "(
            resolution: Spacing(0.1),
            periodic: (x: (0, 1)),
            boundaries: [(shape: Plane(half_extents: (0.4, 0.4)), center: (0.5, 0, 0), velocity: (1, 0, 0))],
            settings: (viscosity_model: Morris1997),
        )",
    )
    .unwrap();
    assert_eq!(scene.periodic, Periodic { x: Some((0.0, 1.0)), ..Periodic::default() });
    assert_eq!(scene.boundaries[0].velocity, Vec3::X);
    let wrong = "(\n resolution: Spacing(0.1),\n periodic: (\n  y: (2, 1),\n ),\n)";
    assert!(FluidScene::from_ron(wrong).unwrap_err().to_string().starts_with("line 4: periodic.y: (2, 1)"));
}
