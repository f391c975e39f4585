//! Places in the code that a document names, compared with the code.
//!
//! A row of a table names a file or folder as `` `graph/plan/src/cull.rs` ``, and what it declares as
//! `` `cull` in `graph/plan/src/cull.rs` `` or `` `cull` and `Liveness::of` in `...` ``. `<kind>` in a path stands for
//! any name.

use std::path::{Path, PathBuf};

use crate::workspace::read;

/// A path in a row, and the names that the row looks for in it.
#[derive(Debug, PartialEq)]
struct Place<'t> {
    names: Vec<&'t str>,
    path: &'t str,
}

/// What the tables of a document name and the workspace does not have, a sentence each.
pub fn violations(root: &Path, text: &str) -> Vec<String> {
    let rows = text.lines().enumerate().filter(|(_, line)| line.starts_with('|'));
    let found = rows.flat_map(|(line, row)| places(row).into_iter().map(move |place| (line + 1, place)));
    found.flat_map(|(line, place)| missing(root, &place).into_iter().map(move |why| format!("{line}: {why}"))).collect()
}

/// The places of a row.
fn places(row: &str) -> Vec<Place<'_>> {
    // Text and code alternate, and a row begins with text.
    let parts: Vec<&str> = row.split('`').collect();
    let paths = (1..parts.len()).step_by(2).filter(|at| is_path(parts[*at]));
    paths.map(|at| Place { names: names_before(&parts, at), path: parts[at] }).collect()
}

fn is_path(code: &str) -> bool {
    code.contains('/') && !code.contains(' ')
}

/// The names in ``..., `a` and `b` in `path` ``; `at` is the index of the path.
fn names_before<'t>(parts: &[&'t str], at: usize) -> Vec<&'t str> {
    let mut names = Vec::new();
    let mut at = at;
    let joins = |text: &str, is_first: bool| if is_first { text == " in " } else { text == " and " || text == ", " };
    while at >= 3 && joins(parts[at - 1], names.is_empty()) && !is_path(parts[at - 2]) {
        at -= 2;
        names.push(parts[at]);
    }
    names
}

fn missing(root: &Path, place: &Place<'_>) -> Vec<String> {
    let files = files(root, place.path);
    if files.is_empty() {
        return vec![format!("there is no `{}`", place.path)];
    }
    let texts: Vec<String> = files.iter().filter(|file| file.is_file()).map(|file| read(file)).collect();
    let absent = place.names.iter().filter(|name| !texts.iter().any(|text| declares(text, name)));
    absent.map(|name| format!("`{}` declares no `{name}`", place.path)).collect()
}

/// The file or folder, or the files that `<kind>` may stand for.
fn files(root: &Path, path: &str) -> Vec<PathBuf> {
    let Some((folder, ending)) = path.split_once("<kind>") else {
        return Some(root.join(path)).filter(|path| path.exists()).into_iter().collect();
    };
    crate::workspace::files_in(&root.join(folder), &[ending.trim_start_matches('.')])
}

/// True if a text of Rust or WGSL declares a function, type, constant, field or attribute; `Type::function` needs both
/// names.
fn declares(text: &str, name: &str) -> bool {
    if let Some((owner, function)) = name.rsplit_once("::") {
        return occurs(text, "", owner) && occurs(text, "fn ", function);
    }
    let keywords = ["fn ", "struct ", "enum ", "trait ", "type ", "const ", "static ", "mod "];
    let is_field = || occurs(text, "pub ", &format!("{name}:"));
    keywords.iter().any(|keyword| occurs(text, keyword, name))
        || is_field()
        || name.starts_with('@') && text.contains(name)
}

/// True if the text has the name as a whole word behind the prefix.
fn occurs(text: &str, prefix: &str, name: &str) -> bool {
    let is_part = |character: Option<char>| character.is_some_and(|c| c.is_alphanumeric() || c == '_');
    text.match_indices(&format!("{prefix}{name}")).any(|(at, found)| {
        let ends = name.ends_with(':') || !is_part(text[at + found.len()..].chars().next());
        ends && !is_part(text[..at].chars().next_back())
    })
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_names_before_a_path_belong_to_it() {
        let row =
            "| Where is `x/y z`? | `a`, `B::b` and `c` in `p/q.rs` and `d` in `e/`; `--set`, then `f` of `g/h.rs` |";
        let found = places(row);
        let of = |names: &[&'static str], path| Place { names: names.to_vec(), path };
        assert_eq!(found, [of(&["c", "B::b", "a"], "p/q.rs"), of(&["d"], "e/"), of(&[], "g/h.rs")]);
    }

    #[test]
    fn declarations_are_whole_words() {
        let text =
            "pub struct Plan { pub bins: u32 }\nimpl Plan {\n    fn to_text(&self) {}\n}\nconst WIDTH: u32 = 1;\n";
        for name in ["Plan", "to_text", "WIDTH", "bins", "Plan::to_text"] {
            assert!(declares(text, name), "{name}");
        }
        for name in ["Pla", "text", "to_tex", "u32", "Graph::to_text", "Plan::bins", "@compute"] {
            assert!(!declares(text, name), "{name}");
        }
        assert!(declares("@workgroup_size(64) fn f()", "@workgroup_size"));
    }

    #[test]
    fn what_is_not_there_is_reported() {
        let root = Path::new(env!("CARGO_MANIFEST_DIR"));
        let text = "`src/none.rs` in prose does not count\n\
                    | `violations` in `src/places.rs` | `src/<kind>.rs` |\n\
                    | `nothing` in `src/places.rs`, `src/none.rs` | `is_path` in `src/<kind>.rs` |\n";
        let wanted = ["3: `src/places.rs` declares no `nothing`", "3: there is no `src/none.rs`"];
        assert_eq!(violations(root, text), wanted);
    }
}
