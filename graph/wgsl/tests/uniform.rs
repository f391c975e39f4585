//! Uniform bytes follow the layout that reflection finds in the shader.

use afterimage_wgsl::{ArgType, Library, Linker, SampleMode, Shader, UniformValue};

static SHADER: Shader = Shader::new(
    "params.wgsl",
    "struct Params {
        amount: f32,
        tint: vec3f,
        count: u32,
        offset: vec2i,
        taps: array<vec4f, 2>,
    }
    fn params(source: vec4f, params: Params) -> vec4f { return source * params.amount; }",
);

fn packed(values: &[(&str, UniformValue)]) -> Result<Vec<u8>, String> {
    let reflection = SHADER.reflect().unwrap_or_else(|error| panic!("{error:?}"));
    reflection.pack("Params", values)
}

fn values() -> Vec<(&'static str, UniformValue)> {
    vec![
        ("taps", [5.0_f32, 6.0, 7.0, 8.0, 9.0, 10.0, 11.0, 12.0].into()),
        ("offset", UniformValue::Ints(vec![-1, -2])),
        ("count", 3_u32.into()),
        ("tint", [0.25_f32, 0.5, 0.75].into()),
        ("amount", 2.0_f32.into()),
    ]
}

fn float(bytes: &[u8], at: usize) -> f32 {
    f32::from_le_bytes([bytes[at], bytes[at + 1], bytes[at + 2], bytes[at + 3]])
}

fn int(bytes: &[u8], at: usize) -> i32 {
    i32::from_le_bytes([bytes[at], bytes[at + 1], bytes[at + 2], bytes[at + 3]])
}

#[test]
fn members_lie_at_the_offsets_that_wgsl_defines() {
    let bytes = packed(&values()).expect("every member has a value");
    // A vec3f and the elements of an array are aligned to 16 bytes, a vec2i to 8; a scalar may follow a vec3f directly.
    assert_eq!(bytes.len(), 80);
    assert_eq!([0, 16, 20, 24].map(|at| float(&bytes, at)), [2.0, 0.25, 0.5, 0.75]);
    assert_eq!([28, 32, 36].map(|at| int(&bytes, at)), [3, -1, -2]);
    let taps: Vec<f32> = (0..8).map(|tap| float(&bytes, 48 + 4 * tap)).collect();
    assert_eq!(taps, [5.0, 6.0, 7.0, 8.0, 9.0, 10.0, 11.0, 12.0]);
    assert_eq!([4, 8, 12, 40, 44].map(|at| int(&bytes, at)), [0; 5], "padding is zero");
}

#[test]
fn each_of_a_few_whole_numbers_has_its_place() {
    let mut values = values();
    values.push(("offset", [7_u32, 9].into()));
    let bytes = packed(&values).expect("every member has a value");
    assert_eq!([32, 36].map(|at| int(&bytes, at)), [7, 9]);
}

#[test]
fn the_last_value_of_a_name_counts_and_unknown_names_do_not() {
    let mut values = values();
    values.push(("amount", 4.0_f32.into()));
    values.push(("elsewhere", 1.0_f32.into()));
    assert_eq!(float(&packed(&values).expect("every member has a value"), 0), 4.0);
}

#[test]
fn a_member_without_a_value_or_with_too_many_numbers_is_an_error_with_its_name() {
    let mut missing = values();
    missing.retain(|(name, _)| *name != "tint");
    assert!(packed(&missing).expect_err("no value").contains("`Params.tint` has no value"));
    let mut long = values();
    long.push(("offset", UniformValue::Ints(vec![1, 2, 3])));
    assert!(packed(&long).expect_err("three numbers").contains("`Params.offset`"));
    let mut array = values();
    array.push(("taps", UniformValue::Floats(vec![1.0; 9])));
    assert!(packed(&array).expect_err("nine numbers").contains("`Params.taps` takes 8 numbers, not 9"));
    array.push(("taps", UniformValue::Floats(vec![1.0; 6])));
    assert!(packed(&array).expect_err("no whole element").contains("`Params.taps` takes 8 numbers, not 6"));
    array.push(("taps", UniformValue::Floats(vec![1.0; 4])));
    let bytes = packed(&array).expect("the first element alone");
    assert_eq!([48, 60, 64, 76].map(|at| float(&bytes, at)), [1.0, 1.0, 0.0, 0.0], "the others are zero");
}

#[test]
fn reflection_finds_functions_and_their_arguments() {
    let reflection = SHADER.reflect().unwrap_or_else(|error| panic!("{error:?}"));
    assert!(reflection.function("params").is_some() && reflection.function("helper").is_none());
    assert!(reflection.layout("Params").is_some_and(|layout| layout.members.len() == 5));
}

