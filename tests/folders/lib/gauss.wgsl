// The mean of an image along an axis, weighted by a Gaussian that ends at three standard deviations. The weights are
// normalized by their sum, so a constant image stays constant. Reads beyond the border return the border.
fn gauss_along(source: texture_2d<f32>, pixel: vec2i, axis: vec2i, sigma: f32) -> vec4f {
    let falloff = -1.0 / (2.0 * sigma * sigma);
    var sum = texel(source, pixel);
    var total = 1.0;
    for (var i = 1; i <= i32(ceil(3.0 * sigma)); i++) {
        let weight = exp(f32(i * i) * falloff);
        sum += weight * (texel(source, pixel - i * axis) + texel(source, pixel + i * axis));
        total += 2.0 * weight;
    }
    return sum / total;
}
