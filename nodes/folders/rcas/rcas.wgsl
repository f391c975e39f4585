struct Rcas { sharpness: f32 }

// The largest lobe.
const RCAS_LIMIT: f32 = 0.1875;

fn rcas(source: texture_2d<f32>, at: Point, params: Rcas) -> vec4f {
    let own = texel(source, at.pixel);
    if params.sharpness == 0.0 { return own; }
    let above = texel(source, at.pixel + vec2i(0, -1)).rgb;
    let below = texel(source, at.pixel + vec2i(0, 1)).rgb;
    let left = texel(source, at.pixel + vec2i(-1, 0)).rgb;
    let right = texel(source, at.pixel + vec2i(1, 0)).rgb;
    let least = min(min(above, below), min(left, right));
    let most = max(max(above, below), max(left, right));
    // The lobes at which the result would be 0, and 1.
    let to_black = min(least, own.rgb) / max(4.0 * most, vec3f(1e-6));
    let to_white = max(1.0 - max(most, own.rgb), vec3f(0.0)) / max(4.0 - 4.0 * least, vec3f(1e-6));
    let of_channels = min(to_black, to_white);
    let lobe = params.sharpness * clamp(min(of_channels.r, min(of_channels.g, of_channels.b)), 0.0, RCAS_LIMIT);
    let sharp = (own.rgb - lobe * (above + below + left + right)) / (1.0 - 4.0 * lobe);
    return vec4f(max(sharp, vec3f(0.0)), own.a);
}
