//! Ends of wires.

use super::state::output_key;
use afterimage_base::diagnostic::quote;

/// The end of a wire: what reads it.
#[derive(Clone, Debug, PartialEq, Eq, PartialOrd, Ord)]
pub enum Reader {
    /// An input of a node.
    Input {
        /// The name of the node.
        node: String,
        /// The name of the input.
        port: String,
    },
    /// An output of the pipeline.
    Output(String),
}

impl Reader {
    /// An input of a node.
    pub fn input(node: &str, port: &str) -> Self {
        Self::Input { node: node.to_owned(), port: port.to_owned() }
    }

    /// The key of its setting.
    pub(super) fn key(&self) -> String {
        match self {
            Self::Input { node, port } => format!("{node}.{port}"),
            Self::Output(name) => output_key(name),
        }
    }

    /// The end of a wire by the key of its setting.
    pub(super) fn of_key(key: &str) -> Option<Self> {
        match key.strip_prefix('@') {
            Some(output) => Some(Self::Output(output.to_owned())),
            None => key.split_once('.').map(|(node, port)| Self::input(node, port)),
        }
    }
}

impl std::fmt::Display for Reader {
    fn fmt(&self, f: &mut std::fmt::Formatter<'_>) -> std::fmt::Result {
        match self {
            Self::Input { node, port } => write!(f, "{} of {}", quote(port), quote(node)),
            Self::Output(name) => write!(f, "the output {}", quote(name)),
        }
    }
}
