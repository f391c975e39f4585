import afterimage::camera::{Camera, camera_position, camera_world};

struct GroundFog { color: vec3f, height: f32 }

fn ground_fog(source: vec4f, depth: texture_2d<f32>, camera: Camera, at: Point, params: GroundFog) -> vec4f {
    let seen = texel(depth, at.pixel).x;
    let place = camera_world(camera, camera_position(camera, at.uv, seen));
    let density = clamp(1.0 - place.y / params.height, 0.0, 1.0);
    return vec4f(mix(source.rgb, params.color, density), source.a);
}
