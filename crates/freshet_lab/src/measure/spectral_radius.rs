//! Largest absolute eigenvalue of small matrices.
//!
//! Schur and Cohn tell of a polynomial whether all its roots lie within a circle without finding any: nothing has to converge. Marden, Geometry of
//! Polynomials, 1966, section 42. Roots that coincide have fewer digits, as always: double ones on the circle five.

/// Rows and columns that matrices here have room for.
pub const ROOM: usize = 4;

/// Whether the eigenvalues of the first `len` rows and columns all lie within a circle of this radius about zero.
pub fn is_within(matrix: &[[f64; ROOM]; ROOM], len: usize, radius: f64) -> bool {
    let mut polynomial = characteristic(matrix, len);
    let mut scale = 1.0;
    for coefficient in &mut polynomial {
        *coefficient *= scale;
        scale *= radius;
    }
    roots_are_in_the_unit_circle(polynomial, len)
}

/// The largest absolute value of an eigenvalue of the first `len` rows and columns, to twelve digits where eigenvalues are apart.
pub fn spectral_radius(matrix: &[[f64; ROOM]; ROOM], len: usize) -> f64 {
    let row = |row: &[f64; ROOM]| row[..len].iter().map(|value| value.abs()).sum::<f64>();
    let (mut low, mut high) = (0.0, matrix[..len].iter().map(row).fold(0.0, f64::max) * 1.001 + f64::MIN_POSITIVE);
    while high - low > 1e-12 * high {
        let middle = 0.5 * (low + high);
        if is_within(matrix, len, middle) { high = middle } else { low = middle }
    }
    high
}

/// Coefficients of `det(z - M)`, the lowest power first (Faddeev and LeVerrier).
fn characteristic(matrix: &[[f64; ROOM]; ROOM], len: usize) -> [f64; ROOM + 1] {
    let mut polynomial = [0.0; ROOM + 1];
    polynomial[len] = 1.0;
    let mut power = [[0.0; ROOM]; ROOM];
    for k in 1..=len {
        let mut next = [[0.0; ROOM]; ROOM];
        for (i, row) in power.iter_mut().enumerate().take(len) {
            row[i] += polynomial[len + 1 - k];
        }
        for (i, row) in next.iter_mut().enumerate().take(len) {
            for (j, entry) in row.iter_mut().enumerate().take(len) {
                *entry = (0..len).map(|l| matrix[i][l] * power[l][j]).sum();
            }
        }
        power = next;
        polynomial[len - k] = -(0..len).map(|i| power[i][i]).sum::<f64>() / k as f64;
    }
    polynomial
}

fn roots_are_in_the_unit_circle(mut polynomial: [f64; ROOM + 1], degree: usize) -> bool {
    for degree in (1..=degree).rev() {
        let (first, last) = (polynomial[0], polynomial[degree]);
        if first.abs() >= last.abs() {
            return false;
        }
        // Of one degree less: it has as many roots in the circle as this one has there, less one.
        let whole = polynomial;
        let size = whole[..=degree].iter().fold(0.0, |size: f64, value| size.max(value.abs()));
        for k in 0..degree {
            polynomial[k] = (last * whole[k + 1] - first * whole[degree - k - 1]) / (size * size);
        }
    }
    true
}

#[cfg(test)]
mod tests {
    use super::*;

    /// The companion matrix of `z^n - c[n-1] z^(n-1) - ... - c[0]`.
    fn companion<const N: usize>(last_row: [f64; N]) -> [[f64; ROOM]; ROOM] {
        let mut matrix = [[0.0; ROOM]; ROOM];
        for row in 0..N - 1 {
            matrix[row][row + 1] = 1.0;
        }
        matrix[N - 1][..N].copy_from_slice(&last_row);
        matrix
    }

    fn assert_radius(matrix: &[[f64; ROOM]; ROOM], len: usize, expected: f64) {
        let found = spectral_radius(matrix, len);
        assert!((found - expected).abs() < 1e-11 * expected, "{found}, not {expected}: {matrix:?}");
    }

    #[test]
    fn radii_are_those_of_known_roots() {
        // A rotation by 90 degrees and growth by 1.2; (z - 2)(z + 3); (z - 0.5)(z - 0.25)(z + 0.125).
        assert_radius(&companion([-1.44, 0.0]), 2, 1.2);
        assert_radius(&companion([6.0, -1.0]), 2, 3.0);
        assert_radius(&companion([-0.015625, -0.03125, 0.625]), 3, 0.5);
        // z^2 (z^2 - 2 cos(1) z + 1): two at zero, two on the circle.
        assert_radius(&companion([0.0, 0.0, -1.0, 2.0 * 1.0_f64.cos()]), 4, 1.0);
        assert!(spectral_radius(&[[0.0; ROOM]; ROOM], 4) < 1e-100);
    }

    /// `(z + 1)^2`.
    #[test]
    fn double_roots_are_told_to_five_digits() {
        let double = companion([-1.0, -2.0]);
        assert!(is_within(&double, 2, 1.0 + 1e-5) && !is_within(&double, 2, 1.0 - 1e-5));
    }
}
