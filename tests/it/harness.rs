//! One harness for headless apps: pumps until pipelines are ready, fails on a shader error and when the app wants to exit.

use std::sync::OnceLock;

use bevy::app::{PluginsState, TaskPoolOptions};
use bevy::camera::RenderTarget;
use bevy::log::LogPlugin;
use bevy::prelude::*;
use bevy::render::pipelined_rendering::PipelinedRenderingPlugin;
use bevy::render::render_resource::{CachedPipelineState, PipelineCache, TextureFormat};
use bevy::render::view::screenshot::{Screenshot, ScreenshotCaptured};
use bevy::render::{RenderApp, RenderPlugin};
use bevy::shader::{ShaderCacheError, ValidateShader};
use bevy::time::TimeUpdateStrategy;
use bevy::window::ExitCondition;
use bevy::winit::WinitPlugin;
use bevy_freshet::prelude::*;

/// Every backend in every mode.
pub const ALL: [(FluidBackend, FluidMode); 4] = [
    (FluidBackend::Cpu, FluidMode::Lockstep),
    (FluidBackend::Cpu, FluidMode::Pipelined),
    (FluidBackend::Gpu, FluidMode::Lockstep),
    (FluidBackend::Gpu, FluidMode::Pipelined),
];

/// Updates until pipelines must be ready.
const PATIENCE: u32 = 500;

/// What the fluid complained of.
#[derive(Resource, Default)]
struct Complaints(Vec<FluidProblem>);

/// The last picture.
#[derive(Resource, Default)]
struct Picture(Option<image::RgbImage>);

/// A headless app with fluids.
pub struct TestApp {
    app: App,
}

impl TestApp {
    /// An app that has no entities yet, whose fixed step is 1/64 s.
    pub fn new() -> Self {
        Self::with(|_| {})
    }

    /// The same with something done after Bevy's plugins and before Freshet's.
    pub fn with(change: impl FnOnce(&mut App)) -> Self {
        static ADAPTER: OnceLock<Result<(), String>> = OnceLock::new();
        let adapter = ADAPTER.get_or_init(|| {
            let device = freshet_gpu::open_device(freshet_gpu::DeviceRequest::default());
            device.map(|_| ()).map_err(|error| error.to_string())
        });
        if let Err(error) = adapter {
            // Bevy would panic without saying what to do.
            panic!("install mesa-vulkan-drivers libvulkan1: {error}");
        }
        let mut app = App::new();
        app.add_plugins(
            DefaultPlugins
                .set(WindowPlugin { primary_window: None, exit_condition: ExitCondition::DontExit, ..default() })
                .set(RenderPlugin { synchronous_pipeline_compilation: true, ..default() })
                // All apps of this process share them. One that waits for its fluid in a system must not hold up the others.
                .set(TaskPoolPlugin { task_pool_options: TaskPoolOptions::with_num_threads(8) })
                .disable::<LogPlugin>()
                .disable::<WinitPlugin>()
                .disable::<PipelinedRenderingPlugin>(),
        );
        change(&mut app);
        app.add_plugins(FreshetPlugins::default())
            .insert_resource(TimeUpdateStrategy::FixedTimesteps(0))
            .init_resource::<Complaints>()
            .init_resource::<Picture>()
            .add_systems(Last, |mut messages: MessageReader<FluidProblem>, mut complaints: ResMut<Complaints>| {
                complaints.0.extend(messages.read().cloned());
            });
        while app.plugins_state() == PluginsState::Adding {
            std::thread::yield_now();
        }
        app.finish();
        app.cleanup();
        let mut test = Self { app };
        // Bounds are checked: software drivers swallow what is written outside.
        let mut shaders = test.app.world_mut().resource_mut::<Assets<Shader>>();
        for (_, shader) in shaders.iter_mut().filter(|(_, shader)| shader.path.starts_with("freshet/")) {
            shader.validate_shader = ValidateShader::Enabled;
        }
        // The first update has no duration.
        test.update();
        test
    }

    /// The world.
    pub fn world(&mut self) -> &mut World {
        self.app.world_mut()
    }

    /// The renderer's world.
    pub fn render_world(&self) -> &World {
        self.app.sub_app(RenderApp).world()
    }

    /// Spawns.
    pub fn spawn(&mut self, bundle: impl Bundle) -> Entity {
        self.world().spawn(bundle).id()
    }

    /// Despawns.
    pub fn despawn(&mut self, entity: Entity) {
        self.world().despawn(entity);
    }

    /// Changes a component.
    pub fn change<C: Component<Mutability = bevy::ecs::component::Mutable>>(
        &mut self,
        entity: Entity,
        change: impl FnOnce(&mut C),
    ) {
        change(&mut self.world().get_mut::<C>(entity).expect("the entity has the component"));
    }

