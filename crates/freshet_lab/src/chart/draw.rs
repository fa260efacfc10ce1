//! Draws a [`Chart`] with plotters.

use std::error::Error;
use std::path::PathBuf;

use plotters::coord::Shift;
use plotters::element::DashedPathElement;
use plotters::prelude::*;
use plotters::style::text_anchor::{HPos, Pos, VPos};

use super::{Chart, Colour, Mark, Panel, Series};
use crate::error::LabError;
use crate::output::Output;

type Area<'a> = DrawingArea<SVGBackend<'a>, Shift>;
pub(super) type Drawn = Result<(), Box<dyn Error>>;

const FONT: &str = "sans-serif";
pub(super) const TITLE_SIZE: u32 = 24;
const PANEL_TITLE_SIZE: u32 = 20;
pub(super) const TEXT_SIZE: u32 = 18;
pub(super) const TICK_SIZE: u32 = 16;
const HEAD: u32 = 40;
const FOOT: u32 = 40;
/// With more panels than this there is another row.
const MOST_SIDE_BY_SIDE: usize = 4;

/// Draws a chart into a file of the output folder.
pub fn draw(output: &Output, name: &str, chart: &Chart) -> Result<PathBuf, LabError> {
    let mut svg = String::new();
    draw_into(&mut svg, chart)
        .map_err(|error| LabError::Chart { path: output.path(name), reason: error.to_string() })?;
    output.write(name, &svg)
}

fn draw_into(svg: &mut String, chart: &Chart) -> Drawn {
    let root = SVGBackend::with_string(svg, chart.size).into_drawing_area();
    root.fill(&WHITE)?;
    let (head, rest) = root.split_vertically(HEAD);
    let (panels, foot) = rest.split_vertically(chart.size.1.saturating_sub(HEAD + FOOT));
    let title = text(TITLE_SIZE).pos(Pos::new(HPos::Center, VPos::Center));
    head.draw_text(&chart.title, &title, ((chart.size.0 / 2) as i32, (HEAD / 2) as i32))?;
    for (area, panel) in panels.split_evenly(grid(chart.panels.len())).iter().zip(&chart.panels) {
        draw_panel(area, panel)?;
    }
    draw_legend(&foot, chart)?;
    root.present()?;
    Ok(())
}

/// Rows and columns for panels.
fn grid(panels: usize) -> (usize, usize) {
    let rows = panels.div_ceil(MOST_SIDE_BY_SIDE).max(1);
    (rows, panels.div_ceil(rows).max(1))
}

fn draw_panel(area: &Area<'_>, panel: &Panel) -> Drawn {
    let across = |x| panel.x_scale.place(x);
    let up = |y| panel.y_scale.place(y);
    let mut axes = ChartBuilder::on(area)
        .margin(6)
        .margin_right(20)
        .caption(&panel.title, text(PANEL_TITLE_SIZE))
        .x_label_area_size(52)
        .y_label_area_size(64)
        .build_cartesian_2d(across(panel.x.0)..across(panel.x.1), up(panel.y.0)..up(panel.y.1))?;
    axes.configure_mesh()
        .x_desc(&panel.x_label)
        .y_desc(&panel.y_label)
        .x_labels(6)
        .y_labels(6)
        .axis_desc_style(text(TEXT_SIZE))
        .label_style(text(TICK_SIZE))
        .x_label_formatter(&|&value| panel.x_scale.label(value))
        .y_label_formatter(&|&value| panel.y_scale.label(value))
        .light_line_style(RGBColor(0xf4, 0xf5, 0xf6))
        .bold_line_style(RGBColor(0xe2, 0xe5, 0xe8))
        .axis_style(rgb(Colour::INK))
        .draw()?;
    let inside =
        |point: &(f64, f64)| (panel.x.0..=panel.x.1).contains(&point.0) && (panel.y.0..=panel.y.1).contains(&point.1);
    for series in &panel.series {
        let points: Vec<(f64, f64)> =
            series.points.iter().copied().filter(inside).map(|(x, y)| (across(x), up(y))).collect();
        let colour = rgb(series.colour);
        match series.mark {
            Mark::Line(width) => {
                axes.draw_series(LineSeries::new(points, colour.stroke_width(width)))?;
            }
            Mark::Dashes(width) => {
                axes.draw_series(DashedLineSeries::new(points, 9, 6, colour.stroke_width(width)))?;
            }
            Mark::Circles(radius) => {
                axes.draw_series(points.into_iter().map(|point| Circle::new(point, radius, colour.stroke_width(2))))?;
            }
        }
    }
    let plot = axes.plotting_area().strip_coord_spec();
    for (line, note) in panel.notes.iter().enumerate() {
        plot.draw_text(note, &text(TICK_SIZE), (10, 8 + line as i32 * (TICK_SIZE as i32 + 4)))?;
    }
    Ok(())
}

