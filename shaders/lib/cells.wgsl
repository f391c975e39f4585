// Lattices of cells that divide an image of any size evenly, and the arguments of kernels with a form by cells.

// A cell, and the position of an invocation in it.
struct Cell {
    // Column and row.
    place: vec2u,
    // Index of the invocation within the cell. Cells have a power of two of invocations.
    invocation: u32,
    invocations: u32,
    // Index of the cell within the workgroup.
    slot: u32,
}

// A pixel that overlaps a cell.
struct Seen {
    pixel: vec2i,
    color: vec4f,
    // The area within one of the finest cells, as a share of the pixel.
    share: f32,
    // True if the pixel's center is in the cell, which holds for one cell of each lattice.
    centered: bool,
}

// The share of a pixel within a cell along each axis. Integers before the division, so nothing is lost or counted
// twice.
fn cell_share(pixel: vec2u, cell: vec2u, pixels: vec2u, cells: vec2u) -> vec2f {
    let overlap = min((pixel + 1u) * cells, (cell + 1u) * pixels) - max(pixel * cells, cell * pixels);
    return vec2f(overlap) / vec2f(cells);
}

// The first pixel whose center is in the cell or beyond: the smallest p with (p + 1/2) / pixels * cells >= cell.
fn cell_first(cell: vec2u, pixels: vec2u, cells: vec2u) -> vec2u {
    return (max(2u * pixels * cell, cells) - cells + 2u * cells - 1u) / (2u * cells);
}
