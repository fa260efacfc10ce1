//! Plans: what is executed and why, the numbers, and what is refused.

use freshet_core::field::FieldOrigin;
use freshet_core::grid::Grid;
use freshet_core::plan::{Parameters, Plan, StageKind};
use freshet_core::prelude::*;
use freshet_core::scene::{MAX_OBJECTS, MAX_PARTICLES};
use glam::IVec3;

/// A column of a cubic metre in a tank of 4 x 2 x 1 m.
fn dam_break() -> FluidScene {
    FluidScene {
        name: "dam break".to_owned(),
        volumes: vec![Volume::block(Vec3::splat(0.5), Vec3::splat(0.5))],
        boundaries: vec![Boundary::open_box(Vec3::new(4.0, 2.0, 1.0), Vec3::new(2.0, 1.0, 0.5))],
        ..FluidScene::with_spacing(0.1)
    }
}

fn cork() -> Body {
    Body { name: "cork".to_owned(), samples: vec![Vec3::X * 0.1, Vec3::NEG_X * 0.1], ..Body::default() }
}

fn kinds(plan: &Plan) -> Vec<StageKind> {
    plan.stages.iter().map(|stage| stage.kind).collect()
}

fn reason(plan: &Plan, kind: StageKind) -> &str {
    &plan.stages.iter().find(|stage| stage.kind == kind).unwrap().reason
}

fn refused(scene: &FluidScene) -> String {
    Plan::new(scene).unwrap_err().to_string()
}

fn near(a: f32, b: f64) -> bool {
    (f64::from(a) / b - 1.0).abs() < 1e-5
}

#[test]
fn without_bodies_there_is_no_stage_for_them() {
    use StageKind::{Acceleration, BodyLoad, BodyMotion, BodySort, Density, Integrate, Sort, StepControl};
    let plan = Plan::new(&dam_break()).unwrap();
    assert_eq!(kinds(&plan), [Sort, Density, Acceleration, StepControl, Integrate]);
    assert!(!plan.has(BodyLoad) && plan.body_samples() == 0);
    let with = Plan::new(&FluidScene { bodies: vec![cork(), cork()], ..dam_break() }).unwrap();
    let all = [Sort, BodySort, Density, Acceleration, BodyLoad, StepControl, BodyMotion, Integrate];
    assert_eq!(kinds(&with), all);
    assert_eq!(with.body_samples(), 4);
    assert!(with.bodies.iter().all(|body| body.volumes.len() == 2 && body.volumes.iter().all(|&volume| volume > 0.0)));
}

#[test]
fn xsph_is_a_stage_of_plans_that_ask_for_it_and_knows_both_solvers() {
    use StageKind::{Acceleration, Density, DensitySolve, DivergenceSolve, Integrate, Sort, StepControl, Xsph};
    let with = |mut scene: FluidScene| {
        scene.settings.xsph = 0.5;
        Plan::new(&scene).unwrap()
    };
    let plan = with(dam_break());
    assert_eq!(kinds(&plan), [Sort, Density, Acceleration, StepControl, Xsph, Integrate]);
    assert!(reason(&plan, Xsph).contains("settings.xsph is 0.5") && plan.to_string().contains("XSPH with epsilon 0.5"));
    let plan = with(incompressible(DivergenceFree::default()));
    let all = [Sort, Density, Acceleration, StepControl, DivergenceSolve, Xsph, DensitySolve, Integrate];
    assert_eq!(kinds(&plan), all);
}

#[test]
fn the_plan_says_by_which_integrator_particles_move_and_refuses_those_under_which_oscillations_grow() {
    for integrator in Integrator::ALL {
        let mut scene = dam_break();
        scene.settings.integrator = integrator;
        if integrator.in_solvers().is_some() {
            let plan = Plan::new(&scene).unwrap();
            assert_eq!(plan.parameters.integrator, integrator);
            assert!(reason(&plan, StageKind::Integrate).starts_with(&format!("{}: ", integrator.name())), "{plan}");
        } else {
            let message = refused(&scene);
            let words =
                ["settings.integrator", integrator.name(), "semi-implicit Euler, Verlet", "every oscillation grows"];
            assert!(words.iter().all(|word| message.contains(word)), "{message}");
        }
    }
    assert_eq!(Integrator::ALL.into_iter().filter(|integrator| integrator.in_solvers().is_none()).count(), 2);
    let mut scene = dam_break();
    let limit = |scene: &FluidScene| Plan::new(scene).unwrap().parameters.viscous_limit();
    let by_default = limit(&scene);
    scene.settings.integrator = Integrator::VelocityCorrectedBeeman;
    assert!((limit(&scene) / by_default - 0.3).abs() < 1e-6, "as much shorter as it bears less of a drag");
    scene.boundaries[0].friction = Friction::coulomb(0.5);
    let message = refused(&scene);
    let words = ["settings.integrator", "velocity-corrected Beeman", "another one, as boundaries[0] has friction"];
    assert!(words.iter().all(|word| message.contains(word)), "{message}");
    scene.settings.integrator = Integrator::Beeman;
    assert!(Plan::new(&scene).is_ok());
}

#[test]
fn the_plan_says_which_form_the_pressure_force_has_and_refuses_what_does_not_go_together() {
    let mut scene = dam_break();
    assert!(reason(&Plan::new(&scene).unwrap(), StageKind::Acceleration).starts_with("pressure, "));
    scene.settings.pressure_force = PressureForce::Mueller;
    let plan = Plan::new(&scene).unwrap();
    assert!(reason(&plan, StageKind::Acceleration).starts_with("pressure by Mueller's form, "), "{plan}");
    scene.settings.widest_support = 1.5;
    let message = refused(&scene);
    let words = ["settings.pressure_force", "Mueller", "Monaghan, with a settings.widest_support above 1"];
    assert!(words.iter().all(|word| message.contains(word)), "{message}");
}

#[test]
fn supports_that_grow_are_a_stage_and_make_cells_longer() {
    use StageKind::{Acceleration, Density, Integrate, Sort, StepControl, Support};
    let plain = Plan::new(&dam_break()).unwrap();
    assert_eq!((plain.parameters.widest_support, plain.grid.cell_size), (1.0, plain.parameters.support_radius));
    let mut scene = dam_break();
    scene.settings.widest_support = 1.5;
    let plan = Plan::new(&scene).unwrap();
    assert_eq!(kinds(&plan), [Sort, Support, Density, Acceleration, StepControl, Integrate]);
    let radius = plan.parameters.support_radius;
    assert_eq!((plan.grid.cell_size, plan.grid.support_radius), (1.5 * radius, radius));
    assert_eq!(radius, plain.parameters.support_radius);
    assert!(reason(&plan, Support).contains("settings.widest_support is 1.5"));
    assert!(plan.to_string().contains("supports of particles up to 1.5 times as wide"));
    // Four cells of the widest support divide a period.
    scene.periodic.z = Some((-3.0 * radius, 3.0 * radius));
    let ends = |scene: &FluidScene| Plan::new(scene).map(|_| ()).map_err(|error| error.to_string());
    scene.boundaries.clear();
    scene.volumes[0] = Volume::block(Vec3::splat(2.0 * radius), Vec3::ZERO);
    scene.settings.expected_speed = Some(1.0);
    assert_eq!(ends(&scene), Ok(()));
    scene.settings.widest_support = 1.6;
    let refused = ends(&scene).unwrap_err();
    assert!(refused.contains("periodic.z") && refused.contains(&format!("{} m", 4.0 * 1.6 * radius)), "{refused}");
}

#[test]
fn friction_is_a_stage_of_plans_with_walls_that_have_it() {
    let mut scene = dam_break();
    assert!(Plan::new(&scene).unwrap().boundary.frictions.is_empty());
    scene.boundaries.push(Boundary::new(BoundaryShape::Box { half_extents: Vec3::splat(0.2) }, Vec3::Y * 10.0));
    scene.boundaries[0].friction = Friction { at_rest: 0.5, sliding: 0.25 };
    let plan = Plan::new(&scene).unwrap();
    assert!(plan.has(StageKind::Friction) && reason(&plan, StageKind::Friction).contains("friction"));
    let walls = &plan.boundary;
    let rough = walls.frictions.iter().take_while(|&&friction| friction == [0.5, 0.25]).count();
    assert!(rough > 0 && rough < walls.positions.len() && walls.frictions.len() == walls.positions.len());
    assert!(walls.frictions[rough..].iter().all(|&friction| friction == [0.0, 0.0]));
    scene.boundaries[1].friction = Friction::coulomb(0.1);
    scene.boundaries[1].velocity = Vec3::X;
    let message = Plan::new(&scene).unwrap_err().to_string();
    assert!(message.contains("boundaries[1].velocity") && message.contains("along every viscous face"), "{message}");
    // A belt of its upper face; the others stand.
    scene.boundaries[1].viscous_faces = [false, false, false, true, false, false];
    let walls = Plan::new(&scene).unwrap().boundary;
    let top = |k: &usize| *k >= rough && walls.positions[*k].y > 10.0 + 0.1;
    let moving: Vec<usize> = (0..walls.positions.len()).filter(|&k| walls.velocities[k] == Vec3::X).collect();
    assert!(!moving.is_empty() && moving.iter().all(top));
    assert!((rough..walls.positions.len()).any(|k| walls.velocities[k] == Vec3::ZERO));
    // Without a viscous face nothing of it would move.
    scene.boundaries[1].viscous_faces = [false; 6];
    let message = Plan::new(&scene).unwrap_err().to_string();
    assert!(message.contains("boundaries[1].velocity") && message.contains("no viscous face"), "{message}");
    scene.boundaries[1].viscous_faces[3] = true;
    scene.boundaries[1].friction = Friction::default();
    let message = Plan::new(&scene).unwrap_err().to_string();
    assert!(message.contains("zero, as there is no settings.viscosity_model and no friction"), "{message}");
}

