// The built-in scene: a loft at golden hour, a dim room with a bright window, a low sun, neon and fine detail.
//
// Linear Rec.709 radiance in units in which the room's grays are 0.02 to 0.3. Equal parameters give equal images.
import afterimage::color::brightest;
import package::loft::{LOFT_BALL, LOFT_BALLOON, LOFT_OUTSIDE, LoftHit, loft_trace};
import package::loft_lamps::{LoftLamps, loft_lamps, loft_sun_point};
import package::loft_outside::loft_view;
import package::loft_pose::{LoftPose, loft_pose};
import package::loft_shade::{loft_haze, loft_lit};
import package::loft_surfaces::{LoftSurface, loft_surface};
import package::ray::{Ray, ray_direction};

struct DemoScene {
    time: f32,   // seconds; animates the neon's flicker and the dust in the sunbeam
    range: f32,  // stops from the room's gray to the sun's disc: 18 is the reference, 0 makes all light equal
    walk: f32,   // 0 deep in the room, 1 in front of the window
    step: f32,   // how far the camera has come since the previous frame
    dt: f32,     // seconds since the previous frame
    objects: i32,
    samples: i32,
    first: i32,
    jitter: vec2f,  // of the samples, in pixels, y downwards
    aperture: f32,  // meters
    focus: f32,     // meters
}

struct DemoSceneCamera {
    eye: vec3f,
    right: vec3f,
    up: vec3f,
    back: vec3f,
}

const DEMO_SCENE_TAN_FOV: f32 = 0.4245;     // of half the vertical field of view, 46 degrees
const DEMO_SCENE_NEAR: f32 = 0.1;           // meters
const DEMO_SCENE_SKY_DEPTH: f32 = 1000.0;   // meters
const DEMO_SCENE_BRIGHTEST: f32 = 60000.0;  // half floats end at 65504: leaves room for a filter's overshoot

// A level path past the pouf, along the table, to the window.
fn demo_scene_camera(walk: f32) -> DemoSceneCamera {
    let w = smoothstep(0.0, 1.0, walk);
    let eye = mix(vec3f(1.75, 1.55, 4.7), vec3f(-0.45, 1.62, -2.3), w);
    let aim = mix(vec3f(0.15, 1.72, -4.0), vec3f(-1.6, 2.0, -8.0), w);
    let back = normalize(eye - aim);
    let right = normalize(cross(vec3f(0.0, 1.0, 0.0), back));
    return DemoSceneCamera(eye, right, cross(back, right), back);
}

// The ray through a pixel, `offset` pixels from its center.
fn demo_scene_ray(camera: DemoSceneCamera, at: Point, offset: vec2f) -> Ray {
    let from_center = vec2f(at.pixel) + 0.5 + offset - 0.5 * at.size;
    let xy = from_center * vec2f(2.0, -2.0) * (DEMO_SCENE_TAN_FOV / at.size.y);
    return Ray(camera.eye, ray_direction(camera.right * xy.x + camera.up * xy.y - camera.back));
}

// The ray from a point of the lens to where the ray through its middle is in focus: that of a thin lens. `point` is on
// a disc of radius 1.
fn demo_scene_through_lens(camera: DemoSceneCamera, ray: Ray, point: vec2f, params: DemoScene) -> Ray {
    let sharp = ray.direction * (params.focus / dot(ray.direction, -camera.back));
    let aside = (camera.right * point.x + camera.up * point.y) * (0.5 * params.aperture);
    return Ray(ray.origin + aside, ray_direction(sharp - aside));
}

// The width of a pixel at a distance of one meter.
fn demo_scene_pixel(at: Point) -> f32 {
    return 2.0 * DEMO_SCENE_TAN_FOV / at.size.y;
}

// Share of the light along `view` that is a mirror reflection; 0 for rough surfaces.
fn demo_scene_reflectance(surface: LoftSurface, view: vec3f) -> vec3f {
    let grazing = pow(1.0 - clamp(dot(surface.normal, view), 0.0, 1.0), 5.0);
    let smoothness = (1.0 - surface.roughness) * (1.0 - surface.roughness);
    let polished = step(1e-3, brightest(surface.mirror));
    return (surface.mirror + (1.0 - surface.mirror) * grazing) * (smoothness * polished);
}

