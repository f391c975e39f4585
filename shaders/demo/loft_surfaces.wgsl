// The materials of the loft: all procedural, with detail that shows aliasing.
import package::loft::{
    LOFT_BALL, LOFT_BALLOON, LOFT_BLIND, LOFT_BOOKS, LOFT_BRASS, LOFT_BRICK, LOFT_CEILING, LOFT_CERAMIC, LOFT_CHROME,
    LOFT_CLAY, LOFT_CLOTH, LOFT_FLOOR, LOFT_FRAME, LOFT_LEAF, LOFT_PAPER, LOFT_PLASTER, LOFT_RADIATOR, LOFT_REVEAL,
    LOFT_TUBE, LOFT_WALNUT, LoftHit, loft_sign,
};
import package::loft_lamps::{LOFT_AMBER, LOFT_CYAN, LOFT_MAGENTA, LoftLamps};
import afterimage::noise::{hash_cell, noise, noise_cell};

struct LoftSurface {
    albedo: vec3f,
    normal: vec3f,
    mirror: vec3f,       // reflectance at normal incidence; 0 has no highlight
    roughness: f32,
    translucence: f32,   // share of the albedo that is lit by sunlight from behind
    emission: vec3f,
    glow: f32,           // emissive strength, 0 to 1
}

fn loft_matte(albedo: vec3f, normal: vec3f) -> LoftSurface {
    return LoftSurface(albedo, normal, vec3f(0.0), 1.0, 0.0, vec3f(0.0), 0.0);
}

fn loft_thin(albedo: vec3f, normal: vec3f, translucence: f32) -> LoftSurface {
    return LoftSurface(albedo, normal, vec3f(0.0), 1.0, translucence, vec3f(0.0), 0.0);
}

fn loft_glossy(albedo: vec3f, normal: vec3f, roughness: f32) -> LoftSurface {
    return LoftSurface(albedo, normal, vec3f(0.045), roughness, 0.0, vec3f(0.0), 0.0);
}

fn loft_metal(mirror: vec3f, normal: vec3f, roughness: f32) -> LoftSurface {
    return LoftSurface(vec3f(0.0), normal, mirror, roughness, 0.0, vec3f(0.0), 0.0);
}

// Coverage of a pixel by a line: `d` is the distance from its center, `half_width` its half width, `pixel` the pixel's
// width.
fn loft_line(d: f32, half_width: f32, pixel: f32) -> f32 {
    let blur = max(pixel, 1e-4);
    return clamp((half_width - d) / blur + 0.5, 0.0, 1.0) * min(1.0, 2.0 * half_width / blur);
}

// Ink of a printed page: words of three-by-five letters; `line` is the line spacing.
fn loft_print(p: vec2f, line: f32) -> f32 {
    let place = p / vec2f(0.5 * line, line);
    let letter = noise_cell(place);
    let point = vec2i(fract(place) * vec2f(4.0, 8.0));
    let inked = hash_cell(letter * 16 + point) > 0.42 && point.x < 3 && point.y < 5;
    return select(0.0, 1.0, inked && hash_cell(letter + 977) > 0.17);
}

// Wood with the grain along y. `seed` in 0..1 makes boards differ.
fn loft_wood(p: vec2f, dark: vec3f, light: vec3f, seed: f32) -> vec3f {
    let coarse = noise(vec2f(p.x * 46.0 + seed * 91.0, p.y * 2.2));
    let fine = noise(vec2f(p.x * 170.0, p.y * 7.0 + seed * 31.0));
    return mix(dark, light, clamp(coarse * 0.45 + fine * 0.3 + seed * 0.5 - 0.12, 0.0, 1.0));
}

