//! Many mutants in one text, each behind a condition on its number.

use std::cmp::Reverse;
use std::collections::BTreeMap;
use std::ops::Range;

use crate::list::Mutant;
use crate::sites::{Site, Text};

/// The items that a crate needs for the conditions: the chosen mutant, and a list of those that a test reaches.
pub(crate) const SUPPORT: &str = r#"
#[doc(hidden)]
#[allow(missing_docs, unreachable_pub, clippy::all)]
pub(crate) fn __mutant(number: usize) -> bool {
    use std::io::Write as _;
    use std::sync::atomic::{AtomicBool, Ordering};
    static SEEN: [AtomicBool; 8192] = [const { AtomicBool::new(false) }; 8192];
    static MODE: std::sync::OnceLock<(usize, Option<std::fs::File>)> = std::sync::OnceLock::new();
    let (chosen, trace) = MODE.get_or_init(|| {
        let number = std::env::var("MUTANT").ok().and_then(|text| text.parse().ok()).unwrap_or(usize::MAX);
        let open = |path| std::fs::OpenOptions::new().create(true).append(true).open(path).expect("a trace");
        (number, std::env::var("MUTANT_TRACE").ok().map(open))
    });
    if let Some(mut trace) = trace.as_ref() {
        if !SEEN[number].swap(true, Ordering::Relaxed) {
            trace.write_all(format!("{number}\n").as_bytes()).expect("a trace");
        }
    }
    *chosen == number
}
"#;

/// A change of the text, and the mutants that it holds.
struct Edit {
    range: Range<usize>,
    what: What,
    mutants: Vec<(usize, Mutant)>,
}

enum What {
    /// The body of a function returns at once.
    Body,
    Around(Site),
}

/// The text of a file with these mutants, each with its number. The numbers of mutants whose place is not found, or
/// which cannot be behind a condition, come with it.
pub(crate) fn weave(text: &Text, mutants: &[(usize, Mutant)]) -> (String, Vec<usize>) {
    let (sites, mut lost) = (text.sites(), Vec::new());
    let mut edits: BTreeMap<(usize, bool, Reverse<usize>), Edit> = BTreeMap::new();
    for (number, mutant) in mutants {
        let start = text.at(mutant.span.start);
        let site = sites.iter().find(|(key, _)| **key == (mutant.genre.as_str(), start)).map(|(_, site)| site);
        let Some((range, what)) = place(text, mutant, start, site) else {
            lost.push(*number);
            continue;
        };
        // What begins at one place: first the statement of a function, then from the outside to the inside.
        let key = (range.start, !matches!(what, What::Body), Reverse(range.end));
        let edit = edits.entry(key).or_insert_with(|| Edit { range, what, mutants: Vec::new() });
        edit.mutants.push((*number, mutant.clone()));
    }
    let edits: Vec<Edit> = edits.into_values().collect();
    (Weaver { text: &text.text, edits: &edits }.render(0..text.text.len(), 0), lost)
}

/// The text that an edit replaces, and how.
fn place(text: &Text, mutant: &Mutant, start: usize, site: Option<&Site>) -> Option<(Range<usize>, What)> {
    let range = match (mutant.genre.as_str(), site) {
        ("FnValue", _) => return Some((start..start, What::Body)),
        // A condition with `let` binds names, so it cannot stand in a branch.
        (_, Some(Site::Binary { left, right })) if text.text[left.start..right.end].contains("let ") => return None,
        (_, Some(Site::Binary { left, right })) => left.start..right.end,
        (_, Some(Site::Unary { operand })) => start..operand.end,
        (_, Some(Site::Arm { pattern_end, guard })) => {
            *pattern_end..guard.as_ref().map_or(*pattern_end, |guard| guard.end)
        }
        (_, Some(Site::Field { field, .. })) => field.clone(),
        (_, None) => return None,
    };
    Some((range, What::Around(site?.clone())))
}

