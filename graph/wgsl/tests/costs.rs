//! What a function of the language costs an untrusted kernel: how many of it fit below the limit of operations.
//!
//! The weights are measured with a driver (`limits/cost.rs`), so a change of one is meant, or a fault.

use afterimage_wgsl::{Shader, limits};

/// A kernel that repeats a computation this often.
fn kernel(line: &str, count: usize) -> Shader {
    let mut text = String::from("import afterimage::math::power;\nstruct Pair { numbers: array<f32, 40> }\n");
    text +=
        "fn twice(image: texture_2d<f32>, at: vec2i) -> vec4f { return texel(image, at) + texel(image, at + 1); }\n";
    text += "fn many(a: mat4x4f, b: mat4x4f, c: mat4x4f, d: mat4x4f) -> f32 { return 1.0; }\n";
    text += "fn kind(source: vec4f, image: texture_2d<f32>, at: Point) -> vec4f {\nvar wide = mat4x4f();\n";
    text += "var sum = source; var whole = vec2u(source.xy); var signed = vec2i(source.xy); var m = mat2x2f();\n";
    text += "var list: array<f32, 40>; var one = source.x; var i = whole.x;\n";
    text += &format!("{line}\n").repeat(count);
    text += "return sum + vec4f(vec2f(whole), vec2f(signed)) + one + list[i] + m[0].xyxy; }";
    Shader::untrusted("kind.wgsl".into(), text)
}

/// The most lines that are accepted, to a hundredth.
fn most(line: &str) -> usize {
    let fits = |count: &usize| match kernel(line, *count).reflect() {
        Ok(_) => true,
        Err(error) if error.message.contains(limits::OPERATIONS.counts) => false,
        Err(error) => panic!("{line}: {error}"),
    };
    assert!(fits(&1), "{line}");
    let mut low = 1;
    while low < 4096 && fits(&(low * 2)) {
        low *= 2;
    }
    let (mut low, mut high) = (low, 2 * low);
    while high - low > (low / 100).max(1) {
        let middle = (low + high) / 2;
        if fits(&middle) { low = middle } else { high = middle }
    }
    low
}

/// Operations that a line takes, to a hundredth.
fn operations(line: &str) -> f64 {
    limits::OPERATIONS.max as f64 / most(line) as f64
}

fn assert_costs(cases: &[(&str, f64)]) {
    let wrong = |(line, wanted): &(&str, f64)| {
        let found = operations(line);
        ((found / wanted - 1.0).abs() > 0.04).then(|| format!("`{line}` takes {found:.0} operations and not {wanted}"))
    };
    let wrong: Vec<String> = cases.iter().filter_map(wrong).collect();
    assert!(wrong.is_empty(), "{}", wrong.join("\n"));
}

#[test]
fn functions_cost_what_a_driver_needs_for_them() {
    assert_costs(&[
        ("one = tan(one);", 602.0),
        ("one = log(one);", 402.0),
        ("one = log2(one);", 402.0),
        ("one = pow(one, one);", 503.0),
        ("one = atan2(one, one);", 503.0),
        ("one = asinh(one);", 502.0),
        ("sum = acosh(sum);", 2010.0),
        ("one = sin(one);", 258.0),
        ("one = cos(one);", 258.0),
        ("one = ldexp(one, signed.x);", 112.0),
        ("one = exp2(one);", 70.0),
        ("one = determinant(m);", 270.0),
        ("one = smoothstep(0.0, 1.0, one);", 55.0),
        ("one = length(sum);", 206.0),
        ("sum = normalize(sum);", 206.0),
        ("sum = reflect(sum, sum);", 222.0),
        ("sum = max(sum, sum);", 75.0),
    ]);
}

#[test]
fn functions_of_bits_and_packing_cost_what_a_driver_needs_for_them() {
    assert_costs(&[
        ("i = pack2x16float(sum.xy);", 659.0),
        ("sum = vec4f(unpack2x16float(i), 0.0, 0.0);", 661.0),
        ("one = quantizeToF16(one);", 326.0),
        ("i = pack4x8snorm(sum);", 273.0),
        ("i = pack4x8unorm(sum);", 273.0),
        ("sum = unpack4x8snorm(i);", 273.0),
        ("sum = unpack4x8unorm(i);", 273.0),
        ("i = reverseBits(i);", 72.0),
        ("i = countOneBits(i);", 72.0),
        ("i = countLeadingZeros(i);", 72.0),
        ("i = firstLeadingBit(i);", 72.0),
        ("i = extractBits(i, 1u, 2u);", 73.0),
    ]);
}

