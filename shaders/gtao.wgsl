// Ambient occlusion from depth: for some slices of the hemisphere over a pixel, the highest horizon to both sides, and
// the share of cosine-weighted light between them in closed form. Jimenez, Wu, Pesce and Jarabo, "Practical Realtime
// Strategies for Accurate Indirect Occlusion", 2016. Horizons fall back to the surface's own where occluders fade out
// at the radius.
#import camera
#import depth
#import grade
#import math

struct Gtao {
    amount: f32,
    power: f32,
    radius: f32,
    falloff: f32,
    slices: i32,
    steps: i32,
    most: f32,         // the longest way in pixels of the depth image
    is_world: f32,     // 1 if the normals are in the world's space
    stride: f32,       // pixels of the depth image from one texel of the result to the next
    axis: vec2f,       // of the denoiser
}

const GTAO_PI: f32 = 3.14159265;
// What is farther has no occlusion: the sky.
const GTAO_FARTHEST: f32 = 60000.0;
// The distance off a plane, as a share of the depth, beyond which visibilities are not mixed.
const GTAO_SOFT: f32 = 0.02;
// The sine of the angle over the surface below which an occluder counts less: texels lie beside the slice, and depths
// are rounded, so a flat surface would occlude itself.
const GTAO_FLAT: f32 = 0.08;

// What is seen at a texel of the depth image.
fn gtao_place(depth: texture_2d<f32>, camera: Camera, p: vec2i) -> vec3f {
    let uv = (vec2f(p) + 0.5) / vec2f(textureDimensions(depth));
    return camera_place(camera, uv, clamp(texel(depth, p).x, 1e-3, HALF_MAX));
}

// The way along the surface to the next texel: to the side where the depth bends less.
fn gtao_tangent(depth: texture_2d<f32>, camera: Camera, p: vec2i, step: vec2i) -> vec3f {
    let middle = gtao_place(depth, camera, p);
    let after = gtao_place(depth, camera, p + step) - middle;
    let before = middle - gtao_place(depth, camera, p - step);
    let has_after = all(p + step < vec2i(textureDimensions(depth)));
    let has_before = all(p >= step);
    return select(before, after, has_after && (!has_before || abs(after.z) < abs(before.z)));
}

// A unit vector, or the one towards the camera where there is none.
fn gtao_unit(v: vec3f) -> vec3f {
    let square = dot(v, v);
    return select(vec3f(0.0, 0.0, 1.0), v * inverseSqrt(max(square, 1e-30)), square > 1e-30);
}

// The normal of the surface at a texel, from the depth.
fn gtao_normal(depth: texture_2d<f32>, camera: Camera, p: vec2i) -> vec3f {
    let right = gtao_tangent(depth, camera, p, vec2i(1, 0));
    let down = gtao_tangent(depth, camera, p, vec2i(0, 1));
    return gtao_unit(cross(down, right));
}

// The direction to the camera: parallel ones have one for all places.
fn gtao_towards(camera: Camera, place: vec3f) -> vec3f {
    return select(vec3f(0.0, 0.0, 1.0), gtao_unit(-place), camera.projection[2].w != 0.0);
}

// The share of the cosine-weighted light of a half slice between the normal and a horizon, whose angles are from the
// direction to the camera.
fn gtao_arc(horizon: f32, normal: f32) -> f32 {
    return 0.25 * (cos(normal) - cos(2.0 * horizon - normal) + 2.0 * horizon * sin(normal));
}

// A place to look from, and its normal.
struct GtaoPoint {
    pixel: vec2i,
    place: vec3f,
    towards: vec3f,
    normal: vec3f,
}

// The highest cosine of the angle between the direction to the camera and an occluder on one side of a slice. `way` is
// the longest way in pixels, `lowest` the cosine of the surface's own horizon.
fn gtao_horizon(
    depth: texture_2d<f32>,
    camera: Camera,
    point: GtaoPoint,
    way: vec2f,
    lowest: f32,
    shift: f32,
    params: Gtao,
) -> f32 {
    var highest = lowest;
    let reach = length(way);
    for (var i = 0; i < min(params.steps, 32); i++) {
        let share = (f32(i) + shift) / f32(params.steps);
        let pixels = 1.0 + share * share * max(reach - 1.0, 0.0);
        let p = point.pixel + vec2i(round(way * (pixels / reach)));
        if any(p < vec2i(0)) || any(p >= vec2i(textureDimensions(depth))) { continue; }
        let to = gtao_place(depth, camera, p) - point.place;
        let distance = length(to);
        let cosine = dot(to, point.towards) / max(distance, 1e-6);
        let near = clamp((params.radius - distance) / (params.falloff * params.radius), 0.0, 1.0);
        let rise = clamp(dot(to, point.normal) / max(GTAO_FLAT * distance, 1e-6), 0.0, 1.0);
        highest = max(highest, mix(lowest, cosine, near * rise));
    }
    return highest;
}

