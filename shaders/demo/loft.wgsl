// A loft at golden hour: its solids, and their intersections with a ray. All intersections have closed forms.
//
// Units are meters; x to the right, y up, z toward the viewer. The window is in the wall at z = -4.
import package::loft_pose::{LOFT_BALL_RADIUS, LOFT_BALLOON_RADII, LoftPose};
import package::ray::{Ray, RAY_MISS, ray_box, ray_ellipsoid, ray_tube};

struct LoftHit {
    distance: f32,
    normal: vec3f,
    what: u32,
}

const LOFT_OUTSIDE: u32 = 0u;
const LOFT_FLOOR: u32 = 1u;
const LOFT_CEILING: u32 = 2u;
const LOFT_PLASTER: u32 = 3u;
const LOFT_BRICK: u32 = 4u;
const LOFT_REVEAL: u32 = 5u;
const LOFT_FRAME: u32 = 6u;
const LOFT_BLIND: u32 = 7u;
const LOFT_WALNUT: u32 = 8u;
const LOFT_BOOKS: u32 = 9u;
const LOFT_RADIATOR: u32 = 10u;
const LOFT_CHROME: u32 = 11u;
const LOFT_BRASS: u32 = 12u;
const LOFT_CERAMIC: u32 = 13u;
const LOFT_CLOTH: u32 = 14u;
const LOFT_PAPER: u32 = 15u;
const LOFT_LEAF: u32 = 16u;
const LOFT_CLAY: u32 = 17u;
const LOFT_NEON: u32 = 18u;
const LOFT_BALLOON: u32 = 19u;
const LOFT_BALL: u32 = 20u;

const LOFT_ROOM_LOW = vec3f(-4.0, 0.0, -4.0);
const LOFT_ROOM_HIGH = vec3f(4.0, 4.2, 5.6);

const LOFT_WINDOW_LOW = vec2f(-2.6, 0.5);
const LOFT_WINDOW_SIZE = vec2f(4.4, 3.4);
const LOFT_PANE = vec2f(1.1, 1.1333333);
const LOFT_BAR: f32 = 0.03;           // half the width of a glazing bar
const LOFT_BLIND_LOW = vec2f(0.7, 2.45);
const LOFT_SLAT: f32 = 0.05;          // from one slat of the blind to the next

const LOFT_RING = vec2f(2.66, 2.5);   // center of the cyan ring; the magenta one is its afterimage
const LOFT_RING_STEP = vec2f(0.4, -0.08);
const LOFT_RING_RADIUS: f32 = 0.4;
const LOFT_UNDERLINE_LOW = vec2f(2.3, 1.72);
const LOFT_UNDERLINE_LENGTH: f32 = 1.2;
const LOFT_NEON_Z: f32 = -3.93;
const LOFT_TUBE: f32 = 0.016;

fn loft_box(hit: ptr<function, LoftHit>, ray: Ray, low: vec3f, high: vec3f, what: u32) {
    let t = ray_box(ray, low, high);
    if t.x < t.y && t.x > 1e-4 && t.x < (*hit).distance {
        // The side that was entered last, where the surface is furthest from the center.
        let p = ray.origin + ray.direction * t.x;
        let out = (p - 0.5 * (low + high)) / (high - low);
        let most = max(max(abs(out.x), abs(out.y)), abs(out.z));
        *hit = LoftHit(t.x, normalize(sign(out) * step(vec3f(most), abs(out))), what);
    }
}

fn loft_ball(hit: ptr<function, LoftHit>, ray: Ray, center: vec3f, radii: vec3f, what: u32) {
    let t = ray_ellipsoid(ray, center, radii);
    if t > 1e-4 && t < (*hit).distance {
        let p = ray.origin + ray.direction * t;
        *hit = LoftHit(t, normalize((p - center) / (radii * radii)), what);
    }
}