/// Four floats are a color; whole numbers and truth values are not.
#[test]
fn a_kernel_function_gives_four_floats() {
    let text = "fn kernel(a: f32, b: vec2f, c: i32, d: vec3u, e: bool) -> vec4f { return vec4f(a); }
        fn whole(a: f32) -> vec4i { return vec4i(i32(a)); }
        fn unsigned(a: f32) -> vec4u { return vec4u(u32(a)); }
        fn three(a: f32) -> vec3f { return vec3f(a); }
        fn truth(a: f32) -> vec4<bool> { return vec4<bool>(a > 0.0); }
        fn one(a: f32) -> f32 { return a; }
        fn nothing(a: f32) { }";
    let shader = Shader::new("kernel.wgsl", text);
    let reflection = shader.reflect().unwrap_or_else(|error| panic!("{error:?}"));
    let [kernel] = reflection.functions.as_slice() else { panic!("one function: {:?}", reflection.functions) };
    let types: Vec<Option<u8>> = kernel.args.iter().map(|(_, ty)| floats(ty)).collect();
    assert_eq!((kernel.name.as_str(), types), ("kernel", vec![Some(1), Some(2), None, None, None]));
}

/// Only textures of floats, and samplers that do not compare, are arguments.
#[test]
fn other_textures_are_no_arguments() {
    let text = "fn kernel(a: texture_2d<f32>, b: texture_3d<f32>, c: sampler, d: texture_2d<u32>, e: texture_3d<i32>,
            f: texture_depth_2d, g: texture_multisampled_2d<i32>, h: texture_2d_array<f32>, i: texture_cube<f32>,
            j: sampler_comparison, k: texture_1d<f32>, l: texture_storage_2d<rgba16float, write>,
            m: texture_storage_3d<rgba16float, write>) -> vec4f { return vec4f(); }";
    let shader = Shader::new("kernel.wgsl", text);
    let reflection = shader.reflect().unwrap_or_else(|error| panic!("{error:?}"));
    let args = &reflection.function("kernel").expect("it gives four floats").args;
    assert_eq!(
        args[..3].iter().map(|(_, ty)| ty).collect::<Vec<_>>(),
        [&ArgType::Texture, &ArgType::Volume, &ArgType::Sampler]
    );
    for (name, ty) in &args[3..] {
        assert!(matches!(ty, ArgType::Other(_)), "{name} is {ty:?}");
    }
    assert_eq!(args.len(), 13);
}

/// Shaders are equal if their files, texts and libraries are, wherever they are in memory.
#[test]
fn shaders_are_equal_by_what_they_hold() {
    let shader = |file: &str, text: &str| Shader::loaded(file.into(), text.into());
    let files = |text: &str| Library::of_files([("a.wgsl".to_owned(), text.to_owned())], []);
    let (one, text) = (shader("a", "const A = 1;"), "const A = 1;");
    assert!(one == one && one == shader("a", text));
    assert!(one != shader("b", text) && one != shader("a", "const A = 2;"));
    let with = |library| shader("a", text).with_loaded_library(library);
    assert!(one != with(files("")));
    let own = with(files("const B = 1;"));
    assert!(own != with(files("const B = 2;")) && own == own);
}

/// Equal files are one part of a module, and others are parts of their own.
#[test]
fn a_file_is_in_a_module_once() {
    let text = "const FAST: bool = false; fn kernel(a: vec4f) -> vec4f { return a; }";
    let shader = |file: &str, text: &str| Shader::loaded(file.into(), text.into());
    let shaders = [shader("a", text), shader("a", text), shader("b", text), shader("a", "const A = 1;")];
    let mut linker = Linker::new(SampleMode::Plain);
    let mut add = |at: usize, defines: &[&str]| linker.add(shaders[at].source(), defines).expect("it has no imports");
    let first = add(0, &[]);
    assert!(first == add(0, &[]) && first == add(1, &[]));
    assert!(first != add(2, &[]) && first != add(3, &[]) && first != add(0, &["FAST"]));
    assert!(add(0, &["FAST"]) == add(1, &["FAST"]));
    assert!(linker.add_copy(shaders[0].source()).expect("it has no imports") != first);
}

fn floats(ty: &ArgType) -> Option<u8> {
    match ty {
        ArgType::Floats(count) => Some(*count),
        ArgType::Other(_) => None,
        other => panic!("a number is not {other:?}"),
    }
}
