// One section per curve: the curve for light of 0 or more, and its kernel.
import afterimage::color::{brightest, luminance};
import afterimage::math::{mean3, power, power3, smooth_step, soft_floor};
import afterimage::oklab::{
    OklabLine, oklab, oklab_at, oklab_certainty, oklab_deviation, oklab_line, oklab_of_light, oklab_share, oklab_turn,
};
import afterimage::transfer::{pq_decode, pq_encode};

struct ToneMap {
    enter0: vec4f,     // rows: Rec.709 to the working space
    enter1: vec4f,
    enter2: vec4f,
    leave0: vec4f,     // the working space to the primaries of the display
    leave1: vec4f,
    leave2: vec4f,
    light_lms0: vec4f, // Rec.709 to the cone responses of Oklab
    light_lms1: vec4f,
    light_lms2: vec4f,
    to_lms0: vec4f,    // the primaries of the display to the cone responses
    to_lms1: vec4f,
    to_lms2: vec4f,
    from_lms0: vec4f,  // and back
    from_lms1: vec4f,
    from_lms2: vec4f,
    light_scale: f32,
    path_to_white: f32, // the share of the mean that the channels of bright light get
    keep_hue: f32,
    compress: f32,     // 1: colors are compressed into the gamut, 0: they are clipped
    gamut_knee: f32,
    peak: f32,
    peak_lightness: f32,
    white_level: f32,
    exposure: f32,
    contrast: f32,
    linear_start: f32,
    toe: f32,
    pedestal: f32,
    shoulder: vec4f,   // Uchimura: start, limit, limit minus start, steepness
    look: vec4f,       // AgX: slope and power
    saturation: f32,
    gt7: vec4f,        // GT7: peak, then a, b, c of a + b * exp(c * x) above the linear part
    gt7_intensity: f32,
    aces2: vec2f,      // ACES 2 tone scale: factor and offset
    agx_hdr: vec4f,    // AgX for HDR: toe, slope, rise, white
}

// --- Conversion to the working space ---

// True if the working space is that of the image. The rows are then the identity.
const TONE_MAP_SAME_SPACE: bool = false;
// True if colors outside of the gamut are clipped. The search for its border is much for a driver to compile.
const TONE_MAP_CLIPS: bool = false;

fn tone_map_rows(row0: vec4f, row1: vec4f, row2: vec4f, v: vec3f) -> vec3f {
    return vec3f(dot(row0.xyz, v), dot(row1.xyz, v), dot(row2.xyz, v));
}

// All channels of bright light get a share of their mean, so that a curve per channel makes white of every light.
fn tone_map_whitened(v: vec3f, params: ToneMap) -> vec3f {
    if TONE_MAP_CLIPS { return max(v, vec3f(0.0)); }
    let mean = mean3(max(v, vec3f(0.0)));
    return soft_floor(v, params.path_to_white * mean * (mean / (params.peak + mean)));
}

fn tone_map_enter(source: vec4f, params: ToneMap) -> vec3f {
    if TONE_MAP_SAME_SPACE { return tone_map_whitened(source.rgb * params.light_scale, params); }
    let inside = tone_map_rows(params.enter0, params.enter1, params.enter2, source.rgb);
    return tone_map_whitened(inside * params.light_scale, params);
}

fn tone_map_leave(v: vec3f, params: ToneMap) -> vec3f {
    if TONE_MAP_SAME_SPACE { return v; }
    return tone_map_rows(params.leave0, params.leave1, params.leave2, v);
}

// --- Hue and gamut, in Oklab ---

fn tone_map_from_lms(lms: vec3f, params: ToneMap) -> vec3f {
    return tone_map_rows(params.from_lms0, params.from_lms1, params.from_lms2, lms);
}

// Colors of all shares of this chroma at one lightness.
fn tone_map_line(lightness: f32, chroma: vec2f, params: ToneMap) -> OklabLine {
    let of_lightness = chroma / max(lightness, 1e-6);
    let k = oklab_deviation(of_lightness);
    let k2 = k * k;
    return oklab_line(
        3.0 * tone_map_from_lms(k, params),
        3.0 * tone_map_from_lms(k2, params),
        tone_map_from_lms(k2 * k, params),
        length(of_lightness),
    );
}

