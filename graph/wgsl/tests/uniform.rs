//! Uniform bytes follow the layout that reflection finds in the shader.
#![allow(missing_docs, reason = "a test binary exports nothing")]

use afterimage_wgsl::{ArgType, Shader, UniformValue};

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

fn floats(ty: &ArgType) -> Option<u8> {
    match ty {
        ArgType::Floats(count) => Some(*count),
        ArgType::Other(_) => None,
        other => panic!("a number is not {other:?}"),
    }
}
