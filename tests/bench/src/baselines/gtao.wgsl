// Ambient occlusion from depth, written by hand after Jimenez, Wu, Pesce and Jarabo, "Practical Realtime Strategies for
// Accurate Indirect Occlusion", 2016: the search, a mean over four by four pixels of a surface in two passes, and the
// light times the visibility, with bounces by the albedo. VISIBILITY is replaced by the format of the visibilities.

struct Settings {
    factor: vec2f,     // from uv to the camera's x and y at a distance of 1
    offset: vec2f,
    pixels: vec2f,     // of 1 m at a distance of 1 m
    radius: f32,
    falloff: f32,
    longest: f32,      // way of the search, in pixels
    slices: f32,
    steps: f32,
    amount: f32,
    power: f32,
}

@group(0) @binding(0) var<uniform> settings: Settings;
@group(0) @binding(1) var depths: texture_2d<f32>;
@group(0) @binding(2) var normals: texture_2d<f32>;
@group(0) @binding(3) var noisy: texture_2d<f32>;
@group(0) @binding(4) var scene: texture_2d<f32>;
@group(0) @binding(5) var albedos: texture_2d<f32>;
@group(0) @binding(6) var visibility: texture_storage_2d<VISIBILITY, write>;
@group(0) @binding(7) var lit: texture_storage_2d<rgba16float, write>;

const PI: f32 = 3.14159265;

fn distance_at(p: vec2i) -> f32 {
    return clamp(textureLoad(depths, p, 0).x, 1e-3, 65504.0);
}

fn place(p: vec2i) -> vec3f {
    let distance = distance_at(p);
    let uv = (vec2f(p) + 0.5) / vec2f(textureDimensions(depths));
    return vec3f((uv * settings.factor + settings.offset) * distance, -distance);
}

// The cosine of the highest horizon on one side.
fn horizon(p: vec2i, origin: vec3f, eye: vec3f, normal: vec3f, way: vec2f, lowest: f32, shift: f32) -> f32 {
    let size = vec2i(textureDimensions(depths));
    let reach = length(way);
    var highest = lowest;
    for (var i = 0.0; i < settings.steps; i += 1.0) {
        let share = (i + shift) / settings.steps;
        let pixels = 1.0 + share * share * max(reach - 1.0, 0.0);
        let q = p + vec2i(round(way * (pixels / reach)));
        if any(q < vec2i(0)) || any(q >= size) { break; }
        let to = place(q) - origin;
        let scale = inverseSqrt(max(dot(to, to), 1e-12));
        let near = clamp((settings.radius - dot(to, to) * scale) / (settings.falloff * settings.radius), 0.0, 1.0);
        let rise = clamp(dot(to, normal) * scale / 0.08, 0.0, 1.0);
        highest = max(highest, mix(lowest, dot(to, eye) * scale, near * rise));
    }
    return highest;
}

// The integral over a half slice.
fn arc(horizon: f32, normal: f32) -> f32 {
    return 0.25 * (cos(normal) - cos(2.0 * horizon - normal) + 2.0 * horizon * sin(normal));
}

// The light that a slice misses, of what its surface alone would leave.
fn slice(p: vec2i, origin: vec3f, eye: vec3f, normal: vec3f, tangent: vec3f, shift: f32) -> f32 {
    let a = dot(normal, eye);
    let b = dot(normal, tangent);
    let size = length(vec2f(a, b));
    let angle = select(atan2(b, a), 0.0, size < 1e-6);
    var way = (tangent.xy - origin.xy * (tangent.z / origin.z)) * settings.pixels * settings.radius / -origin.z;
    way *= min(1.0, settings.longest / max(length(way), 1e-6));
    if length(way) < 1.0 { return 0.0; }
    let lowest = vec2f(-sin(angle), sin(angle));
    let first = acos(clamp(horizon(p, origin, eye, normal, way, lowest.x, shift), -1.0, 1.0));
    let second = -acos(clamp(horizon(p, origin, eye, normal, -way, lowest.y, shift), -1.0, 1.0));
    let high = angle + min(first - angle, 0.5 * PI);
    let low = angle + max(second - angle, -0.5 * PI);
    return max(a + angle * b - size * (arc(low, angle) + arc(high, angle)), 0.0);
}

