//! What reflection finds in a file: entry points, bindings, arguments, layouts, sharing, and how much is computed.

use afterimage_base::value::{FileValue, Value};
use afterimage_wgsl::{
    ArgType, EntryStage, GlobalKind, Library, Located, NumberKind, Reflection, RegisterPressure, ScalarKind, Shader,
    UniformValue, imports, is_free_name,
};

fn reflected(text: &str) -> Reflection {
    let shader = Shader::loaded("file.wgsl".into(), text.into());
    shader.reflect().unwrap_or_else(|error| panic!("{error}")).clone()
}

#[test]
fn entry_points_have_a_stage_a_workgroup_and_locations() {
    let reflection = reflected(
        "struct Corner { @builtin(position) place: vec4f, @location(2) tint: vec3f,
    @location(0) @interpolate(flat) part: u32 }
struct Pair { @location(1) second: vec2f, @location(0) first: vec4f }
fn help() { }
@compute @workgroup_size(8, 4, 2) fn made() { help(); }
@vertex fn corner(@location(1) at: vec2f, @location(0) part: u32, @builtin(vertex_index) index: u32) -> Corner {
    return Corner(vec4f(at, 0.0, 1.0), vec3f(), part);
}
@fragment fn shown(@location(3) @interpolate(flat) way: vec2i, corner: Corner) -> Pair {
    return Pair(vec2f(), vec4f()); }
@fragment fn gray() -> @location(0) f32 { return 1.0; }",
    );
    let located = |location, number, width| Located { location, number, width };
    let (float, int, uint) = (NumberKind::Float, NumberKind::Int, NumberKind::Uint);
    let names: Vec<&str> = reflection.entries.iter().map(|entry| entry.name.as_str()).collect();
    assert_eq!(names, ["made", "corner", "shown", "gray"]);
    let entry = |name: &str| reflection.entry(name).expect("it is declared").clone();
    let made = entry("made");
    assert_eq!(
        (made.stage, made.workgroup, made.inputs.len(), made.outputs.len()),
        (EntryStage::Compute, [8, 4, 2], 0, 0)
    );
    let corner = entry("corner");
    assert_eq!((corner.stage, corner.workgroup), (EntryStage::Vertex, [0; 3]));
    assert_eq!(corner.inputs, [located(0, uint, 1), located(1, float, 2)]);
    assert_eq!(corner.outputs, [located(0, uint, 1), located(2, float, 3)]);
    let shown = entry("shown");
    assert_eq!(shown.stage, EntryStage::Fragment);
    assert_eq!(shown.inputs, [located(0, uint, 1), located(2, float, 3), located(3, int, 2)]);
    assert_eq!(shown.outputs, [located(0, float, 4), located(1, float, 2)]);
    let words: Vec<String> = shown.inputs.iter().chain(&entry("gray").outputs).map(ToString::to_string).collect();
    let expected = ["@location(0) u32", "@location(2) vec3<f32>", "@location(3) vec2<i32>", "@location(0) f32"];
    assert_eq!(words, expected);
    assert!(reflection.entry("help").is_none() && reflection.function("made").is_none());
}

