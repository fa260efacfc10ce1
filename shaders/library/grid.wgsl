// The wrapped uniform grid, as freshet_core::grid with cells cut along x: edges of the support radius along y and z and of
// a CELLS_PER_RADIUS-th of it along x, x fastest, wrapped by a bit mask. Along axes that repeat the cells divide the period
// and are longer, and differences are taken to the nearest image.
#define_import_path freshet::grid

#import freshet::bindings as fields

// The cells that a particle's neighbours are in: nine rows of ROW_CELLS cells adjacent along x.
const CELLS_PER_RADIUS: u32 = #{CELLS_PER_RADIUS}u;
const ROW_CELLS: u32 = 2u * CELLS_PER_RADIUS + 1u;

// Slightly more than the squared support radius over itself: rounding of coordinates must not cut a neighbour off.
const SQUARED_REACH: f32 = 1.001;

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

// A point in units of cells, from the corner of cell zero.
fn scaled(position: vec3<f32>) -> vec3<f32> {
#ifdef PERIODIC
    return (position - fields::parameters.grid_origin) * fields::parameters.inverse_cell_size;
#else
    return position * fields::parameters.inverse_cell_size;
#endif
}

// From b to a; where the domain repeats itself, from the image of b that is nearest.
fn difference(a: vec3<f32>, b: vec3<f32>) -> vec3<f32> {
    let x = a - b;
#ifdef PERIODIC
    return x - fields::parameters.period * round(x * fields::parameters.inverse_period);
#else
    return x;
#endif
}

#ifdef PERIODIC
// What leaves a period through one end comes back through the other.
fn wrapped(position: vec3<f32>) -> vec3<f32> {
    let low = fields::parameters.period_low;
    let high = fields::parameters.period_high;
    let turns = floor((position - low) * fields::parameters.inverse_period);
    let moved = position - fields::parameters.period * turns;
    let image = select(low, moved, (moved >= low) & (moved < high));
    return select(image, position, (position >= low) & (position < high));
}
#endif

// A point in the grid: the wrapped coordinates of its cell, and where it is in the cell, as a part of each edge.
struct Place {
    cell: vec3<u32>,
    inside: vec3<f32>,
}

fn place_of(position: vec3<f32>) -> Place {
    let at = scaled(position);
    let lower = floor(at);
    return Place(bitcast<vec3<u32>>(vec3<i32>(lower)) & fields::parameters.cell_mask, at - lower);
}

// Wrapped coordinates of the cell that holds a point.
fn cell_of(position: vec3<f32>) -> vec3<u32> {
    let lower = floor(scaled(position));
    return bitcast<vec3<u32>>(vec3<i32>(lower)) & fields::parameters.cell_mask;
}

fn cell_index(cell: vec3<u32>) -> u32 {
    return cell.x | (cell.y << fields::parameters.log_cells_x) | (cell.z << fields::parameters.log_cells_xy);
}

// Set in a cell's start of wall samples if there are any in the rows around it.
const NEAR_WALLS: u32 = 0x80000000u;

fn is_near_walls(cell: vec3<u32>) -> bool {
    return fields::cell_start(fields::parameters.wall_starts + cell_index(cell)) >= NEAR_WALLS;
}

// A row of x-adjacent cells in the table of starts: `first` is the entry of its first cell, `end` the entry after its last.
// A row that wraps around continues at `wrapped`, up to `wrapped_end`; others have these two equal.
struct Cells {
    first: u32,
    end: u32,
    wrapped: u32,
    wrapped_end: u32,
}

// Cells `begin` up to `end` of row 0 .. 8 around a cell.
fn cells_of(grid: Shape, center: vec3<u32>, row: u32, begin: u32, end: u32) -> Cells {
    let y = (center.y + row % 3u - 1u) & grid.cell_mask.y;
    let z = (center.z + row / 3u - 1u) & grid.cell_mask.z;
    let base = (y << grid.log_cells_x) | (z << grid.log_cells_xy);
    let x = (center.x + begin - CELLS_PER_RADIUS) & grid.cell_mask.x;
    let after = x + end - begin;
    let over = after - min(after, grid.cell_mask.x + 1u);
    return Cells(base + x, base + after - over, base, base + over);
}

// Which cells of row 0 .. 8 around a point the support reaches: from the first number up to the second.
fn reached(place: Place, row: u32) -> vec2<u32> {
    // What is left of the support at the row's distance from the point.
    let side = vec2<f32>(f32(row % 3u), f32(row / 3u)) - 1.0;
    var gap = side * (max(side, vec2<f32>(0.0)) - place.inside.yz);
    var cells_per_radius = f32(CELLS_PER_RADIUS);
#ifdef PERIODIC
    gap /= fields::parameters.cells_per_radius.yz;
    cells_per_radius = fields::parameters.cells_per_radius.x;
#endif
    let left = SQUARED_REACH - dot(gap, gap);
    let reach = cells_per_radius * sqrt(max(left, 0.0));
    let center = place.inside.x + f32(CELLS_PER_RADIUS);
    let begin = u32(max(center - reach, 0.0));
    let end = min(u32(center + reach) + 1u, ROW_CELLS);
    return vec2<u32>(begin, select(begin, end, left > 0.0));
}

// Where the particles, or samples, of a row are: `straight` of them from `first`, and the others, where the row wraps
// around, `jump` further on.
struct Row {
    first: u32,
    straight: u32,
    jump: u32,
    count: u32,
}

// The start of a cell's particles or samples; the bit above is NEAR_WALLS.
fn start(entry: u32) -> u32 {
    return fields::cell_start(entry) & ~NEAR_WALLS;
}

// `section` is where the starts of the kind in question begin.
fn row_of(section: u32, cells: Cells) -> Row {
    let first = start(section + cells.first);
    let end = start(section + cells.end);
    var row = Row(first, end - first, 0u, end - first);
    if (cells.wrapped_end != cells.wrapped) {
        let other = start(section + cells.wrapped);
        row.jump = other - end;
        row.count += start(section + cells.wrapped_end) - other;
    }
    return row;
}

// A row of unknown length.
fn open_row_of(section: u32, cells: Cells) -> Row {
    var row = Row(start(section + cells.first), 0xffffffffu, 0u, 0xffffffffu);
    if (cells.wrapped_end != cells.wrapped) {
        let end = start(section + cells.end);
        row.straight = end - row.first;
        row.jump = start(section + cells.wrapped) - end;
    }
    return row;
}

// The particle or sample at place `t` of a row.
fn member(row: Row, t: u32) -> u32 {
    return row.first + t + select(0u, row.jump, t >= row.straight);
}
