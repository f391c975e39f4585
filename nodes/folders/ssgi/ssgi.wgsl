import afterimage::camera::{Camera, camera_place, camera_previous_uv, camera_uv_apart, camera_world};
import afterimage::depth::depth_at;
import afterimage::sanitize::HALF_MAX;
import afterimage::surface::{
    SURFACE_FARTHEST, surface_given_normal, surface_normal, surface_place, surface_toward, surface_turn, surface_unit,
};

struct Ssgi {
    amount: f32,
    radius: f32,
    largest: f32,
    thickness: f32,
    slices: i32,
    steps: i32,
    blend: f32,
    world: u32,
}

const SSGI_PI: f32 = 3.14159265;
// Parts of a half turn, one for each bit.
const SSGI_PARTS: f32 = 32.0;
// The distance off the plane of a surface, as a share of the depth, beyond which light is not mixed.
const SSGI_SOFT: f32 = 0.01;
// The difference of distances, as a share, beyond which the frame before shows another surface.
const SSGI_MOVED: f32 = 0.05;

// The pixel that a texel of half the size stands for.
fn ssgi_pixel(depth: texture_2d<f32>, texel_at: vec2i) -> vec2i {
    return min(2 * texel_at + 1, vec2i(textureDimensions(depth)) - 1);
}

fn ssgi_normal(depth: texture_2d<f32>, normal: texture_2d<f32>, camera: Camera, pixel: vec2i, params: Ssgi) -> vec3f {
    let given = texel(normal, pixel).xyz;
    if dot(given, given) > 1e-4 { return surface_given_normal(camera, given, f32(params.world)); }
    return surface_normal(depth, camera, pixel);
}

// Normals, from 0 to 1 because light is not negative, and distances in alpha.
fn ssgi_surface(depth: texture_2d<f32>, normal: texture_2d<f32>, camera: Camera, at: Point, params: Ssgi) -> vec4f {
    let pixel = ssgi_pixel(depth, at.pixel);
    let distance = depth_at(depth, pixel);
    return vec4f(0.5 + 0.5 * ssgi_normal(depth, normal, camera, pixel, params), distance);
}

// A texel of `surface`: its normal, and its distance in alpha.
fn ssgi_seen(surface: texture_2d<f32>, p: vec2i) -> vec4f {
    let seen = texel(surface, p);
    return vec4f(2.0 * seen.xyz - 1.0, seen.w);
}

// The mean of the pixels under a texel.
fn ssgi_levels(source: texture_2d<f32>, source_sampler: sampler, at: Point) -> vec4f {
    return tap(source, source_sampler, at.uv);
}

// The position of a texel's surface.
fn ssgi_uv(depth: texture_2d<f32>, texel_at: vec2i) -> vec2f {
    return (vec2f(ssgi_pixel(depth, texel_at)) + 0.5) / vec2f(textureDimensions(depth));
}

fn ssgi_place(depth: texture_2d<f32>, camera: Camera, texel_at: vec2i, distance: f32) -> vec3f {
    return camera_place(camera, ssgi_uv(depth, texel_at), distance);
}

// The parts between two places of a slice, in parts.
fn ssgi_parts(low: f32, high: f32) -> u32 {
    let first = u32(clamp(low, 0.0, SSGI_PARTS));
    let count = u32(clamp(high, 0.0, SSGI_PARTS)) - first;
    if count == 0u { return 0u; }
    return (0xffffffffu >> (32u - count)) << first;
}

// The cosine-weighted share of a half slice up to an angle. Slices are denser toward the middle, so it is the integral
// of (a cos x + b sin x) sin x, for a normal with the parts a toward the camera and b along the tangent.
fn ssgi_share(facing: vec2f, angle: f32) -> f32 {
    let x = clamp(angle, 0.0, SSGI_PI);
    return 0.5 * (facing.x * sin(x) * sin(x) + facing.y * (x - sin(x) * cos(x)));
}

