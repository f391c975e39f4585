// Streaks of light to several sides, as anamorphic lenses and the blades of an aperture make them: each an exponential
// tail, from passes of four taps whose distances grow by the factor four. The product of the passes is the whole tail:
// Kawase, "Frame Buffer Postprocessing Effects in DOUBLE-S.T.E.A.L", GDC 2003.
import afterimage::grade::{bounded, bounded_scene};

struct StreaksTail {
    step: vec2f,  // texels from a tap to the next
    decay: f32,   // factor from one tap to the next
    scale: f32,   // 1 / (1 + decay + decay^2 + decay^3)
}

struct Streaks {
    intensity: f32,
    tint: vec3f,
    share: f32,  // of each tail
}

// Outside of the image there is no light.
fn streaks_tap(source: texture_2d<f32>, source_sampler: sampler, place: vec2f) -> vec3f {
    let size = vec2f(textureDimensions(source));
    let inside = clamp(min(place, size - place) + 0.5, vec2f(0.0), vec2f(1.0));
    return inside.x * inside.y * tap(source, source_sampler, place / size).rgb;
}

fn streaks_tail(source: texture_2d<f32>, source_sampler: sampler, at: Point, params: StreaksTail) -> vec4f {
    var sum = vec3f(0.0);
    var weight = params.scale;
    for (var i = 0; i < 4; i++) {
        let place = vec2f(at.pixel) + 0.5 - f32(i) * params.step;
        sum += weight * streaks_tap(source, source_sampler, place);
        weight *= params.decay;
    }
    return vec4f(bounded(sum), 1.0);
}

fn streaks_both(before: vec4f, after: vec4f) -> vec4f {
    return vec4f(bounded(before.rgb + after.rgb), 1.0);
}

fn streaks(source: vec4f, tails: vec4f, params: Streaks) -> vec4f {
    return vec4f(bounded_scene(params.intensity * params.share * params.tint * tails.rgb), source.a);
}
