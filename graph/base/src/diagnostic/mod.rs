//! Diagnostics: what is wrong with a user's files, where, and what to do about it.
//!
//! Every error in a user's file becomes a [`Diagnostic`] with a stable code, one or more locations and, if known, a
//! hint. [`Diagnostics`] holds all of them with the texts of the files, so that it can be printed
//! ([`Diagnostics::render`]) or passed to an editor ([`Diagnostics::to_json`]) without further data.

mod diagnostics;
mod fix;
mod json;
mod location;
mod names;

pub use diagnostics::{Correction, Diagnostic, Diagnostics, Label, Severity, Style};
pub use fix::{Fix, apply};
pub use location::{Location, Position, Sources, Spanned};
pub use names::{did_you_mean, is_control, list, nearest, quote, shown, shown_path};
