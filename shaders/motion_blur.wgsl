// Motion blur: each pixel gathers the light that moves over it while the shutter is open. Tiles of longest paths, and
// classes by depth: McGuire, Hennessy, Bukowski and Osman, "A Reconstruction Filter for Plausible Motion Blur", I3D
// 2012; samples along both paths: Guertin, McGuire and Nowrouzezahrai, "A Fast and Stable Feature-Aware Motion Blur
// Filter", HPG 2014. Weights are shares of the time for which the shutter is open.
import afterimage::camera::{Camera, camera_place, camera_previous_uv, camera_world};
import afterimage::depth::{depth_at, depth_distance};
import afterimage::front::{FRONT_SOFT, front_beside, front_is_before, front_pixel};
import afterimage::grade::bounded_scene;
import afterimage::math::between;
import afterimage::noise::hash_cell;

struct MotionBlur {
    samples: i32,
    tile: i32,
    max_radius: f32,  // the longest half of a path, in pixels
    scale: vec2f,     // from the numbers of the motion image to half of the path in pixels
}

// Half of the path of a pixel while the shutter is open, in pixels.
fn motion_blur_limited(motion: vec2f, params: MotionBlur) -> vec2f {
    let path = clamp(motion * params.scale, vec2f(-1e4), vec2f(1e4));
    return path * min(1.0, params.max_radius / max(length(path), 1e-6));
}

// 1 if the first depth is well before the second, 0 if it is not before it.
fn motion_blur_before(first: f32, second: f32) -> f32 {
    return clamp((second - first) / (FRONT_SOFT * min(first, second)), 0.0, 1.0);
}

// The path at a pixel and the depth. Without one, what moves faster counts as nearer.
fn motion_blur_found(motion: texture_2d<f32>, p: vec2i, params: MotionBlur) -> vec3f {
    let path = motion_blur_limited(texel(motion, p).xy, params);
    return vec3f(path, 1.0 / (1.0 + length(path)));
}

// The path and the depth of a pixel beside a front. Where edges are smooth, it shows a part of the front, which would
// stay as a line where the front began to move: so it moves with the front, if that moves in another way.
fn motion_blur_joined(own: vec3f, front: vec3f) -> vec4f {
    return vec4f(select(own, front, distance(own.xy, front.xy) >= 1.0), 1.0);
}

fn motion_blur_path(motion: texture_2d<f32>, at: Point, params: MotionBlur) -> vec4f {
    let own = motion_blur_found(motion, at.pixel, params);
    var front = own;
    for (var i = 0; i < 4; i++) {
        let other = motion_blur_found(motion, front_beside(at.pixel, i), params);
        front = select(front, other, front_is_before(other.z, own.z) && other.z < front.z);
    }
    return motion_blur_joined(own, front);
}

fn motion_blur_path_depth(
    motion: texture_2d<f32>,
    depth: texture_2d<f32>,
    at: Point,
    params: MotionBlur,
) -> vec4f {
    let p = front_pixel(depth, at.pixel);
    let own = vec3f(motion_blur_limited(texel(motion, at.pixel).xy, params), depth_at(depth, at.pixel));
    let front = vec3f(motion_blur_limited(texel(motion, p).xy, params), depth_at(depth, p));
    return motion_blur_joined(own, front);
}

// The path of what stands still while the camera moves.
fn motion_blur_path_camera(depth: vec4f, camera: Camera, at: Point, params: MotionBlur) -> vec4f {
    let distance = depth_distance(depth.x);
    let uv = at.uv + camera.jitter / at.size;
    let before = camera_previous_uv(camera, camera_world(camera, camera_place(camera, uv, distance)));
    return vec4f(motion_blur_limited(clamp(uv - before.xy, vec2f(-1e3), vec2f(1e3)), params), distance, 1.0);
}

// Without motion and camera nothing moves.
fn motion_blur_still(source: vec4f) -> vec4f {
    return source;
}

// The share of the time in which what moves half a path of this length is seen at a pixel this far away.
fn motion_blur_cover(path: f32, distance: f32) -> f32 {
    let half = max(path, 0.5);
    return clamp(half + 0.5 - distance, 0.0, 1.0) / (2.0 * half);
}

// The position of a sample along a path, evenly over it and half a pixel beyond, and its distance.
fn motion_blur_sample(direction: vec2f, reach: f32, part: f32) -> vec3f {
    let offset = round(direction * (reach * (2.0 * part - 1.0)));
    return vec3f(offset, abs(dot(offset, direction)));
}

fn motion_blur(
    source: texture_2d<f32>,
    path: texture_2d<f32>,
    around: texture_2d<f32>,
    at: Point,
    params: MotionBlur,
) -> vec4f {
    let center = texel(source, at.pixel);
    let longest = texel(around, at.pixel / params.tile).xy;
    let most = length(longest);
    if most < 0.5 { return center; }
    let own = texel(path, at.pixel).xyz;
    let own_length = length(own.xy);
    let count = (clamp(params.samples, 1, 64) + 1) / 2;
    let shift = hash_cell(at.pixel);

    // What is before the pixel's own surface and moves over it, along the longest path around: light with its alpha,
    // and for how much of the time.
    var front = vec4f();
    var covered = 0.0;
    let across = longest / most;
    for (var i = 0; i < count; i++) {
        let place = motion_blur_sample(across, most + 0.5, (f32(i) + shift) / f32(count));
        let other = texel(path, at.pixel + vec2i(place.xy)).xyz;
        let cover = motion_blur_before(other.z, own.z) * motion_blur_cover(abs(dot(other.xy, across)), place.z);
        front += cover * texel(source, at.pixel + vec2i(place.xy));
        covered += cover;
    }

    // The own surface along its own path, and what is seen beside it while it has moved away.
    var light = center;
    if own_length >= 0.5 {
        let along = own.xy / own_length;
        var same = center * 1e-3;
        var behind = vec4f();
        var weights = vec2f(1e-3, 0.0);
        for (var i = 0; i < count; i++) {
            let place = motion_blur_sample(along, own_length + 0.5, (f32(i) + shift) / f32(count));
            let other = texel(path, at.pixel + vec2i(place.xy)).xyz;
            let color = texel(source, at.pixel + vec2i(place.xy));
            let is_before = motion_blur_before(other.z, own.z);
            let is_behind = motion_blur_before(own.z, other.z);
            let cover = motion_blur_cover(abs(dot(other.xy, along)), place.z);
            let seen = vec2f((1.0 - is_before - is_behind) * cover, is_behind * motion_blur_cover(own_length, place.z));
            same += seen.x * color;
            behind += seen.y * color;
            weights += seen;
        }
        let cover = min(weights.x * 2.0 * (own_length + 0.5) / f32(count), 1.0);
        light = same / weights.x;
        if weights.y > 1e-6 { light = between(behind / weights.y, light, cover); }
    }
    let share = min(covered * 2.0 * (most + 0.5) / f32(count), 1.0);
    light = between(light, front / max(covered, 1e-6), share);
    return vec4f(bounded_scene(light.rgb), clamp(light.a, 0.0, HALF_MAX));
}
