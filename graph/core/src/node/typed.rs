//! Typed nodes: what a node author writes, and an instance, which is a node at its values.

use std::sync::Arc;

use super::color::ColorChange;
use super::invariants::Invariants;
use super::kind::{DynNode, InputValues, Kind, NodeKind};
use super::ports::{Input, Output};
use super::recorder::Recorder;
use super::values::UniformValues;
use afterimage_base::Shared;
use afterimage_base::color::Colorimetry;
use afterimage_base::image::Format;
use afterimage_base::value::{Param, Value};
use afterimage_wgsl::Shader;

/// The parameters of a node kind, as `params!` declares them.
pub trait Params: Sized + Clone + Send + Sync + 'static {
    /// The name of the kind, as pipeline files write it.
    const KIND: &'static str;
    /// Description for the manual.
    const DOC: &'static str;
    /// The declarations, in the order of the struct's fields.
    fn table() -> &'static [Param];
    /// The values of the fields, in the order of the table.
    fn values(&self) -> Vec<Value>;
    /// The struct from values in the order of the table; `None` where a value has the wrong type.
    fn from_values(values: &[Value]) -> Option<Self>;
    /// Sets the value at a place of the table; `None` where it has the wrong type, and without such a place.
    fn set_value(&mut self, index: usize, value: &Value) -> Option<()>;
}

/// A node kind with typed parameters: what a node author implements, besides `params!`.
pub trait Node: Params {
    /// The input ports.
    const INPUTS: &'static [Input];
    /// The output ports, the main one first, each with its fallback.
    const OUTPUTS: &'static [Output];
    /// Invariants of the results, for `afterimage stress`.
    const INVARIANTS: Invariants = Invariants::DEFAULT;
    /// The shaders of its passes. [`Registry::new`](super::Registry::new) links and validates those that are listed; an
    /// error in any other one is found by the first plan that needs it.
    const SHADERS: &'static [&'static Shader] = &[];

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

    /// Change of colorimetry at the present values.
    fn color(&self) -> ColorChange {
        ColorChange::Keep
    }

    /// Invariants of the results at the present values.
    fn invariants(&self) -> Invariants {
        Self::INVARIANTS
    }

    /// Describes the passes of the node.
    fn record(&self, pass: &mut Recorder<'_>);
}

impl<N: Node> DynNode for N {
    fn take(&mut self, index: usize, value: &Value) -> bool {
        self.set_value(index, value).expect("the value has the type of its table");
        true
    }
    fn is_identity(&self, inputs: &InputValues) -> bool {
        Node::is_identity(self, inputs)
    }
    fn identity_of(&self, output: &str, inputs: &InputValues) -> bool {
        Node::identity_of(self, output, inputs)
    }
    fn verify(&self) -> Result<(), String> {
        Node::verify(self)
    }
    fn verify_format(&self, format: Format) -> Result<(), String> {
        Node::verify_format(self, format)
    }
    fn verify_display(&self, display: &Colorimetry) -> Result<(), String> {
        Node::verify_display(self, display)
    }
    fn color(&self) -> ColorChange {
        Node::color(self)
    }
    fn invariants(&self) -> Invariants {
        Node::invariants(self)
    }
    fn record(&self, pass: &mut Recorder<'_>) {
        Node::record(self, pass);
    }
}

/// The kind of a typed node.
struct Typed<N>(std::marker::PhantomData<fn() -> N>);

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
    fn shaders(&self) -> &[&'static Shader] {
        N::SHADERS
    }
    fn instantiate(&self, values: &[Value]) -> Arc<dyn DynNode> {
        Arc::new(of_values::<N>(values))
    }
}

fn of_values<N: Params>(values: &[Value]) -> N {
    N::from_values(values).expect("the values have the types of their table")
}

impl NodeKind {
    /// The kind of a typed node.
    pub const fn of<N: Node>() -> Self {
        Self(Shared::Static(const { &Typed::<N>(std::marker::PhantomData) }))
    }
}

/// A node of a kind at parameter values: what a graph holds.
#[derive(Clone)]
pub struct NodeInstance {
    kind: NodeKind,
    values: Vec<Value>,
    node: Arc<dyn DynNode>,
}

impl NodeInstance {
    /// The node at these values, in the order of the kind's table.
    ///
    /// # Panics
    ///
    /// Panics where a value is missing or has another type than its parameter.
    pub fn new(kind: NodeKind, values: Vec<Value>) -> Self {
        let node = kind.instantiate(&values);
        Self { kind, values, node }
    }

    /// The kind.
    pub fn kind(&self) -> &NodeKind {
        &self.kind
    }

    /// The parameter values, in the order of the kind's table.
    pub fn values(&self) -> &[Value] {
        &self.values
    }

    /// The value of the parameter of that name.
    pub fn value(&self, name: &str) -> Option<&Value> {
        self.kind.param(name).map(|(index, _)| &self.values[index])
    }

    /// Sets the value at this place of the kind's table, and returns the one before. Nothing is allocated where no copy
    /// of this instance is left.
    ///
    /// # Panics
    ///
    /// Panics where the table has no such place, or its parameter has another type.
    pub fn set(&mut self, index: usize, value: Value) -> Value {
        let before = std::mem::replace(&mut self.values[index], value);
        let taken = Arc::get_mut(&mut self.node).is_some_and(|node| node.take(index, &self.values[index]));
        if !taken {
            self.node = self.kind.instantiate(&self.values);
        }
        before
    }

