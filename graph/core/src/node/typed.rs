//! Kinds with typed parameters, as a node author declares them, and an instance, which is a node at its values.

use std::any::Any;
use std::sync::Arc;

use super::invariants::Invariants;
use super::kind::{Kind, Node, NodeKind};
use super::ports::{Input, Output};
use super::values::UniformValues;
use afterimage_base::Shared;
use afterimage_base::value::{Param, Value};
use afterimage_wgsl::Shader;

/// The declaration of a node kind with typed parameters, as [`node_kind!`](crate::node_kind) makes it.
pub trait TypedKind: Sized + Clone + Send + Sync + 'static {
    /// The name of the kind, as pipeline files write it.
    const KIND: &'static str;
    /// Description for the manual.
    const DOC: &'static str;
    /// The input ports.
    const INPUTS: &'static [Input] = &[];
    /// The output ports, the main one first, each with its fallback.
    const OUTPUTS: &'static [Output];
    /// Invariants of the results, for `afterimage stress`.
    const INVARIANTS: Invariants = Invariants::DEFAULT;
    /// The shaders of its passes. [`Registry::new`](super::Registry::new) links and validates those that are listed; an
    /// error in any other one is found by the first plan that needs it.
    const SHADERS: &'static [&'static Shader] = &[];
    /// The parameters, in the order of the struct's fields.
    fn table() -> &'static [Param];
    /// The values of the fields, in the order of the table.
    fn values(&self) -> Vec<Value>;
    /// The struct from values in the order of the table; `None` where a value has the wrong type.
    fn from_values(values: &[Value]) -> Option<Self>;
    /// Sets the value at a place of the table; `None` where it has the wrong type, and without such a place.
    fn set_value(&mut self, index: usize, value: &Value) -> Option<()>;
}

/// The kind of a typed node.
struct Typed<N>(std::marker::PhantomData<fn() -> N>);

impl<N: TypedKind + Node> Kind for Typed<N> {
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
    fn invariants(&self) -> Invariants {
        N::INVARIANTS
    }
    fn shaders(&self) -> &[&'static Shader] {
        N::SHADERS
    }
    fn instantiate(&self, values: &[Value]) -> Arc<dyn Node> {
        Arc::new(N::from_values(values).expect("the values have the types of their table"))
    }
    fn set(&self, node: &mut dyn Node, index: usize, value: &Value) -> bool {
        let node: &mut dyn Any = node;
        let node: &mut N = node.downcast_mut().expect("the kind has made the node");
        node.set_value(index, value).expect("the value has the type of its table");
        true
    }
}

impl NodeKind {
    /// The kind of a typed node.
    pub const fn of<N: TypedKind + Node>() -> Self {
        Self(Shared::Static(const { &Typed::<N>(std::marker::PhantomData) }))
    }
}

/// A node of a kind at parameter values: what a graph holds.
#[derive(Clone)]
pub struct NodeInstance {
    kind: NodeKind,
    values: Vec<Value>,
    node: Arc<dyn Node>,
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
        let taken = Arc::get_mut(&mut self.node).is_some_and(|node| self.kind.set(node, index, &self.values[index]));
        if !taken {
            self.node = self.kind.instantiate(&self.values);
        }
        before
    }

    /// Invariants of the results at the present values.
    pub fn invariants(&self) -> Invariants {
        self.node.invariants(self.kind.invariants())
    }

    /// The values of the parameters by their names, as uniforms take them.
    pub fn uniform_values(&self) -> UniformValues<'_> {
        UniformValues::new(self.kind.params(), &self.values)
    }
}

impl std::ops::Deref for NodeInstance {
    type Target = dyn Node;
    fn deref(&self) -> &Self::Target {
        &*self.node
    }
}

impl std::fmt::Debug for NodeInstance {
    fn fmt(&self, f: &mut std::fmt::Formatter<'_>) -> std::fmt::Result {
        f.debug_struct("NodeInstance").field("kind", &self.kind).field("values", &self.values).finish()
    }
}

/// Declares a node kind: its name, manual text, parameters and ports. What its nodes do is the kind's
/// [`Node`](crate::node::Node).
///
/// Each field has a doc comment, a type that implements [`ParamType`](crate::value::ParamType), a default, and, after
/// `=>`, calls of [`Param`](crate::value::Param)'s builder methods. After the struct follow constants of
/// [`TypedKind`](crate::node::TypedKind): `OUTPUTS` and, where they are needed, `INPUTS`, `INVARIANTS` and `SHADERS`.
///
/// ```
/// use afterimage_graph::prelude::*;
/// node_kind! {
///     /// Darkens the picture toward its corners.
///     pub struct Corners {
///         /// Share of the effect that is mixed in; 0 changes nothing.
///         pub amount: f32 = 1.0 => within(0.0..=1.0), neutral(0.0);
///         /// Middle of the bright part.
///         pub center: [f32; 2] = [0.5, 0.5] => within(-1.0..=2.0), unit("uv");
///     }
///
///     const INPUTS: &'static [Input] = &[Input::image("source", "The picture.")];
///     const OUTPUTS: &'static [Output] =
///         &[Output::image("result", OutputState::same("source"), "The darkened picture.").or_input("source")];
/// }
/// assert_eq!(Corners::table()[1].name, "center");
/// ```
#[macro_export]
macro_rules! node_kind {
    (
        $(#[doc = $kind_doc:literal])*
        pub struct $kind:ident {
            $(
                $(#[doc = $doc:literal])*
                pub $field:ident : $ty:ty = $default:expr $(=> $($method:ident ( $($arg:expr),* $(,)? )),+ )? ;
            )*
        }
        $( const $name:ident : $declared:ty = $value:expr ; )*
    ) => {
        $(#[doc = $kind_doc])*
        #[derive(Clone, Debug, PartialEq)]
        pub struct $kind {
            $( $(#[doc = $doc])* pub $field: $ty, )*
        }

        impl $crate::node::TypedKind for $kind {
            const KIND: &'static str = stringify!($kind);
            const DOC: &'static str = concat!($($kind_doc, "\n"),*);
            $( const $name: $declared = $value; )*

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
