//! Golden pictures with a tolerance, and mutations that must each exceed it: a fluid as spheres, and as a surface.
//!
//! `FRESHET_WRITE_GOLDEN=1 cargo test --workspace -- golden` writes it anew, and fails, because it compares nothing; look at
//! the picture before you commit it.

use std::path::{Path, PathBuf};

use bevy::prelude::*;
use bevy::shader::Source;
use bevy_freshet::prelude::*;
use image::RgbImage;

use crate::harness::TestApp;

const SIZE: UVec2 = UVec2::new(320, 200);
const SPACING: f32 = 0.05;
/// Mean over pixels and channels of the difference, in 1/255. Drivers differ in rounding and at the edges of spheres, solvers in
/// the last digits of positions: on llvmpipe, the CPU solver's spheres differ by 0.03 and the GPU solver's by 0.04. The
/// mildest mutation, a surface without sun, makes 0.9.
const TOLERANCE: f64 = 0.5;

/// What is different from the golden picture.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
struct Change {
    empty: bool,
    shift: f32,
    dark: bool,
    wrong_depth: bool,
    style: FluidStyle,
    backend: FluidBackend,
}

/// The style of the other picture.
fn surface() -> Change {
    Change { style: FluidStyle::Surface { clarity: 0.3, smoothing: 3.0 }, ..default() }
}

/// A collapsing column in a tank, and a red box that cuts into it.
fn picture(change: Change) -> RgbImage {
    let mut test = TestApp::new();
    if change.wrong_depth {
        let mut shaders = test.world().resource_mut::<Assets<Shader>>();
        let mut impostors: Vec<_> =
            shaders.iter_mut().filter(|(_, shader)| shader.path.ends_with("impostor.wgsl")).collect();
        let (_, shader) = impostors.first_mut().expect("the impostor shader");
        let Source::Wgsl(text) = &shader.source else { panic!("it is WGSL") };
        // As if the quad's depth were the sphere's, a spacing further away.
        let wrong = text.replace("clip.z / clip.w)", "0.97 * clip.z / clip.w)");
        assert_ne!(&wrong, text.as_ref());
        shader.source = Source::Wgsl(wrong.into());
    }
    test.world().insert_resource(ClearColor(Color::srgb(0.75, 0.8, 0.85)));
    test.world().insert_resource(GlobalAmbientLight { brightness: 800.0, ..default() });
    if !change.dark {
        test.spawn((
            DirectionalLight { illuminance: 8_000.0, ..default() },
            Transform::default().looking_to(Vec3::new(-0.4, -1.0, -0.6), Vec3::Y),
        ));
    }
    let mesh = test.world().resource_mut::<Assets<Mesh>>().add(Cuboid::new(0.3, 0.5, 0.3));
    let material = StandardMaterial { base_color: Color::srgb(0.8, 0.1, 0.1), unlit: true, ..default() };
    let material = test.world().resource_mut::<Assets<StandardMaterial>>().add(material);
    test.spawn((Mesh3d(mesh), MeshMaterial3d(material), Transform::from_xyz(0.55, 0.25, 0.35)));

    let backend = if change.backend == FluidBackend::Gpu { FluidBackend::Gpu } else { FluidBackend::Cpu };
    let domain = test.spawn((
        FluidDomain::with_spacing(SPACING).on(backend).in_mode(FluidMode::Lockstep),
        FluidAppearance { interpolate: false, style: change.style, ..default() },
        Transform::from_xyz(change.shift, 0.0, 0.0),
    ));
    test.spawn((FluidContainer::open_box(1.2, 0.8, 0.5), Transform::from_xyz(0.6 + change.shift, 0.4, 0.25)));
    if !change.empty {
        test.spawn((
            FluidVolume::from(Cuboid::new(0.5, 0.6, 0.5)),
            Transform::from_xyz(0.25 + change.shift, 0.3, 0.25),
        ));
    }
    let eye = Vec3::new(1.2, 0.75, 1.4);
    let canvas =
        test.spawn_camera(SIZE, Transform::from_translation(eye).looking_at(Vec3::new(0.5, 0.25, 0.25), Vec3::Y));
    // Early enough that rounding has not grown into other splashes.
    test.tick(10);
    assert_eq!(test.stats(domain).ticks, if change.empty { 0 } else { 10 });
    test.expect_no_complaints();
    test.picture(&canvas)
}

fn golden_path(name: &str) -> PathBuf {
    Path::new(env!("CARGO_MANIFEST_DIR")).join(format!("tests/it/golden/{name}.png"))
}

fn difference(a: &RgbImage, b: &RgbImage) -> f64 {
    assert_eq!(a.dimensions(), b.dimensions());
    let sum: u64 = a.as_raw().iter().zip(b.as_raw()).map(|(a, b)| u64::from(a.abs_diff(*b))).sum();
    sum as f64 / a.as_raw().len() as f64
}

fn golden(name: &str) -> RgbImage {
    image::open(golden_path(name)).expect("the golden picture is in the repository").to_rgb8()
}

fn is_golden(name: &str, change: Change) {
    let drawn = picture(change);
    if std::env::var_os("FRESHET_WRITE_GOLDEN").is_some() {
        drawn.save(golden_path(name)).expect("the golden picture can be written");
        panic!("written to {}; run again without FRESHET_WRITE_GOLDEN", golden_path(name).display());
    }
    for (backend, drawn) in [("cpu", drawn), ("gpu", picture(Change { backend: FluidBackend::Gpu, ..change }))] {
        let difference = difference(&drawn, &golden(name));
        let place = std::env::temp_dir().join(format!("freshet_{name}_{backend}.png"));
        if difference > TOLERANCE {
            drawn.save(&place).expect("the picture can be written");
        }
        println!("{name}, {backend}: {difference:.3}");
        assert!(
            difference <= TOLERANCE,
            "{name}, {backend} differs by {difference:.3}, allowed: {TOLERANCE}; see {}",
            place.display()
        );
    }
}

fn each_exceeds_the_tolerance(name: &str, changes: &[Change]) {
    // The other test is writing it.
    assert!(std::env::var_os("FRESHET_WRITE_GOLDEN").is_none(), "run again without FRESHET_WRITE_GOLDEN");
    let golden = golden(name);
    for change in changes {
        let difference = difference(&picture(*change), &golden);
        println!("{change:?}: {difference:.3}");
        assert!(difference > TOLERANCE, "{change:?} differs by {difference:.3} only, tolerance: {TOLERANCE}");
    }
}

#[test]
fn the_picture_is_the_golden_one_on_both_backends() {
    is_golden("column", Change::default());
}

#[test]
fn a_surface_is_the_golden_one_on_both_backends() {
    is_golden("surface", surface());
}

#[test]
fn each_mutation_exceeds_the_golden_tolerance() {
    let changes = [
        Change { empty: true, ..default() },
        Change { shift: SPACING, ..default() },
        Change { dark: true, ..default() },
        Change { wrong_depth: true, ..default() },
    ];
    each_exceeds_the_tolerance("column", &changes);
}

#[test]
fn each_mutation_of_a_surface_exceeds_the_golden_tolerance() {
    let changes = [
        Change { empty: true, ..surface() },
        Change { shift: SPACING, ..surface() },
        Change { dark: true, ..surface() },
        // Lumps, and milk.
        Change { style: FluidStyle::Surface { clarity: 0.3, smoothing: 0.0 }, ..default() },
        Change { style: FluidStyle::Surface { clarity: 0.03, smoothing: 3.0 }, ..default() },
    ];
    each_exceeds_the_tolerance("surface", &changes);
}
