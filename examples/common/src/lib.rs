//! What the examples share.
//!
//! - [`arguments`]: pieces of a command line.
//! - [`camera`]: a camera that turns around a point.
//! - [`daylight`]: sun, sky and ground.
//! - [`headless`]: an app without a window, its ticks and its pictures.
//! - [`tank`]: a glass tank.
//! - [`trouble`]: what went wrong, as the end of the program.
//! - [`window`]: an app with a window, if there is a display.

pub mod arguments;
pub mod camera;
pub mod daylight;
pub mod headless;
pub mod tank;
pub mod trouble;
pub mod window;
