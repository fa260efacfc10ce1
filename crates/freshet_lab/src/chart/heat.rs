//! A heat map: a coloured cell with a number for each row and column.

use std::path::PathBuf;

use plotters::prelude::*;
use plotters::style::text_anchor::{HPos, Pos, VPos};

use super::Colour;
use super::draw::{Drawn, TEXT_SIZE, TICK_SIZE, TITLE_SIZE, rgb, text};
use crate::error::LabError;
use crate::output::Output;

/// A cell.
#[derive(Clone, Debug, PartialEq)]
pub struct Cell {
    /// 0 for the worst colour to 1 for the best.
    pub shade: f64,
    /// What is written in it.
    pub label: String,
}

/// A heat map.
#[derive(Clone, Debug, PartialEq)]
pub struct HeatMap {
    /// Head line.
    pub title: String,
    /// Lines under the map.
    pub notes: Vec<String>,
    /// Groups of columns: a head line and the names of its columns.
    pub columns: Vec<(String, Vec<String>)>,
    /// Groups of rows: a name and the names of its rows.
    pub rows: Vec<(String, Vec<String>)>,
    /// Cells by row, then column; none is left white.
    pub cells: Vec<Vec<Option<Cell>>>,
}

const CELL: (i32, i32) = (74, 26);
const ROW_HEAD: i32 = 320;
const COLUMN_HEAD: i32 = 92;
/// So that the notes fit.
const LEAST_WIDTH: i32 = 860;
/// Between groups.
const GAP: i32 = 8;
const LINE: i32 = 24;

/// Draws a map into a file of the output folder.
pub fn draw(output: &Output, name: &str, map: &HeatMap) -> Result<PathBuf, LabError> {
    let mut svg = String::new();
    draw_into(&mut svg, map).map_err(|error| LabError::Chart { path: output.path(name), reason: error.to_string() })?;
    output.write(name, &svg)
}

/// Where the members of groups begin, and where all end.
fn places(groups: &[(String, Vec<String>)], first: i32, size: i32) -> (Vec<Vec<i32>>, i32) {
    let mut at = first;
    let mut places = Vec::new();
    for (_, members) in groups {
        places.push((0..members.len() as i32).map(|member| at + member * size).collect::<Vec<_>>());
        at += members.len() as i32 * size + GAP;
    }
    (places, at)
}

fn draw_into(svg: &mut String, map: &HeatMap) -> Drawn {
    let (columns, right) = places(&map.columns, ROW_HEAD, CELL.0);
    let (rows, bottom) = places(&map.rows, COLUMN_HEAD, CELL.1);
    let size = ((right + GAP).max(LEAST_WIDTH) as u32, (bottom + LINE * map.notes.len() as i32 + GAP) as u32);
    let root = SVGBackend::with_string(svg, size).into_drawing_area();
    root.fill(&WHITE)?;
    let middle = |size| text(size).pos(Pos::new(HPos::Center, VPos::Center));
    root.draw_text(&map.title, &middle(TITLE_SIZE), (size.0 as i32 / 2, 20))?;
    for ((group, names), places) in map.columns.iter().zip(&columns) {
        if let (Some(first), Some(last)) = (places.first(), places.last()) {
            root.draw_text(group, &middle(TEXT_SIZE), ((first + last + CELL.0) / 2, 52))?;
        }
        for (name, x) in names.iter().zip(places) {
            root.draw_text(name, &middle(TICK_SIZE), (x + CELL.0 / 2, 78))?;
        }
    }
    let mut cells = map.cells.iter();
    for ((group, names), places) in map.rows.iter().zip(&rows) {
        let left = text(TEXT_SIZE).pos(Pos::new(HPos::Left, VPos::Center));
        let right = text(TICK_SIZE).pos(Pos::new(HPos::Right, VPos::Center));
        if let Some(first) = places.first() {
            root.draw_text(group, &left, (GAP, first + CELL.1 / 2))?;
        }
        for (name, y) in names.iter().zip(places) {
            root.draw_text(name, &right, (ROW_HEAD - GAP, y + CELL.1 / 2))?;
            for (cell, x) in cells.next().into_iter().flatten().zip(columns.iter().flatten()) {
                let Some(cell) = cell else { continue };
                let (colour, ink) = shade(cell.shade);
                let corners = [(*x, *y), (x + CELL.0 - 1, y + CELL.1 - 1)];
                root.draw(&Rectangle::new(corners, rgb(colour).filled()))?;
                let ink = rgb(ink);
                let style = middle(TICK_SIZE).color(&ink);
                root.draw_text(&cell.label, &style, (x + CELL.0 / 2, y + CELL.1 / 2))?;
            }
        }
    }
    for (line, note) in map.notes.iter().enumerate() {
        root.draw_text(note, &text(TICK_SIZE), (GAP, bottom + LINE * line as i32))?;
    }
    root.present()?;
    Ok(())
}

/// From dark red over pale yellow to dark blue, and what can be read on it.
fn shade(value: f64) -> (Colour, Colour) {
    const STOPS: [[f64; 3]; 5] =
        [[150.0, 20.0, 30.0], [232.0, 120.0, 70.0], [250.0, 236.0, 190.0], [120.0, 180.0, 220.0], [11.0, 69.0, 134.0]];
    let at = value.clamp(0.0, 1.0) * (STOPS.len() - 1) as f64;
    let lower = (at as usize).min(STOPS.len() - 2);
    let part = at - lower as f64;
    let [red, green, blue] =
        [0, 1, 2].map(|channel: usize| STOPS[lower][channel] * (1.0 - part) + STOPS[lower + 1][channel] * part);
    let light = 0.3 * red + 0.6 * green + 0.1 * blue > 140.0;
    let ink = if light { Colour::INK } else { Colour(255, 255, 255) };
    (Colour(red as u8, green as u8, blue as u8), ink)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_map_holds_its_words_and_a_rectangle_for_each_cell() -> Drawn {
        let cell = |shade: f64| Some(Cell { shade, label: format!("value {shade}") });
        let map = HeatMap {
            title: "Title".to_owned(),
            notes: vec!["a note".to_owned()],
            columns: vec![("group".to_owned(), vec!["one".to_owned(), "two".to_owned()])],
            rows: vec![("kernel".to_owned(), vec!["24".to_owned()]), ("other".to_owned(), vec!["32".to_owned()])],
            cells: vec![vec![cell(0.0), cell(1.0)], vec![None, cell(0.5)]],
        };
        let mut svg = String::new();
        draw_into(&mut svg, &map)?;
        for word in ["Title", "a note", "group", "one", "two", "kernel", "other", "24", "value 0.5"] {
            assert!(svg.contains(word), "{word} is missing in\n{svg}");
        }
        // The background is one, too.
        assert_eq!(svg.matches("<rect").count(), 4);
        Ok(())
    }
}
