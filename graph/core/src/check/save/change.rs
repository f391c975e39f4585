//! What is saved.

use afterimage_base::value::Value;

/// What the graph shall have that its text does not state.
#[derive(Clone, Debug, PartialEq)]
pub enum Change {
    /// A parameter has another value.
    Value {
        /// `node.parameter`, as [`Graph::parameter_name`](crate::check::Graph::parameter_name) gives it.
        parameter: String,
        /// The value. The path of a file is relative to the saved file; its bytes are not needed.
        value: Value,
    },
    /// A node, or a pipeline used as a node, is switched on or off.
    Enabled {
        /// The name of the node; `outer/inner` for one inside of a pipeline used as a node.
        node: String,
        /// Whether it is on.
        on: bool,
    },
}
