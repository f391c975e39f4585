//! The kinds' own checks of their values: whether a file is readable, whether two parameters fit each other.

use super::build::{Builder, NodeDraft};
use afterimage_base::diagnostic::{Diagnostic, quote};
use afterimage_base::value::Type;

impl Builder<'_> {
    /// Asks every kind about the values of its nodes.
    pub(super) fn verify(&mut self) {
        let doubts: Vec<Diagnostic> = self.drafts.iter().filter(|draft| !draft.is_partial).filter_map(doubt).collect();
        doubts.into_iter().for_each(|doubt| self.report(doubt));
    }
}

fn doubt(draft: &NodeDraft) -> Option<Diagnostic> {
    let why = draft.kind.verify(&draft.values).err()?;
    let message = format!("{} cannot use its parameters: {why}", quote(&draft.name.value));
    let files = draft.kind.params().iter().zip(&draft.written).filter(|(param, _)| param.ty == Type::File);
    let file = files.filter_map(|(_, written)| written.as_ref()).next();
    Some(Diagnostic::error("unusable", message).at(file.unwrap_or(&draft.kind_location), ""))
}
