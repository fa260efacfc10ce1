//! M. Pirovano, "Accurate real-time fluid dynamics using smoothed-particle hydrodynamics and CUDA", thesis, Politecnico di Milano,
//! 2011, section 5.2: a cube without gravity or walls, [`scenes::pirovano`](crate::scenes::pirovano).

use super::published_time::PublishedTime;

const PROCESSOR: &str = "Phenom 8650, one thread";
const CARD: &str = "GeForce GTX 480";

/// A step of 1 ms of its CPU code and of its CUDA code.
pub static TIMES: [PublishedTime; 4] = [
    PublishedTime {
        particles: 4096,
        milliseconds: 241.0,
        hardware: PROCESSOR,
        source: "Pirovano 2011, 5.2: 277 ms less 36 ms of drawing; with surface tension, which has no effect there",
    },
    PublishedTime {
        particles: 32_768,
        milliseconds: 2677.0,
        hardware: PROCESSOR,
        source: "Pirovano 2011, 5.2: whether drawing is in it is not said",
    },
    PublishedTime { particles: 4096, milliseconds: 3.0, hardware: CARD, source: "Pirovano 2011, 5.2" },
    PublishedTime { particles: 32_768, milliseconds: 18.0, hardware: CARD, source: "Pirovano 2011, 5.2" },
];

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn ratios_are_those_of_the_text() {
        let [processor, _, card, card_with_more] = TIMES.map(|time| time.nanoseconds());
        assert!((processor / card - 80.3).abs() < 0.1, "the thesis counts the drawing and says almost 100");
        assert!((TIMES[1].milliseconds / TIMES[3].milliseconds - 148.7).abs() < 0.1, "as the thesis says");
        assert!((card_with_more - 549.3).abs() < 0.1);
    }
}
