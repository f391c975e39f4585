// Sampling with a stride: a kernel reads every `step`-th pixel of every `step`-th row, which form a smaller image.
// Pixels are not averaged, because a mean of light before a logarithm is too bright.

fn stride_size(size: vec2u, step: u32) -> vec2u {
    return (size + step - 1u) / step;
}

// The source pixel of a pixel of the smaller image. The last one for positions outside.
fn stride_pixel(place: vec2u, size: vec2u, step: u32) -> vec2i {
    return vec2i(min(place * step + step / 2u, size - 1u));
}
