// Subpixel morphological anti-aliasing: Jimenez, Echevarria, Sousa and Gutierrez, "SMAA: Enhanced Subpixel
// Morphological Antialiasing", 2012, without its samples in time and in the pixel. The shapes of edges are looked up in
// tables there; here their areas are computed, which needs no table and no limit of the distance.

struct Smaa {
    threshold: f32,
    corners: f32,
    reach: i32,
    diagonal_reach: i32,
}

// The line of a row of pixels is between them and the pixels above; that of a column, between them and those before.
struct SmaaLine {
    along: vec2i,      // the step along the line
    across: vec2i,     // the step from the pixels before the line to those behind it
}

// The end of a line.
struct SmaaEnd {
    distance: f32,     // pixels between the pixel and the last one of the line
    place: vec2i,      // the pixel behind the line whose near border the line ends at
    before: f32,       // 1 if an edge goes on from there on the side before the line
    behind: f32,       // 1 if an edge goes on from there on the other side
}

// A search along a diagonal.
struct SmaaDiagonal {
    steps: i32,        // steps of the staircase
    ends: bool,        // whether it ends within the reach
    last: vec2f,       // the edges after the last step
}

const SMAA_NONE = vec2f(0.0);
// Shapes like a U are drawn rounder below this length: short ones would vanish.
const SMAA_ROUND = 32.0;
// An edge beside one that is this much stronger is not seen.
const SMAA_OVERSHADOWED = 2.0;

// Components as the eye sees them: those of light by their square root.
fn smaa_color(source: texture_2d<f32>, p: vec2i, is_light: bool) -> vec3f {
    let color = max(texel(source, p).rgb, vec3f());
    return select(color, sqrt(color), vec3<bool>(is_light));
}

fn smaa_apart(a: vec3f, b: vec3f) -> f32 {
    let apart = abs(a - b);
    return max(apart.r, max(apart.g, apart.b));
}

// 1 where the pixel differs from the one to its left (x) and from the one above it (y).
fn smaa_find(source: texture_2d<f32>, p: vec2i, params: Smaa, is_light: bool) -> vec4f {
    let right = vec2i(1, 0);
    let down = vec2i(0, 1);
    let color = smaa_color(source, p, is_light);
    let before = smaa_color(source, p - right, is_light);
    let above = smaa_color(source, p - down, is_light);
    let apart = vec2f(smaa_apart(color, before), smaa_apart(color, above));
    let found = step(vec2f(params.threshold), apart);
    if all(found == SMAA_NONE) { return vec4f(); }
    let behind = vec2f(
        smaa_apart(color, smaa_color(source, p + right, is_light)),
        smaa_apart(color, smaa_color(source, p + down, is_light)),
    );
    let beyond = vec2f(
        smaa_apart(before, smaa_color(source, p - 2 * right, is_light)),
        smaa_apart(above, smaa_color(source, p - 2 * down, is_light)),
    );
    let strongest = max(apart, max(behind, beyond));
    return vec4f(found * step(vec2f(max(strongest.x, strongest.y)), SMAA_OVERSHADOWED * apart), 0.0, 1.0);
}

fn smaa_edges(source: texture_2d<f32>, at: Point, params: Smaa) -> vec4f {
    return smaa_find(source, at.pixel, params, false);
}

fn smaa_edges_light(source: texture_2d<f32>, at: Point, params: Smaa) -> vec4f {
    return smaa_find(source, at.pixel, params, true);
}

// The edges of a pixel; there are none outside of the image.
fn smaa_edge(edges: texture_2d<f32>, p: vec2i) -> vec2f {
    let is_inside = all(p >= vec2i()) && all(p < vec2i(textureDimensions(edges)));
    if !is_inside { return SMAA_NONE; }
    return texel(edges, p).xy;
}

// The edge of a pixel that crosses the direction of a line (x), and the one on the line (y).
fn smaa_turned(edges: texture_2d<f32>, p: vec2i, line: SmaaLine) -> vec2f {
    let edge = smaa_edge(edges, p);
    return select(edge, edge.yx, vec2<bool>(line.along.x == 0));
}

// Follows a line from a pixel to one side (-1 or 1) until it stops or an edge crosses it.
fn smaa_end(edges: texture_2d<f32>, p: vec2i, line: SmaaLine, side: i32, reach: i32) -> SmaaEnd {
    var end = SmaaEnd(0.0, p + max(side, 0) * line.along, 0.0, 0.0);
    var here = smaa_turned(edges, end.place, line);
    for (var n = 0; n <= reach; n++) {
        let next = smaa_turned(edges, end.place + side * line.along, line);
        end.distance = f32(n);
        end.before = smaa_turned(edges, end.place - line.across, line).x;
        end.behind = here.x;
        // The pixel after the last is behind its border to the one side, and before it to the other.
        let goes_on = select(next.y, here.y, side > 0);
        if end.before + end.behind > 0.0 || goes_on == 0.0 || n == reach { break; }
        end.place += side * line.along;
        here = next;
    }
    return end;
}

