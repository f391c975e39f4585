//! `Pipeline.plan`: what a pipeline does on a GPU.

use afterimage_graph::check::{Facts, Graph};
use afterimage_graph::image::{Format, ImageDesc, Size};
use afterimage_plan::{Caps, HostImageDesc, HostInputs, Options, Plan, PlanRequest, Requirement, plan};
use pyo3::prelude::*;

use crate::error::Failure;

/// A plan for a typical device and half-float images, as the program's `plan` prints it.
#[pyclass(frozen, name = "Plan", module = "afterimage")]
pub(crate) struct PlanView {
    plan: Plan,
}

impl PlanView {
    pub(crate) fn new(graph: &Graph, facts: Facts, size: Size) -> Result<Self, Failure> {
        let image = HostImageDesc { desc: ImageDesc::new(size), finite: false };
        let request = PlanRequest {
            given: HostInputs::all(size, graph.inputs.iter().filter(|input| !input.optional), image),
            facts,
            caps: Caps { storage: Format::ALL.into(), max_side: 16384, ..Caps::default() },
            options: Options::default(),
            dynamic: Default::default(),
            requirement: &Requirement::typical,
        };
        Ok(Self { plan: plan(graph, &request)? })
    }
}

#[pymethods]
impl PlanView {
    /// Passes, batches, barriers and memory as text.
    fn text(&self) -> String {
        self.plan.to_text()
    }

    /// The same as JSON.
    fn json(&self) -> String {
        self.plan.to_json()
    }

    /// The same as a drawing.
    fn svg(&self) -> String {
        self.plan.to_svg()
    }

    fn _repr_html_(&self) -> String {
        self.plan.to_svg()
    }

    fn __repr__(&self) -> String {
        self.plan.to_text()
    }
}
