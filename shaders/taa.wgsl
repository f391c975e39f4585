// Temporal anti-aliasing: the result of the frame before is read where each surface was, limited to what is seen around
// the pixel now, and a part of the new frame is mixed in. Karis, "High Quality Temporal Supersampling", SIGGRAPH 2014;
// the limit by mean and variance: Salvi, "An Excursion in Temporal Supersampling", GDC 2016.
import afterimage::camera::{Camera, camera_place, camera_previous_uv, camera_world};
import afterimage::depth::depth_at;
import afterimage::grade::bounded_scene;
import afterimage::math::{between, between3};

struct Taa {
    blend: f32,
    variance: f32,
    depth_threshold: f32,
    white: f32,
    scale: vec2f,          // from the numbers of the motion image to uv
    has_motion: f32,       // 1 or 0, as the next two
    has_depth: f32,        // of the frame before
    has_exposure: f32,
    moving: f32,
    keep_above: f32,
    size: f32,             // pixels of the result for one of the source, along a side: 1 or 2
    texel: f32,            // and its inverse
}

// Falloff of the weight of a sample with the square of its distance from the middle of the pixel, in pixels.
const TAA_SHARPNESS: f32 = 2.29;
// The mean of all weights of samples that are two pixels apart: pi / (4 * TAA_SHARPNESS).
const TAA_SPARSE: f32 = 0.343;

fn taa_brightness(light: vec3f) -> f32 {
    return 0.25 * light.r + 0.5 * light.g + 0.25 * light.b;
}

// Light without the part above `keep_above`, which is that of lamps.
fn taa_without_lamps(light: vec3f, params: Taa) -> vec3f {
    return light * min(params.keep_above / max(taa_brightness(light), 1e-7), 1.0);
}

// Light in YCoCg times its weight, and the weight: bright light counts less in means, that at `white` half.
fn taa_packed(light: vec3f, white: f32) -> vec4f {
    let y = taa_brightness(light);
    let color = vec3f(y, 0.5 * (light.r - light.b), 0.5 * light.g - 0.25 * (light.r + light.b));
    return vec4f(color, 1.0) / (1.0 + max(y, 0.0) / white);
}

fn taa_unpacked(packed: vec4f) -> vec3f {
    let color = packed.xyz / max(packed.w, 1e-7);
    return vec3f(color.x + color.y - color.z, color.x + color.z, color.x - color.y - color.z);
}

// The neighborhood of a pixel: the new color, and the limits of the old one.
struct TaaAround {
    color: vec4f,
    mean: vec4f,
    below: vec3f,   // from the mean to the least and to the greatest
    above: vec3f,
    brightest: f32,
    keep_above: f32,
    alpha: vec3f,   // new, least and greatest
    nearness: f32,  // how much the samples of this frame say about the pixel, 1 on average
}

fn taa_around(source: texture_2d<f32>, p: vec2i, jitter: vec2f, params: Taa) -> TaaAround {
    // The variance is of differences from the pixel itself: that of colors loses its digits where they are alike.
    let middle = taa_packed(taa_without_lamps(texel(source, p).rgb, params), params.white);
    var sum = vec4f();
    var total = 0.0;
    var mean = vec4f();
    var square = vec3f();
    var least = vec3f(1e9);
    var greatest = vec3f(-1e9);
    var brightest = 0.0;
    var alpha = vec3f(0.0, 1e9, -1e9);
    for (var y = -1; y <= 1; y++) {
        for (var x = -1; x <= 1; x++) {
            let pixel = texel(source, p + vec2i(x, y));
            let light = pixel.rgb;
            brightest = max(brightest, taa_brightness(light));
            let color = taa_packed(taa_without_lamps(light, params), params.white);
            let away = params.size * (vec2f(f32(x), f32(y)) + jitter);
            let weight = exp(-TAA_SHARPNESS * dot(away, away));
            sum += weight * color;
            total += weight;
            alpha = vec3f(alpha.x + weight * color.w * pixel.a, min(alpha.y, pixel.a), max(alpha.z, pixel.a));
            let apart = color - middle;
            mean += apart / 9.0;
            square += apart.xyz * apart.xyz / 9.0;
            least = min(least, color.xyz);
            greatest = max(greatest, color.xyz);
        }
    }
    // A frame that is doubled shows less of what is around.
    let most = params.variance * params.size * sqrt(max(square - mean.xyz * mean.xyz, vec3f(0.0)));
    mean += middle;
    let below = min(mean.xyz - least, most);
    let above = min(greatest - mean.xyz, most);
    let nearness = select(1.0, total / TAA_SPARSE, params.size > 1.0);
    alpha.x /= max(sum.w, 1e-7);
    return TaaAround(sum / max(total, 1e-7), mean, below, above, brightest, params.keep_above, alpha, nearness);
}

