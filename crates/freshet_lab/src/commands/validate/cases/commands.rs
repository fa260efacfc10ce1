//! Cases that are commands of their own: they write their own files and print their own tables.

use super::super::registry::{Case, Findings, Job};
use crate::commands::column::{self, ColumnArgs};
use crate::commands::dam_break::{self, DamBreakArgs};
use crate::commands::float::{self, FloatArgs};
use crate::error::LabError;
use crate::method::Method;
use crate::verdict::Verdict;

/// See [`column`].
pub const COLUMN: Case = Case {
    name: "column",
    about: "water at rest, 0.25 x 0.25 x 0.5 m: pressure, load, level and speed against hydrostatics",
    run: |job: &Job| {
        let (common, threads) = (job.options(), job.threads);
        found(column::run(&ColumnArgs { common, threads, seconds: None }))
    },
};

/// See [`dam_break`].
pub const DAM_BREAK: Case = Case {
    name: "dam-break",
    about: "front and height of a collapsing column against Martin & Moyce 1952 (n^2 = 1, 2) and Lobovsky et al. 2014",
    run: |job: &Job| {
        let (common, threads) = (job.options(), job.threads);
        found(dam_break::run(&DamBreakArgs { common, threads, resolutions: Vec::new(), method: Method::default() }))
    },
};

/// The same with the incompressible solver.
pub const DAM_BREAK_DFSPH: Case = Case {
    name: "dam-break-dfsph",
    about: "the same with divergence-free SPH",
    run: |job: &Job| {
        let (common, threads) = (job.options(), job.threads);
        let method = Method::DivergenceFree;
        found(dam_break::run(&DamBreakArgs { common, threads, resolutions: Vec::new(), method }))
    },
};

/// The same with the settings of a column at rest.
pub const DAM_BREAK_WATER: Case = Case {
    name: "dam-break-water",
    about: "the same with divergence-free SPH and water's viscosity alone, as in calm-dfsph, and against potential flow",
    run: |job: &Job| {
        let (common, threads) = (job.options(), job.threads);
        let method = Method::WaterAlone;
        found(dam_break::run(&DamBreakArgs { common, threads, resolutions: Vec::new(), method }))
    },
};

/// See [`float`].
pub const FLOAT: Case = Case {
    name: "float",
    about: "rapier ball of half the density of water: draft against Archimedes, heave, momentum ledger",
    run: |job: &Job| {
        let (common, threads) = (job.options(), job.threads);
        let method = Method::default();
        found(float::run(&FloatArgs { common, threads, sizes: Vec::new(), latency: Vec::new(), seconds: None, method }))
    },
};

fn found(verdict: Result<Verdict, LabError>) -> Result<Findings, LabError> {
    Ok(Findings { levels: Vec::new(), verdict: verdict? })
}
