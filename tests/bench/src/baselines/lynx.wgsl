// Threshold bloom with a filmic curve, written by hand: extraction at half size, four halvings, four enlargements,
// and a last pass that adds the bloom, applies the curve and encodes. LEVEL is replaced by the format of the levels,
// GLOW by the filter of the bloom: a tent or bilinear. With SAME the chain does all the work of the pipeline:
// extraction at full size without single bright pixels, sanitizing, and dither. It has no history of the frame before.

struct Settings {
    low: f32,      // the threshold, lower end
    high: f32,     // the threshold, upper end
    own: f32,      // share of a level
    rest: f32,     // share of the coarser ones
    radius: f32,   // of the tent, in texels
    strength: f32,
    gain: f32,
}

@group(0) @binding(0) var linear: sampler;
@group(0) @binding(1) var<uniform> settings: Settings;
@group(0) @binding(2) var first: texture_2d<f32>;
@group(0) @binding(3) var second: texture_2d<f32>;
@group(0) @binding(4) var level: texture_storage_2d<LEVEL, write>;
@group(0) @binding(5) var display: texture_storage_2d<rgba8unorm, write>;

const SAME: bool = SAME_WORK;

fn brightest(rgb: vec3f) -> f32 {
    return max(rgb.r, max(rgb.g, rgb.b));
}

// The mean of the light of four texels.
fn extract(p: vec2u) -> vec4f {
    let last = textureDimensions(first) - 1;
    var sum = vec3f();
    for (var i = 0u; i < 4u; i++) {
        let texel = textureLoad(first, min(2u * p + vec2u(i & 1u, i >> 1u), last), 0).rgb * settings.gain;
        sum += 0.25 * texel * smoothstep(settings.low, settings.high, brightest(texel));
    }
    return vec4f(sum, 1.0);
}

// Sanitizes a color. The bits of positive floats have the order of the floats; those of negative ones are larger.
fn sane(v: vec4f) -> vec4f {
    if !SAME { return v; }
    let bits = bitcast<vec4u>(v);
    return bitcast<vec4f>(select(min(bits, vec4u(0x477fe000u)), vec4u(), bits > vec4u(0x7f800000u)));
}

// The light above the threshold, without pixels that are more than four times as bright as all around them.
fn pick(p: vec2u) -> vec4f {
    let last = vec2i(textureDimensions(first)) - 1;
    let texel = sane(textureLoad(first, p, 0)) * settings.gain;
    var near = 0.0;
    for (var i = 0; i < 9; i++) {
        let at = vec2i(p) + vec2i(i % 3 - 1, i / 3 - 1);
        let light = brightest(sane(textureLoad(first, clamp(at, vec2i(0), last), 0)).rgb) * settings.gain;
        near = max(near, select(0.0, light, i != 4 && all(at == clamp(at, vec2i(0), last))));
    }
    let bright = brightest(texel.rgb);
    let limited = texel.rgb * select(4.0 * near / bright, 1.0, bright <= 4.0 * near);
    return vec4f(limited * smoothstep(settings.low, settings.high, brightest(limited)), texel.a);
}

// Triangular noise of one code, from PCG3D (Jarzynski and Olano 2020).
fn dithered(rgb: vec3f, p: vec2u) -> vec3f {
    var v = vec3u(p, 0u) * 1664525u + 1013904223u;
    v.x += v.y * v.z;
    v.y += v.z * v.x;
    v.z += v.x * v.y;
    v ^= v >> vec3u(16u);
    v.x += v.y * v.z;
    v.y += v.z * v.x;
    v.z += v.x * v.y;
    let noise = (vec3f(v >> vec3u(16u)) + vec3f(v & vec3u(0xffffu))) / 65536.0 - 1.0;
    let code = clamp(rgb, vec3f(0.0), vec3f(1.0)) * 255.0;
    let room = clamp(2.0 * min(code, 255.0 - code), vec3f(0.0), vec3f(1.0));
    return floor(clamp(code + noise * room, vec3f(0.0), vec3f(255.0)) + 0.5) / 255.0;
}

fn around(uv: vec2f, x: f32, y: f32) -> vec3f {
    return textureSampleLevel(first, linear, uv + vec2f(x, y) / vec2f(textureDimensions(first)), 0.0).rgb;
}

