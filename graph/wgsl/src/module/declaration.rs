//! Declarations of a file.

use std::ops::Range;

use rustc_hash::FxHashMap;

use super::import::{Imported, names};
use super::kind::DeclarationKind;
use super::scope::names_of;
use super::syntax::{Item, items};
use crate::error::{ShaderError, position};
use crate::limits::{IMPORTS, check_size, check_text};
use crate::token::{OpenComment, Token, tokens};

/// A distinct name of a file: an index into its names.
#[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord, Hash)]
pub(crate) struct Symbol(pub(crate) u32);

impl Symbol {
    pub(crate) fn index(self) -> usize {
        self.0 as usize
    }
}

/// A place where a declaration uses a name of the file, of an import or of the language.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(crate) struct Use {
    pub(crate) symbol: Symbol,
    pub(crate) token: u32,
}

/// A declaration at the top level of a file.
#[derive(Clone, Debug)]
pub(crate) struct Declaration {
    pub(crate) kind: DeclarationKind,
    pub(crate) name: Option<Symbol>,
    pub(crate) tokens: Range<u32>,
    /// The names that it uses, its own among them, in the order of the text. Local names and members are not among
    /// them.
    pub(crate) uses: Vec<Use>,
    /// Each name that it uses, once.
    pub(crate) used: Vec<Symbol>,
    /// Each name of a parameter or local variable, once.
    pub(crate) locals: Vec<Symbol>,
}

/// An item or a file that a file imports, or a path that stands in its code.
#[derive(Clone, Debug)]
pub(crate) struct Import {
    /// The bytes of each name of its path.
    path: Vec<Range<u32>>,
    /// Its name in the file; a path in the code is its own name.
    pub(crate) name: Symbol,
}

impl Import {
    /// The names of its path.
    pub(crate) fn path<'t>(&self, text: &'t str) -> Vec<&'t str> {
        self.path.iter().map(|name| &text[name.start as usize..name.end as usize]).collect()
    }

    /// The byte where a name of its path starts, counted from the last.
    pub(crate) fn at(&self, from_last: usize) -> usize {
        self.path[self.path.len().saturating_sub(1 + from_last)].start as usize
    }
}

#[derive(Clone, Debug, Default)]
pub(crate) struct Module {
    pub(crate) tokens: Vec<Token>,
    pub(crate) declarations: Vec<Declaration>,
    pub(crate) imports: Vec<Import>,
    /// `enable`, `requires` and `diagnostic` directives: the bytes of each.
    pub(crate) directives: Vec<Range<usize>>,
    names: Vec<Box<str>>,
    symbols: FxHashMap<Box<str>, Symbol>,
    /// The import of each name that has one.
    imported: FxHashMap<Symbol, u32>,
    /// The first declaration of each name.
    declared: Vec<Option<u32>>,
}

fn tokens_of(file: &str, text: &str) -> Result<Vec<Token>, ShaderError> {
    let error = |OpenComment(at)| ShaderError::new(file, position(text, at), "this comment has no end `*/`");
    tokens(text).map_err(error)
}

/// The paths that a file imports, for hosts that read files by name; none if the file has an error, which is reported
/// once it is a [`Shader`](crate::Shader).
pub fn imports(text: &str) -> Vec<String> {
    let module = Module::parse_untrusted("", text).unwrap_or_default();
    module.imports.iter().map(|import| import.path(text).join("::")).collect()
}

fn distinct(uses: &[Use]) -> Vec<Symbol> {
    let mut symbols: Vec<Symbol> = uses.iter().map(|used| used.symbol).collect();
    symbols.sort_unstable();
    symbols.dedup();
    symbols
}

impl Module {
    /// Parses a file.
    ///
    /// # Errors
    /// A comment or a bracket without an end, an import that is no statement of WESL or does not come first, and a name
    /// that means two things. What else is wrong, the validator finds.
    pub(crate) fn parse(file: &str, text: &str) -> Result<Self, ShaderError> {
        Self::of_tokens(file, text, tokens_of(file, text)?)
    }

    /// Parses an untrusted file.
    ///
    /// # Errors
    /// As for [`parse`](Self::parse), and limits of the text.
    pub(crate) fn parse_untrusted(file: &str, text: &str) -> Result<Self, ShaderError> {
        check_size(file, text)?;
        let tokens = tokens_of(file, text)?;
        check_text(file, text, &tokens)?;
        let module = Self::of_tokens(file, text, tokens)?;
        match IMPORTS.exceeded(module.imports.len()) {
            Some(message) => Err(ShaderError::new(file, position(text, module.imports[IMPORTS.max].at(0)), message)),
            None => Ok(module),
        }
    }

    fn of_tokens(file: &str, text: &str, tokens: Vec<Token>) -> Result<Self, ShaderError> {
        let found = items(text, &tokens).map_err(|wrong| {
            let at = position(text, tokens[wrong.token].start as usize);
            let help = wrong.help.map(Into::into);
            ShaderError { help, ..ShaderError::new(file, at, wrong.message) }
        })?;
        let mut module = Self { tokens, ..Self::default() };
        for item in found {
            module.add(text, item).map_err(|(at, message)| ShaderError::new(file, position(text, at), message))?;
        }
        Ok(module)
    }