// Lacquered boards of 17 cm, each slightly different, and the rug on them.
fn loft_floor(p: vec3f, pixel: f32) -> LoftSurface {
    let rug = p.xz - vec2f(-2.75, -1.85);
    if all(rug > vec2f(0.0)) && all(rug < vec2f(2.9, 2.5)) {
        return loft_matte(loft_rug(rug), vec3f(0.0, 1.0, 0.0));
    }
    let across = p.x / 0.17;
    let column = floor(across);
    let along = p.z / 1.9 + hash_cell(noise_cell(vec2f(column, 3.0)));
    let board = floor(along);
    let seed = hash_cell(noise_cell(vec2f(column, board)));
    let seam = min(0.5 - abs(across - column - 0.5), (0.5 - abs(along - board - 0.5)) * 11.0) * 0.17;
    let wood = loft_wood(p.xz, vec3f(0.075, 0.036, 0.019), vec3f(0.25, 0.14, 0.073), seed);
    let ripple = (noise(p.xz * vec2f(31.0, 5.0)) - 0.5) * 0.003;
    let tilt = (vec2f(seed, fract(seed * 57.0)) - 0.5) * vec2f(0.003, 0.005) + ripple;
    let gap = loft_line(seam, 0.003, pixel);
    return loft_glossy(wood * (1.0 - 0.8 * gap), normalize(vec3f(tilt.x, 1.0, tilt.y)), 0.3);
}

// A woven rug: checks in a plain border; `q` is measured from the corner.
fn loft_rug(q: vec2f) -> vec3f {
    let cream = vec3f(0.42, 0.37, 0.29);
    let inset = min(min(q.x, 2.9 - q.x), min(q.y, 2.5 - q.y));
    let square = floor((q - 0.2) / 0.25);
    var dye = select(vec3f(0.045, 0.065, 0.12), cream, fract((square.x + square.y) * 0.5) > 0.25);
    dye = select(dye, vec3f(0.26, 0.055, 0.035), inset < 0.2);
    dye = select(dye, cream, inset < 0.03);
    return dye * (0.8 + 0.4 * noise(q * vec2f(90.0, 240.0)));
}

// Uneven bricks in running bond, visible under raking light. `uv` is along and up the wall.
fn loft_brick(uv: vec2f, normal: vec3f, pixel: f32) -> LoftSurface {
    let course = floor(uv.y / 0.075);
    let along = uv.x / 0.23 + fract(course * 0.5);
    let stone = floor(along);
    let seed = hash_cell(noise_cell(vec2f(stone, course)));
    let edge = min((0.5 - abs(along - stone - 0.5)) * 0.23, (0.5 - abs(uv.y / 0.075 - course - 0.5)) * 0.075);
    let joint = loft_line(edge, 0.005 + 0.004 * noise(uv * 60.0), pixel);
    let clay = mix(vec3f(0.14, 0.062, 0.045), vec3f(0.3, 0.16, 0.11), seed) * (0.65 + 0.6 * noise(uv * 37.0));
    let bump = vec2f(noise(uv * 55.0) - 0.5, noise(uv * 55.0 + 40.0) - 0.5) * 0.5 * (1.0 - joint);
    let tangent = vec3f(abs(normal.z), 0.0, abs(normal.x));
    let uneven = normalize(normal + tangent * bump.x + vec3f(0.0, bump.y, 0.0));
    return loft_matte(mix(clay, vec3f(0.27, 0.245, 0.22), joint), uneven);
}

fn loft_wall(p: vec3f, normal: vec3f, pixel: f32) -> LoftSurface {
    let uv = select(p.xy, p.zy, abs(normal.x) > 0.5);
    let page = uv - vec2f(-3.55, 1.25);
    if normal.z > 0.5 && all(page > vec2f(0.0)) && all(page < vec2f(0.7, 1.0)) {
        return loft_matte(loft_poster(page), normal);
    }
    return loft_brick(uv, normal, pixel);
}

// Two overlapping discs, and small type below.
fn loft_poster(p: vec2f) -> vec3f {
    var ink = vec3f(0.72, 0.66, 0.54);
    if length(p - vec2f(0.28, 0.67)) < 0.19 { ink *= vec3f(0.9, 0.16, 0.1); }
    if length(p - vec2f(0.42, 0.61)) < 0.19 { ink *= vec3f(0.1, 0.45, 0.62); }
    let typeset = all(p > vec2f(0.08)) && all(p < vec2f(0.62, 0.32));
    return select(ink, ink * (1.0 - 0.9 * loft_print(vec2f(p.x, 1.0 - p.y), 0.03)), typeset);
}

