//! The passes of plans that were compiled before, so that a plan which comes back needs only memory.

use std::sync::{Arc, Mutex};

use afterimage_plan::Plan;

use super::loaded::LoadedPasses;

/// Plans whose passes are kept: a few sizes at a few facts.
const MOST: usize = 32;

/// Compiled plans. The one used last is at the end.
#[derive(Default)]
pub(super) struct CompiledPasses(Mutex<Vec<(Arc<Plan>, LoadedPasses)>>);

impl CompiledPasses {
    pub(super) fn get(&self, plan: &Arc<Plan>) -> Option<LoadedPasses> {
        let mut known = self.0.lock().expect(UNBROKEN);
        let at = known.iter().position(|(known, _)| Arc::ptr_eq(known, plan))?;
        known[at..].rotate_left(1);
        known.last().map(|(_, passes)| passes.clone())
    }

    pub(super) fn put(&self, plan: &Arc<Plan>, passes: &LoadedPasses) {
        let mut known = self.0.lock().expect(UNBROKEN);
        known.retain(|(known, _)| !Arc::ptr_eq(known, plan));
        known.push((plan.clone(), passes.clone()));
        if known.len() > MOST {
            known.remove(0);
        }
    }
}

const UNBROKEN: &str = "no thread panics with the lock";