// The visibility of one slice times its weight, the length of the normal in the slice.
fn gtao_slice(
    depth: texture_2d<f32>,
    camera: Camera,
    point: GtaoPoint,
    direction: vec2f,
    shift: f32,
    params: Gtao,
) -> f32 {
    let along = vec3f(direction, 0.0);
    let towards = point.towards;
    let side = gtao_unit(cross(along, towards));
    let within = point.normal - side * dot(point.normal, side);
    let size = length(within);
    let tangent = along - towards * dot(along, towards);
    let cosine = clamp(dot(within, towards) / max(size, 1e-6), -1.0, 1.0);
    let angle = select(-acos(cosine), acos(cosine), dot(tangent, within) >= 0.0);
    let image = vec2f(textureDimensions(depth));
    let way = camera_uv_apart(camera, direction * params.radius, -point.place.z) * image;
    let limited = way * min(1.0, params.most / max(length(way), 1e-6));
    if length(limited) < 1.0 { return size * (cos(angle) + angle * sin(angle)); }
    let half_turn = 0.5 * GTAO_PI;
    let lows = vec2f(cos(angle + half_turn), cos(angle - half_turn));
    let up = acos(clamp(gtao_horizon(depth, camera, point, limited, lows.x, shift, params), -1.0, 1.0));
    let down = -acos(clamp(gtao_horizon(depth, camera, point, -limited, lows.y, shift, params), -1.0, 1.0));
    let high = angle + min(up - angle, half_turn);
    let low = angle + max(down - angle, -half_turn);
    return size * (gtao_arc(low, angle) + gtao_arc(high, angle));
}

// The visibility from a point: directions and ways differ within four by four texels, which the denoiser makes one.
fn gtao_visible(depth: texture_2d<f32>, camera: Camera, point: GtaoPoint, texel_at: vec2i, params: Gtao) -> f32 {
    let turn = f32(((texel_at.x + texel_at.y) & 3) * 4 + (texel_at.x & 3)) / 16.0;
    let shift = 0.125 + 0.25 * f32((texel_at.y - texel_at.x) & 3);
    let count = min(params.slices, 16);
    var sum = 0.0;
    for (var i = 0; i < count; i++) {
        let angle = GTAO_PI * (f32(i) + turn) / f32(count);
        sum += gtao_slice(depth, camera, point, vec2f(cos(angle), sin(angle)), shift, params);
    }
    return clamp(sum / f32(count), 0.0, 1.0);
}

// The pixel of the depth image that a texel of the result stands for.
fn gtao_pixel(depth: texture_2d<f32>, at: Point, params: Gtao) -> vec2i {
    let last = vec2i(textureDimensions(depth)) - 1;
    return min(vec2i(floor((vec2f(at.pixel) + 0.5) * params.stride)), last);
}

// The visibility and the inverse of the distance at a point.
fn gtao_found(depth: texture_2d<f32>, camera: Camera, pixel: vec2i, normal: vec3f, at: Point, params: Gtao) -> vec4f {
    let inverse = depth_inverse(depth, pixel);
    let place = gtao_place(depth, camera, pixel);
    let point = GtaoPoint(pixel, place, gtao_towards(camera, place), normal);
    if inverse * GTAO_FARTHEST < 1.0 { return vec4f(1.0, inverse, 0.0, 1.0); }
    return vec4f(gtao_visible(depth, camera, point, at.pixel, params), inverse, 0.0, 1.0);
}

fn gtao_visibility(depth: texture_2d<f32>, camera: Camera, at: Point, params: Gtao) -> vec4f {
    let pixel = gtao_pixel(depth, at, params);
    return gtao_found(depth, camera, pixel, gtao_normal(depth, camera, pixel), at, params);
}

