//! Names in messages: quoted, listed, and the nearest to a wrong one.

/// A name in backticks for a message: shortened, and without control characters.
pub fn quote(name: &str) -> String {
    const MAX_LENGTH: usize = 48;
    let shown: String = name.chars().take(MAX_LENGTH).flat_map(char::escape_debug).collect();
    // Quotes inside backticks need no escape of their own.
    let shown = shown.replace("\\'", "'").replace("\\\"", "\"");
    if name.chars().nth(MAX_LENGTH).is_some() { format!("`{shown}…`") } else { format!("`{shown}`") }
}

/// A list of names for a message: `a`, `b` and `c`; at most `most` of them.
pub fn list<'a>(names: impl IntoIterator<Item = &'a str>, most: usize) -> String {
    let mut names = names.into_iter();
    let shown: Vec<String> = names.by_ref().take(most).map(quote).collect();
    match (shown.split_last(), names.count()) {
        (None, 0) => String::new(),
        (Some((only, [])), 0) => only.clone(),
        (Some((last, rest)), 0) => format!("{} and {last}", rest.join(", ")),
        (_, more) => format!("{} and {more} more", shown.join(", ")),
    }
}

/// "did you mean `x`?" with the nearest of the names, if one is near enough.
pub fn did_you_mean<'a>(wrong: &str, names: impl IntoIterator<Item = &'a str>) -> Option<String> {
    nearest(wrong, names).map(|name| format!("did you mean {}?", quote(name)))
}

/// The name nearest to `wrong`, if at most a third of the letters of `wrong` differ, or one begins with the other.
pub fn nearest<'a>(wrong: &str, names: impl IntoIterator<Item = &'a str>) -> Option<&'a str> {
    equally_near(wrong, names).first().copied()
}

/// The names nearest to `wrong`, sorted, each once; none if more than a third of the letters of `wrong` differ.
pub(super) fn equally_near<'a>(wrong: &str, names: impl IntoIterator<Item = &'a str>) -> Vec<&'a str> {
    const MAX_LENGTH: usize = 64;
    if wrong.len() > MAX_LENGTH {
        return Vec::new();
    }
    let plain = |name: &str| name.to_lowercase().replace(['_', '-', ' '], "");
    let meant = plain(wrong);
    let allowed = (wrong.chars().count() / 3).max(1);
    let distance = |name: &str| {
        let plain = plain(name);
        let is_beginning = meant.len() >= 4 && plain.starts_with(&meant);
        // `ToneMapping` for `ToneMap`.
        let is_longer = plain.len() >= 5 && meant.len() < 2 * plain.len() && meant.starts_with(&plain);
        match strsim::damerau_levenshtein(&meant, &plain) {
            _ if is_beginning => 1,
            distance if is_longer => distance.min(allowed),
            distance => distance,
        }
    };
    let near = names.into_iter().filter(|name| name.len() <= MAX_LENGTH).map(|name| (distance(name), name));
    let mut near: Vec<(usize, &str)> = near.filter(|(distance, _)| *distance <= allowed).collect();
    near.sort_unstable();
    near.dedup();
    let least = near.first().map(|(distance, _)| *distance);
    near.into_iter().take_while(|(distance, _)| Some(*distance) == least).map(|(_, name)| name).collect()
}
