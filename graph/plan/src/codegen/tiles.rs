//! The entry point of a chain of images, each kept in workgroup memory for the next.
//!
//! Kernel functions read textures through `texel` and `tap`. The file of a function that reads the image before is in
//! the module a second time, with a number in place of a texture, and functions that read workgroup memory in place of
//! those two.

use std::fmt::Write as _;

use afterimage_graph::node::{TileStage, TiledChain};
use afterimage_wgsl::ShaderError;

use super::module::{Composed, PassCode};
use super::writer::FunctionWriter;

/// Invocations of a workgroup, across and down.
const TILE_SIDE: u32 = 16;

/// What functions that read a tile use in place of textures.
const SUBSTITUTION: [(&str, &str); 5] = [
    ("texture_2d<>", "u32"),
    ("sampler", "u32"),
    ("textureDimensions", "tile_size"),
    ("texel", "tile_texel"),
    ("tap", "tile_tap"),
];

/// A chain with its entry point.
pub(super) fn compose_tiled_chain(code: &PassCode<'_>, chain: &TiledChain) -> Result<Composed, ShaderError> {
    let mut linker = code.linker();
    linker.substitute(&SUBSTITUTION);
    let mut writer = FunctionWriter::new(code, linker)?;
    let params = writer.params();
    let stages = chain.stages.iter().enumerate();
    let functions: String =
        stages.map(|(index, stage)| writer.function(&format!("stage{index}"), stage.kernels.clone())).collect();
    let stores: Vec<Option<String>> = chain.stages.iter().map(|stage| store(code, &mut writer, stage)).collect();
    let text = memory(chain, &params) + &functions + &entry_point(chain, &stores);
    writer.finish(&text, [TILE_SIDE, TILE_SIDE, 1], &["compute"])
}

/// The variable of the image that takes a stage's value, if any does.
fn store(code: &PassCode<'_>, writer: &mut FunctionWriter<'_, '_>, stage: &TileStage) -> Option<String> {
    let result = code.pass.results.iter().find(|result| result.kernel == stage.last_kernel())?;
    Some(writer.storage(result.image, code.format_of(result.image)))
}

/// Where the image of each stage begins in workgroup memory, and the texels in all. Successive images alternate between
/// two areas.
fn bases(chain: &TiledChain) -> (Vec<u32>, u32) {
    let kept = &chain.stages[..chain.stages.len() - 1];
    let area = |stage: &TileStage| stage.extent[0] * stage.extent[1];
    let largest = |parity: usize| kept.iter().skip(parity).step_by(2).map(area).max().unwrap_or(0);
    let bases = (0..kept.len()).map(|index| if index % 2 == 0 { 0 } else { largest(0) }).collect();
    (bases, largest(0) + largest(1))
}

/// Reads of the image before, in workgroup memory.
const TILE_READS: &str = "
// Where texel (0, 0) of the image before lies or would lie, the texels in a row, and the image's size.
var<private> tile_zero: i32;
var<private> tile_row: i32;
var<private> tile_bounds: vec2f;
fn tile_size(t: u32) -> vec2u { return vec2u(tile_bounds); }
fn tile_texel(t: u32, p: vec2i) -> vec4f { return tile_cell(tile_zero + p.y * tile_row + p.x); }
fn tile_tap(t: u32, s: u32, uv: vec2f) -> vec4f {
    let p = uv * tile_bounds - 0.5;
    let corner = floor(p);
    let f = p - corner;
    let i = tile_zero + i32(corner.y) * tile_row + i32(corner.x);
    let top = mix(tile_cell(i), tile_cell(i + 1), f.x);
    let bottom = mix(tile_cell(i + tile_row), tile_cell(i + tile_row + 1), f.x);
    return mix(top, bottom, f.y);
}
fn tile_start(next: vec2i, next_size: vec2i, size: vec2i, reach: f32) -> vec2i {
    let center = (vec2f(next) + 0.5) / vec2f(next_size) * vec2f(size) - 0.5;
    // A little less than the exact start, so that rounding loses no texel.
    return vec2i(floor(center - reach - 0.01));
}
";

/// Workgroup memory, and the functions that read and write it.
fn memory(chain: &TiledChain, params: &str) -> String {
    let (_, texels) = bases(chain);
    let (cell, pack, unpack) = match chain.halves {
        true => (
            "vec2u",
            "vec2u(pack2x16float(v.xy), pack2x16float(v.zw))",
            "vec4f(unpack2x16float(cell.x), unpack2x16float(cell.y))",
        ),
        false => ("vec4f", "v", "cell"),
    };
    format!(
        "var<workgroup> tile_memory: array<{cell}, {texels}>;
fn tile_pack(v: vec4f) -> {cell} {{ return {pack}; }}
fn tile_cell(index: i32) -> vec4f {{
    let cell = tile_memory[index];
    return {unpack};
}}
{TILE_READS}fn tile_size_of(stage: i32) -> vec2i {{ return {params}.sizes[stage].xy; }}
// Where the part of a workgroup begins in an image of that size.
fn tile_share(group: vec2i, size: vec2i, last: vec2i) -> vec2i {{
    let whole = group * {tile} >= last;
    return select(vec2i(vec2u(group * {tile}) * vec2u(size) / vec2u(last)), size, whole);
}}
",
        tile = chain.tile
    )
}

fn entry_point(chain: &TiledChain, stores: &[Option<String>]) -> String {
    let last = chain.stages.len() - 1;
    let (bases, _) = bases(chain);
    let origins: String = (0..last).rev().map(|index| origin(index, &chain.stages[index])).collect();
    let loops: String = (0..=last)
        .map(|index| {
            let before = index.checked_sub(1).map(|before| enter(before, &chain.stages[before], bases[before]));
            let stage = &chain.stages[index];
            before.unwrap_or_default() + &stage_loop(index, stage, stores[index].as_deref(), bases.get(index).copied())
        })
        .collect();
    format!(
        "@compute @workgroup_size(16, 16)
fn compute(@builtin(workgroup_id) group: vec3u, @builtin(local_invocation_index) invocation: u32) {{
    let last = tile_size_of({last});
    let origin{last} = vec2i(group.xy) * {};
{origins}{loops}}}",
        chain.tile
    )
}

/// The first texel that a workgroup makes of a stage's image.
fn origin(index: usize, stage: &TileStage) -> String {
    let (next, reach) = (index + 1, stage.reach);
    format!(
        "    let origin{index} = tile_start(origin{next}, tile_size_of({next}), tile_size_of({index}), {reach:?});\n"
    )
}

/// Lets what follows read the image of a stage.
fn enter(index: usize, stage: &TileStage, base: u32) -> String {
    let [width, _] = stage.extent;
    format!(
        "    workgroupBarrier();
    tile_row = {width};
    tile_zero = {base} - origin{index}.y * {width} - origin{index}.x;
    tile_bounds = vec2f(tile_size_of({index}));\n"
    )
}

/// Makes a stage's texels. Those outside of the image hold its edge, so that taps need not be kept inside.
fn stage_loop(index: usize, stage: &TileStage, store: Option<&str>, base: Option<u32>) -> String {
    let [width, height] = stage.extent;
    let mut text = format!(
        "    let size{index} = tile_size_of({index});
    let from{index} = tile_share(vec2i(group.xy), size{index}, last);
    let to{index} = tile_share(vec2i(group.xy) + 1, size{index}, last);
    for (var k = invocation; k < {count}u; k += 256u) {{
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
