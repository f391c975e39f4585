import afterimage::cube::{cube_fetched, cube_tetrahedral, cube_trilinear};
import afterimage::grade::bounded;
import afterimage::math::between3;
import afterimage::shaper::shape3;
import afterimage::transfer::srgb_encode3;

struct ColorLut {
    strength: f32,
    line: vec4f,         // the shaper
    shaper_curve: vec4f,
    curve_count: u32,    // entries of the 1-D table
    curve_low: vec3f,    // the domains: (x - low) * scale lies in 0..1
    curve_scale: vec3f,
    cube_low: vec3f,
    cube_scale: vec3f,
}

// The entry of a 1-D table that is stored in several rows.
fn color_lut_entry(curve: texture_2d<f32>, index: u32) -> vec3f {
    let width = textureDimensions(curve).x;
    return texel(curve, vec2i(vec2u(index % width, index / width))).rgb;
}

fn color_lut_curved(curve: texture_2d<f32>, rgb: vec3f, params: ColorLut) -> vec3f {
    let p = clamp((rgb - params.curve_low) * params.curve_scale, vec3f(0.0), vec3f(1.0)) * f32(params.curve_count - 1u);
    let i = vec3u(min(floor(p), vec3f(f32(params.curve_count - 2u))));
    let f = p - vec3f(i);
    return vec3f(
        mix(color_lut_entry(curve, i.r).r, color_lut_entry(curve, i.r + 1u).r, f.r),
        mix(color_lut_entry(curve, i.g).g, color_lut_entry(curve, i.g + 1u).g, f.g),
        mix(color_lut_entry(curve, i.b).b, color_lut_entry(curve, i.b + 1u).b, f.b),
    );
}

fn color_lut_shaped(source: vec4f, params: ColorLut) -> vec3f {
    return shape3(source.rgb, params.line, params.shaper_curve);
}

fn color_lut_srgb(source: vec4f) -> vec3f {
    return srgb_encode3(clamp(source.rgb, vec3f(0.0), vec3f(1.0)));
}

fn color_lut_placed(rgb: vec3f, params: ColorLut) -> vec3f {
    return (rgb - params.cube_low) * params.cube_scale;
}

fn color_lut_mixed(source: vec4f, looked: vec3f, params: ColorLut) -> vec4f {
    return vec4f(bounded(between3(source.rgb, looked, params.strength)), source.a);
}

// --- A 1-D table ---

fn color_lut_curve(source: vec4f, curve: texture_2d<f32>, params: ColorLut) -> vec4f {
    return color_lut_mixed(source, color_lut_curved(curve, color_lut_shaped(source, params), params), params);
}

fn color_lut_curve_srgb(source: vec4f, curve: texture_2d<f32>, params: ColorLut) -> vec4f {
    return color_lut_mixed(source, color_lut_curved(curve, color_lut_srgb(source), params), params);
}

// --- A 3-D table, with three interpolations ---

fn color_lut_trilinear(source: vec4f, cube: texture_3d<f32>, params: ColorLut) -> vec4f {
    let at = color_lut_placed(color_lut_shaped(source, params), params);
    return color_lut_mixed(source, cube_trilinear(cube, at), params);
}

fn color_lut_trilinear_srgb(source: vec4f, cube: texture_3d<f32>, params: ColorLut) -> vec4f {
    let at = color_lut_placed(color_lut_srgb(source), params);
    return color_lut_mixed(source, cube_trilinear(cube, at), params);
}

fn color_lut_fetched(source: vec4f, cube: texture_3d<f32>, cube_sampler: sampler, params: ColorLut) -> vec4f {
    let at = color_lut_placed(color_lut_shaped(source, params), params);
    return color_lut_mixed(source, cube_fetched(cube, cube_sampler, at), params);
}

fn color_lut_fetched_srgb(source: vec4f, cube: texture_3d<f32>, cube_sampler: sampler, params: ColorLut) -> vec4f {
    let at = color_lut_placed(color_lut_srgb(source), params);
    return color_lut_mixed(source, cube_fetched(cube, cube_sampler, at), params);
}

fn color_lut_tetrahedral(source: vec4f, cube: texture_3d<f32>, params: ColorLut) -> vec4f {
    let at = color_lut_placed(color_lut_shaped(source, params), params);
    return color_lut_mixed(source, cube_tetrahedral(cube, at), params);
}

fn color_lut_tetrahedral_srgb(source: vec4f, cube: texture_3d<f32>, params: ColorLut) -> vec4f {
    let at = color_lut_placed(color_lut_srgb(source), params);
    return color_lut_mixed(source, cube_tetrahedral(cube, at), params);
}

// --- A 1-D table before a 3-D table, from one file ---

fn color_lut_both_trilinear(source: vec4f, curve: texture_2d<f32>, cube: texture_3d<f32>, params: ColorLut) -> vec4f {
    let at = color_lut_placed(color_lut_curved(curve, source.rgb, params), params);
    return color_lut_mixed(source, cube_trilinear(cube, at), params);
}

fn color_lut_both_fetched(
    source: vec4f,
    curve: texture_2d<f32>,
    cube: texture_3d<f32>,
    cube_sampler: sampler,
    params: ColorLut,
) -> vec4f {
    let at = color_lut_placed(color_lut_curved(curve, source.rgb, params), params);
    return color_lut_mixed(source, cube_fetched(cube, cube_sampler, at), params);
}

fn color_lut_both_tetrahedral(source: vec4f, curve: texture_2d<f32>, cube: texture_3d<f32>, params: ColorLut) -> vec4f {
    let at = color_lut_placed(color_lut_curved(curve, source.rgb, params), params);
    return color_lut_mixed(source, cube_tetrahedral(cube, at), params);
}
