//! Claims: `"low": Claim(ms: 0.2, p999: 2.5, on: "a GPU at 3840x2160")`.

use std::fmt::{self, Display, Formatter};

use super::tree::{Field, Item, Tree};
use super::unknown::unknown;
use afterimage_base::diagnostic::{Diagnostic, Spanned, quote};

/// The word before the figures of a claim.
pub(super) const CLAIM: &str = "Claim";

const FIGURES: [&str; 4] = ["ms", "p999", "flip", "on"];

/// Measurement of a tier, as its file states it. Its `Display` is a line for a user.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct Claim {
    /// Conditions of the measurement: a device, a size, images.
    pub on: String,
    /// The milliseconds of a frame.
    pub ms: Option<f64>,
    /// The error that one pixel in a thousand exceeds, in codes of 8 bits.
    pub p999: Option<f64>,
    /// The visible difference FLIP, from 0 to 1.
    pub flip: Option<f64>,
}

impl Display for Claim {
    fn fmt(&self, f: &mut Formatter<'_>) -> fmt::Result {
        let Self { on, ms, p999, flip } = self;
        ms.iter().try_for_each(|ms| write!(f, "{ms} ms, "))?;
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
            "p999" => &mut claim.p999,
            "flip" => &mut claim.flip,
            "on" => {
                match &value.value {
                    Tree::Text(text) => on = Some(text.clone()),
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
        match value.value.number() {
            Some(number) if number.is_finite() && number >= 0.0 => *figure = Some(number),
            _ if value.value.is_broken() => is_broken = true,
            _ => problems.push(wrong(&name, "a number, 0 or more", &value)),
        }
    }
    match on {
        Some(on) if problems.is_empty() => return Ok(Claim { on, ..claim }),
        None if problems.is_empty() && !is_broken => {
            let message = "a claim has no `on`, what it was measured on";
            let help = "write `Claim(ms: 0.2, p999: 2.5, on: \"a GPU at 3840x2160\")`";
            problems.push(Diagnostic::error("wrong-shape", message).at(&word.location, "").help(help));
        }
        _ => {}
    }
    Err(problems)
}

fn wrong(name: &Spanned<String>, wanted: &str, value: &Item) -> Diagnostic {
    Diagnostic::error("wrong-type", format!("{} is {wanted}", quote(&name.value)))
        .at(&value.location, format!("this is {}", value.value.describe()))
}
