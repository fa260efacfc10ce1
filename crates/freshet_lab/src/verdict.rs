//! What a command found, against its bounds: decides the exit code.

use crate::table::Table;

/// One number and what it may be.
#[derive(Clone, Debug, PartialEq)]
pub struct Check {
    /// What was measured, with case and backend.
    pub name: String,
    /// The measured value.
    pub value: f64,
    /// What it may be.
    pub bound: Bound,
    /// Unit of value and bound, for the table.
    pub unit: &'static str,
}

/// What a value may be. Not-a-number is never allowed.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum Bound {
    /// At most this.
    AtMost(f64),
    /// Less than this.
    Below(f64),
    /// At least this.
    AtLeast(f64),
    /// From the first to the second.
    Within(f64, f64),
}

impl Bound {
    /// Whether `value` is allowed.
    pub fn holds(self, value: f64) -> bool {
        match self {
            Bound::AtMost(most) => value <= most,
            Bound::Below(limit) => value < limit,
            Bound::AtLeast(least) => value >= least,
            Bound::Within(least, most) => (least..=most).contains(&value),
        }
    }
}

impl std::fmt::Display for Bound {
    fn fmt(&self, f: &mut std::fmt::Formatter<'_>) -> std::fmt::Result {
        match *self {
            Bound::AtMost(most) => write!(f, "<= {}", short(most)),
            Bound::Below(limit) => write!(f, "< {}", short(limit)),
            Bound::AtLeast(least) => write!(f, ">= {}", short(least)),
            Bound::Within(least, most) => write!(f, "{} to {}", short(least), short(most)),
        }
    }
}

/// Four significant digits, without trailing zeros.
pub(crate) fn short(value: f64) -> String {
    if value == 0.0 || !value.is_finite() {
        return value.to_string();
    }
    let decimals = (3 - value.abs().log10().floor() as i32).clamp(0, 12) as usize;
    let text = format!("{value:.decimals$}");
    if text.contains('.') { text.trim_end_matches('0').trim_end_matches('.').to_owned() } else { text }
}

impl Check {
    /// A value with the bound it has to keep.
    pub fn new(name: impl Into<String>, value: f64, unit: &'static str, bound: Bound) -> Self {
        Self { name: name.into(), value, bound, unit }
    }

    /// Whether the bound is kept.
    pub fn passes(&self) -> bool {
        self.bound.holds(self.value)
    }
}

/// All checks of a command.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct Verdict {
    /// In the order they were made.
    pub checks: Vec<Check>,
    /// What was not measured, and the bound it would have to keep: neither kept nor missed.
    pub unmeasured: Vec<(String, &'static str, Bound)>,
}

impl Verdict {
    /// Adds a check.
    pub fn check(&mut self, name: impl Into<String>, value: f64, unit: &'static str, bound: Bound) {
        self.checks.push(Check::new(name, value, unit, bound));
    }

    /// Says of a bound that what it is about was not measured.
    pub fn leave_open(&mut self, name: impl Into<String>, unit: &'static str, bound: Bound) {
        self.unmeasured.push((name.into(), unit, bound));
    }

    /// Those that missed their bound.
    pub fn missed(&self) -> impl Iterator<Item = &Check> {
        self.checks.iter().filter(|check| !check.passes())
    }

    /// Whether every bound is kept.
    pub fn passes(&self) -> bool {
        self.checks.iter().all(Check::passes)
    }
}

impl std::fmt::Display for Verdict {
    fn fmt(&self, f: &mut std::fmt::Formatter<'_>) -> std::fmt::Result {
        let mut table = Table::new(["check", "value", "bound", ""]);
        for check in &self.checks {
            table.row([
                check.name.clone(),
                format!("{} {}", short(check.value), check.unit).trim_end().to_owned(),
                format!("{} {}", check.bound, check.unit).trim_end().to_owned(),
                if check.passes() { "ok".to_owned() } else { "MISSED".to_owned() },
            ]);
        }
        for (name, unit, bound) in &self.unmeasured {
            let bound = format!("{bound} {unit}");
            table.row([name.clone(), "not measured".to_owned(), bound.trim_end().to_owned(), "open".to_owned()]);
        }
        write!(f, "{table}")?;
        let missed = self.missed().count();
        match missed {
            0 => write!(f, "all {} bounds kept", self.checks.len()),
            _ => write!(f, "{missed} of {} bounds MISSED", self.checks.len()),
        }?;
        match self.unmeasured.len() {
            0 => Ok(()),
            open => write!(f, ", {open} not measured"),
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn bounds_hold_at_their_ends_and_never_for_nan() {
        assert!(Bound::AtMost(5.0).holds(5.0) && !Bound::AtMost(5.0).holds(5.0001));
        assert!(!Bound::Below(5.0).holds(5.0) && Bound::Below(5.0).holds(4.9999));
        assert!(Bound::AtLeast(1.7).holds(1.7) && !Bound::AtLeast(1.7).holds(1.69));
        assert!(Bound::Within(0.0, 1.0).holds(1.0) && !Bound::Within(0.0, 1.0).holds(-0.1));
        for bound in [Bound::AtMost(1.0), Bound::Below(1.0), Bound::AtLeast(-1.0), Bound::Within(-1.0, 1.0)] {
            assert!(!bound.holds(f64::NAN), "{bound}");
        }
    }

    #[test]
    fn one_miss_fails_the_verdict_and_is_named() {
        let mut verdict = Verdict::default();
        verdict.check("kept", 1.0, "%", Bound::AtMost(2.0));
        assert!(verdict.passes());
        verdict.check("lost", 3.0, "%", Bound::AtMost(2.0));
        assert!(!verdict.passes());
        assert_eq!(verdict.missed().map(|check| check.name.as_str()).collect::<Vec<_>>(), ["lost"]);
        let text = verdict.to_string();
        assert!(text.contains("MISSED") && text.contains("1 of 2 bounds"), "{text}");
    }

    #[test]
    fn what_was_not_measured_is_named_and_neither_kept_nor_missed() {
        let mut verdict = Verdict::default();
        verdict.check("kept", 1.0, "%", Bound::AtMost(2.0));
        verdict.leave_open("skipped", "ns", Bound::AtMost(150.0));
        assert!(verdict.passes());
        let text = verdict.to_string();
        let line = text.lines().find(|line| line.contains("skipped")).unwrap_or_default();
        assert!(line.contains("not measured") && line.contains("<= 150 ns") && !line.contains("ok"), "{text}");
        assert!(text.ends_with("all 1 bounds kept, 1 not measured"), "{text}");
    }

    #[test]
    fn numbers_are_short() {
        assert_eq!(short(4905.0), "4905");
        assert_eq!(short(0.050_04), "0.05004");
        assert_eq!(short(8.0), "8");
        assert_eq!(short(0.0), "0");
        assert_eq!(short(127_360.4), "127360");
    }
}
