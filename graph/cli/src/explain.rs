//! `afterimage explain`: what the code of an error or a warning means.

use std::fmt::Write as _;

use afterimage_graph::diagnostic::did_you_mean;
use anstyle::{AnsiColor, Style};

use crate::args::ExplainArgs;
use crate::failure::Failure;
use crate::terminal::{say_styled, say_text, wrapped};

/// For each code `# code`, a paragraph, and an example if it fits in a few lines: `- ` begins those that cause it,
/// `+ ` those that mend it.
const CODES: &str = include_str!("explain/codes.txt");

const CODE: Style = AnsiColor::Cyan.on_default().bold();
const WRONG: Style = AnsiColor::Red.on_default();
const RIGHT: Style = AnsiColor::Green.on_default();

pub(crate) fn run(args: &ExplainArgs) -> Result<(), Failure> {
    let Some(wanted) = &args.code else {
        say_styled(&list());
        return Ok(());
    };
    let code = wanted.trim_start_matches("error").trim_start_matches("warning").trim_matches(['[', ']']);
    let Some((_, page)) = pages().find(|(known, _)| *known == code) else {
        let hint = did_you_mean(code, pages().map(|(known, _)| known));
        let hint = hint.unwrap_or_else(|| "`afterimage explain` lists all codes".into());
        return Err(Failure::user(format!("no error or warning has the code `{code}`")).hint(hint));
    };
    let (text, example) = page.split_once('\n').unwrap_or((page, ""));
    say_text(&wrapped(text, 0));
    if !example.is_empty() {
        say_styled(&styled(example));
    }
    Ok(())
}

/// The codes and what follows them.
fn pages() -> impl Iterator<Item = (&'static str, &'static str)> {
    CODES.trim_start_matches("# ").split("\n\n# ").filter_map(|page| page.trim_end().split_once('\n'))
}

/// The codes with the first sentence about each.
fn list() -> String {
    let width = pages().map(|(code, _)| code.len()).max().unwrap_or(0);
    let mut text = String::new();
    for (code, page) in pages() {
        let sentence = page.lines().next().unwrap_or("").split_inclusive(". ").next().unwrap_or("");
        let lines = wrapped(sentence.trim(), width + 2);
        let _ = writeln!(text, "{CODE}{code:width$}{CODE:#}  {}", lines.trim_start());
    }
    text
}

fn styled(example: &str) -> String {
    let mut text = "\n".to_owned();
    for line in example.lines() {
        let style = match line.get(..1) {
            Some("-") => WRONG,
            Some("+") => RIGHT,
            _ => Style::new(),
        };
        let _ = writeln!(text, "{style}{line}{style:#}");
    }
    text
}