    /// The values of the parameters by their names, as uniforms take them.
    pub fn uniform_values(&self) -> UniformValues<'_> {
        UniformValues::new(self.kind.params(), &self.values)
    }
}

impl std::ops::Deref for NodeInstance {
    type Target = dyn DynNode;
    fn deref(&self) -> &Self::Target {
        &*self.node
    }
}

impl std::fmt::Debug for NodeInstance {
    fn fmt(&self, f: &mut std::fmt::Formatter<'_>) -> std::fmt::Result {
        f.debug_struct("NodeInstance").field("kind", &self.kind).field("values", &self.values).finish()
    }
}

/// Declares the parameters of a node kind and, with them, the kind's name and manual text.
///
/// Each field has a doc comment, a type that implements [`ParamType`](crate::value::ParamType), a default, and, after
/// `=>`, calls of [`Param`](crate::value::Param)'s builder methods.
///
/// ```
/// use afterimage_graph::prelude::*;
/// params! {
///     /// Darkens the picture toward its corners.
///     pub struct Corners {
///         /// Share of the effect that is mixed in; 0 changes nothing.
///         pub amount: f32 = 1.0 => within(0.0..=1.0), neutral(0.0);
///         /// Middle of the bright part.
///         pub center: [f32; 2] = [0.5, 0.5] => within(-1.0..=2.0), unit("uv");
///     }
/// }
/// assert_eq!(Corners::table()[1].name, "center");
/// ```
#[macro_export]
macro_rules! params {
    (
        $(#[doc = $kind_doc:literal])*
        pub struct $kind:ident {
            $(
                $(#[doc = $doc:literal])*
                pub $field:ident : $ty:ty = $default:expr $(=> $($method:ident ( $($arg:expr),* $(,)? )),+ )? ;
            )*
        }
    ) => {
        $(#[doc = $kind_doc])*
        #[derive(Clone, Debug, PartialEq)]
        pub struct $kind {
            $( $(#[doc = $doc])* pub $field: $ty, )*
        }

        impl $crate::node::Params for $kind {
            const KIND: &'static str = stringify!($kind);
            const DOC: &'static str = concat!($($kind_doc, "\n"),*);

            fn table() -> &'static [$crate::value::Param] {
                static TABLE: std::sync::OnceLock<Vec<$crate::value::Param>> = std::sync::OnceLock::new();
                TABLE.get_or_init(|| vec![$(
                    $crate::value::Param::new(
                        stringify!($field),
                        concat!($($doc, "\n"),*),
                        <$ty as $crate::value::ParamType>::TYPE,
                        <$ty as $crate::value::ParamType>::into_value($default),
                    ) $( $( .$method($($arg),*) )+ )?,
                )*])
            }

            fn values(&self) -> Vec<$crate::value::Value> {
                let Self { $( $field ),* } = self.clone();
                vec![$( <$ty as $crate::value::ParamType>::into_value($field), )*]
            }

            #[allow(unused_mut, unused_variables, reason = "a kind may have no parameters")]
            fn from_values(values: &[$crate::value::Value]) -> Option<Self> {
                let mut values = values.iter();
                Some(Self {
                    $( $field: <$ty as $crate::value::ParamType>::from_value(values.next()?)?, )*
                })
            }

            #[allow(unused_mut, unused_variables, unused_assignments, reason = "a kind may have no parameters")]
            fn set_value(&mut self, index: usize, value: &$crate::value::Value) -> Option<()> {
                let mut next = 0;
                $(
                    if index == next {
                        self.$field = <$ty as $crate::value::ParamType>::from_value(value)?;
                        return Some(());
                    }
                    next += 1;
                )*
                None
            }
        }

        impl Default for $kind {
            fn default() -> Self {
                Self { $( $field: $default, )* }
            }
        }
    };
}

/// Declares a parameter type whose values are names.
///
/// ```
/// use afterimage_graph::prelude::*;
/// choices! {
///     /// How fireflies are tamed.
///     pub enum Firefly {
///         /// Not at all.
///         Off,
///         /// Each tap is weighted by its own brightness.
///         Taps,
///     }
/// }
/// assert_eq!(Firefly::Taps.name(), "Taps");
/// ```
#[macro_export]
macro_rules! choices {
    (
        $(#[doc = $type_doc:literal])*
        pub enum $choice:ident {
            $( $(#[doc = $doc:literal])* $variant:ident ),+ $(,)?
        }
    ) => {
        $(#[doc = $type_doc])*
        #[derive(Clone, Copy, Debug, PartialEq, Eq)]
        pub enum $choice {
            $( $(#[doc = $doc])* $variant, )+
        }

        impl $choice {
            /// All values, in the order of their declaration.
            pub const ALL: &'static [Self] = &[$( Self::$variant ),+];

            /// The name in pipeline files.
            pub fn name(self) -> &'static str {
                match self { $( Self::$variant => stringify!($variant) ),+ }
            }
        }

        impl $crate::value::ParamType for $choice {
            const TYPE: $crate::value::Type = $crate::value::Type::Choice(&[$(
                $crate::value::ChoiceName {
                    name: stringify!($variant),
                    doc: concat!($($doc),*),
                }
            ),+]);

            fn into_value(self) -> $crate::value::Value {
                $crate::value::Value::Choice(self.name())
            }

            fn from_value(value: &$crate::value::Value) -> Option<Self> {
                let $crate::value::Value::Choice(name) = value else { return None };
                Self::ALL.iter().copied().find(|choice| choice.name() == *name)
            }
        }
    };
}
