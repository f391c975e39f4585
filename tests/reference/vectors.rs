//! The CPU references against printed test vectors: every operator of `tests/vectors/operators.json` is
//! run through its CPU reference or listed as having none.
//!
//! A CPU reference is given as a function from a case to the flat list of numbers that the case expects.

mod bloom;
mod color;
mod curves;
mod exposure;
mod grade;
mod local;
mod lut;
mod pipelines;
mod purkinje;
mod resolve;
mod shadow;
mod ssao;
mod transfer;

use std::collections::BTreeSet;
use std::sync::LazyLock;

use serde_json::Value;

use super::math::{Matrix, Rgb};

/// An operator's name in the file, and its CPU reference.
type Op = (&'static str, fn(&Case) -> Vec<f64>);

/// Every operator that has a CPU reference.
const TOPICS: &[&[Op]] = &[
    transfer::OPS,
    color::OPS,
    exposure::OPS,
    purkinje::OPS,
    local::OPS,
    bloom::OPS,
    curves::OPS,
    grade::OPS,
    lut::OPS,
    pipelines::OPS,
    resolve::OPS,
    shadow::OPS,
    ssao::OPS,
];

/// Operators of drawing, and a blur whose weights no kind has, which have no CPU reference.
const WITHOUT_REFERENCE: &[&str] = &["depth_bilateral_weight", "fullscreen_triangle"];

/// The operators of the vector file.
static OPERATORS: LazyLock<Vec<Value>> = LazyLock::new(|| {
    let text = include_str!("../vectors/operators.json");
    let mut file: Value = serde_json::from_str(text).expect("the vector file is JSON");
    match file["ops"].take() {
        Value::Array(ops) => ops,
        other => panic!("`ops` is not a list but {other}"),
    }
});

/// What a CPU reference reads: the parameters of its operator and the input of one case.
struct Case<'a> {
    params: &'a Value,
    input: &'a Value,
}

impl<'a> Case<'a> {
    /// The input as one number.
    fn number(&self) -> f64 {
        number(self.input)
    }

    /// The input as a list of numbers.
    fn numbers(&self) -> Vec<f64> {
        flat(self.input)
    }

    /// The input as three numbers.
    fn rgb(&self) -> Rgb {
        array(self.input)
    }

    /// The input as `N` numbers.
    fn array<const N: usize>(&self) -> [f64; N] {
        array(self.input)
    }

    /// The input as a list of triples.
    fn triples(&self) -> Vec<Rgb> {
        self.numbers().chunks_exact(3).map(|chunk| [chunk[0], chunk[1], chunk[2]]).collect()
    }

    /// The input as a word.
    fn word(&self) -> &'a str {
        word(self.input)
    }

    /// A named part of the input.
    fn part(&self, name: &str) -> &'a Value {
        self.input.get(name).unwrap_or_else(|| panic!("no `{name}` in {}", self.input))
    }

    /// A named number of the input.
    fn part_number(&self, name: &str) -> f64 {
        number(self.part(name))
    }

    /// A named triple of the input.
    fn part_rgb(&self, name: &str) -> Rgb {
        array(self.part(name))
    }

    /// A number among the operator's parameters.
    fn param(&self, name: &str) -> f64 {
        number(&self.params[name])
    }
}

/// A number; the file writes the special ones, and the word for holding, as strings.
fn number(value: &Value) -> f64 {
    match value {
        Value::Number(number) => number.as_f64().expect("the number fits f64"),
        Value::String(text) if text == "Inf" => f64::INFINITY,
        Value::String(text) if text == "-Inf" => f64::NEG_INFINITY,
        Value::String(text) if text == "NaN" || text == HOLD => f64::NAN,
        other => panic!("{other} is not a number"),
    }
}

/// How the file says that a meter has nothing to report; CPU references say NaN.
const HOLD: &str = "hold";

fn word(value: &Value) -> &str {
    value.as_str().unwrap_or_else(|| panic!("{value} is not a word"))
}

/// All numbers of nested lists, in order.
fn flat(value: &Value) -> Vec<f64> {
    match value {
        Value::Array(values) => values.iter().flat_map(flat).collect(),
        other => vec![number(other)],
    }
}

fn array<const N: usize>(value: &Value) -> [f64; N] {
    let numbers = flat(value);
    numbers.try_into().unwrap_or_else(|_| panic!("{value} has not {N} numbers"))
}

fn rows(matrix: &Matrix) -> Vec<f64> {
    matrix.concat()
}

/// How far a CPU reference may be from a printed number: its last digit, and never more than the
/// operator's own tolerance for an f32 implementation.
fn allowed(op: &Value, expected: f64) -> f64 {
    let class = word(&op["tolerance_class"]);
    let printed = match class {
        "code" => 1e-6,
        _ => 1e-11 + 1e-9 * expected.abs(),
    };
    let own = number(&op["abs_tol"]) + number(&op["rel_tol"]) * expected.abs();
    if class == "exact" { printed } else { printed.min(own) }
}

/// The vectors of matrices have other keys than those of operators.
fn input_and_output(case: &Value) -> (&Value, &Value) {
    match case.get("name") {
        Some(name) => (name, &case["rows"]),
        None => (&case["input"], &case["output"]),
    }
}

/// What is wrong with each case of an operator; empty when nothing is.
fn wrong_cases(op: &Value, reference: fn(&Case) -> Vec<f64>) -> Vec<String> {
    let cases = op["cases"].as_array().expect("an operator has cases");
    assert!(!cases.is_empty(), "{} has no cases", op["op"]);
    let check = |case| {
        let (input, output) = input_and_output(case);
        let found = reference(&Case { params: &op["params"], input });
        let expected = flat(output);
        let close = |(&found, &expected): (&f64, &f64)| {
            found == expected
                || (found.is_nan() && expected.is_nan())
                || (found - expected).abs() <= allowed(op, expected)
        };
        let right = found.len() == expected.len() && found.iter().zip(&expected).all(close);
        (!right).then(|| format!("{}({input}): {found:?} instead of {expected:?}", op["op"]))
    };
    cases.iter().filter_map(check).collect()
}

fn operator(name: &str) -> &'static Value {
    let found = OPERATORS.iter().find(|op| op["op"] == name);
    found.unwrap_or_else(|| panic!("the vector file has no operator `{name}`"))
}

/// Runs every case of every operator of a topic.
fn check(ops: &[Op]) {
    let wrong: Vec<String> = ops.iter().flat_map(|&(name, reference)| wrong_cases(operator(name), reference)).collect();
    assert!(wrong.is_empty(), "{}", wrong.join("\n"));
}

#[test]
fn every_operator_has_a_cpu_reference_or_is_listed_as_having_none() {
    let named = TOPICS.iter().copied().flatten().map(|(name, _)| *name);
    let mut accounted: Vec<&str> = named.chain(WITHOUT_REFERENCE.iter().copied()).collect();
    accounted.sort_unstable();
    let in_file: BTreeSet<&str> = OPERATORS.iter().map(|op| word(&op["op"])).collect();
    assert_eq!(accounted, in_file.into_iter().collect::<Vec<_>>());
    assert_eq!(OPERATORS.len(), accounted.len(), "an operator is in the file twice");
}

#[test]
fn a_wrong_reference_is_found() {
    let wrong = |case: &Case| vec![case.number() * 1.00001];
    assert!(wrong_cases(operator("srgb_oetf"), wrong).len() > 5);
    let short = |_: &Case| vec![];
    let cases = operator("sanitize")["cases"].as_array().expect("a list").len();
    assert_eq!(wrong_cases(operator("sanitize"), short).len(), cases);
}
