//! A column of water collapses in a tank, and two balls float away on it.
//!
//! With a display: a window (press H for the keys). Without: pictures, a summary and a plot in a folder. Without any GPU adapter,
//! even in software: the CPU simulates, and there is a summary and a plot. `cargo run --example dam_break -- --help` lists the options.

mod arguments;
mod controls;
mod cpu_only;
mod front;
mod headless;
mod panel;
mod plot;
mod scene;
mod stage;
mod summary;
mod window;

use std::process::ExitCode;

use arguments::Arguments;
use bevy::app::App;
use freshet_examples::arguments::{end, read, refuse};
use freshet_examples::headless::find_adapter;
use scene::Setup;

fn main() -> ExitCode {
    let arguments: Arguments = match read(std::env::args_os()) {
        Ok(arguments) => arguments,
        Err(exit) => return exit,
    };
    let setup = match Setup::new(&arguments) {
        Ok(setup) => setup,
        Err(message) => return refuse(&message),
    };
    let window = if arguments.headless { None } else { open_window(&arguments) };
    if window.is_none()
        && let Err(message) = arguments.make_folder()
    {
        return refuse(&message);
    }
    end(match (find_adapter(), window) {
        (Err(error), _) => {
            eprintln!("no GPU adapter, so no pictures: {error}");
            cpu_only::run(&arguments, &setup)
        }
        (Ok(()), Some(app)) => window::run(app, &arguments, setup),
        (Ok(()), None) => headless::run(&arguments, setup),
    })
}

/// An app that can open windows, or a line that says why there are pictures instead.
fn open_window(arguments: &Arguments) -> Option<App> {
    let opened = freshet_examples::window::open();
    if let Err(reason) = &opened {
        eprintln!("no display, so pictures in {}: {reason}", arguments.out.display());
    }
    opened.ok()
}
