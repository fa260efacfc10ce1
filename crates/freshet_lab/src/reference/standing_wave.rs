//! Small standing waves on inviscid water of one depth (Airy 1845; Lamb, Hydrodynamics, 6th ed. 1932, § 228).

/// Angular frequency, 1/s, of a wavenumber, 1/m, on water `depth` m deep: `omega^2 = g k tanh(k D)`.
pub fn frequency(gravity: f64, wavenumber: f64, depth: f64) -> f64 {
    (gravity * wavenumber * (wavenumber * depth).tanh()).sqrt()
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn deep_and_shallow_water_are_its_limits() {
        assert!((frequency(9.81, 2.0, 100.0).powi(2) - 9.81 * 2.0).abs() < 1e-9);
        let shallow = frequency(9.81, 0.01, 1.0) / 0.01;
        assert!((shallow - 9.81_f64.sqrt()).abs() < 1e-3, "{shallow} m/s");
    }
}
