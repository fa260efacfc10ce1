//! Points of cost and gain, both axes in decades, with a numbered front, failures in a strip of their own on top and lists beside.

use std::path::PathBuf;

use plotters::prelude::*;
use plotters::style::text_anchor::{HPos, Pos, VPos};

use super::Colour;
use super::draw::{Drawn, TEXT_SIZE, TICK_SIZE, TITLE_SIZE, rgb, text};
use crate::error::LabError;
use crate::output::Output;

/// What a point looks like.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Shape {
    /// An open circle.
    Ring,
    /// A filled circle.
    Disc,
    /// An open square.
    Square,
    /// What failed, whatever its shape was to be.
    Cross,
}

/// A point.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Dot {
    /// Positive.
    pub x: f64,
    /// Positive; none for what failed.
    pub y: Option<f64>,
    /// Its look.
    pub shape: Shape,
    /// Its colour.
    pub colour: Colour,
    /// Its place in the list, from 1.
    pub number: Option<usize>,
}

/// A line of the list.
#[derive(Clone, Debug, PartialEq)]
pub struct Entry {
    /// Number beside the point, from 1.
    pub number: usize,
    /// What it is.
    pub name: String,
    /// Two numbers.
    pub numbers: [String; 2],
    /// Its colour.
    pub colour: Colour,
}

/// The chart.
#[derive(Clone, Debug, PartialEq)]
pub struct Scatter {
    /// Head line.
    pub title: String,
    /// Name and unit of the horizontal axis.
    pub x_label: String,
    /// Name and unit of the vertical axis.
    pub y_label: String,
    /// Name of the strip of failures.
    pub failed: String,
    /// All points.
    pub dots: Vec<Dot>,
    /// Corners of the front, left to right.
    pub front: Vec<(f64, f64)>,
    /// Over the list.
    pub entries_head: String,
    /// The list.
    pub entries: Vec<Entry>,
    /// What colours mean.
    pub colours: Vec<(Colour, String)>,
    /// What shapes mean.
    pub shapes: Vec<(Shape, String)>,
    /// Lines under the chart.
    pub notes: Vec<String>,
}

const WIDTH: i32 = 1320;
/// Of the axes, px from the left and from the top.
const LEFT: i32 = 96;
const RIGHT: i32 = 840;
const STRIP: (i32, i32) = (64, 100);
const TOP: i32 = 112;
const BOTTOM: i32 = 660;
/// Of the lists.
const LIST: i32 = 876;
const LINE: i32 = 24;
const RADIUS: i32 = 5;

/// Draws a chart into a file of the output folder.
pub fn draw(output: &Output, name: &str, chart: &Scatter) -> Result<PathBuf, LabError> {
    let mut svg = String::new();
    draw_into(&mut svg, chart)
        .map_err(|error| LabError::Chart { path: output.path(name), reason: error.to_string() })?;
    output.write(name, &svg)
}

/// An axis in decades from one pixel to another.
#[derive(Clone, Copy, Debug)]
struct Axis {
    /// Logarithms of the ends.
    ends: (f64, f64),
    pixels: (i32, i32),
}

impl Axis {
    /// Around all values, with some air.
    fn around(values: impl Iterator<Item = f64> + Clone, pixels: (i32, i32)) -> Self {
        let logarithms = || values.clone().filter(|value| *value > 0.0 && value.is_finite()).map(f64::log10);
        let (low, high) = (logarithms().fold(f64::INFINITY, f64::min), logarithms().fold(f64::NEG_INFINITY, f64::max));
        let ends = if low <= high { (low - 0.08, high + 0.08) } else { (-1.0, 1.0) };
        Self { ends, pixels }
    }

    fn place(self, value: f64) -> i32 {
        let share = (value.log10() - self.ends.0) / (self.ends.1 - self.ends.0);
        let (first, last) = (f64::from(self.pixels.0), f64::from(self.pixels.1));
        (first + share * (last - first)).round() as i32
    }

    /// One, two and five of each decade; which are whole decades.
    fn ticks(self) -> Vec<(f64, bool)> {
        let decades = self.ends.0.floor() as i32..=self.ends.1.ceil() as i32;
        let all = decades.flat_map(|decade| [1.0, 2.0, 5.0].map(|of| (of * 10f64.powi(decade), of == 1.0)));
        all.filter(|(value, _)| (self.ends.0..=self.ends.1).contains(&value.log10())).collect()
    }
}

