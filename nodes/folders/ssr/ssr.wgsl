import afterimage::camera::{Camera, CAMERA_SMALLEST_W, camera_clip_uv, camera_uv, camera_uv_apart};
import afterimage::depth::depth_at;
import afterimage::math::smooth_step;
import afterimage::sanitize::HALF_MAX;
import afterimage::surface::{SURFACE_FARTHEST, surface_given_normal, surface_normal, surface_place, surface_toward};

struct Ssr {
    amount: f32,
    roughness: f32,
    reflectance: vec3f,
    farthest: f32,
    thickness: f32,
    steps: i32,
    world: u32,
}

// A ray on the image: where it begins and ends, in pixels and along the view axis.
struct SsrRay {
    from_pixel: vec2f,
    to_pixel: vec2f,
    from_inverse: f32,   // of what clip space divides by
    to_inverse: f32,
    from_z: f32,
    to_z: f32,
    length: f32,         // in meters
    last: f32,           // the share of the ray that the image shows
}

// The hit of a ray.
struct SsrHit {
    uv: vec2f,
    way: f32,            // meters from the surface
    share: f32,          // how much of it is known
}

// The part of the image's side over which reflections fade at its border.
const SSR_BORDER: f32 = 0.08;
// Halvings of the step in which a ray meets a surface.
const SSR_HALVINGS: i32 = 6;

// The mean of the pixels under a texel.
fn ssr_levels(source: texture_2d<f32>, source_sampler: sampler, at: Point) -> vec4f {
    return tap(source, source_sampler, at.uv);
}

fn ssr_ray(camera: Camera, place: vec3f, way: vec3f, size: vec2f, farthest: f32) -> SsrRay {
    // Rays toward the camera end before it.
    let before = select(farthest, 0.95 * -place.z / max(way.z, 1e-6), way.z > 0.0);
    let length = min(farthest, before);
    let end = place + length * way;
    let from_clip = camera.projection * vec4f(place, 1.0);
    let to_clip = camera.projection * vec4f(end, 1.0);
    let from_pixel = camera_clip_uv(from_clip).xy * size;
    let to_pixel = camera_clip_uv(to_clip).xy * size;
    // The share up to the border that it leaves the image by.
    let run = to_pixel - from_pixel;
    let room = select(from_pixel, size - from_pixel, run > vec2f(0.0));
    let shares = room / max(abs(run), vec2f(1e-6));
    return SsrRay(
        from_pixel,
        to_pixel,
        1.0 / max(from_clip.w, CAMERA_SMALLEST_W),
        1.0 / max(to_clip.w, CAMERA_SMALLEST_W),
        place.z,
        end.z,
        length,
        clamp(min(shares.x, shares.y), 0.0, 1.0),
    );
}

// The distance along the view axis at a share of the ray on the image.
fn ssr_distance(ray: SsrRay, share: f32) -> f32 {
    let inverse = mix(ray.from_inverse, ray.to_inverse, share);
    return -mix(ray.from_z * ray.from_inverse, ray.to_z * ray.to_inverse, share) / inverse;
}

// The distance of the ray behind the surface that the image shows there.
fn ssr_behind(depth: texture_2d<f32>, ray: SsrRay, share: f32) -> f32 {
    let pixel = vec2i(floor(mix(ray.from_pixel, ray.to_pixel, share)));
    return ssr_distance(ray, share) - depth_at(depth, pixel);
}

// Reflections fade at the border of the image, beyond which nothing is known.
fn ssr_known(uv: vec2f) -> f32 {
    let inside = min(uv, 1.0 - uv);
    return smooth_step(0.0, SSR_BORDER, min(inside.x, inside.y));
}

fn ssr_hit(depth: texture_2d<f32>, camera: Camera, place: vec3f, way: vec3f, params: Ssr) -> SsrHit {
    let size = vec2f(textureDimensions(depth));
    let ray = ssr_ray(camera, place, way, size, params.farthest);
    let run = abs(ray.to_pixel - ray.from_pixel) * ray.last;
    let count = clamp(i32(min(ceil(max(run.x, run.y)), 512.0)), 1, params.steps);
    var before = 0.0;
    for (var i = 1; i <= count; i++) {
        let share = ray.last * f32(i) / f32(count);
        let stride = abs(ssr_distance(ray, share) - ssr_distance(ray, before));
        let behind = ssr_behind(depth, ray, share);
        if behind > 0.0 && behind < params.thickness + stride {
            var low = before;
            var high = share;
            for (var k = 0; k < SSR_HALVINGS; k++) {
                let middle = 0.5 * (low + high);
                let is_behind = ssr_behind(depth, ray, middle) > 0.0;
                low = select(middle, low, is_behind);
                high = select(high, middle, is_behind);
            }
            if ssr_behind(depth, ray, high) < params.thickness {
                let uv = mix(ray.from_pixel, ray.to_pixel, high) / size;
                let inverse = mix(ray.from_inverse, ray.to_inverse, high);
                let traveled = high * ray.to_inverse / inverse;
                let near = 1.0 - smooth_step(0.8, 1.0, traveled * ray.length / params.farthest);
                return SsrHit(uv, traveled * ray.length, near * ssr_known(uv));
            }
        }
        before = share;
    }
    // Farther than all rays, such as the sky.
    let sky = camera_uv(camera, place + SURFACE_FARTHEST * way).xy;
    let is_seen = way.z < 0.0 && all(sky >= vec2f(0.0)) && all(sky < vec2f(1.0));
    let there = depth_at(depth, vec2i(floor(clamp(sky, vec2f(0.0), vec2f(1.0)) * size)));
    return SsrHit(sky, SURFACE_FARTHEST, select(0.0, ssr_known(sky), is_seen && there > params.farthest));
}

