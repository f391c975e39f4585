// A loft at golden hour, ray traced from solids that have closed forms: a dim room, a bright window, a low sun, neon.
//
// Metres; x to the right, y up, z towards the viewer; the window is in the wall at z = -4. Light is linear Rec.709 radiance
// in the units of the picture, where the room's greys lie at 0.02 to 0.3. Every level is stated for a range of 18 stops.
#import noise
#import ray

struct DemoScene {
    time: f32,   // seconds; moves the neon's hum and the dust
    range: f32,  // stops from the room's grey to the sun's disc; 0 flattens the light, 18 is the reference
    walk: f32,   // 0 deep in the room, 1 in front of the window
}

struct DemoSceneHit {
    distance: f32,
    normal: vec3f,
    what: u32,
}

struct DemoSceneSurface {
    albedo: vec3f,
    normal: vec3f,
    mirror: vec3f,     // reflectance at normal incidence
    roughness: f32,
    emission: vec3f,
    glow: f32,         // emissive strength, the picture's alpha
}

// How bright each kind of light is, relative to the levels of the reference range.
struct DemoSceneGains {
    sky: f32,
    sunlight: f32,
    sun: f32,
    neon: vec3f,       // cyan ring, magenta ring, amber bar
}

struct DemoSceneCamera {
    eye: vec3f,
    right: vec3f,
    up: vec3f,
    back: vec3f,
}

const DEMO_SCENE_OUTSIDE: u32 = 0u;
const DEMO_SCENE_FLOOR: u32 = 1u;
const DEMO_SCENE_CEILING: u32 = 2u;
const DEMO_SCENE_PLASTER: u32 = 3u;
const DEMO_SCENE_BRICK: u32 = 4u;
const DEMO_SCENE_REVEAL: u32 = 5u;
const DEMO_SCENE_FRAME: u32 = 6u;
const DEMO_SCENE_BLIND: u32 = 7u;
const DEMO_SCENE_WALNUT: u32 = 8u;
const DEMO_SCENE_BOOKS: u32 = 9u;
const DEMO_SCENE_RADIATOR: u32 = 10u;
const DEMO_SCENE_CHROME: u32 = 11u;
const DEMO_SCENE_BRASS: u32 = 12u;
const DEMO_SCENE_CERAMIC: u32 = 13u;
const DEMO_SCENE_CLOTH: u32 = 14u;
const DEMO_SCENE_PAPER: u32 = 15u;
const DEMO_SCENE_NEON: u32 = 16u;

const DEMO_SCENE_SKY_DEPTH: f32 = 1000.0;
const DEMO_SCENE_BRIGHTEST: f32 = 60000.0;  // below the largest half float with room for a filter's overshoot
const DEMO_SCENE_REFERENCE: f32 = 18.0;
const DEMO_SCENE_TAN_FOV: f32 = 0.4245;     // of half the vertical field of view, 46 degrees
const DEMO_SCENE_ROOM_LOW = vec3f(-4.0, 0.0, -4.0);
const DEMO_SCENE_ROOM_HIGH = vec3f(4.0, 4.2, 5.6);

const DEMO_SCENE_WINDOW_LOW = vec2f(-2.6, 0.5);
const DEMO_SCENE_WINDOW_SIZE = vec2f(4.4, 3.4);
const DEMO_SCENE_PANE = vec2f(1.1, 1.1333333);
const DEMO_SCENE_BAR: f32 = 0.03;           // half the width of a glazing bar
const DEMO_SCENE_BLIND_LOW = vec2f(0.7, 2.45);
const DEMO_SCENE_SLAT: f32 = 0.05;          // from one slat of the blind to the next

// Fifteen degrees high, twenty-four to the left of the window's axis.
const DEMO_SCENE_SUN = vec3f(-0.392877, 0.258819, -0.882417);
const DEMO_SCENE_SUN_RADIUS: f32 = 0.00465; // half of 0.533 degrees
const DEMO_SCENE_SUNLIGHT = vec3f(250.0, 172.0, 96.0);   // irradiance across the beam
// The disc is as bright as the range says; that of the true sun is a thousand times what a half float holds.
const DEMO_SCENE_SUN_DISC = vec3f(19000.0, 15900.0, 12200.0);