#[test]
fn friction_of_bodies_is_a_stage_of_its_own() {
    let mut scene = FluidScene { bodies: vec![cork()], ..dam_break() };
    assert!(!Plan::new(&scene).unwrap().has(StageKind::BodyFriction));
    scene.bodies[0].friction = Friction { at_rest: 0.5, sliding: 0.25 };
    let plan = Plan::new(&scene).unwrap();
    assert!(plan.has(StageKind::BodyFriction) && !plan.has(StageKind::Friction));
    assert!(reason(&plan, StageKind::BodyFriction).contains("friction"));
    scene.bodies[0].friction.at_rest = 0.2;
    let message = Plan::new(&scene).unwrap_err().to_string();
    assert!(message.contains("bodies[0].friction.at_rest") && message.contains("0.25 to 10"), "{message}");
    scene.bodies[0].friction.at_rest = 0.5;
    scene.settings.integrator = Integrator::VelocityCorrectedBeeman;
    let message = Plan::new(&scene).unwrap_err().to_string();
    assert!(message.contains("another one, as bodies[0] has friction"), "{message}");
}

#[test]
fn walls_that_push_by_themselves_are_a_stage_and_in_no_other_and_refuse_what_does_not_go_together() {
    for method in WallMethod::ALL {
        let mut scene = dam_break();
        scene.settings.wall_method = method;
        let plan = Plan::new(&scene).unwrap();
        let in_sums = method.is_in_sums();
        let is_penalty = matches!(method, WallMethod::Penalty(_));
        let with_images = method == WallMethod::Ghosts;
        let pushes = method.is_force() || with_images;
        assert_eq!((plan.has(StageKind::WallForce), plan.sums_walls()), (pushes, in_sums), "{plan}");
        assert_eq!(plan.has(StageKind::WallCollision), is_penalty || with_images, "{plan}");
        assert_eq!(plan.boundary.faces.is_empty(), !method.needs_faces());
        assert_eq!(plan.parameters.wall_strength > 0.0, method.is_force());
        let without = Plan::new(&FluidScene { boundaries: Vec::new(), ..scene.clone() }).unwrap();
        assert!(!without.has(StageKind::WallForce) && !without.has(StageKind::WallCollision) && !without.sums_walls());
        let in_layers = matches!(method, WallMethod::QuasiFluid(_));
        assert_eq!(plan.has(StageKind::WallDensity), in_layers || with_images, "{plan}");
        assert_eq!(plan.boundary.own_densities.is_empty(), !in_layers);
        if in_sums || with_images {
            continue;
        }
        let stage = if is_penalty { StageKind::WallCollision } else { StageKind::WallForce };
        assert!(reason(&plan, stage).contains(method.name()), "{plan}");
        assert!(reason(&plan, StageKind::Density).ends_with("fluid only") && !plan.boundary.viscous.contains(&true));
        let refused = |change: &dyn Fn(&mut FluidScene), words: [&str; 2]| {
            let mut scene = scene.clone();
            change(&mut scene);
            let message = Plan::new(&scene).unwrap_err().to_string();
            assert!(words.iter().all(|word| message.contains(word)), "{message}");
        };
        let solver = PressureSolver::DivergenceFree(DivergenceFree::default());
        refused(&|scene| scene.settings.pressure_solver = solver, ["settings.wall_method", method.name()]);
        let belt = |scene: &mut FluidScene| {
            scene.boundaries[0].velocity = 1e-9 * Vec3::X;
            scene.boundaries[0].viscous_faces = [false; 6];
            scene.settings.viscosity_model = Some(ViscosityModel::Morris1997);
        };
        refused(&belt, ["boundaries[0].velocity", "zero, with a settings.wall_method of"]);
        let settling = |scene: &mut FluidScene| scene.settings.relaxation = Some(Relaxation::default());
        refused(&settling, ["settings.relaxation: Some", "none, with a settings.wall_method of"]);
        let mut redone = scene.clone();
        redone.settings.redo_substeps = true;
        assert_eq!(Plan::new(&redone).is_ok(), !is_penalty);
        if is_penalty {
            refused(
                &|scene| scene.settings.redo_substeps = true,
                ["settings.redo_substeps: true", "false, with a settings.wall_method of"],
            );
            let other = |scene: &mut FluidScene| scene.settings.integrator = Integrator::Beeman;
            refused(&other, ["settings.integrator", "semi-implicit Euler, with a settings.wall_method of"]);
        }
        if !method.has_friction() {
            let rough = |scene: &mut FluidScene| scene.boundaries[0].friction = Friction::coulomb(0.1);
            refused(&rough, ["boundaries[0].friction.at_rest", "0, with a settings.wall_method of"]);
        }
        if method.needs_faces() {
            let sheet = BoundaryShape::Sphere { radius: 0.5, fluid: FluidSide::Both };
            let boundary = Boundary::new(sheet, Vec3::Y * 10.0);
            refused(
                &|scene| scene.boundaries.push(boundary.clone()),
                ["boundaries[1].shape.fluid", "Inside or Outside"],
            );
        }
    }
    let mut scene = dam_break();
    for (frequency, damping_ratio, field) in [(Some(0.0), 1.0, "frequency"), (None, 2.5, "damping_ratio")] {
        scene.settings.wall_method = WallMethod::SpringDamper(SpringDamper { frequency, damping_ratio });
        let message = refused(&scene);
        assert!(message.contains(&format!("settings.wall_method.{field}")), "{message}");
    }
    for (penalty, field) in [
        (Penalty { bounce: 1.1, ..Penalty::DEFAULT }, "bounce"),
        (Penalty { slip: f32::NAN, ..Penalty::DEFAULT }, "slip"),
        (Penalty { one_way: Some(Vec3::ZERO), ..Penalty::DEFAULT }, "one_way"),
    ] {
        scene.settings.wall_method = WallMethod::Penalty(penalty);
        let message = refused(&scene);
        assert!(message.contains(&format!("settings.wall_method.{field}")), "{message}");
    }
    scene.settings.wall_method = WallMethod::SpringDamper(SpringDamper { frequency: Some(1e4), damping_ratio: 1.0 });
    let limit = Plan::new(&scene).unwrap().parameters.substep_limit(0.0, 0.0);
    assert!(near(limit, 0.5 / 3e4), "{limit}");
}

