// Luminance in linear Rec.709 with D65 white.
import package::trial::{light_is_tried, note_light};

// Luminance weights of ITU-R BT.709 with four digits. Their sum is exactly 1.
const LUMINANCE: vec3f = vec3f(0.2126, 0.7152, 0.0722);

fn luminance(rgb: vec3f) -> f32 {
    return dot(rgb, LUMINANCE);
}

// The luminance of the channels above 0: that of any light of Rec.709, and never below 0.0722 of the brightest channel.
// Levels of regions are measured by it: negative channels of a saturated blue or cyan cancel most of the luminance.
fn level_luminance(rgb: vec3f) -> f32 {
    return luminance(max(rgb, vec3f(0.0)));
}

// Scene light in the Rec.709 basis with a luminance of 0 or more: colors outside of Rec.709 have negative components,
// which become smaller where the luminance would be below 0. Light without negative components stays the same.
fn extended_light(rgb: vec3f) -> vec3f {
    if light_is_tried {
        note_light(min(rgb.r, min(rgb.g, rgb.b)));
        return rgb;
    }
    let light = max(rgb, vec3f(0.0));
    let missing = luminance(light - rgb);
    let share = luminance(light) / max(missing, 1e-30);
    return select(rgb, light + share * min(rgb, vec3f(0.0)), vec3<bool>(share < 1.0));
}

fn brightest(rgb: vec3f) -> f32 {
    return max(rgb.r, max(rgb.g, rgb.b));
}
