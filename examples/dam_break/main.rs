//! A column of water collapses in a tank, and two balls float away on it.
//!
//! With a display: a window (press H for the keys). Without: pictures, a summary and a plot in a folder. Without any GPU adapter,
//! even in software: the CPU simulates, and there is a summary and a plot. `cargo run --example dam_break -- --help` lists the options.

mod arguments;
mod camera;
mod controls;
mod cpu_only;
mod front;
mod headless;
mod panel;
mod plot;
mod scene;
mod stage;
mod summary;
mod trouble;
mod window;

use std::process::ExitCode;

use arguments::Arguments;
use scene::Setup;

fn main() -> ExitCode {
    let arguments = match Arguments::read(std::env::args_os()) {
        Ok(arguments) => arguments,
        Err(exit) => return exit,
    };
    let setup = match Setup::new(&arguments) {
        Ok(setup) => setup,
        Err(message) => return arguments::refuse(&message),
    };
    let wants_window = arguments.wants_window();
    if !wants_window && let Err(message) = arguments.make_folder() {
        return arguments::refuse(&message);
    }
    // Bevy's renderer gives up the whole app if there is none.
    let adapter = freshet_gpu::open_device(freshet_gpu::DeviceRequest::default());
    let result = match adapter {
        Err(error) => {
            eprintln!("no GPU adapter, so no pictures: {error}");
            cpu_only::run(&arguments, &setup)
        }
        Ok(_) if wants_window => window::run(&arguments, setup),
        Ok(_) => headless::run(&arguments, setup),
    };
    match result {
        Ok(()) => ExitCode::SUCCESS,
        Err(message) => {
            eprintln!("error: {message}");
            ExitCode::FAILURE
        }
    }
}