    /// One update, with as many fixed ticks as are due.
    pub fn update(&mut self) {
        self.app.update();
        assert!(self.app.should_exit().is_none(), "the app wants to exit: the renderer failed");
        let Some(render) = self.app.get_sub_app(RenderApp) else { return };
        let cache = render.world().resource::<PipelineCache>();
        for pipeline in cache.pipelines() {
            if let CachedPipelineState::Err(error) = &pipeline.state {
                let is_final =
                    matches!(error, ShaderCacheError::ProcessShaderError(_) | ShaderCacheError::CreateShaderModule(_));
                assert!(!is_final, "a shader is wrong: {error:?}");
            }
        }
    }

    /// So many fixed ticks, one an update.
    pub fn tick(&mut self, ticks: u32) {
        self.world().insert_resource(TimeUpdateStrategy::FixedTimesteps(1));
        for _ in 0..ticks {
            self.update();
        }
        self.world().insert_resource(TimeUpdateStrategy::FixedTimesteps(0));
    }

    /// Statistics of a domain after everything sent is known.
    pub fn settle(&mut self, domain: Entity) -> FluidStats {
        // Switching to lockstep waits in the next tick; afterwards it is as before.
        let mode = self.world().get::<FluidDomain>(domain).expect("a domain").mode;
        self.change::<FluidDomain>(domain, |domain| domain.mode = FluidMode::Lockstep);
        self.tick(1);
        self.change::<FluidDomain>(domain, |domain| domain.mode = mode);
        self.stats(domain)
    }

    /// Statistics of a domain.
    pub fn stats(&mut self, domain: Entity) -> FluidStats {
        self.world().get::<FluidStats>(domain).expect("a domain has statistics").clone()
    }

    /// What the fluid complained of since the last call.
    pub fn complaints(&mut self) -> Vec<FluidProblem> {
        std::mem::take(&mut self.world().resource_mut::<Complaints>().0)
    }

    /// Fails if the fluid has complained.
    pub fn expect_no_complaints(&mut self) {
        let complaints = self.complaints();
        assert!(complaints.is_empty(), "{complaints:?}");
    }

    /// A camera that draws to an image of this size.
    pub fn spawn_camera(&mut self, size: UVec2, pose: Transform) -> Handle<Image> {
        let image = Image::new_target_texture(size.x, size.y, TextureFormat::Rgba8UnormSrgb, None);
        let canvas = self.world().resource_mut::<Assets<Image>>().add(image);
        self.spawn((Camera3d::default(), RenderTarget::Image(canvas.clone().into()), pose));
        canvas
    }

    /// What a camera sees, once its pipelines are ready.
    pub fn picture(&mut self, canvas: &Handle<Image>) -> image::RgbImage {
        for _ in 0..3 {
            self.update();
        }
        let mut patience = PATIENCE;
        while self.is_compiling() {
            self.update();
            patience = patience.checked_sub(1).expect("pipelines become ready");
        }
        self.world().spawn(Screenshot::image(canvas.clone())).observe(
            |captured: On<ScreenshotCaptured>, mut picture: ResMut<Picture>| {
                picture.0 = captured.image.clone().try_into_dynamic().ok().map(|image| image.to_rgb8());
            },
        );
        for _ in 0..PATIENCE {
            self.update();
            if let Some(picture) = self.world().resource_mut::<Picture>().0.take() {
                return picture;
            }
        }
        panic!("no picture came");
    }

    fn is_compiling(&self) -> bool {
        let Some(render) = self.app.get_sub_app(RenderApp) else { return false };
        render.world().resource::<PipelineCache>().waiting_pipelines().next().is_some()
    }
}

/// A tank with a block of water of 5 x 4 x 5 = 100 particles in it.
pub struct Tank {
    /// The domain.
    pub domain: Entity,
    /// The water.
    pub water: Entity,
    /// The tank.
    pub tank: Entity,
}

/// Particles of [`Tank::water`].
pub const WATER: u32 = 100;

impl Tank {
    /// Spawns it; nothing is ambiguous even with several.
    pub fn spawn(test: &mut TestApp, (backend, mode): (FluidBackend, FluidMode)) -> Self {
        let domain = test.spawn(FluidDomain::with_spacing(0.1).on(backend).in_mode(mode));
        let member = FluidInDomain(domain);
        let water =
            test.spawn((FluidVolume::from(Cuboid::new(0.5, 0.4, 0.5)), Transform::from_xyz(0.25, 0.2, 0.25), member));
        let tank = test.spawn((FluidContainer::open_box(1.0, 1.0, 0.5), Transform::from_xyz(0.5, 0.5, 0.25), member));
        Self { domain, water, tank }
    }
}
