//! Common LUT Format files: version 3 (Academy S-2014-006, SMPTE ST 2136-1), and files of version 2 that use only what
//! version 3 has.

mod depth;
mod functions;
mod list;
mod tables;

pub use list::parse_clf;