// The face of the shelf: boards, and books of many sizes between them with dark gaps above.
fn loft_books(p: vec3f, normal: vec3f) -> vec3f {
    let walnut = loft_wood(p.zy, vec3f(0.04, 0.02, 0.012), vec3f(0.12, 0.065, 0.036), 0.5);
    let row = floor(p.y / 0.42);
    let y = p.y - row * 0.42 - 0.028;
    let bay = abs(fract(p.z / 0.86 + 0.5) - 0.5) * 0.86;
    if normal.x < 0.5 || y < 0.0 || bay < 0.014 || p.z > -0.73 || p.z < -3.27 { return walnut; }
    let place = p.z / 0.042;
    let book = vec2f(floor(place + 0.35 * sin(place * 1.7 + row)), row);
    let size = hash_cell(noise_cell(book));
    let kind = hash_cell(noise_cell(book + 50.0));
    let height = 0.2 + 0.15 * size;
    if y > height || kind < 0.12 { return walnut * 0.2; }
    let gilt = min(abs(y - height * 0.75), abs(y - height * 0.15)) < height * 0.03;
    return select(loft_binding(kind, size), vec3f(0.36, 0.28, 0.14), gilt);
}

// Colors of cloth and leather: mostly browns, some navy, green, oxblood and cream.
fn loft_binding(kind: f32, shade: f32) -> vec3f {
    var dye = vec3f(0.17, 0.09, 0.05);
    if kind > 0.38 { dye = vec3f(0.05, 0.08, 0.14); }
    if kind > 0.55 { dye = vec3f(0.2, 0.045, 0.04); }
    if kind > 0.7 { dye = vec3f(0.05, 0.1, 0.07); }
    if kind > 0.82 { dye = vec3f(0.4, 0.35, 0.26); }
    if kind > 0.95 { dye = vec3f(0.34, 0.2, 0.04); }
    return dye * (0.5 + shade);
}

// A glowing gas is brightest where the line of sight through its tube is longest.
fn loft_neon_surface(p: vec3f, lamps: LoftLamps) -> LoftSurface {
    let away = loft_sign(p.xy);
    var gas = LOFT_AMBER * lamps.neon.z;
    if away.y < away.z { gas = LOFT_MAGENTA * lamps.neon.y; }
    if away.x < min(away.y, away.z) { gas = LOFT_CYAN * lamps.neon.x; }
    let across = min(min(away.x, away.y), away.z) / LOFT_TUBE;
    let depth = sqrt(max(1.0 - across * across, 0.0));
    let normal = vec3f(0.0, 0.0, 1.0);
    return LoftSurface(vec3f(0.0), normal, vec3f(0.0), 1.0, 0.0, gas * (0.35 + 0.75 * depth), min(0.4 + depth, 1.0));
}

fn loft_walnut(p: vec3f, n: vec3f, pixel: f32) -> LoftSurface {
    // The grain runs along the longer side of a board: x on fronts and tops, z on ends.
    let uv = select(vec2f(p.y + p.z, p.x), vec2f(p.y, p.z), abs(n.x) > 0.5);
    let wood = loft_wood(uv, vec3f(0.045, 0.023, 0.013), vec3f(0.14, 0.076, 0.042), 0.4);
    // The sideboard's front has three drawers above three.
    let drawer = vec2f(fract((p.x - 2.1) / 0.5667) * 0.5667, p.y - 0.4);
    let front = n.z > 0.5 && p.z < -3.5 && p.y < 0.7;
    let edge = select(1.0, min(min(drawer.x, 0.5667 - drawer.x), abs(drawer.y)), front);
    let gap = loft_line(edge, 0.004, pixel);
    // Only tops are polished: a reflection on every front would show the furniture twice.
    if n.y > 0.5 { return loft_glossy(wood, n, 0.35); }
    return loft_matte(wood * (1.0 - 0.85 * gap), n);
}

