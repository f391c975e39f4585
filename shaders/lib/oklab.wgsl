// Oklab (Ottosson 2020): hue, and a gamut step that keeps it.
import package::math::{mean3, power3, soft_floor};

// The lightness, from the cube roots of the cone responses.
fn oklab_lightness(roots: vec3f) -> f32 {
    return dot(roots, vec3f(0.2104542553, 0.7936177850, -0.0040720468));
}

// The cone responses of Oklab, of any sign, to lightness, a and b.
fn oklab(lms: vec3f) -> vec3f {
    let roots = sign(lms) * power3(abs(lms), 1.0 / 3.0);
    return vec3f(
        oklab_lightness(roots),
        dot(roots, vec3f(1.9779984951, -2.4285922050, 0.4505937099)),
        dot(roots, vec3f(0.0259040371, 0.7827717662, -0.8086757660)),
    );
}

// The share of their mean that all cone responses of a light have, nearly. Without it, the response of the long cones
// vanishes for deep blue, which turns to teal, and next to the blue of Rec.709 chroma jumps, where its gamut has a
// dent.
const OKLAB_LEAST_SHARE: f32 = 0.17;

// Oklab of light, for its hue. The blue of Rec.709 turns by 6.7 degrees toward violet, that of AP1 by 29.
fn oklab_of_light(lms: vec3f) -> vec3f {
    return oklab(soft_floor(lms, OKLAB_LEAST_SHARE * mean3(max(lms, vec3f(0.0)))));
}

// How certain the hue of light is: 1 for all colors of AP1, which have no response below 0; 0 where those below 0
// outweigh the others, and the direction of what remains is that of noise.
fn oklab_certainty(lms: vec3f) -> f32 {
    return max(mean3(lms), 0.0) / max(mean3(max(lms, vec3f(0.0))), 1e-30);
}

// The differences between the cube roots of the cone responses and the lightness.
fn oklab_deviation(chroma: vec2f) -> vec3f {
    return vec3f(
        dot(chroma, vec2f(0.3963377774, 0.2158037573)),
        dot(chroma, vec2f(-0.1055613458, -0.0638541728)),
        dot(chroma, vec2f(-0.0894841775, -1.2914855480)),
    );
}

// Chroma of unchanged amount with a share of the hue of another color. Between hues that are nearly opposite it fades.
fn oklab_turn(chroma: vec2f, other: vec2f, share: f32) -> vec2f {
    let amount = length(chroma);
    let mixed = mix(chroma, other * (amount / max(length(other), 1e-20)), share);
    return mixed * (amount / max(length(mixed), max(0.5 * amount, 1e-20)));
}

// Colors of one lightness and hue. At the share t of the chroma, a channel of RGB is 1 + t * (c1 + t * (c2 + t * c3)),
// in units of the gray of this lightness.
struct OklabLine {
    c1: vec3f,
    c2: vec3f,
    c3: vec3f,
    end: f32, // all larger shares are outside, because of red
}

fn oklab_at(line: OklabLine, t: vec3f) -> vec3f {
    return 1.0 + t * (line.c1 + t * (line.c2 + t * line.c3));
}

// Channels may be below 0 by this much, in units of the gray, and become 0.
const OKLAB_SLACK: f32 = 0.01;
// The gamuts of Rec.709 and Rec.2020 have a dent next to their blue: with more chroma, red falls to 0, or a little
// below it, and rises again. A border at the first crossing would jump by ten codes of 8 bits, from one hue, whose red
// stays above 0, to the next. So where red falls more slowly than this, in units of the gray for a chroma as large as
// the lightness, it counts as if it fell so on. With 0.8, light of Rec.2020 a thousandth apart differs by 4 codes, with
// this by 3; from 1.4 on, the violet of Rec.2020 would have a border that jumps.
const OKLAB_DENT_SLOPE: f32 = 1.2;

// The line through a color with this share of chroma to lightness, from the coefficients of its channels.
fn oklab_line(c1: vec3f, c2: vec3f, c3: vec3f, chroma: f32) -> OklabLine {
    let slope = OKLAB_DENT_SLOPE * chroma;
    let first = c1.r + slope;
    let second = c2.r + sqrt(max(c2.r * c2.r - 3.0 * c3.r * first, 0.0));
    if first >= 0.0 || second <= 0.0 { return OklabLine(c1, c2, c3, 1e30); }
    let bend = -first / second;
    let red = 1.0 + bend * (c1.r + bend * (c2.r + bend * c3.r));
    return OklabLine(c1, c2, c3, bend + max(red + OKLAB_SLACK, 0.0) / slope);
}

// True if no channel is lower than it may be and all are at most `top`.
fn oklab_is_inside(line: OklabLine, t: f32, top: f32) -> bool {
    let v = oklab_at(line, vec3f(t));
    let least = min(v.r, min(v.g, v.b));
    return t <= line.end && least >= -OKLAB_SLACK && max(v.r, max(v.g, v.b)) <= top;
}

// The share of the chroma at which the line leaves the gamut, between two shares of which the second is outside. A step
// of Newton's method for the channels that are outside there; the first of them counts.
fn oklab_crossing(line: OklabLine, inside: f32, outside: f32, top: f32) -> f32 {
    let near = oklab_at(line, vec3f(inside));
    let far = oklab_at(line, vec3f(outside));
    let is_below = far < vec3f(-OKLAB_SLACK);
    let goal = select(vec3f(top), vec3f(-OKLAB_SLACK), is_below);
    let is_out = is_below | (far > vec3f(top));
    let width = outside - inside;
    let share = clamp((goal - near) / select(far - near, vec3f(1.0), far == near), vec3f(0.0), vec3f(1.0));
    let chord = inside + width * share;
    let slope = line.c1 + chord * (2.0 * line.c2 + 3.0 * chord * line.c3);
    let step = (goal - oklab_at(line, chord)) / select(slope, vec3f(1.0), slope == vec3f(0.0));
    let crossing = select(vec3f(outside), clamp(chord + step, vec3f(inside), vec3f(outside)), is_out);
    return min(min(crossing.x, line.end), min(crossing.y, crossing.z));
}

// The share of the chroma at which the line leaves the gamut. The variable u has finer steps near a share of 1. Eight
// halvings separate the crossings of the channels; a step of Newton's method is then as exact as ten more.
fn oklab_border(line: OklabLine, top: f32, knee: f32) -> f32 {
    var low = 0.0;
    var high = 1.0;
    for (var step = 0u; step < 8u; step += 1u) {
        let u = 0.5 * (low + high);
        let inside = oklab_is_inside(line, u / (1.0 - u * (1.0 - knee)), top);
        low = select(low, u, inside);
        high = select(u, high, inside);
    }
    return oklab_crossing(line, low / (1.0 - low * (1.0 - knee)), high / (1.0 - high * (1.0 - knee)), top);
}

// The share of the chroma in the gamut from 0 to `top`. Up to the share `knee`, above 0, of the gamut's chroma nothing
// changes. Beyond it, x/(1+x) compresses the rest, so that a color approaches the border and never passes it.
fn oklab_share(line: OklabLine, top: f32, knee: f32) -> f32 {
    if oklab_is_inside(line, 1.0 / knee, top) { return 1.0; }
    let border = oklab_border(line, top, knee);
    let over = 1.0 - knee * border;
    let rest = 1.0 - knee;
    return min(border * (knee + rest * over / max(rest * border + over, 1e-20)), 1.0);
}
