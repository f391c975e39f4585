// Distortion of a lens: where in the source the light of a pixel comes from. Places are relative to the optical center;
// the distance 1 is half of the image's diagonal.
//
// Brown, "Decentering Distortion of Lenses", 1966, in the form of Conrady's and OpenCV's coefficients; Fitzgibbon,
// "Simultaneous Linear Estimation of Multiple View Geometry and Lens Distortion", CVPR 2001, for the division model.

struct LensDistortion {
    k1: f32,
    k2: f32,
    k3: f32,
    p1: f32,
    p2: f32,
    center: vec2f,
    zoom: f32,
    limit: f32,  // the distance up to which the radial function rises; beyond it a place is moved to it
}

// A factor of the distance, and its derivative by the distance.
struct LensDistortionScale {
    factor: f32,
    slope: f32,
}

// Half of the diagonal is 1.
fn lens_distortion_unit(size: vec2f) -> vec2f {
    return 2.0 * size / length(size);
}

fn lens_distortion_place(at: Point, params: LensDistortion) -> vec2f {
    return (at.uv - 0.5 - params.center) * lens_distortion_unit(at.size) / params.zoom;
}

fn lens_distortion_uv(place: vec2f, at: Point, params: LensDistortion) -> vec4f {
    return vec4f(0.5 + params.center + place / lens_distortion_unit(at.size), 0.0, 0.0);
}

// The place, or the nearest one within the limit.
fn lens_distortion_limited(place: vec2f, params: LensDistortion) -> vec2f {
    return place * min(1.0, params.limit / max(length(place), 1e-6));
}

fn lens_distortion_brown_scale(r: f32, params: LensDistortion) -> LensDistortionScale {
    let s = r * r;
    let factor = 1.0 + s * (params.k1 + s * (params.k2 + s * params.k3));
    return LensDistortionScale(factor, r * (2.0 * params.k1 + s * (4.0 * params.k2 + s * 6.0 * params.k3)));
}

fn lens_distortion_division_scale(r: f32, params: LensDistortion) -> LensDistortionScale {
    let s = r * r;
    let below = max(1.0 + s * (params.k1 + s * params.k2), 1e-3);
    return LensDistortionScale(1.0 / below, -r * (2.0 * params.k1 + 4.0 * s * params.k2) / (below * below));
}

// One step of Newton's method toward the distance that the radial function maps to `wanted`.
fn lens_distortion_step(r: f32, wanted: f32, scale: LensDistortionScale, params: LensDistortion) -> f32 {
    let rise = max(scale.factor + r * scale.slope, 0.05);
    return clamp(r - (r * scale.factor - wanted) / rise, 0.0, params.limit);
}

fn lens_distortion_tangential(place: vec2f, params: LensDistortion) -> vec2f {
    let p = vec2f(params.p2, params.p1);
    let cross = 2.0 * place.x * place.y;
    return p * (dot(place, place) + 2.0 * place * place) + p.yx * cross;
}

fn lens_distortion_brown_of(place: vec2f, params: LensDistortion) -> vec2f {
    let near = lens_distortion_limited(place, params);
    return near * lens_distortion_brown_scale(length(near), params).factor + lens_distortion_tangential(near, params);
}

// The place that the radial function maps to another one.
fn lens_distortion_brown_radial(place: vec2f, params: LensDistortion) -> vec2f {
    let wanted = length(place);
    var r = min(wanted, params.limit);
    for (var i = 0; i < 8; i++) {
        r = lens_distortion_step(r, wanted, lens_distortion_brown_scale(r, params), params);
    }
    return place * (r / max(wanted, 1e-6));
}

fn lens_distortion_brown(at: Point, params: LensDistortion) -> vec4f {
    return lens_distortion_uv(lens_distortion_brown_of(lens_distortion_place(at, params), params), at, params);
}

// The tangential part is small, so subtracting it at the place that was found last converges.
fn lens_distortion_brown_inverse(at: Point, params: LensDistortion) -> vec4f {
    let wanted = lens_distortion_place(at, params);
    var place = lens_distortion_brown_radial(wanted, params);
    for (var i = 0; i < 6; i++) {
        place = lens_distortion_brown_radial(wanted - lens_distortion_tangential(place, params), params);
    }
    return lens_distortion_uv(place, at, params);
}

fn lens_distortion_division(at: Point, params: LensDistortion) -> vec4f {
    let near = lens_distortion_limited(lens_distortion_place(at, params), params);
    let place = near * lens_distortion_division_scale(length(near), params).factor;
    return lens_distortion_uv(place, at, params);
}

fn lens_distortion_division_inverse(at: Point, params: LensDistortion) -> vec4f {
    let place = lens_distortion_place(at, params);
    let wanted = length(place);
    var r = min(wanted, params.limit);
    for (var i = 0; i < 8; i++) {
        r = lens_distortion_step(r, wanted, lens_distortion_division_scale(r, params), params);
    }
    return lens_distortion_uv(place * (r / max(wanted, 1e-6)), at, params);
}
