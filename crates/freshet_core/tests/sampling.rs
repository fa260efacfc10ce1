//! Lattices, boundary layers and what their samples weigh.

use std::f32::consts::PI;

use freshet_core::error::InvalidInput;
use freshet_core::kernel::{Kernel, KernelKind};
use freshet_core::sampling::MAX_SAMPLES;
use freshet_core::sampling::boundary::{sample_box_surface, sample_container, sample_plane, sample_sphere_surface};
use freshet_core::sampling::lattice::{box_cells, count_box, sample_box, sample_sphere};
use freshet_core::sampling::volume_weights::volume_weights;
use glam::{Vec3, vec3};

const CLOSED: [bool; 6] = [false; 6];

/// The distance of the closest two, by brute force.
fn closest_pair(positions: &[Vec3]) -> f32 {
    let mut closest = f32::INFINITY;
    for (i, a) in positions.iter().enumerate() {
        for b in &positions[..i] {
            closest = closest.min(a.distance(*b));
        }
    }
    closest
}

fn nearest(positions: &[Vec3], to: Vec3) -> f32 {
    positions.iter().map(|x| x.distance(to)).fold(f32::INFINITY, f32::min)
}

fn largest(positions: &[Vec3]) -> Vec3 {
    positions.iter().fold(Vec3::ZERO, |largest, x| largest.max(x.abs()))
}

fn mean(positions: &[Vec3]) -> Vec3 {
    (positions.iter().map(|x| x.as_dvec3()).sum::<glam::DVec3>() / positions.len() as f64).as_vec3()
}

// Lattices

#[test]
fn a_box_of_whole_cells_holds_its_volume() {
    let (half, d) = (vec3(0.5, 0.3, 0.2), 0.05);
    let positions = sample_box(half, d).unwrap();
    // 20 x 12 x 8, though none of these quotients is whole in single precision.
    assert_eq!(positions.len(), 1920);
    assert_eq!(count_box(half, d).unwrap(), 1920);
    assert_eq!(box_cells(half, d).unwrap(), [20, 12, 8]);
    // So that the mass is exact, to the rounding of d^3.
    let volume = positions.len() as f32 * d.powi(3);
    assert!((volume / (8.0 * half.x * half.y * half.z) - 1.0).abs() < 1e-6);
    // Cell centres: half a spacing inside every face.
    assert!((largest(&positions) - (half - 0.5 * d)).length() < 1e-7);
    assert!(mean(&positions).length() < 1e-7);
}

#[test]
fn a_box_runs_x_first_with_equal_steps() {
    let positions = sample_box(vec3(0.2, 0.1, 0.1), 0.1).unwrap();
    assert_eq!(positions.len(), 16);
    let expected = [vec3(-0.15, -0.05, -0.05), vec3(-0.05, -0.05, -0.05), vec3(0.05, -0.05, -0.05)];
    for (position, expected) in positions.iter().zip(expected) {
        assert!(position.distance(expected) < 1e-7);
    }
    assert!(positions[4].distance(vec3(-0.15, 0.05, -0.05)) < 1e-7);
    assert!(positions[8].distance(vec3(-0.15, -0.05, 0.05)) < 1e-7);
    assert!((closest_pair(&positions) - 0.1).abs() < 1e-7);
}

#[test]
fn a_box_that_is_no_whole_number_of_cells_stays_centred() {
    // 2.4 and 2.6 cells round to 2 and 3, half a cell and more to one.
    assert_eq!(box_cells(vec3(1.2, 1.3, 0.26), 1.0).unwrap(), [2, 3, 1]);
    let positions = sample_box(vec3(1.2, 1.3, 0.26), 1.0).unwrap();
    assert!(mean(&positions).length() < 1e-6);
    assert_eq!(largest(&positions), vec3(0.5, 1.0, 0.0));
}

