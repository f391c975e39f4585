//! The files that a pipeline names, whether a tier uses them or not.

use std::collections::BTreeSet;

use super::Checker;
use super::files::{Named, join};
use super::limits::MAX_TEXT;
use crate::document::{Document, Item, Tier, Tree};

impl Checker<'_> {
    /// The paths of all files that the document names, and the documents among them, joined to their folders: what it
    /// extends, the files of all of its tiers, and every text that may be the name of one. Documents are read, up to
    /// the limit for the text of a pipeline.
    pub fn named_files(&self) -> BTreeSet<String> {
        let mut walk = Walk::default();
        walk.document(self.document);
        let mut room = MAX_TEXT;
        while let Some(path) = walk.documents.pop() {
            room = room.saturating_sub(self.files.bytes(&path).map_or(0, |bytes| bytes.len()));
            if room == 0 {
                break;
            }
            if let Named::Document(document) = self.files.document(&path) {
                walk.document(&document);
            }
        }
        walk.paths
    }
}

#[derive(Default)]
struct Walk {
    paths: BTreeSet<String>,
    /// Those that may be documents, and were not read yet.
    documents: Vec<String>,
}

impl Walk {
    fn document(&mut self, document: &Document) {
        if let Some(base) = &document.extends {
            self.document_name(&base.location.file, &base.value);
        }
        for value in document.nodes.iter().flat_map(|node| &node.fields.entries).map(|(_, value)| value) {
            self.item(value);
        }
        document.set.iter().for_each(|change| self.item(&change.value));
        for (_, tier) in &document.tiers {
            match tier {
                Tier::File(file) => self.document_name(&file.location.file, &file.value),
                Tier::Settings(changes) => changes.iter().for_each(|change| self.item(&change.value)),
            }
        }
    }

    fn item(&mut self, item: &Item) {
        match &item.value {
            // The file of a nested pipeline is a document, too.
            Tree::Text(text) if text.ends_with(".ron") => self.document_name(&item.location.file, text),
            Tree::Text(text) => drop(self.paths.insert(join(&item.location.file, text))),
            Tree::List(items) | Tree::Tuple(_, items) => items.iter().for_each(|item| self.item(item)),
            Tree::Map(entries) => entries.entries.iter().for_each(|(_, value)| self.item(value)),
            Tree::Struct(_, fields) => fields.entries.iter().for_each(|(_, value)| self.item(value)),
            _ => {}
        }
    }

    fn document_name(&mut self, from: &str, path: &str) {
        let path = join(from, path);
        if self.paths.insert(path.clone()) {
            self.documents.push(path);
        }
    }
}

#[cfg(test)]
mod tests {
    use std::sync::Arc;

    use super::*;
    use crate::check::Loader;
    use crate::document::parse;
    use crate::node::Registry;

    struct Texts(&'static [(&'static str, &'static str)]);

    impl Loader for Texts {
        fn load(&self, path: &str) -> Result<Arc<[u8]>, String> {
            let found = self.0.iter().find(|(known, _)| *known == path);
            found.map(|(_, text)| text.as_bytes().into()).ok_or_else(|| "there is none".to_owned())
        }
    }

    #[test]
    fn files_of_tiers_that_nobody_chose_are_named() {
        let text =
            r#"Pipeline(extends: "base.ron", tiers: { "low": "night/low.ron", "mid": { "a.file": "mid.cube" } })"#;
        let texts = Texts(&[
            ("looks/base.ron", r#"Pipeline(nodes: { "a": ColorLut(source: "scene", file: "../a.cube") })"#),
            ("looks/night/low.ron", r#"Pipeline(extends: "deep.ron", set: { "a.file": "low.cube" })"#),
            ("looks/night/deep.ron", r#"Pipeline(extends: "low.ron")"#),
        ]);
        let document = parse("looks/p.ron", text).expect("it is a pipeline");
        let registry = Registry::new(&[]).expect("it is empty");
        let named = Checker::new(&document, &registry, &texts).named_files();
        let wanted = [
            "a.cube",
            "looks/base.ron",
            "looks/mid.cube",
            "looks/night/deep.ron",
            "looks/night/low.cube",
            "looks/night/low.ron",
            "looks/scene",
        ];
        assert_eq!(named.iter().map(String::as_str).collect::<Vec<_>>(), wanted);
    }
}
