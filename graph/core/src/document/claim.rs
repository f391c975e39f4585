//! Claims: `"low": Claim(ms: 0.2, jod: 9.7, p999: 2.5, for: "desk", on: "a GPU at 3840x2160")`.

use std::fmt::{self, Display, Formatter};

use super::tree::{Field, Item, Tree};
use super::unknown::unknown;
use afterimage_base::diagnostic::{Diagnostic, Spanned, quote};

/// The word before the figures of a claim.
pub(super) const CLAIM: &str = "Claim";

const FIGURES: [&str; 6] = ["ms", "jod", "p999", "flip", "for", "on"];
/// The most JOD: no visible difference.
const MAX_JOD: f64 = 10.0;

/// Measurement of a tier, as its file states it. Its `Display` is a line for a user.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct Claim {
    /// Conditions of the measurement: a device, a size, images.
    pub on: String,
    /// The milliseconds of a frame.
    pub ms: Option<f64>,
    /// The quality in JOD on the [`display`](Self::display), 10 for no visible difference. It can be below zero.
    pub jod: Option<f64>,
    /// The error that one pixel in a thousand exceeds, in codes of 8 bits.
    pub p999: Option<f64>,
    /// The visible difference FLIP, from 0 to 1.
    pub flip: Option<f64>,
    /// The name of the display of `jod`, as `measure --display` takes it: `for` in files.
    pub display: Option<String>,
}

impl Display for Claim {
    fn fmt(&self, f: &mut Formatter<'_>) -> fmt::Result {
        let Self { on, ms, jod, p999, flip, display } = self;
        ms.iter().try_for_each(|ms| write!(f, "{ms} ms, "))?;
        jod.iter().zip(display).try_for_each(|(jod, display)| write!(f, "{jod} JOD for {display}, "))?;
        p999.iter().try_for_each(|p999| write!(f, "99.9 % of pixels within {p999} codes, "))?;
        flip.iter().try_for_each(|flip| write!(f, "FLIP {flip}, "))?;
        write!(f, "on {on}")
    }
}

/// The claim with these figures, each of which occurs once; what is wrong otherwise.
pub(super) fn claim(word: &Spanned<String>, figures: Vec<Field>) -> Result<Claim, Vec<Diagnostic>> {
    let (mut claim, mut on, mut problems, mut is_broken) = (Claim::default(), None, Vec::new(), false);
    for (name, value) in figures {
        let figure = match name.value.as_str() {
            "ms" => &mut claim.ms,
            "jod" => &mut claim.jod,
            "p999" => &mut claim.p999,
            "flip" => &mut claim.flip,
            "for" | "on" => {
                let text_of = if name.value == "on" { &mut on } else { &mut claim.display };
                match &value.value {
                    Tree::Text(text) => *text_of = Some(text.clone()),
                    Tree::Broken => is_broken = true,
                    _ => problems.push(wrong(&name, "a text in quotes", &value)),
                }
                continue;
            }
            other => {
                let message = format!("a claim has no figure {}", quote(other));
                problems.push(unknown("unknown-option", message, &name, "figures", &FIGURES));
                continue;
            }
        };
        let (wanted, range) = match name.value.as_str() {
            "jod" => ("a number, 10 or less", f64::MIN..=MAX_JOD),
            _ => ("a number, 0 or more", 0.0..=f64::MAX),
        };
        match value.value.number() {
            Some(number) if range.contains(&number) => *figure = Some(number),
            _ if value.value.is_broken() => is_broken = true,
            _ => problems.push(wrong(&name, wanted, &value)),
        }
    }
    if problems.is_empty() && !is_broken {
        let mut missing = |message: &str, help: &str| {
            problems.push(Diagnostic::error("wrong-shape", message).at(&word.location, "").help(help));
        };
        match on {
            None => {
                let help = "write `Claim(ms: 0.2, p999: 2.5, on: \"a GPU at 3840x2160\")`";
                missing("a claim has no `on`, what it was measured on", help);
            }
            Some(_) if claim.jod.is_some() && claim.display.is_none() => {
                let help = "write `jod: 9.7, for: \"desk\"`, as `measure --display` names them";
                missing("a claim has `jod`, and no display that it is for", help);
            }
            Some(on) => return Ok(Claim { on, ..claim }),
        }
    }
    Err(problems)
}

fn wrong(name: &Spanned<String>, wanted: &str, value: &Item) -> Diagnostic {
    Diagnostic::error("wrong-type", format!("{} is {wanted}", quote(&name.value)))
        .at(&value.location, format!("this is {}", value.value.describe()))
}

#[cfg(test)]
mod tests {
    use super::super::parse;
    use super::Claim;

    fn claims(text: &str) -> Vec<Claim> {
        let text = format!("Pipeline(inputs: {{}}, nodes: {{}}, outputs: {{}}, claims: {{ {text} }})");
        let document = parse("claims.ron", &text).unwrap_or_else(|errors| panic!("{errors}"));
        document.claims.into_iter().map(|(_, claim)| claim).collect()
    }

    #[test]
    fn a_claim_states_what_is_seen_on_a_display() {
        let new = &claims(r#""low": Claim(ms: 0.2, jod: -0.5, p999: 2.5, flip: 0.1, for: "desk", on: "a GPU")"#)[0];
        assert_eq!((new.jod, new.display.as_deref()), (Some(-0.5), Some("desk")));
        assert_eq!(new.to_string(), "0.2 ms, -0.5 JOD for desk, 99.9 % of pixels within 2.5 codes, FLIP 0.1, on a GPU");
        let old = &claims(r#""low": Claim(ms: 0.2, flip: 0.1, on: "a GPU")"#)[0];
        assert_eq!((old.jod, &old.display), (None, &None));
        assert_eq!(old.to_string(), "0.2 ms, FLIP 0.1, on a GPU");
    }
}
