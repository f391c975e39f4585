//! The copy of the source in which the mutants are, and its test programs.

use std::collections::{BTreeMap, BTreeSet};
use std::path::{Path, PathBuf};
use std::process::{Command, Stdio};

use serde::{Deserialize, Serialize};
use serde_json::Value;

use crate::list::Mutant;
use crate::sites::Text;
use crate::weave::{SUPPORT, marks, weave};

/// The crates whose mutants are taken, whose tests run, and their folders.
pub(crate) const PURE: [(&str, &str); 4] = [
    ("afterimage-base", "graph/base"),
    ("afterimage-wgsl", "graph/wgsl"),
    ("afterimage-graph", "graph/core"),
    ("afterimage-plan", "graph/plan"),
];

/// A test program, the crate that it belongs to, and the folder in which it runs.
#[derive(Clone, Debug, Deserialize, Serialize)]
pub(crate) struct Program {
    pub(crate) package: String,
    pub(crate) path: PathBuf,
    pub(crate) folder: PathBuf,
}

/// The copy, and where it is built.
pub(crate) struct Tree {
    root: PathBuf,
    target: PathBuf,
}

impl Tree {
    /// Copies the files that git knows, those that have changed.
    pub(crate) fn copy(folder: &Path) -> Self {
        let tree = Self { root: folder.join("tree"), target: folder.join("build") };
        let output = Command::new("git")
            .args(["ls-files", "-z", "--cached", "--others", "--exclude-standard"])
            .output()
            .expect("git can be called");
        for name in String::from_utf8_lossy(&output.stdout).split_terminator('\0') {
            if let Ok(bytes) = std::fs::read(name) {
                write_changed(&tree.root.join(name), &bytes);
            }
        }
        tree
    }

    /// Puts the mutants into the copy, without those that do not compile behind a condition. Returns these.
    pub(crate) fn weave(&self, mutants: &[Mutant]) -> BTreeSet<usize> {
        let mut refused = BTreeSet::new();
        loop {
            refused.extend(self.write(mutants, &refused));
            let found = self.refused();
            println!("{} mutants do not compile behind a condition", refused.len() + found.len());
            if found.is_empty() {
                return refused;
            }
            refused.extend(found);
        }
    }

    /// Writes the files with all mutants but the refused ones.
    fn write(&self, mutants: &[Mutant], refused: &BTreeSet<usize>) -> Vec<usize> {
        let mut files: BTreeMap<&str, Vec<(usize, Mutant)>> = BTreeMap::new();
        for (number, mutant) in mutants.iter().enumerate() {
            let of_file = files.entry(&mutant.file).or_default();
            if !refused.contains(&number) {
                of_file.push((number, mutant.clone()));
            }
        }
        let roots: Vec<String> = PURE.iter().map(|(_, folder)| format!("{folder}/src/lib.rs")).collect();
        let names: BTreeSet<&str> = files.keys().copied().chain(roots.iter().map(String::as_str)).collect();
        let mut lost = Vec::new();
        for name in names {
            let text = Text::new(std::fs::read_to_string(name).unwrap_or_else(|error| panic!("{name}: {error}")));
            let (mut woven, without) = weave(&text, files.get(name).map_or(&[], Vec::as_slice));
            if roots.iter().any(|root| root == name) {
                woven += SUPPORT;
            }
            write_changed(&self.root.join(name), woven.as_bytes());
            lost.extend(without);
        }
        lost
    }

    /// The mutants at which the compiler reports errors.
    fn refused(&self) -> BTreeSet<usize> {
        let mut refused = BTreeSet::new();
        for message in self.cargo(&["check", "--lib", "--keep-going"]) {
            let message = &message["message"];
            if message["level"] != "error" {
                continue;
            }
            let spans = message["spans"].as_array().into_iter().flatten();
            for span in spans.filter(|span| span["is_primary"] == true) {
                let file = span["file_name"].as_str().expect("a span has a file");
                let byte = span["byte_start"].as_u64().expect("a span begins") as usize;
                let woven = std::fs::read_to_string(self.root.join(file)).unwrap_or_default();
                let distance =
                    |range: &std::ops::Range<usize>| range.start.abs_diff(byte).min(range.end.abs_diff(byte));
                let marks = marks(&woven);
                let inside =
                    marks.iter().filter(|(_, range)| range.contains(&byte)).min_by_key(|(_, range)| range.len());
                let nearest = inside.or_else(|| marks.iter().min_by_key(|(_, range)| distance(range)));
                refused.extend(nearest.map(|(number, _)| *number));
            }
        }
        refused
    }

    /// Compiles the tests of the crates.
    pub(crate) fn programs(&self) -> Vec<Program> {
        let artifacts = self.cargo(&["test", "--no-run", "--lib", "--tests"]);
        let of = |message: &Value| {
            let path = message["executable"].as_str()?;
            let manifest = Path::new(message["manifest_path"].as_str()?);
            let folder = manifest.parent()?.to_owned();
            let relative = folder.strip_prefix(&self.root).ok()?.to_str()?;
            let package = PURE.iter().find(|(_, folder)| *folder == relative)?.0.to_owned();
            Some(Program { package, path: path.into(), folder })
        };
        let programs: Vec<Program> = artifacts.iter().filter_map(of).collect();
        assert!(programs.len() >= PURE.len(), "the tests do not compile: see above");
        programs
    }

    fn cargo(&self, arguments: &[&str]) -> Vec<Value> {
        let packages = PURE.iter().flat_map(|(name, _)| ["-p", name]);
        let output = Command::new("cargo")
            .args(arguments)
            .args(packages)
            .args(["--quiet", "--message-format", "json"])
            .current_dir(&self.root)
            .env("CARGO_TARGET_DIR", &self.target)
            .env("CARGO_PROFILE_DEV_DEBUG", "0")
            .stderr(Stdio::inherit())
            .output()
            .expect("cargo can be called");
        let lines = String::from_utf8_lossy(&output.stdout).into_owned();
        lines.lines().filter_map(|line| serde_json::from_str(line).ok()).collect()
    }
}

/// Writes a file if its content differs, so that cargo compiles only what has changed.
fn write_changed(path: &Path, bytes: &[u8]) {
    if std::fs::read(path).is_ok_and(|old| old == bytes) {
        return;
    }
    std::fs::create_dir_all(path.parent().expect("a file is in a folder")).expect("the folder can be made");
    std::fs::write(path, bytes).unwrap_or_else(|error| panic!("{}: {error}", path.display()));
}
