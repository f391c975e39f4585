//! The entry point of a halving by rows: a workgroup walks down its columns, and each step gives one row of the result.

use afterimage_graph::node::RowDownsample;
use afterimage_wgsl::ShaderError;

use super::module::{Composed, PassCode};
use super::writer::FunctionWriter;

/// Invocations of a workgroup. The first and the last only make what their neighbors need.
pub(super) const ROW_INVOCATIONS: u32 = 64;

/// A halving by rows with its entry point. The last kernel halves what those before it make.
pub(super) fn compose_row_downsample(code: &PassCode<'_>, rows: &RowDownsample) -> Result<Composed, ShaderError> {
    let last = code.pass.kernels.len() - 1;
    let image = code.pass.results[0].image;
    let mut writer = FunctionWriter::new(code, code.linker())?;
    let function = writer.function("run", 0..last);
    let (result, extent) = (writer.storage(image, code.format_of(image)), writer.extent());
    let names = Names {
        result,
        extent,
        state: writer.name(last, rows.state),
        halve: writer.name(last, &code.pass.kernels[last].function),
    };
    let entry_point = entry_point(&writer, rows, &names);
    writer.finish(&(function + &entry_point), [ROW_INVOCATIONS, 1, 1], &["compute"])
}

struct Names {
    result: String,
    extent: String,
    state: String,
    halve: String,
}

fn entry_point(writer: &FunctionWriter<'_, '_>, rows: &RowDownsample, names: &Names) -> String {
    let texels: Vec<String> = (0..4).map(|place| writer.call_at("run", place)).collect();
    let Names { result, extent, state, halve } = names;
    format!(
        "fn point_of_source(pixel: vec2i) -> Point {{
    let size = 2.0 * {extent};
    let inside = clamp(pixel, vec2i(0), vec2i(size) - 1);
    return Point(inside, (vec2f(inside) + 0.5) / size, size);
}}
@compute @workgroup_size({invocations})
fn compute(@builtin(workgroup_id) group: vec3u, @builtin(local_invocation_index) invocation: u32) {{
    let last = vec2i({extent}) - 1;
    let column = i32(group.x) * {covered} + i32(invocation) - 1;
    let first = i32(group.y) * {count};
    let end = min(first + {count}, last.y + 1);
    var state: {state};
    for (var row = first - 1; row <= end; row++) {{
        let corner = 2 * vec2i(column, row);
        let at0 = point_of_source(corner);
        let at1 = point_of_source(corner + vec2i(1, 0));
        let at2 = point_of_source(corner + vec2i(0, 1));
        let at3 = point_of_source(corner + vec2i(1, 1));
{loads}        let square = Square({texels});
        let value = {halve}(&state, square, invocation);
        if row > first && invocation > 0u && invocation < {last_invocation}u && column <= last.x {{
            textureStore({result}, vec2i(column, row - 1), value);
        }}
    }}
}}",
        invocations = ROW_INVOCATIONS,
        covered = ROW_INVOCATIONS - 2,
        last_invocation = ROW_INVOCATIONS - 1,
        count = rows.rows,
        loads = writer.load_host_pixels(4, "        "),
        texels = texels.join(", "),
    )
}
