//! Stage `wall_collision`: puts particles back that got into walls, see [`Penalty`].

use freshet_core::wall_method::Penalty;
use glam::Vec3;

use crate::near_walls::NearWalls;
use crate::workspace::Workspace;

/// Places and velocities of a chunk's particles after a substep of `dt` seconds; none gets nearer to a face than `contact` spacings.
pub fn wall_collision(
    near: NearWalls<'_>,
    (penalty, contact): (Penalty, f32),
    workspace: &mut Workspace,
    moved: [[&mut [f32]; 3]; 2],
    dt: f32,
) {
    let [[x, y, z], [vx, vy, vz]] = moved;
    let contact = contact * near.plan.parameters.spacing;
    for i in 0..x.len() {
        let mut position = Vec3::new(x[i], y[i], z[i]);
        let Some(around) = near.around(position) else { continue };
        let (planes, count) = near.planes(&around, &mut workspace.near_walls);
        let mut velocity = Vec3::new(vx[i], vy[i], vz[i]);
        penalty.collide(&mut position, &mut velocity, &planes[..count], contact, dt);
        (x[i], y[i], z[i]) = near.plan.grid.periodic.wrap(position).into();
        (vx[i], vy[i], vz[i]) = velocity.into();
    }
}
