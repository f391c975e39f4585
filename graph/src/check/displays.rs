//! Nodes that make light for a display must suit the displays that this light is encoded for.

use super::Graph;
use super::build::Builder;
use afterimage_base::diagnostic::{Diagnostic, quote};

impl Builder<'_> {
    /// Reports the nodes whose results do not suit a display after them.
    pub(super) fn agree_on_displays(&mut self, graph: &Graph) {
        let colors = graph.colors();
        for (index, node) in graph.nodes.iter().enumerate() {
            let mut displays = colors.displays_after(index).iter();
            if let Some(why) = displays.find_map(|display| node.instance.verify_display(display).err()) {
                let draft = &self.drafts[index];
                let message = format!("{} does not suit the display after it: {why}", quote(&draft.name.value));
                let diagnostic = Diagnostic::error("display-conflict", message).at(&draft.kind_location, "");
                self.report(diagnostic.help("make this node and the encoding after it for one display"));
            }
        }
    }
}
