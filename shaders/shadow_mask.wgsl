// Shadows from the depth map of a light: the share of texels around a place that lie before it, seen from the light.
// Williams, "Casting Curved Shadows on Curved Surfaces", 1978; Reeves, Salesin and Cook, "Rendering Antialiased Shadows
// with Depth Maps", 1987. Distances along the light's axis are compared, so any projection and any direction of depth
// will do, and biases are lengths. Penumbrae of lights of some size: Fernando, "Percentage-Closer Soft Shadows", 2005.
import afterimage::camera::{Camera, camera_distance, camera_place, camera_uv, camera_uv_apart, camera_world};
import afterimage::depth::depth_distance;
import afterimage::grade::{bounded, bounded_scene};
import afterimage::surface::{SURFACE_FARTHEST, surface_toward, surface_turn, surface_unit};

struct ShadowMask {
    amount: f32,
    bias: f32,
    slope_bias: f32,
    normal_bias: f32,
    kernel: i32,
    taps: i32,
    is_disc: f32,      // 1 for taps on a disc, 0 for a square
    light_diameter: f32,
    tangent: f32,      // of half of the angular diameter of a light with parallel rays
    largest: f32,
    blocker_taps: i32,
}

// Surfaces that the light grazes at a smaller cosine have the bias of this one.
const SHADOW_GRAZING: f32 = 0.05;

// A place as the light sees it.
struct ShadowPlace {
    texel: vec2f,      // in the depth map, where centers have whole numbers
    distance: f32,     // along the light's axis, less the bias
    width: f32,        // what a texel covers at this distance, in meters
}

// A disc around a place. Taps are compared with distances that fall from that of the place, in the middle, by `rise`
// meters at the rim.
struct ShadowDisc {
    radius: f32,       // in texels
    rise: f32,
    turn: f32,         // in turns
}

// The distance along the light's axis of what the depth map shows at a texel.
fn shadow_distance(map: texture_2d<f32>, light: Camera, p: vec2i) -> f32 {
    let uv = (vec2f(p) + 0.5) / vec2f(textureDimensions(map));
    return camera_distance(light, uv, texel(map, p).x);
}

fn shadow_is_inside(map: texture_2d<f32>, p: vec2i) -> bool {
    return all(p >= vec2i(0)) && all(p < vec2i(textureDimensions(map)));
}

// 1 if a texel lies before the place. Beyond the map nothing does.
fn shadow_before(map: texture_2d<f32>, light: Camera, p: vec2i, distance: f32) -> f32 {
    return select(0.0, 1.0, shadow_is_inside(map, p) && shadow_distance(map, light, p) < distance);
}

// The share of the texels around a place, filtered linearly: a square of `kernel` taps to each side.
fn shadow_square(map: texture_2d<f32>, light: Camera, place: ShadowPlace, kernel: i32) -> f32 {
    let taps = clamp(kernel, 1, 7);
    let corner = place.texel - 0.5 * f32(taps - 1);
    let base = floor(corner);
    let part = corner - base;
    var sum = 0.0;
    for (var j = 0; j <= taps; j++) {
        for (var i = 0; i <= taps; i++) {
            let first = select(vec2f(1.0), 1.0 - part, vec2i(i, j) == vec2i(0));
            let share = select(first, part, vec2i(i, j) == vec2i(taps));
            sum += share.x * share.y * shadow_before(map, light, vec2i(base) + vec2i(i, j), place.distance);
        }
    }
    return sum / f32(taps * taps);
}

// The direction of a tap of a spiral: Vogel, "A Better Way to Construct the Sunflower Head", 1979.
fn shadow_direction(turn: f32, i: i32) -> vec2f {
    let angle = 6.2831853 * turn + 2.3999632 * f32(i);
    return vec2f(cos(angle), sin(angle));
}

