// Hot air bends light: the place where the light of a pixel comes from wavers with the time. Two octaves of value noise
// rise through the image, each of both directions with noise of its own.
import afterimage::noise::noise;

struct HeatHaze {
    strength: f32,
    scale: f32,
    speed: f32,
    shape: f32,
}

// Cells that pass before the noise begins anew: a float still has parts of a cell there.
const HEAT_HAZE_CELLS: f32 = 4096.0;

// From -1 to 1 in both directions, at a place in cells.
fn heat_haze_waver(place: vec2f) -> vec2f {
    return 2.0 * vec2f(noise(place), noise(place + vec2f(37.5, 11.25))) - 1.0;
}

fn heat_haze_place(uv: vec2f, size: vec2f, amount: f32, frame: Frame, params: HeatHaze) -> vec4f {
    let square = vec2f(size.x / size.y, 1.0);
    // Swirls are higher than wide where air rises.
    let cell = params.scale * vec2f(1.0, params.shape);
    let risen = frame_phase(frame, params.speed / (cell.y * HEAT_HAZE_CELLS)) * HEAT_HAZE_CELLS;
    let at = uv * square / cell + vec2f(0.0, risen);
    let wide = heat_haze_waver(at);
    let fine = heat_haze_waver(2.0 * at + vec2f(5.5, 3.25));
    let off = (2.0 * wide + fine) / 3.0;
    return vec4f(uv + params.strength * amount * off / square, 0.0, 0.0);
}

fn heat_haze(at: Point, frame: Frame, params: HeatHaze) -> vec4f {
    return heat_haze_place(at.uv, at.size, 1.0, frame, params);
}

fn heat_haze_masked(
    mask: texture_2d<f32>,
    mask_sampler: sampler,
    at: Point,
    frame: Frame,
    params: HeatHaze,
) -> vec4f {
    let amount = clamp(tap(mask, mask_sampler, at.uv).x, 0.0, 1.0);
    return heat_haze_place(at.uv, at.size, amount, frame, params);
}
