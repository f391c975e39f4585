//! The entry point of a halving by rows: a workgroup walks down its columns, and each step gives one row of the result.

use afterimage_graph::node::{Pass, RowDownsample};
use afterimage_wgsl::ShaderError;

use super::functions::TRIAL;
use super::module::{Composed, PassCode};
use super::writer::FunctionWriter;

/// Imports for the code of a halving.
const IMPORTS: &str = "import afterimage::neighbors::{
    Around, neighbors_known, neighbors_put, neighbors_texel, neighbors_within,
};
import afterimage::halves::{halves_across, halves_down};
";

/// Invocations of a workgroup. The outermost ones only make what their neighbors need.
const ROW_INVOCATIONS: u32 = 64;

/// Texels of the result that a workgroup makes, across and down. With an odd number of columns, each invocation needs
/// a texel of the next one besides.
pub(super) fn rows_cover(rows: &RowDownsample) -> [u32; 2] {
    [ROW_INVOCATIONS - 2 - rows.odd[0], rows.rows]
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
    let (extent, state) = (&names.extent, &names.state);
    let [covered, count] = rows_cover(rows);
    let [wide, high] = rows.odd;
    let walk = walk(writer, rows, names);
    let around = names.neighbors.as_ref().map_or_else(String::new, |neighbors| around_texels(writer, neighbors));
    let above = if high == 1 { "    var above: Square;\n" } else { "" };
    format!(
        "fn point_of_source(pixel: vec2i) -> Point {{
    let size = 2.0 * {extent} + vec2f({wide}, {high});
    let inside = clamp(pixel, vec2i(0), vec2i(size) - 1);
    return Point(inside, (vec2f(inside) + 0.5) / size, size);
}}
{around}@compute @workgroup_size({ROW_INVOCATIONS})
fn compute(@builtin(workgroup_id) group: vec3u, @builtin(local_invocation_index) invocation: u32) {{
    let size = vec2i({extent});
    let first = vec2i(group.xy) * vec2i({covered}, {count});
    let end = min(first + vec2i({covered}, {count}), size);
    let column = first.x + i32(invocation) - 1;
    let is_own = column >= first.x && column < end.x;
    var state: {state};
{above}{walk}}}"
    )
}

/// Statements that make a square for the halving of one of texels, `square`, and what it is called. If the number of
/// rows is odd, it is the square of the row before.
fn halves(rows: &RowDownsample, square: &str) -> (String, String) {
    let (mut statements, mut name) = (String::new(), square.to_owned());
    if rows.odd[0] == 1 {
        statements += &format!("        let across = halves_across({name}, column, size.x, row, invocation);\n");
        name = "across".into();
    }
    if rows.odd[1] == 1 {
        statements += &format!("        let halves = halves_down(&above, {name}, row - 1, size.y);\n");
        name = "halves".into();
    }
    (statements, name)
}