#[test]
fn quasi_fluid_walls_have_layers_where_there_is_room_and_refuse_what_does_not_go_together() {
    let mut scene = dam_break();
    scene.boundaries.truncate(1);
    let single = Plan::new(&scene).unwrap().boundary.positions.len();
    scene.settings.wall_method = WallMethod::QuasiFluid(QuasiFluid::Adapted);
    let plan = Plan::new(&scene).unwrap();
    let walls = &plan.boundary;
    let count = walls.positions.len();
    assert!(count > 5 * single / 2 && count < 4 * single, "{count} of {single}");
    // What stands for nothing but itself weighs what a particle does, and only what is next to the fluid drags it along.
    let whole = plan.parameters.spacing.powi(3);
    let full = walls.volumes.iter().filter(|&&volume| near(volume, whole.into())).count();
    assert!(full > count / 2 && walls.volumes.iter().all(|&volume| volume > 0.3 * whole && volume < 1.4 * whole));
    assert!(walls.own_densities.iter().all(|&own| own > 0.5 && own < 1.02));
    assert!(walls.viscous.iter().filter(|&&viscous| viscous).count() < count / 2 && walls.viscous.contains(&true));
    assert!(reason(&plan, StageKind::WallDensity).contains("quasi-fluid, adapted"), "{plan}");
    assert!(!Plan::new(&FluidScene { boundaries: Vec::new(), ..scene.clone() }).unwrap().has(StageKind::WallDensity));
    // Twice the walls in the same place are not twice as dense.
    let twice = FluidScene { boundaries: vec![scene.boundaries[0].clone(); 2], ..scene.clone() };
    let own = Plan::new(&twice).unwrap().boundary.own_densities;
    assert!(own.len() == 2 * count && own.iter().all(|&own| own < 1.02));
    // A plate of one spacing has one layer, in its middle.
    let half = 0.5 * plan.parameters.spacing;
    let plate =
        Boundary::new(BoundaryShape::Box { half_extents: Vec3::new(8.0 * half, half, 8.0 * half) }, Vec3::Y * 5.0);
    let of_plate = Plan::new(&FluidScene { boundaries: vec![plate], ..scene.clone() }).unwrap().boundary;
    assert!(of_plate.positions.iter().all(|sample| near(sample.y, 5.0)), "{:?}", of_plate.positions);

    scene.settings.wall_method = WallMethod::QuasiFluid(QuasiFluid::PLAIN);
    let plain = Plan::new(&scene).unwrap().boundary;
    assert_eq!(plain.own_densities, walls.own_densities);
    assert!(plain.volumes.iter().zip(&walls.volumes).all(|(&plain, &adapted)| plain == 2.0 * adapted));
    let message = |change: &dyn Fn(&mut FluidScene)| {
        let mut scene = scene.clone();
        change(&mut scene);
        refused(&scene)
    };
    for relative_density in [0.05, 11.0, f32::NAN] {
        let walls = WallMethod::QuasiFluid(QuasiFluid::Plain { relative_density });
        let error = message(&|scene| scene.settings.wall_method = walls);
        assert!(error.contains("settings.wall_method.relative_density") && error.contains("0.1 to 10"), "{error}");
    }
    let solver = PressureSolver::DivergenceFree(DivergenceFree::default());
    let error = message(&|scene| scene.settings.pressure_solver = solver);
    assert!(error.contains("settings.wall_method: quasi-fluid, plain"), "{error}");
    let error = message(&|scene| scene.settings.widest_support = 1.5);
    assert!(error.contains("settings.widest_support: 1.5") && error.contains("quasi-fluid"), "{error}");
    let error = message(&|scene| scene.settings.density = DensityForm::Continuity);
    assert!(error.contains("settings.density") && error.contains("quasi-fluid walls"), "{error}");
    let error = message(&|scene| scene.boundaries[0].friction = Friction::coulomb(0.1));
    assert!(error.contains("boundaries[0].friction.at_rest") && error.contains("quasi-fluid"), "{error}");
    let sheet = BoundaryShape::Sphere { radius: 0.5, fluid: FluidSide::Both };
    let error = message(&|scene| scene.boundaries.push(Boundary::new(sheet.clone(), Vec3::Y * 10.0)));
    assert!(error.contains("boundaries[1].shape.fluid") && error.contains("Inside or Outside"), "{error}");
}

#[test]
fn ghost_particles_are_for_plane_walls_at_right_angles_and_refuse_the_rest() {
    let mut scene = dam_break();
    scene.settings.wall_method = WallMethod::Ghosts;
    let plan = Plan::new(&scene).unwrap();
    for stage in [StageKind::WallDensity, StageKind::WallForce, StageKind::WallCollision] {
        assert!(reason(&plan, stage).contains("ghost particles"), "{plan}");
    }
    assert!(plan.boundary.viscous.contains(&true) && plan.boundary.faces.iter().all(|face| face.depth.abs() < 1e-5));
    let refused = |change: &dyn Fn(&mut FluidScene), words: [&str; 2]| {
        let mut scene = scene.clone();
        change(&mut scene);
        let message = Plan::new(&scene).unwrap_err().to_string();
        assert!(words.iter().all(|word| message.contains(word)), "{message}");
    };
    let ball = BoundaryShape::Sphere { radius: 0.5, fluid: FluidSide::Inside };
    let block = BoundaryShape::Box { half_extents: Vec3::ONE };
    for (shape, name) in [(ball, "Sphere"), (block, "Box")] {
        let boundary = Boundary::new(shape, Vec3::Y * 10.0);
        let expected = format!("shape: {name} is not allowed; allowed: Container, HalfSpace or Plane");
        refused(&|scene| scene.boundaries.push(boundary.clone()), [&expected, "curved"]);
    }
    let slope = |scene: &mut FluidScene| {
        let floor = Boundary::new(BoundaryShape::HalfSpace { half_extents: [1.0, 1.0] }, Vec3::NEG_Y * 10.0);
        scene.boundaries.push(Boundary { rotation: Quat::from_rotation_x(0.3), ..floor });
    };
    refused(&slope, ["boundaries[1].rotation: a face", "degrees from one of boundaries[0]"]);
    let gap = |scene: &mut FluidScene| {
        let half_extents = Vec3::new(0.5, 0.5, 0.9 * plan.parameters.support_radius);
        let shape = BoundaryShape::Container { half_extents, open: [false; 6] };
        scene.boundaries.push(Boundary::new(shape, Vec3::Y * 10.0));
    };
    refused(&gap, ["boundaries[1].shape.half_extents.z", "the support radius"]);
    let solver = PressureSolver::DivergenceFree(DivergenceFree::default());
    refused(&|scene| scene.settings.pressure_solver = solver, ["settings.wall_method", "ghost particles"]);
    refused(&|scene| scene.settings.widest_support = 1.5, ["settings.widest_support: 1.5", "ghost particles"]);
    refused(&|scene| scene.settings.near_pressure = 0.01, ["settings.near_pressure: 0.01", "ghost particles"]);
    refused(&|scene| scene.settings.tensile_correction = 0.2, ["settings.tensile_correction: 0.2", "ghost particles"]);
    let mueller = |scene: &mut FluidScene| scene.settings.pressure_force = PressureForce::Mueller;
    refused(&mueller, ["settings.pressure_force", "Monaghan, with"]);
    refused(&|scene| scene.settings.density = DensityForm::Continuity, ["settings.density", "ghost particles"]);
    refused(&|scene| scene.settings.integrator = Integrator::Beeman, ["settings.integrator", "ghost particles"]);
    refused(&|scene| scene.settings.redo_substeps = true, ["settings.redo_substeps", "ghost particles"]);
    refused(&|scene| scene.boundaries[0].velocity = Vec3::X, ["boundaries[0].velocity", ""]);
    let rough = |scene: &mut FluidScene| scene.boundaries[0].friction = Friction::coulomb(0.1);
    refused(&rough, ["boundaries[0].friction.at_rest", "ghost particles"]);
}

#[test]
fn particles_do_not_settle_among_bodies() {
    let mut scene = dam_break();
    scene.settings.relaxation = Some(Relaxation::default());
    assert!(Plan::new(&scene).unwrap().relaxation.is_some());
    scene.bodies.push(cork());
    let message = Plan::new(&scene).unwrap_err().to_string();
    assert!(message.contains("settings.relaxation") && message.contains("none, if there are bodies"), "{message}");
}

#[test]
fn every_stage_has_a_reason_that_fits_the_scene() {
    let plan = Plan::new(&FluidScene { bodies: vec![cork()], ..dam_break() }).unwrap();
    assert!(plan.stages.iter().all(|stage| stage.reason.len() > 10));
    assert!(reason(&plan, StageKind::Density).contains("fluid, walls and bodies"));
    assert!(reason(&plan, StageKind::Acceleration).contains("artificial viscosity"));

    let mut inviscid = FluidScene { boundaries: Vec::new(), ..dam_break() };
    inviscid.settings.artificial_viscosity = 0.0;
    let plan = Plan::new(&inviscid).unwrap();
    assert!(reason(&plan, StageKind::Density).contains("fluid only"));
    assert_eq!(reason(&plan, StageKind::Acceleration), "pressure and gravity; settings.artificial_viscosity is 0");
}

#[test]
fn a_field_of_a_stage_is_offered_once_and_only_with_the_stage() {
    let plan = Plan::new(&dam_break()).unwrap();
    for (index, field) in plan.fields.iter().enumerate() {
        assert!(!plan.fields[..index].contains(field), "{}", field.name());
        let writer = match field {
            Field::Density | Field::Pressure => Some(StageKind::Density),
            Field::Acceleration => Some(StageKind::Acceleration),
            _ => None,
        };
        assert_eq!(writer.is_some(), field.origin() == FieldOrigin::Stage);
        assert!(writer.is_none_or(|kind| plan.has(kind)), "{}", field.name());
    }
}

