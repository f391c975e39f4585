//! The entry points of a pass of functions of one pixel: a compute one and a full-screen triangle.

use afterimage_base::image::Size;
use afterimage_graph::node::{KernelCall, Pass};
use afterimage_wgsl::{RegisterPressure, Shader, ShaderError};

use super::module::{Composed, PassCode};
use super::writer::FunctionWriter;
use crate::limits::MAX_PASS_OPERATIONS;

const FULL_SCREEN_TRIANGLE: &str = "
@vertex
fn vertex(@builtin(vertex_index) index: u32) -> @builtin(position) vec4f {
    let uv = vec2f(f32(2u * (index & 1u)), f32(index & 2u));
    return vec4f(2.0 * uv.x - 1.0, 1.0 - 2.0 * uv.y, 0.0, 1.0);
}";

/// Imports for code that tries light.
pub(super) const TRIAL: &str = "import afterimage::trial::{light_is_tried, light_lowest};\n";

/// Invocations of a workgroup, across and down. On an H200 half as many take 2 per cent less time than 16x16 do,
/// because their waiting overlaps more.
const WIDTH: u32 = 16;
const HEIGHT: u32 = 8;

/// A pass of kernel functions with its entry points.
pub(super) fn compose_functions(code: &PassCode<'_>) -> Result<Composed, ShaderError> {
    let image = code.pass.function_result().expect("a pass of functions has a result");
    let desc = (code.desc_of)(image);
    let mut writer = FunctionWriter::new(code, code.linker())?;
    let function = writer.function("run", 0..code.pass.kernels.len());
    let (result, extent) = (writer.storage(image, desc.format), writer.extent());
    let origin = writer.origin();
    let column = Column::of(code, desc.size);
    let entry_points = entry_points(&writer, &result, origin.as_deref(), &extent, &column);
    writer.finish(TRIAL, &(function + &entry_points), [WIDTH, HEIGHT, 1], &["compute", "vertex", "fragment"])
}

/// Texels of a result of that size that a workgroup makes, across and down. `sanitizes` states whether the pass
/// sanitizes the textures that it reads around a pixel.
pub(crate) fn functions_cover(pass: &Pass, size: Size, sanitizes: bool) -> [u32; 2] {
    [WIDTH, HEIGHT * rows_of(pass, size, sanitizes)]
}

/// Texels that an invocation makes, one below the other. Several in flight hide each other's waiting, but a small image
/// needs all of its texels to occupy the device, and what computes much needs registers. On an H200 at 4K, four take 25
/// to 40 % less time than one for reads around a pixel, such as those of `Streaks` and `Smaa`; for curves with many
/// powers two take 4 to 5 % less, and four as long as one; of long loops, those of `DemoScene` take 1.7 times as long
/// for two. Texels of host images that are read around a pixel are examined one by one, and overlap no others.
fn rows_of(pass: &Pass, size: Size, sanitizes: bool) -> u32 {
    if sanitizes {
        return 1;
    }
    let rows = match (register_pressure(pass), size.texels()) {
        (RegisterPressure::High, _)
        | (RegisterPressure::Medium, 0..0x40_0000)
        | (RegisterPressure::Low, 0..0x4_0000) => 1,
        (RegisterPressure::Medium, _) | (RegisterPressure::Low, 0x4_0000..0x10_0000) => 2,
        (RegisterPressure::Low, _) => 4,
    };
    // Each is compiled by itself. What is long and untrusted is compiled once.
    let is_trusted = !pass.shaders().any(Shader::is_untrusted);
    match MAX_PASS_OPERATIONS / pass.compile_cost().operations().max(1) {
        _ if is_trusted => rows,
        0 | 1 => 1,
        2 | 3 => rows.min(2),
        _ => rows,
    }
}

fn register_pressure(pass: &Pass) -> RegisterPressure {
    pass.kernels.iter().map(KernelCall::register_pressure).max().unwrap_or_default()
}

/// The texels that an invocation makes, one below the other.
struct Column {
    rows: u32,
    /// Rows between two of them.
    apart: u32,
    /// True if no function reads more than two texels besides its pixel.
    reads_few: bool,
}

