//! Plans as JSON: the fields of [`Plan`], which refer to images and buffers by their indices, and derived figures.

use serde_json::Value;

use super::names::Names;
use crate::plan::Plan;
use afterimage_graph::node::Resource;

impl Plan {
    /// The plan and its hash as indented JSON, with keys in alphabetical order.
    pub fn to_json(&self) -> String {
        let mut content = self.content();
        content["hash"] = self.hash().to_string().into();
        content.sort_all_objects();
        format!("{content:#}")
    }

    /// The plan with the names of its images and buffers, and with what each pass reads, writes and moves.
    pub(super) fn content(&self) -> Value {
        let mut content = serde_json::to_value(self).expect("a plan has no maps");
        let names = Names::new(self);
        for (at, name) in names.images.iter().enumerate() {
            content["images"][at]["name"] = name.as_str().into();
        }
        for (at, name) in names.buffers.iter().enumerate() {
            content["buffers"][at]["name"] = name.as_str().into();
        }
        let named = |resources: Vec<Resource>| resources.into_iter().map(|resource| names.of(resource)).collect();
        for (at, pass) in self.work().enumerate() {
            let view = &mut content["passes"][at];
            view["reads"] = named(pass.reads());
            view["writes"] = named(pass.writes());
            view["bytes_moved"] = self.bytes_moved_by(at).into();
        }
        // Nothing to do, unless another crate asks `serde_json` to keep the order of insertion.
        content.sort_all_objects();
        content
    }
}