#[test]
fn bound_variables_have_a_place_and_a_kind() {
    let reflection = reflected(
        "struct Look { gain: f32 }
@group(0) @binding(3) var<uniform> look: Look;
@group(1) @binding(0) var<uniform> frame: Frame;
@group(0) @binding(4) var flat_: texture_2d<f32>;
@group(0) @binding(5) var deep: texture_3d<f32>;
@group(0) @binding(6) var out: texture_storage_2d<rgba16float, write>;
@group(0) @binding(7) var room: texture_storage_3d<rgba16float, write>;
@group(0) @binding(8) var linear: sampler;
@group(0) @binding(9) var shadow: sampler_comparison;
@group(0) @binding(10) var<storage, read> known: array<u32>;
@group(0) @binding(11) var<storage, read_write> sums: array<u32>;
@group(0) @binding(12) var samples: texture_multisampled_2d<f32>;
var<workgroup> shared_: array<u32, 4>;
@compute @workgroup_size(1) fn made() {
    sums[0] = known[0] + u32(look.gain + frame.part);
    shared_[0] = u32(textureLoad(samples, vec2i(), 0).x);
    let a = textureLoad(flat_, vec2i(), 0) + textureLoad(deep, vec3i(), 0)
        + textureSampleLevel(flat_, linear, vec2f(), 0.0);
    textureStore(out, vec2i(), a);
    textureStore(room, vec3i(), a);
}",
    );
    let table: Vec<(&str, u32, u32, GlobalKind)> = reflection
        .globals
        .iter()
        .map(|global| (global.name.as_str(), global.group, global.binding, global.kind.clone()))
        .collect();
    let expected = [
        ("look", 0, 3, GlobalKind::Uniform("Look".into())),
        ("frame", 1, 0, GlobalKind::Frame),
        ("flat_", 0, 4, GlobalKind::Texture(false)),
        ("deep", 0, 5, GlobalKind::Texture(true)),
        ("out", 0, 6, GlobalKind::StorageTexture(false)),
        ("room", 0, 7, GlobalKind::StorageTexture(true)),
        ("linear", 0, 8, GlobalKind::Sampler),
        ("shadow", 0, 9, GlobalKind::Other),
        ("known", 0, 10, GlobalKind::Buffer(false)),
        ("sums", 0, 11, GlobalKind::Buffer(true)),
        ("samples", 0, 12, GlobalKind::Other),
    ];
    assert_eq!(table, expected);
    assert_eq!(reflection.struct_of("nothing", "look"), Some("Look"));
    assert_eq!(reflection.struct_of("nothing", "sums"), None);
    assert_eq!(reflection.sharing, ["made"]);
}

#[test]
fn arguments_of_the_framework_are_known_by_where_their_types_come_from() {
    let reflection = reflected(
        "import afterimage::workgroup::Invocation;
struct Look { gain: f32 }
fn kind(a: vec4f, at: Point, frame: Frame, invocation: Invocation, params: Look, t: texture_2d<f32>,
    m: texture_multisampled_2d<f32>, v: texture_3d<f32>, s: sampler, n: u32) -> vec4f { return a; }
fn other(at: Point) -> vec3f { return vec3f(at.uv, 0.0); }",
    );
    let types: Vec<&ArgType> =
        reflection.function("kind").expect("it gives a pixel").args.iter().map(|(_, ty)| ty).collect();
    let look = ArgType::Struct("Look".into());
    let expected = [
        &ArgType::Floats(4),
        &ArgType::Point,
        &ArgType::Frame,
        &ArgType::Invocation,
        &look,
        &ArgType::Texture,
        &ArgType::Multisampled,
        &ArgType::Volume,
        &ArgType::Sampler,
    ];
    assert_eq!(types[..9], expected);
    assert!(matches!(types[9], ArgType::Other(_)));
    assert_eq!(reflection.struct_of("kind", "params"), Some("Look"));
    assert_eq!(reflection.struct_of("kind", "at"), None);
    assert_eq!(reflection.functions.len(), 1);
    // An author's own struct of that name is the author's.
    let own = reflected("struct Point { x: f32 }\nfn kind(at: Point) -> vec4f { return vec4f(at.x); }");
    assert_eq!(own.function("kind").expect("it gives a pixel").args[0].1, ArgType::Struct("Point".into()));
}

/// WGSL, 14.4: alignment and size of host-shareable types.
#[test]
fn members_of_every_type_lie_where_the_language_puts_them() {
    let reflection = reflected(
        "struct All {
    a: f32, b: vec2f, c: vec3f, d: i32, e: mat2x3f, f: mat4x4f, g: mat3x2f, h: array<vec3f, 3>, i: vec2u,
    @size(32) j: u32, @align(16) k: array<vec4i, 2>,
}
fn kind(params: All) -> vec4f { return vec4f(params.a); }",
    );
    let layout = reflection.layout("All").expect("it can be a uniform");
    let (float, int, uint) = (ScalarKind::Float, ScalarKind::Int, ScalarKind::Uint);
    let found: Vec<_> = layout
        .members
        .iter()
        .map(|member| (member.name.as_str(), member.offset, member.scalar, member.width, member.count, member.stride))
        .collect();
    let expected = [
        ("a", 0, float, 1, 1, 0),
        ("b", 8, float, 2, 1, 0),
        ("c", 16, float, 3, 1, 0),
        ("d", 28, int, 1, 1, 0),
        ("e", 32, float, 3, 2, 16),
        ("f", 64, float, 4, 4, 16),
        ("g", 128, float, 2, 3, 8),
        ("h", 160, float, 3, 3, 16),
        ("i", 208, uint, 2, 1, 0),
        ("j", 216, uint, 1, 1, 0),
        ("k", 256, int, 4, 2, 16),
    ];
    assert_eq!((found.as_slice(), layout.size), (&expected[..], 288));
    let mut values: Vec<(&str, UniformValue)> = expected
        .iter()
        .enumerate()
        .map(|(at, (name, .., width, count, _))| {
            let base = 100 * at as i64;
            (*name, UniformValue::Ints((0..i64::from(width * count)).map(|number| base + number).collect()))
        })
        .collect();
    values.reverse();
    let bytes = reflection.pack("All", &values).expect("every member has a value");
    let mut expected_bytes = vec![0; 288];
    for (at, (_, offset, scalar, width, count, stride)) in expected.into_iter().enumerate() {
        for number in 0..width * count {
            let value = 100 * at as u32 + number;
            let place = (offset + number / width * stride + number % width * 4) as usize;
            let word = if scalar == float { (value as f32).to_le_bytes() } else { value.to_le_bytes() };
            expected_bytes[place..place + 4].copy_from_slice(&word);
        }
    }
    assert_eq!(bytes, expected_bytes);
    assert_eq!((reflection.size("All"), reflection.size("None")), (Some(288), None));
    assert_eq!(reflection.pack("None", &[]).expect_err("no struct has this name"), "there is no struct `None`");
}

