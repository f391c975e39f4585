//! Faults that people seed: a list of changes of the code.

use crate::list::{Mutant, Place, Span};

/// A change of a file: texts, and what stands in their places.
pub(crate) struct Fault {
    name: String,
    pub(crate) file: String,
    changes: Vec<(String, String)>,
}

/// The faults of a list. Each begins with a line `# name` and the path of its file. A line with `-` in front is a text
/// that the file has once, and the line with `+` after it is the text with the fault, in which `FAULT` is true.
pub(crate) fn read(list: &str) -> Vec<Fault> {
    let text = std::fs::read_to_string(list).unwrap_or_else(|error| panic!("{list}: {error}"));
    text.split("\n# ").skip(1).map(fault).collect()
}

fn fault(text: &str) -> Fault {
    let mut lines = text.lines().filter(|line| !line.trim().is_empty());
    let mut next = || lines.next().unwrap_or_default().to_owned();
    let (name, file) = (next(), next());
    let mut changes = Vec::new();
    loop {
        let (old, new) = (next(), next());
        match (old.strip_prefix("- "), new.strip_prefix("+ ")) {
            (Some(old), Some(new)) => changes.push((old.to_owned(), new.to_owned())),
            _ => break,
        }
    }
    assert!(!changes.is_empty(), "`{name}` changes nothing");
    Fault { name, file, changes }
}

impl Fault {
    /// The text of its file with the fault behind the condition of that number.
    pub(crate) fn put_into(&self, text: &str, number: usize) -> String {
        let condition = format!("crate::__mutant({number})");
        self.changes.iter().fold(text.to_owned(), |text, (old, new)| {
            let count = text.matches(old.as_str()).count();
            assert_eq!(count, 1, "`{}`: {} has `{old}` {count} times", self.name, self.file);
            text.replacen(old.as_str(), &new.replace("FAULT", &condition), 1)
        })
    }

    /// The fault as a mutant of its crate.
    pub(crate) fn mutant(&self) -> Mutant {
        let package = match self.file.strip_prefix("graph/").and_then(|path| path.split_once('/')) {
            Some((name @ ("gpu" | "media" | "plan" | "wgsl"), _)) => format!("afterimage-{name}"),
            _ => "afterimage-graph".to_owned(),
        };
        Mutant {
            name: self.name.clone(),
            file: self.file.clone(),
            package,
            genre: "Fault".to_owned(),
            replacement: String::new(),
            span: Span { start: Place { line: 1, column: 1 } },
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    /// [`Fault::put_into`] looks for each text in the code as it is now.
    #[test]
    fn the_lists_name_what_the_code_has() {
        let root = std::path::Path::new(env!("CARGO_MANIFEST_DIR")).join("../..");
        for (list, count) in [("planner", 9), ("gpu", 100), ("pure", 60)] {
            let faults = read(&root.join(format!("tests/mutants/{list}.txt")).to_string_lossy());
            assert!(faults.len() >= count, "{list}: {} faults", faults.len());
            for fault in faults {
                let text = std::fs::read_to_string(root.join(&fault.file)).unwrap_or_else(|why| panic!("{why}"));
                assert!(fault.put_into(&text, 7).contains("crate::__mutant(7)"), "`{}` has no condition", fault.name);
            }
        }
    }
}
