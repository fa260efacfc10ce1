// The wrapped uniform grid, as freshet_core::grid: cells of the support radius, x fastest, wrapped by a bit mask.
#define_import_path freshet::grid

#import freshet::bindings as fields

// The shape of the grid. Loops take it from a variable: a uniform read in a loop is read anew each time, which software
// adapters do lane by lane.
struct Shape {
    cell_mask: vec3<u32>,
    log_cells_x: u32,
    log_cells_xy: u32,
}

fn shape() -> Shape {
    return Shape(fields::parameters.cell_mask, fields::parameters.log_cells_x, fields::parameters.log_cells_xy);
}

// Wrapped coordinates of the cell that holds a point.
fn cell_of(position: vec3<f32>) -> vec3<u32> {
    let unwrapped = vec3<i32>(floor(position * fields::parameters.inverse_cell_size));
    return bitcast<vec3<u32>>(unwrapped) & fields::parameters.cell_mask;
}

fn cell_index(cell: vec3<u32>) -> u32 {
    return cell.x | (cell.y << fields::parameters.log_cells_x) | (cell.z << fields::parameters.log_cells_xy);
}

// A row of three x-adjacent cells in the table of starts: `first` is the entry of its first cell, `end` the entry after
// its last. A row that wraps around continues at `wrapped`, up to `wrapped_end`; others have these two equal.
struct Cells {
    first: u32,
    end: u32,
    wrapped: u32,
    wrapped_end: u32,
}

// Row 0 .. 8 of the 27 cells around a cell.
fn cells_around(grid: Shape, center: vec3<u32>, row: u32) -> Cells {
    let y = (center.y + row % 3u - 1u) & grid.cell_mask.y;
    let z = (center.z + row / 3u - 1u) & grid.cell_mask.z;
    let base = (y << grid.log_cells_x) | (z << grid.log_cells_xy);
    let x = (center.x - 1u) & grid.cell_mask.x;
    let over = x + 2u - min(x + 2u, grid.cell_mask.x);
    return Cells(base + x, base + x + 3u - over, base, base + over);
}

// Where the particles, or samples, of a row are: `straight` of them from `first`, and the others, where the row wraps
// around, `jump` further on.
struct Row {
    first: u32,
    straight: u32,
    jump: u32,
    count: u32,
}

// `section` is where the starts of the kind in question begin.
fn row_of(section: u32, cells: Cells) -> Row {
    let first = fields::cell_start(section + cells.first);
    let end = fields::cell_start(section + cells.end);
    var row = Row(first, end - first, 0u, end - first);
    if (cells.wrapped_end != cells.wrapped) {
        let other = fields::cell_start(section + cells.wrapped);
        row.jump = other - end;
        row.count += fields::cell_start(section + cells.wrapped_end) - other;
    }
    return row;
}

// The particle or sample at place `t` of a row.
fn member(row: Row, t: u32) -> u32 {
    return row.first + t + select(0u, row.jump, t >= row.straight);
}