const DEMO_SCENE_RING = vec2f(2.66, 2.5);   // centre of the cyan ring; the magenta one is its afterimage
const DEMO_SCENE_RING_STEP = vec2f(0.4, -0.08);
const DEMO_SCENE_RING_RADIUS: f32 = 0.4;
const DEMO_SCENE_BAR_LOW = vec2f(2.3, 1.72);
const DEMO_SCENE_BAR_LENGTH: f32 = 1.2;
const DEMO_SCENE_NEON_Z: f32 = -3.93;
const DEMO_SCENE_TUBE: f32 = 0.016;
const DEMO_SCENE_CYAN = vec3f(0.9, 9.0, 11.0);
const DEMO_SCENE_MAGENTA = vec3f(12.0, 1.1, 6.5);
const DEMO_SCENE_AMBER = vec3f(12.0, 4.6, 0.7);

// --- Camera ---

fn demo_scene_camera(walk: f32) -> DemoSceneCamera {
    let w = smoothstep(0.0, 1.0, walk);
    let eye = mix(vec3f(1.75, 1.55, 4.7), vec3f(-0.45, 1.62, -2.3), w);
    let aim = mix(vec3f(0.15, 1.72, -4.0), vec3f(-1.6, 2.0, -8.0), w);
    let back = normalize(eye - aim);
    let right = normalize(cross(vec3f(0.0, 1.0, 0.0), back));
    return DemoSceneCamera(eye, right, cross(back, right), back);
}

// The ray through a pixel, `offset` pixels from its centre.
fn demo_scene_ray(camera: DemoSceneCamera, at: Point, offset: vec2f) -> Ray {
    let centre = vec2f(at.pixel) + 0.5 + offset - 0.5 * at.size;
    let xy = centre * vec2f(2.0, -2.0) * DEMO_SCENE_TAN_FOV / at.size.y;
    return Ray(camera.eye, ray_direction(camera.right * xy.x + camera.up * xy.y - camera.back));
}

// --- Solids ---

fn demo_scene_box(hit: ptr<function, DemoSceneHit>, ray: Ray, low: vec3f, high: vec3f, what: u32) {
    let t = ray_box(ray, low, high);
    if t.x < t.y && t.x > 1e-4 && t.x < (*hit).distance {
        // The side that was entered last: where the surface stands furthest out of the middle.
        let p = ray.origin + ray.direction * t.x;
        let out = (p - 0.5 * (low + high)) / (high - low);
        let most = max(max(abs(out.x), abs(out.y)), abs(out.z));
        *hit = DemoSceneHit(t.x, sign(out) * step(vec3f(most), abs(out)), what);
    }
}

fn demo_scene_ball(hit: ptr<function, DemoSceneHit>, ray: Ray, centre: vec3f, radii: vec3f, what: u32) {
    let t = ray_ellipsoid(ray, centre, radii);
    if t > 1e-4 && t < (*hit).distance {
        let p = ray.origin + ray.direction * t;
        *hit = DemoSceneHit(t, normalize((p - centre) / (radii * radii)), what);
    }
}

fn demo_scene_tube(hit: ptr<function, DemoSceneHit>, ray: Ray, foot: vec3f, radius: f32, height: f32, what: u32) {
    let t = ray_tube(ray, foot, radius, height);
    if t > 1e-4 && t < (*hit).distance {
        let p = ray.origin + ray.direction * t - foot;
        *hit = DemoSceneHit(t, vec3f(p.x, 0.0, p.z) / radius, what);
    }
}

