//! A pipeline with its device.

use std::path::PathBuf;
use std::sync::{Mutex, MutexGuard, PoisonError};

use afterimage::Source;
use afterimage::host::TierLimits;
use afterimage::offline::{Offline, OfflineFrame};
use afterimage_graph::check::Fact;
use afterimage_graph::diagnostic::Style;
use afterimage_graph::document::Claim;
use afterimage_graph::image::Size;
use afterimage_graph::node::CAMERA;
use afterimage_graph::value::Value;
use afterimage_pipelines::PIPELINES;
use pyo3::prelude::*;
use serde_json::json;

use crate::error::Failure;
use crate::frame::{GivenArray, GivenCamera, Moment, PythonImage, encoding, into_python};
use crate::measure;
use crate::plan::PlanView;
use crate::value::{declaration, to_python, to_text};

/// The names and the texts of the built-in pipelines.
#[pyfunction]
pub(crate) fn built_in() -> Vec<(&'static str, &'static str)> {
    PIPELINES.to_vec()
}

/// A pipeline. The Python class of this name holds it.
#[pyclass(frozen, module = "afterimage._native")]
pub(crate) struct Pipeline {
    look: Mutex<Offline>,
}

/// Options of opening a pipeline.
#[derive(FromPyObject)]
pub(crate) struct Opening {
    #[pyo3(item)]
    tier: Option<String>,
    /// A fact is a number, or a flag if the last member is true.
    #[pyo3(item)]
    facts: Vec<(String, f64, bool)>,
    #[pyo3(item)]
    outputs: Vec<String>,
    #[pyo3(item)]
    encoding: Option<String>,
    #[pyo3(item)]
    dither: bool,
    #[pyo3(item)]
    adapter: Option<String>,
    /// Folders of node kinds.
    #[pyo3(item)]
    nodes: Vec<PathBuf>,
    /// Folders whose files the pipeline may name.
    #[pyo3(item)]
    allow: Vec<PathBuf>,
}

impl Opening {
    /// Opens a text with `Pipeline(`, the built-in pipeline of a name, or the file of a path.
    fn open(self, source: &str) -> Result<Offline, Failure> {
        let mut from = if source.contains("Pipeline(") { Source::text("<text>", source) } else { Source::from(source) };
        from = self.nodes.into_iter().fold(from, Source::folder);
        from = self.allow.into_iter().fold(from, Source::allow);
        if let Some(tier) = self.tier {
            from = from.tier(tier);
        }
        let mut look = Offline::open(from)?;
        look.set_outputs(self.outputs)?;
        look.set_encoding(encoding(self.encoding.as_deref())?);
        look.set_dither(self.dither);
        look.set_adapter(self.adapter);
        self.facts.iter().try_for_each(|(name, number, is_flag)| look.set_fact(name, fact(*number, *is_flag)))?;
        Ok(look)
    }
}

fn fact(number: f64, is_flag: bool) -> Fact {
    if is_flag { Fact::Flag(number != 0.0) } else { Fact::Number(number) }
}

#[pymethods]
impl Pipeline {
    /// Opens a pipeline; no device is needed yet.
    #[new]
    fn new(py: Python<'_>, source: &str, opening: Opening) -> PyResult<Self> {
        let look = py.detach(|| opening.open(source))?;
        Ok(Self { look: Mutex::new(look) })
    }

    /// The warnings about the pipeline as it is, as one text.
    fn warnings(&self, py: Python<'_>) -> PyResult<String> {
        let warnings = py.detach(|| self.look().warnings()).map_err(Failure::from)?;
        Ok(if warnings.is_empty() { String::new() } else { warnings.render(Style::Plain) })
    }

    /// The name, the tier, all tiers, inputs and outputs as JSON.
    fn describe(&self, py: Python<'_>) -> String {
        py.detach(|| describe(&self.look()).to_string())
    }

    /// The declarations of all parameters as JSON.
    fn parameters(&self, py: Python<'_>) -> String {
        py.detach(|| {
            let look = self.look();
            let all: Vec<_> = look.graph().parameters().map(|id| declaration(look.graph(), id)).collect();
            json!(all).to_string()
        })
    }

    /// The value of a parameter, or whether a node is on.
    fn get(&self, py: Python<'_>, name: &str) -> PyResult<Py<PyAny>> {
        let graph = py.detach(|| self.look().graph().clone());
        if let Some((_, node)) = graph.node(name) {
            return to_python(py, &Value::Bool(!node.off));
        }
        let id = graph.parameter(name).map_err(Failure::Parameter)?;
        to_python(py, graph.value(id))
    }

    /// Sets a parameter, or switches a node.
    fn set(&self, py: Python<'_>, name: &str, value: &Bound<'_, PyAny>) -> PyResult<()> {
        let ty = py.detach(|| {
            let look = self.look();
            Some(look.graph().declaration(look.graph().parameter(name).ok()?).ty)
        });
        let text = to_text(value, ty)?;
        Ok(py.detach(|| self.look().set(name, &text)).map_err(Failure::from)?)
    }

    /// Makes a parameter or a node what it is in the file again.
    fn unset(&self, py: Python<'_>, name: &str) -> PyResult<()> {
        Ok(py.detach(|| self.look().unset(name)).map_err(Failure::from)?)
    }

