import afterimage::math::power;
import afterimage::tent::tent_weight;

struct Kuwahara { radius: f32, sharpness: f32, direction: f32 }

// Weights of Sobel's filter along a row, and the most reads to each side of a pixel along a round brush.
const KUWAHARA_SOBEL: array<f32, 3> = array(0.25, 0.5, 0.25);
const KUWAHARA_READS: f32 = 8.0;

// The structure tensor: the squares of the slopes along x and y, and that of their sum, because images of a display
// hold no negative numbers.
fn kuwahara_tensor(source: texture_2d<f32>, at: Point) -> vec4f {
    var across = vec3f();
    var down = vec3f();
    for (var i = -1; i <= 1; i++) {
        let weight = KUWAHARA_SOBEL[i + 1];
        across += weight * (texel(source, at.pixel + vec2i(1, i)).rgb - texel(source, at.pixel + vec2i(-1, i)).rgb);
        down += weight * (texel(source, at.pixel + vec2i(i, 1)).rgb - texel(source, at.pixel + vec2i(i, -1)).rgb);
    }
    let both = across + down;
    return vec4f(dot(across, across), dot(down, down), dot(both, both), 1.0);
}

// A Gaussian of two pixels along an axis.
fn kuwahara_smooth(t: texture_2d<f32>, pixel: vec2i, axis: vec2i) -> vec4f {
    var sum = vec4f();
    var total = 0.0;
    for (var i = -6; i <= 6; i++) {
        let weight = exp(-0.125 * f32(i * i));
        sum += weight * texel(t, pixel + i * axis);
        total += weight;
    }
    return sum / total;
}

fn kuwahara_across(tensor: texture_2d<f32>, at: Point) -> vec4f {
    return kuwahara_smooth(tensor, at.pixel, vec2i(1, 0));
}

fn kuwahara_flow(across: texture_2d<f32>, at: Point) -> vec4f {
    return kuwahara_smooth(across, at.pixel, vec2i(0, 1));
}

// Pixels between two reads.
fn kuwahara_step(height: f32, params: Kuwahara) -> f32 {
    return max(ceil(params.radius * height / KUWAHARA_READS), 1.0);
}

// The image without what reads that far apart would miss.
fn kuwahara_soft(source: texture_2d<f32>, source_sampler: sampler, at: Point, params: Kuwahara) -> vec4f {
    let step = kuwahara_step(at.size.y, params);
    if step == 1.0 { return texel(source, at.pixel); }
    var sum = vec4f();
    for (var y = -1; y <= 1; y++) {
        for (var x = -1; x <= 1; x++) {
            sum += tent_weight(x, y) * tap(source, source_sampler, at.uv + 0.5 * step * vec2f(vec2i(x, y)) / at.size);
        }
    }
    return sum;
}

// From pixels to the disk of radius 1 that the ellipse of a brush becomes: along it, and across.
struct KuwaharaBrush {
    along: vec2f,
    beside: vec2f,
    reach: vec2f,  // half of the sides of the box around it, in pixels
}

fn kuwahara_brush(flow: vec4f, radius: f32, direction: f32) -> KuwaharaBrush {
    let mean = 0.5 * (flow.x + flow.y);
    let apart = vec2f(0.5 * (flow.x - flow.y), 0.5 * (flow.z - flow.x - flow.y));
    let strength = length(apart);
    // The edge lies across the largest slope.
    let angle = 0.5 * atan2(-apart.y, -apart.x + select(0.0, 1.0, strength <= 1e-9));
    let share = 1.0 + direction * clamp(strength / max(mean, 1e-9), 0.0, 1.0);
    let axis = vec2f(cos(angle), sin(angle));
    let long = radius * share;
    let short = radius / share;
    let reach = sqrt(long * long * axis * axis + short * short * axis.yx * axis.yx);
    return KuwaharaBrush(axis / long, vec2f(-axis.y, axis.x) / short, reach);
}

// The sums over four sectors: weights, each channel times them, and its square.
struct KuwaharaSectors {
    weights: vec4f,
    red: vec4f,
    green: vec4f,
    blue: vec4f,
    alpha: vec4f,
    squares: vec4f,
}

fn kuwahara_add(sectors: ptr<function, KuwaharaSectors>, color: vec4f, weights: vec4f) {
    (*sectors).weights += weights;
    (*sectors).red += weights * color.r;
    (*sectors).green += weights * color.g;
    (*sectors).blue += weights * color.b;
    (*sectors).alpha += weights * color.a;
    (*sectors).squares += weights * dot(color.rgb, color.rgb);
}

// The polynomials of the sectors to the right, below, to the left and above, at a place in the disk of radius 1.
fn kuwahara_weights(p: vec2f) -> vec4f {
    let bend = 0.33 - 3.77 * p.yx * p.yx;
    let raised = max(vec4f(p, -p) + bend.xyxy, vec4f(0.0));
    return raised * raised;
}

// The means of four sectors, weighted by their calm, and the weight.
struct KuwaharaMean { color: vec4f, weight: f32 }

fn kuwahara_mean(sectors: KuwaharaSectors, sharpness: f32) -> KuwaharaMean {
    let total = max(sectors.weights, vec4f(1e-9));
    let red = sectors.red / total;
    let green = sectors.green / total;
    let blue = sectors.blue / total;
    let variance = max(sectors.squares / total - red * red - green * green - blue * blue, vec4f(0.0));
    var weights = vec4f();
    for (var i = 0; i < 4; i++) {
        weights[i] = 1.0 / (1.0 + power(255.0 * variance[i], 0.5 * sharpness));
    }
    weights = select(vec4f(0.0), weights, sectors.weights > vec4f(1e-9));
    let color = vec4f(
        dot(weights, red),
        dot(weights, green),
        dot(weights, blue),
        dot(weights, sectors.alpha / total),
    );
    return KuwaharaMean(color, dot(weights, vec4f(1.0)));
}

fn kuwahara(soft: texture_2d<f32>, flow: texture_2d<f32>, at: Point, params: Kuwahara) -> vec4f {
    if params.radius == 0.0 { return texel(soft, at.pixel); }
    let radius = max(params.radius * at.size.y, 0.5);
    let brush = kuwahara_brush(texel(flow, at.pixel), radius, params.direction);
    let step = kuwahara_step(at.size.y, params);
    let reads = vec2i(floor(brush.reach / step));
    var straight = KuwaharaSectors();
    var diagonal = KuwaharaSectors();
    for (var y = -reads.y; y <= reads.y; y++) {
        for (var x = -reads.x; x <= reads.x; x++) {
            let away = step * vec2f(f32(x), f32(y));
            let p = vec2f(dot(away, brush.along), dot(away, brush.beside));
            if dot(p, p) > 1.0 { continue; }
            let color = texel(soft, at.pixel + vec2i(away));
            let first = kuwahara_weights(p);
            let second = kuwahara_weights(0.70710678 * vec2f(p.x + p.y, p.y - p.x));
            let near = exp(-3.125 * dot(p, p)) / (dot(first, vec4f(1.0)) + dot(second, vec4f(1.0)));
            kuwahara_add(&straight, color, near * first);
            kuwahara_add(&diagonal, color, near * second);
        }
    }
    let a = kuwahara_mean(straight, params.sharpness);
    let b = kuwahara_mean(diagonal, params.sharpness);
    return (a.color + b.color) / (a.weight + b.weight);
}
