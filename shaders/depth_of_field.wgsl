// Depth of field: each pixel gathers the light whose circle of confusion covers it. A circle spreads its light over its
// area. Light of surfaces before a pixel's own covers the pixel by the share that the circles cover. Surfaces behind it
// are seen past the own one, in the part of the pixel's circle that they fill: none beside a sharp foreground.
//
// After Jimenez, "Next Generation Post Processing in Call of Duty: Advanced Warfare", SIGGRAPH 2014. The polygon:
// Sousa, "Graphics Gems from CryENGINE 3", SIGGRAPH 2013.
import afterimage::depth::depth_at;
import afterimage::front::{FRONT_SOFT, front_beside, front_is_before};
import afterimage::grade::bounded_scene;
import afterimage::math::between;

struct DepthOfField {
    focus: f32,
    focal_length: f32,
    place: vec2f,
    area: f32,
    rings: i32,
    blades: f32,
    rotation: f32,    // radians
    squeeze: f32,
    strength: f32,    // the radius of the circle of confusion at an infinite distance, in pixels, times 1000 s - F
    max_radius: f32,  // the largest radius, in pixels
    tile: i32,
}

const DEPTH_OF_FIELD_PI: f32 = 3.14159265;

// The radius of the circle of confusion in pixels. The gather reads whole pixels and softens the edge of the circle by
// one: that adds at least the variance of a pixel to the circle's, which is taken off here.
fn depth_of_field_radius(z: f32, focus: f32, params: DepthOfField) -> f32 {
    let strength = params.strength / (1000.0 * focus - params.focal_length);
    let radius = min(strength * abs(z - focus) / z, params.max_radius);
    return sqrt(max(radius * radius - 1.0 / 6.0, 0.0));
}

// The radius and the depth of a pixel. Where edges are smooth, a pixel beside a surface in front of it shows a part of
// that, whatever its own depth says, so it belongs to that surface: blurred with what is behind, the edge of a sharper
// one would have steps, and a pixel in focus would draw a line around a blurred one.
fn depth_of_field_circle_of(depth: texture_2d<f32>, pixel: vec2i, focus: f32, params: DepthOfField) -> vec4f {
    let own = depth_at(depth, pixel);
    let own_radius = depth_of_field_radius(own, focus, params);
    var z = own;
    var radius = own_radius;
    for (var i = 0; i < 4; i++) {
        let other = depth_at(depth, front_beside(pixel, i));
        let found = depth_of_field_radius(other, focus, params);
        let is_sharper = found < radius;
        let is_blurred = found >= 2.0 && other < z;
        if front_is_before(other, own) && select(is_sharper, is_blurred, own_radius < 0.5) {
            z = other;
            radius = found;
        }
    }
    return vec4f(radius, z, 0.0, 1.0);
}

fn depth_of_field_circle(depth: texture_2d<f32>, at: Point, params: DepthOfField) -> vec4f {
    return depth_of_field_circle_of(depth, at.pixel, params.focus, params);
}

fn depth_of_field_circle_found(
    depth: texture_2d<f32>,
    focus: texture_2d<f32>,
    at: Point,
    params: DepthOfField,
) -> vec4f {
    return depth_of_field_circle_of(depth, at.pixel, texel(focus, vec2i()).x, params);
}

// Reads to each side of the place where the focus is found.
const DEPTH_OF_FIELD_SEARCH: i32 = 16;

// The distance of the nearest surface around a place, within the domain of the focus.
fn depth_of_field_focus(depth: texture_2d<f32>, params: DepthOfField) -> vec4f {
    let size = vec2f(textureDimensions(depth));
    var nearest = 10000.0;
    for (var y = -DEPTH_OF_FIELD_SEARCH; y <= DEPTH_OF_FIELD_SEARCH; y++) {
        for (var x = -DEPTH_OF_FIELD_SEARCH; x <= DEPTH_OF_FIELD_SEARCH; x++) {
            let away = vec2f(f32(x), f32(y)) / f32(DEPTH_OF_FIELD_SEARCH);
            if dot(away, away) > 1.0 { continue; }
            let place = vec2i(floor(params.place * size + params.area * size.y * away));
            nearest = min(nearest, depth_at(depth, place));
        }
    }
    return vec4f(max(nearest, 0.5), 0.0, 0.0, 1.0);
}

// Half of the angle between two samples of the rings 1 to 16: its cosine and sine. A direction is the one before it,
// turned, which is cheaper than its own sine; these are numbers, because the error of a device's sine would add up.
const DEPTH_OF_FIELD_TURNS = array<vec2f, 16>(
    vec2f(0.866025404, 0.500000000),
    vec2f(0.965925826, 0.258819045),
    vec2f(0.984807753, 0.173648178),
    vec2f(0.991444861, 0.130526192),
    vec2f(0.994521895, 0.104528463),
    vec2f(0.996194698, 0.087155743),
    vec2f(0.997203797, 0.074730094),
    vec2f(0.997858923, 0.065403129),
    vec2f(0.998308158, 0.058144829),
    vec2f(0.998629535, 0.052335956),
    vec2f(0.998867339, 0.047581916),
    vec2f(0.999048222, 0.043619387),
    vec2f(0.999188998, 0.040265940),
    vec2f(0.999300705, 0.037391194),
    vec2f(0.999390827, 0.034899497),
    vec2f(0.999464587, 0.032719083),
);

// A direction that is turned by the angle of another one.
fn depth_of_field_turned(direction: vec2f, angle: vec2f) -> vec2f {
    return vec2f(direction.x * angle.x - direction.y * angle.y, direction.x * angle.y + direction.y * angle.x);
}