#[test]
fn a_ball_is_filled_and_nothing_sticks_out() {
    for (radius, d) in [(0.5, 0.1), (0.5, 0.05), (0.37, 0.031), (0.25, 0.1), (0.077, 0.1)] {
        let positions = sample_sphere(radius, d).unwrap();
        assert!(positions.iter().all(|x| x.length() <= radius * 1.000_01));
        assert!(mean(&positions).length() < 1e-6);
        assert!(positions.len() == 1 || (closest_pair(&positions) - d).abs() < 1e-5 * d);
        // Complete: one of the two lattices, with each of its points within the radius.
        let shift = if positions.contains(&Vec3::ZERO) { 0.0 } else { 0.5 };
        let reach = (radius / d) as i32 + 2;
        let at = |i: i32| (i as f32 + shift) * d;
        let inside = (-reach..reach)
            .flat_map(|i| (-reach..reach).flat_map(move |j| (-reach..reach).map(move |k| (i, j, k))))
            .filter(|&(i, j, k)| vec3(at(i), at(j), at(k)).length() <= radius)
            .count();
        assert_eq!(positions.len(), inside, "{radius}, {d}");
        // x runs fastest.
        assert!(positions.is_sorted_by_key(|x| (
            (x.z / d * 2.0).round() as i32,
            (x.y / d * 2.0).round() as i32,
            (x.x / d * 2.0).round() as i32
        )));
    }
    // The smallest.
    assert_eq!(sample_sphere(0.5, 1.0).unwrap(), [Vec3::ZERO]);
}

#[test]
fn the_volume_of_a_filled_ball_is_as_close_as_documented() {
    for (from, to, tolerance) in [(2.0, 3.0, 0.26), (3.0, 5.0, 0.1), (5.0, 10.0, 0.06), (10.0, 20.0, 0.02)] {
        for radius in (0..=40).map(|i| from + (to - from) * i as f32 / 40.0) {
            let volume = sample_sphere(radius, 1.0).unwrap().len() as f32 / (4.0 / 3.0 * PI * radius.powi(3));
            assert!((volume - 1.0).abs() < tolerance, "{radius} d: {volume}");
        }
    }
}

// Boundary layers

/// Which of the six planes of the box `half` the point lies on.
fn faces_at(x: Vec3, half: Vec3) -> [bool; 6] {
    let on = |value: f32, plane: f32| (value - plane).abs() < 1e-5;
    [on(x.x, -half.x), on(x.x, half.x), on(x.y, -half.y), on(x.y, half.y), on(x.z, -half.z), on(x.z, half.z)]
}

/// Points on the six faces of a box, on a grid finer than any spacing, edges and corners among them.
fn points_on_box(half: Vec3, steps: i32) -> Vec<Vec3> {
    let at = |i: i32| 2.0 * i as f32 / steps as f32 - 1.0;
    let mut points = Vec::new();
    for (i, j) in (0..=steps).flat_map(|i| (0..=steps).map(move |j| (i, j))) {
        for side in [-1.0, 1.0] {
            points.push(half * vec3(side, at(i), at(j)));
            points.push(half * vec3(at(i), side, at(j)));
            points.push(half * vec3(at(i), at(j), side));
        }
    }
    points
}

#[test]
fn a_closed_tank_is_covered_once_half_a_spacing_outside() {
    let d = 0.1;
    // The last is no whole number of spacings along any axis.
    for (half, count) in [(vec3(0.5, 0.3, 0.2), Some(12 * 8 * 6 - 10 * 6 * 4)), (vec3(0.43, 0.27, 0.31), None)] {
        let positions = sample_container(half, CLOSED, d).unwrap();
        let layer = half + 0.5 * d;
        assert!(count.is_none_or(|count| count == positions.len()), "{}", positions.len());
        // All on the layer, which is d/2 outside of the tank.
        assert!(positions.iter().all(|&x| faces_at(x, layer).contains(&true)));
        assert!((largest(&positions) - layer).length() < 1e-6);
        // Every edge and corner, and none twice. The step is 6/7 d or more for these.
        let closest = closest_pair(&positions);
        assert!(closest > 0.85 * d && closest < 1.01 * d, "{closest}");
        // A square of steps up to 8/7 d leaves its middle 0.81 d from a sample; of d, 0.71 d.
        for point in points_on_box(layer, 40) {
            assert!(nearest(&positions, point) < 0.81 * d, "{point}");
        }
        for corner in [layer, -layer, vec3(layer.x, -layer.y, layer.z)] {
            assert!(nearest(&positions, corner) < 1e-6);
        }
    }
}

