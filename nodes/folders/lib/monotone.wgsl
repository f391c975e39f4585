// Cubics through points that rise and fall only where the points do: Hermite cubics with the slopes of Fritsch and
// Butland ("A Method for Constructing Local Monotone Piecewise Cubic Interpolants", 1984), which meet the condition of
// Fritsch and Carlson (1980). At the ends, the slopes are those of Moler ("Numerical Computing with MATLAB", 3.6).

// The slope at the point `b` between two others: the harmonic mean of both secants, the nearer one weighted more, or 0
// where the points turn.
fn monotone_slope(a: vec2f, b: vec2f, c: vec2f) -> f32 {
    let before = b.x - a.x;
    let after = c.x - b.x;
    let left = (b.y - a.y) / before;
    let right = (c.y - b.y) / after;
    let weight_left = 2.0 * after + before;
    let weight_right = after + 2.0 * before;
    let sum = weight_left * right + weight_right * left;
    let is_turn = left * right <= 0.0;
    return select(3.0 * (before + after) * left * right / select(sum, 1.0, sum == 0.0), 0.0, is_turn);
}

// The slope at the end `a`, from the next two points: of the parabola through all three, limited so that the cubic
// stays monotone.
fn monotone_end_slope(a: vec2f, b: vec2f, c: vec2f) -> f32 {
    let near = b.x - a.x;
    let far = c.x - b.x;
    let left = (b.y - a.y) / near;
    let right = (c.y - b.y) / far;
    let slope = ((2.0 * near + far) * left - near * right) / (near + far);
    let is_steep = left * right <= 0.0 && abs(slope) > abs(3.0 * left);
    return select(select(slope, 3.0 * left, is_steep), 0.0, slope * left <= 0.0);
}

// The cubic from `a` to `b` with these slopes there. Exact at both.
fn monotone_cubic(a: vec2f, b: vec2f, slope_a: f32, slope_b: f32, x: f32) -> f32 {
    let width = b.x - a.x;
    let t = clamp((x - a.x) / width, 0.0, 1.0);
    let rest = 1.0 - t;
    let bend = rest * slope_a - t * slope_b;
    return a.y * rest * rest * (1.0 + 2.0 * t) + b.y * t * t * (3.0 - 2.0 * t) + width * t * rest * bend;
}

struct MonotonePoints { p0: vec2f, p1: vec2f, p2: vec2f, p3: vec2f, p4: vec2f }

// The least distance of points in x.
const MONOTONE_STEP: f32 = 0.0009765625;

fn monotone_after(p: vec2f, before: vec2f) -> vec2f {
    return vec2f(max(p.x, before.x + MONOTONE_STEP), p.y);
}

// Points that follow each other in x: one that does not lies just after the one before.
fn monotone_points(black: vec2f, shadows: vec2f, middle: vec2f, highlights: vec2f, white: vec2f) -> MonotonePoints {
    let p1 = monotone_after(shadows, black);
    let p2 = monotone_after(middle, p1);
    let p3 = monotone_after(highlights, p2);
    return MonotonePoints(black, p1, p2, p3, monotone_after(white, p3));
}

// The curve through five points that follow each other in x. Beyond the ends, it goes on straight.
fn monotone_curve(p: MonotonePoints, x: f32) -> f32 {
    let first = monotone_end_slope(p.p0, p.p1, p.p2);
    let last = monotone_end_slope(p.p4, p.p3, p.p2);
    if x <= p.p0.x { return p.p0.y + first * (x - p.p0.x); }
    if x >= p.p4.x { return p.p4.y + last * (x - p.p4.x); }
    let second = monotone_slope(p.p0, p.p1, p.p2);
    if x < p.p1.x { return monotone_cubic(p.p0, p.p1, first, second, x); }
    let third = monotone_slope(p.p1, p.p2, p.p3);
    if x < p.p2.x { return monotone_cubic(p.p1, p.p2, second, third, x); }
    let fourth = monotone_slope(p.p2, p.p3, p.p4);
    if x < p.p3.x { return monotone_cubic(p.p2, p.p3, third, fourth, x); }
    return monotone_cubic(p.p3, p.p4, fourth, last, x);
}
