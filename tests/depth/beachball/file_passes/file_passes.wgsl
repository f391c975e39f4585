fn file_passes_distance(depth: vec4f) -> vec4f {
    return vec4f(select(65504.0, depth.x, depth.x > 0.0), 0.0, 0.0, 1.0);
}

// The motion from the frame before is taken to be that to the next.
fn file_passes_moved(motion: vec4f) -> vec4f {
    return vec4f(motion.x, -motion.y, 0.0, 1.0);
}
