//! J. C. Martin & W. J. Moyce, "Part IV. An experimental study of the collapse of liquid columns on a rigid horizontal
//! plane", Phil. Trans. R. Soc. Lond. A 244 (1952) 312-324: water columns of width a = 2.25 in on a dry floor.
//!
//! The fronts are over T = n t sqrt(g/a), the heights of the columns at the back wall over tau = t sqrt(g/a).
//!
//! No table was read from the paper by us: all are second-hand, from transcriptions that agree with each other as
//! said at each. The origin of time is uncertain (the membrane that held the column had to vanish first): papers that use
//! the data allow a shift of up to 0.2 in T, and so do we.

use super::dam_break::DamBreakExperiment;

/// 2.25 in.
const WIDTH: f64 = 0.057_15;

/// Table 1, square column, n^2 = 1.
///
/// As re-plotted by Leakey et al. 2021, figure 7 (vector markers); a second transcription of table 1 agrees within 0.01. The
/// heights, in units of a, are of the same figure.
pub static SQUARE: DamBreakExperiment = DamBreakExperiment {
    name: "martin_moyce_square",
    title: "Martin & Moyce 1952, n² = 1",
    source: "Martin & Moyce 1952, table 1, a = 2.25 in; second-hand: as re-plotted by Leakey et al. 2021, fig. 7",
    width: WIDTH,
    aspect: 1.0,
    // No front is so far by the last height, so that nothing comes back from the far wall.
    tank_length: 12.0,
    window: (1.0, 3.3),
    points: &[
        (0.43, 1.11),
        (0.62, 1.22),
        (0.80, 1.44),
        (0.97, 1.67),
        (1.14, 1.89),
        (1.29, 2.11),
        (1.45, 2.33),
        (1.62, 2.56),
        (1.76, 2.78),
        (1.93, 3.00),
        (2.07, 3.22),
        (2.24, 3.44),
        (2.40, 3.67),
        (2.54, 3.89),
        (2.71, 4.11),
        (2.87, 4.33),
        (3.04, 4.56),
        (3.21, 4.78),
        (3.29, 4.89),
        (3.32, 5.00),
    ],
    heights: &[
        (0.80, 0.89),
        (1.29, 0.78),
        (1.74, 0.67),
        (2.15, 0.56),
        (2.57, 0.44),
        (3.08, 0.33),
        (4.27, 0.22),
        (6.29, 0.11),
    ],
};

/// Table 2, column twice as high as wide, n^2 = 2; T = t sqrt(2g/a), which is n t sqrt(g/a).
///
/// Two independent public transcriptions agree; the points DualSPHysics uses for Koshizuka & Oka's case agree within 0.04
/// in Z. The heights are table 6, in units of 2 a, from public transcriptions.
pub static TALL: DamBreakExperiment = DamBreakExperiment {
    name: "martin_moyce_tall",
    title: "Martin & Moyce 1952, n² = 2",
    source: "Martin & Moyce 1952, table 2, a = 2.25 in; second-hand: two public transcriptions that agree",
    width: WIDTH,
    aspect: 2.0,
    // As above: Martin & Moyce's own front was at 14 a at T = 9.2.
    tank_length: 20.0,
    window: (1.0, 3.3),
    points: &[
        (0.41, 1.11),
        (0.84, 1.22),
        (1.19, 1.44),
        (1.43, 1.67),
        (1.63, 1.89),
        (1.83, 2.11),
        (1.98, 2.33),
        (2.20, 2.56),
        (2.32, 2.78),
        (2.51, 3.00),
        (2.65, 3.22),
        (2.83, 3.44),
        (2.98, 3.67),
        (3.11, 3.89),
        (3.33, 4.11),
    ],
    heights: &[
        (0.56, 0.94),
        (0.77, 0.89),
        (0.93, 0.83),
        (1.08, 0.78),
        (1.28, 0.72),
        (1.46, 0.67),
        (1.66, 0.61),
        (1.84, 0.56),
        (2.00, 0.50),
        (2.21, 0.44),
        (2.45, 0.39),
        (2.70, 0.33),
        (3.06, 0.28),
        (3.44, 0.22),
        (4.20, 0.17),
        (5.25, 0.11),
        (7.40, 0.06),
    ],
};