// True if a bright light is wide, as a sky is: three of the eight pixels at this distance show it, too.
const TAA_WIDE: i32 = 8;

fn taa_is_wide(source: texture_2d<f32>, p: vec2i, params: Taa) -> bool {
    var count = 0;
    for (var i = 0; i < 9; i++) {
        let step = vec2i(i % 3 - 1, i / 3 - 1);
        let light = texel(source, p + TAA_WIDE * step).rgb;
        count += select(0, 1, i != 4 && taa_brightness(light) > params.keep_above);
    }
    return count > 2;
}

// The neighborhood of a pixel. Wide lights are no lamps: edges before them would have steps, and of a wide light that a
// mean dims at its edge little is lost.
fn taa_seen(source: texture_2d<f32>, p: vec2i, jitter: vec2f, params: Taa) -> TaaAround {
    let around = taa_around(source, p, jitter, params);
    if around.brightest <= params.keep_above || !taa_is_wide(source, p, params) { return around; }
    var all = params;
    all.keep_above = HALF_MAX;
    return taa_around(source, p, jitter, all);
}

// The nearest of the nine texels around: edges move with the surface in front.
fn taa_nearest(depth: texture_2d<f32>, p: vec2i) -> vec2i {
    var nearest = p;
    var least = depth_at(depth, p);
    for (var y = -1; y <= 1; y++) {
        for (var x = -1; x <= 1; x++) {
            let found = depth_at(depth, p + vec2i(x, y));
            nearest = select(nearest, p + vec2i(x, y), found < least);
            least = min(least, found);
        }
    }
    return clamp(nearest, vec2i(0), vec2i(textureDimensions(depth)) - 1);
}

// The place in the world that is seen at a texel.
fn taa_world(depth: texture_2d<f32>, camera: Camera, p: vec2i) -> vec3f {
    let uv = (vec2f(p) + 0.5 + camera.jitter) / vec2f(textureDimensions(depth));
    return camera_world(camera, camera_place(camera, uv, depth_at(depth, p)));
}

// The motion of a texel since the previous frame, in uv: by the motion image, or of static surfaces.
fn taa_motion(depth: texture_2d<f32>, motion: texture_2d<f32>, camera: Camera, p: vec2i, params: Taa) -> vec2f {
    let uv = (vec2f(p) + 0.5 + camera.jitter) / vec2f(textureDimensions(depth));
    let still = uv - camera_previous_uv(camera, taa_world(depth, camera, p)).xy;
    let moved = texel(motion, p).xy * params.scale;
    return clamp(select(still, moved, params.has_motion > 0.5), vec2f(-4.0), vec2f(4.0));
}

// True if the surface of a texel was visible in the previous frame: its distance then is that of a texel there.
fn taa_was_seen(
    depth: texture_2d<f32>,
    previous_depth: texture_2d<f32>,
    camera: Camera,
    p: vec2i,
    there: vec2f,
    params: Taa,
) -> bool {
    let place = camera.previous_view * vec4f(taa_world(depth, camera, p), 1.0);
    let expected = max(-place.z, 1e-3);
    let size = vec2f(textureDimensions(previous_depth));
    let middle = vec2i(floor(clamp(there * size - camera.previous_jitter, vec2f(-4.0), size + 4.0)));
    var off = 1e9;
    for (var y = -1; y <= 1; y++) {
        for (var x = -1; x <= 1; x++) {
            let found = depth_at(previous_depth, middle + vec2i(x, y));
            off = min(off, abs(found - expected) / min(expected, found));
        }
    }
    // A distance of the sky has no meaning in detail.
    return off < params.depth_threshold || (expected > 30000.0 && off < 2.0);
}

// The weights of a Catmull-Rom spline for the texels -1, 0, 1 and 2 at a place between 0 and 1.
fn taa_weights(x: f32) -> vec4f {
    let first = x * (-0.5 + x * (1.0 - 0.5 * x));
    let second = 1.0 + x * x * (-2.5 + 1.5 * x);
    let third = x * (0.5 + x * (2.0 - 1.5 * x));
    return vec4f(first, second, third, x * x * (0.5 * x - 0.5));
}

