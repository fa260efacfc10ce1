//! How many particles the buffers have room for: grows by doubling, shrinks by halving.

/// Room below which buffers do not shrink.
const LEAST: u32 = 1024;

/// Room at the start: the particles of the plan and an eighth more.
pub(crate) fn initial_capacity(start: u32, most: u32) -> u32 {
    (start + start / 8).max(LEAST).min(most)
}

/// The room for `bound` particles, no fewer than there can be, when there is room for `capacity`.
pub(crate) fn fitting_capacity(capacity: u32, bound: u32, most: u32) -> u32 {
    let mut fitting = capacity;
    while fitting < bound && fitting < most {
        fitting = fitting.saturating_mul(2).min(most);
    }
    if bound < fitting / 4 {
        fitting = (fitting / 2).max(LEAST.min(most));
    }
    fitting
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn doubles_up_to_the_most_and_halves_below_a_quarter() {
        assert_eq!(initial_capacity(8000, 8000), 8000);
        assert_eq!(initial_capacity(8000, 100_000), 9000);
        assert_eq!(fitting_capacity(1000, 1001, 100_000), 2000);
        assert_eq!(fitting_capacity(1000, 7000, 5000), 5000);
        assert_eq!(fitting_capacity(8000, 2000, 8000), 8000);
        assert_eq!(fitting_capacity(8000, 1999, 8000), 4000);
        assert_eq!(fitting_capacity(LEAST, 0, 8000), LEAST);
        assert_eq!(fitting_capacity(500, 0, 500), 500);
    }
}