fn gtao_visibility_normals(
    depth: texture_2d<f32>,
    normal: texture_2d<f32>,
    camera: Camera,
    at: Point,
    params: Gtao,
) -> vec4f {
    let pixel = gtao_pixel(depth, at, params);
    let given = texel(normal, pixel).xyz;
    let turned = (camera.view * vec4f(given, 0.0)).xyz;
    return gtao_found(depth, camera, pixel, gtao_unit(select(given, turned, params.is_world > 0.5)), at, params);
}

// The slope of the inverse distances, which the y of visibilities holds: as in `depth_slope`.
fn gtao_slope(noisy: texture_2d<f32>, p: vec2i, step: vec2i) -> f32 {
    let middle = texel(noisy, p).y;
    let after = texel(noisy, p + step).y - middle;
    let before = middle - texel(noisy, p - step).y;
    let has_after = all(p + step < vec2i(textureDimensions(noisy)));
    let has_before = all(p >= step);
    return select(before, after, has_after && (!has_before || abs(after) < abs(before)));
}

// A mean over four texels of an axis on the pixel's own surface. All sixteen directions have the same weight in two of
// these passes.
fn gtao_denoise(noisy: texture_2d<f32>, at: Point, params: Gtao) -> vec4f {
    let step = vec2i(params.axis);
    let slope = gtao_slope(noisy, at.pixel, step);
    let own = texel(noisy, at.pixel);
    var sum = vec2f(own.x, 1.0);
    for (var i = -2; i <= 2; i++) {
        let place = at.pixel + i * step;
        let is_inside = all(place >= vec2i(0)) && all(place < vec2i(textureDimensions(noisy)));
        if i == 0 || !is_inside { continue; }
        let other = texel(noisy, place);
        let like = depth_likeness(own.y + slope * f32(i), other.y, max(own.y, 1e-6), GTAO_SOFT);
        let weight = like * select(1.0, 0.5, abs(i) == 2);
        sum += weight * vec2f(other.x, 1.0);
    }
    return vec4f(sum.x / sum.y, own.y, 0.0, 1.0);
}

// From half of the size to the whole: the nearest four, weighted by how well their depths fit. Where none fits, the one
// that fits best counts most.
fn gtao_enlarge(small: texture_2d<f32>, depth: texture_2d<f32>, at: Point, params: Gtao) -> vec4f {
    let inverse = depth_inverse(depth, at.pixel);
    // The texel with index i shows the pixel 2 i + 1.
    let place = (vec2f(at.pixel) - floor(0.5 * params.stride)) / params.stride;
    let base = floor(place);
    let part = place - base;
    var sum = vec2f();
    for (var i = 0; i < 4; i++) {
        let corner = vec2i(i & 1, i >> 1);
        let share = select(1.0 - part, part, corner == vec2i(1));
        let other = texel(small, vec2i(base) + corner);
        let off = abs(other.y - inverse) / (GTAO_SOFT * inverse);
        let weight = (share.x * share.y + 1e-3) / (1e-3 + off * off);
        sum += weight * vec2f(other.x, 1.0);
    }
    return vec4f(sum.x / sum.y, inverse, 0.0, 1.0);
}

// The visibility that is shown.
fn gtao_shown(visibility: vec4f, params: Gtao) -> f32 {
    return 1.0 - params.amount * (1.0 - power(visibility.x, params.power));
}

fn gtao_lit(source: vec4f, visibility: vec4f, params: Gtao) -> vec4f {
    return vec4f(bounded_scene(source.rgb * gtao_shown(visibility, params)), source.a);
}

// Light that bounces between surfaces of this albedo: a fit of the same authors.
fn gtao_lit_albedo(source: vec4f, visibility: vec4f, albedo: vec4f, params: Gtao) -> vec4f {
    let color = clamp(albedo.rgb, vec3f(0.0), vec3f(1.0));
    let v = gtao_shown(visibility, params);
    let a = 2.0404 * color - 0.3324;
    let b = -4.7951 * color + 0.6417;
    let c = 2.7552 * color + 0.6903;
    let bounced = max(vec3f(v), ((v * a + b) * v + c) * v);
    return vec4f(bounded_scene(source.rgb * min(bounced, vec3f(1.0))), source.a);
}

fn gtao_occlusion(visibility: vec4f, params: Gtao) -> vec4f {
    return vec4f(1.0 - gtao_shown(visibility, params), 0.0, 0.0, 0.0);
}
