// Built-in arguments of a kernel function.

// The pixel of the result: its index, the uv of its center (v downwards) and the size of the image.
struct Point {
    pixel: vec2i,
    uv: vec2f,
    size: vec2f,
}

// The frame. Its time is a whole number of seconds and a part of one, because a float has no frames left after some
// hours. `dt` is in seconds. `reset` is 1 in the first frame and after a reset by the host, else 0.
struct Frame {
    seconds: u32,
    part: f32,
    dt: f32,
    index: u32,
    reset: u32,
}

// The phase, from 0 to 1, of what happens `rate` times in a second. It moves as evenly after a week as in the first
// second: the phase of the whole seconds is a product of integers, in 2^-32 of a cycle.
fn frame_phase(frame: Frame, rate: f32) -> f32 {
    let whole = frame.seconds * u32(fract(rate) * 4294967296.0);
    return fract(f32(whole) * 2.3283064365e-10 + fract(frame.part * rate));
}

// The four texels of an image of twice the size that lie under one texel.
struct Square {
    upper_left: vec4f,
    upper_right: vec4f,
    lower_left: vec4f,
    lower_right: vec4f,
}

// A square with black in the place of the texels that lie beyond the border of an image of `size`. The place of its
// upper left texel is even.
fn square_inside(square: Square, first: vec2i, size: vec2i) -> Square {
    let is_first = (first >= vec2i()) & (first < size);
    let is_second = is_first & (first + 1 < size);
    return Square(
        select(vec4f(), square.upper_left, is_first.x && is_first.y),
        select(vec4f(), square.upper_right, is_second.x && is_first.y),
        select(vec4f(), square.lower_left, is_first.x && is_second.y),
        select(vec4f(), square.lower_right, is_second.x && is_second.y),
    );
}
