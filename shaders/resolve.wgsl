// One pixel from samples. A mean of light before a tone curve lets one bright sample hide the others, so light may be
// weighted by 1 / (1 + gain * its largest component) (Karis, "Tone Mapping", 2013; Lottes). The window of the wider
// filters is that of Harris, "On the Use of Windows for Harmonic Analysis", 1978, by the distance from the pixel's
// center (Pettineo, "Experimenting with Reconstruction Filters for MSAA Resolve", 2012). A sample with a number that is
// NaN counts nowhere.
import afterimage::grade::bounded_scene;

struct Resolve {
    gain: f32,
    radius: f32,       // of the window in pixels; 0 for the mean over the pixel
    reach: i32,        // pixels to each side that the window may touch
}

struct ResolveChoice {
    is_largest: f32,   // 1 to choose the sample with the largest x, 0 for the smallest
}

// A number of 4 bits of this one.
fn resolve_digit(digits: vec2u, index: i32) -> f32 {
    let word = select(digits.x, digits.y, index >= 8);
    return f32((word >> (4u * u32(index & 7))) & 15u);
}

// The position of a sample in its pixel: the standard places of Vulkan, Direct3D and Metal, in sixteenths.
fn resolve_place(count: i32, index: i32) -> vec2f {
    var x = vec2u(0x8u, 0u);
    var y = vec2u(0x8u, 0u);
    if count == 2 { x.x = 0x4cu; y.x = 0x4cu; }
    if count == 4 { x.x = 0xa2e6u; y.x = 0xea62u; }
    if count == 8 { x.x = 0xfb135d79u; y.x = 0x1f7d39b5u; }
    if count == 16 { x = vec2u(0xbda3c579u, 0x1ef02486u); y = vec2u(0x3bd67a59u, 0x0f48c21eu); }
    return vec2f(resolve_digit(x, index), resolve_digit(y, index)) / 16.0;
}

// The Blackman-Harris window: 1 in the middle, 6e-5 at 1, and nothing beyond.
fn resolve_window(distance: f32) -> f32 {
    let turn = 3.14159265 * min(distance, 1.0);
    let sum = 0.35875 + 0.48829 * cos(turn) + 0.14128 * cos(2.0 * turn) + 0.01168 * cos(3.0 * turn);
    return select(0.0, sum, distance < 1.0);
}

fn resolve(source: texture_multisampled_2d<f32>, at: Point, params: Resolve) -> vec4f {
    let count = i32(textureNumSamples(source));
    let size = vec2i(textureDimensions(source));
    let reach = min(params.reach, 2);
    var light = vec4f();
    var alpha = vec2f();
    for (var j = -reach; j <= reach; j++) {
        for (var i = -reach; i <= reach; i++) {
            let p = at.pixel + vec2i(i, j);
            if any(p < vec2i(0)) || any(p >= size) { continue; }
            for (var k = 0; k < count; k++) {
                if !is_sample_known(source, p, k) { continue; }
                let one = texel_sample(source, p, k);
                let apart = vec2f(f32(i), f32(j)) + resolve_place(count, k) - 0.5;
                let share = select(1.0, resolve_window(length(apart) / max(params.radius, 1e-3)), params.radius > 0.0);
                let largest = max(max(one.r, one.g), max(one.b, 0.0));
                let weight = share / (1.0 + params.gain * largest);
                light += weight * vec4f(one.rgb, 1.0);
                alpha += share * vec2f(one.a, 1.0);
            }
        }
    }
    return vec4f(bounded_scene(light.rgb / max(light.w, 1e-30)), alpha.x / max(alpha.y, 1e-30));
}

// The sample with the smallest or the largest x: of depths, a mean would lie on neither surface.
fn resolve_chosen(source: texture_multisampled_2d<f32>, at: Point, params: ResolveChoice) -> vec4f {
    let count = i32(textureNumSamples(source));
    var best = vec4f();
    var has_one = false;
    for (var k = 0; k < count; k++) {
        if !is_sample_known(source, at.pixel, k) { continue; }
        let one = texel_sample(source, at.pixel, k);
        let is_better = select((one.x < best.x), (one.x > best.x), params.is_largest > 0.5);
        best = select(best, one, is_better || !has_one);
        has_one = true;
    }
    return best;
}