// Radiance along a ray with at most one mirror reflection, and the emissive strength of the first hit.
fn demo_scene_radiance(first: Ray, pixel: f32, sun: vec3f, lamps: LoftLamps, pose: LoftPose) -> vec4f {
    var ray = first;
    var share = vec3f(1.0);
    var color = vec3f(0.0);
    var glow = 0.0;
    var traveled = 0.0;
    for (var bounce = 0; bounce < 2; bounce++) {
        let hit = loft_trace(ray, pose);
        if bounce == 0 { color += loft_haze(ray, min(hit.distance, 20.0), lamps); }
        if hit.what == LOFT_OUTSIDE {
            color += share * loft_view(ray.direction, lamps);
            break;
        }
        let p = ray.origin + ray.direction * hit.distance;
        traveled += hit.distance;
        let surface = loft_surface(hit, p, traveled * pixel, lamps);
        color += share * loft_lit(surface, p, -ray.direction, hit.normal, sun, lamps, pose);
        if bounce == 0 { glow = surface.glow; }
        share *= demo_scene_reflectance(surface, -ray.direction);
        if brightest(share) < 0.004 { break; }
        ray = Ray(p + hit.normal * 1e-3, ray_direction(reflect(ray.direction, surface.normal)));
    }
    return vec4f(color, glow);
}

// Position of sample `i` of `count` in a pixel: on a rotated grid for four of them, else in the R2 sequence (Roberts,
// "The Unreasonable Effectiveness of Quasirandom Sequences", 2018).
fn demo_scene_offset(i: i32, count: i32) -> vec2f {
    var offset = vec2f(0.125, 0.375);
    if (i & 1) == 1 { offset = vec2f(-offset.y, offset.x); }
    if (i & 2) == 2 { offset = -offset; }
    let spread = fract(0.5 + f32(i) * vec2f(0.7548777, 0.5698403)) - 0.5;
    return select(spread, offset, count == 4);
}

// Position of sample `i` on a disc of radius 1: two parts of the R3 sequence (Roberts), apart from those in a pixel.
fn demo_scene_lens(i: i32) -> vec2f {
    let share = fract(0.5 + f32(i) * vec2f(0.8191725, 0.6710436));
    return sqrt(share.x) * vec2f(cos(6.2831853 * share.y), sin(6.2831853 * share.y));
}

// The image, with the emissive strength in alpha: the mean of its samples. A mean of linear light is what a lens
// collects, and no sample is brighter than the sun's disc.
fn demo_scene(at: Point, frame: Frame, params: DemoScene) -> vec4f {
    let camera = demo_scene_camera(params.walk);
    let lamps = loft_lamps(params.time, params.range);
    let pose = loft_pose(params.time, params.objects);
    let count = min(params.samples, 64);
    var sum = vec4f(0.0);
    for (var i = params.first; i < params.first + count; i++) {
        let offset = demo_scene_offset(i, count) + params.jitter;
        var ray = demo_scene_ray(camera, at, offset);
        if params.aperture > 0.0 { ray = demo_scene_through_lens(camera, ray, demo_scene_lens(i), params); }
        sum += demo_scene_radiance(ray, demo_scene_pixel(at), loft_sun_point(offset), lamps, pose);
    }
    let mean = sum / f32(count);
    return vec4f(min(mean.rgb, vec3f(DEMO_SCENE_BRIGHTEST)), mean.a);
}

// The surface at the middle of a pixel.
struct DemoSceneSeen {
    camera: DemoSceneCamera,
    ray: Ray,
    hit: LoftHit,
}

fn demo_scene_seen(at: Point, params: DemoScene) -> DemoSceneSeen {
    let camera = demo_scene_camera(params.walk);
    let ray = demo_scene_ray(camera, at, params.jitter);
    return DemoSceneSeen(camera, ray, loft_trace(ray, loft_pose(params.time, params.objects)));
}

