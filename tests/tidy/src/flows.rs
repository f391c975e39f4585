//! Flows: the way of a task or of a value through the files.
//!
//! A flow is a file in `tests/tidy/flows/`. Each line names a station, `FILE::FUNCTION` or `FILE::TYPE::FUNCTION`, in
//! the order of execution; its indentation is its depth in the tree of calls. Lines with `#` are comments.
//! `limit files N` and `limit returns N` state the most that is allowed.
//!
//! Each station is verified: the function exists, and the function that calls it, the nearest line above with less
//! indentation, names it in its body. `FILE::FUNCTION via NAME` stands where the caller knows it by another name: by a
//! trait, a macro or a constant. `FILE::FUNCTION reads NAME` stands where no call leads to it, but data that an earlier
//! station has stored: the function itself names the data. A WGSL function is a station too.
//!
//! Consecutive stations in one file are one stay. A return is a stay in a file that was left before. That control
//! comes back to a caller is no stay; a further call from there is counted where it leads.

use std::collections::BTreeSet;
use std::path::Path;

use crate::functions::{Function, in_text};
use crate::workspace::read;

/// A task or a value, with its stations.
#[derive(Debug, Default)]
pub struct Flow {
    /// The most files that are allowed.
    pub max_files: Option<usize>,
    /// The most returns that are allowed.
    pub max_returns: Option<usize>,
    stations: Vec<Station>,
}

#[derive(Debug)]
struct Station {
    depth: usize,
    file: String,
    owner: Option<String>,
    function: String,
    link: Link,
}

/// What leads to a station.
#[derive(Debug)]
enum Link {
    /// The caller names this.
    Named(String),
    /// The function itself names this.
    Reads(String),
}

/// The figures of a flow.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Figures {
    /// Functions on the way.
    pub stations: usize,
    /// Different files.
    pub files: usize,
    /// Stays in a file that was left before.
    pub returns: usize,
}

impl Flow {
    /// Reads the text of a flow.
    ///
    /// # Panics
    ///
    /// Panics at a line that is no station and no limit.
    pub fn parse(text: &str) -> Self {
        let mut flow = Self::default();
        for line in text.lines().filter(|line| !line.trim().is_empty() && !line.starts_with('#')) {
            match line.split_whitespace().collect::<Vec<_>>()[..] {
                ["limit", "files", limit] => flow.max_files = limit.parse().ok(),
                ["limit", "returns", limit] => flow.max_returns = limit.parse().ok(),
                _ => flow.stations.push(Station::parse(line)),
            }
        }
        flow
    }

    /// The figures.
    pub fn figures(&self) -> Figures {
        let mut stays: Vec<&str> = self.stations.iter().map(|station| station.file.as_str()).collect();
        stays.dedup();
        let files = stays.iter().collect::<BTreeSet<_>>().len();
        Figures { stations: self.stations.len(), files, returns: stays.len() - files }
    }

    /// What is wrong with the stations in the code below `root`, and which limits are exceeded; a sentence each.
    pub fn violations(&self, root: &Path) -> Vec<String> {
        let missing = (0..self.stations.len()).filter_map(|at| self.fault(root, at).err());
        let Figures { files, returns, .. } = self.figures();
        let exceeded = [("files", files, self.max_files), ("returns", returns, self.max_returns)];
        let exceeded = exceeded.into_iter().filter_map(|(what, count, limit)| {
            limit.filter(|limit| count > *limit).map(|limit| format!("{count} {what}, at most {limit} are allowed"))
        });
        missing.chain(exceeded).collect()
    }

    /// The stays in order, one line each.
    pub fn stays(&self) -> String {
        let mut text = String::new();
        let mut seen = BTreeSet::new();
        for stay in self.stations.chunk_by(|a, b| a.file == b.file) {
            let again = if seen.insert(&stay[0].file) { "" } else { " (return)" };
            let functions: Vec<&str> = stay.iter().map(|station| station.function.as_str()).collect();
            text += &format!("{}{again}: {}\n", stay[0].file, functions.join(", "));
        }
        text
    }

    fn fault(&self, root: &Path, at: usize) -> Result<(), String> {
        let station = &self.stations[at];
        let function = station.find(root)?;
        match &station.link {
            Link::Reads(name) if function.names.contains(name) => Ok(()),
            Link::Reads(name) => Err(format!("{} does not read `{name}`", station.name())),
            Link::Named(name) => {
                let caller = self.stations[..at].iter().rev().find(|caller| caller.depth < station.depth);
                let Some(caller) = caller else { return Ok(()) };
                let calls = caller.find(root)?.names.contains(name);
                let fault = || format!("{} does not name `{name}`, which leads to {}", caller.name(), station.name());
                calls.then_some(()).ok_or_else(fault)
            }
        }
    }
}

