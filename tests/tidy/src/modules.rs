//! The modules of a crate, read from its files.

use std::collections::BTreeMap;
use std::path::{Path, PathBuf};

use proc_macro2::{Delimiter, TokenTree};

use crate::paths::{Found, Import};
use crate::tokens::{group, is_punct, is_word, product_tokens, word};
use crate::workspace::read;

/// The modules of a crate; the first is the root. Modules of tests are absent.
#[derive(Debug, Default)]
pub struct Tree {
    /// All modules; a parent comes before its children.
    pub modules: Vec<Module>,
}

/// A module.
#[derive(Debug, Default)]
pub struct Module {
    /// The file that it is written in.
    pub file: PathBuf,
    /// The module around it.
    pub parent: Option<usize>,
    /// The modules in it.
    pub children: BTreeMap<String, usize>,
    /// The items defined in it, with the module of the definition: a macro for other crates belongs to the root too.
    pub(crate) items: BTreeMap<String, usize>,
    pub(crate) imports: Vec<Import>,
    pub(crate) paths: Vec<Vec<String>>,
}

impl Tree {
    /// The modules below the root file of a crate.
    ///
    /// # Panics
    ///
    /// Panics if a file is missing or is not Rust.
    pub fn of(root: &Path) -> Self {
        let mut tree = Self::default();
        let folder = root.parent().expect("a file lies in a folder");
        tree.file(root, folder, None);
        tree
    }

    /// The files of the crate, each once.
    pub fn files(&self) -> Vec<&Path> {
        let mut files: Vec<&Path> = self.modules.iter().map(|module| module.file.as_path()).collect();
        files.sort();
        files.dedup();
        files
    }

    fn file(&mut self, path: &Path, folder: &Path, parent: Option<usize>) -> usize {
        let tokens = product_tokens(&read(path), path);
        self.module(tokens, path, folder, parent)
    }

    /// Adds a module; its children have their files in `folder`.
    fn module(&mut self, tokens: Vec<TokenTree>, path: &Path, folder: &Path, parent: Option<usize>) -> usize {
        let number = self.modules.len();
        self.modules.push(Module { file: path.to_owned(), parent, ..Module::default() });
        let mut own = Vec::with_capacity(tokens.len());
        let mut at = 0;
        while at < tokens.len() {
            match self.child(&tokens[at..], path, folder, number) {
                Some(length) => at += length,
                None => {
                    own.push(tokens[at].clone());
                    at += 1;
                }
            }
        }
        self.define(number, &own);
        let mut found = Found::default();
        found.scan(&own);
        (self.modules[number].imports, self.modules[number].paths) = (found.imports, found.paths);
        number
    }

    /// Adds the module that these tokens declare, if they do; returns how many tokens the declaration has.
    fn child(&mut self, tokens: &[TokenTree], path: &Path, folder: &Path, parent: usize) -> Option<usize> {
        let name = is_word(tokens.first(), "mod").then(|| word(tokens.get(1))).flatten()?;
        let inner = folder.join(&name);
        let child = if let Some(body) = group(tokens.get(2), Delimiter::Brace) {
            self.module(body.stream().into_iter().collect(), path, &inner, Some(parent))
        } else if is_punct(tokens.get(2), ';') {
            let file =
                [folder.join(format!("{name}.rs")), inner.join("mod.rs")].into_iter().find(|file| file.is_file());
            let file = file.unwrap_or_else(|| panic!("module `{name}` of {} has no file", path.display()));
            self.file(&file, &inner, Some(parent))
        } else {
            return None;
        };
        self.modules[parent].children.insert(name, child);
        Some(3)
    }

    /// Notes the items that these tokens define, those in the arguments of a macro included.
    fn define(&mut self, module: usize, tokens: &[TokenTree]) {
        let mut exported = false;
        for (at, token) in tokens.iter().enumerate() {
            let next = word(tokens.get(at + 1));
            match word(Some(token)).as_deref() {
                Some("fn" | "struct" | "enum" | "union" | "trait" | "type" | "const" | "static") => {
                    next.into_iter().for_each(|name| self.item(module, module, name));
                }
                Some("macro_rules") => {
                    let name = word(tokens.get(at + 2)).expect("a macro has a name");
                    self.item(module, module, name.clone());
                    if std::mem::take(&mut exported) {
                        self.item(0, module, name);
                    }
                }
                _ => {}
            }
            if let Some(body) = macro_arguments(tokens, at) {
                self.define(module, &body);
            }
            exported |=
                group(Some(token), Delimiter::Bracket).is_some_and(|g| g.stream().to_string() == "macro_export");
        }
    }

    fn item(&mut self, owner: usize, definition: usize, name: String) {
        self.modules[owner].items.insert(name, definition);
    }
}

/// The tokens in the braces of the macro call that ends here, unless the macro is defined here.
fn macro_arguments(tokens: &[TokenTree], at: usize) -> Option<Vec<TokenTree>> {
    let body = group(tokens.get(at), Delimiter::Brace)?;
    let is_call = at >= 2 && is_punct(tokens.get(at - 1), '!') && !is_word(tokens.get(at - 2), "macro_rules");
    is_call.then(|| body.stream().into_iter().collect())
}
