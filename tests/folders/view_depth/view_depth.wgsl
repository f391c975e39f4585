import afterimage::camera::{Camera, camera_distance};

fn view_depth(depth: texture_2d<f32>, camera: Camera, at: Point) -> vec4f {
    let seen = texel(depth, at.pixel).x;
    return vec4f(clamp(camera_distance(camera, at.uv, seen), 0.0, 65504.0), 0.0, 0.0, 1.0);
}
