//! Scales of entities: what remains of a transform without its rotation.

use bevy::math::{Affine3A, DMat3};
use bevy::prelude::*;

/// Difference of scales, relative to them, up to which a wall counts as unchanged: the hierarchy's rounding, 1e-6, changes them in
/// each tick in which a parent moves.
const SAME_STRETCH: f32 = 1e-5;

/// Whether two stretches differ by rounding only.
pub(crate) fn is_same_stretch(a: Mat3, b: Mat3) -> bool {
    let limit = SAME_STRETCH * largest(b);
    // A comparison with not-a-number is false: it is like nothing.
    (a - b).to_cols_array().iter().all(|difference| difference.abs() <= limit)
}

fn largest(matrix: Mat3) -> f32 {
    matrix.to_cols_array().iter().fold(0.0, |largest, value| largest.max(value.abs()))
}

/// The rigid frame of an entity in the world, and how it is stretched first; or what is wrong with it.
pub(crate) fn stretched_frame(transforms: &TransformHelper, entity: Entity) -> Result<(Isometry3d, Mat3), String> {
    let transform = transforms.compute_global_transform(entity).map_err(|error| error.to_string())?;
    split(transform.affine()).ok_or_else(|| {
        let (scale, _, translation) = transform.to_scale_rotation_translation();
        format!(
            "Transform: scale {scale}, translation {translation} is not allowed; allowed: a scale other than 0, finite numbers"
        )
    })
}

/// Splits a transform into a stretch and a rigid frame after it, by the polar decomposition (Higham 1986): with scales of parents
/// that are turned it is no scale along axes, but a symmetric matrix. Of a mirror image it is the negative of one.
fn split(affine: Affine3A) -> Option<(Isometry3d, Mat3)> {
    let linear = DMat3::from_cols_array(&affine.matrix3.to_cols_array().map(f64::from));
    let determinant = linear.determinant();
    let size = determinant.abs().cbrt();
    let is_usable = size > 0.0 && size.is_finite() && affine.translation.is_finite();
    if !is_usable {
        return None;
    }
    // Newton's iteration (eq. 3.1 there); from a size of one it doubles the digits once the ratio of the scales is used up.
    let mut rotation = linear * (determinant.signum() / size);
    for _ in 0..100 {
        let next = 0.5 * (rotation + rotation.inverse().transpose());
        let change = (next - rotation).to_cols_array().iter().fold(0.0, |most: f64, value| most.max(value.abs()));
        rotation = next;
        if change < 1e-14 {
            break;
        }
    }
    let off = rotation * rotation.transpose() - DMat3::IDENTITY;
    let is_rotation = off.to_cols_array().iter().all(|value| value.abs() < 1e-9);
    if !is_rotation {
        return None;
    }
    let stretch = (rotation.transpose() * linear).as_mat3();
    let stretch = if is_same_stretch(stretch, Mat3::IDENTITY) { Mat3::IDENTITY } else { stretch };
    Some((Isometry3d::new(affine.translation, Quat::from_mat3(&rotation.as_mat3()).normalize()), stretch))
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_parts_make_the_whole() {
        let turned = Quat::from_euler(EulerRot::YXZ, 0.7, -0.3, 2.0);
        let parent = Transform::from_xyz(1.0, 2.0, 3.0).with_rotation(turned).with_scale(Vec3::new(2.0, 0.5, 1.0));
        for scale in [
            Vec3::ONE,
            Vec3::splat(3.0),
            Vec3::new(1.0, 20.0, 0.3),
            Vec3::new(1e-4, 1.0, 1e3),
            Vec3::new(-1.0, 1.0, 2.0),
            Vec3::splat(-2.0),
        ] {
            let child = Transform::from_rotation(turned.inverse()).with_scale(scale);
            for whole in [child.compute_affine(), parent.compute_affine() * child.compute_affine()] {
                let (frame, stretch) = split(whole).unwrap();
                assert_eq!(stretch.determinant() < 0.0, scale.x * scale.y * scale.z < 0.0);
                for point in [Vec3::X, Vec3::Y, Vec3::Z, Vec3::new(0.3, -2.0, 0.7)] {
                    let (wanted, found) = (whole.transform_point3(point), frame * (stretch * point));
                    assert!(wanted.distance(found) < 1e-5 * (1.0 + wanted.length()), "{scale}: {wanted} {found}");
                }
                let symmetric = (stretch - stretch.transpose()).to_cols_array();
                assert!(symmetric.iter().all(|value| value.abs() < 1e-4 * largest(stretch)), "{stretch}");
            }
        }
    }

    #[test]
    fn a_turning_parent_leaves_the_stretch_as_it_is() {
        let child = Transform::from_xyz(0.5, 0.0, 0.0).with_scale(Vec3::new(2.0, 0.5, 1.5)).compute_affine();
        let (_, first) = split(child).unwrap();
        for step in 1..1000 {
            let parent = Transform::from_rotation(Quat::from_euler(EulerRot::XYZ, 0.01 * step as f32, 0.3, -0.2));
            let (_, stretch) = split(parent.compute_affine() * child).unwrap();
            assert!(is_same_stretch(stretch, first), "{step}: {stretch}");
        }
        assert_eq!(split(Affine3A::from_quat(Quat::from_rotation_y(0.3))).unwrap().1, Mat3::IDENTITY);
    }

    #[test]
    fn what_has_no_volume_is_refused() {
        for scale in [Vec3::ZERO, Vec3::new(1.0, 0.0, 1.0), Vec3::NAN, Vec3::splat(f32::INFINITY)] {
            assert!(split(Affine3A::from_scale(scale)).is_none(), "{scale}");
        }
        assert!(split(Affine3A::from_translation(Vec3::NAN)).is_none());
    }
}
