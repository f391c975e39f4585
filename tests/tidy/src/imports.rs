//! Import edges: which module uses an item that another module defines.
//!
//! An edge comes from a private `use`, and from each path in the code. Re-exports are followed to the definition. A
//! re-export alone and a declaration `mod x;` are no edges.

use crate::modules::{Module, Tree};
use crate::scopes::Target;

/// A use of an item of another module.
#[derive(Clone, Debug, PartialEq, Eq, PartialOrd, Ord)]
pub struct Edge {
    /// The module that uses it.
    pub from: usize,
    /// The module that defines it.
    pub to: usize,
    /// The item.
    pub name: String,
}

/// All edges between different modules, sorted, each once.
pub fn edges(tree: &Tree) -> Vec<Edge> {
    let mut edges: Vec<Edge> = (0..tree.modules.len()).flat_map(|module| of_module(tree, module)).collect();
    edges.retain(|edge| edge.from != edge.to);
    edges.sort();
    edges.dedup();
    edges
}

fn of_module(tree: &Tree, from: usize) -> Vec<Edge> {
    let Module { imports, paths, .. } = &tree.modules[from];
    let private = imports.iter().filter(|import| !import.public && import.name.is_some());
    let imported = private.flat_map(|import| of_path(tree, from, &import.path, true));
    imported.chain(paths.iter().flat_map(|path| of_path(tree, from, path, false))).collect()
}

fn of_path(tree: &Tree, from: usize, path: &[String], is_import: bool) -> Vec<Edge> {
    let edge = |target| match target {
        Target::Item(to) => Some(Edge { from, to, name: item_name(tree, to, path) }),
        // The items that are used through the module are edges of their own.
        Target::Module(to) => is_import.then(|| Edge { from, to, name: path.join("::") }),
    };
    tree.resolve(from, path).into_iter().filter_map(edge).collect()
}

/// The last segment of the path that is an item of that module: behind it may stand a variant or a function of a type.
fn item_name(tree: &Tree, module: usize, path: &[String]) -> String {
    let is_item = |segment: &&String| tree.modules[module].items.contains_key(*segment);
    path.iter().rev().find(is_item).or(path.last()).cloned().unwrap_or_default()
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::cycles::tests::tree;

    fn found(files: &[(&str, &str)]) -> Vec<String> {
        let tree = tree(files);
        let name =
            |module: usize| tree.modules[module].file.file_name().expect("a name").to_string_lossy().into_owned();
        edges(&tree).into_iter().map(|edge| format!("{} {} {}", name(edge.from), name(edge.to), edge.name)).collect()
    }

    #[test]
    fn a_re_export_is_followed_to_the_definition() {
        let files = [
            ("lib.rs", "mod a; mod b;"),
            ("a/mod.rs", "mod inner; pub use inner::Thing;"),
            ("a/inner.rs", "pub struct Thing;"),
            ("b.rs", "use crate::a::Thing; fn f() -> Thing { crate::a::Thing }"),
        ];
        assert_eq!(found(&files), ["b.rs inner.rs Thing"]);
    }

    #[test]
    fn a_re_export_that_the_module_uses_itself_is_an_edge() {
        let files = [("lib.rs", "mod a; pub use a::Thing; pub struct Other(Thing);"), ("a.rs", "pub struct Thing;")];
        assert_eq!(found(&files), ["lib.rs a.rs Thing"]);
    }

    #[test]
    fn paths_in_code_globs_and_macros_are_edges() {
        let files = [
            ("lib.rs", "mod a; mod b; mod c;"),
            ("a.rs", "pub enum Kind { One } pub fn kind() {}"),
            ("b.rs", "use super::a::*; fn f() { kind(); }"),
            ("c.rs", "fn f() { m!(super::a::Kind::One) }"),
        ];
        assert_eq!(found(&files), ["b.rs a.rs kind", "c.rs a.rs Kind"]);
    }

    #[test]
    fn a_function_and_a_module_of_one_name_are_both_found() {
        let files = [("lib.rs", "mod a; use a::a; fn f() { a(); }"), ("a.rs", "pub fn a() {}")];
        assert_eq!(found(&files), ["lib.rs a.rs a"]);
    }

    #[test]
    fn a_macro_for_other_crates_belongs_to_its_file() {
        let files = [
            ("lib.rs", "mod a; mod b;"),
            ("a.rs", "#[macro_export] macro_rules! params { () => { $crate::b::B } }"),
            ("b.rs", "pub struct B; crate::params! { }"),
        ];
        assert_eq!(found(&files), ["a.rs b.rs B", "b.rs a.rs params"]);
    }
}
