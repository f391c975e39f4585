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

// The first pixel of the square of a cell, if the cells cover the image.
fn stride_square(cell: vec2u, step: u32) -> vec2u {
    let block = cell / step;
    let own = cell - block * step;
    let random = hash(block.x ^ hash(block.y));
    let x = (own.y + (random & 0xffu)) % step;
    let y = (own.x + x * ((random >> 16u) & 0xffu) + ((random >> 8u) & 0xffu)) % step;
    return STRIDE_SQUARE * (cell * step + vec2u(x, y));
}

// The cells cover a little more than the image where a side is no multiple of theirs; scaled, they cover it.
fn stride_scaled(pixels: vec4u, side: u32, step: u32) -> vec4u {
    let covered = step * stride_size(vec2u(side), step).x;
    var scaled = pixels;
    if covered != side { scaled = (2u * pixels + 1u) * side / (2u * covered); }
    return min(scaled, vec4u(side - 1u));
}

// The source pixels of four pixels of the smaller image, one below the other in a square: the row of the first is a
// multiple of four. Some of the last for positions outside.
fn stride_rows(first: vec2u, size: vec2u, step: u32) -> array<vec2i, 4> {
    var corner = first;
    if step > 1u { corner = stride_square(first / STRIDE_SQUARE, step) + vec2u(first.x % STRIDE_SQUARE, 0u); }
    let x = i32(stride_scaled(vec4u(corner.x), size.x, step).x);
    let y = vec4i(stride_scaled(corner.y + vec4u(0u, 1u, 2u, 3u), size.y, step));
    return array(vec2i(x, y.x), vec2i(x, y.y), vec2i(x, y.z), vec2i(x, y.w));
}

// The source pixel of a pixel of the smaller image. One of the last for positions outside.
fn stride_pixel(place: vec2u, size: vec2u, step: u32) -> vec2i {
    if step == 1u { return vec2i(min(place, size - 1u)); }
    let pixel = stride_square(place / STRIDE_SQUARE, step) + place % STRIDE_SQUARE;
    return vec2i(vec2u(stride_scaled(vec4u(pixel.x), size.x, step).x, stride_scaled(vec4u(pixel.y), size.y, step).x));
}
