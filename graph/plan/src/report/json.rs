//! Plans as canonical JSON: keys in alphabetical order, lists in the order of the plan, no number that depends on the
//! machine.

use super::content::Content;
use super::names::Names;
use crate::plan::Plan;

impl Plan {
    /// The whole plan as indented JSON: the canonical content and its hash.
    pub fn to_json(&self) -> String {
        let names = Names::new(self);
        let mut content = Content::new(self, &names);
        content.hash = Some(self.hash().to_string());
        serde_json::to_string_pretty(&content).expect("names and numbers can always be written as JSON")
    }
}