// Everything that stands in the room. Also what the sun's rays meet, so the glowing tubes are elsewhere.
fn demo_scene_furniture(ray: Ray, nearest: DemoSceneHit) -> DemoSceneHit {
    var hit = nearest;
    // Table, and what is on it.
    demo_scene_box(&hit, ray, vec3f(-2.0, 0.72, -1.15), vec3f(-0.2, 0.77, -0.15), DEMO_SCENE_WALNUT);
    demo_scene_box(&hit, ray, vec3f(-1.88, 0.0, -1.05), vec3f(-1.83, 0.72, -0.25), DEMO_SCENE_WALNUT);
    demo_scene_box(&hit, ray, vec3f(-0.37, 0.0, -1.05), vec3f(-0.32, 0.72, -0.25), DEMO_SCENE_WALNUT);
    demo_scene_box(&hit, ray, vec3f(-1.3, 0.77, -0.5), vec3f(-0.98, 0.79, -0.25), DEMO_SCENE_PAPER);
    demo_scene_ball(&hit, ray, vec3f(-0.6, 0.95, -0.7), vec3f(0.18), DEMO_SCENE_CHROME);
    demo_scene_ball(&hit, ray, vec3f(-0.78, 0.86, -0.34), vec3f(0.09), DEMO_SCENE_BRASS);
    demo_scene_ball(&hit, ray, vec3f(-1.52, 0.95, -0.7), vec3f(0.15, 0.18, 0.15), DEMO_SCENE_CERAMIC);
    demo_scene_tube(&hit, ray, vec3f(-1.52, 1.08, -0.7), 0.05, 0.2, DEMO_SCENE_CERAMIC);
    // The lantern and its cord.
    demo_scene_ball(&hit, ray, vec3f(-1.0, 2.2, -0.7), vec3f(0.34, 0.27, 0.34), DEMO_SCENE_PAPER);
    demo_scene_tube(&hit, ray, vec3f(-1.0, 2.45, -0.7), 0.008, 1.75, DEMO_SCENE_FRAME);
    // Pouf, sideboard, shelf, radiator, beams.
    demo_scene_ball(&hit, ray, vec3f(1.55, 0.25, -0.9), vec3f(0.46, 0.27, 0.46), DEMO_SCENE_CLOTH);
    demo_scene_box(&hit, ray, vec3f(2.1, 0.14, -4.0), vec3f(3.8, 0.66, -3.55), DEMO_SCENE_WALNUT);
    demo_scene_ball(&hit, ray, vec3f(2.5, 0.83, -3.75), vec3f(0.12, 0.18, 0.12), DEMO_SCENE_CERAMIC);
    demo_scene_ball(&hit, ray, vec3f(3.3, 0.79, -3.75), vec3f(0.14), DEMO_SCENE_BRASS);
    demo_scene_box(&hit, ray, vec3f(-4.0, 0.0, -3.3), vec3f(-3.62, 2.56, -0.7), DEMO_SCENE_BOOKS);
    demo_scene_box(&hit, ray, vec3f(-2.2, 0.08, -4.0), vec3f(1.4, 0.42, -3.88), DEMO_SCENE_RADIATOR);
    demo_scene_box(&hit, ray, vec3f(-2.75, 3.98, -4.0), vec3f(-2.55, 4.2, 5.6), DEMO_SCENE_WALNUT);
    demo_scene_box(&hit, ray, vec3f(-0.5, 3.98, -4.0), vec3f(-0.3, 4.2, 5.6), DEMO_SCENE_WALNUT);
    demo_scene_box(&hit, ray, vec3f(1.75, 3.98, -4.0), vec3f(1.95, 4.2, 5.6), DEMO_SCENE_WALNUT);
    return hit;
}

// Nearest point of each tube of the sign to a point on its plane: xy and the distance.
fn demo_scene_on_ring(p: vec2f, centre: vec2f) -> vec3f {
    let v = p - centre;
    let far = max(length(v), 1e-4);
    return vec3f(centre + v * (DEMO_SCENE_RING_RADIUS / far), abs(far - DEMO_SCENE_RING_RADIUS));
}

fn demo_scene_on_bar(p: vec2f) -> vec3f {
    let x = clamp(p.x - DEMO_SCENE_BAR_LOW.x, 0.0, DEMO_SCENE_BAR_LENGTH);
    let near = DEMO_SCENE_BAR_LOW + vec2f(x, 0.0);
    return vec3f(near, length(p - near));
}

// Cyan, magenta, amber: how far `p` is from each tube.
fn demo_scene_sign(p: vec2f) -> vec3f {
    let cyan = demo_scene_on_ring(p, DEMO_SCENE_RING).z;
    let magenta = demo_scene_on_ring(p, DEMO_SCENE_RING + DEMO_SCENE_RING_STEP).z;
    return vec3f(cyan, magenta, demo_scene_on_bar(p).z);
}

