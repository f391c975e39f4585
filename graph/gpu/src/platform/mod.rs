//! What differs between targets that have threads and may wait, and the web, which has neither.

#[cfg(not(target_family = "wasm"))]
mod native;
#[cfg(target_family = "wasm")]
mod web;

#[cfg(not(target_family = "wasm"))]
pub(crate) use native::{Worker, caught, on_threads, scoped, submit, wait, watched};
#[cfg(target_family = "wasm")]
pub(crate) use web::{Worker, caught, on_threads, scoped, watched};
