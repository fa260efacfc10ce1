//! A small game: guide water through a mill wheel into a basin before the time is over.
//!
//! With a display: a window. Click a gate (or press its number) to open it, click elsewhere to place a crate. `--headless` plays without
//! one: `--autoplay` makes the moves that win, without it there are none. Levels are RON files in `assets/sluice`.
//! `cargo run --example sluice -- --help` lists the options.

mod arguments;
mod crates;
mod game;
mod gates;
mod headless;
mod hud;
mod level;
mod paint;
mod pointer;
mod site;
mod wheel;
mod window;

use std::process::ExitCode;

use arguments::Arguments;
use freshet_examples::arguments::{end, read, refuse};

fn main() -> ExitCode {
    let arguments: Arguments = match read(std::env::args_os()) {
        Ok(arguments) => arguments,
        Err(exit) => return exit,
    };
    let levels = match arguments.levels() {
        Ok(levels) => levels,
        Err(message) => return refuse(&message),
    };
    if arguments.headless {
        return end(headless::run(&arguments, levels));
    }
    end(match freshet_examples::window::open() {
        Ok(app) => window::run(app, &arguments, levels),
        Err(reason) => Err(format!("no display, try --headless: {reason}")),
    })
}