// The chroma that is lost is made up for by brightness, within the peak: colorful light looks brighter than its
// lightness (Helmholtz and Kohlrausch).
fn tone_map_compressed(lightness: f32, chroma: vec2f, params: ToneMap) -> vec3f {
    let l = clamp(lightness, 0.0, params.peak_lightness);
    let gray = l * l * l;
    let line = tone_map_line(l, chroma, params);
    let share = oklab_share(line, params.peak / max(gray, 1e-30), max(params.gamut_knee, 1e-3));
    let rgb = gray * max(oklab_at(line, vec3f(share)), vec3f(0.0));
    return rgb * (1.0 + (1.0 - share) * max(1.0 - brightest(rgb) / params.peak, 0.0));
}

fn tone_map_result(mapped: vec3f, source: vec4f, params: ToneMap) -> vec4f {
    var rgb = tone_map_leave(mapped, params);
    let compresses = !TONE_MAP_CLIPS && params.compress > 0.0;
    if params.keep_hue > 0.0 || compresses {
        let lab = oklab(tone_map_rows(params.to_lms0, params.to_lms1, params.to_lms2, rgb));
        let light = tone_map_rows(params.light_lms0, params.light_lms1, params.light_lms2, source.rgb);
        let chroma = oklab_turn(lab.yz, oklab_of_light(light).yz, params.keep_hue * oklab_certainty(light));
        if compresses {
            rgb = tone_map_compressed(lab.x, chroma, params);
        } else {
            let roots = lab.x + oklab_deviation(chroma);
            rgb = tone_map_from_lms(roots * roots * roots, params);
        }
    }
    return vec4f(clamp(rgb, vec3f(0.0), vec3f(params.peak)), source.a);
}

// --- None ---

fn tone_map_none(source: vec4f, params: ToneMap) -> vec4f {
    return tone_map_result(tone_map_enter(source, params), source, params);
}

// --- Reinhard ---

fn tone_map_reinhard_curve(v: vec3f) -> vec3f {
    return v / (1.0 + v);
}

fn tone_map_reinhard(source: vec4f, params: ToneMap) -> vec4f {
    return tone_map_result(tone_map_reinhard_curve(tone_map_enter(source, params)), source, params);
}

// --- Reinhard, extended: per channel, and by luminance without a division by it ---

fn tone_map_reinhard_extended_curve(v: vec3f, params: ToneMap) -> vec3f {
    return v * ((1.0 + v / (params.white_level * params.white_level)) / (1.0 + v));
}

fn tone_map_reinhard_luminance_curve(v: vec3f, params: ToneMap) -> vec3f {
    let y = luminance(v);
    return v * ((1.0 + y / (params.white_level * params.white_level)) / (1.0 + y));
}

fn tone_map_reinhard_extended(source: vec4f, params: ToneMap) -> vec4f {
    return tone_map_result(tone_map_reinhard_extended_curve(tone_map_enter(source, params), params), source, params);
}

fn tone_map_reinhard_luminance(source: vec4f, params: ToneMap) -> vec4f {
    return tone_map_result(tone_map_reinhard_luminance_curve(tone_map_enter(source, params), params), source, params);
}

// --- Exponential ---

// 1 - exp(-x), by its series where the difference would cancel.
fn tone_map_exponential_curve(v: vec3f, params: ToneMap) -> vec3f {
    let x = v * params.exposure;
    let series = x * (1.0 - x * (1.0 / 2.0 - x * (1.0 / 6.0 - x / 24.0)));
    return select(1.0 - exp(-min(x, vec3f(80.0))), series, x < vec3f(0.03));
}

fn tone_map_exponential(source: vec4f, params: ToneMap) -> vec4f {
    return tone_map_result(tone_map_exponential_curve(tone_map_enter(source, params), params), source, params);
}

// --- The tone scale of ACES 2.0 ---

