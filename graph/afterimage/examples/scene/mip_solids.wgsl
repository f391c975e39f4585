// Icosahedra in a row, with an image whose mip levels have a color each.
@group(0) @binding(0) var picture: texture_2d<f32>;
@group(0) @binding(1) var picture_sampler: sampler;

struct Corner { @builtin(position) clip: vec4f, @location(0) place: vec3f }

@vertex fn solid(@location(0) place: vec3f, @location(1) center: vec4f) -> Corner {
    let world = center.w * place + center.xyz;
    return Corner(vec4f(1.6 * world.xy * vec2f(0.5625, 1.0), (-world.z - 1.0) / 40.0 * -world.z, -world.z), place);
}

@fragment fn banded(corner: Corner) -> @location(0) vec4f {
    let direction = normalize(corner.place);
    let uv = vec2f(0.5 + 0.5 * direction.x, 0.5 - 0.5 * direction.y);
    let light = 0.35 + 0.65 * max(dot(direction, normalize(vec3f(-0.4, 0.6, 0.7))), 0.0);
    return vec4f(light * textureSample(picture, picture_sampler, uv).rgb, 1.0);
}
