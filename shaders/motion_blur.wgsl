// Motion blur: each pixel gathers the light that moves over it while the shutter is open. McGuire, Hennessy, Bukowski
// and Osman, "A Reconstruction Filter for Plausible Motion Blur", I3D 2012.
#import camera
#import grade
#import math
#import noise

struct MotionBlur {
    samples: i32,
    tile: i32,
    most: f32,     // the longest half of a path, in pixels
    scale: vec2f,  // from the numbers of the motion image to half of the path in pixels
}

// Surfaces whose depths differ by less than this share belong together.
const MOTION_BLUR_SOFT: f32 = 0.05;

// Half of the path of a pixel while the shutter is open, in pixels.
fn motion_blur_limited(motion: vec2f, params: MotionBlur) -> vec2f {
    let path = clamp(motion * params.scale, vec2f(-1e4), vec2f(1e4));
    return path * min(1.0, params.most / max(length(path), 1e-6));
}

// The same and the depth, 1 without one.
fn motion_blur_path(motion: vec4f, params: MotionBlur) -> vec4f {
    return vec4f(motion_blur_limited(motion.xy, params), 1.0, 1.0);
}

fn motion_blur_path_depth(motion: vec4f, depth: vec4f, params: MotionBlur) -> vec4f {
    return vec4f(motion_blur_limited(motion.xy, params), max(depth.x, 1e-3), 1.0);
}

// The path of what stands still while the camera moves.
fn motion_blur_path_camera(depth: vec4f, camera: Camera, at: Point, params: MotionBlur) -> vec4f {
    let distance = clamp(depth.x, 1e-3, HALF_MAX);
    let uv = at.uv + camera.jitter / at.size;
    let before = camera_previous_uv(camera, camera_world(camera, camera_place(camera, uv, distance)));
    return vec4f(motion_blur_limited(clamp(uv - before.xy, vec2f(-1e3), vec2f(1e3)), params), distance, 1.0);
}

// Without motion and camera nothing moves.
fn motion_blur_still(source: vec4f) -> vec4f {
    return source;
}

// The longer of two paths.
fn motion_blur_longer(a: vec2f, b: vec2f) -> vec2f {
    return select(a, b, dot(b, b) > dot(a, a));
}

// The longest path in a row of texels, and in a column of such rows.
fn motion_blur_rows(path: texture_2d<f32>, at: Point, params: MotionBlur) -> vec4f {
    var longest = vec2f();
    for (var i = 0; i < params.tile; i++) {
        let place = vec2i(at.pixel.x * params.tile + i, at.pixel.y);
        longest = motion_blur_longer(longest, texel(path, place).xy);
    }
    return vec4f(longest, 0.0, 1.0);
}

fn motion_blur_tiles(rows: texture_2d<f32>, at: Point, params: MotionBlur) -> vec4f {
    var longest = vec2f();
    for (var i = 0; i < params.tile; i++) {
        let place = vec2i(at.pixel.x, at.pixel.y * params.tile + i);
        longest = motion_blur_longer(longest, texel(rows, place).xy);
    }
    return vec4f(longest, 0.0, 1.0);
}

// The longest path of the nine tiles around: no path leads farther than a tile.
fn motion_blur_around(tiles: texture_2d<f32>, at: Point) -> vec4f {
    var longest = vec2f();
    for (var y = -1; y <= 1; y++) {
        for (var x = -1; x <= 1; x++) {
            longest = motion_blur_longer(longest, texel(tiles, at.pixel + vec2i(x, y)).xy);
        }
    }
    return vec4f(longest, 0.0, 1.0);
}

// 1 at the place itself, 0 at the end of a path.
fn motion_blur_cone(distance: f32, length: f32) -> f32 {
    return clamp(1.0 - distance / max(length, 1e-3), 0.0, 1.0);
}

// 1 along a path, 0 beyond its end.
fn motion_blur_cylinder(distance: f32, length: f32) -> f32 {
    return 1.0 - smooth_step(0.95 * length, 1.05 * length, distance);
}

// 1 if the first depth is not behind the second, 0 if it is well behind.
fn motion_blur_before(first: f32, second: f32) -> f32 {
    return clamp(1.0 - (first - second) / (MOTION_BLUR_SOFT * min(first, second)), 0.0, 1.0);
}

// The share of the light at another place that is seen at this one: of what moves over it from there, of what is seen
// there while this place's own surface has moved away, and of both together.
fn motion_blur_share(own: vec3f, other: vec3f, distance: f32) -> f32 {
    let own_length = length(own.xy);
    let other_length = length(other.xy);
    let over = motion_blur_before(other.z, own.z) * motion_blur_cone(distance, other_length);
    let through = motion_blur_before(own.z, other.z) * motion_blur_cone(distance, own_length);
    let both = motion_blur_cylinder(distance, other_length) * motion_blur_cylinder(distance, own_length);
    return over + through + 2.0 * both;
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
    if dot(longest, longest) < 0.25 { return center; }
    let own = texel(path, at.pixel).xyz;
    let own_weight = 1.0 / max(length(own.xy), 0.5);
    var sum = own_weight * vec4f(center.rgb, 1.0);
    let count = min(params.samples, 64);
    let shift = hash_cell(at.pixel) - 0.5;
    for (var i = 0; i < count; i++) {
        let offset = longest * (2.0 * (f32(i) + 0.5 + shift) / f32(count) - 1.0);
        let place = at.pixel + vec2i(round(offset));
        let share = motion_blur_share(own, texel(path, place).xyz, length(offset));
        sum += share * vec4f(texel(source, place).rgb, 1.0);
    }
    return vec4f(bounded_scene(sum.rgb / sum.w), center.a);
}