fn tone_map_aces2_curve(v: vec3f, params: ToneMap) -> vec3f {
    let f = params.aces2.x * power3(v / (v + params.aces2.y), 1.15);
    return f * f / (f + 0.04);
}

fn tone_map_aces2(source: vec4f, params: ToneMap) -> vec4f {
    return tone_map_result(tone_map_aces2_curve(tone_map_enter(source, params), params), source, params);
}

// --- Narkowicz's fit of ACES 1 ---

fn tone_map_narkowicz_curve(v: vec3f) -> vec3f {
    return min(v * (2.51 * v + 0.03) / (v * (2.43 * v + 0.59) + 0.14), vec3f(1.0));
}

fn tone_map_narkowicz(source: vec4f, params: ToneMap) -> vec4f {
    return tone_map_result(tone_map_narkowicz_curve(tone_map_enter(source, params)), source, params);
}

// --- Hill's fit of ACES 1: the matrices replace the conversion to and from the working space ---

fn tone_map_hill_curve(v: vec3f) -> vec3f {
    return (v * (v + 0.0245786) - 0.000090537) / (v * (0.983729 * v + 0.4329510) + 0.238081);
}

fn tone_map_hill(source: vec4f, params: ToneMap) -> vec4f {
    return tone_map_result(tone_map_hill_curve(tone_map_enter(source, params)), source, params);
}

// --- Hable: Uncharted 2's curve of 2x over its value at 11.2, with the offset at black folded in ---

fn tone_map_hable_curve(v: vec3f) -> vec3f {
    let x = 2.0 * v;
    let y = x * (0.14 * x + 0.016666667) / (x * (0.15 * x + 0.5) + 0.06);
    return min(y * 1.3790642, vec3f(1.0));
}

fn tone_map_hable(source: vec4f, params: ToneMap) -> vec4f {
    return tone_map_result(tone_map_hable_curve(tone_map_enter(source, params)), source, params);
}

// --- Uchimura ---

fn tone_map_uchimura_channel(x: f32, params: ToneMap) -> f32 {
    let m = params.linear_start;
    let toe = m * power(min(x, m) / m, params.toe) + params.pedestal;
    let straight = m + params.contrast * (x - m);
    let beyond = max(x - params.shoulder.x, 0.0);
    let shoulder = params.shoulder.y - params.shoulder.z * exp(-min(params.shoulder.w * beyond, 80.0));
    let blended = mix(toe, straight, smooth_step(0.0, m, x));
    return max(select(blended, shoulder, x >= params.shoulder.x), 0.0);
}

fn tone_map_uchimura_curve(v: vec3f, params: ToneMap) -> vec3f {
    return vec3f(
        tone_map_uchimura_channel(v.r, params),
        tone_map_uchimura_channel(v.g, params),
        tone_map_uchimura_channel(v.b, params),
    );
}

fn tone_map_uchimura(source: vec4f, params: ToneMap) -> vec4f {
    return tone_map_result(tone_map_uchimura_curve(tone_map_enter(source, params), params), source, params);
}

// --- Khronos PBR Neutral: below 0.8 the color itself minus the Fresnel offset of 0.04 ---

fn tone_map_khronos_neutral_curve(v: vec3f) -> vec3f {
    let least = min(v.r, min(v.g, v.b));
    let offset = select(0.04, least - 6.25 * least * least, least < 0.08);
    let c = v - offset;
    let peak = brightest(c);
    let over = max(peak - 0.76, 0.0);
    let pressed = 1.0 - 0.24 * 0.24 / (over + 0.24);
    let gray = 1.0 - 1.0 / (0.15 * max(peak - pressed, 0.0) + 1.0);
    return select(mix(c * (pressed / max(peak, 0.76)), vec3f(pressed), gray), c, peak < 0.76);
}

fn tone_map_khronos_neutral(source: vec4f, params: ToneMap) -> vec4f {
    return tone_map_result(tone_map_khronos_neutral_curve(tone_map_enter(source, params)), source, params);
}

// --- AgX ---

