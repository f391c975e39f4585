import afterimage::depth::depth_at;

struct Denoise { strength: f32, depth_edge: f32 }

// The light that is black to the logarithm.
const DENOISE_BLACK: f32 = 0.001;

fn denoise_level(rgb: vec3f) -> vec3f {
    return log2(max(rgb, vec3f(0.0)) + DENOISE_BLACK);
}

// The weight of a read whose depth and normal differ.
fn denoise_surface(own: f32, other: f32, own_normal: vec4f, other_normal: vec4f, edge: f32) -> f32 {
    let apart = (other - own) / (edge * own);
    let facing = own_normal.xyz - other_normal.xyz;
    return exp(-apart * apart - 4.0 * dot(facing, facing));
}

// The weights of the spline, from its middle.
const DENOISE_SPLINE: array<f32, 3> = array(0.375, 0.25, 0.0625);

// A pass: the B-spline of reads `step` apart.
fn denoise_pass(
    source: texture_2d<f32>,
    depth: texture_2d<f32>,
    normal: texture_2d<f32>,
    at: Point,
    step: i32,
    params: Denoise,
) -> vec4f {
    let own = texel(source, at.pixel);
    if params.strength == 0.0 { return own; }
    let own_level = denoise_level(own.rgb);
    let own_depth = depth_at(depth, at.pixel);
    let own_normal = texel(normal, at.pixel);
    let tolerance = params.strength / f32(step);
    var sum = vec4f();
    var total = 0.0;
    for (var y = -2; y <= 2; y++) {
        for (var x = -2; x <= 2; x++) {
            let pixel = at.pixel + step * vec2i(x, y);
            let other = texel(source, pixel);
            let spline = vec2f(DENOISE_SPLINE[abs(x)], DENOISE_SPLINE[abs(y)]);
            let apart = denoise_level(other.rgb) - own_level;
            let alike = exp(-dot(apart, apart) / (tolerance * tolerance));
            let other_depth = depth_at(depth, pixel);
            let other_normal = texel(normal, pixel);
            let surface = denoise_surface(own_depth, other_depth, own_normal, other_normal, params.depth_edge);
            let weight = spline.x * spline.y * alike * surface;
            sum += weight * other;
            total += weight;
        }
    }
    return sum / total;
}

fn denoise_first(
    source: texture_2d<f32>,
    depth: texture_2d<f32>,
    normal: texture_2d<f32>,
    at: Point,
    params: Denoise,
) -> vec4f {
    return denoise_pass(source, depth, normal, at, 1, params);
}

fn denoise_second(
    first: texture_2d<f32>,
    depth: texture_2d<f32>,
    normal: texture_2d<f32>,
    at: Point,
    params: Denoise,
) -> vec4f {
    return denoise_pass(first, depth, normal, at, 2, params);
}

fn denoise_third(
    second: texture_2d<f32>,
    depth: texture_2d<f32>,
    normal: texture_2d<f32>,
    at: Point,
    params: Denoise,
) -> vec4f {
    return denoise_pass(second, depth, normal, at, 4, params);
}

fn denoise_fourth(
    third: texture_2d<f32>,
    depth: texture_2d<f32>,
    normal: texture_2d<f32>,
    at: Point,
    params: Denoise,
) -> vec4f {
    return denoise_pass(third, depth, normal, at, 8, params);
}

fn denoise(
    fourth: texture_2d<f32>,
    depth: texture_2d<f32>,
    normal: texture_2d<f32>,
    at: Point,
    params: Denoise,
) -> vec4f {
    return denoise_pass(fourth, depth, normal, at, 16, params);
}
