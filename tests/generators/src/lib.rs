//! Random numbers, random graphs, texts with changes and expensive pipelines that depend on their arguments alone: for
//! tests, benches and fuzzing.

mod bombs;
mod graph;
mod kinds;
mod mutate;
mod rng;

pub use bombs::{BOMBS, Bomb, MakeBomb};
pub use graph::{Recipe, hold_some};
pub use mutate::mutated;
pub use rng::Rng;
