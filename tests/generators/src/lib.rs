//! Random numbers, random graphs and expensive pipelines that depend on their arguments alone: for tests, benches and
//! fuzzing.

mod bombs;
mod graph;
mod kinds;
mod rng;

pub use bombs::{BOMBS, Bomb, MakeBomb};
pub use graph::Recipe;
pub use rng::Rng;
