// Intersections of a ray with simple solids. Distances are multiples of the length of the ray's direction.

// No hit: a finite distance beyond everything in a scene.
const RAY_MISS: f32 = 1e9;

struct Ray {
    origin: vec3f,
    direction: vec3f,
}

// A direction without zero components, so that it can be divided by. The change is below 0.001 pixels.
fn ray_direction(v: vec3f) -> vec3f {
    let d = normalize(v);
    return select(d, vec3f(1e-7), abs(d) < vec3f(1e-7));
}

// Entry and exit distance of a box. It is a miss if the exit comes first. `direction` must have no zero component.
fn ray_box(ray: Ray, low: vec3f, high: vec3f) -> vec2f {
    let a = (low - ray.origin) / ray.direction;
    let b = (high - ray.origin) / ray.direction;
    let n = min(a, b);
    let f = max(a, b);
    return vec2f(max(max(n.x, n.y), n.z), min(min(f.x, f.y), f.z));
}

// First hit with the outside of an axis-aligned ellipsoid.
fn ray_ellipsoid(ray: Ray, center: vec3f, radii: vec3f) -> f32 {
    let o = (ray.origin - center) / radii;
    let d = ray.direction / radii;
    let a = dot(d, d);
    let b = dot(o, d);
    // The squared distance of the line from the center is exact where b * b - a * c would cancel.
    let away = o - d * (b / a);
    let rest = 1.0 - dot(away, away);
    let t = (-b - sqrt(max(rest, 0.0) * a)) / a;
    return select(RAY_MISS, t, rest > 0.0);
}

// First hit with the side of an upright tube between its ends.
fn ray_tube(ray: Ray, foot: vec3f, radius: f32, height: f32) -> f32 {
    let o = ray.origin.xz - foot.xz;
    let d = ray.direction.xz;
    let a = dot(d, d);
    let b = dot(o, d);
    let away = o - d * (b / a);
    let rest = radius * radius - dot(away, away);
    let t = (-b - sqrt(max(rest, 0.0) * a)) / a;
    let y = ray.origin.y + ray.direction.y * t - foot.y;
    return select(RAY_MISS, t, rest > 0.0 && y > 0.0 && y < height);
}
