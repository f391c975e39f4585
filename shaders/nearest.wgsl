// An image of numbers that have no mean, such as depths, in another size.

fn nearest(source: texture_2d<f32>, at: Point) -> vec4f {
    return texel(source, vec2i(at.uv * vec2f(textureDimensions(source))));
}