#[test]
fn the_printed_plan_holds_stages_reasons_and_numbers() {
    let plan = Plan::new(&FluidScene { bodies: vec![cork()], ..dam_break() }).unwrap();
    let text = plan.to_string();
    let mut from = 0;
    for stage in &plan.stages {
        let line = text[from..].find(&format!("stage {}", stage.kind.name())).expect("in order") + from;
        assert!(text[line..].lines().next().unwrap().ends_with(&stage.reason));
        from = line + 1;
    }
    for part in [
        "plan of dam break\n",
        "1000 particles of 1.0000e0 kg at the start, at most 1000; spacing 0.1 m, wendland_c2 kernel of support 0.2 m",
        "1 bodies with 2 samples",
        "tait with sound speed 62.642 m/s, clamped at zero; alpha 0.03; step factors 0.4 0.25 0.125",
        "expected speed 6.264 m/s: 2 sqrt(g D) of a column D = 1.0000 m deep",
        &format!("{} wall samples", plan.boundary.positions.len()),
        &format!(
            "wrapped grid of {} x {} x {} cells",
            plan.grid.dimensions().x,
            plan.grid.dimensions().y,
            plan.grid.dimensions().z
        ),
    ] {
        assert!(text.contains(part), "{part:?} is missing in:\n{text}");
    }
}

#[test]
fn the_numbers_of_a_dam_break() {
    let plan = Plan::new(&dam_break()).unwrap();
    let p = &plan.parameters;
    assert_eq!((plan.positions.len(), plan.volume_ids.as_slice(), plan.max_particles), (1000, &[(0, 1000)][..], 1000));
    assert!(near(p.particle_mass, 1.0) && near(p.support_radius, 0.2) && near(p.smoothing_length, 0.1));
    let speed = 2.0 * 9.81f64.sqrt();
    assert!(near(p.expected_speed, speed) && near(p.sound_speed, 10.0 * speed), "{}", p.expected_speed);
    assert_eq!(p.pressure_law.equation, EquationOfState::Tait { sound_speed: p.sound_speed, exponent: 7.0 });
    let kernel = p.kernel().unwrap();
    assert_eq!(p.density_calibration, kernel.lattice_sum(0.1) as f32);
    assert_eq!(p.gradient_calibration, kernel.lattice_gradient_sum(0.1) as f32);
    assert!(plan.boundary.positions.len() == plan.boundary.volumes.len() && plan.boundary.positions.len() > 1000);
    for (particle, sample) in plan.positions.iter().zip(&plan.boundary.positions) {
        assert!(particle.cmpgt(p.bounds_min).all() && particle.cmplt(p.bounds_max).all());
        assert!(sample.cmpgt(p.bounds_min).all() && sample.cmplt(p.bounds_max).all());
    }
    // The fluid touches the faces, the samples lie behind them.
    let apart = 0.5 * p.spacing + p.boundary_depth;
    let nearest = plan.boundary.positions.iter().flat_map(|a| plan.positions.iter().map(|b| a.distance(*b)));
    let nearest = nearest.fold(f32::INFINITY, f32::min);
    // Straight behind a particle there need not be a sample: up to half a spacing aside in both directions. The start is
    // hydrostatic, which brings the lowest layer a few thousandths of a spacing nearer.
    let aside = (apart * apart + 0.5 * p.spacing * p.spacing).sqrt();
    assert!(nearest > apart - 0.003 * p.spacing && nearest < aside, "{nearest}, not {apart} to {aside}");
}

#[test]
fn the_expected_speed_is_that_of_the_fastest_thing() {
    let speed = |scene: &FluidScene| Plan::new(scene).unwrap().parameters.expected_speed;
    let mut scene = dam_break();
    scene.settings.expected_speed = Some(3.0);
    assert_eq!(speed(&scene), 3.0);
    scene.settings.expected_speed = None;

    // Gravity along another axis, of another size: D is the extent along it, 0.5 m.
    scene.gravity = Vec3::new(-2.0, 0.0, 0.0);
    scene.volumes[0] = Volume::block(Vec3::new(0.25, 0.5, 0.5), Vec3::new(0.25, 0.5, 0.5));
    assert!(near(speed(&scene), 2.0));

    // A block that starts at 20 m/s, its highest particles 1.95 m above the floor.
    scene = dam_break();
    scene.volumes =
        vec![Volume { velocity: Vec3::X * 20.0, ..Volume::block(Vec3::splat(0.2), Vec3::new(2.0, 1.8, 0.5)) }];
    assert!(near(speed(&scene), (400.0f64 + 2.0 * 9.81 * 1.95).sqrt()));

    // Nothing at all moves it.
    scene = FluidScene { gravity: Vec3::ZERO, ..dam_break() };
    assert!(speed(&scene) > 0.0 && speed(&scene) <= 0.01);
    assert!(Plan::new(&FluidScene::with_spacing(0.1)).unwrap().positions.is_empty());
}

#[test]
fn resolution_and_support_by_number() {
    let particles = Plan::new(&FluidScene { resolution: Resolution::Particles(8000), ..dam_break() }).unwrap();
    assert!(near(particles.parameters.spacing, 0.05));
    assert_eq!(particles.positions.len(), 8000);

    let mut scene = dam_break();
    scene.settings.support = Support::Neighbours(30.0);
    let radius = f64::from(Plan::new(&scene).unwrap().parameters.support_radius);
    assert!((4.0 / 3.0 * std::f64::consts::PI * (radius / 0.1).powi(3) - 30.0).abs() < 1e-3);
    scene.settings.support = Support::Ratio(2.5);
    assert!(near(Plan::new(&scene).unwrap().parameters.support_radius, 0.25));

    // Shared by so small and so large a volume, spacings out of range would come out.
    let mut tiny = FluidScene { resolution: Resolution::Particles(1 << 20), ..dam_break() };
    tiny.volumes[0] = Volume::block(Vec3::splat(1e-3), Vec3::ZERO);
    assert!(refused(&tiny).contains("resolution: 0.0000196") && refused(&tiny).contains("0.0001 to 100 m"));
    tiny.resolution = Resolution::Particles(1);
    tiny.volumes[0] = Volume::block(Vec3::splat(1e3), Vec3::ZERO);
    assert!(refused(&tiny).contains("resolution: 2000"), "{}", refused(&tiny));
    tiny.volumes.clear();
    assert!(refused(&tiny).contains("a spacing, as there is no volume to share"));
}

#[test]
fn fluid_slower_than_a_tenth_of_sound_only() {
    let mut scene = dam_break();
    for (speed, allowed) in [(62.7, true), (62.0, false), (1.0, false)] {
        scene.settings.sound_speed = Some(speed);
        assert_eq!(Plan::new(&scene).is_ok(), allowed, "{speed}");
    }
    assert!(matches!(Plan::new(&scene), Err(SceneError::Compressible { field: "settings.sound_speed", .. })));
    scene.settings.allow_compressible = true;
    let plan = Plan::new(&scene).unwrap();
    assert_eq!(plan.parameters.sound_speed, 1.0);
    assert!(plan.to_string().contains("note  compressible by request: sound speed 1 m/s"));

    scene = dam_break();
    for (equation, sound_speed) in [
        (EquationOfState::Desbrun { stiffness: 1e4 }, 100.0),
        (EquationOfState::Tait { sound_speed: 80.0, exponent: 3.0 }, 80.0),
        (EquationOfState::Linear { sound_speed: 70.0 }, 70.0),
    ] {
        scene.settings.equation_of_state = Some(equation);
        let parameters = Plan::new(&scene).unwrap().parameters;
        assert_eq!((parameters.pressure_law.equation, parameters.sound_speed), (equation, sound_speed));
    }
    scene.settings.equation_of_state = Some(EquationOfState::Linear { sound_speed: 60.0 });
    assert!(refused(&scene).starts_with("settings.equation_of_state: a speed of sound of 60 m/s"));
    scene.settings.sound_speed = Some(80.0);
    assert!(refused(&scene).starts_with("settings.sound_speed: 80"), "given twice");
}

/// P 5.1: a jet of 0.1 m radius leaves 3.5 m above the ground at 4.76 m/s, with c = 1.5 m/s.
#[test]
fn the_published_jet_needs_leave_to_be_compressible() {
    let mut jet = FluidScene {
        emitters: vec![Emitter {
            center: Vec3::new(0.0, 3.5, 0.0),
            direction: Vec3::X,
            radius: 0.1,
            speed: 4.76,
            lifetime: 1.2,
        }],
        boundaries: vec![Boundary::new(BoundaryShape::Plane { half_extents: [3.0, 1.0] }, Vec3::new(2.0, 0.0, 0.0))],
        ..FluidScene::with_spacing(0.02)
    };
    jet.settings.sound_speed = Some(1.5);
    assert!(refused(&jet).contains("1.5 m/s") && refused(&jet).contains("ten times the expected speed"));
    jet.settings.allow_compressible = true;
    let plan = Plan::new(&jet).unwrap();
    // It falls to the ground.
    assert!(near(plan.parameters.expected_speed, (4.76f64.powi(2) + 2.0 * 9.81 * 3.5).sqrt()));
    assert!(plan.lifetimes && plan.positions.is_empty());
    assert_eq!(u64::from(plan.max_particles), jet.emitters[0].steady_count(0.02).unwrap());
    assert!(plan.notes.iter().any(|note| note.contains("sound speed 1.5 m/s is below ten times")));
}

