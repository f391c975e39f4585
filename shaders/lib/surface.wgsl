// Places and normals of surfaces that an image of distances along the view axis shows, in the camera's space.
import package::camera::{Camera, camera_place};
import package::depth::depth_at;

// Anything farther is the sky, which is no surface.
const SURFACE_FARTHEST: f32 = 60000.0;

// The position of the surface at a texel of the depth image, in the camera's space.
fn surface_place(depth: texture_2d<f32>, camera: Camera, p: vec2i) -> vec3f {
    let uv = (vec2f(p) + 0.5) / vec2f(textureDimensions(depth));
    return camera_place(camera, uv, depth_at(depth, p));
}

// The way along the surface to the next texel: to the side where the depth bends less.
fn surface_tangent(depth: texture_2d<f32>, camera: Camera, p: vec2i, step: vec2i) -> vec3f {
    let middle = surface_place(depth, camera, p);
    let after = surface_place(depth, camera, p + step) - middle;
    let before = middle - surface_place(depth, camera, p - step);
    let has_after = all(p + step < vec2i(textureDimensions(depth)));
    let has_before = all(p >= step);
    return select(before, after, has_after && (!has_before || abs(after.z) < abs(before.z)));
}

// A unit vector, or the one toward the camera where there is none.
fn surface_unit(v: vec3f) -> vec3f {
    let square = dot(v, v);
    return select(vec3f(0.0, 0.0, 1.0), v * inverseSqrt(max(square, 1e-30)), square > 1e-30);
}

// The normal of the surface at a texel, from the depth.
fn surface_normal(depth: texture_2d<f32>, camera: Camera, p: vec2i) -> vec3f {
    let right = surface_tangent(depth, camera, p, vec2i(1, 0));
    let down = surface_tangent(depth, camera, p, vec2i(0, 1));
    return surface_unit(cross(down, right));
}

// The direction to the camera: parallel ones have one for all places.
fn surface_toward(camera: Camera, place: vec3f) -> vec3f {
    return select(vec3f(0.0, 0.0, 1.0), surface_unit(-place), camera.projection[2].w != 0.0);
}

// The normal that an image gives, which may be in the world's space, in that of the camera.
fn surface_given_normal(camera: Camera, given: vec3f, is_world: f32) -> vec3f {
    let turned = (camera.view * vec4f(given, 0.0)).xyz;
    return surface_unit(select(given, turned, is_world > 0.5));
}

// Sixteen parts of a turn, which differ within four by four pixels.
fn surface_turn(pixel: vec2i) -> f32 {
    return f32(((pixel.x + pixel.y) & 3) * 4 + (pixel.x & 3)) / 16.0;
}

// The pixel of a depth image that a texel of a smaller image stands for, which has `stride` pixels for each texel.
fn surface_pixel(depth: texture_2d<f32>, at: Point, stride: f32) -> vec2i {
    let last = vec2i(textureDimensions(depth)) - 1;
    return min(vec2i(floor((vec2f(at.pixel) + 0.5) * stride)), last);
}
