//! A GPU device can get lost while an app runs: the driver is restarted, the card is pulled out.

use bevy::render::error_handler::{RenderErrorHandler, RenderErrorPolicy};
use bevy::render::renderer::RenderDevice;
use bevy_freshet::prelude::*;

use crate::harness::{ALL, Tank, TestApp, WATER};

#[test]
fn a_lost_device_is_a_problem_of_its_fluids_and_the_app_goes_on() {
    for mode in [FluidMode::Lockstep, FluidMode::Pipelined] {
        let mut test = TestApp::new();
        // By default Bevy ends the app.
        test.world().insert_resource(RenderErrorHandler(|_, _, _| RenderErrorPolicy::StopRendering));
        let lost = Tank::spawn(&mut test, (FluidBackend::Gpu, mode));
        let other = Tank::spawn(&mut test, ALL[0]);
        test.tick(4);
        test.expect_no_complaints();
        assert_eq!(test.stats(lost.domain).stopped, None);
        test.world().resource::<RenderDevice>().wgpu_device().destroy();
        let begin = std::time::Instant::now();
        test.tick(8);
        assert!(begin.elapsed().as_secs() < 5, "{mode:?}: the app hung for {:?}", begin.elapsed());
        let complaints = test.complaints();
        assert_eq!(complaints.len(), 1, "{mode:?}: {complaints:?}");
        assert_eq!((complaints[0].entity, complaints[0].component), (lost.domain, "FluidDomain"), "{mode:?}");
        assert!(complaints[0].message.contains("the fluid stopped: the device failed"), "{mode:?}: {complaints:?}");
        let stats = test.stats(lost.domain);
        let reason = stats.stopped.expect("it has stopped");
        assert!(complaints[0].message.ends_with(&reason), "{mode:?}: {reason} {complaints:?}");
        let stats = test.stats(other.domain);
        assert_eq!((stats.ticks, stats.particles, stats.stopped), (12, WATER, None), "{mode:?}");
        // On the CPU it starts again.
        test.change::<FluidDomain>(lost.domain, |domain| domain.backend = FluidBackend::Cpu);
        test.tick(2);
        let stats = test.settle(lost.domain);
        assert_eq!((stats.backend, stats.particles, stats.stopped), (FluidBackend::Cpu, WATER, None), "{mode:?}");
        test.expect_no_complaints();
    }
}
