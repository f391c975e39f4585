// The lighting of the loft: the sun's beam and its haze, the window as an area light, neon, and indirect light.
import package::loft::{
    LOFT_BAR, LOFT_BLIND_LOW, LOFT_NEON_Z, LOFT_OUTSIDE, LOFT_PANE, LOFT_RING, LOFT_RING_STEP, LOFT_ROOM_HIGH,
    LOFT_ROOM_LOW, LOFT_TUBE, LOFT_WINDOW_LOW, LOFT_WINDOW_SIZE, LoftHit, loft_from_bar, loft_furniture, loft_in_blind,
    loft_on_ring, loft_on_underline,
};
import package::loft_lamps::{LOFT_AMBER, LOFT_CYAN, LOFT_MAGENTA, LOFT_SUN, LOFT_SUN_RADIUS, LOFT_SUNLIGHT, LoftLamps};
import package::loft_pose::LoftPose;
import package::loft_surfaces::LoftSurface;
import afterimage::noise::noise;
import package::ray::{Ray, RAY_MISS};

// Share of the sun's beam that reaches `p` through the window, with the penumbra of the sun's disc.
fn loft_beam(p: vec3f) -> f32 {
    let slope = LOFT_SUN.xy / LOFT_SUN.z;
    let bars_at = p.xy + slope * (-4.2 - p.z);
    let mouth_at = p.xy + slope * min(-4.0 - p.z, 0.0);
    let blur = max(2.0 * LOFT_SUN_RADIUS * (p.z + 4.2), 0.004);
    let bars = clamp((loft_from_bar(bars_at) - LOFT_BAR) / blur + 0.5, vec2f(0.0), vec2f(1.0));
    let low = min(bars_at, mouth_at) - LOFT_WINDOW_LOW;
    let high = LOFT_WINDOW_LOW + LOFT_WINDOW_SIZE - max(bars_at, mouth_at);
    let edge = clamp(min(low, high) / blur + 0.5, vec2f(0.0), vec2f(1.0));
    return bars.x * bars.y * edge.x * edge.y * loft_past_blind(p, blur);
}

// The slats of the blind near it; their mean where the sun's disc is wider than the gaps.
fn loft_past_blind(p: vec3f, blur: f32) -> f32 {
    let at = p.xy + LOFT_SUN.xy / LOFT_SUN.z * (-4.08 - p.z);
    if p.z < -4.07 || any(at < LOFT_BLIND_LOW) { return 1.0; }
    let stripe = select(0.0, 1.0, !loft_in_blind(at));
    return mix(stripe, 0.3, clamp(blur / 0.02, 0.0, 1.0));
}

// 1 if nothing in the room lies between `p` and `sun`, a point of the sun's disc.
fn loft_unshaded(p: vec3f, n: vec3f, sun: vec3f, pose: LoftPose) -> f32 {
    let ray = Ray(p + n * 2e-3, sun);
    let hit = loft_furniture(ray, LoftHit(RAY_MISS, n, LOFT_OUTSIDE), pose);
    return step(RAY_MISS, hit.distance);
}

// The edge from `a` to `b` in Lambert's formula for the irradiance of a polygon (both unit vectors).
fn loft_edge(a: vec3f, b: vec3f) -> vec3f {
    let c = clamp(dot(a, b), -0.9999, 0.9999);
    return cross(a, b) * (acos(c) * inverseSqrt(1.0 - c * c));
}

// Form factor of the window as a vector: its share of a cosine-weighted hemisphere around its own direction.
fn loft_window_factor(p: vec3f) -> vec3f {
    let low = vec3f(LOFT_WINDOW_LOW.x, LOFT_WINDOW_LOW.y, -4.15) - p;
    let size = LOFT_WINDOW_SIZE;
    let a = normalize(low);
    let b = normalize(low + vec3f(size.x, 0.0, 0.0));
    let c = normalize(low + vec3f(size.x, size.y, 0.0));
    let d = normalize(low + vec3f(0.0, size.y, 0.0));
    let f = loft_edge(a, b) + loft_edge(b, c) + loft_edge(c, d) + loft_edge(d, a);
    return f * (select(-1.0, 1.0, dot(f, vec3f(-0.4, 2.2, -4.15) - p) > 0.0) / 6.2832);
}

