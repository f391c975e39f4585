//! Pipelines that are built in code.

use std::fmt::{self, Display, Formatter};

use afterimage_graph::node::TypedKind;

use crate::source::Source;

/// A pipeline that is built in code, of typed nodes. It is written as the text of a pipeline file, and a [`Source`] of
/// it is that text: it has the same checks, and errors show their places in it.
///
/// ```
/// use afterimage::host::kinds::{Encode, Exposure, ToneMap};
/// use afterimage::{Pipeline, Source};
///
/// let pipeline = Pipeline::default()
///     .input("scene", "Color")
///     .node("exposed", &Exposure { stops: 1.5 }, &[("source", "scene")])
///     .node("mapped", &ToneMap::default(), &[("source", "exposed")])
///     .node("display", &Encode::default(), &[("source", "mapped")])
///     .output("display", "display")
///     .tier("dark", &[("exposed.stops", "-1.0")]);
/// assert!(pipeline.to_string().contains(r#""exposed": Exposure(source: "scene", stops: 1.5),"#));
/// let source = Source::from(pipeline).tier("dark");
/// # drop(source);
/// ```
#[derive(Clone, Debug, Default)]
pub struct Pipeline {
    inputs: Vec<String>,
    nodes: Vec<String>,
    outputs: Vec<String>,
    tiers: Vec<String>,
}

impl Pipeline {
    /// Adds an image or a block that the host gives. The type is as in a file: `Color`, `Depth(optional: true)`.
    pub fn input(mut self, name: &str, ty: &str) -> Self {
        self.inputs.push(format!("{name:?}: {ty}"));
        self
    }

    /// Adds a node. Each wire is a port and the name of what it reads. Values that the kind has by default are not
    /// written.
    pub fn node<N: TypedKind>(mut self, name: &str, node: &N, wires: &[(&str, &str)]) -> Self {
        let mut fields: Vec<String> = wires.iter().map(|(port, source)| format!("{port}: {source:?}")).collect();
        for (param, value) in N::table().iter().zip(node.values()) {
            if value != param.default {
                fields.push(format!("{}: {value}", param.name));
            }
        }
        self.nodes.push(format!("{name:?}: {}({})", N::KIND, fields.join(", ")));
        self
    }

    /// Adds an image that the host gets.
    pub fn output(mut self, name: &str, source: &str) -> Self {
        self.outputs.push(format!("{name:?}: {source:?}"));
        self
    }

    /// Adds a tier: `node.parameter` and a value as in a file, or a node and `Off`.
    pub fn tier(mut self, name: &str, changes: &[(&str, &str)]) -> Self {
        let changes: Vec<String> = changes.iter().map(|(name, value)| format!("{name:?}: {value}")).collect();
        self.tiers.push(format!("{name:?}: {{ {} }}", changes.join(", ")));
        self
    }
}

impl Display for Pipeline {
    fn fmt(&self, f: &mut Formatter<'_>) -> fmt::Result {
        writeln!(f, "Pipeline(")?;
        let sections =
            [("inputs", &self.inputs), ("nodes", &self.nodes), ("outputs", &self.outputs), ("tiers", &self.tiers)];
        for (section, entries) in sections {
            if !entries.is_empty() {
                writeln!(f, "    {section}: {{")?;
                entries.iter().try_for_each(|entry| writeln!(f, "        {entry},"))?;
                writeln!(f, "    }},")?;
            }
        }
        writeln!(f, ")")
    }
}

impl From<Pipeline> for Source {
    fn from(pipeline: Pipeline) -> Self {
        Self::text("pipeline in code", pipeline.to_string())
    }
}