#[test]
fn operators_cost_what_a_driver_writes_out_for_them() {
    assert_costs(&[
        ("one = one + one;", 12.0),
        ("sum = sum * sum;", 38.0),
        ("i = i / 3u;", 408.0),
        ("i = i % 3u;", 408.0),
        ("whole = whole / whole;", 840.0),
        ("one = one / 3.0;", 12.0),
        ("i = i + 1u;", 15.0),
        ("m = m * m;", 73.0),
        ("one = sum[i];", 113.0),
        ("one = list[i];", 977.0),
        ("if one > 0.0 { one = 1.0; }", 74.0),
        ("sum = select(sum, sum, one > 0.0);", 80.0),
        ("switch i { case 1u: { one = 1.0; } default: { one = 2.0; } }", 139.0),
    ]);
}

/// An array that is a value and not in memory is copied for each element that an index may choose.
#[test]
fn an_element_of_a_value_costs_the_square_of_its_array() {
    let found = operations("{ let value = list; one = value[i]; }");
    assert!((6500.0..7200.0).contains(&found), "{found}");
}

/// A function of the library that reads textures has a weight of its own, and no other function has it. What a function
/// is given costs nothing.
#[test]
fn calls_cost_what_the_function_does() {
    assert_costs(&[
        ("sum = texel(image, at.pixel);", 1882.0),
        ("sum = twice(image, at.pixel);", 3840.0),
        ("one = power(one, one);", 542.0),
        ("one = many(wide, wide, wide, wide);", 202.0),
    ]);
}

/// A kernel whose value `t` comes from these statements and is used `uses` times.
fn of_value(functions: &str, statements: &str, uses: usize) -> Result<(), String> {
    let lines = "sum += t; ".repeat(uses);
    let text = format!(
        "{functions}\nfn kind(source: vec4f) -> vec4f {{ var sum = source; {statements} {lines} return sum; }}"
    );
    Shader::untrusted("kind.wgsl".into(), text).reflect().map(drop).map_err(|error| error.to_string())
}

const EARLY: &str = "fn early(c: vec4f) -> vec4f { if c.x > 0.5 { return c.yzwx; } return c; }";
const SETS: &str = "fn sets(c: ptr<function, vec4f>) { if (*c).x > 0.5 { *c = (*c).yzwx; } }";
const USES: &str = "fn uses(c: vec4f) -> vec4f { return c + c + c + c + c + c + c + c + c + c; }";

/// llvmpipe compiles them in a time in proportion to the square of the uses.
#[test]
fn many_uses_of_what_branches_have_made_are_refused() {
    let merged = [
        ("", "var t = source; if source.x > 0.5 { t = source.yzwx; }"),
        ("", "var t = source; if source.x > 0.5 { t.y = 1.0; }"),
        ("", "var t = source; if source.x > 0.5 { } else { if source.y > 0.5 { t = vec4f(); } }"),
        ("", "var t = source; switch u32(source.x) { case 1u: { t = vec4f(); } default: { } }"),
        ("", "var o = source; if source.x > 0.5 { o = vec4f(); } let t = o;"),
        ("", "var o = source; if source.x > 0.5 { o = vec4f(); } var t = -(o + 0.0);"),
        ("", "var o = source; if source.x > 0.5 { o = vec4f(); } let t = vec4f(o.x, o.yz, 1.0);"),
        ("", "var o = source; if source.x > 0.5 { o = vec4f(); } let t = max(o, o);"),
        (EARLY, "let t = early(source);"),
        (SETS, "var t = source; sets(&t);"),
    ];
    for (functions, statements) in merged {
        assert_eq!(of_value(functions, statements, 100), Ok(()), "{statements}");
        let error = of_value(functions, statements, 400).expect_err(statements);
        assert!(error.contains(limits::OPERATIONS.counts), "{statements}: {error}");
    }
    let functions = format!("{EARLY}\n{USES}");
    let calls = |count: usize| format!("let t = source; let o = early(source); {}", "sum += uses(o); ".repeat(count));
    assert_eq!(of_value(&functions, &calls(10), 1), Ok(()));
    assert!(of_value(&functions, &calls(40), 1).is_err(), "an argument is used in the function");
}

#[test]
fn uses_of_other_values_cost_no_more_than_their_operations() {
    let others = [
        ("", "let t = source;"),
        ("", "var t = source; t = t * source;"),
        ("", "var t = source; if source.x > 0.5 { t = source.yzwx; } t = t * source;"),
        ("", "var t = source; var o = source; if source.x > 0.5 { o = source.yzwx; }"),
        ("", "var o = source; if source.x > 0.5 { o = source.yzwx; } var t = o + o;"),
        ("", "var t = source; for (var i = 0; i < 3; i++) { t *= source; }"),
        (EARLY, "let t = early(source) * source.yzwx;"),
        (USES, "let t = uses(source);"),
    ];
    for (functions, statements) in others {
        assert_eq!(of_value(functions, statements, 2000), Ok(()), "{statements}");
    }
    // Many values with few uses each.
    let few = "var t = source; if source.x > 0.5 { t = sum; } sum += t * t; sum = sum * source; ";
    let blocks = format!("{{ {few} }} ").repeat(300);
    assert_eq!(of_value("", &format!("{blocks} let t = source;"), 1), Ok(()));
}
