// Lattices of cells that divide an image of any size evenly.

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
