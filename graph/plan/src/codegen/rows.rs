//! The entry point of a halving by rows: a workgroup walks down its columns, and each step gives one row of the result.

use super::compose::{Composed, StepsWriter, promises, uniform_struct};
use afterimage_base::Shared;
use afterimage_base::image::Format;
use afterimage_graph::node::{ImageId, Rows};
use afterimage_wgsl::{SampleMode, ShaderError, ShaderFeatures, Text};

/// Invocations of a workgroup, the fewest that there are. The first and the last only bring what their neighbours need.
pub const ROW_LANES: u32 = 64;

/// A halving by rows with its entry point.
pub(crate) fn compose_rows(
    rows: &Rows,
    format: Format,
    sample_mode_of: &dyn Fn(ImageId) -> SampleMode,
    features: ShaderFeatures,
) -> Result<Composed, ShaderError> {
    let mut writer = StepsWriter::new(sample_mode_of);
    let reading = writer.strictest(&rows.source);
    writer.stage(0, &rows.source, 0);
    let function = writer.take_function("run", rows.source.len() - 1);
    let storage = writer.storage(rows.result, format);
    let extent = writer.extent();
    let mut text = Text::promising(promises(&rows.source)).reading(reading, features)?;
    for step in &rows.source {
        text.module(&step.shader)?;
    }
    text.module(rows.by.shader)?;
    text.generated(&uniform_struct(&rows.source));
    text.generated(writer.declarations());
    text.generated(&function);
    text.generated(&entry(rows, &storage, &extent));
    Ok(Composed {
        source: text.text,
        map: text.map,
        compute: Shared::of("compute"),
        fragment: None,
        slots: writer.into_slots(),
        workgroup: [ROW_LANES, 1, 1],
        unchecked: rows.by.shader.is_unchecked() && rows.source.iter().all(|step| step.shader.is_unchecked()),
        reading,
    })
}

fn entry(rows: &Rows, result: &str, extent: &str) -> String {
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
        lanes = ROW_LANES,
        covered = ROW_LANES - 2,
        last_lane = ROW_LANES - 1,
        count = rows.rows,
        state = rows.by.state,
        function = rows.by.function,
    )
}