// The same for taps on a disc, in a spiral of equal areas, which is turned differently in each pixel of four by four.
fn shadow_disc(map: texture_2d<f32>, light: Camera, place: ShadowPlace, disc: ShadowDisc, params: ShadowMask) -> f32 {
    let count = clamp(params.taps, 1, 64);
    var sum = 0.0;
    for (var i = 0; i < count; i++) {
        let share = sqrt((f32(i) + 0.5) / f32(count));
        let at = place.texel + disc.radius * share * shadow_direction(disc.turn, i);
        sum += shadow_square(map, light, ShadowPlace(at, place.distance - disc.rise * share, place.width), 1);
    }
    return sum / f32(count);
}

// True if the light has a size.
fn shadow_is_soft(light: Camera, params: ShadowMask) -> bool {
    return select(params.tangent, params.light_diameter, light.projection[2].w != 0.0) > 0.0;
}

// Half of the penumbra's width in texels, of an edge that is `gap` meters nearer to the light than the place. It is the
// distance in the map, too, up to which what is that much nearer lies before a part of the light.
fn shadow_penumbra(light: Camera, place: ShadowPlace, gap: f32, params: ShadowMask) -> f32 {
    let lamp = 0.5 * params.light_diameter * gap / max(place.distance - gap, 1e-3);
    return select(params.tangent * gap, lamp, light.projection[2].w != 0.0) / place.width;
}

// The distance along the light's axis of the near plane, which may be at either end of the depths.
fn shadow_nearest(light: Camera) -> f32 {
    return min(camera_distance(light, vec2f(0.5), 0.0), camera_distance(light, vec2f(0.5), 1.0));
}

// The mean distance of blockers before the place, toward the light: 0 without one. Only what lies before part
// of the light counts, so a plane never blocks itself, or what the least disc of the filter reaches. Taps are nearer to
// each other in the middle, where all blockers are that are near to the place.
fn shadow_gap(map: texture_2d<f32>, light: Camera, place: ShadowPlace, disc: ShadowDisc, params: ShadowMask) -> f32 {
    let count = clamp(params.blocker_taps, 1, 64);
    let least = 0.5 * f32(params.kernel) + 0.5;
    var sum = 0.0;
    var found = 0.0;
    for (var i = 0; i < count; i++) {
        let way = disc.radius * f32(i) / f32(count);
        let p = vec2i(floor(place.texel + way * shadow_direction(disc.turn, i) + 0.5));
        let gap = min(place.distance - shadow_distance(map, light, p), HALF_MAX);
        let reach = max(shadow_penumbra(light, place, gap, params), least);
        if gap > 0.0 && shadow_is_inside(map, p) && length(vec2f(p) - place.texel) <= reach {
            sum += gap;
            found += 1.0;
        }
    }
    return sum / max(found, 1.0);
}

// The share for a light of some size: a disc as wide as the penumbra of the mean blocker, at least that of `kernel`.
// Its taps are compared with a cone toward the light, half as steep as that of the light's rays, which no surface
// reaches by its slope alone.
fn shadow_soft(map: texture_2d<f32>, light: Camera, place: ShadowPlace, turn: f32, params: ShadowMask) -> f32 {
    let least = 0.5 * f32(params.kernel);
    let widest = max(0.5 * params.largest * f32(textureDimensions(map).x), least);
    let reach = shadow_penumbra(light, place, max(place.distance - shadow_nearest(light), 0.0), params);
    let gap = shadow_gap(map, light, place, ShadowDisc(clamp(reach, least, widest), 0.0, turn), params);
    if gap <= 0.0 { return 0.0; }
    let radius = clamp(shadow_penumbra(light, place, gap, params), least, widest);
    return shadow_disc(map, light, place, ShadowDisc(radius, 0.5 * gap, turn), params);
}

// The place in the world of what a pixel shows, and its distance. Apart from what reads the light: a module with the
// blocks of both cameras has four uniform buffers, with which Mesa 22 crashes.
fn shadow_mask_place(depth: vec4f, camera: Camera, at: Point) -> vec4f {
    let distance = depth_distance(depth.x);
    return vec4f(camera_world(camera, camera_place(camera, at.uv, distance)), distance);
}

// A normal in the world, of one in the camera's space.
fn shadow_mask_turned(normal: vec4f, camera: Camera) -> vec4f {
    return vec4f(bounded((camera.inverse_view * vec4f(normal.xyz, 0.0)).xyz), 0.0);
}

