//! The entry point of a function of one pixel whose invocations share the memory of a workgroup.

use afterimage_wgsl::ShaderError;

use super::module::{Composed, PassCode};
use super::writer::FunctionWriter;

/// A pass of one kernel function with its entry point: one invocation for each texel, also beyond the border, where the
/// others may wait for it. The workgroup is a row for the device.
pub(super) fn compose_in_workgroup(code: &PassCode<'_>, [width, height]: [u32; 2]) -> Result<Composed, ShaderError> {
    let image = code.pass.results[0].image;
    let desc = (code.desc_of)(image);
    let mut writer = FunctionWriter::new(code, code.linker())?;
    let extent = writer.extent();
    let nearest = format!("point_at(clamp(here.pixel, vec2i(), vec2i({extent}) - 1))");
    let function = writer.workgroup_function("run", &nearest);
    let result = writer.storage(image, desc.format);
    let invocations = width * height;
    let entry_point = format!(
        "fn point_at(pixel: vec2i) -> Point {{
    return Point(pixel, (vec2f(pixel) + 0.5) / {extent}, {extent});
}}
{function}@compute @workgroup_size({invocations})
fn compute(invocation: Invocation, @builtin(workgroup_id) group: vec3u) {{
    let local = vec2u(invocation.index % {width}u, invocation.index / {width}u);
    let pixel = vec2i(group.xy * vec2u({width}u, {height}u) + local);
    let value = run(point_at(pixel), invocation);
    if all(pixel < vec2i({extent})) {{ textureStore({result}, pixel, value); }}
}}
"
    );
    writer.finish("import afterimage::workgroup::Invocation;\n", &entry_point, [invocations, 1, 1], &["compute"])
}