fn loft_tube(hit: ptr<function, LoftHit>, ray: Ray, foot: vec3f, radius: f32, height: f32, what: u32) {
    let t = ray_tube(ray, foot, radius, height);
    if t > 1e-4 && t < (*hit).distance {
        let p = ray.origin + ray.direction * t - foot;
        *hit = LoftHit(t, vec3f(p.x, 0.0, p.z) / radius, what);
    }
}

// A pot and a spiral of leaves; `foot` is on the floor below it.
fn loft_plant(hit: ptr<function, LoftHit>, ray: Ray, foot: vec3f) {
    let bounds = ray_box(ray, foot + vec3f(-0.75, 0.0, -0.75), foot + vec3f(0.75, 2.1, 0.75));
    if bounds.x > bounds.y || bounds.y < 0.0 { return; }
    loft_tube(hit, ray, foot, 0.2, 0.38, LOFT_CLAY);
    loft_ball(hit, ray, foot + vec3f(0.0, 0.37, 0.0), vec3f(0.199, 0.02, 0.199), LOFT_CLAY);
    loft_tube(hit, ray, foot + vec3f(0.0, 0.4, 0.0), 0.014, 1.15, LOFT_WALNUT);
    var across = vec2f(1.0, 0.0);
    for (var i = 0; i < 13; i++) {
        // Rotation by the golden angle, as in plants.
        across = vec2f(-0.7374 * across.x - 0.6755 * across.y, 0.6755 * across.x - 0.7374 * across.y);
        let rise = f32(i) / 12.0;
        let along = normalize(vec3f(across.x, 0.3 + 1.3 * rise, across.y));
        let side = vec3f(-across.y, 0.0, across.x);
        let size = vec3f(0.3, 0.1, 0.012) * (1.15 - 0.35 * rise);
        let middle = foot + vec3f(0.0, 0.6 + 0.95 * rise, 0.0) + along * (size.x + 0.05);
        loft_leaf(hit, ray, middle, mat3x3f(along, side, cross(along, side)), size);
    }
}

// A flat ellipsoid; the columns of `turn` are its axes.
fn loft_leaf(hit: ptr<function, LoftHit>, ray: Ray, middle: vec3f, turn: mat3x3f, size: vec3f) {
    let local = Ray((ray.origin - middle) * turn, ray.direction * turn);
    let t = ray_ellipsoid(local, vec3f(0.0), size);
    if t > 1e-4 && t < (*hit).distance {
        let p = (local.origin + local.direction * t) / (size * size);
        *hit = LoftHit(t, normalize(turn * p), LOFT_LEAF);
    }
}