// The distance of the edge of a polygonal aperture in a direction: 1 at its corners.
fn depth_of_field_edge(angle: f32, params: DepthOfField) -> f32 {
    let side = 2.0 * DEPTH_OF_FIELD_PI / params.blades;
    let turned = angle + params.rotation;
    let within = turned - side * floor(turned / side);
    return cos(0.5 * side) / cos(within - 0.5 * side);
}

// The radius of a ring: the outermost one is the reach.
fn depth_of_field_ring(ring: f32, reach: f32, params: DepthOfField) -> f32 {
    let share = ring / f32(params.rings);
    return reach * share * sqrt(share);
}

// Light before and behind a pixel's own surface with its alpha, and their weights.
struct DepthOfFieldLight {
    before: vec4f,
    behind: vec4f,
    weights: vec2f,
}

// The surface that a pixel shows. `density` is the light of a place within its circle, of 1 in all: a circle is never
// smaller than a pixel.
struct DepthOfFieldSurface {
    radius: f32,
    depth: f32,
    density: f32,
}

fn depth_of_field_surface(circle: vec4f) -> DepthOfFieldSurface {
    return DepthOfFieldSurface(circle.x, circle.y, 1.0 / max(DEPTH_OF_FIELD_PI * circle.x * circle.x, 1.0));
}

// Adds the light of a surface. `distance` is that from the pixel, in pixels of an aperture that is a circle; `area` is
// what the sample stands for, and `nearness` 1 over the difference of depths of two surfaces.
fn depth_of_field_add(
    light: ptr<function, DepthOfFieldLight>,
    color: vec4f,
    other: DepthOfFieldSurface,
    own: DepthOfFieldSurface,
    nearness: f32,
    distance: f32,
    area: f32,
) {
    let away = clamp((other.depth - own.depth) * nearness, -1.0, 1.0);
    let is_before = max(-away, 0.0);
    let covers = clamp(vec2f(other.radius, own.radius) - distance + 0.5, vec2f(0.0), vec2f(1.0));
    let density = covers * vec2f(other.density, own.density);
    // The smaller circle of two that belong together, and the own one of what is behind.
    let seen_past = select(max(away, 0.0), 1.0, other.radius > own.radius);
    let far = mix(density.x, density.y, seen_past);
    let weights = area * vec2f(is_before * density.x, (1.0 - is_before) * far);
    (*light).before += weights.x * color;
    (*light).behind += weights.y * color;
    (*light).weights += weights;
}

// `is_polygon` is the same for all pixels: each of the two kernels below has its own.
fn depth_of_field_gathered(
    source: texture_2d<f32>,
    circle: texture_2d<f32>,
    around: texture_2d<f32>,
    at: Point,
    params: DepthOfField,
    is_polygon: bool,
) -> vec4f {
    let center = texel(source, at.pixel);
    let reach = texel(around, at.pixel / params.tile).x;
    if reach < 0.5 { return center; }
    let own = depth_of_field_surface(texel(circle, at.pixel));
    let nearness = 1.0 / (FRONT_SOFT * own.depth);
    // Six samples in the first ring, twelve in the second, and so on, nearer to each other in the middle: for surfaces
    // that are less blurred. They are texels, because a filtered one would mix the light of two surfaces.
    var light = DepthOfFieldLight();
    var inside = depth_of_field_ring(0.5, reach, params);
    depth_of_field_add(&light, center, own, own, nearness, 0.0, DEPTH_OF_FIELD_PI * inside * inside);
    for (var ring = 1; ring <= min(params.rings, 16); ring++) {
        let outside = depth_of_field_ring(f32(ring) + 0.5, reach, params);
        let area = DEPTH_OF_FIELD_PI * (outside - inside) * (outside + inside) / f32(6 * ring);
        let distance = depth_of_field_ring(f32(ring), reach, params);
        let half_turn = DEPTH_OF_FIELD_TURNS[ring - 1];
        let turn = depth_of_field_turned(half_turn, half_turn);
        var direction = select(vec2f(1.0, 0.0), half_turn, (ring & 1) == 1);
        for (var i = 0; i < 6 * ring; i++) {
            var along = distance;
            if is_polygon {
                let turns = (f32(i) + 0.5 * f32(ring & 1)) / f32(6 * ring);
                along *= depth_of_field_edge(2.0 * DEPTH_OF_FIELD_PI * turns, params);
            }
            let place = at.pixel + vec2i(round(along * direction / vec2f(params.squeeze, 1.0)));
            let other = depth_of_field_surface(texel(circle, place));
            depth_of_field_add(&light, texel(source, place), other, own, nearness, distance, area);
            direction = depth_of_field_turned(direction, turn);
        }
        inside = outside;
    }
    let before = light.before / max(light.weights.x, 1e-6);
    let behind = light.behind / max(light.weights.y, 1e-6);
    let color = between(behind, before, clamp(light.weights.x, 0.0, 1.0));
    return vec4f(bounded_scene(color.rgb), clamp(color.a, 0.0, HALF_MAX));
}

// With a round aperture.
fn depth_of_field(
    source: texture_2d<f32>,
    circle: texture_2d<f32>,
    around: texture_2d<f32>,
    at: Point,
    params: DepthOfField,
) -> vec4f {
    return depth_of_field_gathered(source, circle, around, at, params, false);
}

// With a polygon.
fn depth_of_field_polygon(
    source: texture_2d<f32>,
    circle: texture_2d<f32>,
    around: texture_2d<f32>,
    at: Point,
    params: DepthOfField,
) -> vec4f {
    return depth_of_field_gathered(source, circle, around, at, params, true);
}
