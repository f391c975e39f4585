//! The table of kinds that a program knows.

use std::collections::BTreeMap;

use super::kind::NodeKind;

/// All node kinds of a program, by name.
#[derive(Clone, Debug, Default)]
pub struct Registry {
    kinds: BTreeMap<&'static str, NodeKind>,
}

/// Two kinds have the same name.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct DuplicateKind(pub &'static str);

impl std::fmt::Display for DuplicateKind {
    fn fmt(&self, f: &mut std::fmt::Formatter<'_>) -> std::fmt::Result {
        write!(f, "two node kinds are called `{}`", self.0)
    }
}

impl std::error::Error for DuplicateKind {}

impl Registry {
    /// All kinds of several tables; an error if two of them share a name.
    pub fn new(tables: &[&[NodeKind]]) -> Result<Self, DuplicateKind> {
        let mut kinds = BTreeMap::new();
        for kind in tables.iter().copied().flatten() {
            if kinds.insert(kind.name(), *kind).is_some() {
                return Err(DuplicateKind(kind.name()));
            }
        }
        Ok(Self { kinds })
    }

    /// The kind of that name.
    pub fn get(&self, name: &str) -> Option<NodeKind> {
        self.kinds.get(name).copied()
    }

    /// All kinds, by name.
    pub fn iter(&self) -> impl Iterator<Item = NodeKind> + '_ {
        self.kinds.values().copied()
    }

    /// All names, sorted.
    pub fn names(&self) -> impl Iterator<Item = &'static str> + '_ {
        self.kinds.keys().copied()
    }
}