// The mean height over the pixel whose near border is `near` pixels from an end: the line falls from 1 at the end to 0
// in the middle.
fn smaa_fall(near: f32, length: f32) -> f32 {
    let first = min(near, 0.5 * length);
    let last = min(near + 1.0, 0.5 * length);
    return (last - first) - (last * last - first * first) / length;
}

fn smaa_rounded(area: f32, length: f32) -> f32 {
    return mix(sqrt(0.5 * area), area, min(length / SMAA_ROUND, 1.0));
}

// The factor of the blend near an end whose crossing edge is longer than a step: a real corner stays sharp.
fn smaa_sharpness(edges: texture_2d<f32>, end: SmaaEnd, line: SmaaLine) -> vec2f {
    return vec2f(
        smaa_turned(edges, end.place + line.across, line).x,
        smaa_turned(edges, end.place - 2 * line.across, line).x,
    );
}

// The shares of a pixel that belong to the other side of its line (x), and of the pixel before the line (y). The true
// edge is drawn from end to end: half a pixel to the side on which an edge goes on there.
fn smaa_line(edges: texture_2d<f32>, p: vec2i, line: SmaaLine, params: Smaa) -> vec2f {
    let first = smaa_end(edges, p, line, -1, params.reach);
    let second = smaa_end(edges, p, line, 1, params.reach);
    var heights = vec2f(first.before - first.behind, second.before - second.behind);
    // Where edges go on to both sides, the line is taken to continue against the other end.
    let is_both = vec2f(first.before * first.behind, second.before * second.behind);
    heights -= is_both * heights.yx;
    let length = first.distance + second.distance + 1.0;
    var areas = 0.5 * vec2f(smaa_fall(first.distance, length), smaa_fall(second.distance, length));
    if heights.x == heights.y {
        areas = vec2f(smaa_rounded(areas.x, length), smaa_rounded(areas.y, length));
    }
    let shares = vec2f(dot(areas, max(-heights, SMAA_NONE)), dot(areas, max(heights, SMAA_NONE)));
    let is_near = vec2f(
        select(0.0, 1.0, first.distance <= second.distance),
        select(0.0, 1.0, second.distance <= first.distance),
    );
    let held = (1.0 - params.corners) * is_near / (is_near.x + is_near.y);
    let kept = 1.0 - held.x * smaa_sharpness(edges, first, line) - held.y * smaa_sharpness(edges, second, line);
    return shares * clamp(kept, SMAA_NONE, vec2f(1.0));
}

// The share of the unit square at `corner` that lies to the right of the way between two places, y downwards.
fn smaa_share(start: vec2f, end: vec2f, corner: vec2f) -> f32 {
    let normal = vec2f(end.y - start.y, start.x - end.x);
    let extent = abs(normal.x) + abs(normal.y);
    let depth = clamp(dot(normal, corner + 0.5 - 0.5 * (start + end)) / extent + 0.5, 0.0, 1.0);
    let least = min(depth, 1.0 - depth);
    let narrow = min(abs(normal.x), abs(normal.y)) / extent;
    let triangle = least * least / max(2.0 * narrow * (1.0 - narrow), 1e-6);
    let area = select((least - 0.5 * narrow) / (1.0 - narrow), triangle, least < narrow);
    return select(area, 1.0 - area, depth > 0.5);
}

// The beginning of a diagonal, on the staircase's corners: `kind` is 1 for an edge that goes on to one side, 2 to the
// other, 3 to both and 0 to none. The last two leave two possibilities, of which the mean is taken.
fn smaa_corner(kind: i32, is_open: bool, is_second: bool) -> vec2f {
    let inner = vec2f(1.0, 0.0);
    if kind == 1 || (kind != 2 && is_second) { return inner; }
    return select(vec2f(0.0), vec2f(1.0), kind >= 2 || is_open);
}

// The shares of a pixel and of the one before it that a diagonal takes, by the steps to both of its ends.
fn smaa_diagonal_area(steps: vec2i, kinds: vec2i) -> vec2f {
    let length = f32(steps.x + steps.y + 1);
    let pixel = vec2f(1.0, 0.0) + f32(steps.x);
    // At the second end the sides are exchanged.
    let last = select(kinds.y, 3 - kinds.y, kinds.y == 1 || kinds.y == 2);
    let is_open = kinds.x + kinds.y == 0;
    var shares = vec2f();
    for (var k = 0; k < 2; k++) {
        let start = smaa_corner(kinds.x, is_open, k == 1);
        let end = smaa_corner(last, is_open, k == 1) + length;
        let own = smaa_share(start, end, pixel);
        let other = smaa_share(start, end, pixel + vec2f(0.0, 1.0));
        shares += 0.5 * vec2f(1.0 - own, other);
    }
    return shares;
}

