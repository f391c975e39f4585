//! Step 5: the order of passes, and the waves they form.

use std::ops::Range;

use super::{Draft, Setting};
use crate::node::{Pass, Recording, Resource};

/// Passes stay in the order of recording, which is a topological order that follows the file.
pub(crate) fn order(draft: &mut Draft, setting: &Setting<'_>) {
    let _ = (draft, setting);
}

/// Runs of passes of which none touches what another of the run writes.
pub(crate) fn waves(recording: &Recording, serial: bool) -> Vec<Range<usize>> {
    let mut waves: Vec<Range<usize>> = Vec::new();
    let mut touched: (Vec<Resource>, Vec<Resource>) = Default::default();
    for (index, pass) in recording.passes.iter().enumerate() {
        if index > 0 && !serial && independent(pass, &touched) {
            waves.last_mut().expect("the first pass opens a wave").end = index + 1;
        } else {
            touched = Default::default();
            waves.push(index..index + 1);
        }
        touched.0.extend(pass.reads());
        touched.1.extend(pass.writes());
    }
    waves
}

fn independent(pass: &Pass, (read, written): &(Vec<Resource>, Vec<Resource>)) -> bool {
    let reads_written = pass.reads().iter().any(|r| written.contains(r));
    let writes_touched = pass.writes().iter().any(|w| written.contains(w) || read.contains(w));
    !reads_written && !writes_touched
}
