//! Kinds of declarations.

#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(crate) enum DeclarationKind {
    Function,
    Struct,
    Constant,
    Override,
    Alias,
    Variable,
    Assertion,
    /// Text that is no declaration: the validator states what is wrong with it.
    Unknown,
}
