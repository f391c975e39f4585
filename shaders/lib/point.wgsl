// Built-in arguments of a kernel function.

// The pixel of the result: its index, the uv of its center (v downwards) and the size of the image.
struct Point {
    pixel: vec2i,
    uv: vec2f,
    size: vec2f,
}

// The frame. `time` and `dt` are in seconds. `reset` is 1 in the first frame and after a reset by the host, else 0.
struct Frame {
    time: f32,
    dt: f32,
    index: u32,
    reset: u32,
}

// The four texels of an image of twice the size that lie under one texel.
struct Square {
    upper_left: vec4f,
    upper_right: vec4f,
    lower_left: vec4f,
    lower_right: vec4f,
}
