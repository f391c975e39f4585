// Pictures of which a kernel looks at every `step`-th pixel of every `step`-th row only: they make up a smaller picture. Pixels are picked and
// not averaged, because an average of light before a logarithm is too bright.

fn stride_size(size: vec2u, step: u32) -> vec2u {
    return (size + step - 1u) / step;
}

// The pixel that stands for a place in the smaller picture; the last one for places outside.
fn stride_pixel(place: vec2u, size: vec2u, step: u32) -> vec2i {
    return vec2i(min(place * step + step / 2u, size - 1u));
}
