import afterimage::color::{brightest, luminance};
import afterimage::math::between3;

struct Newsprint {
    cell: f32,
    angle: f32,
    color: u32,
    black: f32,
    ink: vec3f,
    paper: vec3f,
    amount: f32,
}

const NEWSPRINT_PI: f32 = 3.14159265;

// The height h above which cos u + cos v lies in this share of a cell, fitted to the inverse of the integral: the share
// of the result is right within 0.0011.
fn newsprint_level(share: f32) -> f32 {
    let x = abs(1.0 - 2.0 * share);
    let bend = -1.29508 + x * (0.859032 + x * (-1.349367 + x * 0.672083));
    return sign(1.0 - 2.0 * share) * (2.0 * x + x * (1.0 - x) * bend);
}

// The share of a pixel that a screen of dots inks, for ink that covers this share of a cell.
fn newsprint_inked(ink: f32, place: vec2f, cell: f32, degrees: f32) -> f32 {
    let angle = radians(degrees);
    let axis = vec2f(cos(angle), sin(angle));
    let p = 2.0 * NEWSPRINT_PI / cell * vec2f(dot(place, axis), dot(place, vec2f(-axis.y, axis.x)));
    let height = cos(p.x) + cos(p.y) - newsprint_level(ink);
    let slope = 2.0 * NEWSPRINT_PI / cell * length(sin(p));
    let edge = clamp(0.5 + height / max(slope, 0.5 * NEWSPRINT_PI / cell), 0.0, 1.0);
    // Of a dot or a hole that is smaller than a pixel, each pixel at it shows its area.
    let blank = select(0.0, 1.0, ink > 0.5);
    let area = min(ink, 1.0 - ink) * cell * cell;
    return mix(blank, edge, clamp(area, 0.0, 1.0));
}

fn newsprint(source: vec4f, at: Point, params: Newsprint) -> vec4f {
    if params.amount == 0.0 { return source; }
    let cell = max(params.cell * at.size.y, 2.0);
    let place = vec2f(at.pixel) + 0.5 - 0.5 * at.size;
    let light = clamp(source.rgb, vec3f(0.0), vec3f(1.0));
    var print = vec3f();
    if params.color != 0u {
        let black = params.black * (1.0 - brightest(light));
        let inks = 1.0 - light / max(1.0 - black, 1e-6);
        let cyan = newsprint_inked(clamp(inks.x, 0.0, 1.0), place, cell, params.angle + 15.0);
        let magenta = newsprint_inked(clamp(inks.y, 0.0, 1.0), place, cell, params.angle + 75.0);
        let yellow = newsprint_inked(clamp(inks.z, 0.0, 1.0), place, cell, params.angle);
        let left = 1.0 - newsprint_inked(black, place, cell, params.angle + 45.0);
        print = params.paper * left * (1.0 - vec3f(cyan, magenta, yellow));
    } else {
        let inked = newsprint_inked(1.0 - luminance(light), place, cell, params.angle + 45.0);
        print = between3(params.paper, params.ink, inked);
    }
    return vec4f(between3(source.rgb, print, params.amount), source.a);
}