#[test]
fn steps_are_the_closest_to_the_spacing() {
    // 2 half + d = 1.45 d: two steps of 0.725 d are closer to d than one of 1.45 d.
    let positions = sample_container(vec3(0.6, 0.255, 0.6), CLOSED, 1.0).unwrap();
    let mut heights: Vec<f32> = positions.iter().map(|x| x.y).collect();
    heights.sort_by(f32::total_cmp);
    heights.dedup();
    assert_eq!(heights.len(), 3, "{heights:?}");
}

#[test]
fn an_open_tank_ends_flush_with_its_rim() {
    let (half, d) = (vec3(0.5, 0.3, 0.2), 0.1);
    for face in 0..6 {
        let mut open = CLOSED;
        open[face] = true;
        let positions = sample_container(half, open, d).unwrap();
        let (axis, sign) = (face / 2, if face % 2 == 0 { -1.0 } else { 1.0 });
        // The other walls reach to half a spacing below the rim, on all sides of it.
        let rim: Vec<Vec3> = positions.iter().copied().filter(|x| x[axis] * sign > half[axis] - 0.51 * d).collect();
        assert!(rim.iter().all(|x| (x[axis] * sign - (half[axis] - 0.5 * d)).abs() < 1e-6));
        let nodes: Vec<usize> = (0..3).filter(|&i| i != axis).map(|i| (half[i] * 20.0).round() as usize + 2).collect();
        assert_eq!(rim.len(), 2 * (nodes[0] + nodes[1]) - 4, "face {face}");
        // The opposite wall is complete.
        let back = positions.iter().filter(|x| (x[axis] * sign + half[axis] + 0.5 * d).abs() < 1e-6).count();
        assert_eq!(back, nodes[0] * nodes[1]);
        assert!((closest_pair(&positions) - d).abs() < 1e-6);
    }
}

#[test]
fn tanks_with_several_open_faces() {
    let (half, d) = (vec3(0.5, 0.3, 0.2), 0.1);
    // A floor alone: all but -y, ending flush, as many as cells of the floor.
    let floor = sample_container(half, [true, true, false, true, true, true], d).unwrap();
    assert_eq!(floor.len(), 10 * 4);
    assert!(floor.iter().all(|x| (x.y + 0.35).abs() < 1e-6));
    assert!((largest(&floor) - vec3(0.45, 0.35, 0.15)).length() < 1e-6);
    // A wall across each axis: the same.
    assert_eq!(sample_container(half, [true, false, true, true, true, true], d).unwrap().len(), 6 * 4);
    assert_eq!(sample_container(half, [true, true, true, true, false, true], d).unwrap().len(), 10 * 6);
    // A channel along x: floor and two walls, 10 long, a floor of 6 and walls of 6 above it.
    let channel = sample_container(half, [true, true, false, true, false, false], d).unwrap();
    assert_eq!(channel.len(), 10 * (6 + 2 * 6));
    assert!((closest_pair(&channel) - d).abs() < 1e-6);
    // Nothing left.
    assert_eq!(sample_container(half, [true; 6], d).unwrap(), []);
    // A gap narrower than a spacing between two open faces is one row.
    assert_eq!(sample_container(vec3(0.03, 0.3, 0.2), [true, true, false, true, true, true], d).unwrap().len(), 4);
}

#[test]
fn a_tank_that_is_mostly_open_takes_no_time() {
    // 2e9 nodes along one axis, 5 along the others, and one wall across it left: only that one may be walked.
    let start = std::time::Instant::now();
    for (half, face) in [(vec3(1e6, 0.0025, 0.0025), 0), (vec3(0.0025, 1e6, 0.0025), 2), (vec3(0.0025, 0.0025, 1e6), 4)]
    {
        let mut open = [true; 6];
        open[face] = false;
        assert_eq!(sample_container(half, open, 0.001).unwrap().len(), 25);
    }
    // Microseconds; seconds for the shortest of the long ways.
    assert!(start.elapsed().as_millis() < 500, "{:?}", start.elapsed());
}

