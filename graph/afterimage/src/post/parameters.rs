//! The parameters of a [`Post`]: handles and values.

use afterimage_graph::value::{ParamType, Value};

use super::Post;
use super::values::{Control, Parameter, ParameterInfo};
use crate::error::PostError;

impl Post {
    /// All parameters of the graph.
    pub fn parameters(&self) -> impl Iterator<Item = ParameterInfo<'_>> {
        self.graph().parameters().map(|id| ParameterInfo {
            name: self.graph().parameter_name(id),
            declaration: self.graph().declaration(id),
            value: self.graph().value(id),
        })
    }

    /// The parameters of the present graph that the host has set, or has handles of and may set without a plan: their
    /// names, `node.parameter`, and their values.
    pub fn set_values(&self) -> impl Iterator<Item = (&str, &Value)> {
        self.values.set_values()
    }

    /// A handle to the parameter that `node.parameter` names.
    ///
    /// The parameter is dynamic from the next plan on: its node runs also where its value changes nothing, so that new
    /// values need no plan. Where a change [needs a plan](Self::needs_plan), each does.
    ///
    /// # Errors
    /// There is no such parameter, or it has another type.
    pub fn parameter<T: ParamType>(&mut self, name: &str) -> Result<Parameter<T>, PostError> {
        let (parameter, is_new) = self.values.parameter(name)?;
        if is_new {
            self.plans.queue();
        }
        Ok(parameter)
    }

    /// The same for a parameter of any type.
    ///
    /// # Errors
    /// There is no such parameter.
    pub fn control(&mut self, name: &str) -> Result<Control, PostError> {
        let (control, is_new) = self.values.control(name)?;
        if is_new {
            self.plans.queue();
        }
        Ok(control)
    }

    /// Sets a value, from the next frame on; in the background if it needs a new plan. While the present graph has no
    /// such parameter, the value is kept for the next one.
    ///
    /// # Errors
    /// It is outside of the domain, or does not go with other values of the node, which then keeps the old one.
    pub fn set<T: ParamType>(&mut self, parameter: Parameter<T>, value: T) -> Result<(), PostError> {
        self.set_value(parameter.control(), value.into_value())
    }

    /// The same for a parameter of any type.
    ///
    /// # Errors
    /// As [`set`](Self::set); also if the value has another type.
    pub fn set_value(&mut self, control: Control, value: Value) -> Result<(), PostError> {
        if self.values.set(control, value)? {
            self.plans.queue();
        }
        Ok(())
    }

    /// The present value of a parameter: that of the graph, or the last that was set while the graph has none.
    pub fn value(&self, control: Control) -> Option<&Value> {
        self.values.value(control)
    }

    /// Reverts to the value in the pipeline file, also in the next graph.
    ///
    /// # Errors
    /// As [`set`](Self::set).
    pub fn unset(&mut self, control: Control) -> Result<(), PostError> {
        if self.values.unset(control)? {
            self.plans.queue();
        }
        Ok(())
    }

    /// `true` if a change of the parameter needs a new plan.
    pub fn needs_plan(&self, control: Control) -> bool {
        self.values.needs_plan(control)
    }
}
