//! A cache of compiled passes, so that a plan which is loaded again needs only memory.

use std::sync::{Arc, Mutex};

use afterimage_plan::Plan;

use crate::executor::loaded::LoadedPasses;

/// Plans whose passes are kept: a few sizes at a few facts.
const MAX_PLANS: usize = 32;

/// Compiled plans, the last used at the end.
#[derive(Default)]
pub(crate) struct CompiledPasses(Mutex<Vec<(Arc<Plan>, LoadedPasses)>>);

impl CompiledPasses {
    pub(crate) fn get(&self, plan: &Arc<Plan>) -> Option<LoadedPasses> {
        let mut known = self.0.lock().expect(UNBROKEN);
        let at = known.iter().position(|(known, _)| Arc::ptr_eq(known, plan))?;
        known[at..].rotate_left(1);
        known.last().map(|(_, passes)| passes.clone())
    }

    pub(crate) fn put(&self, plan: &Arc<Plan>, passes: &LoadedPasses) {
        let mut known = self.0.lock().expect(UNBROKEN);
        known.retain(|(known, _)| !Arc::ptr_eq(known, plan));
        known.push((plan.clone(), passes.clone()));
        if known.len() > MAX_PLANS {
            known.remove(0);
        }
    }
}

const UNBROKEN: &str = "no thread panics with the lock";