/// K 8.2: 131,072 particles of 0.0002 kg with an ideal gas of low stiffness.
#[test]
fn the_published_block_needs_leave_to_be_compressible() {
    let half = (0.0002f32 * 131_072.0 / 1000.0).cbrt() / 2.0;
    let mut block = FluidScene {
        resolution: Resolution::Particles(131_072),
        volumes: vec![Volume::block(Vec3::new(half * 2.0, half, half / 2.0), Vec3::ZERO)],
        ..FluidScene::with_spacing(1.0)
    };
    block.settings.equation_of_state = Some(EquationOfState::IdealGas { stiffness: 3.0 });
    assert!(refused(&block).starts_with("settings.equation_of_state"));
    block.settings.allow_compressible = true;
    let plan = Plan::new(&block).unwrap();
    assert!((f64::from(plan.parameters.particle_mass) / 0.0002 - 1.0).abs() < 1e-4);
    // Rounded to whole cells along each axis.
    assert!((plan.positions.len() as f64 / 131_072.0 - 1.0).abs() < 0.02, "{}", plan.positions.len());
    assert!(near(plan.parameters.sound_speed, 3f64.sqrt()));
}

#[test]
fn capacity() {
    let mut scene = dam_break();
    scene.settings.max_particles = Some(999);
    assert!(refused(&scene).contains("settings.max_particles: 999") && refused(&scene).contains("at least 1000"));
    scene.settings.max_particles = Some(1000);
    assert_eq!(Plan::new(&scene).unwrap().max_particles, 1000);
    assert_eq!(Plan::new(&FluidScene::with_spacing(0.1)).unwrap().max_particles, 1);

    let forever = Emitter { center: Vec3::Y, direction: Vec3::Y, radius: 0.2, speed: 1.0, lifetime: f32::INFINITY };
    scene = FluidScene { emitters: vec![Emitter { lifetime: 2.0, ..forever.clone() }, forever.clone()], ..dam_break() };
    assert!(refused(&scene).contains("emitters[1] flows for ever"));
    scene.settings.max_particles = Some(5000);
    assert_eq!(Plan::new(&scene).unwrap().max_particles, 5000);
    scene.settings.max_particles = None;
    scene.emitters.pop();
    // 13 in a layer for the 4 pi cells of the disc, which takes 0.1035 s to flow in: 29 layers in 2 s and a tick of at most 1 s,
    // and two for the ends.
    assert_eq!(Plan::new(&scene).unwrap().max_particles, 1000 + 13 * 31);
    scene.emitters[0].lifetime = 1e30;
    assert!(refused(&scene).contains("settings.max_particles") && refused(&scene).contains("1 to 67108864"));
}

#[test]
fn bounds_leave_out_no_particle_of_the_start() {
    let mut scene = dam_break();
    let plan = Plan::new(&scene).unwrap();
    let low = plan.positions.iter().copied().fold(Vec3::INFINITY, Vec3::min);
    let high = plan.positions.iter().copied().fold(Vec3::NEG_INFINITY, Vec3::max);
    // On the bounds is inside, as for the solvers.
    scene.settings.bounds = Some((low, high));
    let parameters = Plan::new(&scene).unwrap().parameters;
    assert_eq!((parameters.bounds_min, parameters.bounds_max), (low, high));
    for bounds in [(low + 1e-3 * Vec3::X, high), (low, high - 1e-3 * Vec3::Y), (high + 1.0, high + 2.0)] {
        scene.settings.bounds = Some(bounds);
        let Err(SceneError::Invalid(error)) = Plan::new(&scene) else { panic!("{bounds:?} is accepted") };
        assert_eq!((error.field.as_str(), error.value), ("settings.bounds", format!("{} {}", bounds.0, bounds.1)));
        assert!(
            error.allowed.contains(&low.to_string()) && error.allowed.contains(&high.to_string()),
            "{}",
            error.allowed
        );
    }
    // Without particles of the start there is nothing to leave out.
    scene.volumes.clear();
    assert!(Plan::new(&scene).is_ok());
}

#[test]
fn too_many_particles_are_refused_before_memory_is_taken() {
    let mut scene = dam_break();
    scene.resolution = Resolution::Spacing(1e-4);
    assert!(refused(&scene).contains("resolution: spacing 0.0001 m"));
    scene.resolution = Resolution::Spacing(1e-3);
    scene.volumes[0] = Volume::ball(50.0, Vec3::ZERO);
    assert!(refused(&scene).contains(&format!("up to {MAX_PARTICLES}")));
    // Many volumes that are small enough on their own: 400 times 64 million.
    let many = (0..400).map(|index| Volume::block(Vec3::splat(0.2), Vec3::X * index as f32)).collect();
    assert!(refused(&FluidScene { volumes: many, ..scene.clone() }).contains("this one makes 2.560e10"));
    // And walls.
    let wall = Boundary::closed_box(Vec3::splat(3.0), Vec3::ZERO);
    let tray = Boundary::open_box(Vec3::new(2.0, 1.0, 3.0), Vec3::ZERO);
    scene = FluidScene { boundaries: vec![wall, tray], volumes: Vec::new(), ..FluidScene::with_spacing(4e-4) };
    // 6 * 9 m2 and 6 + 2 (2 + 3) m2 over 1.6e-7.
    assert!(refused(&scene).contains("wall samples in all; this one makes 4.375e8"), "{}", refused(&scene));
}

#[test]
fn volumes_that_share_space_are_refused() {
    let block = |half: Vec3, center: Vec3| Volume::block(half, center);
    let unit = block(Vec3::splat(0.5), Vec3::ZERO);
    let overlaps = |second: Volume| match Plan::new(&FluidScene { volumes: vec![unit.clone(), second], ..dam_break() })
    {
        Ok(_) => false,
        Err(SceneError::Overlap { first: 0, second: 1, .. }) => true,
        Err(error) => panic!("{error}"),
    };
    // The same place; half a cell aside, where no two particles are near; a corner; inside; the other one inside.
    assert!(overlaps(unit.clone()));
    assert!(overlaps(block(Vec3::splat(0.5), Vec3::splat(0.05))));
    assert!(overlaps(block(Vec3::splat(0.5), Vec3::splat(0.85))));
    assert!(overlaps(Volume::ball(0.2, Vec3::splat(0.1))));
    assert!(overlaps(Volume::ball(2.0, Vec3::ZERO)));
    let turned = Volume { rotation: Quat::from_rotation_y(0.7), ..block(Vec3::splat(0.5), Vec3::X * 1.1) };
    assert!(overlaps(turned.clone()));
    // Side by side, with whole cells and with half ones, a ball on top, turned a little farther away.
    assert!(!overlaps(block(Vec3::splat(0.5), Vec3::X)));
    assert!(!overlaps(block(Vec3::splat(0.525), Vec3::X * 1.025)));
    assert!(!overlaps(Volume::ball(0.3, Vec3::Y * 0.8)));
    assert!(!overlaps(Volume { center: Vec3::X * 1.25, ..turned }));
    // Neither a whole number of cells long.
    let odd = |center| block(Vec3::splat(0.525), center);
    let pair = vec![odd(Vec3::ZERO), odd(Vec3::X * 1.05), Volume::ball(0.3, Vec3::Y * 5.0), odd(Vec3::Z * 1.05)];
    assert_eq!(Plan::new(&FluidScene { volumes: pair, ..dam_break() }).unwrap().volume_ids.len(), 4);
}

#[test]
fn more_objects_than_a_scene_may_have_are_refused() {
    let many = MAX_OBJECTS + 1;
    let emitter = Emitter { center: Vec3::Y, direction: Vec3::Y, radius: 0.2, speed: 1.0, lifetime: 1.0 };
    let scene = dam_break();
    let cases = [
        ("volumes", FluidScene { volumes: vec![scene.volumes[0].clone(); many], ..scene.clone() }),
        ("emitters", FluidScene { emitters: vec![emitter; many], ..scene.clone() }),
        ("boundaries", FluidScene { boundaries: vec![scene.boundaries[0].clone(); many], ..scene.clone() }),
        ("bodies", FluidScene { bodies: vec![cork(); many], ..scene.clone() }),
    ];
    for (field, scene) in cases {
        let Err(SceneError::Invalid(error)) = Plan::new(&scene) else { panic!("{many} {field} are accepted") };
        assert_eq!((error.field.as_str(), error.value.as_str()), (field, "10001 of them"));
        assert_eq!(error.allowed, "up to 10000");
    }
}

