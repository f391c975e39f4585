//! The tier that a check is of.

use super::expand::Expansion;
use super::limits::MAX_TIERS;
use crate::document::{Document, Tier};
use afterimage_base::diagnostic::{Diagnostic, Location, did_you_mean, list, quote};

impl Expansion<'_> {
    /// Reports claims of tiers that the document does not have.
    pub(super) fn check_claims(&mut self, document: &Document) {
        for (name, _) in document.claims.iter().take(MAX_TIERS + 1) {
            let is_there = document.tiers.iter().take(MAX_TIERS).any(|(known, _)| known.value == name.value);
            // What could not be read may have it.
            if !is_there && !document.is_partial {
                self.fields.reports.push(unknown_tier(document, &name.value, &name.location));
            }
        }
    }

    /// The document of the requested tier. Its overrides are applied once the nodes are known.
    pub(super) fn tier(&mut self, document: Document, name: Option<&str>) -> Document {
        let Some(name) = name else { return document };
        let Some((_, tier)) = document.tiers.iter().find(|(known, _)| known.value == name) else {
            self.fields.reports.push(unknown_tier(&document, name, &document.location));
            return document;
        };
        match tier {
            Tier::Settings(_) => {
                self.tier = Some(name.to_owned());
                document
            }
            Tier::File(named) => self.fields.document(named).unwrap_or(document),
        }
    }
}

fn unknown_tier(document: &Document, name: &str, location: &Location) -> Diagnostic {
    let names = || document.tiers.iter().map(|(name, _)| name.value.as_str());
    let mut help = match document.tiers.len() {
        0 => "it has no tiers at all".to_owned(),
        _ => format!("its tiers are {}", list(names(), 8)),
    };
    if let Some(meant) = did_you_mean(name, names()) {
        help = format!("{meant} {help}");
    }
    Diagnostic::error("unknown-tier", format!("the pipeline has no tier {}", quote(name))).at(location, "").help(help)
}
