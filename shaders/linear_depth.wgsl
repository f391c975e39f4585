// From the depth that a projection writes to the distance along the view axis.
import afterimage::camera::{Camera, camera_distance};
import afterimage::depth::depth_distance;

fn linear_depth(depth: vec4f, camera: Camera, at: Point) -> vec4f {
    let distance = camera_distance(camera, at.uv, depth.x);
    return vec4f(depth_distance(distance), 0.0, 0.0, 1.0);
}

fn linear_depth_distance(depth: vec4f) -> vec4f {
    return depth;
}