fn demo_scene_neon(hit: ptr<function, DemoSceneHit>, ray: Ray) {
    let t = (DEMO_SCENE_NEON_Z - ray.origin.z) / ray.direction.z;
    let far = demo_scene_sign((ray.origin + ray.direction * t).xy);
    let near = min(min(far.x, far.y), far.z);
    if near < DEMO_SCENE_TUBE && t > 1e-4 && t < (*hit).distance {
        *hit = DemoSceneHit(t, vec3f(0.0, 0.0, 1.0), DEMO_SCENE_NEON);
    }
}

// --- The room and its window ---

// How far a point of the window is from the nearest bar's middle, on each axis.
fn demo_scene_from_bar(p: vec2f) -> vec2f {
    let u = p - DEMO_SCENE_WINDOW_LOW;
    let count = DEMO_SCENE_WINDOW_SIZE / DEMO_SCENE_PANE;
    return abs(u - DEMO_SCENE_PANE * round(clamp(u / DEMO_SCENE_PANE, vec2f(0.0), round(count))));
}

fn demo_scene_in_blind(p: vec2f) -> bool {
    return all(p > DEMO_SCENE_BLIND_LOW) && fract(p.y / DEMO_SCENE_SLAT) < 0.7;
}

// Goes on from the wall's opening at `z` = -4 through the recess: its sides, the blind, the bars, the air beyond.
fn demo_scene_opening(ray: Ray) -> DemoSceneHit {
    let t = (vec4f(-4.08, -4.16, -4.24, -4.3) - ray.origin.z) / ray.direction.z;
    let low = DEMO_SCENE_WINDOW_LOW;
    let edge = select(low, low + DEMO_SCENE_WINDOW_SIZE, ray.direction.xy > vec2f(0.0));
    let aside = (edge - ray.origin.xy) / ray.direction.xy;
    let side = min(aside.x, aside.y);
    let facing = -sign(ray.direction.xy);
    let blind = ray.origin.xy + ray.direction.xy * t.x;
    if t.x < side && demo_scene_in_blind(blind) {
        return DemoSceneHit(t.x, vec3f(0.0, 0.0, 1.0), DEMO_SCENE_BLIND);
    }
    let front = ray.origin.xy + ray.direction.xy * t.y;
    if t.y < side && any(demo_scene_from_bar(front) < vec2f(DEMO_SCENE_BAR)) {
        return DemoSceneHit(t.y, vec3f(0.0, 0.0, 1.0), DEMO_SCENE_FRAME);
    }
    let behind = demo_scene_from_bar(ray.origin.xy + ray.direction.xy * t.z) < vec2f(DEMO_SCENE_BAR);
    if t.z < side && any(behind) {
        let normal = select(vec3f(0.0, facing.y, 0.0), vec3f(facing.x, 0.0, 0.0), behind.x);
        return DemoSceneHit(mix(t.y, t.z, 0.5), normal, DEMO_SCENE_FRAME);
    }
    if side < t.w {
        let normal = select(vec3f(0.0, facing.y, 0.0), vec3f(facing.x, 0.0, 0.0), aside.x < aside.y);
        return DemoSceneHit(side, normal, DEMO_SCENE_REVEAL);
    }
    return DemoSceneHit(RAY_MISS, -ray.direction, DEMO_SCENE_OUTSIDE);
}

// The room's shell from inside.
fn demo_scene_shell(ray: Ray) -> DemoSceneHit {
    let edge = select(DEMO_SCENE_ROOM_LOW, DEMO_SCENE_ROOM_HIGH, ray.direction > vec3f(0.0));
    let t = (edge - ray.origin) / ray.direction;
    let facing = -sign(ray.direction);
    if t.y < min(t.x, t.z) {
        let what = select(DEMO_SCENE_CEILING, DEMO_SCENE_FLOOR, facing.y > 0.0);
        return DemoSceneHit(t.y, vec3f(0.0, facing.y, 0.0), what);
    }
    if t.x < t.z {
        return DemoSceneHit(t.x, vec3f(facing.x, 0.0, 0.0), select(DEMO_SCENE_BRICK, DEMO_SCENE_PLASTER, facing.x > 0.0));
    }
    let p = ray.origin.xy + ray.direction.xy * t.z - DEMO_SCENE_WINDOW_LOW;
    if facing.z > 0.0 && all(p > vec2f(0.0)) && all(p < DEMO_SCENE_WINDOW_SIZE) {
        return demo_scene_opening(ray);
    }
    return DemoSceneHit(t.z, vec3f(0.0, 0.0, facing.z), DEMO_SCENE_BRICK);
}

