//! The front over time as a chart.

use std::path::Path;

use plotters::prelude::*;

use crate::summary::Sample;

/// Writes the chart as SVG.
pub fn write(path: &Path, fronts: &[Sample]) -> Result<(), String> {
    draw(path, fronts).map_err(|error| format!("{}: {error}", path.display()))
}

fn draw(path: &Path, fronts: &[Sample]) -> Result<(), Box<dyn std::error::Error>> {
    let ends = |values: &mut dyn Iterator<Item = f64>| {
        values.fold((f64::INFINITY, f64::NEG_INFINITY), |(low, high), value| (low.min(value), high.max(value)))
    };
    let (mut start, mut end) = ends(&mut fronts.iter().map(|sample| sample.time));
    let (mut low, mut high) = ends(&mut fronts.iter().map(|sample| f64::from(sample.front)));
    if start >= end {
        (start, end) = (0.0, 1.0);
    }
    if low >= high {
        (low, high) = (0.0, 1.0);
    }
    let root = SVGBackend::new(path, (800, 480)).into_drawing_area();
    root.fill(&WHITE)?;
    let margin = 0.05 * (high - low);
    let mut chart = ChartBuilder::on(&root)
        .margin(16)
        .caption("Front of the water", ("sans-serif", 22))
        .x_label_area_size(44)
        .y_label_area_size(56)
        .build_cartesian_2d(start..end, low - margin..high + margin)?;
    chart.configure_mesh().x_desc("time, s").y_desc("front, m").light_line_style(WHITE.mix(0.0)).draw()?;
    let line = fronts.iter().map(|sample| (sample.time, f64::from(sample.front)));
    chart.draw_series(LineSeries::new(line, RGBColor(16, 99, 180).stroke_width(2)))?;
    root.present()?;
    Ok(())
}
