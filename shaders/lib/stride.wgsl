// Sampling with a stride: a kernel reads one square of 4x4 pixels of each `step` times `step` squares, and these form a
// smaller image. Single pixels far from each other would take as long as all: memory is read by lines. Pixels are not
// averaged, because a mean of light before a logarithm is too bright.
//
// A regular grid aliases: of a picture of lines it sees all lines or none. So the square of a cell is chosen by a
// hash, the same in every frame. In each block of `step` times `step` cells, every row, every column and every position
// in a cell is chosen once: lines along an axis are counted exactly.
import package::noise::hash;

const STRIDE_SQUARE: u32 = 4u;

fn stride_size(size: vec2u, step: u32) -> vec2u {
    if step == 1u { return size; }
    return (size + STRIDE_SQUARE * step - 1u) / (STRIDE_SQUARE * step) * STRIDE_SQUARE;
}

// The source pixel of a pixel of the smaller image. One of the last for positions outside.
fn stride_pixel(place: vec2u, size: vec2u, step: u32) -> vec2i {
    if step == 1u { return vec2i(min(place, size - 1u)); }
    let cell = place / STRIDE_SQUARE;
    let block = cell / step;
    let own = cell - block * step;
    let random = hash(block.x ^ hash(block.y));
    let x = (own.y + (random & 0xffu)) % step;
    let y = (own.x + x * ((random >> 16u) & 0xffu) + ((random >> 8u) & 0xffu)) % step;
    // The cells cover a little more than the image where a side is no multiple of theirs; scaled, they cover it.
    let within = 2u * (STRIDE_SQUARE * (cell * step + vec2u(x, y)) + place % STRIDE_SQUARE) + 1u;
    return vec2i(min(within * size / (2u * step * stride_size(size, step)), size - 1u));
}