@compute @workgroup_size(16, 16)
fn search(@builtin(global_invocation_id) id: vec3u) {
    if any(id.xy >= textureDimensions(depths)) { return; }
    let p = vec2i(id.xy);
    let origin = place(p);
    let inverse = -1.0 / origin.z;
    if -origin.z > 60000.0 {
        textureStore(visibility, p, vec4f(1.0, inverse, 0.0, 1.0));
        return;
    }
    let eye = normalize(-origin);
    let normal = normalize(textureLoad(normals, p, 0).xyz);
    let turn = f32(((p.x + p.y) & 3) * 4 + (p.x & 3)) / 16.0;
    let shift = 0.125 + 0.25 * f32((p.y - p.x) & 3);
    let right = normalize(vec3f(eye.z, 0.0, -eye.x));
    let up = cross(eye, right);
    var sum = 0.0;
    for (var i = 0.0; i < settings.slices; i += 1.0) {
        let angle = PI * (i + turn) / settings.slices;
        sum += slice(p, origin, eye, normal, cos(angle) * right + sin(angle) * up, shift);
    }
    textureStore(visibility, p, vec4f(1.0 - sum / settings.slices, inverse, 0.0, 1.0));
}

// A mean over four texels of an axis. Neighbors count by how near they lie to the plane through the pixel: the inverse
// of the distance is linear on it.
fn mean(p: vec2i, step: vec2i) -> vec4f {
    let size = vec2i(textureDimensions(noisy));
    let own = textureLoad(noisy, p, 0).xy;
    let has_after = all(p + step < size);
    let has_before = all(p - step >= vec2i(0));
    let after = textureLoad(noisy, min(p + step, size - 1), 0).y - own.y;
    let before = own.y - textureLoad(noisy, max(p - step, vec2i(0)), 0).y;
    let slope = select(before, after, has_after && (!has_before || abs(after) < abs(before)));
    var sum = vec2f(own.x, 1.0);
    for (var i = -2; i <= 2; i++) {
        let q = p + i * step;
        if i == 0 || any(q < vec2i(0)) || any(q >= size) { continue; }
        let other = textureLoad(noisy, q, 0).xy;
        let off = min(abs(other.y - own.y - slope * f32(i)) / (0.02 * max(own.y, 1e-6)), 1.0);
        let weight = (1.0 - off * off) * select(1.0, 0.5, abs(i) == 2);
        sum += weight * vec2f(other.x, 1.0);
    }
    return vec4f(sum.x / sum.y, own.y, 0.0, 1.0);
}

@compute @workgroup_size(16, 16)
fn across(@builtin(global_invocation_id) id: vec3u) {
    if any(id.xy >= textureDimensions(noisy)) { return; }
    textureStore(visibility, id.xy, mean(vec2i(id.xy), vec2i(1, 0)));
}

@compute @workgroup_size(16, 16)
fn down(@builtin(global_invocation_id) id: vec3u) {
    if any(id.xy >= textureDimensions(noisy)) { return; }
    textureStore(visibility, id.xy, mean(vec2i(id.xy), vec2i(0, 1)));
}

@compute @workgroup_size(16, 16)
fn light(@builtin(global_invocation_id) id: vec3u) {
    if any(id.xy >= textureDimensions(scene)) { return; }
    let visible = textureLoad(noisy, id.xy, 0).x;
    let v = 1.0 - settings.amount * (1.0 - pow(max(visible, 1e-30), settings.power));
    let albedo = clamp(textureLoad(albedos, id.xy, 0).rgb, vec3f(0.0), vec3f(1.0));
    let a = 2.0404 * albedo - 0.3324;
    let b = -4.7951 * albedo + 0.6417;
    let c = 2.7552 * albedo + 0.6903;
    let bounced = clamp(((v * a + b) * v + c) * v, vec3f(v), vec3f(1.0));
    let color = textureLoad(scene, id.xy, 0);
    textureStore(lit, id.xy, vec4f(color.rgb * bounced, color.a));
}
