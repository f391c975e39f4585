// The depth of a scene as a lamp sees it.
import afterimage::camera::Camera;

@group(0) @binding(0) var<uniform> light: Camera;

@vertex fn from_light(
    @location(0) place: vec3f,
    @location(1) normal: vec3f,
    @location(2) color: vec4f,
) -> @builtin(position) vec4f {
    return light.projection * (light.view * vec4f(place, 1.0));
}
