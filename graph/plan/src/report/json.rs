//! Plans as canonical JSON: keys in alphabetical order, lists in the order of the plan, no number that depends on the
//! machine.

use super::content::content;
use crate::plan::Plan;

impl Plan {
    /// The whole plan as indented JSON: the canonical content and its hash.
    pub fn to_json(&self) -> String {
        let mut content = content(self);
        content["hash"] = self.hash().to_string().into();
        content.sort_all_objects();
        format!("{content:#}")
    }
}