// A sharp filter of the history, which is filtered again in every frame.
fn taa_bicubic(history: texture_2d<f32>, uv: vec2f) -> vec4f {
    let size = vec2f(textureDimensions(history));
    let place = clamp(uv * size - 0.5, vec2f(-2.0), size + 1.0);
    let base = floor(place);
    let across = taa_weights(place.x - base.x);
    let down = taa_weights(place.y - base.y);
    var sum = vec4f();
    for (var y = 0; y < 4; y++) {
        for (var x = 0; x < 4; x++) {
            let color = texel(history, vec2i(base) + vec2i(x - 1, y - 1));
            sum += across[x] * down[y] * color;
        }
    }
    return sum;
}

// A color limited to what is seen around, and to a number of deviations, on the way to the mean.
fn taa_limited(color: vec4f, around: TaaAround) -> vec4f {
    let away = color - around.mean;
    let room = select(around.below, around.above, away.xyz > vec3f(0.0));
    let units = abs(away.xyz) / max(room, vec3f(1e-6));
    return around.mean + away / max(max(max(units.x, units.y), units.z), 1.0);
}

// The share of the new frame: more where the history is read between its texels, which softens it once more. What a
// reading takes grows with the variance of its filter: x (1 - x) of two texels at a place x between them. Yang and
// others, "Amortized Supersampling", SIGGRAPH Asia 2009.
fn taa_share(there: vec2f, size: vec2f, params: Taa) -> f32 {
    let place = clamp(there, vec2f(0.0), vec2f(1.0)) * size - 0.5;
    let part = place - floor(place);
    return max(params.blend, params.moving * 2.0 * dot(part, 1.0 - part));
}

// The light of the history without lamps, and that of lamps alone. Four texels, because the spline's negative weights
// would take a sun from what is around it.
struct TaaSplit {
    light: vec3f,
    lamps: vec3f,
}

fn taa_split(history: texture_2d<f32>, uv: vec2f, ratio: f32, params: Taa) -> TaaSplit {
    let size = vec2f(textureDimensions(history));
    let place = clamp(uv * size - 0.5, vec2f(-2.0), size + 1.0);
    let base = floor(place);
    let part = place - base;
    var sum = TaaSplit();
    for (var i = 0; i < 4; i++) {
        let corner = vec2i(i & 1, i >> 1u);
        let weights = select(1.0 - part, part, corner == vec2i(1));
        let light = bounded_scene(texel(history, vec2i(base) + corner).rgb * ratio);
        let limited = taa_without_lamps(light, params);
        sum.light += weights.x * weights.y * limited;
        sum.lamps += weights.x * weights.y * (light - limited);
    }
    return sum;
}

// The light of lamps: means count it in full, so that none of it is lost. That of the history is limited to what is
// seen around.
fn taa_lamps(source: texture_2d<f32>, p: vec2i, jitter: vec2f, old: vec3f, share: f32, params: Taa) -> vec3f {
    var sum = vec3f();
    var total = 0.0;
    var least = vec3f(1e9);
    var greatest = vec3f(-1e9);
    for (var i = 0; i < 9; i++) {
        let step = vec2i(i % 3 - 1, i / 3 - 1);
        let light = texel(source, p + step).rgb;
        let lamps = light - taa_without_lamps(light, params);
        let away = params.size * (vec2f(step) + jitter);
        let weight = exp(-TAA_SHARPNESS * dot(away, away));
        sum += weight * lamps;
        total += weight;
        least = min(least, lamps);
        greatest = max(greatest, lamps);
    }
    return between3(clamp(old, least, greatest), sum / max(total, 1e-7), share);
}

// The pixel of the source under a pixel of the result, and the way from there to its sample, in pixels of the source.
struct TaaPlace {
    pixel: vec2i,
    jitter: vec2f,
}

fn taa_place(at: Point, jitter: vec2f, params: Taa) -> TaaPlace {
    let middle = (vec2f(at.pixel) + 0.5) * params.texel;
    let pixel = floor(middle);
    return TaaPlace(vec2i(pixel), jitter + (pixel + 0.5 - middle));
}