impl Column {
    /// Functions that read many texels, without long loops, are called for pixels beside each other: where they read
    /// the same texel around two pixels, drivers load it once. On an H200 at 4K, `Cas` takes 73 us so, and 112 us with
    /// rows eight apart; but the loop of `GodRays` takes 413 us at 8K, and 244 us apart. Where an image ends within a
    /// column, they are apart, too: the limit of such places hides that texels are the same.
    fn of(code: &PassCode<'_>, size: Size) -> Column {
        const FEW: usize = 2;
        let reads_few = code.pass.kernels.iter().all(|kernel| kernel.shader.texel_reads(&kernel.function) <= FEW);
        let rows = rows_of(code.pass, size, code.sample_mode().sanitizes());
        let is_whole = size.height.is_multiple_of(rows) && !code.options.has_origin;
        let is_beside = is_whole && !reads_few && register_pressure(code.pass) == RegisterPressure::Low;
        Column { rows, apart: if is_beside { 1 } else { HEIGHT }, reads_few }
    }

    /// The expression of an invocation's first texel in its workgroup, from the bottom up. Invocations that run
    /// together share more texels in blocks than in rows: on an H200 at 4K, `Fxaa` takes 8 us less, of 106.
    fn first(&self) -> String {
        if self.reads_few {
            return "local.xy".into();
        }
        let step = if self.apart == 1 { self.rows } else { 1 };
        format!("vec2u(local.x % 4u + 4u * (local.y % 4u), {step}u * (local.x / 4u + 4u * (local.y / 4u)))")
    }
}

/// `origin` is the first texel of the result in its image.
fn entry_points(
    writer: &FunctionWriter<'_, '_>,
    result: &str,
    origin: Option<&str>,
    extent: &str,
    column: &Column,
) -> String {
    let Column { rows, apart, reads_few } = *column;
    let plus = origin.map_or(String::new(), |origin| format!(" + {origin}"));
    let minus = origin.map_or(String::new(), |origin| format!(" - {origin}"));
    // From the bottom up, because what the pass before has read last is still in the cache. Texels above the first row
    // are made like the first row, and not stored: a branch around each would let none overlap another.
    let (mut places, mut made, mut stored) = (String::new(), String::new(), String::new());
    for row in 0..rows {
        let offset = row * apart;
        let place = format!("first - vec2i(0, {offset})");
        let place = if apart == 1 { place } else { format!("max({place}, vec2i())") };
        places += &format!("    let at{row} = point_at({place});\n");
        made += &format!("    let value{row} = {};\n", writer.call_at("run", row));
        stored += &format!(
            "    if first.y >= {offset} {{ textureStore({result}, first - vec2i(0, {offset}){plus}, value{row}); }}\n"
        );
    }
    // Light is tried where several texels are made at once, and few are read: a trial waits for the pixels of the host,
    // and so would the reads of a tent (on an H200 at 4K, `mobile` takes 12 us less without). Those that are made again
    // are made one by one: their code stands there once, because the loop ends at a number that is not constant.
    let is_tried = rows > 1 && reads_few && writer.loads_light();
    let texels = if is_tried {
        let kept = format!("    if light_lowest >= 0.0 {{\n{stored}    return;\n    }}\n");
        format!(
            "{loads}{tried}{kept}    for (var row = 0; row < {rows} + min(size.x, 0); row++) {{
        if first.y < row * {apart} {{ break; }}
        let at0 = point_at(first - vec2i(0, row * {apart}));
{load}        textureStore({result}, at0.pixel{plus}, {run});
    }}
",
            loads = writer.load_raw(rows, "    "),
            tried = writer.try_light(rows, &made),
            load = writer.load_pixels(1, "        "),
            run = writer.call_at("run", 0),
        )
    } else {
        writer.load_pixels(rows, "    ") + &made + &stored
    };
    format!(
        "fn point_at(pixel: vec2i) -> Point {{
    return Point(pixel, (vec2f(pixel) + 0.5) / {extent}, {extent});
}}
@compute @workgroup_size({WIDTH}, {HEIGHT})
fn compute(@builtin(workgroup_id) group: vec3u, @builtin(local_invocation_id) local: vec3u) {{
    let away = vec2i(group.xy * vec2u({WIDTH}u, {}u) + {});
    let size = vec2i({extent});
    let first = vec2i(away.x, size.y - 1 - away.y);
    if first.x >= size.x || first.y < 0 {{ return; }}
{places}{texels}}}
{FULL_SCREEN_TRIANGLE}
@fragment
fn fragment(@builtin(position) position: vec4f) -> @location(0) vec4f {{
    let at0 = point_at(vec2i(position.xy){minus});
{load}    return {run};
}}",
        HEIGHT * rows,
        column.first(),
        load = writer.load_pixels(1, "    "),
        run = writer.call_at("run", 0),
    )
}