// Follows a staircase from a pixel. Its steps are the edges of each pixel, or for the other diagonal the edge above
// each pixel and the one to its right.
fn smaa_staircase(edges: texture_2d<f32>, p: vec2i, way: vec2i, reach: i32) -> SmaaDiagonal {
    let shift = vec2i(select(0, 1, way.x == way.y), 0);
    var found = SmaaDiagonal(0, false, SMAA_NONE);
    for (var n = 1; n <= reach; n++) {
        let pixel = p + n * way;
        found.last = vec2f(smaa_edge(edges, pixel + shift).x, smaa_edge(edges, pixel).y);
        if found.last.x + found.last.y < 2.0 {
            found.ends = true;
            break;
        }
        found.steps = n;
    }
    return found;
}

// The blend weights of a diagonal of a row's pixel: up to the right, or down to the right.
fn smaa_diagonal(edges: texture_2d<f32>, p: vec2i, rises: bool, params: Smaa) -> vec2f {
    let slope = select(1, -1, rises);
    let right = vec2i(1, 0);
    // The side on which the staircase goes on from the pixel only if the upright edge of the pixel is there.
    let upright = smaa_edge(edges, p + select(right, vec2i(), rises)).x > 0.0;
    var left = SmaaDiagonal(0, true, SMAA_NONE);
    var far = SmaaDiagonal(0, true, SMAA_NONE);
    if upright || !rises { left = smaa_staircase(edges, p, vec2i(-1, -slope), params.diagonal_reach); }
    if upright || rises { far = smaa_staircase(edges, p, vec2i(1, slope), params.diagonal_reach); }
    if rises && upright { left.steps += i32(left.last.y); }
    if !rises && upright { far.steps += i32(far.last.y); }
    if left.steps + far.steps < 3 { return SMAA_NONE; }
    let start = p + left.steps * vec2i(-1, -slope);
    let end = p + far.steps * vec2i(1, slope);
    let before = vec2f(
        smaa_edge(edges, start - right).y,
        smaa_edge(edges, start + select(vec2i(0, -1), vec2i(), rises)).x,
    );
    let behind = vec2f(
        smaa_edge(edges, end + right).y,
        smaa_edge(edges, end + select(right, vec2i(1, -1), rises)).x,
    );
    let kinds = vec2i(vec2f(2.0 * before.x + before.y, 2.0 * behind.x + behind.y));
    let known = select(vec2i(), kinds, vec2<bool>(left.ends, far.ends));
    return smaa_diagonal_area(vec2i(left.steps, far.steps), known);
}

// The shares that are mixed into a pixel from the one above it (x), into that one from the pixel (y), and the same for
// the pixel to the left (z, w).
fn smaa_weights(edges: texture_2d<f32>, at: Point, params: Smaa) -> vec4f {
    let p = at.pixel;
    let edge = smaa_edge(edges, p);
    var shares = vec4f();
    var is_diagonal = false;
    if edge.y > 0.0 {
        if params.diagonal_reach > 0 {
            let rising = smaa_diagonal(edges, p, true, params);
            let falling = smaa_diagonal(edges, p, false, params);
            shares = vec4f(rising + falling.yx, 0.0, 0.0);
            is_diagonal = shares.x + shares.y > 0.0;
        }
        if !is_diagonal {
            shares = vec4f(smaa_line(edges, p, SmaaLine(vec2i(1, 0), vec2i(0, 1)), params), 0.0, 0.0);
        }
    }
    if edge.x > 0.0 && !is_diagonal {
        let line = smaa_line(edges, p, SmaaLine(vec2i(0, 1), vec2i(1, 0)), params);
        shares = vec4f(shares.xy, line);
    }
    return clamp(shares, vec4f(), vec4f(1.0));
}

// Mixes a pixel with those beside it, on the axis on which more is to be mixed.
fn smaa(source: texture_2d<f32>, weights: texture_2d<f32>, at: Point) -> vec4f {
    let p = at.pixel;
    let last = vec2i(textureDimensions(weights)) - 1;
    let own = texel(weights, p);
    let right = select(texel(weights, p + vec2i(1, 0)).w, 0.0, p.x == last.x);
    let below = select(texel(weights, p + vec2i(0, 1)).y, 0.0, p.y == last.y);
    let across = vec2f(own.z, right);
    let down = vec2f(own.x, below);
    let color = texel(source, p);
    let is_across = max(across.x, across.y) > max(down.x, down.y);
    let shares = select(down, across, vec2<bool>(is_across));
    let sum = shares.x + shares.y;
    if sum < 1e-5 { return color; }
    let step = select(vec2i(0, 1), vec2i(1, 0), vec2<bool>(is_across));
    let before = mix(color, texel(source, p - step), shares.x);
    let behind = mix(color, texel(source, p + step), shares.y);
    return (shares.x * before + shares.y * behind) / sum;
}
