//! Well-formed names.

/// Names that pipeline files use themselves.
pub(super) const RESERVED: [&str; 3] = ["Pipeline", "Off", "On"];

/// Name of the files and functions of a kind: `tone_map` for `ToneMap`.
///
/// # Errors
/// Why no kind can have the name.
pub fn kind_file_name(kind: &str) -> Result<String, String> {
    if !is_pascal(kind) {
        return Err("it begins with a capital letter and holds letters and digits only, as `ToneMap` does".into());
    }
    let file = snake(kind);
    match is_free_in_wgsl(&file) {
        _ if RESERVED.contains(&kind) => Err("pipeline files use this name themselves".into()),
        false => Err(format!("`{file}` is a word of WGSL and cannot be the name of its function")),
        true if afterimage_wgsl::is_type_name(&file) => {
            Err(format!("its function would hide the type `{file}` of WGSL"))
        }
        true => Ok(file),
    }
}

pub(in crate::node) fn is_pascal(name: &str) -> bool {
    name.starts_with(|c: char| c.is_ascii_uppercase()) && name.chars().all(|c| c.is_ascii_alphanumeric())
}

pub(in crate::node) fn is_snake(name: &str) -> bool {
    let inner = |c: char| c.is_ascii_lowercase() || c.is_ascii_digit() || c == '_';
    name.starts_with(|c: char| c.is_ascii_lowercase())
        && name.chars().all(inner)
        && !name.contains("__")
        && !name.ends_with('_')
}

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

pub(super) fn pascal(snake: &str) -> String {
    let word = |word: &str| {
        word.chars().take(1).map(|c| c.to_ascii_uppercase()).chain(word.chars().skip(1)).collect::<String>()
    };
    snake.split('_').map(word).collect()
}

/// Returns whether WGSL takes the name for a variable.
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
    fn a_kind_has_a_file_name_unless_its_own_is_taken() {
        assert_eq!(kind_file_name("ToneMap").as_deref(), Ok("tone_map"));
        let target = ("Target", "a word of WGSL");
        let types = [("F32", "the type `f32`"), ("Vec4f", "the type `vec4f`"), ("Sampler", "the type `sampler`")];
        let others = [("toneMap", "capital"), ("../Up", "capital"), ("Off", "pipeline files"), target];
        for (name, why) in others.into_iter().chain(types) {
            assert!(kind_file_name(name).is_err_and(|error| error.contains(why)), "{name}");
        }
    }

    #[test]
    fn names_change_case_both_ways() {
        assert_eq!(snake("LocalToneMap"), "local_tone_map");
        assert_eq!(pascal("local_tone_map"), "LocalToneMap");
    }
}
