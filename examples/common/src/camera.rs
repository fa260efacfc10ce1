//! A camera that turns around a point, and moves it.

use bevy::input::mouse::{AccumulatedMouseMotion, AccumulatedMouseScroll};
use bevy::prelude::*;

/// Where the camera is, seen from what it looks at.
#[derive(Component, Clone, Copy, Debug)]
pub struct Orbit {
    /// m.
    pub target: Vec3,
    /// m.
    pub distance: f32,
    /// rad.
    pub yaw: f32,
    /// rad, positive from above.
    pub pitch: f32,
    /// The mouse button that turns, and the one that moves.
    pub buttons: [MouseButton; 2],
}

impl Orbit {
    /// Shows all that lies between two corners. The left button turns, the right one moves.
    pub fn around((low, high): (Vec3, Vec3)) -> Self {
        let size = high - low;
        // A little below the middle, because fluid lies at the bottom; steep enough that no horizon distracts.
        let target = (low + high) / 2.0 - Vec3::Y * 0.05 * size.y;
        let buttons = [MouseButton::Left, MouseButton::Right];
        Self { target, distance: 1.12 * size.length(), yaw: 0.42, pitch: 0.44, buttons }
    }

    /// The pose.
    pub fn transform(&self) -> Transform {
        let direction = Quat::from_euler(EulerRot::YXZ, self.yaw, -self.pitch, 0.0) * Vec3::Z;
        Transform::from_translation(self.target + direction * self.distance).looking_at(self.target, Vec3::Y)
    }
}

/// One button turns, the other and the arrow or WASD keys move, the wheel comes closer.
pub fn steer(
    mut cameras: Query<(&mut Orbit, &mut Transform)>,
    buttons: Res<ButtonInput<MouseButton>>,
    keys: Res<ButtonInput<KeyCode>>,
    motion: Res<AccumulatedMouseMotion>,
    scroll: Res<AccumulatedMouseScroll>,
    time: Res<Time<Real>>,
) {
    for (mut orbit, mut transform) in &mut cameras {
        let mut new = *orbit;
        if buttons.pressed(orbit.buttons[0]) {
            new.yaw -= motion.delta.x * 0.005;
            new.pitch = (new.pitch + motion.delta.y * 0.005).clamp(-1.5, 1.5);
        }
        let mut shift = Vec2::ZERO;
        if buttons.pressed(orbit.buttons[1]) {
            shift += motion.delta * Vec2::new(-1.0, 1.0) * 0.0015;
        }
        let pressed = |a, b| if keys.any_pressed([a, b]) { 1.0 } else { 0.0 };
        let step = 0.8 * time.delta_secs();
        shift.x += step * (pressed(KeyCode::ArrowRight, KeyCode::KeyD) - pressed(KeyCode::ArrowLeft, KeyCode::KeyA));
        shift.y += step * (pressed(KeyCode::PageUp, KeyCode::KeyE) - pressed(KeyCode::PageDown, KeyCode::KeyQ));
        let ahead = step * (pressed(KeyCode::ArrowUp, KeyCode::KeyW) - pressed(KeyCode::ArrowDown, KeyCode::KeyS));
        let level = Vec3::new(transform.forward().x, 0.0, transform.forward().z).normalize_or_zero();
        new.target += (transform.right() * shift.x + transform.up() * shift.y + level * ahead) * orbit.distance;
        new.distance = (new.distance * (-0.1 * scroll.delta.y).exp()).clamp(0.05, 1e4);
        *orbit = new;
        *transform = new.transform();
    }
}
