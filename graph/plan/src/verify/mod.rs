//! A checker of plans that shares no code with the stages: it replays a plan and proves that every read sees its last
//! write, that no two live images share memory, and that barriers separate all that must be ordered.
//!
//! It reads nothing but the plan's data: lifetimes, states and figures are computed again.

mod drawings;
mod figures;
mod memory;
mod order;
mod shape;
mod states;
mod walk;

use crate::heap_placement::{HeapPlacement, PlacedPlan};
use crate::plan::Plan;
use walk::{Faults, Walk};

pub use walk::Fault;

/// Checks the plan, with its images in the places that the plan gives them.
///
/// # Errors
/// Every fault that was found, in the order of the walk; a plan whose parts do not fit together is not walked.
pub fn verify(plan: &Plan) -> Result<(), Vec<Fault>> {
    faults_of(plan, &HeapPlacement::of(plan))
}

/// Checks a plan with its images in these places.
///
/// # Errors
/// As [`verify`].
pub fn verify_placed(placed: &PlacedPlan) -> Result<(), Vec<Fault>> {
    faults_of(&placed.plan, &placed.placement)
}

fn faults_of(plan: &Plan, places: &HeapPlacement) -> Result<(), Vec<Fault>> {
    let mut faults = Faults::default();
    shape::check(plan, places, &mut faults);
    if faults.0.is_empty() {
        let walk = Walk::new(plan, places);
        let checks = [order::check, memory::check, states::check, figures::check, drawings::check];
        checks.into_iter().for_each(|check| check(&walk, &mut faults));
    }
    if faults.0.is_empty() { Ok(()) } else { Err(faults.0) }
}
