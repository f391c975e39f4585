//! Declarations of a file.

use std::ops::Range;

use rustc_hash::FxHashMap;

use super::kind::DeclarationKind;
use super::scope::names_of;
use super::syntax::{Item, items};
use crate::error::{ShaderError, position};
use crate::limits::{check_size, check_text};
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

#[derive(Clone, Debug)]
pub(crate) struct Import {
    pub(crate) name: String,
    /// The byte where the name starts.
    pub(crate) at: usize,
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
    /// The first declaration of each name.
    declared: Vec<Option<u32>>,
}

fn tokens_of(file: &str, text: &str) -> Result<Vec<Token>, ShaderError> {
    let error = |OpenComment(at)| ShaderError::new(file, position(text, at), "this comment has no end `*/`");
    tokens(text).map_err(error)
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
    /// A comment or a bracket without an end, and an import that is not at the top level. What else is wrong, the
    /// validator finds.
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
        Self::of_tokens(file, text, tokens)
    }

    fn of_tokens(file: &str, text: &str, tokens: Vec<Token>) -> Result<Self, ShaderError> {
        let found = items(text, &tokens).map_err(|wrong| {
            let at = position(text, tokens[wrong.token].start as usize);
            let help = wrong.help.map(Into::into);
            ShaderError { help, ..ShaderError::new(file, at, wrong.message) }
        })?;
        let mut module = Self { tokens, ..Self::default() };
        for item in found {
            module.add(text, item);
        }
        Ok(module)
    }

    fn add(&mut self, text: &str, item: Item) {
        match item {
            Item::Import(token) => {
                let token = self.tokens[token];
                self.imports.push(Import { name: token.of(text).to_owned(), at: token.start as usize });
            }
            Item::Directive(tokens) => self.directives.push(self.bytes(tokens)),
            Item::Declaration(kind, tokens, name) => self.declare(text, kind, tokens, name),
        }
    }

    fn declare(&mut self, text: &str, kind: DeclarationKind, range: Range<usize>, name: Option<usize>) {
        let found = names_of(text, &self.tokens[range.clone()], kind);
        let mut symbols = |tokens: Vec<usize>| -> Vec<Use> {
            let at = |token: usize| (range.start + token) as u32;
            tokens.into_iter().map(|token| Use { symbol: self.intern(text, at(token)), token: at(token) }).collect()
        };
        let (uses, locals) = (symbols(found.uses), distinct(&symbols(found.locals)));
        let name = name.map(|token| self.intern(text, token as u32));
        let tokens = range.start as u32..range.end as u32;
        let used = distinct(&uses);
        self.declared.resize(self.names.len(), None);
        let index = self.declarations.len() as u32;
        if let Some(name) = name {
            self.declared[name.index()].get_or_insert(index);
        }
        self.declarations.push(Declaration { kind, name, tokens, uses, used, locals });
    }

    fn intern(&mut self, text: &str, token: u32) -> Symbol {
        let name = self.tokens[token as usize].of(text);
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
