//! Bodies of any shape and density in a pool: drop them with the mouse, drag them, see what the water does to them.
//!
//! With a display: a window. Left button: drop, or drag what is there; right button: turn; wheel: come closer. `--headless`: a body of
//! each shape is dropped, and figures of how they float are printed. `cargo run --example floating_bodies -- --help` lists the options.

mod arguments;
mod bodies;
mod figures;
mod headless;
mod panel;
mod pointer;
mod pool;
mod shape;
mod window;

use std::process::ExitCode;

use arguments::Arguments;
use freshet_examples::arguments::{end, read};

fn main() -> ExitCode {
    let arguments: Arguments = match read(std::env::args_os()) {
        Ok(arguments) => arguments,
        Err(exit) => return exit,
    };
    if arguments.headless {
        return end(headless::run(&arguments));
    }
    end(match freshet_examples::window::open() {
        Ok(app) => window::run(app, &arguments),
        Err(reason) => Err(format!("no display, try --headless: {reason}")),
    })
}
