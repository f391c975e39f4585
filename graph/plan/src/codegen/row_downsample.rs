//! The entry point of a halving by rows: a workgroup walks down its columns, and each step gives one row of the result.

use afterimage_graph::node::{Pass, RowDownsample};
use afterimage_wgsl::ShaderError;

use super::functions::TRIAL;
use super::module::{Composed, PassCode};
use super::writer::FunctionWriter;

/// Imports for the code of a halving.
const IMPORTS: &str = "import afterimage::neighbors::{
    Around, NeighborsSeen, neighbors_clamped, neighbors_inside, neighbors_lower, neighbors_of, neighbors_place,
    neighbors_share, neighbors_upper,
};
import afterimage::halves::{halves_across, halves_down};
";

/// Invocations of a workgroup. The outermost ones only make what their neighbors need.
const ROW_INVOCATIONS: u32 = 64;

/// Columns on either side that a workgroup makes for those between them: one for the halving, and one more where texels
/// depend on their neighbors.
fn margin(rows: &RowDownsample) -> u32 {
    if rows.around.is_some() { 2 } else { 1 }
}

/// Texels of the result that a workgroup makes, across and down. With an odd number of columns, each invocation needs
/// a texel of the next one besides.
pub(super) fn rows_cover(rows: &RowDownsample) -> [u32; 2] {
    [ROW_INVOCATIONS - 2 * margin(rows) - rows.odd[0], rows.rows]
}

/// A halving by rows with its entry point.
pub(super) fn compose_row_downsample(code: &PassCode<'_>, rows: &RowDownsample) -> Result<Composed, ShaderError> {
    let mut writer = FunctionWriter::new(code, code.linker())?;
    if rows.around.is_some() {
        // It loads them ahead.
        writer.load_all_pixels();
    }
    let halving = code.pass.results[0].kernel;
    let mut functions = writer.function("run", 0..rows.around.unwrap_or(halving));
    if let Some(around) = rows.around {
        functions += &writer.function_after("change", around..around + 1, ", around: Around");
        if around + 1 < halving {
            functions += &writer.function_after("finish", around + 1..halving, "");
        }
    }
    let [results, calls] = stored(code, &mut writer);
    let names = Names {
        extent: writer.extent(),
        state: writer.name(halving, rows.state),
        results,
        calls,
        neighbors: rows.around.map(|around| NeighborNames::new(code.pass, &writer, around, halving)),
    };
    let entry_point = entry_point(&writer, rows, &names);
    let imports = [TRIAL, IMPORTS].concat();
    writer.finish(&imports, &(functions + &entry_point), [ROW_INVOCATIONS, 1, 1], &["compute"])
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
    /// If texels depend on their neighbors, what they are changed by.
    neighbors: Option<NeighborNames>,
}

struct NeighborNames {
    /// The functions for the number of a texel, and for whether it may change.
    number: String,
    changes: String,
    /// True if there are functions of the texels that are changed.
    finishes: bool,
}

impl NeighborNames {
    fn new(pass: &Pass, writer: &FunctionWriter<'_, '_>, around: usize, halving: usize) -> Self {
        let form = pass.kernels[around].by_neighbors.expect("a kernel that shares its neighbors has a form for it");
        let (number, changes) = (writer.name(around, form.number), writer.name(around, form.changes));
        Self { number, changes, finishes: around + 1 < halving }
    }
}

fn entry_point(writer: &FunctionWriter<'_, '_>, rows: &RowDownsample, names: &Names) -> String {
    let (extent, state, margin) = (&names.extent, &names.state, margin(rows));
    let [covered, count] = rows_cover(rows);
    let [wide, high] = rows.odd;
    let walk = match &names.neighbors {
        None => plain_walk(writer, rows, names),
        Some(neighbors) => walk_of_neighbors(writer, rows, names, neighbors),
    };
    let above = if high == 1 { "    var above: Square;\n" } else { "" };
    format!(
        "fn point_of_source(pixel: vec2i) -> Point {{
    let size = 2.0 * {extent} + vec2f({wide}, {high});
    let inside = clamp(pixel, vec2i(0), vec2i(size) - 1);
    return Point(inside, (vec2f(inside) + 0.5) / size, size);
}}
@compute @workgroup_size({ROW_INVOCATIONS})
fn compute(@builtin(workgroup_id) group: vec3u, @builtin(local_invocation_index) invocation: u32) {{
    let size = vec2i({extent});
    let first = vec2i(group.xy) * vec2i({covered}, {count});
    let end = min(first + vec2i({covered}, {count}), size);
    let column = first.x + i32(invocation) - {margin};
    let is_own = column >= first.x && column < end.x;
    var state: {state};
{above}{walk}}}"
    )
}

