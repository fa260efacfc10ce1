//! A half-submerged sphere that heaves in an endless sea: Hulme 1982, J. Fluid Mech. 121, 443, table 1; second-hand, not compared with the paper.

/// `K a` (with `K = omega^2 / g` and the radius `a`), and the added mass over `2/3 pi rho a^3`.
const ADDED_MASS: [(f64, f64); 12] = [
    (0.4, 0.6452),
    (0.5, 0.5861),
    (0.6, 0.5381),
    (0.7, 0.4999),
    (0.8, 0.4698),
    (0.9, 0.4464),
    (1.0, 0.4284),
    (1.2, 0.4047),
    (1.4, 0.3924),
    (1.6, 0.3871),
    (1.8, 0.3864),
    (2.0, 0.3884),
];

/// The added mass at a `K a` from 0.4 to 2, a straight line between the table's.
pub fn added_mass(wave_number: f64) -> f64 {
    let after = ADDED_MASS.partition_point(|&(at, _)| at < wave_number).clamp(1, ADDED_MASS.len() - 1);
    let ((low, from), (high, to)) = (ADDED_MASS[after - 1], ADDED_MASS[after]);
    from + (to - from) * (wave_number - low) / (high - low)
}

/// Period of the free heave, s, of a sphere of half the fluid's density and this radius, m: `K a (1 + mu(K a)) = 3/2`. Its waves damp it by a
/// few per cent of critical, which changes the period by less than a thousandth.
pub fn heave_period(radius: f64, gravity: f64) -> f64 {
    let mut wave_number = 1.0;
    for _ in 0..60 {
        wave_number = 1.5 / (1.0 + added_mass(wave_number));
    }
    std::f64::consts::TAU / (wave_number * gravity / radius).sqrt()
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_period_solves_its_equation() {
        let wave_number = (std::f64::consts::TAU / heave_period(0.15, 9.81)).powi(2) * 0.15 / 9.81;
        assert!((wave_number * (1.0 + added_mass(wave_number)) - 1.5).abs() < 1e-9);
        assert!((wave_number - 1.055).abs() < 1e-3, "{wave_number}");
        assert_eq!(added_mass(1.0), 0.4284);
    }
}