// Position of light between ten stops below middle gray (0) and 6.5 stops above (1), after the inset matrix.
fn tone_map_agx_log(v: vec3f) -> vec3f {
    let inset = vec3f(
        dot(v, vec3f(0.842479062253, 0.078433600000, 0.079223745148)),
        dot(v, vec3f(0.042328242261, 0.878468636470, 0.079166127461)),
        dot(v, vec3f(0.042375654906, 0.078433600000, 0.879142973793)),
    );
    return clamp((log2(max(inset, vec3f(1e-10))) + 12.473931188) / 16.5, vec3f(0.0), vec3f(1.0));
}

const TONE_MAP_AGX_TOE: f32 = 0.5122773822930714;
const TONE_MAP_AGX_SHOULDER: f32 = 0.5414641562781497;

// Two hyperbola-like arms of slope 2 at the pivot (10 / 16.5, 0.5), toe of power 3, shoulder of power 3.25. The scale
// of each arm makes it end at 0 and at 1.
fn tone_map_agx_arm(reach: f32, scale: f32, exponent: f32) -> f32 {
    let u = 2.0 * reach / scale;
    return scale * u / power(1.0 + power(u, exponent), 1.0 / exponent);
}

fn tone_map_agx_sigmoid(t: f32) -> f32 {
    let past = t - 0.60606060606;
    let toe = 0.5 - tone_map_agx_arm(max(-past, 0.0), TONE_MAP_AGX_TOE, 3.0);
    let shoulder = 0.5 + tone_map_agx_arm(max(past, 0.0), TONE_MAP_AGX_SHOULDER, 3.25);
    return select(shoulder, toe, past < 0.0);
}

fn tone_map_agx_exact(v: vec3f) -> vec3f {
    let t = tone_map_agx_log(v);
    return vec3f(tone_map_agx_sigmoid(t.r), tone_map_agx_sigmoid(t.g), tone_map_agx_sigmoid(t.b));
}

// A polynomial of degree 6 that maps 0 to 0 and 1 to 1, is monotonic, and has an error of at most 0.0033.
fn tone_map_agx_fitted(v: vec3f) -> vec3f {
    let t = tone_map_agx_log(v);
    let upper = t * (-5.92929872 + t * (30.3767436 + t * (-38.901444 + t * 15.1220424)));
    return t * (0.124105529 + t * (0.207851246 + upper));
}

fn tone_map_agx_look(s: vec3f, params: ToneMap) -> vec3f {
    let powered = power3(s * params.look.xyz, params.look.w);
    return mix(vec3f(luminance(powered)), powered, params.saturation);
}

// The inverse of the inset matrix, then display gamma 2.2 to linear light.
fn tone_map_agx_finish(s: vec3f) -> vec3f {
    let v = vec3f(
        dot(s, vec3f(1.196879005120, -0.098020881140, -0.099029744080)),
        dot(s, vec3f(-0.052896851757, 1.151903129904, -0.098961176845)),
        dot(s, vec3f(-0.052971635514, -0.098043450117, 1.151073672641)),
    );
    return power3(min(v, vec3f(1.0)), 2.2);
}

fn tone_map_agx(source: vec4f, params: ToneMap) -> vec4f {
    let s = tone_map_agx_exact(tone_map_enter(source, params));
    return tone_map_result(tone_map_agx_finish(s), source, params);
}

fn tone_map_agx_looked(source: vec4f, params: ToneMap) -> vec4f {
    let s = tone_map_agx_look(tone_map_agx_exact(tone_map_enter(source, params)), params);
    return tone_map_result(tone_map_agx_finish(s), source, params);
}

fn tone_map_agx_fast(source: vec4f, params: ToneMap) -> vec4f {
    let s = tone_map_agx_fitted(tone_map_enter(source, params));
    return tone_map_result(tone_map_agx_finish(s), source, params);
}

fn tone_map_agx_fast_looked(source: vec4f, params: ToneMap) -> vec4f {
    let s = tone_map_agx_look(tone_map_agx_fitted(tone_map_enter(source, params)), params);
    return tone_map_result(tone_map_agx_finish(s), source, params);
}