#[test]
fn values_of_rust_and_of_files_become_numbers() {
    let reflection = reflected(
        "struct One { x: f32, i: i32, u: u32, v: vec4f }
fn kind(params: One) -> vec4f { return params.v; }",
    );
    let words = |values: &[(&str, UniformValue)]| -> Vec<[u8; 4]> {
        let bytes = reflection.pack("One", values).expect("every member has a value");
        bytes.as_chunks::<4>().0.to_vec()
    };
    let float = |number: f32| number.to_le_bytes();
    let base = |x: UniformValue, i: UniformValue, u: UniformValue| {
        vec![("x", x), ("i", i), ("u", u), ("v", [1.5_f64, 2.0, 3.0, 4.5].into())]
    };
    let found = words(&base(2.5_f64.into(), (-3_i32).into(), true.into()));
    assert_eq!(found[..4], [float(2.5), (-3_i32).to_le_bytes(), 1_u32.to_le_bytes(), [0; 4]]);
    assert_eq!(found[4..], [1.5, 2.0, 3.0, 4.5].map(float));
    let found = words(&base(7_u32.into(), 2.75_f32.into(), false.into()));
    assert_eq!(found[..3], [float(7.0), 2_i32.to_le_bytes(), [0; 4]]);
    let value = |value: Value| UniformValue::from(&value);
    let found = words(&base(value(Value::Float(0.25)), value(Value::Int(-9)), value(Value::Bool(true))));
    assert_eq!(found[..3], [float(0.25), (-9_i32).to_le_bytes(), 1_u32.to_le_bytes()]);
    assert_eq!(value(Value::Vector([1.0, 2.0, 3.0, 0.0], 3)), UniformValue::Few([1.0, 2.0, 3.0, 0.0], 3));
    for nothing in [Value::Choice("A"), Value::Text("a".into()), Value::File(FileValue::default())] {
        assert_eq!(value(nothing), UniformValue::Floats(Vec::new()));
    }
    assert_eq!(UniformValue::from([1_u32, 2]), UniformValue::FewInts([1, 2, 0, 0], 2));
    assert_eq!(UniformValue::from([1_u32, 2, 3, 4, 5]), UniformValue::Ints(vec![1, 2, 3, 4, 5]));
    assert_eq!(UniformValue::from([1.0_f32; 4]), UniformValue::Few([1.0; 4], 4));
    assert_eq!(UniformValue::from([1.0_f32; 5]), UniformValue::Floats(vec![1.0; 5]));
    assert_eq!(UniformValue::from(&[[1.0_f32, 2.0], [3.0, 4.0]][..]), UniformValue::Floats(vec![1.0, 2.0, 3.0, 4.0]));
}

#[test]
fn a_struct_of_the_file_is_another_one_than_that_of_an_imported_file() {
    static LIBRARY: Library = Library::new(&[(
        "look",
        "struct Look { far: vec4f }
fn seen(l: Look) -> vec4f { return l.far; }",
    )]);
    static OWN: Shader = Shader::new(
        "own.wgsl",
        "import package::look::seen;
struct Look { own: f32 }
fn kind(params: Look) -> vec4f { return vec4f(params.own); }",
    )
    .with_library(&LIBRARY);
    let reflection = OWN.reflect().unwrap_or_else(|error| panic!("{error}"));
    assert_eq!(reflection.layout("Look").expect("it is declared").members[0].name, "own");
}