// The number of texels to the border.
fn ssgi_room(texel_at: vec2i, direction: vec2f, size: vec2f) -> f32 {
    let middle = vec2f(texel_at) + 0.5;
    let room = select(middle, size - middle, direction > vec2f(0.0)) / max(abs(direction), vec2f(1e-6));
    return min(room.x, room.y);
}

// The light at a place, from the blur that is about as wide as the samples are apart.
fn ssgi_read(
    l1: texture_2d<f32>,
    l1_sampler: sampler,
    l2: texture_2d<f32>,
    l2_sampler: sampler,
    l3: texture_2d<f32>,
    l3_sampler: sampler,
    l4: texture_2d<f32>,
    l4_sampler: sampler,
    l5: texture_2d<f32>,
    l5_sampler: sampler,
    l6: texture_2d<f32>,
    l6_sampler: sampler,
    uv: vec2f,
    apart: f32,
) -> vec3f {
    if apart < 2.0 { return tap(l1, l1_sampler, uv).rgb; }
    if apart < 4.0 { return tap(l2, l2_sampler, uv).rgb; }
    if apart < 8.0 { return tap(l3, l3_sampler, uv).rgb; }
    if apart < 16.0 { return tap(l4, l4_sampler, uv).rgb; }
    if apart < 32.0 { return tap(l5, l5_sampler, uv).rgb; }
    return tap(l6, l6_sampler, uv).rgb;
}

// The share of a texel's radiance that a white surface at a point would scatter.
fn ssgi_gathered(
    l1: texture_2d<f32>,
    l1_sampler: sampler,
    l2: texture_2d<f32>,
    l2_sampler: sampler,
    l3: texture_2d<f32>,
    l3_sampler: sampler,
    l4: texture_2d<f32>,
    l4_sampler: sampler,
    l5: texture_2d<f32>,
    l5_sampler: sampler,
    l6: texture_2d<f32>,
    l6_sampler: sampler,
    surface: texture_2d<f32>,
    depth: texture_2d<f32>,
    camera: Camera,
    at: Point,
    frame: Frame,
    params: Ssgi,
) -> vec4f {
    let own = ssgi_seen(surface, at.pixel);
    if own.w >= SURFACE_FARTHEST || params.amount <= 0.0 { return vec4f(0.0, 0.0, 0.0, own.w); }
    let size = vec2f(textureDimensions(surface));
    let place = ssgi_place(depth, camera, at.pixel, own.w);
    let toward = surface_toward(camera, place);
    let moves = select(0.0, fract(0.618034 * f32(frame.index & 1023u)), params.blend < 1.0);
    let turn = fract(surface_turn(at.pixel) + moves);
    let shift = fract(0.125 + 0.25 * f32((at.pixel.y - at.pixel.x) & 3) + 0.7549 * moves);
    let slices = clamp(params.slices, 1, 16);
    let steps = clamp(params.steps, 1, 32);
    let parts = SSGI_PARTS / SSGI_PI;
    var sum = vec3f();
    // Axes across the direction to the camera, around which slices are even.
    let right = surface_unit(vec3f(toward.z, 0.0, -toward.x));
    let up = cross(toward, right);
    for (var i = 0; i < 2 * slices; i++) {
        // A half of a slice, from the direction to the camera to its tangent.
        let angle = SSGI_PI * (f32(i) + turn) / f32(slices);
        let tangent = cos(angle) * right + sin(angle) * up;
        let along = tangent.xy - place.xy * (tangent.z / place.z);
        let way = camera_uv_apart(camera, along * params.radius, own.w) * size;
        let whole = max(length(way), 1e-6);
        let direction = way / whole;
        let reach = min(min(whole, params.largest * size.y), ssgi_room(at.pixel, direction, size));
        // The angle of the surface's own horizon.
        let facing = vec2f(dot(own.xyz, toward), dot(own.xyz, tangent));
        let lowest = atan2(facing.x, -facing.y);
        var covered = 0u;
        var before = 0.0;
        var last = own.xyz;
        var last_front = lowest;
        for (var k = 0; k < steps; k++) {
            let share = (f32(k) + shift) / f32(steps);
            let texels = 1.0 + share * share * max(reach - 1.0, 0.0);
            let step = vec2i(round(texels * direction));
            let p = at.pixel + step;
            if any(p < vec2i(0)) || any(p >= vec2i(size)) { break; }
            let other = ssgi_seen(surface, p);
            if other.w >= SURFACE_FARTHEST { before = texels; continue; }
            let to = ssgi_place(depth, camera, p, other.w) - place;
            // As deep as thick things are, or as far as the sample before was.
            let stride = params.radius * (texels - before) / whole;
            let behind = to - toward * (params.thickness + stride);
            let front = atan2(dot(to, tangent), dot(to, toward));
            let back = min(atan2(dot(behind, tangent), dot(behind, toward)), lowest);
            // Half of the way to the sample after, if the surface goes on.
            let onward = select(0.0, 0.5 * max(last_front - front, 0.0), dot(other.xyz, last) > 0.9);
            let low = clamp(front - onward, 0.0, lowest);
            let found = ssgi_parts(low * parts + shift, max(back, low) * parts + shift) & ~covered;
            covered |= found;
            // Backs of things send nothing.
            let faces = dot(other.xyz, to) < 0.0;
            if found != 0u && faces {
                let ends = (vec2f(f32(firstTrailingBit(found)), f32(firstLeadingBit(found) + 1u)) - shift) / parts;
                let filled = f32(countOneBits(found)) / (parts * (ends.y - ends.x));
                let uv = ssgi_uv(depth, p);
                let light = ssgi_read(
                    l1, l1_sampler, l2, l2_sampler, l3, l3_sampler, l4, l4_sampler, l5, l5_sampler, l6, l6_sampler,
                    uv, texels - before,
                );
                sum += light * (max(ssgi_share(facing, ends.y) - ssgi_share(facing, ends.x), 0.0) * filled);
            }
            before = texels;
            last = other.xyz;
            last_front = front;
        }
    }
    let scattered = sum / f32(slices);
    return vec4f(min(scattered, vec3f(HALF_MAX)), own.w);
}

