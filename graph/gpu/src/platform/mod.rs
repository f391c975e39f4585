//! What differs between targets that have threads and may wait, and the web, which has neither.

#[cfg(not(target_family = "wasm"))]
mod native;
#[cfg(not(target_family = "wasm"))]
mod threads;
#[cfg(target_family = "wasm")]
mod web;

#[cfg(not(target_family = "wasm"))]
pub(crate) use native::{caught, scoped, submit, wait, watched};
#[cfg(not(target_family = "wasm"))]
pub(crate) use threads::{Worker, on_threads};
#[cfg(target_family = "wasm")]
pub(crate) use web::{Worker, caught, on_threads, scoped, watched};
