import afterimage::math::smooth_step;

struct PolygonMask {
    corners: i32,
    corner_1: vec2f,
    corner_2: vec2f,
    corner_3: vec2f,
    corner_4: vec2f,
    corner_5: vec2f,
    corner_6: vec2f,
    corner_7: vec2f,
    corner_8: vec2f,
    softness: f32,
    invert: u32,
}

// The distance to the polygon in pixels, below 0 inside.
fn polygon_mask_outside(p: vec2f, size: vec2f, params: PolygonMask) -> f32 {
    let corners = array(
        params.corner_1,
        params.corner_2,
        params.corner_3,
        params.corner_4,
        params.corner_5,
        params.corner_6,
        params.corner_7,
        params.corner_8,
    );
    var least = 1e30;
    var is_inside = false;
    var before = corners[params.corners - 1] * size;
    for (var i = 0; i < params.corners; i++) {
        let corner = corners[i] * size;
        let side = before - corner;
        let from_corner = p - corner;
        let share = clamp(dot(from_corner, side) / max(dot(side, side), 1e-12), 0.0, 1.0);
        let apart = from_corner - share * side;
        least = min(least, dot(apart, apart));
        // A ray to the right crosses the side.
        let is_below = p.y >= corner.y;
        let is_crossed = is_below != (p.y >= before.y);
        let is_left = side.x * from_corner.y > side.y * from_corner.x;
        is_inside = is_inside != (is_crossed && is_left == (side.y > 0.0));
        before = corner;
    }
    return select(sqrt(least), -sqrt(least), is_inside);
}

fn polygon_mask(source: vec4f, at: Point, params: PolygonMask) -> vec4f {
    let outside = polygon_mask_outside(vec2f(at.pixel) + 0.5, at.size, params);
    let ramp = clamp(0.5 - outside / max(params.softness * at.size.y, 1.0), 0.0, 1.0);
    let is_soft = params.softness * at.size.y > 1.0;
    let inside = select(ramp, smooth_step(0.0, 1.0, ramp), is_soft);
    return vec4f(vec3f(select(inside, 1.0 - inside, params.invert != 0u)), 1.0);
}
