// The camera of a frame: the host block `Camera`. Positions are in the camera's space, which looks along -z with y
// upwards, or in the world's. Depth is what the projection writes: from 0 to 1, with the near plane at either end.

struct Camera {
    view: mat4x4f,
    projection: mat4x4f,
    inverse_view: mat4x4f,
    inverse_projection: mat4x4f,
    previous_view: mat4x4f,
    previous_projection: mat4x4f,
    jitter: vec2f,
    previous_jitter: vec2f,
}

// The least divisor of a position: an infinite far plane has 0. Farther things count as this much closer.
const CAMERA_SMALLEST_W: f32 = 1e-7;

// The place in the camera's space of what is seen at `uv`.
fn camera_position(camera: Camera, uv: vec2f, depth: f32) -> vec3f {
    let clip = vec4f(2.0 * uv.x - 1.0, 1.0 - 2.0 * uv.y, depth, 1.0);
    let place = camera.inverse_projection * clip;
    return place.xyz / max(place.w, CAMERA_SMALLEST_W);
}

// The distance along the camera's axis of what is seen at `uv`.
fn camera_distance(camera: Camera, uv: vec2f, depth: f32) -> f32 {
    return -camera_position(camera, uv, depth).z;
}

// Projects a position in the camera's space to uv and depth. Positions behind the camera are far outside of 0..1.
fn camera_uv(camera: Camera, place: vec3f) -> vec3f {
    return camera_clip_uv(camera.projection * vec4f(place, 1.0));
}

// The place in the world of a place in the camera's space.
fn camera_world(camera: Camera, place: vec3f) -> vec3f {
    return (camera.inverse_view * vec4f(place, 1.0)).xyz;
}

// Projects a position in the world to uv and depth of the previous frame.
fn camera_previous_uv(camera: Camera, world: vec3f) -> vec3f {
    return camera_clip_uv(camera.previous_projection * (camera.previous_view * vec4f(world, 1.0)));
}

// uv and depth of a place in clip space.
fn camera_clip_uv(clip: vec4f) -> vec3f {
    let place = clip.xyz / max(clip.w, CAMERA_SMALLEST_W);
    return vec3f(0.5 + 0.5 * place.x, 0.5 - 0.5 * place.y, place.z);
}

// The divisor of clip space (w) at a distance along the camera's axis.
fn camera_clip_w(camera: Camera, distance: f32) -> f32 {
    return max(camera.projection[3].w - camera.projection[2].w * distance, CAMERA_SMALLEST_W);
}

// The place in the camera's space of what is seen at `uv` at this distance along the camera's axis.
fn camera_place(camera: Camera, uv: vec2f, distance: f32) -> vec3f {
    let m = camera.projection;
    let clip = vec2f(2.0 * uv.x - 1.0, 1.0 - 2.0 * uv.y) * camera_clip_w(camera, distance);
    let rest = clip - m[3].xy + m[2].xy * distance;
    let area = m[0].x * m[1].y - m[0].y * m[1].x;
    let xy = vec2f(m[1].y * rest.x - m[1].x * rest.y, m[0].x * rest.y - m[0].y * rest.x);
    return vec3f(xy / select(area, 1.0, area == 0.0), -distance);
}

// The distance in uv of two positions at this distance that are `apart` in the camera's x and y.
fn camera_uv_apart(camera: Camera, apart: vec2f, distance: f32) -> vec2f {
    let clip = camera.projection[0].xy * apart.x + camera.projection[1].xy * apart.y;
    return vec2f(0.5, -0.5) * clip / camera_clip_w(camera, distance);
}
