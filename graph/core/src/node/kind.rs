//! A kind of node, and a node, as the framework sees them.

use std::any::Any;
use std::sync::Arc;

use super::block::HostBlock;
use super::color::ColorChange;
use super::invariants::Invariants;
use super::ports::{Fallback, Input, Output, Signature};
use super::recorder::Recorder;
use afterimage_base::Shared;
use afterimage_base::color::Colorimetry;
use afterimage_base::image::Format;
use afterimage_base::value::{Param, Value, When};
use afterimage_wgsl::Shader;

/// Inputs of a node of a specialized graph that are zero or absent.
#[derive(Clone, Debug)]
pub struct InputValues {
    kind: NodeKind,
    zero: Vec<usize>,
    absent: Vec<usize>,
}

impl InputValues {
    /// From the indices of the inputs that are exactly zero and of those that are unwired or off.
    pub fn new(kind: NodeKind, zero: Vec<usize>, absent: Vec<usize>) -> Self {
        Self { kind, zero, absent }
    }

    /// Returns whether the input is known to be zero everywhere. Panics if the kind has none of that name.
    pub fn is_zero(&self, port: &str) -> bool {
        self.zero.contains(&self.kind.signature().input_index(port))
    }

    /// Returns whether nothing arrives at the input. Panics if the kind has none of that name.
    pub fn is_absent(&self, port: &str) -> bool {
        self.absent.contains(&self.kind.signature().input_index(port))
    }
}

/// A node kind: its declaration, and the nodes at values of its parameters.
pub trait Kind: Send + Sync + 'static {
    /// The name in pipeline files.
    fn name(&self) -> &str;
    /// Description for the manual.
    fn doc(&self) -> &str;
    /// The parameters.
    fn params(&self) -> &[Param];
    /// The input ports.
    fn inputs(&self) -> &[Input];
    /// The output ports, the main one first.
    fn outputs(&self) -> &[Output];
    /// Invariants of the results.
    fn invariants(&self) -> Invariants {
        Invariants::NONE
    }
    /// The shaders that a registry validates before it takes the kind.
    fn shaders(&self) -> &[&'static Shader] {
        &[]
    }
    /// The host blocks that its inputs declare.
    fn blocks(&self) -> Vec<&'static HostBlock> {
        self.inputs().iter().filter_map(|port| port.block).collect()
    }
    /// The node at these values, in the order of `params`. Panics where a value has the wrong type.
    fn instantiate(&self, values: &[Value]) -> Arc<dyn Node>;
    /// Sets a parameter of a node of this kind, by its place in the order of `params`; `false` if the node is to be
    /// instantiated anew for it. Panics where the value has the wrong type.
    fn set(&self, node: &mut dyn Node, index: usize, value: &Value) -> bool {
        let _ = (node, index, value);
        false
    }
}

/// A node at its values.
pub trait Node: Any + Send + Sync {
    /// Returns whether every output equals its fallback at the present values and input values: the node is then
    /// skipped. The fallback must be bit-identical to the result of running the node, or more accurate.
    fn is_identity(&self, inputs: &InputValues) -> bool {
        let _ = inputs;
        false
    }

    /// The same for the named output alone, for a kind whose outputs become identities at different values. Readers of
    /// such an output get its fallback, and the node runs only if another output is read.
    fn identity_of(&self, output: &str, inputs: &InputValues) -> bool {
        let _ = output;
        self.is_identity(inputs)
    }

    /// Checks what domains cannot express: whether a loaded file can be read, whether values fit each other. The error
    /// is one sentence, with the line of the file that it is about. A node whose values fail is never recorded.
    fn verify(&self) -> Result<(), String> {
        Ok(())
    }

    /// Checks a format that the pipeline file sets for the results. The error is one sentence.
    fn verify_format(&self, format: Format) -> Result<(), String> {
        let _ = format;
        Ok(())
    }

    /// Checks that the results suit a display that they are encoded for: called for each `Encode` that follows on the
    /// wires. The error is one sentence.
    fn verify_display(&self, display: &Colorimetry) -> Result<(), String> {
        let _ = display;
        Ok(())
    }

