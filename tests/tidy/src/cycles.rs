//! Cycles of import edges: between the files of a crate, and between the modules in each module.

use std::collections::{BTreeMap, BTreeSet, VecDeque};

use crate::imports::{Edge, edges};
use crate::modules::Tree;

/// A cycle: each step is a place, the place that it uses, and the items that it uses there.
pub type Cycle = Vec<(String, String, Vec<String>)>;

/// For each place the places that it uses, with the items.
type Graph = BTreeMap<String, BTreeMap<String, BTreeSet<String>>>;

/// For each file or module on a cycle the shortest cycle through it; cycles through the same places are listed once.
pub fn cycles(tree: &Tree) -> Vec<Cycle> {
    let edges = edges(tree);
    let levels = (0..tree.modules.len()).filter(|module| !tree.modules[*module].children.is_empty());
    let module_graphs = levels.map(|level| graph(&edges, |module| tree.part(level, module)));
    let file_graph = graph(&edges, |module| Some(tree.file_name(module)));
    let mut found: Vec<Cycle> = Vec::new();
    for graph in std::iter::once(file_graph).chain(module_graphs) {
        found.extend(graph.keys().filter_map(|start| shortest(&graph, start)));
    }
    let mut seen = BTreeSet::new();
    found.retain(|cycle| seen.insert(cycle.iter().map(|(place, ..)| place.clone()).collect::<BTreeSet<_>>()));
    found
}

/// A cycle as lines of text.
pub fn describe(cycle: &Cycle) -> String {
    let steps = cycle.iter().map(|(from, to, names)| format!("  {from} uses {} of {to}", names.join(", ")));
    steps.collect::<Vec<_>>().join("\n")
}

impl Tree {
    fn file_name(&self, module: usize) -> String {
        let root = self.modules[0].file.parent().expect("a file lies in a folder");
        let file = &self.modules[module].file;
        file.strip_prefix(root).unwrap_or(file).display().to_string()
    }

    /// The part of the module `level` that `module` belongs to: a child with all below it, or the file of the module
    /// itself. `None` if it lies outside.
    fn part(&self, level: usize, module: usize) -> Option<String> {
        if module == level {
            return Some(self.file_name(level));
        }
        let mut child = module;
        while self.modules[child].parent? != level {
            child = self.modules[child].parent?;
        }
        let file = self.file_name(child);
        match file.strip_suffix("/mod.rs") {
            _ if self.modules[child].children.is_empty() => Some(file),
            Some(folder) => Some(format!("{folder}/")),
            None => Some(format!("{}/", file.trim_end_matches(".rs"))),
        }
    }
}

fn graph(edges: &[Edge], place: impl Fn(usize) -> Option<String>) -> Graph {
    let mut graph = Graph::new();
    for Edge { from, to, name } in edges {
        let (Some(from), Some(to)) = (place(*from), place(*to)) else { continue };
        if from != to {
            graph.entry(from).or_default().entry(to).or_default().insert(name.clone());
        }
    }
    graph
}

/// The shortest cycle through a place, by a search in breadth.
fn shortest(graph: &Graph, start: &str) -> Option<Cycle> {
    let mut before: BTreeMap<&str, &str> = BTreeMap::new();
    let mut queue = VecDeque::from([start]);
    while let Some(place) = queue.pop_front() {
        for next in graph.get(place).into_iter().flat_map(BTreeMap::keys) {
            if next == start {
                return Some(steps(graph, &before, place, start));
            }
            if !before.contains_key(next.as_str()) {
                before.insert(next, place);
                queue.push_back(next);
            }
        }
    }
    None
}

/// The steps from `start` to `last` and back to `start`.
fn steps(graph: &Graph, before: &BTreeMap<&str, &str>, last: &str, start: &str) -> Cycle {
    let mut cycle = Cycle::new();
    let (mut from, mut to) = (last, start);
    loop {
        cycle.push((from.to_owned(), to.to_owned(), graph[from][to].iter().cloned().collect()));
        if from == start {
            break;
        }
        (from, to) = (before[from], from);
    }
    cycle.reverse();
    cycle
}

#[cfg(test)]
pub(crate) mod tests {
    use super::*;

    /// The modules of a crate with these files; they exist while they are read.
    pub(crate) fn tree(files: &[(&str, &str)]) -> Tree {
        let name = std::thread::current().name().expect("a test has a name").replace("::", "-");
        let root = std::env::temp_dir().join(format!("afterimage-tidy-{}-{name}", std::process::id()));
        for (path, text) in files {
            let path = root.join(path);
            std::fs::create_dir_all(path.parent().expect("a folder")).expect("a temporary folder");
            std::fs::write(path, text).expect("a temporary file");
        }
        let tree = Tree::of(&root.join(files[0].0));
        std::fs::remove_dir_all(root).expect("the folder can be removed");
        tree
    }

    fn found(files: &[(&str, &str)]) -> Vec<String> {
        cycles(&tree(files)).iter().map(describe).collect()
    }

    #[test]
    fn a_parent_and_a_child_that_use_each_other_are_found() {
        let files = [
            ("lib.rs", "mod a;"),
            ("a/mod.rs", "mod b; use b::make; pub struct Thing; fn f() { make(); }"),
            ("a/b.rs", "pub fn make() -> super::Thing { super::Thing }"),
        ];
        assert_eq!(found(&files), ["  a/b.rs uses Thing of a/mod.rs\n  a/mod.rs uses make of a/b.rs"]);
    }

    #[test]
    fn a_declaration_and_a_re_export_are_no_cycle() {
        let files = [
            ("lib.rs", "mod a;"),
            ("a/mod.rs", "mod b; mod c; pub use b::make; pub use c::Thing;"),
            ("a/b.rs", "pub fn make() -> super::Thing { super::Thing }"),
            ("a/c.rs", "pub struct Thing;"),
        ];
        assert_eq!(found(&files), Vec::<String>::new());
    }

    #[test]
    fn folders_that_use_each_other_are_found_without_a_cycle_of_files() {
        let files = [
            ("lib.rs", "mod a; mod b;"),
            ("a/mod.rs", "pub mod low; pub mod high;"),
            ("a/low.rs", "pub struct Low;"),
            ("a/high.rs", "use crate::b::middle::Middle; pub struct High(Middle);"),
            ("b/mod.rs", "pub mod middle;"),
            ("b/middle.rs", "use crate::a::low::Low; pub struct Middle(Low);"),
        ];
        assert_eq!(found(&files), ["  a/ uses Middle of b/\n  b/ uses Low of a/"]);
    }

    #[test]
    fn imports_of_tests_do_not_count() {
        let files = [
            ("lib.rs", "mod a; mod b;"),
            ("a.rs", "pub struct A; #[cfg(test)] mod tests { use crate::b::B; }"),
            ("b.rs", "use crate::a::A; pub struct B(A);"),
        ];
        assert_eq!(found(&files), Vec::<String>::new());
    }
}