// All solids in the room. The sun's shadow rays use it too, so the glowing tubes are not in it.
fn loft_furniture(ray: Ray, nearest: LoftHit, pose: LoftPose) -> LoftHit {
    var hit = nearest;
    // Table, and the objects on it.
    loft_box(&hit, ray, vec3f(-2.0, 0.72, -1.15), vec3f(-0.2, 0.77, -0.15), LOFT_WALNUT);
    loft_box(&hit, ray, vec3f(-1.88, 0.0, -1.05), vec3f(-1.83, 0.72, -0.25), LOFT_WALNUT);
    loft_box(&hit, ray, vec3f(-0.37, 0.0, -1.05), vec3f(-0.32, 0.72, -0.25), LOFT_WALNUT);
    loft_box(&hit, ray, vec3f(-1.3, 0.77, -0.5), vec3f(-0.98, 0.79, -0.25), LOFT_PAPER);
    loft_ball(&hit, ray, vec3f(-0.6, 0.95, -0.7), vec3f(0.18), LOFT_CHROME);
    loft_ball(&hit, ray, vec3f(-0.78, 0.86, -0.34), vec3f(0.09), LOFT_BRASS);
    loft_ball(&hit, ray, vec3f(-1.52, 0.95, -0.7), vec3f(0.15, 0.18, 0.15), LOFT_CERAMIC);
    loft_tube(&hit, ray, vec3f(-1.52, 1.08, -0.7), 0.05, 0.2, LOFT_CERAMIC);
    // The lantern and its cord.
    loft_ball(&hit, ray, vec3f(-0.5, 2.15, -0.7), vec3f(0.34, 0.27, 0.34), LOFT_PAPER);
    loft_tube(&hit, ray, vec3f(-0.5, 2.41, -0.7), 0.008, 1.79, LOFT_FRAME);
    loft_plant(&hit, ray, vec3f(1.4, 0.0, -3.25));
    // Pouf, sideboard, shelf, radiator, beams.
    loft_tube(&hit, ray, vec3f(1.55, 0.0, -0.9), 0.42, 0.34, LOFT_CLOTH);
    loft_ball(&hit, ray, vec3f(1.55, 0.34, -0.9), vec3f(0.43, 0.09, 0.43), LOFT_CLOTH);
    loft_box(&hit, ray, vec3f(2.1, 0.14, -4.0), vec3f(3.8, 0.66, -3.55), LOFT_WALNUT);
    loft_ball(&hit, ray, vec3f(2.5, 0.83, -3.75), vec3f(0.12, 0.18, 0.12), LOFT_CERAMIC);
    loft_ball(&hit, ray, vec3f(3.3, 0.79, -3.75), vec3f(0.14), LOFT_BRASS);
    loft_box(&hit, ray, vec3f(-4.0, 0.0, -3.3), vec3f(-3.62, 2.56, -0.7), LOFT_BOOKS);
    loft_box(&hit, ray, vec3f(-2.2, 0.08, -4.0), vec3f(1.4, 0.42, -3.88), LOFT_RADIATOR);
    loft_box(&hit, ray, vec3f(-2.75, 3.98, -4.0), vec3f(-2.55, 4.2, 5.6), LOFT_WALNUT);
    loft_box(&hit, ray, vec3f(-0.5, 3.98, -4.0), vec3f(-0.3, 4.2, 5.6), LOFT_WALNUT);
    loft_box(&hit, ray, vec3f(1.75, 3.98, -4.0), vec3f(1.95, 4.2, 5.6), LOFT_WALNUT);
    loft_ball(&hit, ray, pose.balloon, LOFT_BALLOON_RADII, LOFT_BALLOON);
    loft_ball(&hit, ray, pose.ball, vec3f(LOFT_BALL_RADIUS), LOFT_BALL);
    return hit;
}

// The nearest point of each tube of the sign to a point in its plane: xy and the distance.
fn loft_on_ring(p: vec2f, center: vec2f) -> vec3f {
    let v = p - center;
    let far = max(length(v), 1e-4);
    return vec3f(center + v * (LOFT_RING_RADIUS / far), abs(far - LOFT_RING_RADIUS));
}

fn loft_on_underline(p: vec2f) -> vec3f {
    let x = clamp(p.x - LOFT_UNDERLINE_LOW.x, 0.0, LOFT_UNDERLINE_LENGTH);
    let near = LOFT_UNDERLINE_LOW + vec2f(x, 0.0);
    return vec3f(near, length(p - near));
}

// Cyan, magenta, amber: the distance of `p` from each tube.
fn loft_sign(p: vec2f) -> vec3f {
    let cyan = loft_on_ring(p, LOFT_RING).z;
    let magenta = loft_on_ring(p, LOFT_RING + LOFT_RING_STEP).z;
    return vec3f(cyan, magenta, loft_on_underline(p).z);
}

fn loft_neon(hit: ptr<function, LoftHit>, ray: Ray) {
    let t = (LOFT_NEON_Z - ray.origin.z) / ray.direction.z;
    let far = loft_sign((ray.origin + ray.direction * t).xy);
    let near = min(min(far.x, far.y), far.z);
    if near < LOFT_TUBE && t > 1e-4 && t < (*hit).distance {
        *hit = LoftHit(t, vec3f(0.0, 0.0, 1.0), LOFT_NEON);
    }
}

