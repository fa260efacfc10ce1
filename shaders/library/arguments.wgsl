// Arguments of the indirect dispatches and of drawing, in a buffer of their own: a dispatch cannot write the buffer it
// takes its arguments from.
#define_import_path freshet::arguments

#import freshet::bindings as fields
#import freshet::threads
#ifdef INCOMPRESSIBLE
#import freshet::solve
#endif

// Writes what the next dispatches are told. `going`: whether another substep follows.
fn write_arguments(going: bool) {
    let count = select(0u, fields::control.count, going);
    fields::set_arguments(#{ARGUMENTS_PARTICLES}u, threads::groups_for(count));
    let blocks = (fields::parameters.cells + #{SCAN_BLOCK}u) / #{SCAN_BLOCK}u;
    fields::set_arguments(#{ARGUMENTS_CELLS}u, threads::group_grid(select(0u, blocks, going)));
#ifdef BODIES
    fields::set_arguments(#{ARGUMENTS_SAMPLES}u, threads::groups_for(select(0u, fields::parameters.body_samples, going)));
    fields::set_arguments(#{ARGUMENTS_BODIES}u, threads::group_grid(select(0u, fields::parameters.bodies, going)));
#endif
#ifdef QUASI_FLUID_WALLS
    let wall_samples = select(0u, fields::parameters.wall_samples, going);
    fields::set_arguments(#{ARGUMENTS_WALL_SAMPLES}u, threads::groups_for(wall_samples));
#endif
    fields::set_instances(fields::control.count);
}

#ifdef INCOMPRESSIBLE
// Which passes of the solves are dispatched next: the first of the divergence solve, iterations, the first of the density solve.
fn write_solve_arguments(first: bool, iterations: bool, density: bool) {
    let live = fields::control.live;
    fields::set_arguments(#{ARGUMENTS_FIRST}u, threads::groups_for(select(0u, live, first)));
    fields::set_arguments(#{ARGUMENTS_ITERATIONS}u, threads::groups_for(select(0u, live, iterations)));
    fields::set_arguments(#{ARGUMENTS_DENSITY}u, threads::groups_for(select(0u, live, density)));
#ifdef BODIES
    // Positions are corrected about bodies that stand still.
    let answering = iterations && fields::control.solve_phase == solve::DIVERGENCE;
    fields::set_arguments(#{ARGUMENTS_PUSHES}u, threads::groups_for(select(0u, fields::parameters.body_samples, answering)));
    fields::set_arguments(#{ARGUMENTS_ANSWERS}u, threads::group_grid(select(0u, fields::parameters.bodies, answering)));
#endif
}
#endif

#ifdef POISSON
// Whether the next iteration of a Poisson equation is dispatched.
fn write_iteration_arguments(iterates: bool) {
    let count = select(0u, fields::control.live, iterates);
    fields::set_arguments(#{ARGUMENTS_ITERATIONS}u, threads::groups_for(count));
}
#endif

fn write_motion_arguments(moving: bool) {
    fields::set_arguments(#{ARGUMENTS_MOTION}u, threads::groups_for(select(0u, fields::control.live, moving)));
#ifdef BODIES
    fields::set_arguments(#{ARGUMENTS_BODY_MOTION}u, threads::groups_for(select(0u, fields::parameters.bodies, moving)));
#ifdef ROUGH_BODIES
    fields::set_arguments(#{ARGUMENTS_FRICTION_LOADS}u, threads::groups_for(select(0u, fields::parameters.body_samples, moving)));
    fields::set_arguments(#{ARGUMENTS_FRICTION_SUMS}u, threads::group_grid(select(0u, fields::parameters.bodies, moving)));
#endif
#endif
}

#ifdef REDO
// Whether the state is kept that a substep starts from, and whether what was kept is put back.
fn write_redo_arguments(keep: bool, restore: bool) {
#ifdef BODIES
    let count = max(fields::control.live, fields::parameters.bodies);
#else
    let count = fields::control.live;
#endif
    fields::set_arguments(#{ARGUMENTS_KEEP}u, threads::groups_for(select(0u, count, keep)));
    fields::set_arguments(#{ARGUMENTS_RESTORE}u, threads::groups_for(select(0u, count, restore)));
}
#endif
