// Positions of the moving objects of the loft: a balloon on an ellipse, and a ball that bounces on the floor.

struct LoftPose {
    balloon: vec3f,
    ball: vec3f,
}

const LOFT_BALLOON_RADII = vec3f(0.2, 0.25, 0.2);
const LOFT_BALLOON_PERIOD: f32 = 5.0;   // seconds
const LOFT_BALL_RADIUS: f32 = 0.13;
const LOFT_BALL_PERIOD: f32 = 0.8;      // seconds of a bounce
const LOFT_BALL_HEIGHT: f32 = 0.785;    // half of gravity times the square of half of the period
const LOFT_BALL_TURN: f32 = 7.0;        // seconds of its way through the room

// Objects that are absent are far below the floor, where no ray leads.
const LOFT_NOWHERE = vec3f(0.0, -1000.0, 0.0);

fn loft_turn(time: f32, period: f32) -> vec2f {
    let angle = 6.2831853 * fract(time / period);
    return vec2f(cos(angle), sin(angle));
}

// At a time in seconds, with this many objects.
fn loft_pose(time: f32, objects: i32) -> LoftPose {
    let drift = loft_turn(time, LOFT_BALLOON_PERIOD);
    let balloon = vec3f(-1.5 + 0.7 * drift.x, 1.4 + 0.12 * drift.y, 0.6 + 0.5 * drift.y);
    let bounce = fract(time / LOFT_BALL_PERIOD);
    let height = LOFT_BALL_RADIUS + LOFT_BALL_HEIGHT * 4.0 * bounce * (1.0 - bounce);
    let way = loft_turn(time, LOFT_BALL_TURN);
    let ball = vec3f(2.3 + 0.5 * way.x, height, 0.7 + 0.8 * way.y);
    return LoftPose(select(LOFT_NOWHERE, balloon, objects > 0), select(LOFT_NOWHERE, ball, objects > 1));
}