fn halve(uv: vec2f) -> vec4f {
    let corners = around(uv, -2.0, -2.0) + around(uv, 2.0, -2.0) + around(uv, -2.0, 2.0) + around(uv, 2.0, 2.0);
    let edges = around(uv, 0.0, -2.0) + around(uv, -2.0, 0.0) + around(uv, 2.0, 0.0) + around(uv, 0.0, 2.0);
    let inner = around(uv, -1.0, -1.0) + around(uv, 1.0, -1.0) + around(uv, -1.0, 1.0) + around(uv, 1.0, 1.0);
    return vec4f(0.03125 * corners + 0.0625 * edges + 0.125 * (inner + around(uv, 0.0, 0.0)), 1.0);
}

fn tent(uv: vec2f, radius: f32) -> vec3f {
    let d = radius / vec2f(textureDimensions(second));
    var sum = vec3f();
    for (var y = -1; y <= 1; y++) {
        for (var x = -1; x <= 1; x++) {
            let weight = f32((2 - abs(x)) * (2 - abs(y))) / 16.0;
            sum += weight * textureSampleLevel(second, linear, uv + vec2f(f32(x), f32(y)) * d, 0.0).rgb;
        }
    }
    return sum;
}

fn near(uv: vec2f) -> vec3f {
    return textureSampleLevel(second, linear, uv, 0.0).rgb;
}

fn enlarge(p: vec2u, uv: vec2f) -> vec4f {
    let own = textureLoad(first, p, 0).rgb;
    return vec4f(settings.own * own + settings.rest * tent(uv, settings.radius), 1.0);
}

fn finish(p: vec2u, uv: vec2f) -> vec4f {
    let scene = sane(textureLoad(first, p, 0));
    let v = min(max(scene.rgb * settings.gain + settings.strength * GLOW, vec3f(0.0)), vec3f(65504.0));
    let mapped = min(v * (2.51 * v + 0.03) / (v * (2.43 * v + 0.59) + 0.14), vec3f(1.0));
    let encoded = select(1.055 * pow(mapped, vec3f(1.0 / 2.4)) - 0.055, 12.92 * mapped, mapped <= vec3f(0.0031308));
    if SAME { return vec4f(dithered(encoded, p), scene.a); }
    return vec4f(encoded, scene.a);
}

fn center(p: vec2u, size: vec2u) -> vec2f {
    return (vec2f(p) + 0.5) / vec2f(size);
}

@compute @workgroup_size(16, 16)
fn extract_dispatch(@builtin(global_invocation_id) id: vec3u) {
    if any(id.xy >= textureDimensions(level)) { return; }
    textureStore(level, id.xy, extract(id.xy));
}

@compute @workgroup_size(16, 16)
fn pick_dispatch(@builtin(global_invocation_id) id: vec3u) {
    if any(id.xy >= textureDimensions(level)) { return; }
    textureStore(level, id.xy, pick(id.xy));
}

@compute @workgroup_size(16, 16)
fn halve_dispatch(@builtin(global_invocation_id) id: vec3u) {
    let size = textureDimensions(level);
    if any(id.xy >= size) { return; }
    textureStore(level, id.xy, halve(center(id.xy, size)));
}

@compute @workgroup_size(16, 16)
fn enlarge_dispatch(@builtin(global_invocation_id) id: vec3u) {
    let size = textureDimensions(level);
    if any(id.xy >= size) { return; }
    textureStore(level, id.xy, enlarge(id.xy, center(id.xy, size)));
}

@compute @workgroup_size(16, 16)
fn finish_dispatch(@builtin(global_invocation_id) id: vec3u) {
    let size = textureDimensions(display);
    if any(id.xy >= size) { return; }
    textureStore(display, id.xy, finish(id.xy, center(id.xy, size)));
}

struct Corner {
    @builtin(position) position: vec4f,
    @location(0) uv: vec2f,
}

@vertex
fn triangle(@builtin(vertex_index) index: u32) -> Corner {
    let uv = vec2f(f32((index << 1u) & 2u), f32(index & 2u));
    return Corner(vec4f(uv * vec2f(2.0, -2.0) + vec2f(-1.0, 1.0), 0.0, 1.0), uv);
}

@fragment
fn extract_draw(corner: Corner) -> @location(0) vec4f {
    return extract(vec2u(corner.position.xy));
}

@fragment
fn pick_draw(corner: Corner) -> @location(0) vec4f {
    return pick(vec2u(corner.position.xy));
}

@fragment
fn halve_draw(corner: Corner) -> @location(0) vec4f {
    return halve(corner.uv);
}

@fragment
fn enlarge_draw(corner: Corner) -> @location(0) vec4f {
    return enlarge(vec2u(corner.position.xy), corner.uv);
}

@fragment
fn finish_draw(corner: Corner) -> @location(0) vec4f {
    return finish(vec2u(corner.position.xy), corner.uv);
}
