//! A checker of plans that shares no code with the stages: it replays a plan and proves that every read sees its last
//! write, that no two live images share memory, and that barriers separate all that must be ordered.
//!
//! It reads nothing but the plan's data: lifetimes, states and figures are computed again.

mod figures;
mod memory;
mod order;
mod shape;
mod states;
mod walk;

use crate::placed::PlacedPlan;
use crate::plan::Plan;
use walk::{Faults, Places, Walk};

pub use walk::Fault;

/// Checks the plan, with its images in the places that the plan gives them.
///
/// # Errors
/// Every fault that was found, in the order of the walk; a plan whose parts do not fit together is not walked.
pub fn verify(plan: &Plan) -> Result<(), Vec<Fault>> {
    let places = Places {
        offsets: plan.images.iter().map(|image| image.offset).collect(),
        heap: plan.memory.placed,
        aliasing: plan.batches.iter().map(|batch| batch.aliasing.as_slice()).collect(),
    };
    faults_of(plan, places)
}

/// Checks a plan with its images in these places.
///
/// # Errors
/// As [`verify`].
pub fn verify_placed(placed: &PlacedPlan) -> Result<(), Vec<Fault>> {
    let PlacedPlan { plan, placement } = placed;
    let aliasing = placement.aliasing.iter().map(Vec::as_slice).collect();
    faults_of(plan, Places { offsets: placement.offsets.clone(), heap: placement.heap, aliasing })
}

fn faults_of(plan: &Plan, places: Places<'_>) -> Result<(), Vec<Fault>> {
    let mut faults = Faults::default();
    shape::check(plan, &places, &mut faults);
    if faults.0.is_empty() {
        let walk = Walk::new(plan, places);
        order::check(&walk, &mut faults);
        memory::check(&walk, &mut faults);
        states::check(&walk, &mut faults);
        figures::check(&walk, &mut faults);
    }
    if faults.0.is_empty() { Ok(()) } else { Err(faults.0) }
}
