// A scene under one lamp: its depth from the lamp, and its light.
import afterimage::camera::{Camera, camera_clip_uv};

struct SceneLight { warmth: f32, emission: f32 }

@group(0) @binding(0) var<uniform> camera: Camera;
@group(0) @binding(1) var<uniform> light: Camera;
@group(0) @binding(2) var shadows: texture_2d<f32>;
@group(0) @binding(3) var<uniform> params: SceneLight;

struct Corner {
    @builtin(position) clip: vec4f,
    @location(0) world: vec3f,
    @location(1) normal: vec3f,
    @location(2) color: vec4f,
}

@vertex fn from_camera(@location(0) place: vec3f, @location(1) normal: vec3f, @location(2) color: vec4f) -> Corner {
    let clip = camera.projection * (camera.view * vec4f(place, 1.0));
    return Corner(clip, place, normal, color);
}

// The share of the lamp's light that arrives: nine taps, each over two by two texels.
fn arrives(place: vec3f) -> f32 {
    let seen = camera_clip_uv(light.projection * (light.view * vec4f(place, 1.0)));
    let size = vec2f(textureDimensions(shadows));
    let at = seen.xy * size - 0.5;
    let first = floor(at);
    let part = at - first;
    let across = vec4f(1.0 - part.x, 1.0, 1.0, part.x) / 3.0;
    let down = vec4f(1.0 - part.y, 1.0, 1.0, part.y) / 3.0;
    var sum = 0.0;
    for (var y = 0; y < 4; y++) {
        for (var x = 0; x < 4; x++) {
            let depth = texel(shadows, vec2i(first) + vec2i(x, y) - 1).x;
            sum += select(0.0, across[x] * down[y], seen.z <= depth);
        }
    }
    return sum;
}

@fragment fn shaded(corner: Corner) -> @location(0) vec4f {
    let normal = normalize(corner.normal);
    let to_light = light.inverse_view[3].xyz - corner.world;
    let facing = max(dot(normal, normalize(to_light)), 0.0);
    // The lamp is a cone with a soft edge.
    let axis = normalize(light.inverse_view[2].xyz);
    let cone = smoothstep(0.9, 0.95, dot(normalize(to_light), axis));
    let lamp = vec3f(1.0, 0.5 + 0.4 * (1.0 - params.warmth), 1.0 - 0.6 * params.warmth);
    let direct = 260.0 * facing * cone / dot(to_light, to_light) * lamp * arrives(corner.world);
    let sky = mix(vec3f(0.05, 0.05, 0.06), vec3f(0.14, 0.18, 0.26), 0.5 + 0.5 * normal.y);
    let emitted = params.emission * corner.color.a * corner.color.rgb;
    return vec4f(corner.color.rgb * (direct + sky) + emitted, corner.color.a);
}

// The share of the light that passes through one side of colored glass.
@fragment fn tinted(corner: Corner) -> @location(0) vec4f {
    return vec4f(corner.color.rgb, 1.0);
}
