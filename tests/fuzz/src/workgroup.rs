//! Shaders of folders whose functions share memory of a workgroup: refused at the author's line, or they become a valid
//! module in which every invocation arrives at each barrier.

use afterimage_wgsl::{ArgType, Function, Instance, Linker, SampleMode, Shader, limits, validate};

/// The seeds of mutation: the last function of each takes a pixel and its place in a workgroup.
pub const SEEDS: [&str; 6] = [
    "import afterimage::workgroup::Invocation;
var<workgroup> tile: array<vec4f, 64>;
fn shared_pixel(index: u32) -> vec4f { return tile[index % 64u]; }
fn kind(source: vec4f, at: Point, invocation: Invocation) -> vec4f {
    tile[invocation.index] = source;
    workgroupBarrier();
    return 0.5 * (shared_pixel(invocation.index + 1u) + source);
}
",
    "import afterimage::workgroup::Invocation;
var<workgroup> bright: atomic<u32>;
var<workgroup> least: atomic<i32>;
fn kind(source: vec4f, at: Point, invocation: Invocation) -> vec4f {
    if source.x > 0.5 { atomicAdd(&bright, 1u); }
    atomicMin(&least, i32(source.y * 100.0));
    workgroupBarrier();
    let count = f32(atomicLoad(&bright));
    return vec4f(count / 64.0, f32(atomicLoad(&least)), source.zw);
}
",
    "import afterimage::workgroup::{Invocation, workgroup_scan, workgroup_sum};
fn kind(source: vec4f, at: Point, invocation: Invocation) -> vec4f {
    let sum = workgroup_sum(invocation, 64u, source.xy);
    workgroupBarrier();
    let scan = workgroup_scan(invocation, 64u, u32(abs(source.x) * 10.0));
    return vec4f(sum / 64.0, vec2f(scan) / 640.0);
}
",
    "import afterimage::workgroup::Invocation;
import afterimage::color::luminance;
struct Pair { low: vec4f, high: vec4f }
const SIDE: u32 = 8u;
var<workgroup> pairs: array<Pair, 64>;
var<workgroup> flags: array<array<u32, 8>, 8>;
fn fold(index: u32, half: u32) {
    if index < half {
        pairs[index].low = min(pairs[index].low, pairs[index + half].low);
        pairs[index].high = max(pairs[index].high, pairs[index + half].high);
    }
    workgroupBarrier();
}
fn kind(source: vec4f, at: Point, invocation: Invocation) -> vec4f {
    let index = invocation.index;
    pairs[index] = Pair(source, source);
    flags[index / SIDE][index % SIDE] = select(0u, 1u, luminance(source.rgb) > 0.5);
    workgroupBarrier();
    fold(index, 32u);
    fold(index, 16u);
    fold(index, 8u);
    fold(index, 4u);
    var count = 0u;
    for (var x = 0u; x < SIDE; x++) { count += flags[index / SIDE][x]; }
    return mix(pairs[0].low, pairs[0].high, f32(count) / 8.0);
}
",
    "import afterimage::workgroup::Invocation;
var<workgroup> order: array<f32, 64>;
fn kind(source: vec4f, at: Point, invocation: Invocation) -> vec4f {
    order[invocation.index] = source.x;
    workgroupBarrier();
    var rank = 0u;
    var other = 0u;
    loop {
        if other >= 64u { break; }
        if order[other] < source.x { rank += 1u; }
        continuing { other += 1u; }
    }
    switch rank % 3u {
        case 0u { return source.yzxw; }
        case 1u { return source.zxyw; }
        default { return source; }
    }
}
",
    "import afterimage::workgroup::Invocation;
// Wrong on purpose: mutation finds its way from here to what is accepted, and the other way round.
var<workgroup> words: array<atomic<u32>, 4>;
var<workgroup> block: mat4x4f;
fn wait(deep: bool) { if deep { return; } workgroupBarrier(); }
fn kind(source: vec4f, at: Point, invocation: Invocation) -> vec4f {
    for (var step = 0; step < 3; step++) { workgroupBarrier(); }
    if source.x > 0.5 { wait(true); }
    block[invocation.index % 4u] = source;
    { workgroupBarrier(); }
    return block * vec4f(f32(atomicExchange(&words[invocation.index % 4u], 7u)));
}
",
];

/// True if the text is a shader that a folder may hold if its functions have a workgroup.
pub(crate) fn survives(text: &str) -> bool {
    let shader = Shader::untrusted("kind.wgsl".to_owned(), text.to_owned()).with_workgroups();
    match shader.reflect() {
        Ok(reflection) => {
            reflection.functions.iter().for_each(|function| composes(&shader, function));
            true
        }
        Err(error) => {
            assert!(!error.message.is_empty());
            assert_eq!(error.file, "kind.wgsl", "the error is not in a file of the author: {error}");
            let lines = text.split('\n').count();
            assert!((1..=lines).contains(&(error.line as usize)), "the file has {lines} lines: {error}");
            false
        }
    }
}

/// What is accepted is valid as a pass, too.
fn composes(shader: &Shader, function: &Function) {
    let arg = |(_, ty): &(String, ArgType)| match ty {
        ArgType::Floats(1) => Some("image.x"),
        ArgType::Floats(4) => Some("image"),
        ArgType::Point => Some("at"),
        ArgType::Invocation => Some("invocation"),
        _ => None,
    };
    let Some(args) = function.args.iter().map(arg).collect::<Option<Vec<_>>>() else { return };
    let mut linker = Linker::new(SampleMode::Plain);
    let instance = linker.add(shader.source(), &[]).unwrap_or_else(|error| panic!("accepted, but: {error}"));
    let (before, name) =
        (linker.before_call(limits::WORKGROUP_LOOP_STEPS).unwrap_or_default(), linker.name(instance, &function.name));
    let code = format!(
        "import afterimage::workgroup::Invocation;
@group(0) @binding(0) var result: texture_storage_2d<rgba16float, write>;
fn run(at: Point, invocation: Invocation) -> vec4f {{
    let image = vec4f(at.uv, at.size);
    {before}
    return {name}({});
}}
@compute @workgroup_size(64)
fn compute(invocation: Invocation, @builtin(workgroup_id) group: vec3u) {{
    let pixel = vec2i(group.xy * 8u + vec2u(invocation.index % 8u, invocation.index / 8u));
    let value = run(Point(pixel, vec2f(pixel), vec2f(1.0)), invocation);
    textureStore(result, pixel, value);
}}",
        args.join(", ")
    );
    let linked = linker.link(code, &[(Instance::GENERATED, "compute")]);
    let linked = linked.unwrap_or_else(|error| panic!("accepted, but: {error}"));
    validate(&linked.text, &linked.map).unwrap_or_else(|error| panic!("accepted, but: {error}"));
}
