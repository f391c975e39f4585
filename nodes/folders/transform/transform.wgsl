struct Transform {
    offset: vec2f,
    scale: f32,
    rotation: f32,
    crop: vec4f,
    repeat: u32,
}

// The most reads in a footprint along an axis.
const TRANSFORM_READS: f32 = 8.0;

// The place of the source that is shown at a place of the result, both in pixels.
fn transform_place(pixel: vec2f, size: vec2f, params: Transform) -> vec2f {
    let angle = radians(params.rotation);
    let axis = vec2f(cos(angle), sin(angle));
    let p = pixel - (0.5 + params.offset) * size;
    return vec2f(dot(p, axis), dot(p, vec2f(-axis.y, axis.x))) / params.scale + 0.5 * size;
}

// `finest` is the side of a read's footprint in pixels of the source.
fn transform_read(
    t: texture_2d<f32>,
    s: sampler,
    place: vec2f,
    size: vec2f,
    finest: f32,
    params: Transform,
) -> vec4f {
    let low = params.crop.xy * size;
    let high = (1.0 - params.crop.zw) * size;
    // The share of the footprint between both sides of the image, along each axis of it.
    let from_low = clamp((place - low) / finest + 0.5, vec2f(), vec2f(1.0));
    let to_high = clamp((high - place) / finest + 0.5, vec2f(), vec2f(1.0));
    let share = max(from_low + to_high - 1.0, vec2f());
    let covered = select(share.x * share.y, 1.0, params.repeat != 0u);
    let is_empty = any(high <= low);
    return select(covered, 0.0, is_empty) * tap(t, s, clamp(place, low, max(high, low)) / size);
}

fn transform(source: texture_2d<f32>, source_sampler: sampler, at: Point, params: Transform) -> vec4f {
    let is_neutral = all(params.offset == vec2f()) && params.scale == 1.0 && params.rotation == 0.0;
    if is_neutral && all(params.crop == vec4f()) { return texel(source, at.pixel); }
    let reads = clamp(ceil(1.0 / params.scale), 1.0, TRANSFORM_READS);
    var sum = vec4f();
    for (var y = 0.0; y < reads; y += 1.0) {
        for (var x = 0.0; x < reads; x += 1.0) {
            let pixel = vec2f(at.pixel) + (vec2f(x, y) + 0.5) / reads;
            let place = transform_place(pixel, at.size, params);
            sum += transform_read(source, source_sampler, place, at.size, 1.0 / (params.scale * reads), params);
        }
    }
    return sum / (reads * reads);
}