    /// Changes the tier; `None` is the pipeline as it is written.
    fn set_tier(&self, py: Python<'_>, tier: Option<&str>) -> PyResult<()> {
        Ok(py.detach(|| self.look().set_tier(tier)).map_err(Failure::from)?)
    }

    /// Holds limits; without milliseconds, keeps the present tier from now on.
    fn govern(
        &self,
        py: Python<'_>,
        ms: Option<f64>,
        tiers: Vec<String>,
        min_jod: Option<f64>,
        display: Option<String>,
    ) -> PyResult<()> {
        let Some(ms) = ms else {
            py.detach(|| self.look().stop_governing());
            return Ok(());
        };
        let tiers: Vec<&str> = tiers.iter().map(String::as_str).collect();
        let limits = TierLimits { ms, min_jod, display };
        Ok(py.detach(|| self.look().govern(limits, &tiers)).map_err(Failure::from)?)
    }

    /// Reports the time of the last frame. Returns the reason of the change that the next one has.
    fn report_frame_time(&self, py: Python<'_>, ms: f64, dt: f64) -> PyResult<Option<String>> {
        let change = py.detach(|| self.look().report_frame_time(ms, dt)).map_err(Failure::from)?;
        Ok(change.map(|change| change.to_string()))
    }

    /// The reason why the limits are not held at present.
    fn shortfall(&self, py: Python<'_>) -> Option<String> {
        py.detach(|| self.look().governor()?.shortfall().map(|shortfall| shortfall.to_string()))
    }

    /// States a fact.
    fn set_fact(&self, py: Python<'_>, name: &str, number: f64, is_flag: bool) -> PyResult<()> {
        Ok(py.detach(|| self.look().set_fact(name, fact(number, is_flag))).map_err(Failure::from)?)
    }

    /// Renders a frame. The interpreter is free for other threads until it is done.
    #[expect(clippy::type_complexity, reason = "a tuple for the Python half")]
    fn render<'py>(
        &self,
        py: Python<'py>,
        images: Vec<GivenArray<'py>>,
        cameras: Vec<GivenCamera>,
        size: (u32, u32),
        moment: Moment,
        values: Vec<String>,
    ) -> PyResult<(Vec<PythonImage<'py>>, Vec<Option<[f32; 4]>>)> {
        let images = images.iter().map(GivenArray::given).collect::<PyResult<Vec<_>>>()?;
        let cameras: Vec<_> = cameras.iter().map(GivenCamera::camera).collect();
        let values: Vec<&str> = values.iter().map(String::as_str).collect();
        let frame = OfflineFrame {
            images: &images,
            cameras: &cameras,
            size: Size::new(size.0, size.1),
            number: moment.number,
            step: moment.step(),
            values: &values,
        };
        let rendered = py.detach(|| self.look().render(&frame)).map_err(Failure::from)?;
        let outputs = rendered.outputs.into_iter().map(|output| into_python(py, output)).collect::<PyResult<_>>()?;
        Ok((outputs, rendered.values))
    }

    /// The plan for images of a size on a typical device.
    fn plan(&self, py: Python<'_>, size: (u32, u32)) -> PyResult<PlanView> {
        Ok(py.detach(|| {
            let look = self.look();
            PlanView::new(look.graph(), look.facts().clone(), Size::new(size.0, size.1))
        })?)
    }

    /// The report of `afterimage measure --json` on image files.
    fn measure(&self, py: Python<'_>, images: Vec<String>, tiers_only: bool, frames: u32) -> PyResult<String> {
        Ok(py.detach(|| measure::report(&self.look(), images, tiers_only, frames))?)
    }

    /// The name of the graphics adapter.
    fn adapter(&self, py: Python<'_>) -> PyResult<String> {
        Ok(py.detach(|| self.look().gpu()).map_err(Failure::from)?.name())
    }
}

impl Pipeline {
    /// The present state. Nobody who has it waits for the interpreter.
    fn look(&self) -> MutexGuard<'_, Offline> {
        self.look.lock().unwrap_or_else(PoisonError::into_inner)
    }
}

fn describe(look: &Offline) -> serde_json::Value {
    let inputs = look.graph().inputs.iter().map(|input| {
        json!({
            "name": input.name,
            "camera": input.block.is_some_and(|block| *block == CAMERA),
            "block": input.block.is_some(),
            "state": input.state.name(),
            "channels": input.min_channels,
            "optional": input.optional,
            "volume": input.volume,
            "multisampled": input.multisampled,
        })
    });
    let tiers = look.tiers().into_iter().map(|tier| {
        let claim = look.claim(&tier);
        let claim = claim.map(|Claim { on, ms, jod, p999, flip, display }| {
            json!({ "on": on, "ms": ms, "jod": jod, "p999": p999, "flip": flip, "display": display })
        });
        json!({ "name": tier, "claim": claim })
    });
    let outputs = look.outputs().map(|output| json!({ "name": output.name, "state": output.state.name() }));
    let facts: Vec<String> = look.graph().facts().into_iter().map(|(name, _)| name).collect();
    json!({
        "name": look.name(),
        "tier": look.tier(),
        "tiers": tiers.collect::<Vec<_>>(),
        "facts": facts,
        "inputs": inputs.collect::<Vec<_>>(),
        "outputs": outputs.collect::<Vec<_>>(),
    })
}