    /// Adds an item of the top level, or states the byte where it is wrong, and why.
    fn add(&mut self, text: &str, item: Item) -> Result<(), (usize, String)> {
        match item {
            Item::Import(items) => items.into_iter().try_for_each(|item| self.import(text, item)),
            Item::Directive(tokens) => {
                self.directives.push(self.bytes(tokens));
                Ok(())
            }
            Item::Declaration(kind, tokens, name) => {
                self.declare(text, kind, tokens, name);
                self.check_name(text, name)
            }
        }
    }

    fn import(&mut self, text: &str, Imported { path, name }: Imported) -> Result<(), (usize, String)> {
        let symbol = self.intern(&text[name.start as usize..name.end as usize]);
        let import = Import { path, name: symbol };
        let Some(first) = self.imported.get(&symbol).copied() else {
            self.imported.insert(symbol, self.imports.len() as u32);
            self.imports.push(import);
            return Ok(());
        };
        let [first, second] = [&self.imports[first as usize], &import].map(|import| import.path(text).join("::"));
        if first == second {
            return Ok(());
        }
        let message = format!(
            "`{0}` is imported as `{first}` and as `{second}`: give one another name, as in `{second} as other_{0}`",
            self.name(symbol)
        );
        Err((name.start as usize, message))
    }

    /// Checks that what was declared has not the name of an import.
    fn check_name(&self, text: &str, token: Option<usize>) -> Result<(), (usize, String)> {
        let Some(token) = token.map(|token| self.tokens[token]) else { return Ok(()) };
        let name = token.of(text);
        let import = self.symbol(name).and_then(|symbol| self.imported.get(&symbol));
        let Some(import) = import.map(|import| &self.imports[*import as usize]) else { return Ok(()) };
        let path = import.path(text).join("::");
        let message =
            format!("`{name}` is imported, too: give that another name, as in `import {path} as other_{name};`");
        Err((token.start as usize, message))
    }

    /// Imports what a path in the code names: its first name may be that of an imported file.
    fn import_path(&mut self, text: &str, used: Use) {
        if !self.name(used.symbol).contains("::") || self.imported.contains_key(&used.symbol) {
            return;
        }
        let mut path = names(text, &self.tokens[used.token as usize]);
        let first = self.symbol(&text[path[0].start as usize..path[0].end as usize]);
        if let Some(import) = first.and_then(|first| self.imported.get(&first)) {
            drop(path.splice(..1, self.imports[*import as usize].path.iter().cloned()));
        }
        self.imported.insert(used.symbol, self.imports.len() as u32);
        self.imports.push(Import { path, name: used.symbol });
    }

    fn declare(&mut self, text: &str, kind: DeclarationKind, range: Range<usize>, name: Option<usize>) {
        let found = names_of(text, &self.tokens[range.clone()], kind);
        let mut symbols = |tokens: Vec<usize>| -> Vec<Use> {
            let at = |token: usize| (range.start + token) as u32;
            let word = |token: usize| self.tokens[at(token) as usize].of(text);
            let words: Vec<(&str, u32)> = tokens.into_iter().map(|token| (word(token), at(token))).collect();
            words.into_iter().map(|(word, token)| Use { symbol: self.intern(word), token }).collect()
        };
        let (uses, locals) = (symbols(found.uses), distinct(&symbols(found.locals)));
        uses.iter().for_each(|used| self.import_path(text, *used));
        let name = name.map(|token| self.intern(self.tokens[token].of(text)));
        let tokens = range.start as u32..range.end as u32;
        let used = distinct(&uses);
        self.declared.resize(self.names.len(), None);
        let index = self.declarations.len() as u32;
        if let Some(name) = name {
            self.declared[name.index()].get_or_insert(index);
        }
        self.declarations.push(Declaration { kind, name, tokens, uses, used, locals });
    }

    fn intern(&mut self, name: &str) -> Symbol {
        if let Some(symbol) = self.symbols.get(name) {
            return *symbol;
        }
        let symbol = Symbol(self.names.len() as u32);
        self.names.push(name.into());
        self.symbols.insert(name.into(), symbol);
        symbol
    }

    /// The bytes from the first to the last of some tokens.
    pub(crate) fn bytes(&self, tokens: Range<usize>) -> Range<usize> {
        self.tokens[tokens.start].start as usize..self.tokens[tokens.end - 1].end as usize
    }

    /// The characters of a name.
    pub(crate) fn name(&self, symbol: Symbol) -> &str {
        &self.names[symbol.index()]
    }

    pub(crate) fn symbol_count(&self) -> usize {
        self.names.len()
    }

    /// The name with these characters, if the file has it.
    pub(crate) fn symbol(&self, name: &str) -> Option<Symbol> {
        self.symbols.get(name).copied()
    }

    /// The first declaration of a name.
    pub(crate) fn declaration(&self, name: Symbol) -> Option<usize> {
        self.declared.get(name.index()).copied().flatten().map(|index| index as usize)
    }

    /// The declaration of a name by its characters.
    pub(crate) fn declaration_of(&self, name: &str) -> Option<usize> {
        self.symbol(name).and_then(|symbol| self.declaration(symbol))
    }

    pub(crate) fn tokens_of(&self, declaration: &Declaration) -> &[Token] {
        &self.tokens[declaration.tokens.start as usize..declaration.tokens.end as usize]
    }
}
