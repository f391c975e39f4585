import afterimage::color::luminance;
import afterimage::math::smooth_step;

struct Halftone {
    amount: f32,
    pitch: f32,
    across: vec2f,
}

fn halftone(source: vec4f, at: Point, params: Halftone) -> vec4f {
    let p = vec2f(at.pixel) + 0.5;
    let turned = vec2f(dot(p, params.across), dot(p, vec2f(-params.across.y, params.across.x)));
    let cell = fract(turned / params.pitch) - 0.5;
    // A disc of this radius covers the share of the cell that the ink must leave white.
    let radius = sqrt(clamp(luminance(source.rgb), 0.0, 1.0) / 3.14159265);
    let edge = 0.7 / params.pitch;
    let paper = 1.0 - smooth_step(radius - edge, radius + edge, length(cell));
    return vec4f(mix(source.rgb, vec3f(paper), params.amount), source.a);
}
