//! The entry point of a halving by rows: a workgroup walks down its columns, and each step gives one row of the result.

use afterimage_graph::node::{Pass, RowDownsample};
use afterimage_wgsl::ShaderError;

use super::module::{Composed, PassCode};
use super::writer::FunctionWriter;

/// Invocations of a workgroup. The outermost ones only make what their neighbors need.
const ROW_INVOCATIONS: u32 = 64;

/// Columns on either side that a workgroup makes for those between them: one for the halving, and one more where texels
/// depend on their neighbors.
fn margin(rows: &RowDownsample) -> u32 {
    if rows.around.is_some() { 2 } else { 1 }
}

/// Texels of the result that a workgroup makes, across and down.
pub(super) fn rows_cover(rows: &RowDownsample) -> [u32; 2] {
    [ROW_INVOCATIONS - 2 * margin(rows), rows.rows]
}

/// A halving by rows with its entry point.
pub(super) fn compose_row_downsample(code: &PassCode<'_>, rows: &RowDownsample) -> Result<Composed, ShaderError> {
    let mut writer = FunctionWriter::new(code, code.linker())?;
    let halving = code.pass.results[0].kernel;
    let mut functions = writer.function("run", 0..rows.around.unwrap_or(halving));
    if let Some(around) = rows.around {
        functions += &writer.function_of_neighbors("change", around..halving);
    }
    let [results, calls] = stored(code, &mut writer);
    let names = Names {
        extent: writer.extent(),
        state: writer.name(halving, rows.state),
        results,
        calls,
        number: rows.around.map(|around| writer.name(around, number(code.pass, around))),
    };
    let entry_point = entry_point(&writer, rows, &names);
    writer.finish(&(functions + &entry_point), [ROW_INVOCATIONS, 1, 1], &["compute"])
}

/// The function that gives the number of a texel for its neighbors.
fn number(pass: &Pass, around: usize) -> &'static str {
    pass.kernels[around].by_neighbors.expect("a kernel that shares its neighbors has a form for it").number
}

/// The storage images of the results, and the functions that make their texels.
fn stored(code: &PassCode<'_>, writer: &mut FunctionWriter<'_, '_>) -> [Vec<String>; 2] {
    let (mut images, mut functions) = (Vec::new(), Vec::new());
    for result in &code.pass.results {
        images.push(writer.storage(result.image, code.format_of(result.image)));
        functions.push(writer.name(result.kernel, &code.pass.kernels[result.kernel].function));
    }
    [images, functions]
}

struct Names {
    extent: String,
    state: String,
    /// The storage images: that of the halving, and those of texels that depend on one square alone.
    results: Vec<String>,
    calls: Vec<String>,
    /// The function for the number of a texel, if texels depend on their neighbors.
    number: Option<String>,
}

fn entry_point(writer: &FunctionWriter<'_, '_>, rows: &RowDownsample, names: &Names) -> String {
    let (extent, state, margin) = (&names.extent, &names.state, margin(rows));
    let [covered, count] = rows_cover(rows);
    let walk = match &names.number {
        None => plain_walk(writer, names),
        Some(number) => walk_of_neighbors(writer, names, number),
    };
    let import = if names.number.is_some() { "#import neighbors\n" } else { "" };
    format!(
        "{import}fn point_of_source(pixel: vec2i) -> Point {{
    let size = 2.0 * {extent};
    let inside = clamp(pixel, vec2i(0), vec2i(size) - 1);
    return Point(inside, (vec2f(inside) + 0.5) / size, size);
}}
@compute @workgroup_size({ROW_INVOCATIONS})
fn compute(@builtin(workgroup_id) group: vec3u, @builtin(local_invocation_index) invocation: u32) {{
    let last = vec2i({extent}) - 1;
    let column = i32(group.x) * {covered} + i32(invocation) - {margin};
    let first = i32(group.y) * {count};
    let end = min(first + {count}, last.y + 1);
    let is_own = invocation >= {margin}u && invocation < {outer}u && column <= last.x;
    var state: {state};
{walk}}}",
        outer = ROW_INVOCATIONS - margin,
    )
}

