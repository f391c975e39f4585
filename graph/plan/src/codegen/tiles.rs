//! The entry point of a tiling: a chain of images, each kept in workgroup memory for the next.
//!
//! Kernel functions read textures through `texel` and `tap`. For a function that reads the image before, its file is written a second time under
//! other names, in which a texture is a number and those two read workgroup memory.

use afterimage_base::Shared;
use std::fmt::Write as _;

use super::compose::{Composed, StepsWriter, promises};
use afterimage_base::image::Format;
use afterimage_graph::node::{Arg, ImageId, Step, TileStage, Tiling};
use afterimage_wgsl::{SampleMode, ShaderError, ShaderFeatures, Text};

/// Invocations of a workgroup, across and down.
const TILE_SIDE: u32 = 16;

/// A tiling with its entry point.
pub(crate) fn compose_tiling(
    tiling: &Tiling,
    format_of: &dyn Fn(ImageId) -> Format,
    sample_mode_of: &dyn Fn(ImageId) -> SampleMode,
    features: ShaderFeatures,
) -> Result<Composed, ShaderError> {
    let steps: Vec<&Step> = tiling.stages.iter().flat_map(|stage| &stage.steps).collect();
    let mut writer = StepsWriter::new(sample_mode_of);
    let reading = writer.strictest(steps.iter().copied());
    let params = writer.params_variable();
    let mut functions = String::new();
    let mut first = 0;
    for (index, stage) in tiling.stages.iter().enumerate() {
        writer.stage(index, &stage.steps, first);
        functions += &writer.take_function(&format!("stage{index}"), first + stage.steps.len() - 1);
        first += stage.steps.len();
    }
    let stores: Vec<Option<String>> =
        tiling.stages.iter().map(|stage| stage.result.map(|image| writer.storage(image, format_of(image)))).collect();
    let mut text = Text::promising(promises(steps.iter().copied())).reading(reading, features)?;
    for step in steps.iter().filter(|step| !is_tiled(step)) {
        text.module(&step.shader)?;
    }
    text.generated(&uniform_struct(tiling, &steps));
    text.generated(writer.declarations());
    text.generated(&memory(tiling, &params));
    for step in steps.iter().filter(|step| is_tiled(step)) {
        text.tiled_module(&step.shader)?;
    }
    text.generated(&functions);
    text.generated(&entry(tiling, &stores, &params));
    Ok(Composed {
        source: text.text,
        map: text.map,
        compute: Shared::of("compute"),
        fragment: None,
        slots: writer.into_slots(),
        workgroup: [TILE_SIDE, TILE_SIDE, 1],
        unchecked: steps.iter().all(|step| step.shader.is_unchecked()),
        reading,
    })
}

/// Whether a step reads the image before.
pub(crate) fn is_tiled(step: &Step) -> bool {
    step.args.contains(&Arg::Tile)
}

fn uniform_struct(tiling: &Tiling, steps: &[&Step]) -> String {
    let mut text = format!("struct PassUniform {{\n    sizes: array<vec4i, {}>,\n", tiling.stages.len());
    for (index, step) in steps.iter().enumerate().filter(|(_, step)| !step.uniform.is_empty()) {
        let _ = writeln!(text, "    @align(16) step{index}: {},", super::compose::params_struct(step));
    }
    text + "}"
}

/// Where the image of each stage begins in workgroup memory: they lie in it by turns.
fn bases(tiling: &Tiling) -> (Vec<u32>, u32) {
    let kept = &tiling.stages[..tiling.stages.len() - 1];
    let area = |stage: &TileStage| stage.extent[0] * stage.extent[1];
    let even = kept.iter().step_by(2).map(area).max().unwrap_or(0);
    let odd = kept.iter().skip(1).step_by(2).map(area).max().unwrap_or(0);
    let bases = (0..kept.len()).map(|index| if index % 2 == 0 { 0 } else { even }).collect();
    (bases, even + odd)
}

