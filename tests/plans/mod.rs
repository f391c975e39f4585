//! PlanCache: whatever the graph, the checker has nothing to say; and what is wrong, it finds.

mod faults;
mod known;
mod printing;
mod properties;
pub mod random;
mod stability;
