//! Well-formed names.

/// `ToneMap`.
pub(in crate::node) fn is_pascal(name: &str) -> bool {
    name.starts_with(|c: char| c.is_ascii_uppercase()) && name.chars().all(|c| c.is_ascii_alphanumeric())
}

/// `tone_map`.
pub(super) fn is_snake(name: &str) -> bool {
    let inner = |c: char| c.is_ascii_lowercase() || c.is_ascii_digit() || c == '_';
    name.starts_with(|c: char| c.is_ascii_lowercase())
        && name.chars().all(inner)
        && !name.contains("__")
        && !name.ends_with('_')
}

/// `ToneMap` as `tone_map`.
pub(in crate::node) fn snake(pascal: &str) -> String {
    let mut snake = String::new();
    for c in pascal.chars() {
        if c.is_ascii_uppercase() && !snake.is_empty() {
            snake.push('_');
        }
        snake.push(c.to_ascii_lowercase());
    }
    snake
}

/// `tone_map` as `ToneMap`.
pub(super) fn pascal(snake: &str) -> String {
    let word = |word: &str| {
        word.chars().take(1).map(|c| c.to_ascii_uppercase()).chain(word.chars().skip(1)).collect::<String>()
    };
    snake.split('_').map(word).collect()
}

/// Whether WGSL takes the name for a variable.
pub(super) fn is_free_in_wgsl(name: &str) -> bool {
    afterimage_wgsl::is_free_name(name)
}

/// The name of a file without folders and ending.
pub(in crate::node) fn stem(file: &str) -> &str {
    let name = file.rsplit(['/', '\\']).next().unwrap_or(file);
    name.split('.').next().unwrap_or(name)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn reserved_words_of_wgsl_are_not_free() {
        for word in ["target", "filter", "from", "let"] {
            assert!(!is_free_in_wgsl(word), "{word}");
        }
        assert!(is_free_in_wgsl("source"));
    }

    #[test]
    fn names_change_case_both_ways() {
        assert_eq!(snake("LocalToneMap"), "local_tone_map");
        assert_eq!(pascal("local_tone_map"), "LocalToneMap");
    }
}
