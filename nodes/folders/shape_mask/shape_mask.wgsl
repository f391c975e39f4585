import afterimage::math::smooth_step;

struct ShapeMask {
    center: vec2f,
    size: vec2f,
    rotation: f32,
    ellipse: u32,
    roundness: f32,
    softness: f32,
    invert: u32,
}

fn shape_mask_box(p: vec2f, half_size: vec2f, roundness: f32) -> f32 {
    let radius = roundness * min(half_size.x, half_size.y);
    let q = abs(p) - half_size + radius;
    return length(max(q, vec2f(0.0))) + min(max(q.x, q.y), 0.0) - radius;
}

// The distance over which the ellipse's implicit function grows as it does here.
fn shape_mask_ellipse(p: vec2f, half_size: vec2f) -> f32 {
    let share = length(p / half_size);
    let slope = length(p / (half_size * half_size));
    return select(share * (share - 1.0) / max(slope, 1e-20), -min(half_size.x, half_size.y), slope <= 1e-20);
}

fn shape_mask(source: vec4f, at: Point, params: ShapeMask) -> vec4f {
    let angle = radians(params.rotation);
    let axis = vec2f(cos(angle), sin(angle));
    let from_center = (vec2f(at.pixel) + 0.5 - params.center * at.size);
    let p = vec2f(dot(from_center, axis), dot(from_center, vec2f(-axis.y, axis.x)));
    let half_size = 0.5 * params.size * at.size.y;
    let outside = select(
        shape_mask_box(p, half_size, params.roundness),
        shape_mask_ellipse(p, half_size),
        params.ellipse != 0u,
    );
    let ramp = clamp(0.5 - outside / max(params.softness * at.size.y, 1.0), 0.0, 1.0);
    let is_soft = params.softness * at.size.y > 1.0;
    let inside = select(ramp, smooth_step(0.0, 1.0, ramp), is_soft);
    return vec4f(vec3f(select(inside, 1.0 - inside, params.invert != 0u)), 1.0);
}