// The weight of a texel's radiance at a position with this normal.
fn ssgi_alike(
    surface: texture_2d<f32>,
    depth: texture_2d<f32>,
    camera: Camera,
    p: vec2i,
    place: vec3f,
    normal: vec3f,
) -> f32 {
    if any(p < vec2i(0)) || any(p >= vec2i(textureDimensions(surface))) { return 0.0; }
    let other = ssgi_seen(surface, p);
    let off = dot(normal, ssgi_place(depth, camera, p, other.w) - place) / (SSGI_SOFT * -place.z);
    let facing = max(dot(normal, other.xyz), 0.0);
    return exp(-off * off) * facing * facing * facing * facing;
}

// A mean over a surface, of texels `step` apart with these weights from the middle.
fn ssgi_mean(
    light: texture_2d<f32>,
    surface: texture_2d<f32>,
    depth: texture_2d<f32>,
    camera: Camera,
    at: Point,
    step: i32,
    weights: vec3f,
) -> vec4f {
    let own = ssgi_seen(surface, at.pixel);
    let middle = texel(light, at.pixel);
    if own.w >= SURFACE_FARTHEST { return middle; }
    let place = ssgi_place(depth, camera, at.pixel, own.w);
    var sum = weights.x * weights.x * middle.rgb;
    var total = weights.x * weights.x;
    for (var i = 0; i < 25; i++) {
        let away = vec2i(i % 5 - 2, i / 5 - 2);
        let p = at.pixel + step * away;
        if i == 12 { continue; }
        let alike = ssgi_alike(surface, depth, camera, p, place, own.xyz);
        let weight = alike * weights[abs(away.x)] * weights[abs(away.y)];
        sum += weight * texel(light, p).rgb;
        total += weight;
    }
    return vec4f(sum / total, own.w);
}

