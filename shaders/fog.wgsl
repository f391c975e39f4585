// Fog that is uniform or thins out with the height: the light of the scene is absorbed, and light of the sky and of the
// sun is scattered into its place. The optical depth of a ray through an exponential atmosphere has a closed form:
// Quilez, "Better Fog", 2010. Scattering of the sun: Henyey and Greenstein, 1941.
import afterimage::camera::{Camera, camera_place, camera_world};
import afterimage::depth::depth_distance;
import afterimage::grade::bounded_scene;

struct Fog {
    density: f32,
    falloff: f32,
    level: f32,
    eye_height: f32,
    up: vec3f,
    start: f32,
    most: f32,
    color: vec3f,
    sun: vec3f,
    sun_color: vec3f,
    anisotropy: f32,
    tan_fov: f32,
}

// The vector to a pixel at the depth 1: x right, y up, z toward the viewer.
fn fog_ray(at: Point, params: Fog) -> vec3f {
    let place = (2.0 * at.uv - 1.0) * vec2f(at.size.x / at.size.y, -1.0);
    return vec3f(place * params.tan_fov, -1.0);
}

// (1 - exp(-x)) / x, which is 1 at 0.
fn fog_mean(x: f32) -> f32 {
    let near = 1.0 - 0.5 * x + x * x / 6.0;
    return select((1.0 - exp(-x)) / select(x, 1.0, x == 0.0), near, abs(x) < 0.02);
}

// The optical depth of a ray from the start of the fog to a distance. The ray begins at a height.
fn fog_depth(eye_height: f32, rise: f32, distance: f32, params: Fog) -> f32 {
    let way = clamp(distance - params.start, 0.0, HALF_MAX);
    let height = clamp(eye_height, -1e6, 1e6) + rise * params.start - params.level;
    let thickness = exp(clamp(-params.falloff * height, -60.0, 20.0));
    return min(params.density * thickness * way * fog_mean(clamp(params.falloff * rise * way, -20.0, 60.0)), 60.0);
}

// The Henyey-Greenstein phase function times 4 pi: 1 in all directions at an anisotropy of 0.
fn fog_phase(cosine: f32, g: f32) -> f32 {
    let below = max(1.0 + g * g - 2.0 * g * cosine, 1e-4);
    return (1.0 - g * g) / (below * sqrt(below));
}

// Light that comes through fog of this optical depth from a direction.
fn fog_lit(source: vec4f, optical: f32, direction: vec3f, params: Fog) -> vec4f {
    let passed = max(exp(-optical), 1.0 - params.most);
    let scattered = params.color + params.sun_color * fog_phase(dot(direction, params.sun), params.anisotropy);
    return vec4f(bounded_scene(source.rgb * passed + scattered * (1.0 - passed)), source.a);
}

fn fog(source: vec4f, depth: vec4f, at: Point, params: Fog) -> vec4f {
    let ray = fog_ray(at, params);
    let direction = normalize(ray);
    let distance = depth_distance(depth.x) * length(ray);
    let optical = fog_depth(params.eye_height, dot(params.up, direction), distance, params);
    return fog_lit(source, optical, direction, params);
}

// The same in the world's space: the camera says where a ray begins and where it leads.
fn fog_camera(source: vec4f, depth: vec4f, camera: Camera, at: Point, params: Fog) -> vec4f {
    let start = camera_place(camera, at.uv, 0.0);
    let ray = camera_place(camera, at.uv, depth_distance(depth.x)) - start;
    let direction = (camera.inverse_view * vec4f(ray / max(length(ray), 1e-6), 0.0)).xyz;
    let height = dot(params.up, camera_world(camera, start));
    return fog_lit(source, fog_depth(height, dot(params.up, direction), length(ray), params), direction, params);
}
