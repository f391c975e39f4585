//! The table of kinds that a program knows.

use std::collections::BTreeMap;

use super::block::HostBlock;
use super::kind::NodeKind;

/// All node kinds of a program, by name.
#[derive(Clone, Debug, Default)]
pub struct Registry {
    kinds: BTreeMap<String, NodeKind>,
}

/// Two kinds have the same name.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct DuplicateKind(pub String);

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
            if kinds.insert(kind.name().to_owned(), kind.clone()).is_some() {
                return Err(DuplicateKind(kind.name().to_owned()));
            }
        }
        Ok(Self { kinds })
    }

    /// The kind of that name.
    pub fn get(&self, name: &str) -> Option<&NodeKind> {
        self.kinds.get(name)
    }

    /// All kinds, by name.
    pub fn iter(&self) -> impl Iterator<Item = &NodeKind> + '_ {
        self.kinds.values()
    }

    /// The host block of that name, which a port of some kind declares.
    pub fn block(&self, name: &str) -> Option<&'static HostBlock> {
        self.blocks().find(|block| block.name == name)
    }

    /// The host blocks that ports declare; one that several ports declare comes as often.
    pub fn blocks(&self) -> impl Iterator<Item = &'static HostBlock> + '_ {
        self.iter().flat_map(|kind| kind.inputs()).filter_map(|port| port.block)
    }

    /// All names, sorted.
    pub fn names(&self) -> impl Iterator<Item = &str> + '_ {
        self.kinds.keys().map(String::as_str)
    }
}
