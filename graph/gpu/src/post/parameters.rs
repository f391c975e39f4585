//! Parameters that the host changes while a plan renders.

use std::collections::BTreeSet;

use afterimage_graph::check::{Graph, ParameterId};
use afterimage_graph::value::{ParamType, Value};

use super::handle::{Control, Handle, Parameter, ParameterInfo};
use super::{Post, PostError};

impl Post {
    /// All parameters of the graph.
    pub fn parameters(&self) -> impl Iterator<Item = ParameterInfo<'_>> {
        self.graph().parameters().map(|id| ParameterInfo {
            name: self.graph().parameter_name(id),
            declaration: self.graph().declaration(id),
            value: self.graph().value(id),
        })
    }

    /// The values that the host has set for parameters of the present graph, by their names, `node.parameter`.
    pub fn set_values(&self) -> impl Iterator<Item = (&str, &Value)> {
        let handles = self.handles.iter().filter(|handle| handle.value.is_some());
        handles.filter_map(|handle| Some((handle.name.as_str(), self.graph().value(handle.place?))))
    }

    /// A handle to the parameter that `node.parameter` names.
    ///
    /// The parameter is dynamic from the next plan on: its node runs also where its value changes nothing, so that new
    /// values need no plan. Where a change [needs a plan](Self::needs_plan), each does.
    ///
    /// # Errors
    /// There is no such parameter, or it has another type.
    pub fn parameter<T: ParamType>(&mut self, name: &str) -> Result<Parameter<T>, PostError> {
        let place = self.graph().parameter(name).map_err(PostError::UnknownParameter)?;
        let ty = self.graph().declaration(place).ty;
        if ty != T::TYPE {
            return Err(PostError::WrongType { name: name.to_owned(), ty: ty.describe() });
        }
        Ok(Parameter::new(self.control(name)?))
    }

    /// The same for a parameter of any type.
    ///
    /// # Errors
    /// There is no such parameter.
    pub fn control(&mut self, name: &str) -> Result<Control, PostError> {
        let place = self.graph().parameter(name).map_err(PostError::UnknownParameter)?;
        if let Some(known) = self.handles.iter().position(|handle| handle.place == Some(place)) {
            return Ok(Control(known));
        }
        let (ty, written) = (self.graph().declaration(place).ty, Some(self.graph().value(place).clone()));
        self.handles.push(Handle { name: name.to_owned(), ty, value: None, written, place: Some(place) });
        self.is_stale = true;
        Ok(Control(self.handles.len() - 1))
    }

    /// Sets a value, from the next frame on; in the background if it needs a new plan. While the present graph has no
    /// such parameter, the value is kept for the next one.
    ///
    /// # Errors
    /// It is outside of the domain, or does not go with other values of the node, which then keeps the old one.
    pub fn set<T: ParamType>(&mut self, parameter: Parameter<T>, value: T) -> Result<(), PostError> {
        self.set_value(parameter.control, value.into_value())
    }

    /// The same for a parameter of any type.
    ///
    /// # Errors
    /// As [`set`](Self::set); also if the value has another type.
    pub fn set_value(&mut self, control: Control, value: Value) -> Result<(), PostError> {
        let handle = &mut self.handles[control.0];
        if let Some(place) = handle.place {
            let refused = |why| PostError::Refused { name: handle.name.clone(), why };
            let is_new = *self.plans.graph().value(place) != value;
            if is_new && self.plans.set(place, value.clone()).map_err(refused)? {
                self.is_stale = true;
                self.age.values += 1;
            } else if is_new {
                if let Some(running) = self.running.as_mut().filter(|running| running.graph == self.age.graph) {
                    running.uniforms.change(place.node);
                }
                self.fade.change(place.node, self.age.graph);
                if let Some(next) = self.next.as_mut().filter(|next| !next.changed.contains(&place.node)) {
                    next.changed.push(place.node);
                }
            }
        }
        handle.value = Some(value);
        Ok(())
    }

    /// The present value of a parameter: that of the graph, or the last that was set while the graph has none.
    pub fn value(&self, control: Control) -> Option<&Value> {
        let handle = &self.handles[control.0];
        handle.place.map(|place| self.graph().value(place)).or(handle.value.as_ref())
    }

    /// Takes back what the host has set: the value of the graph holds again, also in the next one.
    ///
    /// # Errors
    /// As [`set`](Self::set).
    pub fn unset(&mut self, control: Control) -> Result<(), PostError> {
        if let Some(written) = self.handles[control.0].written.clone() {
            self.set_value(control, written)?;
        }
        self.handles[control.0].value = None;
        Ok(())
    }

    /// Whether a change of the parameter needs a new plan.
    pub fn needs_plan(&self, control: Control) -> bool {
        self.handles[control.0].place.is_some_and(|place| self.graph().declaration(place).replan)
    }

    /// The parameters with handles whose changes need no plan.
    pub(super) fn dynamic(&self) -> impl Iterator<Item = ParameterId> + '_ {
        let places = self.handles.iter().filter_map(|handle| handle.place);
        places.filter(|place| !self.graph().declaration(*place).replan)
    }

    /// Takes the values of a graph that differs from the present one in values of dynamic parameters alone. Returns
    /// whether it does; otherwise some may be taken, and the graph is to be replaced.
    pub(super) fn take_values(&mut self, graph: &Graph) -> bool {
        if !self.graph().has_structure_of(graph) {
            return false;
        }
        let dynamic: BTreeSet<ParameterId> = self.dynamic().collect();
        let is_same = |id: &ParameterId| self.graph().value(*id) == graph.value(*id);
        if !graph.parameters().filter(|id| !dynamic.contains(id)).all(|id| is_same(&id)) {
            return false;
        }
        for control in (0..self.handles.len()).map(Control) {
            let handle = &mut self.handles[control.0];
            let Some(written) = handle.place.map(|place| graph.value(place).clone()) else { continue };
            handle.written = Some(written.clone());
            if handle.value.is_none() {
                if self.set_value(control, written).is_err() {
                    return false;
                }
                self.handles[control.0].value = None;
            }
        }
        true
    }

    /// Finds the parameters of all handles in a new graph, and sets what the host has set.
    pub(super) fn place_handles(&mut self) {
        let graph = self.plans.shared_graph();
        for handle in &mut self.handles {
            handle.place = handle.place_in(&graph);
            handle.written = handle.place.map(|place| graph.value(place).clone());
            if let (Some(place), Some(value)) = (handle.place, &handle.value) {
                // What this graph does not accept keeps the value of its file.
                let _ = self.plans.set(place, value.clone());
            }
        }
    }
}
