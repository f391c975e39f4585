//! Names and paths, resolved to the module that defines the item.

use std::collections::BTreeSet;

use crate::modules::Tree;

/// What a path names.
#[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord)]
pub(crate) enum Target {
    Module(usize),
    /// An item of this module.
    Item(usize),
}

/// The names whose imports are being followed: an import that leads back to itself ends there.
type Followed = BTreeSet<(usize, String)>;

impl Tree {
    /// What a path in this module names: items if there are any, else modules. Nothing for names of other crates.
    pub(crate) fn resolve(&self, from: usize, path: &[String]) -> Vec<Target> {
        let mut targets = self.walk(from, path, &mut Followed::new());
        if targets.iter().any(|target| matches!(target, Target::Item(_))) {
            targets.retain(|target| matches!(target, Target::Item(_)));
        }
        targets.sort();
        targets.dedup();
        targets
    }

    fn walk(&self, from: usize, path: &[String], followed: &mut Followed) -> Vec<Target> {
        let Some((first, rest)) = path.split_first() else { return Vec::new() };
        let begin = match first.as_str() {
            "crate" => vec![Target::Module(0)],
            "self" => vec![Target::Module(from)],
            "super" => self.modules[from].parent.map(Target::Module).into_iter().collect(),
            name => self.lookup(from, name, followed),
        };
        rest.iter().fold(begin, |targets, segment| self.step(&targets, segment, followed))
    }

    /// Follows one segment. Behind an item stands a part of it, such as a variant.
    fn step(&self, targets: &[Target], segment: &str, followed: &mut Followed) -> Vec<Target> {
        let mut found = Vec::new();
        for target in targets {
            match *target {
                Target::Module(module) if segment == "super" => {
                    found.extend(self.modules[module].parent.map(Target::Module));
                }
                Target::Module(module) => found.extend(self.lookup(module, segment, followed)),
                Target::Item(_) => {}
            }
        }
        if found.is_empty() {
            found.extend(targets.iter().filter(|target| matches!(target, Target::Item(_))));
        }
        found
    }

    /// What a name means in a module: its items and children, what it imports by name, else what it imports by `*`.
    fn lookup(&self, module: usize, name: &str, followed: &mut Followed) -> Vec<Target> {
        let scope = &self.modules[module];
        let mut found: Vec<Target> = scope.items.get(name).copied().map(Target::Item).into_iter().collect();
        found.extend(scope.children.get(name).copied().map(Target::Module));
        if !followed.insert((module, name.to_owned())) {
            return found;
        }
        for import in scope.imports.iter().filter(|import| import.name.as_deref() == Some(name)) {
            found.extend(self.walk(module, &import.path, followed));
        }
        if found.is_empty() {
            found = self.lookup_in_globs(module, name, followed);
        }
        found
    }

    fn lookup_in_globs(&self, module: usize, name: &str, followed: &mut Followed) -> Vec<Target> {
        let globs = self.modules[module].imports.iter().filter(|import| import.name.is_none());
        let mut found = Vec::new();
        for import in globs {
            for target in self.walk(module, &import.path, followed) {
                if let Target::Module(source) = target {
                    found.extend(self.lookup(source, name, followed));
                }
            }
        }
        found
    }
}
