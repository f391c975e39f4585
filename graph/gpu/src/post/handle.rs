//! What a host holds for a parameter.

use std::marker::PhantomData;

use afterimage_graph::check::{Graph, ParameterId};
use afterimage_graph::value::{Param, Type, Value};

/// A parameter that the host changes, with values of type `T`.
pub struct Parameter<T> {
    pub(super) control: Control,
    value: PhantomData<fn(T)>,
}

impl<T> Clone for Parameter<T> {
    fn clone(&self) -> Self {
        *self
    }
}

impl<T> Copy for Parameter<T> {}

impl<T> Parameter<T> {
    pub(super) fn new(control: Control) -> Self {
        Self { control, value: PhantomData }
    }

    /// The same without its type, for code that treats all parameters alike.
    pub fn control(self) -> Control {
        self.control
    }
}

/// A parameter that the host changes, of any type.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Control(pub(super) usize);

/// A parameter of a graph.
#[derive(Clone, Debug)]
pub struct ParameterInfo<'p> {
    /// Its name, `node.parameter`.
    pub name: String,
    /// Its type, domain, unit, documentation and more. [`replan`](Param::replan) says whether a change needs a new
    /// plan.
    pub declaration: &'p Param,
    /// Its present value.
    pub value: &'p Value,
}

/// What the host holds a [`Control`] for.
#[derive(Clone)]
pub(super) struct Handle {
    pub(super) name: String,
    pub(super) ty: Type,
    /// The value that the host has set.
    pub(super) value: Option<Value>,
    /// The value of the present graph before the host has set one.
    pub(super) written: Option<Value>,
    /// Where it is in the present graph, which may have none.
    pub(super) place: Option<ParameterId>,
}

impl Handle {
    /// Where the parameter is in a graph, if it has one of that name and type.
    pub(super) fn place_in(&self, graph: &Graph) -> Option<ParameterId> {
        let place = graph.parameter(&self.name).ok()?;
        (graph.declaration(place).ty == self.ty).then_some(place)
    }
}