// The sheets on the table are printed; the lantern is ribbed and translucent.
fn loft_paper(p: vec3f, n: vec3f) -> LoftSurface {
    let sheet = p.y < 0.8;
    let ink = select(0.0, loft_print(p.xz - vec2f(-1.3, -0.5), 0.016), sheet && n.y > 0.99);
    let rib = select(0.88 + 0.12 * cos(p.y * 170.0), 1.0, sheet);
    return loft_thin(vec3f(0.68, 0.63, 0.54) * (rib * (1.0 - 0.85 * ink)), n, select(0.2, 0.0, sheet));
}

fn loft_radiator(p: vec3f, n: vec3f) -> LoftSurface {
    let fin = fract(p.x / 0.06) - 0.5;
    let hollow = 0.25 + 0.75 * smoothstep(-0.5, -0.32, -abs(fin));
    return loft_matte(vec3f(0.4, 0.39, 0.37) * hollow, normalize(n + vec3f(fin * 2.4 * n.z, 0.0, 0.0)));
}

// The material at the hit point `p`; `pixel` is the width of a pixel there, in meters.
fn loft_surface(hit: LoftHit, p: vec3f, pixel: f32, lamps: LoftLamps) -> LoftSurface {
    let n = hit.normal;
    switch hit.what {
        case LOFT_FLOOR: { return loft_floor(p, pixel); }
        case LOFT_CEILING: { return loft_matte(vec3f(0.46, 0.44, 0.41), n); }
        case LOFT_PLASTER: {
            let mottle = 0.85 + 0.3 * noise(p.zy * 1.7) * noise(p.zy * 6.0);
            return loft_matte(vec3f(0.085, 0.135, 0.145) * mottle, n);
        }
        case LOFT_BRICK: { return loft_wall(p, n, pixel); }
        case LOFT_REVEAL: { return loft_matte(vec3f(0.6, 0.58, 0.54), n); }
        case LOFT_FRAME: { return loft_matte(vec3f(0.035, 0.036, 0.04), n); }
        case LOFT_BLIND: { return loft_thin(vec3f(0.5, 0.44, 0.35), n, 0.12); }
        case LOFT_WALNUT: { return loft_walnut(p, n, pixel); }
        case LOFT_BOOKS: { return loft_matte(loft_books(p, n), n); }
        case LOFT_RADIATOR: { return loft_radiator(p, n); }
        case LOFT_CHROME: { return loft_metal(vec3f(0.86, 0.87, 0.88), n, 0.05); }
        case LOFT_BRASS: { return loft_metal(vec3f(0.82, 0.56, 0.22), n, 0.14); }
        case LOFT_CERAMIC: { return loft_glossy(vec3f(0.05, 0.17, 0.19), n, 0.12); }
        case LOFT_CLOTH: {
            let knit = 0.82 + 0.18 * cos(46.0 * atan2(p.z + 0.9, p.x - 1.55)) * cos(p.y * 130.0);
            return loft_matte(vec3f(0.36, 0.17, 0.085) * knit, n);
        }
        case LOFT_PAPER: { return loft_paper(p, n); }
        case LOFT_LEAF: { return loft_thin(vec3f(0.045, 0.105, 0.03), n, 0.5); }
        case LOFT_CLAY: {
            let soil = step(0.36, p.y);
            return loft_matte(mix(vec3f(0.3, 0.13, 0.075), vec3f(0.05, 0.035, 0.025), soil), n);
        }
        case LOFT_BALLOON: { return loft_glossy(vec3f(0.42, 0.035, 0.03), n, 0.2); }
        case LOFT_BALL: {
            let stripe = step(0.5, fract(1.5 * n.y + 0.25));
            return loft_matte(mix(vec3f(0.5, 0.47, 0.4), vec3f(0.05, 0.2, 0.32), stripe), n);
        }
        default: { return loft_neon_surface(p, lamps); }
    }
}
