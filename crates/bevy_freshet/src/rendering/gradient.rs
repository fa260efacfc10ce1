//! Named gradients.

use bevy::prelude::*;

/// Colours from low to high values.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Hash, Reflect)]
#[reflect(Default, Clone, Debug, PartialEq)]
pub enum FluidGradient {
    /// Deep blue over turquoise to foam.
    #[default]
    Water,
    /// Dark violet over green to yellow; even in lightness, readable without colour vision.
    Viridis,
    /// Blue over green and yellow to red; many steps can be told apart.
    Turbo,
    /// Black over red and orange to white, as hot metal.
    Heat,
    /// Blue over white to red, for values around a middle.
    Diverging,
    /// Black to white.
    Gray,
}

impl FluidGradient {
    /// Every gradient.
    pub const ALL: [Self; 6] = [Self::Water, Self::Viridis, Self::Turbo, Self::Heat, Self::Diverging, Self::Gray];

    /// Stable name, as in files and panels.
    pub fn name(self) -> &'static str {
        match self {
            Self::Water => "water",
            Self::Viridis => "viridis",
            Self::Turbo => "turbo",
            Self::Heat => "heat",
            Self::Diverging => "diverging",
            Self::Gray => "gray",
        }
    }

    /// Finds a gradient by its [`name`](Self::name).
    pub fn by_name(name: &str) -> Option<Self> {
        Self::ALL.into_iter().find(|gradient| gradient.name() == name)
    }

    /// Colour at `t`, 0 to 1 (clamped).
    pub fn color(self, t: f32) -> LinearRgba {
        let stops = self.stops();
        let place = t.clamp(0.0, 1.0) * (stops.len() - 1) as f32;
        let index = (place as usize).min(stops.len() - 2);
        let color = |index: usize| {
            let [red, green, blue] = stops[index];
            LinearRgba::from(Srgba::rgb_u8(red, green, blue))
        };
        color(index).mix(&color(index + 1), place - index as f32)
    }

    /// sRGB colours at equal distances. Viridis (Smith & van der Walt 2015) and Turbo (Mikhailov 2019) are samples of the
    /// published maps.
    fn stops(self) -> &'static [[u8; 3]] {
        match self {
            Self::Water => &[
                [9, 52, 122],
                [12, 74, 153],
                [16, 99, 180],
                [27, 127, 202],
                [57, 157, 217],
                [104, 187, 229],
                [163, 215, 240],
                [216, 238, 248],
                [248, 252, 254],
            ],
            Self::Viridis => &[
                [68, 1, 84],
                [71, 45, 123],
                [59, 82, 139],
                [44, 114, 142],
                [33, 145, 140],
                [39, 173, 129],
                [92, 200, 99],
                [170, 220, 50],
                [253, 231, 37],
            ],
            Self::Turbo => &[
                [48, 18, 59],
                [70, 107, 227],
                [40, 187, 236],
                [49, 242, 153],
                [162, 252, 60],
                [237, 208, 58],
                [251, 128, 34],
                [210, 49, 5],
                [122, 4, 3],
            ],
            Self::Heat => &[
                [12, 6, 8],
                [88, 10, 6],
                [178, 28, 8],
                [232, 84, 12],
                [250, 154, 32],
                [254, 214, 106],
                [255, 250, 230],
            ],
            Self::Diverging => &[
                [33, 80, 172],
                [110, 150, 214],
                [190, 208, 238],
                [242, 242, 242],
                [242, 196, 178],
                [222, 122, 100],
                [176, 30, 44],
            ],
            Self::Gray => &[[6, 6, 6], [250, 250, 250]],
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn gradients_are_found_by_name_and_end_where_they_say() {
        for gradient in FluidGradient::ALL {
            assert_eq!(FluidGradient::by_name(gradient.name()), Some(gradient));
            assert_eq!(gradient.color(-1.0), gradient.color(0.0));
            assert_eq!(gradient.color(2.0), gradient.color(1.0));
        }
        assert!(FluidGradient::by_name("Water").is_none());
    }
}