// All sixteen turns have the same weight.
fn ssgi_first(
    gathered: texture_2d<f32>,
    surface: texture_2d<f32>,
    depth: texture_2d<f32>,
    camera: Camera,
    at: Point,
) -> vec4f {
    return ssgi_mean(gathered, surface, depth, camera, at, 1, vec3f(1.0, 1.0, 0.5));
}

// B-splines with holes, as those of `Denoise`.
fn ssgi_second(
    first: texture_2d<f32>,
    surface: texture_2d<f32>,
    depth: texture_2d<f32>,
    camera: Camera,
    at: Point,
) -> vec4f {
    return ssgi_mean(first, surface, depth, camera, at, 2, vec3f(0.375, 0.25, 0.0625));
}

fn ssgi_third(
    second: texture_2d<f32>,
    surface: texture_2d<f32>,
    depth: texture_2d<f32>,
    camera: Camera,
    at: Point,
) -> vec4f {
    return ssgi_mean(second, surface, depth, camera, at, 4, vec3f(0.375, 0.25, 0.0625));
}

// The light over time, of what stands still and was seen.
fn ssgi_mixed(
    third: vec4f,
    history: texture_2d<f32>,
    history_sampler: sampler,
    depth: texture_2d<f32>,
    camera: Camera,
    at: Point,
    frame: Frame,
    params: Ssgi,
) -> vec4f {
    if params.blend >= 1.0 || frame.reset != 0u || third.w >= SURFACE_FARTHEST { return third; }
    let world = camera_world(camera, ssgi_place(depth, camera, at.pixel, third.w));
    let there = camera_previous_uv(camera, world).xy;
    // A texel shows a pixel that is half a pixel off its middle.
    let uv = there - 0.5 / vec2f(textureDimensions(depth));
    let expected = -(camera.previous_view * vec4f(world, 1.0)).z;
    let old = tap(history, history_sampler, clamp(uv, vec2f(0.0), vec2f(1.0)));
    let was_seen = all(there > vec2f(0.0)) && all(there < vec2f(1.0))
        && abs(old.w - expected) < SSGI_MOVED * max(expected, 1e-3);
    return vec4f(mix(third.rgb, old.rgb, select(0.0, 1.0 - params.blend, was_seen)), third.w);
}

// The scattered radiance: the nearest four texels that show the pixel's surface.
fn ssgi(
    source: vec4f,
    albedo: vec4f,
    mixed: texture_2d<f32>,
    surface: texture_2d<f32>,
    depth: texture_2d<f32>,
    normal: texture_2d<f32>,
    camera: Camera,
    at: Point,
    params: Ssgi,
) -> vec4f {
    if params.amount <= 0.0 || depth_at(depth, at.pixel) >= SURFACE_FARTHEST { return source; }
    let place = surface_place(depth, camera, at.pixel);
    let up = ssgi_normal(depth, normal, camera, at.pixel, params);
    let base = (at.pixel - 1) >> vec2u(1u);
    let part = 0.5 * vec2f((at.pixel - 1) & vec2i(1));
    var sum = vec3f();
    var total = 0.0;
    for (var i = 0; i < 4; i++) {
        let corner = vec2i(i & 1, i >> 1u);
        let share = select(1.0 - part, part, corner == vec2i(1));
        let p = clamp(base + corner, vec2i(0), vec2i(textureDimensions(mixed)) - 1);
        let weight = (share.x * share.y + 1e-3) * (ssgi_alike(surface, depth, camera, p, place, up) + 1e-4);
        sum += weight * texel(mixed, p).rgb;
        total += weight;
    }
    let scattered = clamp(albedo.rgb, vec3f(0.0), vec3f(1.0)) * (params.amount / total) * sum;
    return vec4f(clamp(source.rgb + scattered, vec3f(-HALF_MAX), vec3f(HALF_MAX)), source.a);
}

fn ssgi_light(mixed: vec4f) -> vec4f {
    return mixed;
}
