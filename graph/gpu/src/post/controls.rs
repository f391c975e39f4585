//! Parameters that the host changes while a plan renders.

use std::marker::PhantomData;
use std::sync::atomic::{AtomicU64, Ordering};

use afterimage_graph::value::{Param, Type, Value};

use super::error::PostError;

/// A parameter that the host changes, with values of type `T`.
pub struct Parameter<T> {
    control: Control,
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
pub struct Control(u64);

impl Control {
    /// A new handle. No two are equal, so that one of another pipeline is known as such.
    fn next() -> Self {
        static HANDLES: AtomicU64 = AtomicU64::new(0);
        Self(HANDLES.fetch_add(1, Ordering::Relaxed))
    }
}

/// A parameter of a graph.
#[derive(Clone, Debug)]
pub struct ParameterInfo<'p> {
    /// Its name, `node.parameter`.
    pub name: String,
    /// Its type, domain, unit, documentation and more. [`replan`](Param::replan) states whether a change needs a new
    /// plan.
    pub declaration: &'p Param,
    /// Its present value.
    pub value: &'p Value,
}

/// The parameters with handles, and the values that the host has set.
#[derive(Clone, Default)]
pub(super) struct Controls(Vec<Entry>);

#[derive(Clone)]
pub(super) struct Entry {
    control: Control,
    pub(super) name: String,
    pub(super) ty: Type,
    /// The value that the host has set.
    pub(super) value: Option<Value>,
}

impl Controls {
    /// All of them, in the order of their handles.
    pub(super) fn entries(&self) -> &[Entry] {
        &self.0
    }

    /// The handle at an index.
    pub(super) fn at(&self, index: usize) -> Control {
        self.0[index].control
    }

    /// Adds a handle.
    pub(super) fn add(&mut self, name: &str, ty: Type) -> Control {
        let control = Control::next();
        self.0.push(Entry { control, name: name.to_owned(), ty, value: None });
        control
    }

    /// The index of a handle.
    ///
    /// # Errors
    /// It is another pipeline's.
    pub(super) fn index(&self, control: Control) -> Result<usize, PostError> {
        self.0.binary_search_by_key(&control.0, |entry| entry.control.0).map_err(|_| PostError::UnknownHandle)
    }

    /// Notes the value that the host has set, or that it has set none.
    pub(super) fn note(&mut self, index: usize, value: Option<Value>) {
        self.0[index].value = value;
    }
}
