//! House rules of the workspace: `cargo test -p afterimage-tidy`. Reads source text; builds nothing and needs no GPU.
//!
//! | module | question |
//! |---|---|
//! | [`layers`] | do the dependencies of the crates follow the layers? |
//! | [`imports`], [`cycles`] | which file uses which, and is there a cycle? |
//! | [`files`] | width and header of each file |
//! | [`places`] | does the code have the functions and files that a document names? |
//! | [`documents`] | does everything exist that a document links to and names? |
//! | [`promises`] | does a test hold each promise of a document? |
//! | [`stages`] | does the documentation name the stages of the planner? |
//! | [`calls`] | is there a call for which the house has another one? |
//! | [`opens`] | is there a second place that opens files? |
//! | [`packages`] | can a library crate be built from its own files? |
//! | [`licenses`] | are the licenses and sources of dependencies allowed? |
//! | [`shaders`] | is there a function of the shared shaders that nothing calls? |
//! | [`unsafes`] | which code is `unsafe`, and why? |
//! | [`versions`] | do documents state the versions and features of the manifests? |

pub mod calls;
pub mod cycles;
pub mod documents;
pub mod files;
pub mod imports;
pub mod layers;
pub mod licenses;
pub mod modules;
pub mod opens;
pub mod packages;
mod paths;
pub mod places;
pub mod promises;
mod scopes;
pub mod shaders;
pub mod stages;
pub mod tokens;
pub mod unsafes;
pub mod versions;
pub mod workspace;