fn if_chosen(number: usize) -> String {
    format!("crate::__mutant({number})")
}

/// Text of a mutant between comments, by which an error of the compiler is found to be its.
fn marked(number: usize, text: &str) -> String {
    format!("/*<{number}*/{text}/*>{number}*/")
}

/// The mutants of a woven text and the bytes between their comments.
pub(crate) fn marks(woven: &str) -> Vec<(usize, Range<usize>)> {
    let (mut open, mut all) = (Vec::new(), Vec::new());
    for (at, _) in woven.match_indices("/*") {
        let rest = &woven[at + 2..];
        let number = rest[1.min(rest.len())..].split_once("*/").and_then(|(text, _)| text.parse::<usize>().ok());
        match (rest.as_bytes().first(), number) {
            (Some(b'<'), Some(number)) => open.push((number, at)),
            (Some(b'>'), Some(_)) => {
                let (number, begin) = open.pop().expect("comments come in pairs");
                all.push((number, begin..at));
            }
            _ => {}
        }
    }
    all
}

struct Weaver<'t> {
    text: &'t str,
    edits: &'t [Edit],
}

impl Weaver<'_> {
    /// A part of the text with the edits in it, from that number on.
    fn render(&self, range: Range<usize>, first: usize) -> String {
        let (mut out, mut at) = (String::new(), range.start);
        for (index, edit) in self.edits.iter().enumerate().skip(first) {
            if edit.range.start >= at && edit.range.end <= range.end {
                out.push_str(&self.text[at..edit.range.start]);
                out.push_str(&self.edited(edit, index + 1));
                at = edit.range.end;
            }
        }
        out.push_str(&self.text[at..range.end]);
        out
    }

    fn edited(&self, edit: &Edit, next: usize) -> String {
        let part = |range: &Range<usize>| self.render(range.clone(), next);
        let choices = |otherwise: String, choice: &dyn Fn(&Mutant) -> String| {
            let branch = |(number, mutant): &(usize, Mutant)| {
                marked(*number, &format!("if {} {{ {} }} else ", if_chosen(*number), choice(mutant)))
            };
            format!("({}{{ {otherwise} }})", edit.mutants.iter().map(branch).collect::<String>())
        };
        match &edit.what {
            What::Body => {
                let early = |(number, mutant): &(usize, Mutant)| {
                    marked(*number, &format!("if {} {{ return {}; }}", if_chosen(*number), mutant.replacement))
                };
                edit.mutants.iter().map(early).collect()
            }
            What::Around(Site::Binary { left, right }) => {
                let operator = self.text[left.end..right.start].trim();
                let (left, right) = (part(left), part(right));
                let with = |operator: &str| format!("(({left}) {operator} ({right}))");
                choices(with(operator), &|mutant| with(&mutant.replacement))
            }
            What::Around(Site::Unary { operand }) => {
                let operator = self.text[edit.range.start..operand.start].trim();
                let operand = part(operand);
                choices(format!("({operator}({operand}))"), &|_| format!("({operand})"))
            }
            What::Around(Site::Arm { guard, .. }) => self.guard(edit, guard.as_ref().map(part)),
            What::Around(Site::Field { name, value, base, .. }) => {
                let (value, base) = (part(value), &self.text[base.clone()]);
                format!("{name}: {}", choices(value, &|_| format!("({base}).{name}")))
            }
        }
    }

    /// The guard of an arm that may be missing, or hold always or never.
    fn guard(&self, edit: &Edit, guard: Option<String>) -> String {
        let mut condition = guard.map_or("true".to_owned(), |guard| format!("({guard})"));
        for (number, mutant) in &edit.mutants {
            let chosen = if_chosen(*number);
            condition = match mutant.replacement.as_str() {
                "true" => format!("({} || {condition})", marked(*number, &chosen)),
                _ => format!("(!{} && {condition})", marked(*number, &chosen)),
            };
        }
        format!(" if {condition}")
    }
}
