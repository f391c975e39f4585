import afterimage::sanitize::HALF_MAX;

struct LensProfile {
    ptlens: vec3f,
    poly5: vec2f,
    red: vec3f,
    blue: vec3f,
    falloff: vec3f,
    crop: f32,
    add: u32,
    zoom: f32,
}

// The least slope of a function of the distance: steps of Newton's method stay small where it folds the image.
const LENS_PROFILE_SLOPE: f32 = 0.25;
// Places that are farther out count as this far.
const LENS_PROFILE_FARTHEST: f32 = 64.0;
// Green stands where the distortion has it.
const LENS_PROFILE_GREEN: vec3f = vec3f(1.0, 0.0, 0.0);
// The darkest corner: 1/64 of the light.
const LENS_PROFILE_DARKEST: f32 = 0.015625;

// The factor that leads from a distance in the straight image to that in the image of the lens.
fn lens_profile_factor(r: f32, params: LensProfile) -> f32 {
    let p = params.ptlens;
    let s = r * r;
    return 1.0 - p.x - p.y - p.z + r * (p.z + r * (p.y + r * p.x)) + s * (params.poly5.x + s * params.poly5.y);
}

// The slope of the distance times its factor.
fn lens_profile_slope(r: f32, params: LensProfile) -> f32 {
    let p = params.ptlens;
    let s = r * r;
    let ptlens = 1.0 - p.x - p.y - p.z + r * (2.0 * p.z + r * (3.0 * p.y + r * 4.0 * p.x));
    return ptlens + s * (3.0 * params.poly5.x + s * 5.0 * params.poly5.y);
}

// The magnification of a channel.
fn lens_profile_fringe(r: f32, channel: vec3f) -> f32 {
    return channel.x + r * (channel.y + r * channel.z);
}

// The distance in the straight image of what a channel has at a distance in the image of the lens.
fn lens_profile_straight(r: f32, channel: vec3f, params: LensProfile) -> f32 {
    var bent = r;
    for (var i = 0; i < 6; i++) {
        let slope = channel.x + bent * (2.0 * channel.y + bent * 3.0 * channel.z);
        let error = bent * lens_profile_fringe(bent, channel) - r;
        bent = clamp(bent - error / max(slope, LENS_PROFILE_SLOPE), 0.0, LENS_PROFILE_FARTHEST);
    }
    var straight = bent;
    for (var i = 0; i < 8; i++) {
        let error = straight * lens_profile_factor(straight, params) - bent;
        let step = error / max(lens_profile_slope(straight, params), LENS_PROFILE_SLOPE);
        straight = clamp(straight - step, 0.0, LENS_PROFILE_FARTHEST);
    }
    return straight;
}

// One channel and the alpha of the result at a position from the middle, in halves of the shorter side.
fn lens_profile_read(t: texture_2d<f32>, s: sampler, place: vec2f, channel: vec3f, params: LensProfile) -> vec4f {
    let size = vec2f(textureDimensions(t));
    let side = min(size.x, size.y);
    let r = min(length(place) * params.crop, LENS_PROFILE_FARTHEST);
    let is_added = params.add != 0u;
    var scale = 1.0;
    var seen = r;
    if is_added {
        scale = lens_profile_straight(r, channel, params) / max(r, 1e-6);
    } else {
        let bent = lens_profile_factor(r, params);
        scale = bent * lens_profile_fringe(r * bent, channel);
        seen = r * scale;
    }
    scale = clamp(scale, -LENS_PROFILE_FARTHEST, LENS_PROFILE_FARTHEST);
    // The falloff is that of a place in the image of the lens, and its distance is 1 in the corners.
    let way = clamp(seen * side / length(size), 0.0, 4.0);
    let q = way * way;
    let k = params.falloff;
    let light = max(1.0 + q * (k.x + q * (k.y + q * k.z)), LENS_PROFILE_DARKEST);
    let found = tap(t, s, 0.5 + 0.5 * scale * place * side / size);
    return vec4f(found.rgb * select(1.0 / light, light, is_added), found.a);
}

fn lens_profile(source: texture_2d<f32>, source_sampler: sampler, at: Point, params: LensProfile) -> vec4f {
    let own = texel(source, at.pixel);
    let has_fringes = any(params.red != LENS_PROFILE_GREEN) || any(params.blue != LENS_PROFILE_GREEN);
    let bends = any(params.ptlens != vec3f()) || any(params.poly5 != vec2f()) || params.zoom != 1.0;
    if !(has_fringes || bends || any(params.falloff != vec3f())) { return own; }
    let place = (2.0 * at.uv - 1.0) * at.size / (min(at.size.x, at.size.y) * params.zoom);
    let green = lens_profile_read(source, source_sampler, place, LENS_PROFILE_GREEN, params);
    var found = green;
    if has_fringes {
        let red = lens_profile_read(source, source_sampler, place, params.red, params);
        let blue = lens_profile_read(source, source_sampler, place, params.blue, params);
        found = vec4f(red.r, green.g, blue.b, green.a + (red.a - green.a) / 3.0 + (blue.a - green.a) / 3.0);
    }
    return clamp(found, vec4f(-HALF_MAX), vec4f(HALF_MAX));
}
