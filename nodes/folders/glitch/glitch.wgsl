import afterimage::noise::hash_cell;

struct Glitch {
    amount: f32,
    share: f32,
    blocks: f32,
    rate: f32,
    fringe: f32,
}

// Changes until they come again.
const GLITCH_MOMENTS: f32 = 65536.0;

// The offset of the block of a line, from -1 to 1: mostly 0.
fn glitch_jump(line: f32, frame: Frame, params: Glitch) -> f32 {
    let moment = i32(floor(frame_phase(frame, params.rate / GLITCH_MOMENTS) * GLITCH_MOMENTS));
    let block = i32(floor(line * params.blocks));
    let chance = hash_cell(vec2i(block, 2 * moment));
    let distance = 2.0 * hash_cell(vec2i(block, 2 * moment + 1)) - 1.0;
    return select(0.0, distance, chance < params.share);
}

fn glitch(source: texture_2d<f32>, source_sampler: sampler, at: Point, frame: Frame, params: Glitch) -> vec4f {
    let jump = params.amount * glitch_jump(at.uv.y, frame, params);
    let apart = jump * params.fringe;
    let middle = tap(source, source_sampler, at.uv + vec2f(jump, 0.0));
    let red = tap(source, source_sampler, at.uv + vec2f(jump + apart, 0.0));
    let blue = tap(source, source_sampler, at.uv + vec2f(jump - apart, 0.0));
    return vec4f(red.r, middle.g, blue.b, middle.a + (red.a - middle.a) / 3.0 + (blue.a - middle.a) / 3.0);
}