// --- AgX for HDR displays: the matrices replace the conversion to and from the working space ---

fn tone_map_agx_hdr_curve(v: vec3f, params: ToneMap) -> vec3f {
    let powered = power3(v, 1.25);
    let above = max(v - 0.18, vec3f(0.0));
    let line = params.agx_hdr.y * above;
    let shoulder = line * (1.0 + above / params.agx_hdr.w) / (1.0 + line / params.agx_hdr.z);
    return select(0.18 + min(shoulder, params.agx_hdr.zzz), powered / (powered + params.agx_hdr.x), v < vec3f(0.18));
}

fn tone_map_agx_hdr(source: vec4f, params: ToneMap) -> vec4f {
    return tone_map_result(tone_map_agx_hdr_curve(tone_map_enter(source, params), params), source, params);
}

// --- GT7: Rec.2020, 1 is 100 cd/m2; the result is in units of its SDR white of 250 cd/m2 ---

fn tone_map_gt7_channel(x: f32, params: ToneMap) -> f32 {
    let toe = 0.538 * power(min(x, 0.538) / 0.538, 1.28);
    let low = mix(toe, x, smooth_step(0.0, 0.538, x));
    let high = params.gt7.y + params.gt7.z * exp(max(params.gt7.w * x, -80.0));
    return select(high, low, x < 0.444 * params.gt7.x);
}

// Light to I, Ct, Cp (ITU-R BT.2100).
fn tone_map_ictcp(v: vec3f) -> vec3f {
    let l = pq_encode(100.0 * dot(v, vec3f(0.412109375, 0.523925781250, 0.063964843750)));
    let m = pq_encode(100.0 * dot(v, vec3f(0.166748046875, 0.720458984375, 0.112792968750)));
    let s = pq_encode(100.0 * dot(v, vec3f(0.024169921875, 0.075439453125, 0.900390625)));
    return vec3f(
        0.5 * (l + m),
        dot(vec3f(l, m, s), vec3f(1.61376953125, -3.323486328125, 1.709716796875)),
        dot(vec3f(l, m, s), vec3f(4.378173828125, -4.245605468750, -0.132568359375)),
    );
}

// The published operator ends at 10000 cd/m2 here, and only here.
fn tone_map_from_ictcp(v: vec3f) -> vec3f {
    let l = 0.01 * pq_decode(min(v.x + 0.008609037038 * v.y + 0.111029625003 * v.z, 1.0));
    let m = 0.01 * pq_decode(min(v.x - 0.008609037038 * v.y - 0.111029625003 * v.z, 1.0));
    let s = 0.01 * pq_decode(min(v.x + 0.560031335711 * v.y - 0.320627174987 * v.z, 1.0));
    let rgb = vec3f(
        dot(vec3f(l, m, s), vec3f(3.436606694333, -2.506452118656, 0.069845424323)),
        dot(vec3f(l, m, s), vec3f(-0.791329555599, 1.983600451792, -0.192270896193)),
        dot(vec3f(l, m, s), vec3f(-0.025949899691, -0.098913714712, 1.124863614402)),
    );
    return max(rgb, vec3f(0.0));
}

// The curve per channel, which shifts hues, blended with the same intensity in the hue of the source. Chroma fades near
// the peak.
fn tone_map_gt7_curve(v: vec3f, params: ToneMap) -> vec3f {
    let skewed = vec3f(
        tone_map_gt7_channel(v.r, params),
        tone_map_gt7_channel(v.g, params),
        tone_map_gt7_channel(v.b, params),
    );
    let own = tone_map_ictcp(v);
    let fade = 1.0 - smooth_step(0.98, 1.16, own.x / params.gt7_intensity);
    let kept = tone_map_from_ictcp(vec3f(tone_map_ictcp(skewed).x, own.yz * fade));
    return min(mix(skewed, kept, 0.6), vec3f(params.gt7.x)) / 2.5;
}

fn tone_map_gt7(source: vec4f, params: ToneMap) -> vec4f {
    return tone_map_result(tone_map_gt7_curve(tone_map_enter(source, params), params), source, params);
}
