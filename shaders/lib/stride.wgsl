// Sampling with a stride: a kernel reads one pixel of each cell of about `step` times `step` pixels, and these form a
// smaller image. Pixels are not averaged, because a mean of light before a logarithm is too bright.
//
// A regular grid of pixels aliases: of a picture of lines it sees either all lines or none. So the pixel of a cell is
// chosen by a hash, the same in every frame. In each block of `step` times `step` cells, every row, every column and
// every position in a cell is chosen once: lines along an axis are counted exactly.
#import noise

fn stride_size(size: vec2u, step: u32) -> vec2u {
    return (size + step - 1u) / step;
}

// The source pixel of a pixel of the smaller image. One of the last for positions outside.
fn stride_pixel(place: vec2u, size: vec2u, step: u32) -> vec2i {
    if step == 1u { return vec2i(min(place, size - 1u)); }
    let block = place / step;
    let own = place - block * step;
    let random = hash(block.x ^ hash(block.y));
    let x = (own.y + (random & 0xffu)) % step;
    let y = (own.x + x * ((random >> 16u) & 0xffu) + ((random >> 8u) & 0xffu)) % step;
    // The cells cover a little more than the image where a side is no multiple of the step; scaled, they cover it.
    let within = 2u * (place * step + vec2u(x, y)) + 1u;
    return vec2i(min(within * size / (2u * step * stride_size(size, step)), size - 1u));
}