/// Statements that make a square for the halving of one of texels, `square`, that lies in the row `row`; and what it is
/// called. If the number of rows is odd, it is the square of the row before.
fn halves(rows: &RowDownsample, square: &str, row: &str) -> (String, String) {
    let (mut statements, mut name) = (String::new(), square.to_owned());
    if rows.odd[0] == 1 {
        statements += &format!("        let across = halves_across({name}, column, size.x, row, invocation);\n");
        name = "across".into();
    }
    if rows.odd[1] == 1 {
        statements += &format!("        let halves = halves_down(&above, {name}, {row} - 1, size.y);\n");
        name = "halves".into();
    }
    (statements, name)
}

/// The square of a row of an open source, of whose texels beyond the border a half counts.
fn open(rows: &RowDownsample, square: &str, row: &str) -> String {
    let [wide, high] = rows.odd;
    format!("square_open({square}, 2 * vec2i(column, {row}), 2 * size + vec2i({wide}, {high}))")
}

/// The places of the square of a row, whose names begin with `places`.
fn places(places: &str, row: &str, indent: &str) -> String {
    let offsets = ["0, 0", "1, 0", "0, 1", "1, 1"];
    let place = |(index, offset): (usize, &&str)| {
        format!("{indent}let {places}{index} = point_of_source(2 * vec2i(column, {row}) + vec2i({offset}));\n")
    };
    offsets.iter().enumerate().map(place).collect()
}

/// The square of a row, from the texels of the source, which `loads` has loaded.
fn square(writer: &FunctionWriter<'_, '_>, loads: &str) -> String {
    let texels: Vec<String> = (0..4).map(|place| writer.call_at("run", place)).collect();
    let places = places("at", "row", INDENT);
    let made = format!("Square({});\n", texels.join(", "));
    if !writer.loads_light() {
        let sanitized = writer.sanitize_pixels(4, INDENT);
        return format!("{places}{loads}{sanitized}        let square = {made}");
    }
    let (_, repairs) = writer.limits_of_pixels(4, INDENT);
    let tried = writer.try_light(4, &format!("        square = {made}"), "");
    format!(
        "{places}{loads}        var square: Square;\n{tried}        if light_lowest < 0.0 {{
{repairs}            square = {made}        }}
"
    )
}

const INDENT: &str = "        ";

/// Stores what depends on a square alone: also on the last one, of which an image with an odd side has a part.
fn stores_of_squares(rows: &RowDownsample, names: &Names) -> String {
    let of_squares = names.results.iter().zip(&names.calls).skip(1);
    let store = |(result, function)| format!("textureStore({result}, vec2i(column, row), {function}(square));");
    let stores: String = of_squares.map(store).map(|store| format!("            {store}\n")).collect();
    if stores.is_empty() {
        return stores;
    }
    let [wide, high] = rows.odd;
    format!(
        "        let beyond = end + select(vec2i(0), vec2i({wide}, {high}), end == size);
        if row >= first.y && row < beyond.y && column >= first.x && column < beyond.x {{
{stores}        }}
"
    )
}

/// From the row above the first to the one below the last: a step gives the row before.
fn plain_walk(writer: &FunctionWriter<'_, '_>, rows: &RowDownsample, names: &Names) -> String {
    let (result, halve) = (&names.results[0], &names.calls[0]);
    let (lit, name) = match rows.is_open {
        true => (format!("        let lit = {};\n", open(rows, "square", "row")), "lit"),
        false => (String::new(), "square"),
    };
    let (halves, given) = halves(rows, name, "row");
    format!(
        "    for (var row = first.y - 1; row <= end.y + {late}; row++) {{
{square}{stores}{lit}{halves}        let value = {halve}(&state, {given}, invocation);
        if row > first.y + {late} && is_own {{ textureStore({result}, vec2i(column, row - 1 - {late}), value); }}
    }}
",
        late = rows.odd[1],
        square = square(writer, &writer.load_raw(4, INDENT)),
        stores = stores_of_squares(rows, names),
    )
}

/// The place of each texel of a square, from that of the square below it, and its name.
const TEXELS: [(&str, &str); 4] =
    [("0, -2", "upper_left"), ("1, -2", "upper_right"), ("0, -1", "lower_left"), ("1, -1", "lower_right")];

