//! Charts as SVG: lines in one or more panels, at most four side by side, with one legend below, [heat maps](heat) and [costs against errors](scatter).
//!
//! Text is left to the viewer's fonts, so that no font library is needed.

mod draw;
pub mod heat;
pub mod scatter;

pub use draw::draw;

/// A colour, red, green, blue.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Colour(pub u8, pub u8, pub u8);

impl Colour {
    /// Measurements and text.
    pub const INK: Self = Self(0x22, 0x26, 0x2b);
    /// Light to dark blue: coarse to fine.
    pub const BLUES: [Self; 3] = [Self(0x8e, 0xc3, 0xec), Self(0x3a, 0x87, 0xc8), Self(0x0b, 0x45, 0x86)];
    /// The other backend.
    pub const ORANGE: Self = Self(0xd9, 0x6a, 0x1b);
    /// Bounds.
    pub const RED: Self = Self(0xc0, 0x39, 0x2b);
}

/// How a series is drawn.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum Mark {
    /// A line of this width, px.
    Line(u32),
    /// A dashed line of this width, px.
    Dashes(u32),
    /// Open circles of this radius, px.
    Circles(u32),
}

/// Points with a name and a look.
#[derive(Clone, Debug, PartialEq)]
pub struct Series {
    /// Name in the legend; the first series of a name in any panel makes the entry.
    pub name: String,
    /// Look.
    pub mark: Mark,
    /// Colour.
    pub colour: Colour,
    /// What is drawn; points outside the panel are left out.
    pub points: Vec<(f64, f64)>,
}

/// How an axis runs.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub enum Scale {
    /// Equal steps add the same.
    #[default]
    Linear,
    /// Equal steps double; for positive values, those from 1,024 on written in units of it: `4K`.
    Doubling,
    /// Equal steps multiply by ten; for positive values, with a text at whole powers of ten only.
    Decades,
}

impl Scale {
    /// Where a value stands on the axis.
    fn place(self, value: f64) -> f64 {
        match self {
            Scale::Linear => value,
            Scale::Doubling => value.log2(),
            Scale::Decades => value.log10(),
        }
    }

    /// The text at a place.
    fn label(self, place: f64) -> String {
        match self {
            Scale::Linear => draw::tick(place),
            Scale::Doubling => match place.exp2() {
                value if value < 1024.0 => format!("{}", value.round()),
                value => format!("{}K", (value / 1024.0 * 10.0).round() / 10.0),
            },
            Scale::Decades if (place - place.round()).abs() > 1e-6 => String::new(),
            Scale::Decades if (-3.5..3.5).contains(&place) => draw::tick(10f64.powf(place.round())),
            Scale::Decades => format!("1e{}", place.round()),
        }
    }
}

/// One set of axes.
#[derive(Clone, Debug, PartialEq)]
pub struct Panel {
    /// Over the axes.
    pub title: String,
    /// Lines of text in the upper left corner of the axes.
    pub notes: Vec<String>,
    /// Name and unit of the horizontal axis.
    pub x_label: String,
    /// Name and unit of the vertical axis.
    pub y_label: String,
    /// How the horizontal axis runs.
    pub x_scale: Scale,
    /// Ends of the horizontal axis.
    pub x: (f64, f64),
    /// How the vertical axis runs.
    pub y_scale: Scale,
    /// Ends of the vertical axis.
    pub y: (f64, f64),
    /// Drawn in order.
    pub series: Vec<Series>,
}

impl Panel {
    /// The same panel with a vertical axis from `floor` to a little above the highest point of all series.
    #[must_use]
    pub fn fitted(mut self, floor: f64) -> Self {
        let points = self.series.iter().flat_map(|series| &series.points);
        let highest = points.map(|point| point.1).filter(|y| y.is_finite()).fold(floor, f64::max);
        self.y = (floor, floor + ((highest - floor) * 1.08).max(1e-9));
        self
    }
}

/// Panels with a head and a foot.
#[derive(Clone, Debug, PartialEq)]
pub struct Chart {
    /// Head line.
    pub title: String,
    /// Side by side, left to right, in rows of at most four.
    pub panels: Vec<Panel>,
    /// Width and height, px.
    pub size: (u32, u32),
}
