//! Ø. E. Krog, "GPU-based real-time snow avalanche simulations", master's thesis, NTNU, June 2010: the "Simple" model (Müller et
//! al. 2003) in its performance test scene, [`scenes::krog`](crate::scenes::krog).
//!
//! Only what the text says in numbers; figure 8.1 has 32K to 512K particles as curves that cannot be read to better than a
//! tenth, so 32K has no entry.

use super::published_time::PublishedTime;

const THESIS: &str = "Krog 2010, abstract and 8.1.2: iterations per second of the simple model, without drawing";
const PAPER: &str = "the paper appended to Krog 2010: frames per second of the simple model, parameters not said";
const FERMI: &str = "GeForce GTX 470";
const GT200: &str = "GeForce GTX 260";

/// Iterations a second, of the thesis, then those of the paper before it.
pub static TIMES: [PublishedTime; 7] = [
    rate(64, 215.4, FERMI, THESIS),
    rate(128, 122.2, FERMI, THESIS),
    rate(256, 64.9, FERMI, THESIS),
    rate(64, 99.0, GT200, PAPER),
    rate(128, 63.0, GT200, PAPER),
    rate(256, 38.0, GT200, PAPER),
    rate(512, 17.0, GT200, PAPER),
];

const fn rate(kibi: u32, per_second: f64, hardware: &'static str, source: &'static str) -> PublishedTime {
    PublishedTime { particles: kibi * 1024, milliseconds: 1000.0 / per_second, hardware, source }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn rates_become_times() {
        let of = |particles, hardware| {
            TIMES.iter().find(|time| time.particles == particles && time.hardware == hardware).map(|t| t.nanoseconds())
        };
        // 1 / (64.9 x 262144)
        assert!(of(262_144, FERMI).is_some_and(|time| (time - 58.78).abs() < 0.01));
        assert!(of(524_288, GT200).is_some_and(|time| (time - 112.2).abs() < 0.1));
    }
}
