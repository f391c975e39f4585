// Depth of field: each pixel gathers the light whose circle of confusion covers it. A circle spreads its light over its
// area, and light of surfaces behind a pixel's own is limited to the pixel's circle, so that it does not bleed over a
// sharp foreground; light of surfaces before it covers the pixel by the share that the circles cover.
//
// After Jimenez, "Next Generation Post Processing in Call of Duty: Advanced Warfare", SIGGRAPH 2014. The polygon:
// Sousa, "Graphics Gems from CryENGINE 3", SIGGRAPH 2013.
#import grade
#import math

struct DepthOfField {
    focus: f32,
    rings: i32,
    blades: f32,
    rotation: f32,  // radians
    strength: f32,  // the radius of the circle of confusion at an infinite distance, in pixels
    most: f32,      // the largest radius, in pixels
    tile: i32,
}

const DEPTH_OF_FIELD_PI: f32 = 3.14159265;
// Surfaces whose depths differ by less than this share belong together.
const DEPTH_OF_FIELD_SOFT: f32 = 0.05;

// The radius of the circle of confusion in pixels, and the depth. The gather reads whole pixels and softens the edge of
// the circle by one: that adds at least the variance of a pixel to the circle's, which is taken off here.
fn depth_of_field_circle(depth: vec4f, params: DepthOfField) -> vec4f {
    let z = max(depth.x, 1e-3);
    let radius = min(params.strength * abs(z - params.focus) / z, params.most);
    return vec4f(sqrt(max(radius * radius - 1.0 / 6.0, 0.0)), z, 0.0, 1.0);
}

// The largest radius in a row of texels, and in a column of such rows.
fn depth_of_field_rows(circle: texture_2d<f32>, at: Point, params: DepthOfField) -> vec4f {
    var most = 0.0;
    for (var i = 0; i < params.tile; i++) {
        most = max(most, texel(circle, vec2i(at.pixel.x * params.tile + i, at.pixel.y)).x);
    }
    return vec4f(most, 0.0, 0.0, 1.0);
}

fn depth_of_field_tiles(rows: texture_2d<f32>, at: Point, params: DepthOfField) -> vec4f {
    var most = 0.0;
    for (var i = 0; i < params.tile; i++) {
        most = max(most, texel(rows, vec2i(at.pixel.x, at.pixel.y * params.tile + i)).x);
    }
    return vec4f(most, 0.0, 0.0, 1.0);
}

// The largest radius of the nine tiles around: no circle reaches farther than a tile.
fn depth_of_field_around(tiles: texture_2d<f32>, at: Point) -> vec4f {
    var most = 0.0;
    for (var y = -1; y <= 1; y++) {
        for (var x = -1; x <= 1; x++) {
            most = max(most, texel(tiles, at.pixel + vec2i(x, y)).x);
        }
    }
    return vec4f(most, 0.0, 0.0, 1.0);
}

// The distance of the edge of the aperture in a direction: 1 for a circle and at the corners of a polygon.
fn depth_of_field_edge(angle: f32, params: DepthOfField) -> f32 {
    if params.blades < 3.0 { return 1.0; }
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

// Light before and behind a pixel's own surface. The weights are in w.
struct DepthOfFieldLight {
    before: vec4f,
    behind: vec4f,
}

// Adds the light of a place. `distance` is that from the pixel, in pixels of an aperture that is a circle; `area` is
// what the sample stands for.
fn depth_of_field_add(
    light: ptr<function, DepthOfFieldLight>,
    color: vec3f,
    circle: vec2f,
    own: vec2f,
    distance: f32,
    area: f32,
) {
    let is_before = clamp((own.y - circle.y) / (DEPTH_OF_FIELD_SOFT * own.y), 0.0, 1.0);
    let near = clamp(circle.x - distance + 0.5, 0.0, 1.0) / max(DEPTH_OF_FIELD_PI * circle.x * circle.x, 1.0);
    let radius = min(circle.x, own.x);
    let far = clamp(radius - distance + 0.5, 0.0, 1.0) / max(DEPTH_OF_FIELD_PI * radius * radius, 1.0);
    let weights = area * vec2f(is_before * near, (1.0 - is_before) * far);
    (*light).before += weights.x * vec4f(color, 1.0);
    (*light).behind += weights.y * vec4f(color, 1.0);
}

fn depth_of_field(
    source: texture_2d<f32>,
    circle: texture_2d<f32>,
    around: texture_2d<f32>,
    at: Point,
    params: DepthOfField,
) -> vec4f {
    let center = texel(source, at.pixel);
    let reach = texel(around, at.pixel / params.tile).x;
    if reach < 0.5 { return center; }
    let own = texel(circle, at.pixel).xy;
    // Six samples in the first ring, twelve in the second, and so on, nearer to each other in the middle: for surfaces
    // that are less blurred. They are texels, because a filtered one would mix the light of two surfaces.
    var light = DepthOfFieldLight();
    var inside = depth_of_field_ring(0.5, reach, params);
    depth_of_field_add(&light, center.rgb, own, own, 0.0, DEPTH_OF_FIELD_PI * inside * inside);
    for (var ring = 1; ring <= min(params.rings, 16); ring++) {
        let count = 6 * ring;
        let outside = depth_of_field_ring(f32(ring) + 0.5, reach, params);
        let area = DEPTH_OF_FIELD_PI * (outside - inside) * (outside + inside) / f32(count);
        let distance = depth_of_field_ring(f32(ring), reach, params);
        for (var i = 0; i < count; i++) {
            let angle = 2.0 * DEPTH_OF_FIELD_PI * (f32(i) + 0.5 * f32(ring & 1)) / f32(count);
            let offset = distance * depth_of_field_edge(angle, params) * vec2f(cos(angle), sin(angle));
            let place = at.pixel + vec2i(round(offset));
            let color = texel(source, place).rgb;
            depth_of_field_add(&light, color, texel(circle, place).xy, own, distance, area);
        }
        inside = outside;
    }
    let behind = light.behind.rgb / max(light.behind.w, 1e-6);
    let before = light.before.rgb / max(light.before.w, 1e-6);
    let color = between3(behind, before, clamp(light.before.w, 0.0, 1.0));
    return vec4f(bounded_scene(color), center.a);
}