#[test]
fn a_box_body_is_covered_once_half_a_spacing_inside() {
    let d = 0.1;
    for (half, count) in [(vec3(0.5, 0.3, 0.2), Some(10 * 6 * 4 - 8 * 4 * 2)), (vec3(0.43, 0.27, 0.31), None)] {
        let positions = sample_box_surface(half, d).unwrap();
        let layer = half - 0.5 * d;
        assert!(count.is_none_or(|count| count == positions.len()), "{}", positions.len());
        assert!(positions.iter().all(|&x| faces_at(x, layer).contains(&true)));
        assert!((largest(&positions) - layer).length() < 1e-6);
        let closest = closest_pair(&positions);
        // Steps of 7.6/8 d, 4.4/4 d, 5.2/5 d.
        assert!(closest > 0.9 * d && closest < 1.01 * d, "{closest}");
        for point in points_on_box(layer, 40) {
            assert!(nearest(&positions, point) < 0.8 * d, "{point}");
        }
    }
    // As thin as it may be: one sample thick, and not two layers on one spot.
    assert_eq!(sample_box_surface(vec3(0.05, 0.25, 0.25), d).unwrap().len(), 25);
    assert_eq!(sample_box_surface(vec3(0.06, 0.25, 0.25), d).unwrap().len(), 25);
    assert_eq!(sample_box_surface(Vec3::splat(0.05), d).unwrap(), [Vec3::ZERO]);
    // A cube of two cells: its eight corners.
    assert_eq!(sample_box_surface(Vec3::splat(0.1), d).unwrap().len(), 8);
}

#[test]
fn a_ball_body_is_covered_evenly() {
    let d = 0.1;
    for radius in [0.05, 0.07, 0.08, 0.085, 0.09, 0.1, 0.11, 0.13, 0.15, 0.17, 0.2, 0.3, 0.45, 1.0] {
        let positions = sample_sphere_surface(radius, d).unwrap();
        let layer = radius - 0.5 * d;
        let expected = 4.0 * PI * (layer / d).powi(2);
        assert!(
            (positions.len() as f32 - expected).abs() <= 0.51 || positions.len() == 1,
            "{radius}: {}",
            positions.len()
        );
        if positions.len() > 1 {
            assert!(positions.iter().all(|x| (x.length() - layer).abs() < 1e-6), "radius {radius}");
        } else {
            assert_eq!(positions, [Vec3::ZERO]);
        }
        let closest = closest_pair(&positions);
        assert!(closest > 0.5 * d, "{radius}: {closest}");
        // 2000 directions or ten a sample, on another spiral; the point in the middle between them is a little farther.
        let tests = 2000.max(10 * positions.len());
        let farthest = (0..tests)
            .map(|i| {
                let z = 1.0 - (2.0 * i as f32 + 1.0) / tests as f32;
                let (sin, cos) = (i as f64 * 0.618_033_988_75 * std::f64::consts::TAU).sin_cos();
                let ring = (1.0 - z * z).sqrt();
                nearest(&positions, layer * vec3(ring * cos as f32, ring * sin as f32, z))
            })
            .fold(0.0, f32::max);
        assert!(farthest < 0.75 * d, "radius {radius}: {farthest}");
        // Even enough that the middle of all samples stays within a spacing of the centre, divided among them.
        assert!(mean(&positions).length() < d / positions.len() as f32 + 1e-6, "radius {radius}: {}", mean(&positions));
    }
}

#[test]
fn a_patch_of_wall_lies_behind_its_surface() {
    let d = 0.1;
    for normal in [Vec3::Y, Vec3::NEG_X, vec3(1.0, 2.0, -0.5), vec3(0.0, 0.0, -3e-20)] {
        let unit = normal.as_dvec3().normalize().as_vec3();
        let positions = sample_plane(normal, 0.5, 0.33, d).unwrap();
        // 10 and 6.6 parts; seven of 0.0943 are closer to d than six of 0.11.
        assert_eq!(positions.len(), 10 * 7);
        assert!(positions.iter().all(|x| (x.dot(unit) + 0.5 * d).abs() < 1e-6), "{normal}");
        assert!(mean(&positions).distance(-0.5 * d * unit) < 1e-6);
        assert!((closest_pair(&positions) - 0.66 / 7.0).abs() < 1e-6);
        // Flush: the outermost lie half a part within the patch.
        let (u, v) = unit.any_orthonormal_pair();
        let reach = |axis: Vec3| positions.iter().map(|x| x.dot(axis).abs()).fold(0.0, f32::max);
        assert!((reach(u) - 0.45).abs() < 1e-5 && (reach(v) - 0.33 * 6.0 / 7.0).abs() < 1e-5, "{normal}");
    }
}