fn memory(tiling: &Tiling, params: &str) -> String {
    let (_, texels) = bases(tiling);
    let (cell, pack, unpack) = if tiling.halves {
        (
            "vec2u",
            "vec2u(pack2x16float(v.xy), pack2x16float(v.zw))",
            "vec4f(unpack2x16float(cell.x), unpack2x16float(cell.y))",
        )
    } else {
        ("vec4f", "v", "cell")
    };
    format!(
        "var<workgroup> tile_memory: array<{cell}, {texels}>;
// Where texel (0, 0) of the image before lies or would lie, the texels in a row, and the image's size.
var<private> tile_zero: i32;
var<private> tile_row: i32;
var<private> tile_bounds: vec2f;
fn tile_pack(v: vec4f) -> {cell} {{ return {pack}; }}
fn tile_cell(index: i32) -> vec4f {{
    let cell = tile_memory[index];
    return {unpack};
}}
fn tile_size(t: u32) -> vec2u {{ return vec2u(tile_bounds); }}
fn tile_texel(t: u32, p: vec2i) -> vec4f {{ return tile_cell(tile_zero + p.y * tile_row + p.x); }}
fn tile_tap(t: u32, s: u32, uv: vec2f) -> vec4f {{
    let p = uv * tile_bounds - 0.5;
    let corner = floor(p);
    let f = p - corner;
    let i = tile_zero + i32(corner.y) * tile_row + i32(corner.x);
    let top = mix(tile_cell(i), tile_cell(i + 1), f.x);
    let bottom = mix(tile_cell(i + tile_row), tile_cell(i + tile_row + 1), f.x);
    return mix(top, bottom, f.y);
}}
fn tile_start(next: vec2i, next_size: vec2i, size: vec2i, reach: f32) -> vec2i {{
    let center = (vec2f(next) + 0.5) / vec2f(next_size) * vec2f(size) - 0.5;
    // A little less than the exact start, so that rounding loses no texel.
    return vec2i(floor(center - reach - 0.01));
}}
fn tile_size_of(stage: i32) -> vec2i {{ return {params}.sizes[stage].xy; }}
// Where the share of a workgroup begins in an image of that size.
fn tile_share(group: vec2i, size: vec2i, last: vec2i) -> vec2i {{
    let whole = group * {tile} >= last;
    return select(vec2i(vec2u(group * {tile}) * vec2u(size) / vec2u(last)), size, whole);
}}",
        tile = tiling.tile
    )
}

fn entry(tiling: &Tiling, stores: &[Option<String>], params: &str) -> String {
    let last = tiling.stages.len() - 1;
    let (bases, _) = bases(tiling);
    let mut body =
        format!("    let last = tile_size_of({last});\n    let origin{last} = vec2i(group.xy) * {};\n", tiling.tile);
    for index in (0..last).rev() {
        let reach = tiling.stages[index].reach;
        let _ = writeln!(
            body,
            "    let origin{index} = tile_start(origin{next}, tile_size_of({next}), tile_size_of({index}), {reach:?});",
            next = index + 1
        );
    }
    for (index, stage) in tiling.stages.iter().enumerate() {
        if index > 0 {
            let [width, _] = tiling.stages[index - 1].extent;
            let _ = writeln!(
                body,
                "    workgroupBarrier();
    tile_row = {width};
    tile_zero = {base} - origin{before}.y * {width} - origin{before}.x;
    tile_bounds = vec2f(tile_size_of({before}));",
                base = bases[index - 1],
                before = index - 1
            );
        }
        body += &stage_loop(index, stage, stores[index].as_deref(), bases.get(index).copied());
    }
    let _ = params;
    format!(
        "@compute @workgroup_size(16, 16)
fn compute(@builtin(workgroup_id) group: vec3u, @builtin(local_invocation_index) thread: u32) {{
{body}}}"
    )
}

/// Makes a stage's texels. Those outside of the image hold its edge, so that taps need not be kept inside.
fn stage_loop(index: usize, stage: &TileStage, store: Option<&str>, base: Option<u32>) -> String {
    let [width, height] = stage.extent;
    let mut text = format!(
        "    let size{index} = tile_size_of({index});
    let from{index} = tile_share(vec2i(group.xy), size{index}, last);
    let to{index} = tile_share(vec2i(group.xy) + 1, size{index}, last);
    for (var k = thread; k < {count}u; k += 256u) {{
        let q = origin{index} + vec2i(i32(k % {width}u), i32(k / {width}u));
        let p = clamp(q, vec2i(0), size{index} - 1);
        let value = stage{index}(Point(p, (vec2f(p) + 0.5) / vec2f(size{index}), vec2f(size{index})));
",
        count = width * height
    );
    if let Some(base) = base {
        let _ = writeln!(text, "        tile_memory[{base} + i32(k)] = tile_pack(value);");
    }
    if let Some(store) = store {
        let _ = writeln!(
            text,
            "        if all(q >= from{index}) && all(q < to{index}) {{ textureStore({store}, p, value); }}"
        );
    }
    text + "    }\n"
}