fn demo_scene_trace(ray: Ray) -> DemoSceneHit {
    var hit = demo_scene_furniture(ray, demo_scene_shell(ray));
    demo_scene_neon(&hit, ray);
    return hit;
}

// --- Outside ---

fn demo_scene_sky(direction: vec3f) -> vec3f {
    let height = max(direction.y, 0.0);
    let base = mix(vec3f(7.2, 5.2, 3.7), vec3f(1.6, 2.9, 5.2), 1.0 - exp(-3.6 * height));
    let away = acos(clamp(dot(direction, DEMO_SCENE_SUN), -1.0, 1.0));
    return base + vec3f(7.0, 4.6, 2.2) * exp(-5.0 * away) + vec3f(60.0, 46.0, 30.0) * exp(-60.0 * away);
}

// The disc, a little darker at its limb.
fn demo_scene_sun(direction: vec3f) -> vec3f {
    let away = length(direction - DEMO_SCENE_SUN) / DEMO_SCENE_SUN_RADIUS;
    return DEMO_SCENE_SUN_DISC * (0.6 + 0.4 * sqrt(max(1.0 - away * away, 0.0))) * step(away, 1.0);
}

// One row of houses: coverage in w. `at` is the tangent of the angle across and up.
fn demo_scene_street(at: vec2f, row: i32, haze: vec3f) -> vec4f {
    let nearness = f32(row) / 4.0;
    let width = 0.022 * exp2(1.1 * f32(row));
    let cell = floor(at.x / width + 0.37 * f32(row));
    let inside = at.x / width + 0.37 * f32(row) - cell;
    let chance = hash_cell(vec2i(i32(clamp(cell, -1e6, 1e6)), row));
    let top = 0.012 - 0.05 * f32(row) + width * (0.3 + 2.3 * chance * chance);
    let storey = vec2f(inside * 7.0, (top - at.y) / width * 8.0);
    let pane = vec2i(clamp(storey, vec2f(-1e6), vec2f(1e6)));
    let lit = hash_cell(pane + vec2i(i32(clamp(cell, -1e6, 1e6)) * 13, row * 71));
    let opening = step(0.3, fract(storey.x)) * step(0.35, fract(storey.y)) * step(0.5, storey.y);
    let wall = mix(vec3f(0.5, 0.42, 0.4), vec3f(0.16, 0.17, 0.2), chance) * (0.7 + 0.6 * step(0.5, inside) * chance);
    let glass = mix(wall * 0.55, vec3f(2.4, 1.7, 0.9), step(0.86, lit) * 0.8);
    return vec4f(mix(haze, mix(wall, glass, opening), 0.22 + 0.6 * nearness), step(at.y, top));
}

fn demo_scene_view(direction: vec3f, gains: DemoSceneGains) -> vec3f {
    let at = direction.xy / max(-direction.z, 1e-3);
    var colour = demo_scene_sky(direction) * gains.sky;
    let haze = demo_scene_sky(vec3f(direction.x, 0.02, direction.z)) * 0.42;
    let ridge = 0.05 + 0.025 * sin(at.x * 2.3 + 0.6) + 0.012 * sin(at.x * 6.1) + 0.004 * sin(at.x * 17.0);
    let near = ridge - 0.02 - 0.016 * sin(at.x * 3.7 + 2.0);
    if at.y < ridge { colour = haze * vec3f(0.92, 1.0, 1.12) * gains.sky; }
    if at.y < near { colour = haze * vec3f(0.66, 0.78, 0.92) * gains.sky; }
    for (var row = 0; row < 5; row++) {
        let street = demo_scene_street(at, row, haze * vec3f(0.75, 0.75, 0.8));
        colour = mix(colour, street.rgb * gains.sky, street.w);
    }
    return colour + demo_scene_sun(direction) * gains.sun * step(ridge, at.y);
}

// --- Surfaces ---

// Share of a pixel that a line covers: `d` from its middle, `half_width`, and the pixel's own width.
fn demo_scene_line(d: f32, half_width: f32, pixel: f32) -> f32 {
    let blur = max(pixel, 1e-4);
    return clamp((half_width - d) / blur + 0.5, 0.0, 1.0) * min(1.0, 2.0 * half_width / blur);
}

