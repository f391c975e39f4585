//! What a plan makes anew when the numbers in it have changed: tables, and what is held between frames.

use afterimage_plan::Plan;

/// Whether the next frame makes anew what some passes of a plan make, its tables for example.
pub(crate) struct Tables(Vec<Made>);

/// What a pass makes.
struct Made {
    pass: usize,
    /// The uniforms of the pass: the offset in the buffer, and the bytes that the next frame sees.
    offset: u64,
    bytes: Vec<u8>,
    is_filled: bool,
}

impl Tables {
    /// What these passes of a plan make, and no frame has made yet.
    pub(crate) fn new(plan: &Plan, uniforms: &[u8], makes: impl Fn(usize) -> bool) -> Self {
        let passes = (0..plan.passes.len()).filter(|pass| makes(*pass));
        let made = passes.map(|pass| {
            let block = &plan.passes[pass].uniform;
            let bytes = uniforms[block.offset as usize..][..block.bytes.len()].to_vec();
            Made { pass, offset: block.offset, bytes, is_filled: false }
        });
        Self(made.collect())
    }

    /// Takes over what the passes of the plan before have filled. `same` has passes of this plan and of that one that
    /// make the same of equal numbers, in the same texture.
    pub(crate) fn keep(&mut self, before: &Self, same: &[(usize, usize)]) {
        for (own, old) in same {
            let old = before.0.iter().find(|made| made.pass == *old && made.is_filled);
            if let Some(own) = self.0.iter_mut().find(|made| made.pass == *own) {
                own.is_filled |= old.is_some_and(|old| old.bytes == own.bytes);
            }
        }
    }

    /// Notes bytes that are written to the uniforms: other ones than before need other tables.
    pub(crate) fn write(&mut self, offset: u64, bytes: &[u8]) {
        for Made { offset: start, bytes: known, is_filled, .. } in &mut self.0 {
            let first = offset.max(*start);
            let end = (offset + bytes.len() as u64).min(*start + known.len() as u64);
            let Some(count) = end.checked_sub(first) else { continue };
            let new = &bytes[(first - offset) as usize..][..count as usize];
            let known = &mut known[(first - *start) as usize..][..count as usize];
            if known != new {
                known.copy_from_slice(new);
                *is_filled = false;
            }
        }
    }

    /// Lets the next frame fill the tables, whatever they hold.
    pub(crate) fn forget(&mut self) {
        self.0.iter_mut().for_each(|made| made.is_filled = false);
    }

    /// Whether the next frame must fill a table.
    pub(crate) fn are_stale(&self) -> bool {
        self.0.iter().any(|made| !made.is_filled)
    }

    /// Whether a pass fills a table in the next frame.
    pub(crate) fn is_stale(&self, pass: usize) -> bool {
        self.0.iter().any(|made| made.pass == pass && !made.is_filled)
    }

    /// A frame was recorded, which has filled stale tables; whether there were any.
    pub(crate) fn fill(&mut self) -> bool {
        let were_stale = self.are_stale();
        self.0.iter_mut().for_each(|made| made.is_filled = true);
        were_stale
    }
}
