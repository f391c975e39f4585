//! The entry point of a tiled chain: images, each kept in workgroup memory for the next.
//!
//! Kernel functions read textures through `texel` and `tap`. For a function that reads the image before, its file is
//! written a second time under other names, in which a texture is a number and those two read workgroup memory.

use std::fmt::Write as _;

use super::functions::{KernelWriter, is_tiled, params_struct, promises};
use super::module::Composed;
use super::uniforms::uniform_struct;
use afterimage_base::Shared;
use afterimage_base::image::Format;
use afterimage_graph::node::{ImageId, Pass, TileStage, TiledChain};
use afterimage_wgsl::{SampleMode, Shader, ShaderError, ShaderFeatures, Text};

/// Invocations of a workgroup, across and down.
const TILE_SIDE: u32 = 16;

/// A tiled chain with its entry point.
pub(super) fn compose_tiled_chain(
    pass: &Pass,
    chain: &TiledChain,
    format_of: &dyn Fn(ImageId) -> Format,
    sample_mode_of: &dyn Fn(ImageId) -> SampleMode,
    features: ShaderFeatures,
) -> Result<Composed, ShaderError> {
    let kernels = &pass.kernels;
    let mut writer = KernelWriter::new(sample_mode_of);
    let reading = writer.strictest(kernels);
    let params = writer.params_variable();
    let mut functions = String::new();
    for (index, stage) in chain.stages.iter().enumerate() {
        writer.kernels(index, &kernels[stage.kernels.clone()], stage.kernels.start);
        functions += &writer.take_function(&format!("stage{index}"), stage.last_kernel());
    }
    let stored = |stage: &TileStage| pass.results.iter().find(|result| result.kernel == stage.last_kernel());
    let images = chain.stages.iter().map(|stage| stored(stage).map(|result| result.image));
    let stores: Vec<Option<String>> =
        images.map(|image| image.map(|image| writer.storage(image, format_of(image)))).collect();
    let mut text = Text::promising(promises(kernels)).reading(reading, features)?;
    for kernel in kernels.iter().filter(|kernel| !is_tiled(kernel)) {
        text.module(&kernel.shader)?;
    }
    text.generated(&uniform_struct(pass, &|at| params_struct(&kernels[at])));
    text.generated(writer.declarations());
    text.generated(&memory(chain, &params));
    for kernel in kernels.iter().filter(|kernel| is_tiled(kernel)) {
        text.tiled_module(&kernel.shader)?;
    }
    text.generated(&functions);
    text.generated(&entry(chain, &stores));
    Ok(Composed {
        source: text.text,
        map: text.map,
        compute: Shared::of("compute"),
        fragment: None,
        slots: writer.into_slots(),
        workgroup: [TILE_SIDE, TILE_SIDE, 1],
        unchecked: pass.shaders().all(Shader::is_unchecked),
        reading,
        // Every texel of a tile is written before it is read.
        zero_workgroup_memory: false,
    })
}

/// Where the image of each stage begins in workgroup memory: images alternate between its two parts.
fn bases(chain: &TiledChain) -> (Vec<u32>, u32) {
    let kept = &chain.stages[..chain.stages.len() - 1];
    let area = |stage: &TileStage| stage.extent[0] * stage.extent[1];
    let even = kept.iter().step_by(2).map(area).max().unwrap_or(0);
    let odd = kept.iter().skip(1).step_by(2).map(area).max().unwrap_or(0);
    let bases = (0..kept.len()).map(|index| if index % 2 == 0 { 0 } else { even }).collect();
    (bases, even + odd)
}

fn memory(chain: &TiledChain, params: &str) -> String {
    let (_, texels) = bases(chain);
    let (cell, pack, unpack) = if chain.halves {
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
        tile = chain.tile
    )
}

fn entry(chain: &TiledChain, stores: &[Option<String>]) -> String {
    let last = chain.stages.len() - 1;
    let (bases, _) = bases(chain);
    let mut body =
        format!("    let last = tile_size_of({last});\n    let origin{last} = vec2i(group.xy) * {};\n", chain.tile);
    for index in (0..last).rev() {
        let reach = chain.stages[index].reach;
        let _ = writeln!(
            body,
            "    let origin{index} = tile_start(origin{next}, tile_size_of({next}), tile_size_of({index}), {reach:?});",
            next = index + 1
        );
    }
    for (index, stage) in chain.stages.iter().enumerate() {
        if index > 0 {
            let [width, _] = chain.stages[index - 1].extent;
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
