//! Well-formed names, and the names in a file of WGSL.

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

/// Whether an item's name begins with the name of its file, in whichever case it is written.
pub(in crate::node) fn belongs(item: &str, stem: &str) -> bool {
    let prefixes = [stem, &pascal(stem), &stem.to_uppercase()];
    let rest = prefixes.into_iter().find_map(|prefix| item.strip_prefix(prefix));
    rest.is_some_and(|rest| !rest.starts_with(|c: char| c.is_ascii_lowercase()))
}

/// The names of a file's own items: functions, structs, constants and variables, but not the bindings of whole kernels.
pub(in crate::node) fn items(source: &str) -> Vec<String> {
    let mut items = Vec::new();
    let mut depth = 0_i32;
    let mut is_bound = false;
    for line in source.lines() {
        let line = line.split("//").next().unwrap_or_default();
        if depth == 0 && !line.trim().is_empty() {
            is_bound |= line.contains("@binding");
            if let Some(name) = item(line) {
                let is_variable = line.contains("var");
                if !(is_bound && is_variable) {
                    items.push(name);
                }
                is_bound = false;
            }
        }
        depth += line.matches('{').count() as i32 - line.matches('}').count() as i32;
    }
    items
}

/// The name that a line declares.
fn item(line: &str) -> Option<String> {
    let mut rest = line.trim();
    while rest.starts_with('@') {
        let end = rest.find(|c: char| c.is_whitespace() || c == '(').unwrap_or(rest.len());
        let is_call = rest[end..].starts_with('(');
        let end = if is_call { end + rest[end..].find(')')? + 1 } else { end };
        rest = rest[end..].trim_start();
    }
    let (word, after) = rest.split_at(rest.find(|c: char| c.is_whitespace() || c == '<').unwrap_or(rest.len()));
    if !["fn", "struct", "const", "override", "alias", "var"].contains(&word) {
        return None;
    }
    let after = if after.starts_with('<') { &after[after.find('>')? + 1..] } else { after };
    let name: String = after.trim_start().chars().take_while(|c| c.is_alphanumeric() || *c == '_').collect();
    (!name.is_empty()).then_some(name)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn items_are_found_and_bindings_left_out() {
        let source = "const A_B: u32 = 1u;\nstruct S { x: f32 }\n@group(0) @binding(0) var<uniform> params: S;\n\
                      var<workgroup> a_sums: array<f32, 4>;\n@compute @workgroup_size(8, 8)\nfn a_run() {\n  let fn_like = 1;\n}\n";
        assert_eq!(items(source), ["A_B", "S", "a_sums", "a_run"]);
    }

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
