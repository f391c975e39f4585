//! Number of brackets of each kind in a file.

use std::sync::Arc;

use super::bracket::Bracket;
use super::token::{Kind, Lexer};

/// For each bracket, how many closing ones of a file are too many; negative where they are too few. What has been
/// reported is taken out, so that it does not explain another error.
#[derive(Clone, Copy, Debug, Default)]
pub(super) struct Balance([i64; 3]);

impl Balance {
    pub(super) fn of(file: &Arc<str>, text: &str) -> Self {
        let mut balance = Self::default();
        let mut lexer = Lexer::new(file, text);
        loop {
            match lexer.next().kind {
                Kind::Open(bracket) => balance.add(bracket, -1),
                Kind::Close(bracket) => balance.add(bracket, 1),
                Kind::End => return balance,
                _ => {}
            }
        }
    }

    pub(super) fn add(&mut self, bracket: Bracket, closing: i64) {
        self.0[bracket as usize] += closing;
    }

    /// Returns whether closing brackets of this kind are missing.
    pub(super) fn lacks(&self, bracket: Bracket) -> bool {
        self.0[bracket as usize] < 0
    }

    /// Returns whether there are too many closing brackets of this kind.
    pub(super) fn exceeds(&self, bracket: Bracket) -> bool {
        self.0[bracket as usize] > 0
    }
}