/// The square of a row, from the texels of the source.
fn square(writer: &FunctionWriter<'_, '_>) -> String {
    let texels: Vec<String> = (0..4).map(|place| writer.call_at("run", place)).collect();
    format!(
        "        let corner = 2 * vec2i(column, row);
        let at0 = point_of_source(corner);
        let at1 = point_of_source(corner + vec2i(1, 0));
        let at2 = point_of_source(corner + vec2i(0, 1));
        let at3 = point_of_source(corner + vec2i(1, 1));
{loads}        let square = Square({texels});
",
        loads = writer.load_host_pixels(4, "        "),
        texels = texels.join(", "),
    )
}

/// Stores what depends on a square alone.
fn stores_of_squares(names: &Names) -> String {
    let of_squares = names.results.iter().zip(&names.calls).skip(1);
    let store = |(result, function)| format!("textureStore({result}, vec2i(column, row), {function}(square));");
    let stores: String = of_squares.map(store).map(|store| format!("            {store}\n")).collect();
    if stores.is_empty() {
        return stores;
    }
    format!("        if row >= first && row < end && is_own {{\n{stores}        }}\n")
}

/// From the row above the first to the one below the last: a step gives the row before.
fn plain_walk(writer: &FunctionWriter<'_, '_>, names: &Names) -> String {
    let (result, halve) = (&names.results[0], &names.calls[0]);
    format!(
        "    for (var row = first - 1; row <= end; row++) {{
{square}{stores}        let value = {halve}(&state, square, invocation);
        if row > first && is_own {{ textureStore({result}, vec2i(column, row - 1), value); }}
    }}
",
        square = square(writer),
        stores = stores_of_squares(names),
    )
}

/// A step makes the texels of a square, and changes those of the square before, whose neighbors are known now. So it
/// begins and ends a row further out. Beyond the border, squares consist of texels of the border as they are changed
/// there: above of the first row, which is known when the first square is, and below of the last one.
fn walk_of_neighbors(writer: &FunctionWriter<'_, '_>, names: &Names, number: &str) -> String {
    let (result, halve) = (&names.results[0], &names.calls[0]);
    format!(
        "    let place = neighbors_place(column, last.x, invocation);
    var next: NeighborsSeen;
    var changed: Square;
    for (var row = first - 2; row <= end + 1; row++) {{
{square}        let numbers = vec4f({number}(square.upper_left), {number}(square.upper_right),
            {number}(square.lower_left), {number}(square.lower_right));
        let rows = neighbors_share(numbers, row >= 0 && row <= last.y, row, place);
        var seen = next;
        next = NeighborsSeen(square, seen.rows.lower, rows);
        if row < first {{ continue; }}
{stores}        if row == 0 {{ seen = NeighborsSeen(neighbors_upper(square), vec4f(), rows); }}
        let around = neighbors_of(seen, rows.upper);
        let upper_left = change(point_of_source(corner - vec2i(0, 2)), seen.square.upper_left, around[0]);
        let upper_right = change(point_of_source(corner - vec2i(-1, 2)), seen.square.upper_right, around[1]);
        let lower_left = change(point_of_source(corner - vec2i(0, 1)), seen.square.lower_left, around[2]);
        let lower_right = change(point_of_source(corner - vec2i(-1, 1)), seen.square.lower_right, around[3]);
        if row > last.y + 1 {{
            changed = neighbors_lower(changed);
        }} else {{
            changed = neighbors_clamped(Square(upper_left, upper_right, lower_left, lower_right), column, last.x);
        }}
        if row == 0 {{ changed = neighbors_upper(changed); }}
        let value = {halve}(&state, changed, invocation);
        if row > first + 1 && is_own {{ textureStore({result}, vec2i(column, row - 2), value); }}
    }}
",
        square = square(writer),
        stores = stores_of_squares(names),
    )
}