/// A step makes the texels of a square, and changes those of the square before, whose neighbors are known now. So it
/// begins and ends a row further out. Beyond the border, squares consist of texels of the border as they are changed
/// there: above of the first row, which is known when the first square is, and below of the last one. Of an image with
/// an odd side, so does the part of the last square that is beyond.
///
/// It needs many registers, so few workgroups wait at once: each step loads the texels of the next one before it uses
/// its own. A walk without neighbors takes longer so.
fn walk_of_neighbors(
    writer: &FunctionWriter<'_, '_>,
    rows: &RowDownsample,
    names: &Names,
    neighbors: &NeighborNames,
) -> String {
    let (result, halve) = (&names.results[0], &names.calls[0]);
    let (halves, given) = halves(rows, if rows.is_open { "lit" } else { "changed" }, "(row - 1)");
    let [wide, high] = rows.odd;
    let NeighborNames { number, changes, finishes } = neighbors;
    let of_texels = |text: &dyn Fn(usize, &str, &str) -> String, between: &str| {
        let texels = TEXELS.iter().enumerate().map(|(index, (offset, texel))| text(index, offset, texel));
        texels.collect::<Vec<_>>().join(between)
    };
    let may_change = of_texels(&|index, _, texel| format!("{changes}(seen.square.{texel}, around[{index}])"), ", ");
    let point = |offset: &str| format!("point_of_source(2 * vec2i(column, row) + vec2i({offset}))");
    let change = |index: usize, offset: &str, texel: &str| {
        format!("                change({}, seen.square.{texel}, around[{index}]),\n", point(offset))
    };
    let finish = |_: usize, offset: &str, texel: &str| match finishes {
        true => format!("finish({}, seen.square.{texel})", point(offset)),
        false => format!("seen.square.{texel}"),
    };
    let finished = format!("Square({})", of_texels(&finish, ", "));
    let ahead = |row: &str, indent: &str| match writer.load_ahead(4, indent) {
        loads if loads.is_empty() => loads,
        loads => places("next", row, indent) + &loads,
    };
    let loads = writer.take_ahead(4, INDENT) + &ahead("row + 1", INDENT);
    format!(
        "    let last = size - 1 + vec2i({wide}, {high});
    let place = neighbors_place(column, last.x, invocation);
    var next: NeighborsSeen;
    var changed: Square;
{declared}{first}    for (var row = first.y - 2; row <= end.y + 1 + {high}; row++) {{
{square}        let numbers = vec4f({number}(square.upper_left), {number}(square.upper_right),
            {number}(square.lower_left), {number}(square.lower_right));
        let rows = neighbors_share({known}, row >= 0 && row <= last.y, row, place);
        var seen = next;
        next = NeighborsSeen(square, seen.rows.lower, rows);
        if row < first.y {{ continue; }}
{stores}        if row == 0 {{ seen = NeighborsSeen(neighbors_upper(square), vec4f(), rows); }}
        let around = neighbors_of(seen, rows.upper);
        if any(vec4<bool>({may_change})) {{
            seen.square = Square(
{change}            );
        }}
        if row > last.y + 1 {{
            changed = neighbors_lower(changed);
        }} else {{
            changed = neighbors_clamped({finished}, column, size.x - 1);
        }}
        if row == 0{or_last} {{ changed = neighbors_upper(changed); }}
{lit}{halves}        let value = {halve}(&state, {given}, invocation);
        if row > first.y + 1 + {high} && is_own {{ textureStore({result}, vec2i(column, row - 2 - {high}), value); }}
    }}
",
        declared = writer.declare_ahead(4, "    "),
        first = ahead("first.y - 2", "    "),
        square = square(writer, &loads),
        stores = stores_of_squares(rows, names),
        known = match rows.odd {
            [0, 0] => "numbers".to_owned(),
            [wide, high] => format!(
                "neighbors_inside(numbers, vec2<bool>({}, {}))",
                if wide == 1 { "column < size.x" } else { "true" },
                if high == 1 { "row < size.y" } else { "true" },
            ),
        },
        change = of_texels(&change, ""),
        or_last = if high == 1 { " || row == last.y + 1" } else { "" },
        lit = match rows.is_open {
            true => format!("        let lit = {};\n", open(rows, "changed", "(row - 1)")),
            false => String::new(),
        },
    )
}
