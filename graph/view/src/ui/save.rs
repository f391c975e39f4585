//! Save: changed values are written into the text of the pipeline.

use super::Viewer;

impl Viewer {
    /// Writes the changes into the pipeline, or as a new tier of it.
    pub(super) fn save(&mut self, tier: Option<&str>) {
        let _ = tier;
    }
}