/// The worst that a scene within its limits can ask of the search for overlaps; where volumes share no space nothing ends it
/// early.
#[test]
fn as_many_volumes_as_there_may_be_are_planned_in_a_moment() {
    let planned = |what: &str, volumes: Vec<Volume>| {
        assert_eq!(volumes.len(), MAX_OBJECTS, "{what}");
        let mut scene = FluidScene { volumes, ..FluidScene::with_spacing(0.1) };
        scene.settings.expected_speed = Some(1.0);
        let begin = std::time::Instant::now();
        let plan = Plan::new(&scene);
        let seconds = begin.elapsed().as_secs_f32();
        println!("{what}: {seconds:.2} s for {:?} particles", plan.as_ref().map(|plan| plan.positions.len()));
        // 0.01 to 1.6 s on two busy cores; a search over all pairs of volumes and their particles takes minutes.
        assert!(seconds < 10.0, "{what}: {seconds} s");
        plan.map(|plan| plan.volume_ids.len())
    };
    let drop = |center: Vec3| Volume::block(Vec3::splat(0.05), center);
    // One above the other: they overlap along x and z.
    let tower = (0..MAX_OBJECTS).map(|i| drop(Vec3::Y * 0.2 * i as f32)).collect();
    assert_eq!(planned("a tower of drops", tower), Ok(MAX_OBJECTS));
    // A pool with drops in a layer above it: the pool's box meets that of every drop.
    let mut pool = vec![Volume::block(Vec3::new(10.0, 1.0, 10.0), Vec3::NEG_Y)];
    pool.extend(
        (1..MAX_OBJECTS as u16)
            .map(|i| drop(Vec3::from([i % 100, 1, i / 100].map(f32::from)) * 0.19 - 9.5 * (Vec3::X + Vec3::Z))),
    );
    assert_eq!(planned("a pool and drops", pool), Ok(MAX_OBJECTS));
    // Slanted rods side by side: the box of each meets those of all others.
    let rotation = Quat::from_rotation_arc(Vec3::X, Vec3::ONE.normalize());
    let rods = (0..MAX_OBJECTS as u16).map(|i| Volume {
        rotation,
        ..Volume::block(Vec3::new(7.5, 0.05, 0.05), rotation * (Vec3::from([0, i % 100, i / 100].map(f32::from)) * 0.2))
    });
    assert_eq!(planned("slanted rods", rods.collect()), Ok(MAX_OBJECTS));
    // All in one place.
    let heap = vec![Volume::ball(0.5, Vec3::ZERO); MAX_OBJECTS];
    assert!(matches!(planned("a heap", heap), Err(SceneError::Overlap { .. })));
}

#[test]
fn bodies_keep_to_their_namesakes() {
    let plan = |names: &[&str]| {
        let bodies = names.iter().map(|name| Body { name: (*name).to_owned(), ..cork() }).collect();
        Plan::new(&FluidScene { bodies, ..dam_break() }).unwrap()
    };
    let earlier = plan(&["a", "b", "a", "c"]);
    assert_eq!(plan(&["c", "a", "d", "a", "a"]).bodies_of(&earlier), [Some(3), Some(0), None, Some(2), None]);
}

#[test]
fn positions_that_f32_cannot_tell_apart_are_refused() {
    let at = |x: f32| FluidScene {
        volumes: vec![Volume::block(Vec3::splat(0.5), Vec3::X * x)],
        boundaries: Vec::new(),
        ..FluidScene::with_spacing(0.1)
    };
    assert!(Plan::new(&at(1.3e4)).is_ok());
    let message = refused(&at(2e4));
    assert!(message.contains("resolution: spacing 0.1 m") && message.contains("at least 0.1525"), "{message}");
}

#[test]
fn limits_of_the_substep() {
    let mut parameters = Plan::new(&dam_break()).unwrap().parameters;
    // h = 0.1 m, c = 62.642 m/s.
    assert!(near(parameters.substep_limit(0.0, 9.81), 0.4 * 0.1 / 62.641_839));
    assert!(near(parameters.substep_limit(10.0, 9.81), 0.4 * 0.1 / 72.641_839));
    assert!(near(parameters.substep_limit(0.0, 1e7), 0.25 * (0.1f64 / 1e7).sqrt()));
    // nu = 1 * 62.64 * 0.1 / 10.
    parameters.artificial_viscosity = 1.0;
    assert!(near(parameters.viscous_limit(), 0.125 * 0.01 / 0.626_418_39));
    parameters.courant_factor = 1.0;
    assert!(near(parameters.substep_limit(0.0, 0.0), 0.1 / 62.641_839));
    parameters.viscous_factor = 0.01;
    assert_eq!(parameters.substep_limit(0.0, 0.0), parameters.viscous_limit());
    parameters.artificial_viscosity = 0.0;
    assert!(parameters.viscous_limit() > 1.0);

    // Equal parts, none longer than the limit by more than a thousandth.
    for (remaining, limit, parts) in [(1.0, 2.0, 1.0), (1.0, 1.0, 1.0), (1.0, 0.4, 3.0), (0.01, 0.001, 10.0)] {
        assert!(near(Parameters::equal_substep(remaining, limit), f64::from(remaining) / parts));
    }
    assert_eq!(Parameters::equal_substep(0.0, 0.1), 0.0);
}

#[test]
fn the_cells_around_a_point_are_all_different() {
    for extent in [Vec3::ZERO, Vec3::splat(3.0), Vec3::new(50.0, 1.0, 0.1)] {
        let grid = Grid::fitting(0.2, extent, 1 << 16);
        for point in [Vec3::ZERO, Vec3::splat(-0.01), Vec3::new(-123.4, 55.5, 1e5), Vec3::splat(-1e9)] {
            let mut cells: Vec<u32> = (0..27)
                .map(|i| {
                    grid.index(grid.coordinates(point).wrapping_add(IVec3::new(i % 3 - 1, i / 3 % 3 - 1, i / 9 - 1)))
                })
                .collect();
            cells.sort_unstable();
            cells.dedup();
            assert_eq!(cells.len(), 27);
            assert!(*cells.last().unwrap() < grid.cells());
        }
    }
}

#[test]
fn cells_wrap_around_also_below_zero() {
    let grid = Grid::fitting(0.5, Vec3::new(2.0, 4.0, 8.0), u32::MAX);
    // 4, 8 and 16 cells and three for the margins, as powers of two.
    assert_eq!(grid.dimensions().to_array(), [8, 16, 32]);
    assert_eq!(grid.cells(), 8 * 16 * 32);
    assert_eq!(grid.coordinates(Vec3::new(-0.01, 0.49, 0.5)), IVec3::new(-1, 0, 1));
    for cell in [IVec3::ZERO, IVec3::new(-1, -1, -1), IVec3::new(3, -20, 70)] {
        let size = grid.dimensions().as_ivec3();
        let [x, y, z] = cell.rem_euclid(size).to_array();
        assert_eq!(grid.index(cell) as i32, x + size.x * (y + size.y * z));
        assert_eq!(grid.index(cell), grid.index(cell + size * IVec3::new(1, -2, 3)));
    }
    // x runs fastest.
    assert_eq!(grid.index(IVec3::new(1, 0, 0)), 1);
}

#[test]
fn a_grid_has_no_more_cells_than_asked_for() {
    for max_cells in [0, 1, 64, 100, 4096, 1 << 20, u32::MAX] {
        for extent in [Vec3::ZERO, Vec3::new(1e6, 1.0, 1.0), Vec3::splat(1e9), Vec3::new(f32::INFINITY, 0.0, f32::NAN)]
        {
            let grid = Grid::fitting(0.1, extent, max_cells);
            assert!(grid.cells() <= max_cells.max(64), "{grid:?}");
            assert!(grid.log_cells.min_element() >= 2);
        }
    }
    // The longest axes give way first, so that a long channel keeps its cross-section.
    assert_eq!(Grid::fitting(1.0, Vec3::new(1000.0, 5.0, 5.0), 1 << 9).dimensions().to_array(), [8, 8, 8]);
}

#[test]
fn a_crowd_of_samples_is_refused_before_it_takes_minutes() {
    let crowd = Body { name: "crowd".to_owned(), samples: vec![Vec3::ONE; 1_000_000], ..Body::default() };
    let begin = std::time::Instant::now();
    let message = refused(&FluidScene { bodies: vec![cork(), crowd], ..dam_break() });
    assert!(
        message.contains("bodies[1].samples") && message.contains("1000000") && message.contains("up to 1000"),
        "{message}"
    );
    // Half a million million pairs would be minutes.
    assert!(begin.elapsed().as_secs() < 10, "{:?}", begin.elapsed());
}

