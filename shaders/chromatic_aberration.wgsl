// Lateral chromatic aberration: a lens magnifies red and blue otherwise than green. Each function is where in the
// source one channel of a pixel comes from.

struct ChromaticAberration {
    amount: f32,
    red: f32,
    blue: f32,
    growth: f32,
    center: vec2f,
}

// `magnification` is that at the corners of the image, less 1.
fn chromatic_aberration_place(at: Point, magnification: f32, params: ChromaticAberration) -> vec4f {
    let place = at.uv - 0.5 - params.center;
    let round = place * 2.0 * at.size / length(at.size);
    let share = mix(1.0, dot(round, round), params.growth);
    let scale = 1.0 + params.amount * magnification * share;
    return vec4f(0.5 + params.center + place / scale, 0.0, 0.0);
}

fn chromatic_aberration_red(at: Point, params: ChromaticAberration) -> vec4f {
    return chromatic_aberration_place(at, params.red, params);
}

fn chromatic_aberration_green(at: Point, params: ChromaticAberration) -> vec4f {
    return chromatic_aberration_place(at, 0.0, params);
}

fn chromatic_aberration_blue(at: Point, params: ChromaticAberration) -> vec4f {
    return chromatic_aberration_place(at, params.blue, params);
}