// The result of a pixel: the new frame, blended with the history if that is valid there.
fn taa_mixed(
    source: texture_2d<f32>,
    history: texture_2d<f32>,
    old: vec4f,
    around: TaaAround,
    is_seen: bool,
    there: vec2f,
    ratio: f32,
    place: TaaPlace,
    at: Point,
    params: Taa,
) -> vec4f {
    let share = select(1.0, min(taa_share(there, at.size, params) * around.nearness, 1.0), is_seen);
    var light = old.rgb;
    var lamps = vec3f();
    if around.brightest > around.keep_above {
        let split = taa_split(history, there, ratio, params);
        light = split.light;
        lamps = taa_lamps(source, place.pixel, place.jitter, split.lamps, share, params);
    }
    let packed = taa_limited(taa_packed(light, params.white), around);
    let mixed = taa_unpacked(between(packed, around.color, share));
    return vec4f(bounded_scene(mixed + lamps), taa_alpha(old.a, packed.w, around, share));
}

// The alpha of a mixture: each weighs as much as its color does, and that of the history is limited to what is seen
// around.
fn taa_alpha(old: f32, weight: f32, around: TaaAround, share: f32) -> f32 {
    let weights = vec2f(weight * (1.0 - share), around.color.w * share);
    let limited = clamp(old, around.alpha.y, around.alpha.z);
    let mixed = dot(weights, vec2f(limited, around.alpha.x)) / max(weights.x + weights.y, 1e-7);
    return clamp(mixed, around.alpha.y, around.alpha.z);
}

// The history of the exposure of this frame.
fn taa_exposed(old: vec4f, ratio: f32) -> vec4f {
    return vec4f(bounded_scene(old.rgb * ratio), old.a);
}

// True if the history is valid at a place.
fn taa_inside(there: vec2f, frame: Frame) -> bool {
    return frame.reset == 0u && all(there >= vec2f(0.0)) && all(there <= vec2f(1.0));
}

// The exposure relative to that of the previous frame.
fn taa_ratio(meter: f32, previous_exposure: texture_2d<f32>, params: Taa) -> f32 {
    let stops = meter - texel(previous_exposure, vec2i(0)).x;
    return exp2(params.has_exposure * clamp(stops, -16.0, 16.0));
}

// The exposure, for the next frame.
fn taa_exposure(meter: f32) -> vec4f {
    return vec4f(meter, 0.0, 0.0, 1.0);
}

fn taa(
    source: texture_2d<f32>,
    history: texture_2d<f32>,
    depth: texture_2d<f32>,
    previous_depth: texture_2d<f32>,
    motion: texture_2d<f32>,
    previous_exposure: texture_2d<f32>,
    camera: Camera,
    meter: f32,
    at: Point,
    frame: Frame,
    params: Taa,
) -> vec4f {
    let place = taa_place(at, camera.jitter, params);
    let around = taa_seen(source, place.pixel, place.jitter, params);
    let there = at.uv - taa_motion(depth, motion, camera, taa_nearest(depth, place.pixel), params);
    let was_seen = taa_was_seen(depth, previous_depth, camera, place.pixel, there, params);
    let is_seen = taa_inside(there, frame) && (was_seen || params.has_depth < 0.5);
    let ratio = taa_ratio(meter, previous_exposure, params);
    let old = taa_exposed(taa_bicubic(history, there), ratio);
    return taa_mixed(source, history, old, around, is_seen, there, ratio, place, at, params);
}

// The same with a filter of four texels.
fn taa_bilinear(
    source: texture_2d<f32>,
    history: texture_2d<f32>,
    history_sampler: sampler,
    depth: texture_2d<f32>,
    previous_depth: texture_2d<f32>,
    motion: texture_2d<f32>,
    previous_exposure: texture_2d<f32>,
    camera: Camera,
    meter: f32,
    at: Point,
    frame: Frame,
    params: Taa,
) -> vec4f {
    let place = taa_place(at, camera.jitter, params);
    let around = taa_seen(source, place.pixel, place.jitter, params);
    let there = at.uv - taa_motion(depth, motion, camera, taa_nearest(depth, place.pixel), params);
    let was_seen = taa_was_seen(depth, previous_depth, camera, place.pixel, there, params);
    let is_seen = taa_inside(there, frame) && (was_seen || params.has_depth < 0.5);
    let ratio = taa_ratio(meter, previous_exposure, params);
    let old = taa_exposed(tap(history, history_sampler, there), ratio);
    return taa_mixed(source, history, old, around, is_seen, there, ratio, place, at, params);
}
