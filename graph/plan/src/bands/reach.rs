//! Halos: rows that passes read around those that they write.

use std::collections::BTreeMap;

use afterimage_graph::node::Pass;

/// Rows that passes read above and below those that they write, in images of each size.
#[derive(Clone, Debug, Default, PartialEq, Eq)]
pub struct Reach(BTreeMap<(usize, [u32; 2]), [u32; 2]>);

impl Reach {
    /// Adds rows, above and below, to those that a pass is given.
    pub fn learn(&mut self, pass: &Pass, index: usize, size: [u32; 2], more: [u32; 2]) {
        let known = self.of(pass, index, size);
        self.0.insert((index, size), [known[0] + more[0], known[1] + more[1]]);
    }

    pub(super) fn of(&self, pass: &Pass, index: usize, size: [u32; 2]) -> [u32; 2] {
        self.0.get(&(index, size)).copied().unwrap_or([pass.kind.min_halo(); 2])
    }
}
