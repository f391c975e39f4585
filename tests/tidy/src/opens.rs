//! Where files are opened: in two places, which read regular files of a bounded size only, and in one that writes.

use std::path::{Path, PathBuf};

use crate::workspace::{Workspace, read};

/// The folder that may open files, and the file of the crate for hosts, which has no codecs of images.
const OPENS: [&str; 2] = ["graph/media/src/files", "graph/afterimage/src/files.rs"];
/// Programs of their own, which read what their author names: build scripts, benches, examples, tests.
const PROGRAMS: [&str; 4] = ["benches", "examples", "tests", "build.rs"];
/// Functions that open a file.
const OPENERS: [&str; 9] = [
    "File::open",
    "File::create",
    "File::options",
    "OpenOptions",
    "fs::read(",
    "fs::read_to_string",
    "fs::write(",
    "fs::copy(",
    "fs::hard_link",
];

/// Where files of the product open others, a sentence each. Tests inside of the files are not counted.
pub fn violations(workspace: &Workspace, files: &[PathBuf]) -> Vec<String> {
    let product = files.iter().map(|file| (workspace.short(file), file)).filter(|(short, _)| !may_open(short));
    product.flat_map(|(short, file)| in_text(short, &read(file))).collect()
}

fn may_open(file: &Path) -> bool {
    let is_program = |part: std::path::Component<'_>| PROGRAMS.iter().any(|name| part.as_os_str() == *name);
    OPENS.iter().any(|place| file.starts_with(place)) || file.components().any(is_program)
}

fn in_text(file: &Path, text: &str) -> Vec<String> {
    let product = text.split("#[cfg(test)]").next().unwrap_or_default();
    let in_line = |(number, line): (usize, &str)| {
        let found = OPENERS.iter().find(|opener| line.contains(**opener))?;
        Some(format!("{}:{}: `{found}` outside of `{}`", file.display(), number + 1, OPENS[0]))
    };
    product.lines().enumerate().filter_map(in_line).collect()
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn an_opened_file_is_found_outside_of_tests() {
        let text = "//! A.\nfn a() { std::fs::read(path); }\n#[cfg(test)]\nmod tests { fn b() { fs::read(path); } }\n";
        assert_eq!(in_text(Path::new("a.rs"), text), ["a.rs:2: `fs::read(` outside of `graph/media/src/files`"]);
    }

    #[test]
    fn programs_and_the_place_that_opens_files_are_free() {
        for (file, free) in [
            ("graph/media/src/files/regular.rs", true),
            ("shaders/build.rs", true),
            ("nodes/examples/color_file.rs", true),
            ("graph/media/src/codec/mod.rs", false),
        ] {
            assert_eq!(may_open(Path::new(file)), free, "{file}");
        }
    }
}