/// Six powers are few, and seven many; loops count by their turns.
#[test]
fn the_effort_of_a_function_is_counted() {
    let functions = [
        "pow(x, x)",
        "exp(x)",
        "exp2(x)",
        "log(x)",
        "log2(x)",
        "sin(x)",
        "cos(x)",
        "tan(x)",
        "asin(x)",
        "acos(x)",
        "atan(x)",
        "atan2(x, x)",
    ];
    for function in functions {
        let of = |count: usize| {
            let lines = format!("x += {function};").repeat(count);
            let text = format!("fn kind(v: vec4f) -> vec4f {{ var x = v; {lines} return x; }}");
            let shader = Shader::loaded("file.wgsl".into(), text);
            (shader.register_pressure("kind"), shader.is_heavy("kind"))
        };
        assert_eq!((of(6), of(7)), ((RegisterPressure::Low, false), (RegisterPressure::Medium, true)), "{function}");
    }
    let light = format!("fn kind(v: vec4f) -> vec4f {{ var x = v; {} return x; }}", "x = sqrt(abs(x));".repeat(20));
    assert!(!Shader::loaded("file.wgsl".into(), light).is_heavy("kind"), "roots are no powers");
    let table = [
        ("for (var i = 0; i < 4; i++)", RegisterPressure::Low),
        ("for (var i = 0; i < 5; i++)", RegisterPressure::Medium),
        ("for (var i = 0; i <= 4; i++)", RegisterPressure::Medium),
        ("for (var i = 0; i <= 3; i++)", RegisterPressure::Low),
        ("for (var i = 0; i < 8; i++)", RegisterPressure::Medium),
        ("for (var i = 0; i < 9; i++)", RegisterPressure::High),
        ("for (var i = 1u; i < 9u; i++)", RegisterPressure::Medium),
        ("for (var i = -2; i <= 2; i++)", RegisterPressure::Medium),
        ("for (var i = 0; i < 24; i += 3)", RegisterPressure::Medium),
        ("for (var i = 0; i < 25; i += 3)", RegisterPressure::High),
        ("for (var i = 0; i < 12; i += 3)", RegisterPressure::Low),
        ("for (var i = 4; i > 0; i--)", RegisterPressure::High),
        ("for (var i = 0; i < 4; i += 0)", RegisterPressure::High),
        ("for (var i = 0; i < 4 && x.x < 1.0; i++)", RegisterPressure::High),
        ("for (var i = 0; i < TURNS; i++)", RegisterPressure::Low),
    ];
    for (head, effort) in table {
        let text = format!(
            "const TURNS: i32 = 3;\nfn kind(v: vec4f) -> vec4f {{ var x = v; {head} {{ x *= v; }} return x; }}
fn calls(v: vec4f) -> vec4f {{ switch i32(v.x) {{ case 1 {{ return kind(v); }} default {{ }} }} return v; }}"
        );
        let shader = Shader::loaded("file.wgsl".into(), text);
        assert_eq!((shader.register_pressure("kind"), shader.register_pressure("calls")), (effort, effort), "{head}");
        assert!(shader.is_heavy("kind"), "{head}");
    }
    let unknown = Shader::loaded("file.wgsl".into(), "fn kind(v: vec4f) -> vec4f { return v; }".into());
    assert_eq!((unknown.register_pressure("none"), unknown.is_heavy("none")), (RegisterPressure::Low, false));
}

#[test]
fn words_of_the_language_are_no_free_names() {
    for name in ["gain", "x_1", "réflexion", "_a"] {
        assert!(is_free_name(name), "{name}");
    }
    for name in ["let", "fn", "struct", "target", "1a", "a b", "__a", "", "a-b", "_"] {
        assert!(!is_free_name(name), "{name}");
    }
    let text =
        "import super :: a::{b as c, d::{e},}; import package::lib::g;\nfn f() -> super::h::T { return c() + g::i(); }";
    let paths = ["super::a::b", "super::a::d::e", "package::lib::g", "super::h::T", "package::lib::g::i"];
    assert_eq!(imports(text), paths);
    assert!(imports("import super::a::b; /*").is_empty());
}
