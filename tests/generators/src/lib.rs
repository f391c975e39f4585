//! Random numbers and random graphs that depend on a seed alone: for tests, benches and fuzzing.

mod graph;
mod kinds;
mod rng;

pub use graph::Recipe;
pub use rng::Rng;
