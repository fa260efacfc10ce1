//! L. Lobovsky, E. Botia-Vera, F. Castellana, J. Mas-Soler, A. Souto-Iglesias, "Experimental investigation of dynamic pressure
//! loads during dam break", J. Fluids Struct. 48 (2014) 407-434 (arXiv 1308.0115): a column of water 600 mm high and 600 mm
//! long behind a gate that is lifted at about 4.5 m/s, and a vertical wall downstream.
//!
//! Second-hand: figure 12 (left), extracted from the vector drawing by a third party (s34metrics.mjs, public), of which
//! these are 25 of 109 points. Time counts from the first motion of the gate.

use super::dam_break::DamBreakExperiment;

/// H = L = 600 mm, dry bed.
pub static SQUARE: DamBreakExperiment = DamBreakExperiment {
    name: "lobovsky_square",
    title: "Lobovský et al. 2014, H = 0.6 m",
    source: "Lobovsky et al. 2014, fig. 12 left, H = L = 0.6 m; second-hand: vector extraction by a third party",
    width: 0.6,
    aspect: 1.0,
    tank_length: 2.683,
    // The front reaches the wall at about 1.58.
    window: (1.0, 1.57),
    points: &[
        (0.0939, 1.0661),
        (0.2017, 1.1559),
        (0.2961, 1.2363),
        (0.4039, 1.3178),
        (0.4984, 1.3982),
        (0.6062, 1.4869),
        (0.7006, 1.5803),
        (0.7948, 1.6758),
        (0.9028, 1.7811),
        (1.0240, 1.9201),
        (1.0914, 2.0047),
        (1.1185, 2.0363),
        (1.1455, 2.0721),
        (1.1859, 2.1287),
        (1.2263, 2.1795),
        (1.2667, 2.2242),
        (1.2937, 2.2652),
        (1.3341, 2.3217),
        (1.4015, 2.4120),
        (1.4149, 2.4281),
        (1.4555, 2.4836),
        (1.4823, 2.5246),
        (1.5227, 2.5811),
        (1.5633, 2.6377),
        (1.5767, 2.6615),
    ],
    heights: &[],
};
