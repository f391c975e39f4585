//! Every test of the front end, in one binary, without a GPU.
#![allow(unreachable_pub, missing_docs, clippy::unwrap_used, reason = "a test binary has no outside")]

/// Numbers of host blocks, and facts.
mod blocks;
/// What images mean, and what a graph tells of itself.
mod colors;
/// Drawing passes that do not fit.
mod drawing;
/// Folders that are part of the program.
mod embedded;
/// Errors in files, and what is said of them.
mod errors;
/// Functions of the shaders' library, called by kinds from folders.
mod library;
/// Files that are loaded asynchronously.
mod loaded_files;
/// Where errors are.
mod locations;
/// A kind from a folder.
mod posterize;
/// When kinds from folders are freed.
mod release;
/// Changed values, written into the text of a file.
mod save;
/// Which of several changes of a value counts.
mod settings;
