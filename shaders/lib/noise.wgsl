// Noise from integers: equal bits on every device, unlike hashes made from sines.

// PCG output permutation over one LCG step (Jarzynski and Olano, "Hash Functions for GPU Rendering", 2020).
fn hash(v: u32) -> u32 {
    let state = v * 747796405u + 2891336453u;
    let word = ((state >> ((state >> 28u) + 4u)) ^ state) * 277803737u;
    return (word >> 22u) ^ word;
}

// Three independent numbers from three (PCG3D, the same source): cheaper than three hashes.
fn hash3(seed: vec3u) -> vec3u {
    var v = seed * 1664525u + 1013904223u;
    v.x += v.y * v.z;
    v.y += v.z * v.x;
    v.z += v.x * v.y;
    v ^= v >> vec3u(16u);
    v.x += v.y * v.z;
    v.y += v.z * v.x;
    v.z += v.x * v.y;
    return v;
}

// A number in [0, 1) for each cell of the plane: the top 24 bits, which a float holds exactly.
fn hash_cell(cell: vec2i) -> f32 {
    let h = hash(bitcast<u32>(cell.x) ^ hash(bitcast<u32>(cell.y)));
    return f32(h >> 8u) * (1.0 / 16777216.0);
}

// The cell that contains a point, limited to the range of integers.
fn noise_cell(p: vec2f) -> vec2i {
    return vec2i(clamp(floor(p), vec2f(-1e6), vec2f(1e6)));
}

// Value noise in [0, 1), one cell per unit, with a continuous first derivative. Constant beyond a million cells.
fn noise(at: vec2f) -> f32 {
    let i = noise_cell(at);
    let f = clamp(at - vec2f(i), vec2f(0.0), vec2f(1.0));
    let w = f * f * (3.0 - 2.0 * f);
    let low = mix(hash_cell(i), hash_cell(i + vec2i(1, 0)), w.x);
    let high = mix(hash_cell(i + vec2i(0, 1)), hash_cell(i + vec2i(1, 1)), w.x);
    return mix(low, high, w.y);
}
