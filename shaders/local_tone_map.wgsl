// Local tone mapping: less contrast between regions, equal or more contrast within them. The base is a share of the
// bilateral grid plus a share of the wide Gaussian: the Gaussian has halos at edges, the grid ripples a little on
// smooth gradients.
import afterimage::color::level_luminance;
import afterimage::grade::bounded_scene;
import afterimage::math::smooth_step;

struct LocalToneMap {
    contrast: f32,
    span: f32,
    detail: f32,
    midpoint: f32,
    share: f32,
    lo: f32,
    hi: f32,
}

const LOCAL_TONE_MAP_MAX_STOPS: f32 = 16.0;
// Between these two weights the base changes from the Gaussian to the grid: below the lower one no sampled pixel was
// near enough. A cell that contains all of its pixels has the weight 512.
const LOCAL_TONE_MAP_EMPTY: f32 = 0.0025;
const LOCAL_TONE_MAP_KNOWN: f32 = 0.01;

fn local_tone_map_level(rgb: vec3f, params: LocalToneMap) -> f32 {
    return clamp(log2(max(level_luminance(rgb), 1e-30)), params.lo, params.hi);
}

// The parameters for a scene whose luminance spans `range` stops. Before the first metered frame that is 0, and nothing
// is compressed.
fn local_tone_map_fitted(range: f32, params: LocalToneMap) -> LocalToneMap {
    var fitted = params;
    fitted.contrast = clamp(params.span / max(range, 0.015625), min(params.contrast, 1.0), max(params.contrast, 1.0));
    return fitted;
}

// o = midpoint + contrast (base - midpoint) + detail (level - base), as a factor 2^(o - level). The chromaticity stays
// the same. Here and below `fma` is written out: where a compiler may choose, an NVIDIA driver chose otherwise in the
// module of a band, and the last bits were not those of the whole picture.
fn local_tone_map_apply(source: vec4f, level: f32, base: f32, params: LocalToneMap) -> vec4f {
    let near = fma(params.contrast, base - params.midpoint, params.midpoint);
    let mapped = fma(params.detail, level - base, near);
    let gain = exp2(clamp(mapped - level, -LOCAL_TONE_MAP_MAX_STOPS, LOCAL_TONE_MAP_MAX_STOPS));
    return vec4f(bounded_scene(source.rgb * gain), source.a);
}

// The base from the grid, or `otherwise` where the grid is empty. The grid stores its own range.
fn local_tone_map_slice(grid: texture_3d<f32>, s: sampler, uv: vec2f, level: f32, otherwise: f32) -> f32 {
    let range = texel3(grid, vec3i(0)).zw;
    let sums = tap3(grid, s, vec3f(uv, (level - range.x) / max(range.y - range.x, 0.015625)));
    let base = fma(sums.x, 1.0 / max(sums.y, 1e-6), 0.5 * (range.x + range.y));
    let known = smooth_step(LOCAL_TONE_MAP_EMPTY, LOCAL_TONE_MAP_KNOWN, sums.y);
    return fma(known, base - otherwise, otherwise);
}

fn local_tone_map(
    source: vec4f,
    grid: texture_3d<f32>,
    grid_sampler: sampler,
    gaussian: texture_2d<f32>,
    gaussian_sampler: sampler,
    at: Point,
    params: LocalToneMap,
) -> vec4f {
    let level = local_tone_map_level(source.rgb, params);
    let wide = tap(gaussian, gaussian_sampler, at.uv).r;
    let near = local_tone_map_slice(grid, grid_sampler, at.uv, level, wide);
    return local_tone_map_apply(source, level, mix(wide, near, params.share), params);
}

fn local_tone_map_grid(
    source: vec4f,
    grid: texture_3d<f32>,
    grid_sampler: sampler,
    at: Point,
    params: LocalToneMap,
) -> vec4f {
    let level = local_tone_map_level(source.rgb, params);
    return local_tone_map_apply(source, level, local_tone_map_slice(grid, grid_sampler, at.uv, level, level), params);
}

fn local_tone_map_gaussian(
    source: vec4f,
    gaussian: texture_2d<f32>,
    gaussian_sampler: sampler,
    at: Point,
    params: LocalToneMap,
) -> vec4f {
    let wide = tap(gaussian, gaussian_sampler, at.uv).r;
    return local_tone_map_apply(source, local_tone_map_level(source.rgb, params), wide, params);
}

// With equal contrast and detail the base cancels out.
fn local_tone_map_global(source: vec4f, params: LocalToneMap) -> vec4f {
    let level = local_tone_map_level(source.rgb, params);
    return local_tone_map_apply(source, level, level, params);
}

fn local_tone_map_ranged(
    source: vec4f,
    grid: texture_3d<f32>,
    grid_sampler: sampler,
    gaussian: texture_2d<f32>,
    gaussian_sampler: sampler,
    range: f32,
    at: Point,
    params: LocalToneMap,
) -> vec4f {
    let fitted = local_tone_map_fitted(range, params);
    return local_tone_map(source, grid, grid_sampler, gaussian, gaussian_sampler, at, fitted);
}

fn local_tone_map_grid_ranged(
    source: vec4f,
    grid: texture_3d<f32>,
    grid_sampler: sampler,
    range: f32,
    at: Point,
    params: LocalToneMap,
) -> vec4f {
    return local_tone_map_grid(source, grid, grid_sampler, at, local_tone_map_fitted(range, params));
}

fn local_tone_map_gaussian_ranged(
    source: vec4f,
    gaussian: texture_2d<f32>,
    gaussian_sampler: sampler,
    range: f32,
    at: Point,
    params: LocalToneMap,
) -> vec4f {
    return local_tone_map_gaussian(source, gaussian, gaussian_sampler, at, local_tone_map_fitted(range, params));
}

fn local_tone_map_global_ranged(source: vec4f, range: f32, params: LocalToneMap) -> vec4f {
    return local_tone_map_global(source, local_tone_map_fitted(range, params));
}
