//! Loops of untrusted files: each step is counted, and a loop that takes too many ends.

use super::instance::{Instance, Part};
use crate::token::TokenKind;

/// The file of the library that counts.
pub(super) const FILE: &str = "loops";
/// The function that counts a step, and states whether the loop must end.
pub(super) const STEP: &str = "is_last_step";
/// The function that begins to count.
pub(super) const BEGIN: &str = "begin_steps";

/// The function that states whether a loop had to end.
pub(super) const CUT: &str = "were_steps_cut";

/// Returns whether any untrusted file has a loop.
pub(super) fn any(parts: &[Part<'_>]) -> bool {
    parts.iter().any(|part| part.file.is_untrusted() && keywords(part).next().is_some())
}

/// Marks where the loops of untrusted files begin.
pub(super) fn mark(parts: &mut [Part<'_>]) {
    for part in parts.iter_mut().filter(|part| part.file.is_untrusted()) {
        let tokens = &part.module.tokens;
        let bracket = |at: usize| tokens[at..].iter().find(|token| token.is('{'));
        let brackets = keywords(part).filter_map(bracket).map(|token| token.start as usize..token.end as usize);
        part.loops = brackets.collect();
    }
}

/// Code after the bracket of a loop, for a counting function of that name.
pub(super) fn start(parts: &[Part<'_>], counter: Instance) -> String {
    let part = &parts[counter.index()];
    let symbol = part.module.symbol(STEP).expect("the library's file declares the function");
    format!("{{ if {}() {{ break; }}", part.final_name(symbol))
}

fn keywords<'p>(part: &'p Part<'_>) -> impl Iterator<Item = usize> + use<'p> {
    let text: &str = part.file.text();
    part.module.tokens.iter().enumerate().filter_map(move |(at, token)| {
        let is_loop = token.kind == TokenKind::Name && matches!(token.of(text), "for" | "while" | "loop");
        is_loop.then_some(at)
    })
}