#[test]
fn solids_of_bodies_are_checked() {
    let with = |solid: Solid| {
        let body = Body { solids: vec![Solid::ball(0.1, Vec3::ZERO), solid], ..cork() };
        refused(&FluidScene { bodies: vec![body], ..dam_break() })
    };
    let error = with(Solid::ball(-1.0, Vec3::ZERO));
    assert!(error.starts_with("bodies[0].solids[1].shape.radius: -1 is not allowed"), "{error}");
    let error = with(Solid::block(Vec3::new(0.1, f32::NAN, 0.1), Vec3::ZERO));
    assert!(error.starts_with("bodies[0].solids[1].shape.half_extents: NaN"), "{error}");
    assert!(with(Solid::ball(0.1, Vec3::INFINITY)).starts_with("bodies[0].solids[1].center"));
    let shrunk = Solid { rotation: Quat::from_xyzw(0.0, 0.0, 0.0, 0.5), ..Solid::ball(0.1, Vec3::ZERO) };
    assert!(with(shrunk).contains("a unit quaternion"));
    let many = Body { solids: vec![Solid::ball(0.1, Vec3::ZERO); MAX_OBJECTS + 1], ..cork() };
    let error = refused(&FluidScene { bodies: vec![many], ..dam_break() });
    assert!(error.starts_with("bodies[0].solids: 10001 of them"), "{error}");
}

/// A block turned by half a right angle in a turned wall, another in no wall, and a third all in a wall.
#[test]
fn what_starts_in_a_wall_is_left_out_by_volume() {
    let turned = Quat::from_rotation_y(std::f32::consts::FRAC_PI_4);
    let wall =
        Boundary { rotation: turned, ..Boundary::new(BoundaryShape::Box { half_extents: Vec3::ONE }, Vec3::ZERO) };
    let block = |at: f32| Volume { rotation: turned, ..Volume::block(Vec3::splat(0.2), turned * Vec3::X * at) };
    let volumes = vec![block(0.98), block(3.0), block(0.0), Volume { hydrostatic: false, ..block(-0.98) }];
    let scene = FluidScene { volumes, boundaries: vec![wall], ..FluidScene::with_spacing(0.1) };
    let plan = Plan::new(&scene).unwrap();
    // Layers of 16 at 0.83, 0.93, 1.03 and 1.13 m; the nearest to the face at 1 m is beside it, and there is room to move away.
    let counts: Vec<_> = plan.left_out.iter().map(|some| (some.volume, some.inside, some.crowded)).collect();
    assert_eq!(counts, [(0, 32, 0), (2, 64, 0), (3, 32, 0)]);
    assert_eq!(plan.volume_ids, [(0, 32), (32, 64), (96, 0), (96, 32)]);
    assert_eq!((plan.positions.len(), plan.velocities.len()), (128, 128));
    assert!(plan.to_string().contains("volumes[2]: 64 of 64 particles are left out"), "{plan}");

    // There is none where other fluid is.
    let crowd = FluidScene { volumes: vec![block(0.98), block(1.4)], ..scene.clone() };
    let plan = Plan::new(&crowd).unwrap();
    assert_eq!((plan.left_out[0].inside, plan.left_out[0].crowded, plan.positions.len()), (32, 16, 16 + 64));

    // Alone it is moved out of the way: none is too near.
    let alone = FluidScene { volumes: vec![scene.volumes[3].clone()], ..scene.clone() };
    let plan = Plan::new(&alone).unwrap();
    assert_eq!((plan.left_out[0].inside, plan.left_out[0].crowded, plan.positions.len()), (32, 0, 32));
    let nearest =
        plan.positions.iter().map(|point| -1.0 - (turned.conjugate() * *point).x).fold(f32::INFINITY, f32::min);
    assert!((nearest - 0.05).abs() < 1e-5, "{nearest}");
    assert!(Plan::new(&dam_break()).unwrap().left_out.is_empty());
}

fn incompressible(solver: DivergenceFree) -> FluidScene {
    let mut scene = dam_break();
    scene.settings.pressure_solver = PressureSolver::DivergenceFree(solver);
    scene
}

#[test]
fn an_incompressible_fluid_has_its_solves_and_starts_under_the_pressure_of_water() {
    use StageKind::{Acceleration, Density, DensitySolve, DivergenceSolve, Integrate, Sort, StepControl};
    let plan = Plan::new(&incompressible(DivergenceFree::default())).unwrap();
    assert_eq!(kinds(&plan), [Sort, Density, Acceleration, StepControl, DivergenceSolve, DensitySolve, Integrate]);
    assert!(reason(&plan, DivergenceSolve).contains("0.001") && reason(&plan, DensitySolve).contains("200"));
    let text = plan.to_string();
    assert!(text.contains("incompressible, relaxation") && !text.contains("tait"), "{text}");
    // On the lattice, and rho g (depth) over rho^2.
    assert!(plan.positions.iter().all(|x| (x * 10.0 - 0.5).fract().abs().max_element() < 1e-3));
    for (position, pressure) in plan.positions.iter().zip(&plan.pressures) {
        assert!((pressure - 9.81 * (1.0 - position.y) / 1000.0).abs() < 1e-6, "{pressure} at {position}");
    }
    let mut loose = incompressible(DivergenceFree::default());
    loose.volumes[0].hydrostatic = false;
    assert!(Plan::new(&loose).unwrap().pressures.iter().all(|&pressure| pressure == 0.0));
    assert!(Plan::new(&dam_break()).unwrap().pressures.is_empty());

    let mut with_body = incompressible(DivergenceFree::default());
    with_body.bodies.push(cork());
    let plan = Plan::new(&with_body).unwrap();
    for kind in [StageKind::BodySort, StageKind::BodyLoad, StageKind::BodyMotion] {
        assert!(plan.has(kind), "{kind:?}");
    }
    assert!(reason(&plan, DivergenceSolve).contains("bodies answer"), "{}", reason(&plan, DivergenceSolve));
}

#[test]
fn the_substep_of_an_incompressible_fluid() {
    let parameters = Plan::new(&incompressible(DivergenceFree::default())).unwrap().parameters;
    // 0.4 d over the speed; what falls from rest; 0.6 of 2 / omega, with 3.0758 = 2 / 0.6502 for Wendland C2 at 2 d.
    assert!(near(parameters.incompressible_limit(4.0, 0.0, 0.0), 0.01));
    assert!(near(
        parameters.incompressible_limit(0.0, 9.81, 0.0),
        (0.04f64 / 9.81).sqrt().min(parameters.viscous_limit().into())
    ));
    let by_pressure = f64::from(parameters.incompressible_limit(0.0, 0.0, 9.81));
    assert!((by_pressure / (0.6 * 0.6502 * 0.1 / 9.81f64.sqrt()) - 1.0).abs() < 1e-2, "{by_pressure}");
    assert!((parameters.relaxation - 0.88 / 2.605).abs() < 0.002);
}

#[test]
fn what_an_incompressible_fluid_cannot_have_is_refused() {
    let with = |change: fn(&mut FluidScene)| {
        let mut scene = incompressible(DivergenceFree::default());
        change(&mut scene);
        refused(&scene)
    };
    let only = "with the weakly compressible settings.pressure_solver only";
    let tait = |scene: &mut FluidScene| {
        scene.settings.equation_of_state = Some(EquationOfState::Tait { sound_speed: 90.0, exponent: 7.0 });
    };
    for (message, words) in [
        (with(tait), ["settings.equation_of_state", "tait", only]),
        (with(|scene| scene.settings.clamp_negative_pressure = false), ["clamp_negative_pressure", "false", only]),
        (with(|scene| scene.settings.widest_support = 1.5), ["settings.widest_support", "1.5", only]),
        (with(|scene| scene.settings.near_pressure = 0.01), ["settings.near_pressure", "0.01", only]),
        (with(|scene| scene.settings.integrator = Integrator::Leapfrog), ["settings.integrator", "leapfrog", only]),
        (with(|scene| scene.settings.pressure_force = PressureForce::Mueller), ["pressure_force", "Mueller", only]),
    ] {
        assert!(words.iter().all(|word| message.contains(word)), "{message}");
    }
    let default = DivergenceFree::default();
    for (solver, words) in [
        (DivergenceFree { compression: f32::NAN, ..default }, ["pressure_solver.compression", "NaN", "0.1"]),
        (DivergenceFree { compression: 0.0, ..default }, ["pressure_solver.compression", "0", "0.1"]),
        (DivergenceFree { divergence: 0.5, ..default }, ["pressure_solver.divergence", "0.5", "0.1"]),
        (DivergenceFree { max_iterations: 1, ..default }, ["pressure_solver.max_iterations", "1", "2 to 10000"]),
        (DivergenceFree { max_iterations: 20_000, ..default }, ["max_iterations", "20000", "2 to 10000"]),
    ] {
        let message = refused(&incompressible(solver));
        assert!(words.iter().all(|word| message.contains(word)), "{message}");
    }
}