// Volume weights

#[test]
fn weights_match_brute_force_and_follow_the_definition() {
    let kernel = Kernel::new(KernelKind::WendlandC2, 0.2).unwrap();
    // A tank away from the origin, at negative and positive cells, and a pair exactly one support radius apart.
    let mut positions = sample_container(vec3(0.5, 0.4, 0.3), CLOSED, 0.1).unwrap();
    positions.iter_mut().for_each(|x| *x += vec3(-0.13, 0.21, 0.077));
    positions.extend([vec3(5.0, 0.0, 0.0), vec3(5.2, 0.0, 0.0)]);
    let weights = volume_weights(&positions, &kernel, 0.78);
    for (b, &x_b) in positions.iter().enumerate() {
        let sum: f64 = positions.iter().map(|x_k| kernel.value(x_b.as_dvec3().distance(x_k.as_dvec3()))).sum();
        let expected = (0.78 / sum) as f32;
        // The order of summation only.
        assert!((weights[b] / expected - 1.0).abs() < 1e-6, "{b}");
    }
    let alone = (0.78 / kernel.value(0.0)) as f32;
    assert!((weights[positions.len() - 1] / alone - 1.0).abs() < 1e-6);
    // A corner has fewer neighbours than the middle of a face, so its samples stand for more.
    let corner = weights[0];
    assert!(weights[..positions.len() - 2].iter().all(|&weight| weight <= corner * 1.000_01));
}

#[test]
fn weights_do_not_depend_on_the_order_and_handle_few() {
    let kernel = Kernel::new(KernelKind::CubicSpline, 0.2).unwrap();
    assert_eq!(volume_weights(&[], &kernel, 0.7), []);
    let positions = sample_sphere_surface(0.4, 0.1).unwrap();
    let backwards: Vec<Vec3> = positions.iter().rev().copied().collect();
    let mut weights = volume_weights(&backwards, &kernel, 0.7);
    weights.reverse();
    for (a, b) in weights.iter().zip(volume_weights(&positions, &kernel, 0.7)) {
        assert!((a / b - 1.0).abs() < 1e-6);
    }
    // Two on one spot share its weight.
    let twice = volume_weights(&[Vec3::ZERO, Vec3::ZERO], &kernel, 0.7);
    let once = volume_weights(&[Vec3::ZERO], &kernel, 0.7);
    assert!((twice[0] * 2.0 / once[0] - 1.0).abs() < 1e-6 && twice[0] == twice[1]);
}

#[test]
fn a_hundred_thousand_samples_are_weighed_without_trouble() {
    let d = 0.01;
    let positions = sample_container(vec3(0.7, 0.6, 0.65), CLOSED, d).unwrap();
    assert!(positions.len() > 100_000);
    let kernel = Kernel::new(KernelKind::WendlandC2, 2.0 * d).unwrap();
    let start = std::time::Instant::now();
    // Such that a sample with all its neighbours, which are within H = 2 d, weighs d^3.
    let within: f64 =
        [(1.0, 0.0), (4.0, 1.0), (4.0, 2.0f64.sqrt())].map(|(n, r)| n * kernel.value(r * f64::from(d))).iter().sum();
    let weights = volume_weights(&positions, &kernel, f64::from(d).powi(3) * within);
    // 0.08 s on one core; comparing all pairs takes minutes.
    assert!(start.elapsed().as_secs() < 10, "{:?}", start.elapsed());
    assert!(weights.iter().all(|weight| *weight > 0.0));
    // In the middle of a face.
    let middle = positions.iter().position(|x| x.x < -0.7 && x.y.abs() < 0.1 && x.z.abs() < 0.1).unwrap();
    assert!((weights[middle] / d.powi(3) - 1.0).abs() < 1e-3, "{}", weights[middle]);
}