    /// Returns whether the image at an input stands for a mean of the picture, given whether an output does: then what
    /// lies beyond the border of the picture is unknown.
    fn averages(&self, input: &str, is_averaged: bool) -> bool {
        let _ = input;
        is_averaged
    }

    /// The parameters, by name, and their values at which a color at the first input leaves as gray; `None` for a kind
    /// that balances no white, and for a color that it cannot make gray. The color is linear Rec.709.
    fn values_for_gray(&self, color: [f64; 3]) -> Option<Vec<(&'static str, Value)>> {
        let _ = color;
        None
    }

    /// Change of colorimetry at the present values.
    fn color(&self) -> ColorChange {
        ColorChange::Keep
    }

    /// Invariants of the results at the present values, of those that the kind declares.
    fn invariants(&self, declared: Invariants) -> Invariants {
        declared
    }

    /// Describes the passes of the node.
    fn record(&self, pass: &mut Recorder<'_>);
}

/// A handle to a node kind: what tables of kinds hold.
#[derive(Clone)]
pub struct NodeKind(pub(super) Shared<dyn Kind>);

impl NodeKind {
    /// Any other implementation; it is dropped with the last handle to it.
    pub fn new(kind: Arc<dyn Kind>) -> Self {
        Self(Shared::Counted(kind))
    }

    /// The counted implementation, if this is no part of the program.
    pub fn counted(&self) -> Option<&Arc<dyn Kind>> {
        match &self.0 {
            Shared::Static(_) => None,
            Shared::Counted(kind) => Some(kind),
        }
    }

    /// Returns whether both are the same implementation. A kind that was loaded again is another one.
    pub fn is(&self, other: &Self) -> bool {
        // Kinds without fields may all have one address, so the name is compared, too.
        std::ptr::addr_eq(&raw const *self.0, &raw const *other.0) && self.name() == other.name()
    }

    /// Declaration of the kind.
    pub fn signature(&self) -> Signature<'_> {
        Signature { name: self.name(), params: self.params(), inputs: self.inputs(), outputs: self.outputs() }
    }

    /// The main output's name.
    pub fn main_output(&self) -> &str {
        &self.outputs().first().expect("every kind has an output: the contract test holds it").name
    }

    /// The input port of that name.
    pub fn input(&self, name: &str) -> Option<&Input> {
        self.inputs().iter().find(|port| port.name == name)
    }

    /// The output port of that name.
    pub fn output(&self, name: &str) -> Option<&Output> {
        self.outputs().iter().find(|port| port.name == name)
    }

    /// Returns whether a node of this kind may be off in any graph: readers of each output get something.
    pub fn can_be_off(&self) -> bool {
        self.outputs().iter().all(|port| port.fallback != Fallback::Absent)
    }

    /// The first condition of the parameter at a place of the table that does not hold at these values of all
    /// parameters; `None` if the parameter has an effect. `is_wired` is called with names of inputs.
    pub fn unmet_condition(&self, values: &[Value], index: usize, is_wired: impl Fn(&str) -> bool) -> Option<&When> {
        let is_one_of =
            |name: &str, among: &[Value]| self.param(name).is_some_and(|(other, _)| among.contains(&values[other]));
        self.params()[index].when.iter().find(|condition| match condition {
            When::OneOf(name, among) => !is_one_of(name, among),
            When::NoneOf(name, among) => is_one_of(name, among),
            When::Wired(input, wired) => is_wired(input) != *wired,
        })
    }

    /// The parameter of that name and its place in the table.
    pub fn param(&self, name: &str) -> Option<(usize, &Param)> {
        self.params().iter().enumerate().find(|(_, param)| param.name == name)
    }
}

impl std::ops::Deref for NodeKind {
    type Target = dyn Kind;
    fn deref(&self) -> &Self::Target {
        &*self.0
    }
}

impl std::fmt::Debug for NodeKind {
    fn fmt(&self, f: &mut std::fmt::Formatter<'_>) -> std::fmt::Result {
        write!(f, "NodeKind({})", self.name())
    }
}
