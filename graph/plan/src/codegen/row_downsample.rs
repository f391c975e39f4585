//! The entry point of a halving by rows: a workgroup walks down its columns, and each step gives one row of the result.

use super::functions::{KernelWriter, params_struct, promises};
use super::module::Composed;
use super::uniforms::uniform_struct;
use afterimage_base::Shared;
use afterimage_base::image::Format;
use afterimage_graph::node::{ImageId, KernelCall, Pass, RowDownsample};
use afterimage_wgsl::{SampleMode, Shader, ShaderError, ShaderFeatures, Text};

/// Invocations of a workgroup, the fewest that there are. The first and the last only bring what their neighbours need.
pub(super) const ROW_INVOCATIONS: u32 = 64;

/// A halving by rows with its entry point.
pub(super) fn compose_row_downsample(
    pass: &Pass,
    rows: &RowDownsample,
    (result, format): (ImageId, Format),
    sample_mode_of: &dyn Fn(ImageId) -> SampleMode,
    features: ShaderFeatures,
) -> Result<Composed, ShaderError> {
    let (halving, source) = pass.kernels.split_last().expect("a halving has kernels");
    let mut writer = KernelWriter::new(sample_mode_of);
    let reading = writer.strictest(source);
    writer.kernels(0, source, 0);
    let function = writer.take_function("run", source.len() - 1);
    let storage = writer.storage(result, format);
    let extent = writer.extent();
    let mut text = Text::promising(promises(source)).reading(reading, features)?;
    for kernel in &pass.kernels {
        text.module(&kernel.shader)?;
    }
    text.generated(&uniform_struct(pass, &|at| params_struct(&pass.kernels[at])));
    text.generated(writer.declarations());
    text.generated(&function);
    text.generated(&entry((rows, halving), &storage, &extent));
    Ok(Composed {
        source: text.text,
        map: text.map,
        compute: Shared::of("compute"),
        fragment: None,
        slots: writer.into_slots(),
        workgroup: [ROW_INVOCATIONS, 1, 1],
        unchecked: pass.shaders().all(Shader::is_unchecked),
        reading,
        zero_workgroup_memory: false,
    })
}

fn entry((rows, halving): (&RowDownsample, &KernelCall), result: &str, extent: &str) -> String {
    format!(
        "fn texel_of_source(pixel: vec2i) -> vec4f {{
    let size = 2.0 * {extent};
    let inside = clamp(pixel, vec2i(0), vec2i(size) - 1);
    return run(Point(inside, (vec2f(inside) + 0.5) / size, size));
}}
@compute @workgroup_size({lanes})
fn compute(@builtin(workgroup_id) group: vec3u, @builtin(local_invocation_index) lane: u32) {{
    let last = vec2i({extent}) - 1;
    let column = i32(group.x) * {covered} + i32(lane) - 1;
    let first = i32(group.y) * {count};
    let end = min(first + {count}, last.y + 1);
    var state: {state};
    for (var row = first - 1; row <= end; row++) {{
        let corner = 2 * vec2i(column, row);
        let square = Square(
            texel_of_source(corner),
            texel_of_source(corner + vec2i(1, 0)),
            texel_of_source(corner + vec2i(0, 1)),
            texel_of_source(corner + vec2i(1, 1)),
        );
        let value = {function}(&state, square, lane);
        if row > first && lane > 0u && lane < {last_lane}u && column <= last.x {{
            textureStore({result}, vec2i(column, row - 1), value);
        }}
    }}
}}",
        lanes = ROW_INVOCATIONS,
        covered = ROW_INVOCATIONS - 2,
        last_lane = ROW_INVOCATIONS - 1,
        count = rows.rows,
        state = rows.state,
        function = halving.function,
    )
}