// Bad inputs

fn field<T: std::fmt::Debug>(result: Result<T, InvalidInput>) -> String {
    result.unwrap_err().field
}

#[test]
fn bad_numbers_are_refused_with_the_field() {
    let half = Vec3::splat(0.5);
    for bad in [f32::NAN, f32::INFINITY, 0.0, -0.1, 1e-30] {
        assert_eq!(field(sample_box(half, bad)), "spacing");
        assert_eq!(field(sample_sphere(0.5, bad)), "spacing");
        assert_eq!(field(sample_container(half, CLOSED, bad)), "spacing");
        assert_eq!(field(sample_box_surface(half, bad)), "spacing");
        assert_eq!(field(sample_sphere_surface(0.5, bad)), "spacing");
        assert_eq!(field(sample_plane(Vec3::Y, 0.5, 0.5, bad)), "spacing");

        assert_eq!(field(sample_box(vec3(0.5, bad, 0.5), 0.1)), "half_extents.y");
        assert_eq!(field(sample_container(vec3(0.5, 0.5, bad), CLOSED, 0.1)), "half_extents.z");
        assert_eq!(field(sample_box_surface(vec3(bad, 0.5, 0.5), 0.1)), "half_extents.x");
        assert_eq!(field(sample_sphere(bad, 0.1)), "radius");
        assert_eq!(field(sample_sphere_surface(bad, 0.1)), "radius");
        assert_eq!(field(sample_plane(Vec3::Y, bad, 0.5, 0.1)), "half_extent_u");
        assert_eq!(field(sample_plane(Vec3::Y, 0.5, bad, 0.1)), "half_extent_v");
    }
    for bad in [Vec3::ZERO, Vec3::NAN, vec3(0.0, f32::INFINITY, 0.0)] {
        assert_eq!(field(sample_plane(bad, 0.5, 0.5, 0.1)), "normal");
    }
}

#[test]
fn a_spacing_larger_than_the_shape_is_refused() {
    assert_eq!(field(sample_box(vec3(1.0, 1.0, 0.2), 1.0)), "half_extents.z");
    assert_eq!(field(sample_sphere(0.49, 1.0)), "radius");
    assert_eq!(field(sample_container(vec3(0.2, 1.0, 1.0), CLOSED, 1.0)), "half_extents.x");
    assert_eq!(field(sample_box_surface(vec3(1.0, 0.4, 1.0), 1.0)), "half_extents.y");
    assert_eq!(field(sample_sphere_surface(0.4, 1.0)), "radius");
    assert_eq!(field(sample_plane(Vec3::X, 1.0, 0.2, 1.0)), "half_extent_v");
    // The message tells what would do.
    let message = sample_sphere_surface(0.4, 1.0).unwrap_err().to_string();
    assert!(message.contains("0.4") && message.contains("0.5 m"), "{message}");
}

#[test]
fn too_many_samples_are_refused_before_they_are_made() {
    // 1e13 and more samples: taking the memory would fail the test by itself.
    let huge = Vec3::splat(1e6);
    assert_eq!(field(sample_box(huge, 1e-6)), "spacing");
    assert_eq!(field(count_box(huge, 1e-6)), "spacing");
    assert_eq!(field(sample_sphere(1e6, 1e-6)), "spacing");
    assert_eq!(field(sample_container(huge, CLOSED, 1e-6)), "spacing");
    assert_eq!(field(sample_box_surface(huge, 1e-6)), "spacing");
    assert_eq!(field(sample_sphere_surface(1e6, 1e-6)), "spacing");
    assert_eq!(field(sample_plane(Vec3::Y, 1e6, 1e6, 1e-6)), "spacing");
    // The limit itself, where only the count is asked for: 64 Mi is 1024 x 256 x 256.
    assert_eq!(count_box(vec3(512.0, 128.0, 128.0), 1.0).unwrap(), MAX_SAMPLES);
    let message = count_box(vec3(512.5, 128.0, 128.0), 1.0).unwrap_err().to_string();
    assert!(message.contains("67108864"), "{message}");
}
