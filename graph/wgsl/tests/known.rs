//! What the linker makes of many texts, compared with `known.tsv`: of each text, and of forty with a few changes,
//! whether it is accepted, what it declares, what errors say, and the modules that it becomes in every way in which it
//! can be linked. `AFTERIMAGE_BLESS=1 cargo test -p afterimage-wgsl --test known` writes the file anew. A change of a
//! message, of naga, or of a module changes lines; what is right about them is asserted elsewhere.

use std::fmt::Write as _;

use afterimage_generators::{FNV_START, fnv1a, mutated};
use afterimage_wgsl::{Library, Linked, Linker, SampleMode, Shader, ShaderError, ShaderFeatures, limits};

/// What texts get that they do not have.
const OTHERS: [&str; 20] =
    ["(", ")", "[", "]", "{", "}", ";", ",", ":", "@", "<", ">", "-", "1", "0.5", "//", "/*", "fn", "var", "source"];

/// A kernel function with declarations of each kind, and names that hide each other.
const FUNCTION: &str = "#import helpers
#import math
struct Light { color: vec3f, @size(16) power: f32, @align(16) taps: array<vec4f, 2> }
alias Pair = vec2<f32>;
const HALF: f32 = 0.5;
const POWERS = array<f32, 3>(1.0, 2.5, HALF);
const IS_SHARP = false;
const_assert HALF < 1.0;
/* a comment /* in a comment */ with fn names(); */
fn weight(pair: Pair, light: ptr<function, Light>) -> f32 {
    (*light).power += HALF; // and one to the end of the line
    return max(pair.x, (*light).power) * helper(pair.y);
}
fn kind(source: texture_2d<f32>, source_sampler: sampler, other: vec4f, at: Point, params: Light) -> vec4f {
    var light = params;
    var sum = vec4f();
    for (var i = 0; i < 3; i++) {
        let HALF = f32(i) * POWERS[i];
        if IS_SHARP && HALF > 1.0 { continue; }
        sum += HALF * tap(source, source_sampler, at.uv + vec2f(HALF) / at.size);
    }
    switch i32(other.x) {
        case 1, 2: { sum = -sum; }
        default: { let light = sum.xyz; sum = vec4f(light, 1.0); }
    }
    loop { sum *= 0.5; continuing { break if all(sum.xy < vec2f(1.0)); } }
    return sum * weight(Pair(other.xy), &light) + texel(source, at.pixel) * power(other.w, 2.0);
}
";

/// A compute kernel with bindings, memory of a workgroup, and constants that are set from outside.
const COMPUTE: &str = "#import cells
#import workgroup
struct Params { gain: f32, steps: u32 }
override SIDE: u32 = 8u;
override SCALE = 2.0;
override IS_LIT: bool;
override STEPS: i32 = -3;
@group(0) @binding(0) var source: texture_2d<f32>;
@group(0) @binding(1) var result: texture_storage_2d<rgba16float, write>;
@group(0) @binding(2) var<uniform> params: Params;
@group(0) @binding(3) var<uniform> frame: Frame;
@group(0) @binding(4) var<storage, read> before: array<vec4f>;
@group(0) @binding(5) var<storage, read_write> after: array<vec4f>;
@group(0) @binding(6) var linear: sampler;
var<workgroup> shared_sums: array<f32, 64>;
var<private> own: vec2<i32> = vec2<i32>(1, 2);
@compute @workgroup_size(8, 8)
fn kind_sum(@builtin(global_invocation_id) id: vec3u, @builtin(local_invocation_index) index: u32) {
    own += vec2i(id.xy);
    shared_sums[index] = SCALE * texel(source, own).x + frame.time;
    workgroupBarrier();
    if index == 0u && IS_LIT { after[0] = vec4f(shared_sums[SIDE]) + before[0] * params.gain; }
    textureStore(result, id.xy, vec4f(shared_sums[index], f32(STEPS), 0.0, 1.0));
}
@compute @workgroup_size(1)
fn kind_last() { after[params.steps] = textureSampleLevel(source, linear, vec2f(0.5), 0.0); }
";

const HELPERS: &str = "#import deeper
fn helper(x: f32) -> f32 { return 2.0 * deep(x); }
fn unused(x: f32) -> f32 { return x; }
";
const DEEPER: &str =
    "const HALF = 0.25;\nfn deep(x: f32) -> f32 { return x * HALF; }\nfn weight(x: f32) -> f32 { return x; }\n";

fn library() -> Library {
    let files = [("helpers.wgsl", HELPERS), ("deeper.wgsl", DEEPER)];
    Library::of_files(files.map(|(name, text)| (name.to_owned(), text.to_owned())))
}

