// The scene behind a froxel volume: scattered light in rgb, the share of light that passes in alpha, both from the
// camera to the texel. Wronski, "Volumetric Fog", 2014.
import afterimage::depth::depth_distance;
import afterimage::grade::bounded_scene;

struct VolumetricComposite {
    near: f32,
    // 1 / (far - near).
    scale: f32,
    // e^curve - 1, or 0 for linear slices.
    bend: f32,
    inverse_curve: f32,
    slices: f32,
    // The position of the first texel, in slices.
    first: f32,
    light: f32,
    amount: f32,
}

// The logarithm of 1 + x for x of 0 or more, also where the sum has lost the digits of x.
fn volumetric_log(x: f32) -> f32 {
    let near = x * (1.0 - x * (0.5 - x * (1.0 / 3.0 - 0.25 * x)));
    return select(log(1.0 + x), near, x < 0.03);
}

// The number of slices between the camera and a distance: 0 at the near end and before it.
fn volumetric_slice(distance: f32, params: VolumetricComposite) -> f32 {
    let linear = clamp((distance - params.near) * params.scale, 0.0, 1.0);
    let curved = volumetric_log(linear * params.bend) * params.inverse_curve;
    return clamp(select(curved, linear, params.bend == 0.0), 0.0, 1.0) * params.slices;
}

fn volumetric_composite(
    source: vec4f,
    depth: vec4f,
    volume: texture_3d<f32>,
    volume_sampler: sampler,
    at: Point,
    params: VolumetricComposite,
) -> vec4f {
    let slice = volumetric_slice(depth_distance(depth.x), params);
    let fog = tap3(volume, volume_sampler, vec3f(at.uv, (slice - params.first + 0.5) / params.slices));
    // No fog lies at the near end, and that of the first texel at its place.
    let share = params.amount * min(slice / params.first, 1.0);
    let passed = 1.0 - share * (1.0 - clamp(fog.a, 0.0, 1.0));
    return vec4f(bounded_scene(source.rgb * passed + share * params.light * fog.rgb), source.a);
}
