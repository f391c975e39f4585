// Depth of field, written by hand after Jimenez, "Next Generation Post Processing in Call of Duty: Advanced Warfare",
// SIGGRAPH 2014: circles of confusion, their largest radius by tiles in three small passes, and a gather along rings
// whose directions the host has computed. CIRCLE is replaced by the format of the circles, SAMPLES by the number of
// samples. Circles overlap by their areas, and light from behind is limited to the pixel's own circle.

struct Settings {
    focus: f32,
    strength: f32,     // the radius of the circle of an infinite distance, in pixels
    longest: f32,      // the largest radius, in pixels
    tile: u32,
    samples: array<vec4f, SAMPLES>,  // the place, its distance and its area in circles of radius 1; first the middle
}

@group(0) @binding(0) var<uniform> settings: Settings;
@group(0) @binding(1) var depths: texture_2d<f32>;
@group(0) @binding(2) var circles: texture_2d<f32>;
@group(0) @binding(3) var reaches: texture_2d<f32>;
@group(0) @binding(4) var scene: texture_2d<f32>;
@group(0) @binding(5) var circle: texture_storage_2d<CIRCLE, write>;
@group(0) @binding(6) var focused: texture_storage_2d<rgba16float, write>;

const PI: f32 = 3.14159265;

// The radius and the distance of what a pixel shows, less what reading whole pixels adds.
fn surface(p: vec2i) -> vec2f {
    let last = vec2i(textureDimensions(depths)) - 1;
    let z = max(textureLoad(depths, clamp(p, vec2i(0), last), 0).x, 1e-3);
    let radius = min(settings.strength * abs(z - settings.focus) / z, settings.longest);
    return vec2f(sqrt(max(radius * radius - 1.0 / 6.0, 0.0)), z);
}

@compute @workgroup_size(16, 16)
fn confuse(@builtin(global_invocation_id) id: vec3u) {
    if any(id.xy >= textureDimensions(depths)) { return; }
    let p = vec2i(id.xy);
    let own = surface(p);
    var found = own;
    // A pixel beside a sharper surface in front belongs to that.
    var sides = array<vec2i, 4>(vec2i(-1, 0), vec2i(1, 0), vec2i(0, -1), vec2i(0, 1));
    for (var i = 0; i < 4; i++) {
        let other = surface(p + sides[i]);
        if other.y < 0.95 * own.y && other.x < found.x { found = other; }
    }
    textureStore(circle, id.xy, vec4f(found, 0.0, 1.0));
}

@compute @workgroup_size(16, 16)
fn rows(@builtin(global_invocation_id) id: vec3u) {
    if any(id.xy >= textureDimensions(circle)) { return; }
    let last = textureDimensions(circles) - 1;
    var most = 0.0;
    for (var i = 0u; i < settings.tile; i++) {
        most = max(most, textureLoad(circles, min(vec2u(id.x * settings.tile + i, id.y), last), 0).x);
    }
    textureStore(circle, id.xy, vec4f(most, 0.0, 0.0, 1.0));
}

@compute @workgroup_size(16, 16)
fn tiles(@builtin(global_invocation_id) id: vec3u) {
    if any(id.xy >= textureDimensions(circle)) { return; }
    let last = textureDimensions(circles) - 1;
    var most = 0.0;
    for (var i = 0u; i < settings.tile; i++) {
        most = max(most, textureLoad(circles, min(vec2u(id.x, id.y * settings.tile + i), last), 0).x);
    }
    textureStore(circle, id.xy, vec4f(most, 0.0, 0.0, 1.0));
}

@compute @workgroup_size(16, 16)
fn around(@builtin(global_invocation_id) id: vec3u) {
    if any(id.xy >= textureDimensions(circle)) { return; }
    let last = vec2i(textureDimensions(circles)) - 1;
    var most = 0.0;
    for (var i = 0; i < 9; i++) {
        let p = clamp(vec2i(id.xy) + vec2i(i % 3 - 1, i / 3 - 1), vec2i(0), last);
        most = max(most, textureLoad(circles, p, 0).x);
    }
    textureStore(circle, id.xy, vec4f(most, 0.0, 0.0, 1.0));
}

// The share of a circle's light at this distance from its middle.
fn share(radius: f32, distance: f32) -> f32 {
    return clamp(radius - distance + 0.5, 0.0, 1.0) / max(PI * radius * radius, 1.0);
}

@compute @workgroup_size(16, 16)
fn gather(@builtin(global_invocation_id) id: vec3u) {
    if any(id.xy >= textureDimensions(scene)) { return; }
    let p = vec2i(id.xy);
    let center = textureLoad(scene, p, 0);
    let reach = textureLoad(reaches, id.xy / settings.tile, 0).x;
    if reach < 0.5 {
        textureStore(focused, p, center);
        return;
    }
    let own = textureLoad(circles, p, 0).xy;
    let last = vec2i(textureDimensions(scene)) - 1;
    var before = vec4f();
    var behind = vec4f();
    for (var i = 0; i < SAMPLES; i++) {
        let way = settings.samples[i];
        let q = clamp(p + vec2i(round(reach * way.xy)), vec2i(0), last);
        let other = textureLoad(circles, q, 0).xy;
        let color = vec4f(textureLoad(scene, q, 0).rgb, 1.0);
        let front = clamp((own.y - other.y) / (0.05 * own.y), 0.0, 1.0);
        let area = reach * reach * way.w;
        before += area * front * share(other.x, reach * way.z) * color;
        behind += area * (1.0 - front) * share(min(other.x, own.x), reach * way.z) * color;
    }
    let far = behind.rgb / max(behind.w, 1e-6);
    let near = before.rgb / max(before.w, 1e-6);
    let color = mix(far, near, clamp(before.w, 0.0, 1.0));
    textureStore(focused, p, vec4f(clamp(color, vec3f(0.0), vec3f(65504.0)), center.a));
}