// The way in the world to the next pixel on the surface: to the side where the distance bends less.
fn shadow_tangent(places: texture_2d<f32>, p: vec2i, step: vec2i) -> vec3f {
    let middle = texel(places, p);
    let after = texel(places, p + step) - middle;
    let before = middle - texel(places, p - step);
    let has_after = all(p + step < vec2i(textureDimensions(places)));
    let has_before = all(p >= step);
    return select(before, after, has_after && (!has_before || abs(after.w) < abs(before.w))).xyz;
}

// The share of the light that is blocked at a place with this normal, both in the world.
fn shadow_share(
    map: texture_2d<f32>,
    light: Camera,
    world: vec3f,
    normal: vec3f,
    at: Point,
    params: ShadowMask,
) -> f32 {
    let place = (light.view * vec4f(world, 1.0)).xyz;
    let n = (light.view * vec4f(normal, 0.0)).xyz;
    let toward = surface_toward(light, place);
    let facing = dot(n, toward);
    if facing <= 0.0 { return 1.0; }
    let size = vec2f(textureDimensions(map));
    // The size of a texel at this distance.
    let width = 1.0 / max(length(camera_uv_apart(light, vec2f(1.0, 0.0), -place.z) * size), 1e-6);
    let aside = sqrt(max(1.0 - facing * facing, 0.0));
    let moved = place + n * (params.normal_bias * width * aside);
    if -moved.z <= 0.0 { return 0.0; }
    let uv = camera_uv(light, moved);
    if any(uv.xy < vec2f(0.0)) || any(uv.xy > vec2f(1.0)) { return 0.0; }
    // The depth of the plane of the surface at the farthest texel that is compared, toward the light.
    let is_soft = shadow_is_soft(light, params);
    let reach = (0.5 * f32(params.kernel) + select(0.5, 1.0, is_soft || params.is_disc > 0.5)) * width;
    let slope = (abs(n.x) + abs(n.y)) * max(toward.z, 0.0) / max(facing, SHADOW_GRAZING);
    let bias = params.bias + params.slope_bias * reach * slope;
    let found = ShadowPlace(uv.xy * size - 0.5, -moved.z - bias, width);
    let turn = surface_turn(at.pixel);
    if is_soft { return shadow_soft(map, light, found, turn, params); }
    let disc = ShadowDisc(0.5 * f32(params.kernel), 0.0, turn);
    if params.is_disc > 0.5 { return shadow_disc(map, light, found, disc, params); }
    return shadow_square(map, light, found, params.kernel);
}

fn shadow_of(
    places: texture_2d<f32>,
    map: texture_2d<f32>,
    light: Camera,
    normal: vec3f,
    at: Point,
    params: ShadowMask,
) -> vec4f {
    let place = texel(places, at.pixel);
    if place.w >= SURFACE_FARTHEST { return vec4f(0.0, 0.0, 0.0, 1.0); }
    return vec4f(shadow_share(map, light, place.xyz, surface_unit(normal), at, params), 0.0, 0.0, 1.0);
}

fn shadow_mask(places: texture_2d<f32>, map: texture_2d<f32>, light: Camera, at: Point, params: ShadowMask) -> vec4f {
    let right = shadow_tangent(places, at.pixel, vec2i(1, 0));
    let down = shadow_tangent(places, at.pixel, vec2i(0, 1));
    return shadow_of(places, map, light, cross(down, right), at, params);
}

fn shadow_mask_normals(
    places: texture_2d<f32>,
    turned: vec4f,
    map: texture_2d<f32>,
    light: Camera,
    at: Point,
    params: ShadowMask,
) -> vec4f {
    return shadow_of(places, map, light, turned.xyz, at, params);
}

fn shadow_mask_lit(source: vec4f, share: vec4f, params: ShadowMask) -> vec4f {
    return vec4f(bounded_scene(source.rgb * (1.0 - params.amount * share.x)), source.a);
}

fn shadow_mask_shadow(share: vec4f, params: ShadowMask) -> vec4f {
    return vec4f(params.amount * share.x, 0.0, 0.0, 0.0);
}
