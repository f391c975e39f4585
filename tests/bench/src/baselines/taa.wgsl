// Temporal anti-aliasing, written by hand after Karis, "High Quality Temporal Supersampling", SIGGRAPH 2014, with the
// limit by mean and variance of Salvi, "An Excursion in Temporal Supersampling", GDC 2016: one pass. The Catmull-Rom
// spline over sixteen texels is nine filtered reads.

struct Settings {
    reprojection: vec4f,   // the row of the matrix from the camera's space to that before that gives the distance
    factor: vec2f,         // from uv to the camera's x and y at a distance of 1
    offset: vec2f,
    jitter: vec2f,
    previous_jitter: vec2f,
    blend: f32,
    moving: f32,
    variance: f32,
    threshold: f32,
    white: f32,
}

@group(0) @binding(0) var<uniform> settings: Settings;
@group(0) @binding(1) var linear: sampler;
@group(0) @binding(2) var scene: texture_2d<f32>;
@group(0) @binding(3) var history: texture_2d<f32>;
@group(0) @binding(4) var depths: texture_2d<f32>;
@group(0) @binding(5) var previous_depths: texture_2d<f32>;
@group(0) @binding(6) var motions: texture_2d<f32>;
@group(0) @binding(7) var smooth_image: texture_storage_2d<rgba16float, write>;

// YCoCg and a weight that falls with the brightness.
fn pack(c: vec3f) -> vec4f {
    let y = 0.25 * (c.r + c.b) + 0.5 * c.g;
    return vec4f(y, 0.5 * (c.r - c.b), 0.5 * c.g - 0.25 * (c.r + c.b), 1.0) / (1.0 + max(y, 0.0) / settings.white);
}

fn unpack(packed: vec4f) -> vec3f {
    let c = packed.xyz / max(packed.w, 1e-7);
    return vec3f(c.x + c.y - c.z, c.x + c.z, c.x - c.y - c.z);
}

// Light that a half float holds. Components of colors outside of Rec.709, and of what the spline overshoots, are
// negative as long as the luminance is not.
fn limited_light(rgb: vec3f) -> vec3f {
    let weights = vec3f(0.2126, 0.7152, 0.0722);
    let bounded = clamp(rgb, vec3f(-65504.0), vec3f(65504.0));
    let light = max(bounded, vec3f(0.0));
    let share = dot(light, weights) / max(dot(light - bounded, weights), 1e-30);
    return light + min(share, 1.0) * min(bounded, vec3f(0.0));
}

fn catmull_rom(uv: vec2f) -> vec3f {
    let size = vec2f(textureDimensions(history));
    let place = uv * size;
    let middle = floor(place - 0.5) + 0.5;
    let x = place - middle;
    let w0 = x * (-0.5 + x * (1.0 - 0.5 * x));
    let w1 = 1.0 + x * x * (-2.5 + 1.5 * x);
    let w2 = x * (0.5 + x * (2.0 - 1.5 * x));
    let w3 = x * x * (0.5 * x - 0.5);
    let w12 = w1 + w2;
    var weights = array<vec2f, 3>(w0, w12, w3);
    var places = array<vec2f, 3>((middle - 1.0) / size, (middle + w2 / w12) / size, (middle + 2.0) / size);
    var sum = vec3f();
    for (var j = 0; j < 3; j++) {
        for (var i = 0; i < 3; i++) {
            let at = vec2f(places[i].x, places[j].y);
            sum += weights[i].x * weights[j].y * textureSampleLevel(history, linear, at, 0.0).rgb;
        }
    }
    return sum;
}

// Whether a texel near the old place showed a surface at the distance that this one had.
fn was_seen(p: vec2i, there: vec2f) -> bool {
    let size = vec2f(textureDimensions(depths));
    let distance = clamp(textureLoad(depths, p, 0).x, 1e-3, 65504.0);
    let uv = (vec2f(p) + 0.5 + settings.jitter) / size;
    let place = vec3f((uv * settings.factor + settings.offset) * distance, -distance);
    let expected = max(-dot(settings.reprojection, vec4f(place, 1.0)), 1e-3);
    let middle = vec2i(floor(there * size - settings.previous_jitter));
    let last = vec2i(size) - 1;
    var off = 1e9;
    for (var i = 0; i < 9; i++) {
        let q = clamp(middle + vec2i(i % 3 - 1, i / 3 - 1), vec2i(0), last);
        let found = clamp(textureLoad(previous_depths, q, 0).x, 1e-3, 65504.0);
        off = min(off, abs(found - expected) / min(expected, found));
    }
    return off < settings.threshold || (expected > 30000.0 && off < 2.0);
}

@compute @workgroup_size(16, 16)
fn resolve(@builtin(global_invocation_id) id: vec3u) {
    let size = textureDimensions(scene);
    if any(id.xy >= size) { return; }
    let p = vec2i(id.xy);
    let last = vec2i(size) - 1;
    let center = textureLoad(scene, p, 0);
    let middle = pack(center.rgb);
    var color = vec4f();
    var total = 0.0;
    var mean = vec4f();
    var square = vec3f();
    var least = middle.xyz;
    var greatest = middle.xyz;
    var nearest = p;
    var distance = textureLoad(depths, p, 0).x;
    for (var i = 0; i < 9; i++) {
        let step = vec2i(i % 3 - 1, i / 3 - 1);
        let q = clamp(p + step, vec2i(0), last);
        let other = pack(textureLoad(scene, q, 0).rgb);
        let away = vec2f(step) + settings.jitter;
        let weight = exp(-2.29 * dot(away, away));
        color += weight * other;
        total += weight;
        let apart = other - middle;
        mean += apart / 9.0;
        square += apart.xyz * apart.xyz / 9.0;
        least = min(least, other.xyz);
        greatest = max(greatest, other.xyz);
        let depth = textureLoad(depths, q, 0).x;
        nearest = select(nearest, q, depth < distance);
        distance = min(distance, depth);
    }
    color /= total;
    let spread = settings.variance * sqrt(max(square - mean.xyz * mean.xyz, vec3f(0.0)));
    mean += middle;
    let there = (vec2f(p) + 0.5) / vec2f(size) - textureLoad(motions, nearest, 0).xy;
    var share = 1.0;
    var old = middle;
    if all(there >= vec2f(0.0)) && all(there <= vec2f(1.0)) && was_seen(p, there) {
        old = pack(limited_light(catmull_rom(there)));
        let part = fract(there * vec2f(size) - 0.5);
        share = max(settings.blend, settings.moving * 2.0 * dot(part, 1.0 - part));
    }
    let away = old - mean;
    let limits = select(min(mean.xyz - least, spread), min(greatest - mean.xyz, spread), away.xyz > vec3f(0.0));
    let units = abs(away.xyz) / max(limits, vec3f(1e-6));
    let limited = mean + away / max(max(max(units.x, units.y), units.z), 1.0);
    let light = unpack(mix(limited, color, share));
    textureStore(smooth_image, p, vec4f(limited_light(light), center.a));
}
