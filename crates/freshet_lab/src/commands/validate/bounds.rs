//! `bounds.csv`: every bound that was judged, when, and how it came out.
//!
//! A full run takes an hour, so that cases are often run in parts: rows of cases that a run has not judged stay as they are.

use std::fs;
use std::io::ErrorKind;

use super::Job;
use crate::date::today;
use crate::error::LabError;
use crate::output::{Csv, Output};
use crate::verdict::{Verdict, short};

/// Name of the file.
pub const FILE: &str = "bounds.csv";

const COLUMNS: [&str; 8] = ["case", "backend", "form", "date", "check", "value", "bound", "kept"];

/// Rows of the runs of a case, each in its form.
#[derive(Clone, Debug, Default)]
pub struct Bounds {
    /// The first three cells of those judged, and their rows.
    judged: Vec<(String, Vec<String>)>,
}

impl Bounds {
    /// Adds what a run of a case found.
    pub fn add(&mut self, case: &str, job: &Job, verdict: &Verdict) {
        let options = job.body_options();
        let form = format!("{}{options}", if job.quick { "quick" } else { "full" });
        let (backend, date) = (job.backend.to_string(), today());
        let row = |check: &str, value: String, bound: String, kept: &str| {
            line(&[case, &backend, &form, &date, check, &value, &bound, kept])
        };
        let judged = verdict.checks.iter().map(|check| {
            let kept = if check.passes() { "yes" } else { "no" };
            row(
                &check.name,
                with_unit(short(check.value), check.unit),
                with_unit(check.bound.to_string(), check.unit),
                kept,
            )
        });
        let open = verdict.unmeasured.iter().map(|(name, unit, bound)| {
            row(name, "not measured".to_owned(), with_unit(bound.to_string(), unit), "open")
        });
        let key = line(&[case, &backend, &form]).trim_end().to_owned() + ",";
        self.judged.push((key, judged.chain(open).collect()));
    }

    /// Replaces the rows of what was judged in the file, or makes it.
    ///
    /// # Errors
    /// If the file cannot be read or written, or is not one of these.
    pub fn write(&self, output: &Output) -> Result<(), LabError> {
        let path = output.path(FILE);
        let before = match fs::read_to_string(&path) {
            Err(error) if error.kind() == ErrorKind::NotFound => String::new(),
            text => text.map_err(LabError::file(&path))?,
        };
        let comment =
            "Bounds of `cargo run --release -p freshet_lab -- validate`, each by the last run that judged it.";
        let head = Csv::new([comment], &COLUMNS);
        let mut old = before.lines().filter(|line| !line.starts_with('#'));
        if old.next().is_some_and(|columns| columns != COLUMNS.join(",")) {
            let reason =
                format!("{} is not a file of bounds: its columns are not {}", path.display(), COLUMNS.join(","));
            return Err(LabError::Argument { argument: "--out", reason });
        }
        let is_judged = |line: &str| self.judged.iter().any(|(key, _)| line.starts_with(key));
        let kept = old.filter(|line| !is_judged(line)).map(|line| format!("{line}\n"));
        let mut rows: Vec<String> = kept.chain(self.judged.iter().flat_map(|(_, rows)| rows.clone())).collect();
        // By case, backend and form; the checks of each in the order they were made.
        rows.sort_by_key(|row| row.splitn(4, ',').take(3).map(str::to_owned).collect::<Vec<_>>());
        output.write(FILE, &(head.text().to_owned() + &rows.concat())).map(|_| ())
    }
}

fn with_unit(value: String, unit: &str) -> String {
    format!("{value} {unit}").trim_end().to_owned()
}

/// A row of a CSV file.
fn line(cells: &[&str]) -> String {
    let mut csv = Csv::default();
    csv.row(cells);
    csv.text().to_owned()
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::afloat::BodyMethod;
    use crate::backend::Backend;
    use crate::verdict::Bound;

    #[test]
    fn a_run_replaces_its_own_rows_only() -> Result<(), LabError> {
        let folder = std::env::temp_dir().join(format!("freshet_lab_bounds_{}", std::process::id()));
        let output = Output::new(&folder)?;
        let job = |quick| Job {
            backend: Backend::Cpu,
            quick,
            threads: Default::default(),
            bodies: BodyMethod::default(),
            lockstep: false,
            output: output.clone(),
        };
        let found = |value| {
            let mut verdict = Verdict::default();
            verdict.check("a, b", value, "%", Bound::Below(2.0));
            verdict.leave_open("c", "", Bound::AtMost(1.0));
            verdict
        };
        for (case, quick, value) in
            [("gate", false, 1.0), ("gate-dfsph", false, 1.5), ("gate", true, 5.0), ("gate", false, 3.0)]
        {
            let mut bounds = Bounds::default();
            bounds.add(case, &job(quick), &found(value));
            bounds.write(&output)?;
        }
        let path = output.path(FILE);
        let text = fs::read_to_string(&path).map_err(LabError::file(&path))?;
        let rows: Vec<&str> = text.lines().skip(2).collect();
        assert_eq!(rows.len(), 6, "{text}");
        assert!(rows[0].starts_with("gate,cpu,full,2") && rows[0].ends_with(",\"a, b\",3 %,< 2 %,no"), "{text}");
        assert!(rows[1].ends_with(",c,not measured,<= 1,open"), "{text}");
        assert!(rows[2].starts_with("gate,cpu,quick,") && rows[4].starts_with("gate-dfsph,cpu,full,"), "{text}");

        output.write(FILE, "name,value\nx,1\n")?;
        let error = Bounds::default().write(&output).unwrap_err().to_string();
        assert!(error.contains("bounds.csv is not a file of bounds"), "{error}");
        fs::remove_dir_all(&folder).map_err(LabError::file(&folder))
    }
}