fn ssr_normal(depth: texture_2d<f32>, normal: texture_2d<f32>, camera: Camera, pixel: vec2i, params: Ssr) -> vec3f {
    let given = texel(normal, pixel).xyz;
    if dot(given, given) > 1e-4 { return surface_given_normal(camera, given, f32(params.world)); }
    return surface_normal(depth, camera, pixel);
}

// The width in texels over which the light that arrives is blurred, as its binary logarithm.
fn ssr_level(camera: Camera, hit: SsrHit, distance: f32, rough: f32, size: vec2f) -> f32 {
    let alpha = min(rough * rough, 0.7);
    // Half of the normals are within alpha, and the light is turned by twice as much.
    let radius = hit.way * 2.0 * alpha / (1.0 - alpha * alpha);
    let texels = abs(camera_uv_apart(camera, vec2f(radius, 0.0), distance).x) * size.x;
    return clamp(log2(max(2.0 * texels, 1.0)), 0.0, 6.0);
}

// The reflected light, and in alpha how much of it is known.
fn ssr_reflected(
    source: texture_2d<f32>,
    source_sampler: sampler,
    l1: texture_2d<f32>,
    l1_sampler: sampler,
    l2: texture_2d<f32>,
    l2_sampler: sampler,
    l3: texture_2d<f32>,
    l3_sampler: sampler,
    l4: texture_2d<f32>,
    l4_sampler: sampler,
    l5: texture_2d<f32>,
    l5_sampler: sampler,
    l6: texture_2d<f32>,
    l6_sampler: sampler,
    depth: texture_2d<f32>,
    normal: texture_2d<f32>,
    surface: texture_2d<f32>,
    camera: Camera,
    at: Point,
    params: Ssr,
) -> vec4f {
    let own = clamp(vec4f(params.reflectance, params.roughness) + texel(surface, at.pixel), vec4f(0.0), vec4f(1.0));
    let rough = own.a;
    let smooth_share = 1.0 - smooth_step(0.6, 0.8, rough);
    if params.amount <= 0.0 || smooth_share <= 0.0 || depth_at(depth, at.pixel) >= SURFACE_FARTHEST { return vec4f(); }
    let place = surface_place(depth, camera, at.pixel);
    let up = ssr_normal(depth, normal, camera, at.pixel, params);
    let toward = surface_toward(camera, place);
    let way = reflect(-toward, up);
    let hit = ssr_hit(depth, camera, place + up * (0.002 * -place.z), way, params);
    let met = vec2i(floor(hit.uv * vec2f(textureDimensions(depth))));
    // The image does not show the backs of things.
    let is_front = dot(ssr_normal(depth, normal, camera, met, params), way) < 0.0;
    let share = select(0.0, hit.share * smooth_share, is_front);
    if share <= 0.0 { return vec4f(); }

    let distance = depth_at(depth, met);
    let level = ssr_level(camera, hit, distance, rough, vec2f(textureDimensions(source)));
    var light = tap(source, source_sampler, hit.uv);
    if level > 0.0 { light = mix(light, tap(l1, l1_sampler, hit.uv), min(level - 0.0, 1.0)); }
    if level > 1.0 { light = mix(light, tap(l2, l2_sampler, hit.uv), min(level - 1.0, 1.0)); }
    if level > 2.0 { light = mix(light, tap(l3, l3_sampler, hit.uv), min(level - 2.0, 1.0)); }
    if level > 3.0 { light = mix(light, tap(l4, l4_sampler, hit.uv), min(level - 3.0, 1.0)); }
    if level > 4.0 { light = mix(light, tap(l5, l5_sampler, hit.uv), min(level - 4.0, 1.0)); }
    if level > 5.0 { light = mix(light, tap(l6, l6_sampler, hit.uv), min(level - 5.0, 1.0)); }

    let grazing = pow(1.0 - clamp(dot(up, toward), 0.0, 1.0), 5.0);
    let reflected = own.rgb + (max(vec3f(1.0 - rough), own.rgb) - own.rgb) * grazing;
    return vec4f(min(light.rgb * reflected * (share * params.amount), vec3f(HALF_MAX)), share);
}

fn ssr(source: vec4f, reflected: vec4f) -> vec4f {
    return vec4f(min(source.rgb + reflected.rgb, vec3f(HALF_MAX)), source.a);
}

fn ssr_reflection(reflected: vec4f) -> vec4f {
    return reflected;
}
