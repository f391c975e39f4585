// Lattices of cells that divide an image evenly, whatever its size, and what kernels in their form by cells are told.

// A cell, and an invocation's part in it.
struct Cell {
    // Its column and row.
    place: vec2u,
    // The number of the invocation among those of the cell, which are a power of two.
    invocation: u32,
    invocations: u32,
    // The number of the cell among those of the workgroup.
    slot: u32,
}

// A pixel that touches a cell.
struct Seen {
    pixel: vec2i,
    color: vec4f,
    // How much of it is meant: what lies in one of the finest cells, in parts of a pixel.
    share: f32,
    // Whether its centre lies there, which is so in one cell of each lattice.
    centred: bool,
}

// How much of a pixel lies in a cell along each axis, in parts of a pixel: whole numbers before the division, so nothing is lost or
// counted twice.
fn cell_share(pixel: vec2u, cell: vec2u, pixels: vec2u, cells: vec2u) -> vec2f {
    let overlap = min((pixel + 1u) * cells, (cell + 1u) * pixels) - max(pixel * cells, cell * pixels);
    return vec2f(overlap) / vec2f(cells);
}

// The first pixel whose centre lies in the cell or beyond: the least p with (p + 1/2) / pixels * cells >= cell.
fn cell_first(cell: vec2u, pixels: vec2u, cells: vec2u) -> vec2u {
    return (max(2u * pixels * cell, cells) - cells + 2u * cells - 1u) / (2u * cells);
}
