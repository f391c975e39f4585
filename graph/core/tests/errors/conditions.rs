//! Conditions over facts.

use afterimage_graph::check::{Condition, Fact, Facts};

fn holds(condition: &str, facts: &[(&str, Fact)]) -> bool {
    let facts: Facts = facts.iter().copied().collect();
    Condition::parse(condition).unwrap_or_else(|error| panic!("{condition}: {}", error.message)).holds(&facts)
}

#[test]
fn and_binds_tighter_than_or_and_not_tighter_than_both() {
    let facts = [("a", true.into()), ("b", false.into()), ("c", false.into())];
    assert!(holds("a or b and c", &facts));
    assert!(!holds("(a or b) and c", &facts));
    assert!(holds("not b and a", &facts));
    assert!(!holds("not (b or a)", &facts));
}

#[test]
fn all_comparisons() {
    let facts = [("x", 10.0.into())];
    for (condition, expected) in [
        ("x < 10", false),
        ("x <= 10", true),
        ("x > 10", false),
        ("x >= 10", true),
        ("x == 10", true),
        ("x != 10", false),
        ("9.5 < x", true),
        ("-1e1 < x", true),
        ("+10 < x", false),
        ("x<.5", false),
        ("x == x", true),
    ] {
        assert_eq!(holds(condition, &facts), expected, "{condition}");
    }
}

#[test]
fn facts_that_are_not_given_may_have_any_value() {
    assert!(holds("a", &[]) && holds("not a", &[]) && holds("x < 1", &[]) && holds("not x < 1", &[]));
    assert!(!holds("a and b", &[("b", false.into())]), "one false part is enough, whatever the other is");
    assert!(holds("a and b", &[("b", true.into())]));
    assert!(!holds("a\u{3000}and\u{2003}b", &[("b", false.into())]), "spaces may be wide");
    assert!(!holds("not (a or b)", &[("b", true.into())]));
}

/// Kleene's three values: a part that nobody knows counts only where the other does not decide.
#[test]
fn the_tables_of_truth_hold_for_what_is_known_and_for_what_is_not() {
    let values = [Some(true), Some(false), None];
    let and = |a, b| if a == Some(false) || b == Some(false) { Some(false) } else { Some(a? && b?) };
    let or = |a, b| if a == Some(true) || b == Some(true) { Some(true) } else { Some(a? || b?) };
    for (a, b) in values.into_iter().flat_map(|a| values.map(|b| (a, b))) {
        let named = [("a", a), ("b", b)].into_iter().filter_map(|(name, value)| Some((name, Fact::from(value?))));
        let facts: Vec<(&str, Fact)> = named.collect();
        let not = |a: Option<bool>| a.map(|a| !a);
        for (condition, wanted) in [
            ("a and b", and(a, b)),
            ("a or b", or(a, b)),
            ("not (a and b)", not(and(a, b))),
            ("not (a or b)", not(or(a, b))),
            ("not a or b", or(not(a), b)),
            ("a and not b", and(a, not(b))),
        ] {
            assert_eq!(holds(condition, &facts), wanted.unwrap_or(true), "{condition} where a is {a:?} and b {b:?}");
        }
    }
}

#[test]
fn nonsense_from_the_host_counts_as_untold() {
    assert!(holds("x < 1", &[("x", f64::NAN.into())]) && holds("not x < 1", &[("x", f64::NAN.into())]));
    assert!(holds("a", &[("a", 0.0.into())]) && holds("x < 1", &[("x", true.into())]));
}

#[test]
fn a_printed_condition_reads_the_same() {
    for condition in
        ["a", "not a", "not (a and b)", "a and (b or c)", "a or b and c", "x < 10", "not (x >= -0.5)", "not not a"]
    {
        let read = Condition::parse(condition).expect("it is well formed");
        assert_eq!(read.to_string(), condition);
        assert_eq!(Condition::parse(&read.to_string()).expect("it is well formed"), read);
    }
}

#[test]
fn facts_are_listed_once() {
    let condition = Condition::parse("b and (a or not b) and x < y").expect("it is well formed");
    assert_eq!(condition.facts(), ["a", "b", "x", "y"]);
}

#[test]
fn endless_conditions_are_refused() {
    for condition in
        [format!("{}a", "not ".repeat(100_000)), format!("{}a", "(".repeat(100_000)), vec!["a"; 100_000].join(" or ")]
    {
        assert_eq!(Condition::parse(&condition).expect_err("it is endless").message, "the condition is too long");
    }
}

#[test]
fn a_condition_is_as_long_and_as_deep_as_it_may_be_and_no_more() {
    let refused = |text: &str| {
        let error = Condition::parse(text).expect_err("it is too long");
        assert_eq!(error.message, "the condition is too long", "{} bytes", text.len());
    };
    let nested = |depth: usize| "(".repeat(depth) + "a" + &")".repeat(depth);
    assert!(Condition::parse(&nested(63)).is_ok());
    refused(&nested(64));
    // A negation and a word, then two words each.
    let words = |more: usize| "not a".to_owned() + &" and a".repeat(more);
    assert!(Condition::parse(&words(255)).is_ok(), "512 tokens");
    refused(&words(256));
    let name = |bytes: usize| "a".repeat(bytes);
    let long = (1..1 << 20).find(|bytes| Condition::parse(&name(*bytes)).is_err()).expect("there is a limit");
    assert!(long > 512, "{long} bytes, and one token");
    refused(&name(long));
}

#[test]
fn signs_of_other_languages_are_named_with_the_word_for_them() {
    for (condition, sign, help) in [
        ("a && b", "&&", "write `and`"),
        ("a & b", "&", "write `and`"),
        ("a || b", "||", "write `or`"),
        ("!a", "!", "write `not`"),
        ("x = 1", "=", "write `==`"),
        ("a $ b", "$", "a condition looks like `emissive and illuminance < 10`"),
    ] {
        let Err(error) = Condition::parse(condition) else { panic!("{condition} is no condition") };
        assert_eq!(&condition[error.span.clone()], sign);
        assert_eq!(error.message, format!("`{sign}` does not belong into a condition"));
        assert_eq!(error.help, help);
    }
}