impl Station {
    fn parse(line: &str) -> Self {
        let words: Vec<&str> = line.split_whitespace().collect();
        let segments: Vec<&str> = words[0].split("::").collect();
        let (file, owner, function) = match segments[..] {
            [file, function] => (file, None, function),
            [file, owner, function] => (file, Some(owner.to_owned()), function),
            _ => panic!("`{line}` is no FILE::FUNCTION and no FILE::TYPE::FUNCTION"),
        };
        let link = match words[1..] {
            [] => Link::Named(function.to_owned()),
            ["via", name] => Link::Named(name.to_owned()),
            ["reads", name] => Link::Reads(name.to_owned()),
            _ => panic!("`{line}`: a station is followed by `via NAME`, `reads NAME` or nothing"),
        };
        let depth = line.len() - line.trim_start().len();
        Self { depth, file: file.to_owned(), owner, function: function.to_owned(), link }
    }

    fn name(&self) -> String {
        let owner = self.owner.iter().map(|owner| format!("{owner}::")).collect::<String>();
        format!("{}::{owner}{}", self.file, self.function)
    }

    fn find(&self, root: &Path) -> Result<Function, String> {
        let path = root.join(&self.file);
        if !path.is_file() {
            return Err(format!("{} does not exist", self.file));
        }
        let text = read(&path);
        let is_wgsl = self.file.ends_with(".wgsl");
        let found = if is_wgsl { wgsl_function(&text, &self.function) } else { self.find_in(&text) };
        found.ok_or_else(|| format!("{} does not exist", self.name()))
    }

    /// The function; where several `impl`s of a type have one of this name, all of them as one.
    fn find_in(&self, text: &str) -> Option<Function> {
        let is_this = |f: &Function| f.name == self.function && (self.owner.is_none() || f.owner == self.owner);
        let found = in_text(text, Path::new(&self.file)).into_iter().filter(is_this);
        found.reduce(|mut one, other| {
            one.names.extend(other.names);
            one
        })
    }
}

/// A function of WGSL with the names from its declaration to the next function.
fn wgsl_function(text: &str, name: &str) -> Option<Function> {
    let line = text.lines().position(|line| line.contains(&format!("fn {name}(")))?;
    let rest = text.lines().skip(line);
    let body: Vec<&str> =
        rest.enumerate().take_while(|(i, text)| *i == 0 || !text.starts_with("fn ")).map(|l| l.1).collect();
    let is_part = |character: char| character.is_alphanumeric() || character == '_';
    let names = body.iter().flat_map(|line| line.split(|c| !is_part(c))).map(str::to_owned).collect();
    Some(Function { owner: None, name: name.to_owned(), line: line + 1, lines: body.len(), names })
}

#[cfg(test)]
mod tests {
    use super::*;

    const TEXT: &str = "# A flow.\nlimit files 2\na.rs::main\n  b.rs::B::read\n  a.rs::check\n    c.rs::run via Kind\n";

    /// A folder with files; removed when it is dropped.
    struct Folder(std::path::PathBuf);

    impl Folder {
        fn new(test: &str, files: &[(&str, &str)]) -> Self {
            let folder = std::env::temp_dir().join(format!("afterimage-tidy-{}-{test}", std::process::id()));
            std::fs::create_dir_all(&folder).expect("a temporary folder");
            for (name, text) in files {
                std::fs::write(folder.join(name), text).expect("a temporary file");
            }
            Self(folder)
        }
    }

    impl Drop for Folder {
        fn drop(&mut self) {
            std::fs::remove_dir_all(&self.0).expect("the folder can be removed");
        }
    }

    #[test]
    fn returns_to_an_earlier_file_are_counted() {
        let flow = Flow::parse(TEXT);
        assert_eq!(flow.figures(), Figures { stations: 4, files: 3, returns: 1 });
    }

    #[test]
    fn stations_and_limits_are_verified() {
        let a = ("a.rs", "fn main() { b.read(); check(); } fn check() { Kind::go(); }");
        let good = Folder::new("good", &[a, ("b.rs", "impl B { fn read() {} }"), ("c.rs", "fn run() {}")]);
        let flow = Flow::parse(TEXT);
        assert_eq!(flow.violations(&good.0), ["3 files, at most 2 are allowed"]);
        let bad = Folder::new("bad", &[("a.rs", "fn main() { b.read(); } fn check() {}"), ("b.rs", "fn read() {}")]);
        let expected = [
            "b.rs::B::read does not exist",
            "a.rs::main does not name `check`, which leads to a.rs::check",
            "c.rs does not exist",
            "3 files, at most 2 are allowed",
        ];
        assert_eq!(flow.violations(&bad.0), expected);
    }

    #[test]
    fn data_is_verified_where_it_is_read() {
        let flow = Flow::parse("a.rs::a\nb.wgsl::b reads strength\n");
        let text = "fn b(x: f32) -> f32 {\n    return x * params.strength;\n}\nfn c() {}\n";
        let good = Folder::new("data", &[("a.rs", "fn a() {}"), ("b.wgsl", text)]);
        assert_eq!(flow.violations(&good.0), Vec::<String>::new());
        let bad = Folder::new("no-data", &[("a.rs", "fn a() {}"), ("b.wgsl", "fn b() {}\nfn strength() {}\n")]);
        assert_eq!(flow.violations(&bad.0), ["b.wgsl::b does not read `strength`"]);
    }
}
