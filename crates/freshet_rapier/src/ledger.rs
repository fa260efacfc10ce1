//! Book-keeping of momentum between fluid and rapier, in double precision.

use freshet_core::step::Impulse;
use glam::DVec3;

/// A sum of impulses.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct Momentum {
    /// N s, world axes.
    pub linear: DVec3,
    /// N m s about the centre of mass, world axes.
    pub angular: DVec3,
}

impl Momentum {
    /// Adds an impulse.
    pub fn add(&mut self, impulse: Impulse) {
        self.linear += impulse.linear.as_dvec3();
        self.angular += impulse.angular.as_dvec3();
    }
}

impl std::ops::Add for Momentum {
    type Output = Self;
    fn add(self, other: Self) -> Self {
        Self { linear: self.linear + other.linear, angular: self.angular + other.angular }
    }
}

impl std::ops::Sub for Momentum {
    type Output = Self;
    fn sub(self, other: Self) -> Self {
        Self { linear: self.linear - other.linear, angular: self.angular - other.angular }
    }
}

/// What the fluid delivered to a body and what rapier's body got of it.
///
/// `delivered + advanced - given - held` is zero but for rounding; with nothing in flight `advanced` is zero.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct Ledger {
    /// Sum of the fluid's true impulses that have arrived.
    pub delivered: Momentum,
    /// Forecasts of ticks whose true impulse has not arrived, as far as they have been applied.
    pub advanced: Momentum,
    /// Change of the body's momentum by the coupling, measured on its velocities before and after each call.
    pub given: Momentum,
    /// What a body could not take because it was asleep, locked or not dynamic, and what of late impulses the forecasts had too little or too much while
    /// something that stands fast held it.
    pub held: Momentum,
    /// Sum of the magnitudes of the delivered linear impulses, N s: the scale for [`imbalance`](Self::imbalance).
    pub exchanged: f64,
}

impl Ledger {
    /// `delivered + advanced - given - held`: zero but for rounding.
    pub fn imbalance(&self) -> Momentum {
        self.delivered + self.advanced - self.given - self.held
    }

    /// The linear imbalance over the sum of all impulses exchanged; zero before the first.
    pub fn relative_imbalance(&self) -> f64 {
        if self.exchanged > 0.0 { self.imbalance().linear.length() / self.exchanged } else { 0.0 }
    }

    pub(crate) fn deliver(&mut self, impulse: Impulse) {
        self.delivered.add(impulse);
        self.exchanged += impulse.linear.as_dvec3().length();
    }

    /// Books a forecast that has been applied before its true impulse is known.
    pub(crate) fn advance(&mut self, forecast: Impulse) {
        self.advanced.add(forecast);
    }

    /// Books that the true impulse of an advanced forecast has come.
    pub(crate) fn withdraw(&mut self, forecast: Impulse) {
        let mut sum = Momentum::default();
        sum.add(forecast);
        self.advanced = self.advanced - sum;
    }
}