/// The square of a row of an open source, of whose texels beyond the border a half counts.
fn open(rows: &RowDownsample, square: &str) -> String {
    let [wide, high] = rows.odd;
    format!("square_open({square}, 2 * vec2i(column, row), 2 * size + vec2i({wide}, {high}))")
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
    let tried = writer.try_light(4, &format!("        var square = {made}"));
    format!(
        "{places}{loads}{tried}        if light_lowest < 0.0 {{
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
    let kept = match rows.odd {
        [0, 0] => "row >= first.y && row < end.y && is_own".to_owned(),
        [wide, high] => format!(
            "row >= first.y && column >= first.x \
             && all(vec2i(column, row) < end + select(vec2i(), vec2i({wide}, {high}), end == size))"
        ),
    };
    format!("        if {kept} {{\n{stores}        }}\n")
}

/// The texels of a square, in the order of their places.
const TEXELS: [&str; 4] = ["upper_left", "upper_right", "lower_left", "lower_right"];

/// The places around a texel, in the order of the numbers of an `Around`.
const PLACES: [&str; 8] = ["-1, -1", "0, -1", "1, -1", "-1, 0", "1, 0", "-1, 1", "0, 1", "1, 1"];

/// A text for each texel of a square.
fn of_texels(text: &dyn Fn(usize, &str) -> String) -> String {
    let texels: Vec<String> = TEXELS.iter().enumerate().map(|(index, texel)| text(index, texel)).collect();
    texels.join(", ")
}

/// A function to the numbers around a texel, and one that changes those texels of a square that may change.
///
/// Few texels change, so their neighbors are made again, all at once: in a loop, each waits for the one before.
fn around_texels(writer: &FunctionWriter<'_, '_>, neighbors: &NeighborNames) -> String {
    let point = |(index, place)| format!("    let at{index} = point_of_source(p + vec2i({place}));\n");
    let points: String = PLACES.iter().enumerate().map(point).collect();
    let known = |place: usize| {
        let texel = writer.call_at("run", place as u32);
        format!("neighbors_known({}({texel}), at{place}.pixel, p + vec2i({}))", neighbors.number, PLACES[place])
    };
    let known = |places: std::ops::Range<usize>| places.map(known).collect::<Vec<_>>().join(",\n            ");
    format!(
        "fn around_texel(p: vec2i) -> Around {{
{points}{loads}    return Around(
        vec3f({upper}),
        vec2f({beside}),
        vec3f({lower}),
    );
}}
fn changed_square(square: Square, first: vec2i, may_change: vec4<bool>) -> Square {{
    let zero = min(point_of_source(first).pixel.x, 0);
    var changed = square;
    for (var index = 0; index < 4 + zero; index++) {{
        if !may_change[index] {{ continue; }}
        let at = point_of_source(first + vec2i(index % 2, index / 2));
        let texel = change(at, neighbors_texel(square, index), around_texel(at.pixel));
        changed = neighbors_put(changed, index, texel);
    }}
    return changed;
}}
",
        loads = writer.load_pixels(8, "    "),
        upper = known(0..3),
        beside = known(3..5),
        lower = known(5..8),
    )
}

/// Statements that change the texels of the square of a row by their neighbors, and what it is called then.
///
/// A texel that does not stand out among the others of its square does not among all.
fn change(neighbors: &NeighborNames) -> (String, &'static str) {
    let NeighborNames { number, changes, finishes } = neighbors;
    let numbers = of_texels(&|_, texel| format!("{number}(square.{texel})"));
    let may_change = of_texels(&|index, texel| format!("{changes}(square.{texel}, around[{index}])"));
    let changed = format!(
        "        let around = neighbors_within(vec4f({numbers}), at0.pixel == at3.pixel);
        let may_change = vec4<bool>({may_change});
        var changed = square;
        if any(may_change) {{ changed = changed_square(square, 2 * vec2i(column, row), may_change); }}
"
    );
    if !finishes {
        return (changed, "changed");
    }
    let finished = of_texels(&|index, texel| format!("finish(at{index}, changed.{texel})"));
    (format!("{changed}        let finished = Square({finished});\n"), "finished")
}

/// From the row above the first to the one below the last: a step gives the row before.
///
/// With neighbors it needs many registers, so few workgroups wait at once: each step loads the texels of the next one
/// before it uses its own. A walk without neighbors takes longer so.
fn walk(writer: &FunctionWriter<'_, '_>, rows: &RowDownsample, names: &Names) -> String {
    let (result, halve) = (&names.results[0], &names.calls[0]);
    let ahead = |row: &str, indent: &str| match writer.load_ahead(4, indent) {
        loads if loads.is_empty() => loads,
        loads => places("next", row, indent) + &loads,
    };
    let (declared, loads) = match names.neighbors {
        None => (String::new(), writer.load_raw(4, INDENT)),
        Some(_) => (
            writer.declare_ahead(4, "    ") + &ahead("first.y - 1", "    "),
            writer.take_ahead(4, INDENT) + &ahead("row + 1", INDENT),
        ),
    };
    let (changed, name) = names.neighbors.as_ref().map_or_else(|| (String::new(), "square"), change);
    let (lit, name) = match rows.is_open {
        true => (format!("        let lit = {};\n", open(rows, name)), "lit"),
        false => (String::new(), name),
    };
    let (halves, given) = halves(rows, name);
    format!(
        "{declared}    for (var row = first.y - 1; row <= end.y + {late}; row++) {{
{square}{stores}{changed}{lit}{halves}        let value = {halve}(&state, {given}, invocation);
        if row > first.y + {late} && is_own {{ textureStore({result}, vec2i(column, row - 1 - {late}), value); }}
    }}
",
        late = rows.odd[1],
        square = square(writer, &loads),
        stores = stores_of_squares(rows, names),
    )
}