/// The lines of a module that no file of the framework's library gave.
fn own_lines(linked: &Linked) -> String {
    let (mut own, mut at) = (String::new(), 0);
    for line in linked.text.split_inclusive('\n') {
        let place = linked.map.locate(at);
        let is_own = |file: &str| ["kind.wgsl", "helpers.wgsl", "deeper.wgsl", "(generated)"].contains(&file);
        if place.as_ref().is_none_or(|place| is_own(&place.file)) {
            write!(own, "{:?}: {line}", place.map(|place| (place.line, place.column))).expect("a string grows");
        }
        at += line.len();
    }
    own
}

const SUBSTITUTION: [(&str, &str); 4] =
    [("texture_2d<>", "u32"), ("sampler", "u32"), ("texel", "tile_texel"), ("tap", "tile_tap")];

/// The module in which generated code calls the kernels of a file, with all that can be set, set.
fn linked(
    shader: &Shader,
    mode: SampleMode,
    features: ShaderFeatures,
    substituted: bool,
) -> Result<String, ShaderError> {
    let reflection = shader.reflect()?;
    let mut linker = Linker::new(mode, features);
    linker.substitute(&SUBSTITUTION);
    let (instance, copy) = if substituted {
        (linker.add_substituted(shader.source(), &[])?, linker.add(shader.source(), &[])?)
    } else {
        (linker.add(shader.source(), &["IS_SHARP"])?, linker.add_copy(shader.source())?)
    };
    for (name, value) in [("SIDE", 4.0), ("SCALE", 0.75), ("IS_LIT", 1.0), ("STEPS", -7.0)] {
        linker.set_override(instance, name, value);
    }
    linker.bind(instance, "source", 1, 7);
    linker.set_storage_format(instance, "result", "r32float");
    linker.make_immediate(instance, "frame");
    linker.replace(instance, "params", "pass_params", ".kernel0");
    let before = linker.before_call(limits::LOOP_STEPS).unwrap_or_default();
    let mut code = format!("fn tile_texel() {{}}\nfn tile_tap() {{}}\nfn all() {{\n    {before}\n");
    for function in &reflection.functions {
        for of in [instance, copy] {
            writeln!(code, "    {};", linker.name(of, &function.name)).expect("a string grows");
        }
    }
    let entries: Vec<_> = reflection.entries.iter().map(|entry| (instance, entry.name.as_str())).collect();
    let linked = linker.link(code + "}\n", &entries)?;
    Ok(format!("{:?}\n{}", linked.entries, own_lines(&linked)))
}

/// All that is known of a file, or the error.
fn described(shader: &Shader) -> Result<String, ShaderError> {
    let reflection = shader.reflect()?;
    let mut text = format!("{reflection:?}");
    let rich = ShaderFeatures { half: true, subgroups: true };
    for (mode, features, substituted) in [
        (SampleMode::Plain, ShaderFeatures::default(), false),
        (SampleMode::ByHand, rich, false),
        (SampleMode::SanitizedLight, ShaderFeatures::default(), true),
    ] {
        text += &linked(shader, mode, features, substituted).unwrap_or_else(|error| format!("{error}\n"));
    }
    Ok(text)
}

/// A line of the table: how many of forty texts are accepted, and a hash of all that is said of them.
fn line(name: &str, text: &str, part: u64, make: fn(String, String) -> Shader) -> String {
    let (mut accepted, mut hash) = (0, FNV_START);
    for seed in 0..40 {
        let text = if (part, seed) == (0, 0) { text.to_owned() } else { mutated(text, 1000 * part + seed, &OTHERS) };
        let shader = make("kind.wgsl".into(), text).with_loaded_library(library());
        let said = described(&shader);
        accepted += usize::from(said.is_ok());
        hash = fnv1a(&said.unwrap_or_else(|error| error.to_string()), hash);
    }
    format!("{name} {part}\t{accepted}\t{hash:016x}\n")
}

#[test]
fn what_the_linker_makes_of_many_texts_changes_only_where_it_is_meant_to() {
    let mut table = String::new();
    for part in 0..8 {
        table += &line("a function", FUNCTION, part, Shader::loaded);
        table += &line("an untrusted function", FUNCTION, part, Shader::untrusted);
        table += &line("a compute kernel", COMPUTE, part, Shader::loaded);
    }
    let none = table.lines().filter(|line| line.contains("\t0\t")).count();
    assert!(none <= 4, "of most some texts are accepted:\n{table}");
    let path = std::path::Path::new(env!("CARGO_MANIFEST_DIR")).join("tests/known.tsv");
    if std::env::var_os("AFTERIMAGE_BLESS").is_some() {
        std::fs::write(&path, &table).expect("the folder of tests can be written");
    }
    let known = std::fs::read_to_string(&path).unwrap_or_default();
    let changed: Vec<(&str, &str)> = known.lines().zip(table.lines()).filter(|(old, new)| old != new).collect();
    assert!(changed.is_empty(), "if this is meant, set AFTERIMAGE_BLESS=1: {changed:#?}");
    assert_eq!(known.lines().count(), table.lines().count());
}
