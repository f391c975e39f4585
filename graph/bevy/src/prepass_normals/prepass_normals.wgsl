import afterimage::camera::Camera;

fn prepass_normals(normals: texture_2d<f32>, camera: Camera, at: Point) -> vec4f {
    let normal = 2.0 * texel(normals, at.pixel).xyz - 1.0;
    let turned = (camera.view * vec4f(normal, 0.0)).xyz;
    return vec4f(turned / max(length(turned), 1e-6), 1.0);
}