// The distance along the view axis in meters.
fn demo_scene_distance(seen: DemoSceneSeen) -> f32 {
    let depth = -dot(seen.ray.direction, seen.camera.back) * seen.hit.distance;
    return select(depth, DEMO_SCENE_SKY_DEPTH, seen.hit.what == LOFT_OUTSIDE);
}

fn demo_scene_depth(at: Point, frame: Frame, params: DemoScene) -> vec4f {
    return vec4f(demo_scene_distance(demo_scene_seen(at, params)), 0.0, 0.0, 1.0);
}

// Depth as a projection writes it whose near plane is at 1 and whose far plane is infinitely far, at 0.
fn demo_scene_projected(at: Point, frame: Frame, params: DemoScene) -> vec4f {
    let seen = demo_scene_seen(at, params);
    let depth = DEMO_SCENE_NEAR / demo_scene_distance(seen);
    return vec4f(select(depth, 0.0, seen.hit.what == LOFT_OUTSIDE), 0.0, 0.0, 1.0);
}

// View-space normal: x right, y up, z toward the viewer. The sky has (0, 0, 1).
fn demo_scene_normal(at: Point, frame: Frame, params: DemoScene) -> vec4f {
    let seen = demo_scene_seen(at, params);
    let normal = seen.hit.normal;
    let camera = seen.camera;
    let n = vec3f(dot(normal, camera.right), dot(normal, camera.up), dot(normal, camera.back));
    return vec4f(select(n, vec3f(0.0, 0.0, 1.0), seen.hit.what == LOFT_OUTSIDE), 1.0);
}

// Diffuse albedo. Alpha is 1 where a light meter should count the pixel, 0 for the sky, lamps and metal.
fn demo_scene_albedo(at: Point, frame: Frame, params: DemoScene) -> vec4f {
    let seen = demo_scene_seen(at, params);
    let hit = seen.hit;
    if hit.what == LOFT_OUTSIDE { return vec4f(0.0); }
    let p = seen.ray.origin + seen.ray.direction * hit.distance;
    let lamps = loft_lamps(params.time, params.range);
    let surface = loft_surface(hit, p, hit.distance * demo_scene_pixel(at), lamps);
    return vec4f(surface.albedo, step(1e-3, brightest(surface.albedo)));
}

// The uv at which a camera sees the point at a vector from it; far outside for points behind it.
fn demo_scene_uv(camera: DemoSceneCamera, way: vec3f, at: Point) -> vec2f {
    let depth = max(-dot(way, camera.back), 1e-3);
    let place = vec2f(dot(way, camera.right), -dot(way, camera.up)) / (depth * DEMO_SCENE_TAN_FOV);
    return 0.5 + 0.5 * place * vec2f(at.size.y / at.size.x, 1.0);
}

// The motion of the surface that was hit since the previous frame.
fn demo_scene_moved(what: u32, params: DemoScene) -> vec3f {
    let now = loft_pose(params.time, params.objects);
    let before = loft_pose(params.time - params.dt, params.objects);
    let ball = select(vec3f(0.0), now.ball - before.ball, what == LOFT_BALL);
    return select(ball, now.balloon - before.balloon, what == LOFT_BALLOON);
}

// The position of the surface at a pixel's center minus its position in the previous frame, in uv. The sky is
// too far to move with the camera.
fn demo_scene_motion(at: Point, frame: Frame, params: DemoScene) -> vec4f {
    let seen = demo_scene_seen(at, params);
    let before = demo_scene_camera(params.walk - params.step);
    let way = seen.ray.direction * min(seen.hit.distance, DEMO_SCENE_SKY_DEPTH);
    let moved = seen.camera.eye - before.eye - demo_scene_moved(seen.hit.what, params);
    let is_sky = seen.hit.what == LOFT_OUTSIDE;
    let there = demo_scene_uv(before, way + select(moved, vec3f(0.0), is_sky), at);
    return vec4f(at.uv + params.jitter / at.size - there, 0.0, 1.0);
}
