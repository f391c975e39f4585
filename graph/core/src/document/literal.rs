//! Values of single tokens.

use super::tree::Tree;

/// The value of a word without parentheses.
pub(super) fn plain_word(word: &str) -> Tree {
    match word {
        "true" | "false" => Tree::Bool(word == "true"),
        "inf" | "inff32" | "inff64" => Tree::Float(f64::INFINITY),
        "NaN" | "NaNf32" | "NaNf64" => Tree::Float(f64::NAN),
        _ => Tree::Name(plain_name(word).to_owned()),
    }
}

/// Decodes a number; `None` if it is none that RON knows.
pub(super) fn number(written: &str) -> Option<Tree> {
    plain_number(written).or_else(|| match ron::from_str::<i64>(written) {
        Ok(whole) => Some(Tree::Int(whole)),
        Err(_) => ron::from_str::<f64>(written).ok().map(Tree::Float),
    })
}

/// Decodes a string with its quotes; `None` if it has an unknown escape.
pub(super) fn text(written: &str) -> Option<Tree> {
    match plain_text(written) {
        Some(plain) => Some(Tree::Text(plain.to_owned())),
        None => ron::from_str(written).ok().map(Tree::Text),
    }
}

/// A name without the `r#` of a raw one.
pub(super) fn plain_name(word: &str) -> &str {
    word.strip_prefix("r#").unwrap_or(word)
}

/// Text between the quotes, if it needs no decoding.
fn plain_text(written: &str) -> Option<&str> {
    let inside = written.strip_prefix('"')?.strip_suffix('"')?;
    (!inside.contains(['\\', '"'])).then_some(inside)
}

/// A plain decimal number: digits, and perhaps a sign and a point. `ron` is slower.
fn plain_number(written: &str) -> Option<Tree> {
    let digits = written.strip_prefix('-').unwrap_or(written);
    let are_digits = |part: &str| !part.is_empty() && part.bytes().all(|byte| byte.is_ascii_digit());
    match digits.split_once('.') {
        Some((whole, rest)) if are_digits(whole) && are_digits(rest) => written.parse().ok().map(Tree::Float),
        None if are_digits(digits) && !digits.starts_with('0') => written.parse().ok().map(Tree::Int),
        _ => None,
    }
}

#[cfg(test)]
mod tests {
    use super::{Tree, number, plain_number, plain_text};

    /// The fast path agrees with `ron`.
    #[test]
    fn plain_numbers_and_texts_are_those_of_ron() {
        let digits = ["0", "-0", "7", "-7", "007", "1_000", "0x1F", "+3", "9223372036854775807", "9223372036854775808"];
        let floats =
            ["1.5", "-0.0", "0.1", "00.5", ".5", "5.", "1e3", "1.5e-3", "1.0.0", "123456789.123456789123456789"];
        let mut taken = 0;
        for text in digits.into_iter().chain(floats) {
            let Some(plain) = plain_number(text) else { continue };
            let whole = ron::from_str::<i64>(text).ok().map(Tree::Int);
            let read = whole.or_else(|| ron::from_str::<f64>(text).ok().map(Tree::Float));
            assert_eq!(Some(&plain), read.as_ref(), "{text}");
            assert_eq!(Some(plain), number(text), "{text}");
            taken += 1;
        }
        assert!(taken >= 8, "only {taken} numbers are plain");
        for text in ["\"\"", "\"a b\"", "\"ü\n\"", "\"a\\tb\"", "\"\\\"\"", "\"/* no comment */\""] {
            let plain = plain_text(text).map(str::to_owned);
            assert!(plain.is_none_or(|plain| Ok(plain) == ron::from_str::<String>(text)), "{text}");
        }
    }
}
