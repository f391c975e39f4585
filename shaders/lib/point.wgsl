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

// A square of an open image of `size`: half of those of its texels that lie beyond the border. The place of its upper
// left texel is even.
fn square_open(square: Square, first: vec2i, size: vec2i) -> Square {
    let is_first = (first >= vec2i()) & (first < size);
    let of_first = select(vec2f(0.5), vec2f(1.0), is_first);
    let of_second = select(vec2f(0.5), vec2f(1.0), is_first & (first + 1 < size));
    return Square(
        square.upper_left * (of_first.x * of_first.y),
        square.upper_right * (of_second.x * of_first.y),
        square.lower_left * (of_first.x * of_second.y),
        square.lower_right * (of_second.x * of_second.y),
    );
}
