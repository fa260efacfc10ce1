//! The laboratory of Freshet: simulations against measurements, charts of accuracy and speed.
//!
//! `cargo run --release -p freshet_lab -- --help` lists the commands. As a library it offers what they are made of:
//! [`reference`] holds the measurements, [`scenes`] what is simulated, [`drive`] runs a solver of any [`backend`] and keeps
//! account, [`measure`] turns particles into numbers, [`verdict`] holds them against their bounds.

pub mod afloat;
pub mod backend;
pub mod chart;
pub mod commands;
pub mod date;
pub mod drive;
pub mod error;
pub mod measure;
pub mod method;
pub mod options;
pub mod output;
pub mod progress;
pub mod reference;
pub mod scenes;
pub mod side_by_side;
pub mod table;
pub mod verdict;
