//! A kind of node: what a node author writes ([`Node`]) and what the framework sees ([`Kind`]).

use std::sync::Arc;

use super::color::ColorChange;
use super::params::Params;
use super::ports::{Fallback, Input, Output, Signature};
use super::recorder::Recorder;
use afterimage_base::Shared;
use afterimage_base::value::{Param, Value};

/// What arrives at a node's inputs once the graph is specialised.
#[derive(Clone, Debug, Default)]
pub struct Arrivals {
    zero: Vec<Shared<str>>,
    absent: Vec<Shared<str>>,
}

impl Arrivals {
    /// From the names of the inputs that are exactly zero and of those that are unwired or off.
    pub fn new(zero: Vec<Shared<str>>, absent: Vec<Shared<str>>) -> Self {
        Self { zero, absent }
    }

    /// Whether the input is known to be zero everywhere.
    pub fn is_zero(&self, port: &str) -> bool {
        self.zero.iter().any(|name| name == port)
    }

    /// Whether nothing arrives at the input.
    pub fn is_absent(&self, port: &str) -> bool {
        self.absent.iter().any(|name| name == port)
    }
}

/// A node kind with typed parameters: what a node author implements, beside `params!`.
pub trait Node: Params {
    /// The input ports.
    const INPUTS: &'static [Input];
    /// The output ports, the main one first.
    const OUTPUTS: &'static [Output];
    /// What replaces every output when the node is off.
    const FALLBACK: Fallback;

    /// The fallback that equals the node's output at its present values and arrivals, if there is one: the node is then
    /// skipped. The result must be bit-identical to running the node, or more accurate.
    fn identity(&self, arrivals: &Arrivals) -> Option<Fallback> {
        let _ = arrivals;
        None
    }

    /// Checks what domains cannot express: whether a loaded file can be read, whether values fit each other. The error
    /// is one sentence, with the line of the file that it is about. A node whose values fail is never recorded.
    fn verify(&self) -> Result<(), String> {
        Ok(())
    }

    /// What the node does to the colorimetry of its image at its present values.
    fn color(&self) -> ColorChange {
        ColorChange::Keep
    }

    /// Describes the passes of the node.
    fn record(&self, pass: &mut Recorder<'_>);
}

/// A node kind as the framework sees it.
pub trait Kind: Send + Sync + 'static {
    /// The name in pipeline files.
    fn name(&self) -> &str;
    /// What it does, for the manual.
    fn doc(&self) -> &str;
    /// The parameters.
    fn params(&self) -> &[Param];
    /// The input ports.
    fn inputs(&self) -> &[Input];
    /// The output ports, the main one first.
    fn outputs(&self) -> &[Output];
    /// What replaces every output when the node is off.
    fn fallback(&self) -> Fallback;
    /// The fallback that equals the node's output at these values and arrivals.
    fn identity(&self, values: &[Value], arrivals: &Arrivals) -> Option<Fallback>;
    /// Whether the values go together and the files among them, which are loaded by now, can be read.
    fn verify(&self, values: &[Value]) -> Result<(), String>;
    /// What the node does to the colorimetry of its image at these values.
    fn color(&self, values: &[Value]) -> ColorChange;
    /// Describes the passes of the node at these values.
    fn record(&self, values: &[Value], pass: &mut Recorder<'_>);
}

struct Typed<N>(std::marker::PhantomData<fn() -> N>);

fn typed<N: Node>(values: &[Value]) -> N {
    N::from_values(values).expect("values of a checked graph have the types of their table")
}

impl<N: Node> Kind for Typed<N> {
    fn name(&self) -> &str {
        N::KIND
    }
    fn doc(&self) -> &str {
        N::DOC
    }
    fn params(&self) -> &[Param] {
        N::table()
    }
    fn inputs(&self) -> &[Input] {
        N::INPUTS
    }
    fn outputs(&self) -> &[Output] {
        N::OUTPUTS
    }
    fn fallback(&self) -> Fallback {
        N::FALLBACK
    }
    fn identity(&self, values: &[Value], arrivals: &Arrivals) -> Option<Fallback> {
        typed::<N>(values).identity(arrivals)
    }
    fn verify(&self, values: &[Value]) -> Result<(), String> {
        typed::<N>(values).verify()
    }
    fn color(&self, values: &[Value]) -> ColorChange {
        typed::<N>(values).color()
    }
    fn record(&self, values: &[Value], pass: &mut Recorder<'_>) {
        typed::<N>(values).record(pass);
    }
}

/// A handle to a node kind: what tables of kinds hold.
#[derive(Clone)]
pub struct NodeKind(Shared<dyn Kind>);

impl NodeKind {
    /// The kind of a typed node.
    pub const fn of<N: Node>() -> Self {
        Self(Shared::Static(const { &Typed::<N>(std::marker::PhantomData) }))
    }

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

    /// What the kind declares.
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

    /// The parameter that had that name before.
    pub fn former_param(&self, name: &str) -> Option<&Param> {
        self.params().iter().find(|param| param.former.as_deref() == Some(name))
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
