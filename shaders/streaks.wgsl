// Streaks of light to both sides, as anamorphic lenses make them: an exponential tail, from passes of four taps whose
// distances grow by the factor four. The product of the passes is the whole tail: Kawase, "Frame Buffer Postprocessing
// Effects in DOUBLE-S.T.E.A.L", GDC 2003.
import afterimage::grade::{bounded, bounded_scene};

struct Streaks {
    axis: vec2i,
    step: i32,   // texels between the taps; negative to the other side
    decay: f32,  // factor from one tap to the next
    scale: f32,  // 1 / (1 + decay + decay^2 + decay^3)
    intensity: f32,
    tint: vec3f,
}

// Outside of the image there is no light.
fn streaks_texel(source: texture_2d<f32>, p: vec2i) -> vec3f {
    let is_inside = all(p >= vec2i(0)) && all(p < vec2i(textureDimensions(source)));
    return select(vec3f(0.0), texel(source, p).rgb, is_inside);
}

fn streaks_tail(source: texture_2d<f32>, at: Point, params: Streaks) -> vec4f {
    var sum = vec3f(0.0);
    var weight = params.scale;
    for (var i = 0; i < 4; i++) {
        sum += weight * streaks_texel(source, at.pixel + i * params.step * params.axis);
        weight *= params.decay;
    }
    return vec4f(bounded(sum), 1.0);
}

fn streaks(source: vec4f, before: vec4f, after: vec4f, params: Streaks) -> vec4f {
    let light = 0.5 * before.rgb + 0.5 * after.rgb;
    return vec4f(bounded_scene(params.intensity * params.tint * light), source.a);
}
