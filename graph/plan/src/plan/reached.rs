//! What follows from a change of the numbers of passes.

use std::collections::BTreeSet;

use afterimage_graph::node::{Pass, Resource};

use super::Plan;

impl Plan {
    /// For each pass whether it must run again if those that `changed` states make something else: it reads what one
    /// that runs again writes, or writes to the same.
    pub fn reached_from(&self, changed: Vec<bool>) -> Vec<bool> {
        let mut reached = changed;
        loop {
            let again = self.work().zip(&reached).filter(|(_, reached)| **reached);
            let written: BTreeSet<Resource> = again.flat_map(|(pass, _)| pass.writes()).collect();
            let uses = |pass: &Pass| pass.reads().iter().chain(&pass.writes()).any(|used| written.contains(used));
            let grown: Vec<bool> = self.work().zip(&reached).map(|(pass, reached)| *reached || uses(pass)).collect();
            if grown == reached {
                return reached;
            }
            reached = grown;
        }
    }
}
