//! The places of a file that mutants change, with the parts of the syntax around them.

use std::collections::HashMap;
use std::ops::Range;

use proc_macro2::LineColumn;
use syn::spanned::Spanned;
use syn::visit::{self, Visit};

use crate::list::Place;

/// The text around the part that a mutant replaces.
#[derive(Clone, Debug)]
pub(crate) enum Site {
    Binary {
        left: Range<usize>,
        right: Range<usize>,
    },
    Unary {
        operand: Range<usize>,
    },
    /// An arm of a `match`: the end of its pattern, and its guard.
    Arm {
        pattern_end: usize,
        guard: Option<Range<usize>>,
    },
    /// A field of a struct expression with a base: its name, its value, and the base.
    Field {
        name: String,
        field: Range<usize>,
        value: Range<usize>,
        base: Range<usize>,
    },
}

/// The text of a file with the offsets of its lines.
pub(crate) struct Text {
    pub(crate) text: String,
    lines: Vec<usize>,
}

impl Text {
    pub(crate) fn new(text: String) -> Self {
        let lines = std::iter::once(0).chain(text.match_indices('\n').map(|(at, _)| at + 1)).collect();
        Self { text, lines }
    }

    /// The byte at a line from 1 and a column from 1 in characters.
    pub(crate) fn at(&self, place: Place) -> usize {
        let start = self.lines[place.line - 1];
        let characters = self.text[start..].chars().take(place.column - 1);
        start + characters.map(char::len_utf8).sum::<usize>()
    }

    fn offset(&self, at: LineColumn) -> usize {
        self.at(Place { line: at.line, column: at.column + 1 })
    }

    fn range(&self, node: &impl Spanned) -> Range<usize> {
        let span = node.span();
        self.offset(span.start())..self.offset(span.end())
    }

    /// The sites of all operators, arms, guards and fields, by the genre of their mutants and the byte where the text
    /// begins that these replace.
    pub(crate) fn sites(&self) -> HashMap<(&'static str, usize), Site> {
        let file = syn::parse_file(&self.text).expect("the file is Rust");
        let mut finder = Finder { text: self, sites: HashMap::new() };
        finder.visit_file(&file);
        finder.sites
    }
}

struct Finder<'t> {
    text: &'t Text,
    sites: HashMap<(&'static str, usize), Site>,
}

impl<'ast> Visit<'ast> for Finder<'_> {
    fn visit_expr_binary(&mut self, node: &'ast syn::ExprBinary) {
        let (left, right) = (self.text.range(&node.left), self.text.range(&node.right));
        let key = ("BinaryOperator", self.text.range(&node.op).start);
        self.sites.insert(key, Site::Binary { left, right });
        visit::visit_expr_binary(self, node);
    }

    fn visit_expr_unary(&mut self, node: &'ast syn::ExprUnary) {
        let operand = self.text.range(&node.expr);
        let key = ("UnaryOperator", self.text.range(&node.op).start);
        self.sites.insert(key, Site::Unary { operand });
        visit::visit_expr_unary(self, node);
    }

    fn visit_arm(&mut self, node: &'ast syn::Arm) {
        let guard = node.guard.as_ref().map(|(_, guard)| self.text.range(guard));
        let pattern = self.text.range(&node.pat);
        let site = Site::Arm { pattern_end: pattern.end, guard: guard.clone() };
        self.sites.insert(("MatchArm", pattern.start), site.clone());
        if let Some(guard) = guard {
            self.sites.insert(("MatchArmGuard", guard.start), site);
        }
        visit::visit_arm(self, node);
    }

    fn visit_expr_struct(&mut self, node: &'ast syn::ExprStruct) {
        if let Some(rest) = &node.rest {
            let base = self.text.range(rest);
            for field in &node.fields {
                let (range, value) = (self.text.range(field), self.text.range(&field.expr));
                let name = self.text.text[self.text.range(&field.member)].to_owned();
                let key = ("StructField", range.start);
                self.sites.insert(key, Site::Field { name, field: range, value, base: base.clone() });
            }
        }
        visit::visit_expr_struct(self, node);
    }
}
