// Ambient occlusion from depth: the share of points in the hemisphere over a pixel that lie behind what the depth image
// shows. Mittring, "Finding Next Gen", 2007; Filion and McNaughton, "Effects and Techniques", 2008. The points have a
// low discrepancy (heights by the radical inverse, angles by the golden ratio), and lie more densely near the pixel.
import afterimage::camera::{Camera, camera_uv};
import afterimage::depth::depth_inverse;
import afterimage::surface::{
    SURFACE_FARTHEST, surface_given_normal, surface_normal, surface_pixel, surface_place, surface_toward, surface_turn,
};

struct Ssao {
    radius: f32,
    bias: f32,
    samples: i32,
    is_world: f32,     // 1 if the normals are in the world's space
    stride: f32,       // pixels of the depth image from one texel of the result to the next
}

// A point of the hemisphere over z, of a radius from 0.1 to 1.
fn ssao_point(index: i32, count: i32) -> vec3f {
    let height = 0.05 + 0.95 * (f32(reverseBits(u32(index)) >> 8u) / 16777216.0);
    let angle = 6.2831853 * fract(0.61803399 * f32(index));
    let share = f32(index) / f32(count);
    let aside = sqrt(1.0 - height * height);
    return (0.1 + 0.9 * share * share) * vec3f(aside * cos(angle), aside * sin(angle), height);
}

// Two directions across a unit vector: Frisvad, "Building an Orthonormal Basis from a 3D Unit Vector Without
// Normalization", 2012, with the sign of Duff and others, 2017.
fn ssao_frame(n: vec3f) -> mat3x3f {
    let s = select(-1.0, 1.0, n.z >= 0.0);
    let a = -1.0 / (s + n.z);
    let b = n.x * n.y * a;
    return mat3x3f(vec3f(1.0 + s * n.x * n.x * a, s * b, -s * n.x), vec3f(b, s + n.y * n.y * a, -n.y), n);
}

// The visibility from a place. Points that the image does not show are not counted.
fn ssao_visible(
    depth: texture_2d<f32>,
    camera: Camera,
    place: vec3f,
    normal: vec3f,
    turn: f32,
    params: Ssao,
) -> f32 {
    let size = vec2f(textureDimensions(depth));
    let frame = ssao_frame(normal);
    let side = vec2f(cos(6.2831853 * turn), sin(6.2831853 * turn));
    let count = clamp(params.samples, 1, 64);
    var sum = vec2f();
    for (var i = 0; i < count; i++) {
        let point = ssao_point(i, count);
        let turned = vec3f(point.x * side.x - point.y * side.y, point.x * side.y + point.y * side.x, point.z);
        let there = place + params.radius * (frame * turned);
        let uv = camera_uv(camera, there).xy;
        let is_shown = there.z < 0.0 && all(uv >= vec2f(0.0)) && all(uv < vec2f(1.0));
        if !is_shown { continue; }
        let found = surface_place(depth, camera, vec2i(floor(uv * size)));
        let near = smoothstep(0.0, 1.0, params.radius / max(abs(place.z - found.z), 1e-4));
        // The depth is that of the middle of a pixel, and at a grazing angle much nearer than that of the point's own
        // place in it. The heights over the surface tell what is before the point, but where they rise with the depth.
        let is_above = dot(normal, found - place) >= params.radius * point.z;
        let rises = dot(normal, surface_toward(camera, found)) <= 0.0;
        let is_before = found.z >= there.z + params.bias && (is_above || rises);
        sum += vec2f(select(0.0, near, is_before), 1.0);
    }
    return 1.0 - sum.x / max(sum.y, 1.0);
}

// The visibility and the inverse of the distance at a pixel of the depth image.
fn ssao_found(depth: texture_2d<f32>, camera: Camera, pixel: vec2i, normal: vec3f, at: Point, params: Ssao) -> vec4f {
    let inverse = depth_inverse(depth, pixel);
    if inverse * SURFACE_FARTHEST < 1.0 { return vec4f(1.0, inverse, 0.0, 1.0); }
    let place = surface_place(depth, camera, pixel);
    let visible = ssao_visible(depth, camera, place, normal, surface_turn(at.pixel), params);
    return vec4f(visible, inverse, 0.0, 1.0);
}

fn ssao(depth: texture_2d<f32>, camera: Camera, at: Point, params: Ssao) -> vec4f {
    let pixel = surface_pixel(depth, at, params.stride);
    return ssao_found(depth, camera, pixel, surface_normal(depth, camera, pixel), at, params);
}

fn ssao_normals(depth: texture_2d<f32>, normal: texture_2d<f32>, camera: Camera, at: Point, params: Ssao) -> vec4f {
    let pixel = surface_pixel(depth, at, params.stride);
    let given = surface_given_normal(camera, texel(normal, pixel).xyz, params.is_world);
    return ssao_found(depth, camera, pixel, given, at, params);
}