// Ink of a printed page: words of three-by-five letters, `line` high from one line to the next.
fn demo_scene_print(p: vec2f, line: f32) -> f32 {
    let row = floor(p.y / line);
    let place = vec2f(p.x / (0.5 * line), p.y / line - row);
    let letter = vec2i(vec2f(floor(place.x), row));
    let dot_at = vec2i(vec2f(fract(place.x) * 4.0, place.y * 8.0));
    let bit = hash_cell(letter * 16 + dot_at) > 0.42 && dot_at.x < 3 && dot_at.y < 5;
    return select(0.0, 1.0, bit && hash_cell(letter + 977) > 0.17);
}

fn demo_scene_wood(p: vec2f, dark: vec3f, light: vec3f, seed: f32) -> vec3f {
    let grain = noise(vec2f(p.x * 46.0 + seed * 91.0, p.y * 2.2)) * 0.6 + noise(vec2f(p.x * 170.0, p.y * 7.0 + seed * 31.0)) * 0.4;
    return mix(dark, light, clamp(grain * 0.75 + seed * 0.5 - 0.12, 0.0, 1.0));
}

fn demo_scene_floor(p: vec3f, pixel: f32) -> DemoSceneSurface {
    let across = p.x / 0.17;
    let lane = floor(across);
    let along = p.z / 1.9 + hash_cell(vec2i(i32(lane), 3));
    let board = floor(along);
    let seed = hash_cell(vec2i(vec2f(lane, board)));
    let seam = min(0.5 - abs(across - lane - 0.5), (0.5 - abs(along - board - 0.5)) * 11.0) * 0.17;
    let wood = demo_scene_wood(p.xz, vec3f(0.085, 0.042, 0.022), vec3f(0.27, 0.155, 0.082), seed);
    let gap = demo_scene_line(seam, 0.003, pixel);
    let tilt = (vec2f(seed, fract(seed * 57.0)) - 0.5) * 0.012 + (noise(p.xz * vec2f(31.0, 5.0)) - 0.5) * 0.012;
    let polished = DemoSceneSurface(wood * (1.0 - 0.8 * gap), normalize(vec3f(tilt.x, 1.0, tilt.y)), vec3f(0.045), 0.24, vec3f(0.0), 0.0);
    // The rug: checks in a plain border, woven.
    let q = p.xz - vec2f(-2.75, -1.85);
    let size = vec2f(2.9, 2.5);
    let inset = min(min(q.x, size.x - q.x), min(q.y, size.y - q.y));
    let square = floor((q - 0.2) / 0.25);
    let odd = fract((square.x + square.y) * 0.5) > 0.25;
    var dye = select(vec3f(0.05, 0.075, 0.14), vec3f(0.46, 0.41, 0.33), odd);
    dye = select(dye, vec3f(0.3, 0.07, 0.045), inset < 0.2);
    dye = select(dye, vec3f(0.46, 0.41, 0.33), inset < 0.03);
    let weave = 0.8 + 0.4 * noise(q * vec2f(90.0, 240.0));
    let rug = DemoSceneSurface(dye * weave, vec3f(0.0, 1.0, 0.0), vec3f(0.0), 1.0, vec3f(0.0), 0.0);
    if inset > 0.0 { return rug; }
    return polished;
}

// Bricks in running bond; `p` runs along the wall and up it. Returns colour, and in w the mortar's share.
fn demo_scene_brick(p: vec2f, pixel: f32) -> vec4f {
    let course = floor(p.y / 0.075);
    let along = p.x / 0.23 + 0.5 * fract(course * 0.5) * 2.0;
    let stone = floor(along);
    let seed = hash_cell(vec2i(vec2f(stone, course)));
    let edge = min((0.5 - abs(along - stone - 0.5)) * 0.23, (0.5 - abs(p.y / 0.075 - course - 0.5)) * 0.075);
    let joint = demo_scene_line(edge, 0.006 + 0.003 * noise(p * 60.0), pixel);
    let clay = mix(vec3f(0.17, 0.07, 0.048), vec3f(0.34, 0.17, 0.11), seed) * (0.7 + 0.5 * noise(p * 37.0));
    return vec4f(mix(clay, vec3f(0.3, 0.27, 0.24), joint), joint);
}