// Irradiance over pi from the sky in the window, with a soft transition where the window is at the surface's horizon.
fn loft_skylight(p: vec3f, n: vec3f) -> vec3f {
    let f = loft_window_factor(p);
    let most = max(length(f), 1e-4);
    let x = dot(f, n) / most;
    let soft = clamp(0.5 * most + 0.1, 0.1, 0.6);
    let above = select(max(x, 0.0), (x + soft) * (x + soft) / (4.0 * soft), abs(x) < soft);
    let tint = mix(vec3f(5.0, 4.3, 3.4), vec3f(3.9, 4.3, 4.9), 0.5 + 0.5 * n.y);
    return tint * (most * above);
}

// One tube, approximated by its nearest point: near it the light falls off as that of a line, far from it as that of a
// point.
fn loft_tube_light(p: vec3f, n: vec3f, near: vec2f, reach: f32) -> f32 {
    let v = vec3f(near, LOFT_NEON_Z) - p;
    let d = max(length(v), 0.03);
    return max(dot(n, v) / d + 0.12, 0.0) * LOFT_TUBE * 2.5 * reach / (d * (d + reach));
}

fn loft_neon_light(p: vec3f, n: vec3f, lamps: LoftLamps) -> vec3f {
    let cyan = loft_on_ring(p.xy, LOFT_RING).xy;
    let magenta = loft_on_ring(p.xy, LOFT_RING + LOFT_RING_STEP).xy;
    let amber = loft_on_underline(p.xy).xy;
    return LOFT_CYAN * (lamps.neon.x * loft_tube_light(p, n, cyan, 1.2))
        + LOFT_MAGENTA * (lamps.neon.y * loft_tube_light(p, n, magenta, 1.2))
        + LOFT_AMBER * (lamps.neon.z * loft_tube_light(p, n, amber, 0.6));
}

// The share of the hemisphere that a box beside the point leaves open.
fn loft_beside(p: vec3f, n: vec3f, low: vec3f, high: vec3f, reach: f32) -> f32 {
    let v = clamp(p, low, high) - p;
    let d = length(v);
    let facing = clamp(dot(n, v) / max(d, 1e-4) * 0.6 + 0.4, 0.0, 1.0) * smoothstep(0.0, 0.02, d);
    return 1.0 - 0.85 * facing * exp(-d / reach);
}

fn loft_open(p: vec3f, n: vec3f) -> f32 {
    let gap = max(min(p - LOFT_ROOM_LOW, LOFT_ROOM_HIGH - p), vec3f(0.0));
    let corner = 1.0 - 0.5 * (1.0 - abs(n)) * exp(-gap / 0.45);
    var open = corner.x * corner.y * corner.z;
    open *= loft_beside(p, n, vec3f(-2.0, 0.35, -1.15), vec3f(-0.2, 0.77, -0.15), 0.35);
    open *= loft_beside(p, n, vec3f(2.1, 0.14, -4.0), vec3f(3.8, 0.66, -3.55), 0.2);
    open *= loft_beside(p, n, vec3f(-4.0, 0.0, -3.3), vec3f(-3.62, 2.56, -0.7), 0.3);
    open *= loft_beside(p, n, vec3f(1.25, 0.1, -1.2), vec3f(1.85, 0.3, -0.6), 0.16);
    open *= loft_beside(p, n, vec3f(-0.63, 0.8, -0.73), vec3f(-0.57, 1.0, -0.67), 0.1);
    open *= loft_beside(p, n, vec3f(-1.57, 0.77, -0.75), vec3f(-1.47, 1.1, -0.65), 0.1);
    open *= loft_beside(p, n, vec3f(1.25, 0.05, -3.4), vec3f(1.55, 0.35, -3.1), 0.12);
    return open;
}

// Indirect light of the room: warm from below, strongest near the sunlit floor.
fn loft_bounce(p: vec3f, n: vec3f) -> vec3f {
    let v = vec3f(1.9, 0.0, -0.4) - p;
    let square = dot(v, v) + 2.5;
    let patch_light = max(dot(n, v) * inverseSqrt(square) + 0.25, 0.0) * 0.7 / square;
    let room = mix(vec3f(0.11, 0.08, 0.058), vec3f(0.055, 0.058, 0.066), 0.5 + 0.5 * n.y);
    return room + vec3f(1.0, 0.6, 0.32) * patch_light;
}

