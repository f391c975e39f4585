// The edge through a pixel, from its neighbors: its gradient, and its strength from 0 to 1.
struct Fsr1Edge { gradient: vec2f, clearness: f32 }

fn fsr1_luma(color: vec4f) -> f32 {
    return 0.5 * (color.r + color.b) + color.g;
}

// Along one axis: how much of the change between both neighbors is on the steeper side. 1 is an edge, 0 a line.
fn fsr1_clearness(before: f32, own: f32, after: f32) -> f32 {
    let steepest = max(abs(after - own), abs(own - before));
    let share = clamp(abs(after - before) / max(steepest, 1e-6), 0.0, 1.0);
    return share * share;
}

// Adds what a pixel sees of its neighbors, by its weight.
fn fsr1_seen(sum: Fsr1Edge, weight: f32, own: f32, left: f32, right: f32, above: f32, below: f32) -> Fsr1Edge {
    let gradient = vec2f(right - left, below - above);
    let clearness = fsr1_clearness(left, own, right) + fsr1_clearness(above, own, below);
    return Fsr1Edge(sum.gradient + weight * gradient, sum.clearness + weight * clearness);
}

// The kernel: its axes in pixels of the source, and its form.
struct Fsr1Kernel { across: vec2f, scale: vec2f, lobe: f32 }

fn fsr1_kernel(edge: Fsr1Edge) -> Fsr1Kernel {
    let squared = dot(edge.gradient, edge.gradient);
    let is_flat = squared < 1.0 / 32768.0;
    let across = select(edge.gradient * inverseSqrt(max(squared, 1e-12)), vec2f(1.0, 0.0), is_flat);
    let clear = 0.25 * edge.clearness * edge.clearness;
    // A kernel along a diagonal is longer, as the diagonal of a pixel is.
    let stretch = 1.0 / max(abs(across.x), abs(across.y));
    let scale = vec2f(1.0 + (stretch - 1.0) * clear, 1.0 - 0.5 * clear);
    return Fsr1Kernel(across, scale, 0.5 - 0.29 * clear);
}

// The weight of a pixel at this distance: a product of polynomials that is near a windowed sinc.
fn fsr1_weight(kernel: Fsr1Kernel, distance: vec2f) -> f32 {
    let turned = vec2f(dot(distance, kernel.across), dot(distance, vec2f(-kernel.across.y, kernel.across.x)));
    let place = turned * kernel.scale;
    let squared = min(dot(place, place), 1.0 / kernel.lobe);
    let base = 0.4 * squared - 1.0;
    let window = kernel.lobe * squared - 1.0;
    return (1.5625 * base * base - 0.5625) * window * window;
}

fn fsr1(source: texture_2d<f32>, at: Point) -> vec4f {
    let place = 0.5 * (vec2f(at.pixel) + 0.5) - 0.5;
    let first = vec2i(floor(place));
    let share = place - floor(place);
    let b = texel(source, first + vec2i(0, -1));
    let c = texel(source, first + vec2i(1, -1));
    let e = texel(source, first + vec2i(-1, 0));
    let f = texel(source, first);
    let g = texel(source, first + vec2i(1, 0));
    let h = texel(source, first + vec2i(2, 0));
    let i = texel(source, first + vec2i(-1, 1));
    let j = texel(source, first + vec2i(0, 1));
    let k = texel(source, first + vec2i(1, 1));
    let l = texel(source, first + vec2i(2, 1));
    let n = texel(source, first + vec2i(0, 2));
    let o = texel(source, first + vec2i(1, 2));
    let lf = fsr1_luma(f);
    let lg = fsr1_luma(g);
    let lj = fsr1_luma(j);
    let lk = fsr1_luma(k);
    var edge = Fsr1Edge();
    edge = fsr1_seen(edge, (1.0 - share.x) * (1.0 - share.y), lf, fsr1_luma(e), lg, fsr1_luma(b), lj);
    edge = fsr1_seen(edge, share.x * (1.0 - share.y), lg, lf, fsr1_luma(h), fsr1_luma(c), lk);
    edge = fsr1_seen(edge, (1.0 - share.x) * share.y, lj, fsr1_luma(i), lk, lf, fsr1_luma(n));
    edge = fsr1_seen(edge, share.x * share.y, lk, lj, fsr1_luma(l), lg, fsr1_luma(o));
    let kernel = fsr1_kernel(edge);
    let wb = fsr1_weight(kernel, vec2f(0.0, -1.0) - share);
    let wc = fsr1_weight(kernel, vec2f(1.0, -1.0) - share);
    let we = fsr1_weight(kernel, vec2f(-1.0, 0.0) - share);
    let wf = fsr1_weight(kernel, vec2f(0.0, 0.0) - share);
    let wg = fsr1_weight(kernel, vec2f(1.0, 0.0) - share);
    let wh = fsr1_weight(kernel, vec2f(2.0, 0.0) - share);
    let wi = fsr1_weight(kernel, vec2f(-1.0, 1.0) - share);
    let wj = fsr1_weight(kernel, vec2f(0.0, 1.0) - share);
    let wk = fsr1_weight(kernel, vec2f(1.0, 1.0) - share);
    let wl = fsr1_weight(kernel, vec2f(2.0, 1.0) - share);
    let wn = fsr1_weight(kernel, vec2f(0.0, 2.0) - share);
    let wo = fsr1_weight(kernel, vec2f(1.0, 2.0) - share);
    let upper = wb * b + wc * c + we * e + wf * f + wg * g + wh * h;
    let lower = wi * i + wj * j + wk * k + wl * l + wn * n + wo * o;
    let total = wb + wc + we + wf + wg + wh + wi + wj + wk + wl + wn + wo;
    let least = min(min(f, g), min(j, k));
    let most = max(max(f, g), max(j, k));
    return clamp((upper + lower) / total, least, most);
}