fn draw_legend(area: &Area<'_>, chart: &Chart) -> Drawn {
    let mut entries: Vec<&Series> = Vec::new();
    for series in chart.panels.iter().flat_map(|panel| &panel.series) {
        if entries.iter().all(|known| known.name != series.name) {
            entries.push(series);
        }
    }
    // The real width of text is only known to the viewer: half an em a letter is close.
    let width_of = |series: &Series| 60 + (series.name.chars().count() as u32 * TEXT_SIZE / 2) as i32;
    let total: i32 = entries.iter().map(|series| width_of(series)).sum();
    let mut x = ((chart.size.0 as i32 - total) / 2).max(8);
    let y = FOOT as i32 / 2;
    for series in entries {
        let colour = rgb(series.colour);
        let ends = [(x, y), (x + 34, y)];
        match series.mark {
            Mark::Line(width) => area.draw(&PathElement::new(ends.to_vec(), colour.stroke_width(width)))?,
            Mark::Dashes(width) => {
                area.draw(&DashedPathElement::new(ends, 9, 6, colour.stroke_width(width)))?;
            }
            Mark::Circles(radius) => area.draw(&Circle::new((x + 17, y), radius, colour.stroke_width(2)))?,
        }
        area.draw_text(&series.name, &text(TEXT_SIZE).pos(Pos::new(HPos::Left, VPos::Center)), (x + 42, y))?;
        x += width_of(series);
    }
    Ok(())
}

pub(super) fn text(size: u32) -> TextStyle<'static> {
    (FONT, size).into_font().color(&rgb(Colour::INK))
}

pub(super) fn rgb(Colour(red, green, blue): Colour) -> RGBColor {
    RGBColor(red, green, blue)
}

/// A number on an axis without the dust of binary fractions.
pub(super) fn tick(value: f64) -> String {
    let rounded = (value * 1e6).round() / 1e6;
    if rounded == 0.0 { "0".to_owned() } else { format!("{rounded}") }
}

#[cfg(test)]
mod tests {
    use super::super::Scale;
    use super::*;

    #[test]
    fn a_chart_holds_its_words_and_its_points() -> Drawn {
        let series = |name: &str, mark| Series {
            name: name.to_owned(),
            mark,
            colour: Colour::INK,
            points: vec![(0.0, 1.0), (1.0, 2.0), (9.0, 9.0)],
        };
        let panel = Panel {
            title: "Panel <one>".to_owned(),
            notes: vec!["a note".to_owned()],
            x_label: "time (s)".to_owned(),
            y_label: "front (m)".to_owned(),
            x_scale: Scale::Linear,
            x: (0.0, 2.0),
            y_scale: Scale::Linear,
            y: (0.0, 3.0),
            series: vec![series("measured", Mark::Circles(4)), series("a line", Mark::Line(2))],
        };
        let chart = Chart { title: "Title".to_owned(), panels: vec![panel.clone(), panel], size: (900, 400) };
        let mut svg = String::new();
        draw_into(&mut svg, &chart)?;
        for word in ["Title", "Panel &lt;one&gt;", "a note", "time (s)", "front (m)", "measured", "a line"] {
            assert!(svg.contains(word), "{word} is missing in\n{svg}");
        }
        // Two points inside each panel, and one in the legend.
        assert_eq!(svg.matches("<circle").count(), 5);
        Ok(())
    }

    #[test]
    fn rows_are_filled_evenly() {
        assert_eq!([0, 1, 3, 4, 5, 8, 9].map(grid), [(1, 1), (1, 1), (1, 3), (1, 4), (2, 3), (2, 4), (3, 3)]);
    }

    #[test]
    fn doublings_are_equal_steps() {
        let place = |x| Scale::Doubling.place(x);
        assert_eq!(place(8192.0) - place(4096.0), place(524_288.0) - place(262_144.0));
        assert_eq!(Scale::Doubling.label(place(4096.0)), "4K");
        assert_eq!(Scale::Doubling.label(place(1536.0)), "1.5K");
        assert_eq!(Scale::Doubling.label(place(256.0)), "256");
        assert_eq!(Scale::Linear.label(4.0), "4");
    }

    #[test]
    fn decades_are_equal_steps_with_a_text_at_whole_ones() {
        let place = |x| Scale::Decades.place(x);
        assert!((place(1e-4) - place(1e-6) - 2.0).abs() < 1e-12);
        let labels = [1e-5, 0.01, 100.0, 3.0].map(|value| Scale::Decades.label(place(value)));
        assert_eq!(labels, ["1e-5", "0.01", "100", ""]);
    }

    #[test]
    fn ticks_are_plain() {
        assert_eq!(tick(0.300_000_000_000_000_04), "0.3");
        assert_eq!(tick(-0.0), "0");
        assert_eq!(tick(2.0), "2");
    }
}