fn draw_into(svg: &mut String, chart: &Scatter) -> Drawn {
    let height = BOTTOM + 84 + LINE * chart.notes.len() as i32;
    let root = SVGBackend::with_string(svg, (WIDTH as u32, height as u32)).into_drawing_area();
    root.fill(&WHITE)?;
    let middle = |size| text(size).pos(Pos::new(HPos::Center, VPos::Center));
    let from_left = |size| text(size).pos(Pos::new(HPos::Left, VPos::Center));
    let from_right = |size| text(size).pos(Pos::new(HPos::Right, VPos::Center));
    root.draw_text(&chart.title, &middle(TITLE_SIZE), (WIDTH / 2, 26))?;

    let x = Axis::around(chart.dots.iter().map(|dot| dot.x), (LEFT, RIGHT));
    let y = Axis::around(chart.dots.iter().filter_map(|dot| dot.y), (BOTTOM, TOP));
    let (faint, grid) = (RGBColor(0xf0, 0xf1, 0xf3), RGBColor(0xd8, 0xdc, 0xe0));
    for (value, whole) in x.ticks() {
        let at = x.place(value);
        let line = if whole { grid } else { faint };
        root.draw(&PathElement::new([(at, TOP), (at, BOTTOM)], line))?;
        root.draw_text(&super::draw::tick(value), &middle(TICK_SIZE), (at, BOTTOM + 16))?;
    }
    for (value, whole) in y.ticks() {
        let at = y.place(value);
        let line = if whole { grid } else { faint };
        root.draw(&PathElement::new([(LEFT, at), (RIGHT, at)], line))?;
        root.draw_text(&super::draw::tick(value), &from_right(TICK_SIZE), (LEFT - 8, at))?;
    }
    root.draw(&Rectangle::new([(LEFT, STRIP.0), (RIGHT, STRIP.1)], RGBColor(0xfb, 0xee, 0xec).filled()))?;
    root.draw_text(&chart.failed, &from_right(TICK_SIZE), (LEFT - 8, (STRIP.0 + STRIP.1) / 2))?;
    root.draw(&PathElement::new([(LEFT, TOP), (LEFT, BOTTOM), (RIGHT, BOTTOM)], rgb(Colour::INK)))?;
    root.draw_text(&chart.x_label, &middle(TEXT_SIZE), ((LEFT + RIGHT) / 2, BOTTOM + 44))?;
    let upright = text(TEXT_SIZE).transform(FontTransform::Rotate270).pos(Pos::new(HPos::Center, VPos::Center));
    root.draw_text(&chart.y_label, &upright, (24, (TOP + BOTTOM) / 2))?;

    // Between its corners the front is a staircase: nothing is known to be below it.
    let mut stairs: Vec<(i32, i32)> = Vec::new();
    for &(cost, error) in &chart.front {
        let corner = (x.place(cost), y.place(error));
        if let Some(&(_, before)) = stairs.last() {
            stairs.push((corner.0, before));
        }
        stairs.push(corner);
    }
    root.draw(&PathElement::new(stairs, rgb(Colour::INK).stroke_width(2)))?;
    for dot in chart.dots.iter().filter(|dot| dot.number.is_none()) {
        let strip = (STRIP.0 + STRIP.1) / 2;
        match dot.y {
            Some(value) => draw_shape(&root, dot.shape, dot.colour, (x.place(dot.x), y.place(value)))?,
            None => draw_shape(&root, Shape::Cross, dot.colour, (x.place(dot.x), strip))?,
        }
    }
    for dot in &chart.dots {
        if let (Some(number), Some(value)) = (dot.number, dot.y) {
            let at = (x.place(dot.x), y.place(value));
            draw_shape(&root, dot.shape, dot.colour, at)?;
            let style = bold(middle(TICK_SIZE));
            root.draw_text(&number.to_string(), &style, (at.0 - 11, at.1 + 13))?;
        }
    }

    let mut at = STRIP.0 + 8;
    root.draw_text(&chart.entries_head, &from_left(TEXT_SIZE), (LIST, at))?;
    at += LINE + 4;
    for entry in &chart.entries {
        let ink = rgb(entry.colour);
        let number = bold(from_right(TICK_SIZE));
        root.draw_text(&entry.number.to_string(), &number, (LIST + 18, at))?;
        root.draw_text(&entry.name, &from_left(TICK_SIZE).color(&ink), (LIST + 30, at))?;
        root.draw_text(&entry.numbers[0], &from_right(TICK_SIZE), (LIST + 340, at))?;
        root.draw_text(&entry.numbers[1], &from_right(TICK_SIZE), (LIST + 424, at))?;
        at += LINE;
    }
    at += LINE / 2;
    for (shape, name) in &chart.shapes {
        draw_shape(&root, *shape, Colour::INK, (LIST + 14, at))?;
        root.draw_text(name, &from_left(TICK_SIZE), (LIST + 30, at))?;
        at += LINE;
    }
    at += LINE / 2;
    for (index, (colour, name)) in chart.colours.iter().enumerate() {
        let (column, row) = (index as i32 % 2, index as i32 / 2);
        let place = (LIST + 14 + 200 * column, at + LINE * row);
        draw_shape(&root, Shape::Disc, *colour, place)?;
        root.draw_text(name, &from_left(TICK_SIZE), (place.0 + 16, place.1))?;
    }
    for (line, note) in chart.notes.iter().enumerate() {
        root.draw_text(note, &from_left(TICK_SIZE), (LEFT, BOTTOM + 80 + LINE * line as i32))?;
    }
    root.present()?;
    Ok(())
}

