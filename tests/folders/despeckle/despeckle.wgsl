import afterimage::workgroup::Invocation;

struct Despeckle { strength: f32 }

// Invocations of the workgroup in both directions; the tile has a border of one texel around them.
const SIDE: i32 = 16;
const TILE_SIDE: i32 = SIDE + 2;
const TILE_TEXELS: i32 = TILE_SIDE * TILE_SIDE;
var<workgroup> tile: array<vec4f, TILE_TEXELS>;

// Stores the texel of the tile with that index.
fn store(source: texture_2d<f32>, first: vec2i, index: i32) {
    if index < TILE_TEXELS {
        tile[index] = texel(source, first + vec2i(index % TILE_SIDE, index / TILE_SIDE));
    }
}

// The least, the middle and the greatest of each channel.
struct Three { low: vec4f, middle: vec4f, high: vec4f }

fn three(a: vec4f, b: vec4f, c: vec4f) -> Three {
    let low = min(a, b);
    let high = max(a, b);
    return Three(min(low, c), max(low, min(high, c)), max(high, c));
}

// Three texels of a row of the tile.
fn row(first: i32) -> Three {
    return three(tile[first], tile[first + 1], tile[first + 2]);
}

fn despeckle(source: texture_2d<f32>, at: Point, invocation: Invocation, params: Despeckle) -> vec4f {
    let index = i32(invocation.index);
    let local = vec2i(index % SIDE, index / SIDE);
    let first = at.pixel - local - 1;
    store(source, first, index);
    store(source, first, index + SIDE * SIDE);
    workgroupBarrier();
    let corner = local.y * TILE_SIDE + local.x;
    let upper = row(corner);
    let middle = row(corner + TILE_SIDE);
    let lower = row(corner + 2 * TILE_SIDE);
    // The median of nine is the median of the greatest low, the middle one of the middles and the least high.
    let low = max(max(upper.low, middle.low), lower.low);
    let high = min(min(upper.high, middle.high), lower.high);
    let median = three(low, three(upper.middle, middle.middle, lower.middle).middle, high).middle;
    let own = tile[corner + TILE_SIDE + 1];
    return vec4f(mix(own.rgb, median.rgb, params.strength), own.a);
}
