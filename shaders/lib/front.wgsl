// The surface that a pixel belongs to at edges. Where these are smooth, a pixel beside a surface in front of it shows a
// part of that, whatever its own depth says.
import package::depth::depth_at;

// Surfaces whose depths differ by less than this share belong together.
const FRONT_SOFT: f32 = 0.05;

// The four pixels beside a pixel.
fn front_beside(p: vec2i, i: i32) -> vec2i {
    let step = select(1, -1, (i & 1) == 0);
    return p + step * select(vec2i(0, 1), vec2i(1, 0), i < 2);
}

// True if one depth is well before another.
fn front_is_before(first: f32, second: f32) -> bool {
    return first < (1.0 - FRONT_SOFT) * second;
}

// The pixel whose surface a pixel belongs to: the nearest one beside it that is well before it, or itself.
fn front_pixel(depth: texture_2d<f32>, p: vec2i) -> vec2i {
    let own = depth_at(depth, p);
    var nearest = own;
    var front = p;
    for (var i = 0; i < 4; i++) {
        let place = front_beside(p, i);
        let other = depth_at(depth, place);
        let is_front = front_is_before(other, own) && other < nearest;
        front = select(front, place, is_front);
        nearest = select(nearest, other, is_front);
    }
    return front;
}