fn bold(style: TextStyle<'_>) -> TextStyle<'_> {
    TextStyle { font: style.font.style(FontStyle::Bold), ..style }
}

fn draw_shape(
    root: &DrawingArea<SVGBackend<'_>, plotters::coord::Shift>,
    shape: Shape,
    colour: Colour,
    at: (i32, i32),
) -> Drawn {
    let ink = rgb(colour);
    match shape {
        Shape::Ring => root.draw(&Circle::new(at, RADIUS, ink.stroke_width(2)))?,
        Shape::Disc => root.draw(&Circle::new(at, RADIUS, ink.filled()))?,
        Shape::Square => {
            let corners = [(at.0 - RADIUS, at.1 - RADIUS), (at.0 + RADIUS, at.1 + RADIUS)];
            root.draw(&Rectangle::new(corners, ink.stroke_width(2)))?;
        }
        Shape::Cross => root.draw(&Cross::new(at, RADIUS, ink.stroke_width(2)))?,
    }
    Ok(())
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn axes_hold_what_there_is() {
        let axis = Axis::around([0.3, 40.0, f64::NAN].into_iter(), (0, 1000));
        assert!(axis.place(0.3) > 0 && axis.place(40.0) < 1000);
        assert_eq!(axis.place((0.3f64 * 40.0).sqrt()), 500);
        let ticks: Vec<f64> = axis.ticks().into_iter().map(|tick| tick.0).collect();
        assert_eq!(ticks, [0.5, 1.0, 2.0, 5.0, 10.0, 20.0]);
        assert!(Axis::around(std::iter::empty(), (0, 10)).ticks().len() > 2);
    }

    #[test]
    fn a_chart_holds_its_words_and_its_points() -> Drawn {
        let dot = |x: f64, y, shape, number| Dot { x, y, shape, colour: Colour::ORANGE, number };
        let chart = Scatter {
            title: "Title".to_owned(),
            x_label: "cost".to_owned(),
            y_label: "gain".to_owned(),
            failed: "fails".to_owned(),
            dots: vec![
                dot(1.0, Some(2.0), Shape::Ring, Some(1)),
                dot(2.0, Some(3.0), Shape::Disc, None),
                dot(3.0, None, Shape::Disc, None),
            ],
            front: vec![(1.0, 2.0)],
            entries_head: "the front".to_owned(),
            entries: vec![Entry {
                number: 1,
                name: "first".to_owned(),
                numbers: ["2 %".to_owned(), "1 s".to_owned()],
                colour: Colour::ORANGE,
            }],
            colours: vec![(Colour::RED, "family".to_owned())],
            shapes: vec![(Shape::Cross, "fails".to_owned())],
            notes: vec!["a note".to_owned()],
        };
        let mut svg = String::new();
        draw_into(&mut svg, &chart)?;
        for word in ["Title", "cost", "gain", "fails", "the front", "first", "2 %", "1 s", "family", "a note"] {
            assert!(svg.contains(word), "{word} is missing in\n{svg}");
        }
        // Two points and the family's.
        assert_eq!(svg.matches("<circle").count(), 3);
        Ok(())
    }
}
