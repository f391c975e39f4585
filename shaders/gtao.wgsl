// Ambient occlusion from depth: for some slices of the hemisphere over a pixel, the highest horizon to both sides, and
// the share of cosine-weighted light between them in closed form. Jimenez, Wu, Pesce and Jarabo, "Practical Realtime
// Strategies for Accurate Indirect Occlusion", 2016. Horizons fall back to the surface's own where occluders fade out
// at the radius.
import afterimage::camera::{Camera, camera_uv_apart};
import afterimage::depth::depth_inverse;
import afterimage::surface::{
    SURFACE_FARTHEST, surface_given_normal, surface_normal, surface_pixel, surface_place, surface_toward, surface_turn,
    surface_unit,
};

struct Gtao {
    radius: f32,
    falloff: f32,
    slices: i32,
    steps: i32,
    max_radius: f32,   // the longest way in pixels of the depth image
    is_world: f32,     // 1 if the normals are in the world's space
    stride: f32,       // pixels of the depth image from one texel of the result to the next
}

const GTAO_PI: f32 = 3.14159265;
// The sine of the angle over the surface below which an occluder counts less: texels lie beside the slice, and depths
// are rounded, so a flat surface would occlude itself.
const GTAO_FLAT: f32 = 0.08;

// The share of the cosine-weighted light of a half slice between the normal and a horizon, whose angles are from the
// direction to the camera.
fn gtao_arc(horizon: f32, normal: f32) -> f32 {
    return 0.25 * (cos(normal) - cos(2.0 * horizon - normal) + 2.0 * horizon * sin(normal));
}

// A place to look from, and its normal.
struct GtaoPoint {
    pixel: vec2i,
    place: vec3f,
    toward: vec3f,
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
        let to = surface_place(depth, camera, p) - point.place;
        let distance = length(to);
        let cosine = dot(to, point.toward) / max(distance, 1e-6);
        let near = clamp((params.radius - distance) / (params.falloff * params.radius), 0.0, 1.0);
        let rise = clamp(dot(to, point.normal) / max(GTAO_FLAT * distance, 1e-6), 0.0, 1.0);
        highest = max(highest, mix(lowest, cosine, near * rise));
    }
    return highest;
}

// The occlusion of one slice, whose `tangent` is across the direction to the camera: the cosine-weighted light of one
// that the surface alone bounds, less that between the horizons. Both are in closed form.
fn gtao_slice(
    depth: texture_2d<f32>,
    camera: Camera,
    point: GtaoPoint,
    tangent: vec3f,
    shift: f32,
    params: Gtao,
) -> f32 {
    let place = point.place;
    let facing = vec2f(dot(point.normal, point.toward), dot(point.normal, tangent));
    let size = length(facing);
    let angle = select(atan2(facing.y, facing.x), 0.0, size < 1e-6);
    let image = vec2f(textureDimensions(depth));
    // The slice is a line in the image.
    let along = tangent.xy - place.xy * (tangent.z / place.z);
    let way = camera_uv_apart(camera, along * params.radius, -place.z) * image;
    let limited = way * min(1.0, params.max_radius / max(length(way), 1e-6));
    if length(limited) < 1.0 { return 0.0; }
    let half_turn = 0.5 * GTAO_PI;
    let lows = vec2f(cos(angle + half_turn), cos(angle - half_turn));
    let up = acos(clamp(gtao_horizon(depth, camera, point, limited, lows.x, shift, params), -1.0, 1.0));
    let down = -acos(clamp(gtao_horizon(depth, camera, point, -limited, lows.y, shift, params), -1.0, 1.0));
    let high = angle + min(up - angle, half_turn);
    let low = angle + max(down - angle, -half_turn);
    return max(facing.x + angle * facing.y - size * (gtao_arc(low, angle) + gtao_arc(high, angle)), 0.0);
}

// The visibility from a point: directions and ways differ within four by four texels, which the denoiser makes one.
// Slices lie evenly around the direction to the camera. The light of a few is not that of the hemisphere, so what they
// miss of their own is taken from 1. This may be below 0 before the mean.
fn gtao_visible(depth: texture_2d<f32>, camera: Camera, point: GtaoPoint, texel_at: vec2i, params: Gtao) -> f32 {
    let turn = surface_turn(texel_at);
    let shift = 0.125 + 0.25 * f32((texel_at.y - texel_at.x) & 3);
    let count = min(params.slices, 16);
    let right = surface_unit(vec3f(point.toward.z, 0.0, -point.toward.x));
    let up = cross(point.toward, right);
    var occlusion = 0.0;
    for (var i = 0; i < count; i++) {
        let angle = GTAO_PI * (f32(i) + turn) / f32(count);
        let tangent = cos(angle) * right + sin(angle) * up;
        occlusion += gtao_slice(depth, camera, point, tangent, shift, params);
    }
    return 1.0 - occlusion / f32(count);
}

// The visibility and the inverse of the distance at a point.
fn gtao_found(depth: texture_2d<f32>, camera: Camera, pixel: vec2i, normal: vec3f, at: Point, params: Gtao) -> vec4f {
    let inverse = depth_inverse(depth, pixel);
    let place = surface_place(depth, camera, pixel);
    let point = GtaoPoint(pixel, place, surface_toward(camera, place), normal);
    if inverse * SURFACE_FARTHEST < 1.0 { return vec4f(1.0, inverse, 0.0, 1.0); }
    return vec4f(gtao_visible(depth, camera, point, at.pixel, params), inverse, 0.0, 1.0);
}

fn gtao_visibility(depth: texture_2d<f32>, camera: Camera, at: Point, params: Gtao) -> vec4f {
    let pixel = surface_pixel(depth, at, params.stride);
    return gtao_found(depth, camera, pixel, surface_normal(depth, camera, pixel), at, params);
}

fn gtao_visibility_normals(
    depth: texture_2d<f32>,
    normal: texture_2d<f32>,
    camera: Camera,
    at: Point,
    params: Gtao,
) -> vec4f {
    let pixel = surface_pixel(depth, at, params.stride);
    let given = surface_given_normal(camera, texel(normal, pixel).xyz, params.is_world);
    return gtao_found(depth, camera, pixel, given, at, params);
}
