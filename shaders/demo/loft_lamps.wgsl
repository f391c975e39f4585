// The brightness of the loft's lights: linear Rec.709 radiance in units in which the room's grays are 0.02 to 0.3.
// Every level is for a range of 18 stops; `loft_lamps` scales them for another.
import afterimage::noise::noise;

// Elevation twelve degrees, twenty-four degrees to the left of the window's axis.
const LOFT_SUN = vec3f(-0.3978485, 0.2079117, -0.8935823);
const LOFT_SUN_RADIUS: f32 = 0.00465; // half of 0.533 degrees
const LOFT_SUNLIGHT = vec3f(290.0, 186.0, 98.0);   // irradiance across the beam
// The radiance of the disc follows from the range; that of the real sun is a thousand times the largest half float.
const LOFT_SUN_DISC = vec3f(19000.0, 15900.0, 12200.0);

const LOFT_CYAN = vec3f(0.9, 9.0, 11.0);
const LOFT_MAGENTA = vec3f(12.0, 1.1, 6.5);
const LOFT_AMBER = vec3f(12.0, 4.6, 0.7);

const LOFT_REFERENCE: f32 = 18.0;           // stops

// A point of the sun's disc for a sample of a pixel, `offset` pixels from its center; at the disc's edge beyond 0.55.
fn loft_sun_point(offset: vec2f) -> vec3f {
    let inside = offset * min(1.0, 0.55 / max(length(offset), 1e-6));
    let right = normalize(cross(LOFT_SUN, vec3f(0.0, 1.0, 0.0)));
    let up = cross(right, LOFT_SUN);
    return normalize(LOFT_SUN + (right * inside.x + up * inside.y) * (1.8 * LOFT_SUN_RADIUS));
}

struct LoftLamps {
    time: f32,       // seconds
    sky: f32,
    sunlight: f32,
    sun: f32,
    neon: vec3f,     // cyan ring, magenta ring, amber bar
}

// At every range a light keeps its share of the stops between the room's gray and the disc.
fn loft_lamps(time: f32, range: f32) -> LoftLamps {
    let less = range / LOFT_REFERENCE - 1.0;
    let neon = loft_flicker(time) * exp2(7.0 * less);
    return LoftLamps(time, exp2(6.6 * less), exp2(8.0 * less), exp2(18.0 * less), neon);
}

// The sign flickers; its magenta ring has a loose contact.
fn loft_flicker(time: f32) -> vec3f {
    let hum = 0.97 + 0.03 * sin(time * 37.0);
    let contact = noise(vec2f(time * 11.0, 0.5)) * noise(vec2f(time * 0.7, 7.5));
    return vec3f(hum, 1.0 - 0.75 * smoothstep(0.55, 0.7, contact), 0.5 + 0.5 * hum);
}