#[test]
fn a_density_that_is_carried_is_refused_with_what_its_rate_does_not_know() {
    let with = |change: fn(&mut FluidScene)| {
        let mut scene = dam_break();
        scene.settings.density = DensityForm::Continuity;
        change(&mut scene);
        Plan::new(&scene).map_err(|error| error.to_string())
    };
    let plan = with(|_| ()).unwrap();
    assert_eq!(plan.excesses.len(), plan.positions.len());
    assert!(plan.stages.iter().any(|stage| stage.reason.contains("particles carry")));
    assert!(Plan::new(&dam_break()).unwrap().excesses.is_empty());
    let refused: [(fn(&mut FluidScene), &str); 8] = [
        (|scene| scene.settings.wall_method = WallMethod::Penalty(Penalty::DEFAULT), "settings.wall_method"),
        (|scene| scene.settings.widest_support = 1.5, "settings.widest_support"),
        (|scene| scene.settings.xsph = 0.5, "settings.xsph"),
        (|scene| scene.settings.integrator = Integrator::Leapfrog, "leapfrog"),
        (|scene| scene.settings.relaxation = Some(Relaxation::default()), "settings.relaxation"),
        (|scene| scene.settings.pressure_solver = PressureSolver::DivergenceFree(DivergenceFree::default()), "weakly"),
        (|scene| scene.bodies = vec![cork()], "1 bodies"),
        (
            |scene| {
                scene.settings.density = DensityForm::AdaptedContinuity;
                scene.settings.xsph = 0.5;
            },
            "adapted continuity",
        ),
    ];
    for (change, word) in refused {
        let message = with(change).unwrap_err();
        assert!(message.contains("settings.density") && message.contains(word), "{message}");
    }
    // The adapted sum is the sum.
    let mut adapted = dam_break();
    adapted.settings.density = DensityForm::Adapted;
    adapted.settings.xsph = 0.5;
    assert!(Plan::new(&adapted).unwrap().excesses.is_empty());
}

#[test]
fn the_position_based_solver_is_refused_with_what_it_does_not_do() {
    let with = |change: fn(&mut FluidScene)| {
        let mut scene = dam_break();
        scene.settings.pressure_solver = PressureSolver::PositionBased(PositionBased::default());
        change(&mut scene);
        Plan::new(&scene).map_err(|error| error.to_string())
    };
    let plan = with(|_| ()).unwrap();
    assert!(plan.has(StageKind::PositionSolve) && !plan.has(StageKind::DivergenceSolve));
    assert!(plan.to_string().contains("position-based, 4 iterations"), "{plan}");
    // Nothing is pressed together at the start.
    let lowest = plan.positions.iter().map(|x| x.y).fold(f32::INFINITY, f32::min);
    assert!((lowest - 0.05).abs() < 1e-6 && plan.positions.iter().any(|x| (x.y - 0.95).abs() < 1e-6));
    fn solver(scene: &mut FluidScene, iterations: u32, softness: f32) {
        scene.settings.pressure_solver = PressureSolver::PositionBased(PositionBased { iterations, softness });
    }
    let refused: [(fn(&mut FluidScene), [&str; 2]); 11] = [
        (|scene| scene.settings.xsph = 0.5, ["settings.xsph: 0.5", "0, with the position-based"]),
        (
            |scene| scene.settings.relaxation = Some(Relaxation::default()),
            ["settings.relaxation: Some", "none, with the position-based"],
        ),
        (|scene| solver(scene, 0, 0.0), ["settings.pressure_solver.iterations: 0", "1 to 1000"]),
        (|scene| solver(scene, 4, -1.0), ["settings.pressure_solver.softness: -1", "0 to 10"]),
        (|scene| scene.settings.integrator = Integrator::Leapfrog, ["settings.integrator", "weakly compressible"]),
        (|scene| scene.settings.redo_substeps = true, ["settings.redo_substeps", "position-based"]),
        (|scene| scene.settings.density = DensityForm::Continuity, ["settings.density", "weakly compressible"]),
        (|scene| scene.settings.near_pressure = 0.01, ["settings.near_pressure", "weakly compressible"]),
        (|scene| scene.settings.tensile_correction = 0.2, ["settings.tensile_correction", "weakly compressible"]),
        (|scene| scene.bodies = vec![cork()], ["settings.pressure_solver: position-based", "1 bodies"]),
        (
            |scene| scene.boundaries[0].friction = Friction { at_rest: 0.5, sliding: 0.25 },
            ["settings.pressure_solver: position-based", "boundaries[0] has friction"],
        ),
    ];
    for (change, words) in refused {
        let message = with(change).unwrap_err();
        assert!(words.iter().all(|word| message.contains(word)), "{message}");
    }
}

#[test]
fn the_pressure_corrected_solver_is_refused_with_what_it_does_not_do() {
    let with = |change: fn(&mut FluidScene)| {
        let mut scene = dam_break();
        scene.settings.pressure_solver = PressureSolver::PressureCorrected(PressureCorrected::default());
        change(&mut scene);
        Plan::new(&scene).map_err(|error| error.to_string())
    };
    let plan = with(|_| ()).unwrap();
    assert!(plan.has(StageKind::PositionSolve) && !plan.has(StageKind::DivergenceSolve));
    assert!(plan.to_string().contains("pressure-corrected, 4 iterations, gradient by sum"), "{plan}");
    fn solver(scene: &mut FluidScene, iterations: u32) {
        let solver = PressureCorrected { iterations, ..PressureCorrected::default() };
        scene.settings.pressure_solver = PressureSolver::PressureCorrected(solver);
    }
    let refused: [(fn(&mut FluidScene), [&str; 2]); 8] = [
        (|scene| solver(scene, 0), ["settings.pressure_solver.iterations: 0", "1 to 1000"]),
        (|scene| solver(scene, 1001), ["settings.pressure_solver.iterations: 1001", "1 to 1000"]),
        (|scene| scene.settings.xsph = 0.5, ["settings.xsph: 0.5", "0, with the pressure-corrected"]),
        (
            |scene| scene.settings.relaxation = Some(Relaxation::default()),
            ["settings.relaxation: Some", "none, with the pressure-corrected"],
        ),
        (|scene| scene.settings.redo_substeps = true, ["settings.redo_substeps", "pressure-corrected"]),
        (|scene| scene.settings.density = DensityForm::Continuity, ["settings.density", "weakly compressible"]),
        (|scene| scene.bodies = vec![cork()], ["settings.pressure_solver: pressure-corrected", "1 bodies"]),
        (
            |scene| scene.boundaries[0].friction = Friction { at_rest: 0.5, sliding: 0.25 },
            ["settings.pressure_solver: pressure-corrected", "boundaries[0] has friction"],
        ),
    ];
    for (change, words) in refused {
        let message = with(change).unwrap_err();
        assert!(words.iter().all(|word| message.contains(word)), "{message}");
    }
}

#[test]
fn the_poisson_solver_is_refused_with_what_it_does_not_do() {
    let with = |change: fn(&mut FluidScene)| {
        let mut scene = dam_break();
        scene.settings.pressure_solver = PressureSolver::PressurePoisson(PressurePoisson::default());
        change(&mut scene);
        Plan::new(&scene).map_err(|error| error.to_string())
    };
    let plan = with(|_| ()).unwrap();
    assert!(plan.has(StageKind::PositionSolve) && !plan.has(StageKind::DivergenceSolve));
    assert!(plan.to_string().contains("pressure Poisson, to 0.02"), "{plan}");
    fn solver(scene: &mut FluidScene, tolerance: f32, max_iterations: u32) {
        scene.settings.pressure_solver = PressureSolver::PressurePoisson(PressurePoisson { tolerance, max_iterations });
    }
    let refused: [(fn(&mut FluidScene), [&str; 2]); 7] = [
        (|scene| solver(scene, 0.0, 60), ["settings.pressure_solver.tolerance: 0", "0.0001 to 0.5"]),
        (|scene| solver(scene, f32::NAN, 60), ["settings.pressure_solver.tolerance: NaN", "0.0001 to 0.5"]),
        (|scene| solver(scene, 0.1, 1), ["settings.pressure_solver.max_iterations: 1", "2 to 1000"]),
        (|scene| scene.settings.xsph = 0.5, ["settings.xsph: 0.5", "0, with the pressure Poisson"]),
        (|scene| scene.settings.redo_substeps = true, ["settings.redo_substeps", "pressure Poisson"]),
        (|scene| scene.settings.density = DensityForm::Continuity, ["settings.density", "weakly compressible"]),
        (|scene| scene.bodies = vec![cork()], ["settings.pressure_solver: pressure Poisson", "1 bodies"]),
    ];
    for (change, words) in refused {
        let message = with(change).unwrap_err();
        assert!(words.iter().all(|word| message.contains(word)), "{message}");
    }
}

#[test]
fn the_plan_says_that_a_tensile_correction_without_tension_does_little() {
    let notes = |correction: f32, clamp: bool| {
        let mut scene = dam_break();
        scene.settings.tensile_correction = correction;
        scene.settings.clamp_negative_pressure = clamp;
        let plan = Plan::new(&scene).unwrap();
        plan.notes.iter().filter(|note| note.contains("settings.clamp_negative_pressure leaves no tension")).count()
    };
    assert_eq!([notes(0.2, true), notes(0.2, false), notes(0.0, true)], [1, 0, 0]);
}
