// What a kernel may know of where and when it runs.

// The pixel being made: its index, the uv of its centre (v down) and the size of the image it belongs to.
struct Point {
    pixel: vec2i,
    uv: vec2f,
    size: vec2f,
}

// The frame being made. `time` and `dt` are in seconds; `reset` is 1 on the first frame and after a cut, else 0.
struct Frame {
    time: f32,
    dt: f32,
    index: u32,
    reset: u32,
}

// The four texels of an image twice as large that lie under one texel.
struct Square {
    upper_left: vec4f,
    upper_right: vec4f,
    lower_left: vec4f,
    lower_right: vec4f,
}