// Distance of a point of the window from the center of the nearest bar, along each axis.
fn loft_from_bar(p: vec2f) -> vec2f {
    let u = p - LOFT_WINDOW_LOW;
    let count = LOFT_WINDOW_SIZE / LOFT_PANE;
    return abs(u - LOFT_PANE * round(clamp(u / LOFT_PANE, vec2f(0.0), round(count))));
}

fn loft_in_blind(p: vec2f) -> bool {
    return all(p > LOFT_BLIND_LOW) && fract(p.y / LOFT_SLAT) < 0.7;
}

// Continues a ray from the opening in the wall at `z` = -4: the sides of the recess, the blind, the bars, the outside.
fn loft_opening(ray: Ray) -> LoftHit {
    let t = (vec4f(-4.08, -4.16, -4.24, -4.3) - ray.origin.z) / ray.direction.z;
    let low = LOFT_WINDOW_LOW;
    let edge = select(low, low + LOFT_WINDOW_SIZE, ray.direction.xy > vec2f(0.0));
    let aside = (edge - ray.origin.xy) / ray.direction.xy;
    let side = min(aside.x, aside.y);
    let facing = -sign(ray.direction.xy);
    let blind = ray.origin.xy + ray.direction.xy * t.x;
    if t.x < side && loft_in_blind(blind) {
        return LoftHit(t.x, vec3f(0.0, 0.0, 1.0), LOFT_BLIND);
    }
    let front = ray.origin.xy + ray.direction.xy * t.y;
    if t.y < side && any(loft_from_bar(front) < vec2f(LOFT_BAR)) {
        return LoftHit(t.y, vec3f(0.0, 0.0, 1.0), LOFT_FRAME);
    }
    let behind = loft_from_bar(ray.origin.xy + ray.direction.xy * t.z) < vec2f(LOFT_BAR);
    if t.z < side && any(behind) {
        let normal = select(vec3f(0.0, facing.y, 0.0), vec3f(facing.x, 0.0, 0.0), behind.x);
        return LoftHit(mix(t.y, t.z, 0.5), normal, LOFT_FRAME);
    }
    if side < t.w {
        let normal = select(vec3f(0.0, facing.y, 0.0), vec3f(facing.x, 0.0, 0.0), aside.x < aside.y);
        return LoftHit(side, normal, LOFT_REVEAL);
    }
    return LoftHit(RAY_MISS, -ray.direction, LOFT_OUTSIDE);
}

// The inside of the room's walls, floor and ceiling.
fn loft_shell(ray: Ray) -> LoftHit {
    let edge = select(LOFT_ROOM_LOW, LOFT_ROOM_HIGH, ray.direction > vec3f(0.0));
    let t = (edge - ray.origin) / ray.direction;
    let facing = -sign(ray.direction);
    if t.y < min(t.x, t.z) {
        let what = select(LOFT_CEILING, LOFT_FLOOR, facing.y > 0.0);
        return LoftHit(t.y, vec3f(0.0, facing.y, 0.0), what);
    }
    if t.x < t.z {
        return LoftHit(t.x, vec3f(facing.x, 0.0, 0.0), select(LOFT_BRICK, LOFT_PLASTER, facing.x > 0.0));
    }
    let p = ray.origin.xy + ray.direction.xy * t.z - LOFT_WINDOW_LOW;
    if facing.z > 0.0 && all(p > vec2f(0.0)) && all(p < LOFT_WINDOW_SIZE) {
        return loft_opening(ray);
    }
    return LoftHit(t.z, vec3f(0.0, 0.0, facing.z), LOFT_BRICK);
}

fn loft_trace(ray: Ray, pose: LoftPose) -> LoftHit {
    var hit = loft_furniture(ray, loft_shell(ray), pose);
    loft_neon(&hit, ray);
    return hit;
}