fn demo_scene_wall(p: vec3f, normal: vec3f, pixel: f32) -> DemoSceneSurface {
    let uv = select(p.xy, p.zy, abs(normal.x) > 0.5);
    let brick = demo_scene_brick(uv, pixel);
    // The clay is uneven, which raking light shows.
    let bump = vec2f(noise(uv * 55.0) - 0.5, noise(uv * 55.0 + 40.0) - 0.5) * 0.5 * (1.0 - brick.w);
    let tangent = select(vec3f(1.0, 0.0, 0.0), vec3f(0.0, 0.0, 1.0), abs(normal.x) > 0.5);
    let rough = normalize(normal + tangent * bump.x + vec3f(0.0, bump.y, 0.0));
    let page = uv - vec2f(-3.55, 1.25);
    let poster = normal.z > 0.5 && all(page > vec2f(0.0)) && all(page < vec2f(0.7, 1.0));
    if poster { return DemoSceneSurface(demo_scene_poster(page), normal, vec3f(0.0), 1.0, vec3f(0.0), 0.0); }
    return DemoSceneSurface(brick.rgb, rough, vec3f(0.0), 1.0, vec3f(0.0), 0.0);
}

// Two discs printed over each other, and small type below.
fn demo_scene_poster(p: vec2f) -> vec3f {
    var ink = vec3f(0.72, 0.66, 0.54);
    if length(p - vec2f(0.28, 0.66)) < 0.19 { ink *= vec3f(0.9, 0.16, 0.1); }
    if length(p - vec2f(0.42, 0.6)) < 0.19 { ink *= vec3f(0.1, 0.45, 0.62); }
    let type_area = p.x > 0.08 && p.x < 0.62 && p.y > 0.08 && p.y < 0.32;
    let print = demo_scene_print(vec2f(p.x, 1.0 - p.y), 0.03);
    return select(ink, ink * (1.0 - 0.9 * print), type_area);
}

// The shelf's face: boards, and between them books of many sizes; darkness above each.
fn demo_scene_books(p: vec3f, normal: vec3f) -> vec3f {
    let walnut = demo_scene_wood(p.yz, vec3f(0.04, 0.02, 0.012), vec3f(0.12, 0.065, 0.036), 0.5);
    if normal.x < 0.5 { return walnut; }
    let row = floor(p.y / 0.42);
    let y = p.y - row * 0.42;
    let bay = abs(fract(p.z / 0.86 + 0.5) - 0.5) * 0.86;
    if y < 0.028 || bay < 0.014 || p.z > -0.73 || p.z < -3.27 { return walnut; }
    let place = p.z / 0.042;
    let book = floor(place + 0.35 * sin(place * 1.7 + row));
    let seed = hash_cell(vec2i(vec2f(book, row)));
    let other = hash_cell(vec2i(vec2f(book, row + 50.0)));
    let height = 0.2 + 0.15 * seed;
    if y > height + 0.028 || other < 0.1 { return walnut * 0.2; }
    let hue = 0.5 + 0.5 * cos(6.2832 * (vec3f(0.0, 0.3, 0.62) + other * 1.0));
    let band = step(0.07, abs(y - 0.028 - height * 0.75) / height) * step(0.02, abs(y - 0.028 - height * 0.15) / height);
    let cloth = mix(vec3f(0.22, 0.2, 0.17), hue * 0.3, 0.65) * (0.35 + 0.9 * seed);
    return mix(vec3f(0.42, 0.33, 0.16), cloth, band);
}

fn demo_scene_neon_surface(p: vec3f, gains: DemoSceneGains) -> DemoSceneSurface {
    let far = demo_scene_sign(p.xy);
    let near = min(min(far.x, far.y), far.z) / DEMO_SCENE_TUBE;
    var gas = DEMO_SCENE_AMBER * gains.neon.z;
    if far.y < far.z { gas = DEMO_SCENE_MAGENTA * gains.neon.y; }
    if far.x < min(far.y, far.z) { gas = DEMO_SCENE_CYAN * gains.neon.x; }
    // A glowing gas in a tube is brightest where the line of sight through it is longest.
    let core = sqrt(max(1.0 - near * near, 0.0));
    return DemoSceneSurface(vec3f(0.0), vec3f(0.0, 0.0, 1.0), vec3f(0.0), 1.0, gas * (0.35 + 0.75 * core), clamp(0.4 + core, 0.0, 1.0));
}

