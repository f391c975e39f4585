import afterimage::math::between3;

struct Mix { amount: f32 }

fn mix(source: vec4f, other: vec4f, mask: vec4f, params: Mix) -> vec4f {
    let share = params.amount * clamp(mask.r, 0.0, 1.0);
    return vec4f(between3(source.rgb, other.rgb, share), source.a + share * (other.a - source.a));
}