// GGX highlight of the sun with Smith's shadowing in Karis' form.
fn loft_glint(surface: LoftSurface, n: vec3f, view: vec3f) -> vec3f {
    let middle = normalize(LOFT_SUN + view);
    let a = max(surface.roughness * surface.roughness, 0.03);
    let nh = max(dot(n, middle), 0.0);
    let nl = max(dot(n, LOFT_SUN), 0.0);
    let nv = max(dot(n, view), 0.02);
    let d = a / (nh * nh * (a * a - 1.0) + 1.0);
    let k = 0.5 * a;
    let v = 0.25 / ((nl * (1.0 - k) + k) * (nv * (1.0 - k) + k));
    let f = surface.mirror + (1.0 - surface.mirror) * pow(1.0 - max(dot(view, middle), 0.0), 5.0);
    // Limits the peak of the formula at grazing angles: no surface is smooth enough for it.
    let peak = d * d * v / 3.1416;
    return f * (peak / (1.0 + 0.2 * peak)) * nl * step(1e-3, surface.mirror.g);
}

fn loft_lit(
    surface: LoftSurface,
    p: vec3f,
    view: vec3f,
    flat_normal: vec3f,
    sun: vec3f,
    lamps: LoftLamps,
    pose: LoftPose,
) -> vec3f {
    let n = surface.normal;
    let around = (loft_skylight(p, n) + loft_bounce(p, n)) * loft_open(p, flat_normal) + loft_neon_light(p, n, lamps);
    let beam = loft_beam(p) * lamps.sunlight;
    let sunlit = beam * loft_unshaded(p, flat_normal, sun, pose);
    // Uneven bricks must not reflect a sun behind the wall.
    let facing = max(dot(n, LOFT_SUN), 0.0) * step(0.0, dot(flat_normal, LOFT_SUN));
    let behind = surface.translucence * max(0.2 - 0.8 * dot(n, LOFT_SUN), 0.0);
    let direct = LOFT_SUNLIGHT * ((sunlit * facing + beam * behind) / 3.1416);
    let diffuse = surface.albedo * (around + direct);
    return surface.emission + diffuse + loft_glint(surface, n, view) * LOFT_SUNLIGHT * sunlit;
}

// Length of sunbeam along the ray up to `distance`, in meters: computed exactly per pane, without visible steps.
fn loft_beam_length(ray: Ray, distance: f32) -> f32 {
    let slope = LOFT_SUN.xy / LOFT_SUN.z;
    let start = ray.origin.xy + slope * (-4.2 - ray.origin.z) - LOFT_WINDOW_LOW;
    let raw = ray.direction.xy - slope * ray.direction.z;
    let step_by = select(raw, vec2f(1e-7), abs(raw) < vec2f(1e-7));
    var sum = 0.0;
    for (var i = 0; i < 4; i++) {
        for (var j = 0; j < 3; j++) {
            let low = vec2f(vec2i(i, j)) * LOFT_PANE + LOFT_BAR;
            let a = (low - start) / step_by;
            let b = (low + LOFT_PANE - 2.0 * LOFT_BAR - start) / step_by;
            let enter = max(min(a, b), vec2f(0.0));
            let leave = min(max(a, b), vec2f(distance));
            let share = select(1.0, 0.3, i == 3 && j == 2);
            sum += share * max(min(leave.x, leave.y) - max(enter.x, enter.y), 0.0);
        }
    }
    return sum;
}

// Sunlight that the room's dust scatters toward the eye, mostly forwards.
fn loft_haze(ray: Ray, distance: f32, lamps: LoftLamps) -> vec3f {
    let toward = max(dot(ray.direction, LOFT_SUN), 0.0);
    let phase = 0.00002 + 0.00012 * pow(toward, 10.0);
    let middle = ray.origin + ray.direction * min(distance, 6.0) * 0.5;
    let drift = 0.8 + 0.4 * noise(middle.xy * 1.1 + vec2f(lamps.time * 0.07, lamps.time * 0.03));
    return LOFT_SUNLIGHT * (lamps.sunlight * phase * drift * loft_beam_length(ray, distance));
}