fn demo_scene_plain(albedo: vec3f, normal: vec3f, mirror: f32, roughness: f32) -> DemoSceneSurface {
    return DemoSceneSurface(albedo, normal, vec3f(mirror), roughness, vec3f(0.0), 0.0);
}

// What the ray met, `pixel` metres of it to a pixel.
fn demo_scene_surface(hit: DemoSceneHit, p: vec3f, pixel: f32, gains: DemoSceneGains) -> DemoSceneSurface {
    let n = hit.normal;
    switch hit.what {
        case DEMO_SCENE_FLOOR: { return demo_scene_floor(p, pixel); }
        case DEMO_SCENE_CEILING: { return demo_scene_plain(vec3f(0.5, 0.48, 0.44), n, 0.0, 1.0); }
        case DEMO_SCENE_PLASTER: {
            let mottle = 0.85 + 0.3 * noise(p.zy * 1.7) * noise(p.zy * 6.0 + 9.0);
            return demo_scene_plain(vec3f(0.1, 0.155, 0.165) * mottle, n, 0.0, 1.0);
        }
        case DEMO_SCENE_BRICK: { return demo_scene_wall(p, n, pixel); }
        case DEMO_SCENE_REVEAL: { return demo_scene_plain(vec3f(0.62, 0.6, 0.56), n, 0.0, 1.0); }
        case DEMO_SCENE_FRAME: { return demo_scene_plain(vec3f(0.035, 0.036, 0.04), n, 0.0, 1.0); }
        case DEMO_SCENE_BLIND: { return demo_scene_plain(vec3f(0.55, 0.5, 0.42), n, 0.0, 1.0); }
        case DEMO_SCENE_WALNUT: {
            let uv = select(p.zx, p.xy, abs(n.z) > 0.5);
            let wood = demo_scene_wood(uv.yx, vec3f(0.05, 0.026, 0.015), vec3f(0.15, 0.082, 0.045), 0.4);
            return demo_scene_plain(wood, n, 0.04, 0.3);
        }
        case DEMO_SCENE_BOOKS: { return demo_scene_plain(demo_scene_books(p, n), n, 0.0, 1.0); }
        case DEMO_SCENE_RADIATOR: {
            let fin = fract(p.x / 0.06) - 0.5;
            let curved = normalize(n + vec3f(fin * 2.4, 0.0, 0.0) * n.z);
            return demo_scene_plain(vec3f(0.5, 0.48, 0.45) * (0.25 + 0.75 * smoothstep(0.5, 0.32, abs(fin))), curved, 0.0, 1.0);
        }
        case DEMO_SCENE_CHROME: { return DemoSceneSurface(vec3f(0.0), n, vec3f(0.86, 0.87, 0.88), 0.05, vec3f(0.0), 0.0); }
        case DEMO_SCENE_BRASS: { return DemoSceneSurface(vec3f(0.0), n, vec3f(0.82, 0.56, 0.22), 0.14, vec3f(0.0), 0.0); }
        case DEMO_SCENE_CERAMIC: { return demo_scene_plain(vec3f(0.06, 0.2, 0.22), n, 0.05, 0.12); }
        case DEMO_SCENE_CLOTH: {
            let rib = 0.75 + 0.25 * cos(24.0 * atan2(p.z + 0.9, p.x - 1.55));
            return demo_scene_plain(vec3f(0.46, 0.24, 0.06) * rib, n, 0.0, 1.0);
        }
        case DEMO_SCENE_PAPER: {
            let rib = 0.9 + 0.1 * cos(p.y * 160.0);
            let ink = select(0.0, demo_scene_print(p.xz - vec2f(-1.3, -0.5), 0.016), n.y > 0.99 && p.y < 0.8);
            return demo_scene_plain(vec3f(0.7, 0.66, 0.58) * rib * (1.0 - 0.85 * ink), n, 0.0, 1.0);
        }
        default: { return demo_scene_neon_surface(p, gains); }
    }
}
