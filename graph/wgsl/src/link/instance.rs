//! A file's place in a linked module.

use std::ops::Range;

use rustc_hash::FxHashMap;

use crate::library::{Library, SourceFile};
use crate::module::{Module, Symbol};

/// A file in a module that is being linked. The same file may be in it several times, each time under names of its own.
#[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord, Hash)]
pub struct Instance(pub(super) u32);

impl Instance {
    /// The code that the caller of the linker writes.
    pub const GENERATED: Self = Self(u32::MAX);

    pub(super) fn index(self) -> usize {
        self.0 as usize
    }
}

/// Meaning of a name in a file.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(super) enum Target {
    /// Something of the language, or nothing.
    Language,
    /// A declaration of an instance, by its name there.
    Declared(Instance, Symbol),
    /// The replacement at that index.
    Replaced(usize),
}

/// Text of the generated code that a name is replaced by.
#[derive(Clone, Debug)]
pub(super) struct Replacement {
    pub(super) name: Symbol,
    /// A name of the generated code, or of the language.
    pub(super) by: String,
    pub(super) members: String,
}

pub(super) struct Part<'a> {
    pub(super) file: &'a SourceFile,
    pub(super) module: &'a Module,
    pub(super) library: Option<&'a Library>,
    /// True if the file is one of the framework's library.
    pub(super) is_framework: bool,
    /// Boolean constants that are set to true.
    pub(super) defines: Vec<String>,
    /// Imported items by their names in the file.
    pub(super) imported: FxHashMap<Symbol, (Instance, Symbol)>,
    /// The files whose names all others know.
    pub(super) prelude: Vec<Instance>,
    /// Other text for some bytes of the file.
    pub(super) edits: Vec<(Range<usize>, String)>,
    /// The brackets where loops begin whose steps are counted: bytes of the file.
    pub(super) loops: Vec<Range<usize>>,
    pub(super) replacements: Vec<Replacement>,
    pub(super) targets: Vec<Option<Target>>,
    /// True if each declaration is in the module.
    pub(super) reached: Vec<bool>,
    /// The names in the module of what is declared, where they differ from those in the file.
    pub(super) renamed: Vec<Option<String>>,
}

impl<'a> Part<'a> {
    pub(super) fn new(
        file: &'a SourceFile,
        module: &'a Module,
        library: Option<&'a Library>,
        defines: Vec<String>,
    ) -> Self {
        Self {
            file,
            module,
            library,
            is_framework: false,
            defines,
            imported: FxHashMap::default(),
            prelude: Vec::new(),
            edits: Vec::new(),
            loops: Vec::new(),
            replacements: Vec::new(),
            targets: vec![None; module.symbol_count()],
            reached: vec![false; module.declarations.len()],
            renamed: vec![None; module.symbol_count()],
        }
    }

    /// The name in the module of what the file calls `symbol`.
    pub(super) fn final_name(&self, symbol: Symbol) -> &str {
        self.renamed[symbol.index()].as_deref().unwrap_or_else(|| self.module.name(symbol))
    }

    /// Returns whether it is of that file and library, with those defines.
    pub(super) fn is_of(&self, file: &SourceFile, library: Option<&Library>, defines: &[String]) -> bool {
        let same_library = match (self.library, library) {
            (Some(own), Some(other)) => std::ptr::eq(own, other),
            (own, other) => own.is_none() && other.is_none(),
        };
        self.file.is_same(file) && same_library && self.defines == defines
    }
}
