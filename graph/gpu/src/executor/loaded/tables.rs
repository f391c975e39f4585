//! What a plan makes anew when the numbers in it have changed: tables, and what is held between frames.

use afterimage_plan::Plan;

/// Whether the next frame makes anew what some passes of a plan make, its tables for example.
pub(crate) struct Tables {
    /// The uniforms of these passes: offsets in the buffer, and the bytes that the next frame sees.
    uniforms: Vec<(u64, Vec<u8>)>,
    is_filled: bool,
}

impl Tables {
    /// What these passes of a plan make, and no frame has made yet.
    pub(crate) fn new(plan: &Plan, uniforms: &[u8], makes: impl Fn(usize) -> bool) -> Self {
        let filling = (0..plan.passes.len()).filter(|pass| makes(*pass));
        let blocks = filling.map(|pass| &plan.passes[pass].uniform);
        let uniforms = blocks.map(|block| {
            let bytes = &uniforms[block.offset as usize..][..block.bytes.len()];
            (block.offset, bytes.to_vec())
        });
        Self { uniforms: uniforms.collect(), is_filled: false }
    }

    /// Notes bytes that are written to the uniforms: other ones than before need other tables.
    pub(crate) fn write(&mut self, offset: u64, bytes: &[u8]) {
        for (start, known) in &mut self.uniforms {
            let first = offset.max(*start);
            let end = (offset + bytes.len() as u64).min(*start + known.len() as u64);
            let Some(count) = end.checked_sub(first) else { continue };
            let new = &bytes[(first - offset) as usize..][..count as usize];
            let known = &mut known[(first - *start) as usize..][..count as usize];
            if known != new {
                known.copy_from_slice(new);
                self.is_filled = false;
            }
        }
    }

    /// Lets the next frame fill the tables, whatever they hold.
    pub(crate) fn forget(&mut self) {
        self.is_filled = false;
    }

    /// Whether the next frame must fill the tables.
    pub(crate) fn are_stale(&self) -> bool {
        !self.uniforms.is_empty() && !self.is_filled
    }

    /// A frame was recorded, which has filled stale tables; whether there were any.
    pub(crate) fn fill(&mut self) -> bool {
        let were_stale = self.are_stale();
        self.is_filled = true;
        were_stale
    }
}
