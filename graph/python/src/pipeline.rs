//! A pipeline with its device.

use std::sync::{Mutex, MutexGuard, PoisonError};

use afterimage_gpu::{FrameStep, Gpu, Opening, Session};
use afterimage_graph::check::{Checker, Facts, Graph, GraphOutput};
use afterimage_graph::color::Transfer;
use afterimage_graph::diagnostic::{Diagnostics, Style, did_you_mean};
use afterimage_graph::image::{ColorState, Size};
use afterimage_graph::node::{CAMERA, Camera, Registry};
use afterimage_lab::quantize::{EncodedFile, Noise, unquantized};
use afterimage_plan::Options;
use pyo3::prelude::*;
use serde_json::json;

use crate::error::Failure;
use crate::frame::{Color, Encoding, Given, GivenArray, GivenCamera, Moment, Rendered, Rounding};
use crate::measure::{self, Measured};
use crate::plan::PlanView;
use crate::source::Source;
use crate::value::{declaration, to_python, to_text};

/// The device that all pipelines share, and the name by which it was asked for.
static GPU: Mutex<Option<(Option<String>, Gpu)>> = Mutex::new(None);

/// The outputs of a frame, and the values that were asked for.
type Frame = (Vec<Rendered>, Vec<Option<[f32; 4]>>);

/// A pipeline. The Python class of this name holds it.
#[pyclass(frozen, module = "afterimage._native")]
pub(crate) struct Pipeline {
    look: Mutex<Look>,
}

/// What a pipeline is at present.
struct Look {
    source: Source,
    registry: Registry,
    tier: Option<String>,
    /// Changed parameters and switched nodes, in the order in which they were changed.
    sets: Vec<(String, String)>,
    facts: Facts,
    /// The outputs that are rendered; all of them if there are none.
    outputs: Vec<String>,
    encoding: Encoding,
    dither: bool,
    adapter: Option<String>,
    /// The graph as it is written, with the changes.
    graph: Graph,
    /// The session that renders it, once there was a frame since the last change, and the noise of its codes.
    session: Option<Session>,
    noise: Noise,
    is_changed: bool,
}

#[pymethods]
impl Pipeline {
    /// Opens a pipeline; no device is needed yet. A fact is a number, or a flag if the last member is true.
    #[new]
    #[expect(clippy::too_many_arguments, reason = "the Python half names them")]
    fn new(
        py: Python<'_>,
        source: &str,
        tier: Option<String>,
        facts: Vec<(String, f64, bool)>,
        outputs: Vec<String>,
        encoding: Option<&str>,
        dither: bool,
        adapter: Option<String>,
    ) -> PyResult<Self> {
        let encoding = Encoding::of(encoding)?;
        let look = py.detach(|| {
            let source = Source::open(source)?;
            let registry = Registry::new(&[afterimage_nodes::ALL]).expect("the built-in kinds have different names");
            let (graph, _) = check(&source, &registry, tier.as_deref(), &[])?;
            let mut look = Look {
                source,
                registry,
                tier,
                sets: Vec::new(),
                facts: Facts::default(),
                outputs,
                encoding,
                dither,
                adapter,
                graph,
                session: None,
                noise: Noise::default(),
                is_changed: false,
            };
            look.check_outputs()?;
            facts.into_iter().try_for_each(|(name, number, is_flag)| look.set_fact(name, number, is_flag))?;
            Ok::<_, Failure>(look)
        })?;
        Ok(Self { look: Mutex::new(look) })
    }

    /// The warnings about the pipeline as it is, as one text.
    fn warnings(&self, py: Python<'_>) -> PyResult<String> {
        let warnings = py.detach(|| self.look().check().map(|(_, warnings)| warnings))?;
        Ok(if warnings.is_empty() { String::new() } else { warnings.render(Style::Plain) })
    }

    /// The name, the tier, all tiers, inputs and outputs as JSON.
    fn describe(&self, py: Python<'_>) -> String {
        py.detach(|| self.look().describe().to_string())
    }

    /// The declarations of all parameters as JSON.
    fn parameters(&self, py: Python<'_>) -> String {
        py.detach(|| {
            let look = self.look();
            let all: Vec<_> = look.graph.parameters().map(|id| declaration(&look.graph, id)).collect();
            json!(all).to_string()
        })
    }

    /// The value of a parameter, or whether a node is on.
    fn get(&self, py: Python<'_>, name: &str) -> PyResult<Py<PyAny>> {
        let graph = py.detach(|| self.look().graph.clone());
        if let Some((_, node)) = graph.node(name) {
            return to_python(py, &afterimage_graph::value::Value::Bool(!node.off));
        }
        let id = graph.parameter(name).map_err(Failure::Parameter)?;
        to_python(py, graph.value(id))
    }

    /// Sets a parameter, or switches a node.
    fn set(&self, py: Python<'_>, name: &str, value: &Bound<'_, PyAny>) -> PyResult<()> {
        let ty = py.detach(|| {
            let look = self.look();
            Some(look.graph.declaration(look.graph.parameter(name).ok()?).ty)
        });
        let text = to_text(value, ty)?;
        Ok(py.detach(|| self.look().set(name, text))?)
    }

    /// Makes a parameter or a node what it is in the file again.
    fn unset(&self, py: Python<'_>, name: &str) -> PyResult<()> {
        Ok(py.detach(|| {
            let mut look = self.look();
            let sets = look.sets.iter().filter(|(known, _)| known != name).cloned().collect();
            look.change(None, Some(sets))
        })?)
    }

    /// Changes the tier; `None` is the pipeline as it is written.
    fn set_tier(&self, py: Python<'_>, tier: Option<String>) -> PyResult<()> {
        Ok(py.detach(|| self.look().change(Some(tier), None))?)
    }

    /// States a fact.
    fn set_fact(&self, py: Python<'_>, name: String, number: f64, is_flag: bool) -> PyResult<()> {
        Ok(py.detach(|| self.look().set_fact(name, number, is_flag))?)
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
    ) -> PyResult<(
        Vec<(String, Bound<'py, PyAny>, Vec<usize>, &'static str, &'static str, Color)>,
        Vec<Option<[f32; 4]>>,
    )> {
        let given = images.iter().map(GivenArray::given).collect::<PyResult<Vec<_>>>()?;
        let cameras: Vec<_> = cameras.into_iter().map(GivenCamera::into_camera).collect();
        let (outputs, values) = py.detach(|| self.look().render(&given, cameras, size, &moment, &values))?;
        let outputs = outputs.into_iter().map(|output| output.into_python(py)).collect::<PyResult<_>>()?;
        Ok((outputs, values))
    }

    /// The plan for images of a size on a typical device.
    fn plan(&self, py: Python<'_>, size: (u32, u32)) -> PyResult<PlanView> {
        Ok(py.detach(|| {
            let look = self.look();
            PlanView::new(&look.graph, look.facts.clone(), Size::new(size.0, size.1))
        })?)
    }

    /// The report of `afterimage measure --json` on image files.
    fn measure(&self, py: Python<'_>, images: Vec<String>, tiers_only: bool, frames: u32) -> PyResult<String> {
        Ok(py.detach(|| self.look().measure(images, tiers_only, frames))?)
    }

    /// The name of the graphics adapter.
    fn adapter(&self, py: Python<'_>) -> PyResult<String> {
        Ok(py.detach(|| Ok::<_, Failure>(open(self.look().adapter.as_deref())?.name()))?)
    }
}

impl Pipeline {
    /// The present state. Nobody who has it waits for the interpreter.
    fn look(&self) -> MutexGuard<'_, Look> {
        self.look.lock().unwrap_or_else(PoisonError::into_inner)
    }
}

impl Look {
    fn check(&self) -> Result<(Graph, Diagnostics), Failure> {
        check(&self.source, &self.registry, self.tier.as_deref(), &self.sets)
    }

    /// Takes another tier or other parameters, unless the check refuses them.
    fn change(&mut self, tier: Option<Option<String>>, sets: Option<Vec<(String, String)>>) -> Result<(), Failure> {
        let tier = tier.unwrap_or_else(|| self.tier.clone());
        let sets = sets.unwrap_or_else(|| self.sets.clone());
        let (graph, _) = check(&self.source, &self.registry, tier.as_deref(), &sets)?;
        (self.graph, self.tier, self.sets, self.is_changed) = (graph, tier, sets, true);
        Ok(())
    }

    fn set(&mut self, name: &str, text: String) -> Result<(), Failure> {
        let mut sets: Vec<_> = self.sets.iter().filter(|(known, _)| known != name).cloned().collect();
        sets.push((name.to_owned(), text));
        self.change(None, Some(sets))
    }

    fn set_fact(&mut self, name: String, number: f64, is_flag: bool) -> Result<(), Failure> {
        let known = self.graph.facts();
        if !known.iter().any(|(known, _)| *known == name) {
            let names: Vec<&str> = known.iter().map(|(name, _)| name.as_str()).collect();
            let meant = did_you_mean(&name, names.iter().copied()).unwrap_or_else(|| "it uses none".to_owned());
            return Err(Failure::Parameter(format!("no `when` of this pipeline uses the fact `{name}`: {meant}")));
        }
        match is_flag {
            true => self.facts.set(name, number != 0.0),
            false => self.facts.set(name, number),
        }
        if let Some(session) = &mut self.session {
            session.post().set_facts(self.facts.clone());
        }
        Ok(())
    }

    /// Refuses outputs that the pipeline does not have.
    fn check_outputs(&self) -> Result<(), Failure> {
        let known: Vec<&str> = self.graph.outputs.iter().map(|output| output.name.as_str()).collect();
        match self.outputs.iter().find(|name| !known.contains(&name.as_str())) {
            None => Ok(()),
            Some(name) => {
                let known = known.join("`, `");
                Err(Failure::Parameter(format!("the pipeline has no output `{name}`; it has `{known}`")))
            }
        }
    }

    fn renders(&self, output: &GraphOutput) -> bool {
        self.outputs.is_empty() || self.outputs.contains(&output.name)
    }

    fn describe(&self) -> serde_json::Value {
        let checker = Checker::new(&self.source.document, &self.registry, &self.source.files);
        let inputs = self.graph.inputs.iter().map(|input| {
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
        let outputs = self.graph.outputs.iter().filter(|output| self.renders(output));
        let outputs = outputs.map(|output| json!({ "name": output.name, "state": output.state.name() }));
        let facts: Vec<String> = self.graph.facts().into_iter().map(|(name, _)| name).collect();
        json!({
            "name": self.source.name,
            "tier": self.tier,
            "tiers": checker.tiers(),
            "facts": facts,
            "inputs": inputs.collect::<Vec<_>>(),
            "outputs": outputs.collect::<Vec<_>>(),
        })
    }

    /// The bits of an output for a display; `None` for linear light and data.
    fn bits(&self, output: &GraphOutput) -> Option<u32> {
        let color = self.graph.colors().at(output.source);
        let is_hdr = color.is_some_and(|color| matches!(color.colorimetry.transfer, Transfer::Pq | Transfer::Hlg));
        (output.state == ColorState::Encoded).then(|| self.encoding.bits(is_hdr))
    }

    /// Makes the session render the graph as it is: the outputs that are wanted, rounded here and not by the pipeline.
    fn prepare(&mut self) -> Result<&mut Session, Failure> {
        let is_current = self.session.is_some() && !self.is_changed;
        if !is_current {
            let mut graph = self.graph.clone();
            graph.outputs.retain(|output| self.renders(output));
            let files = graph.outputs.iter().filter_map(|output| {
                let bits = self.bits(output)?;
                Some(EncodedFile { source: output.source, bits })
            });
            let files: Vec<EncodedFile> = files.collect();
            let rounded_here = unquantized(graph, &files, true);
            self.noise = rounded_here.noise;
            match &mut self.session {
                Some(session) => session.change(rounded_here.graph, Options::default()),
                None => {
                    let gpu = open(self.adapter.as_deref())?;
                    let facts = self.facts.clone();
                    self.session = Some(Session::new(&gpu, rounded_here.graph, facts, Options::default()));
                }
            }
            self.is_changed = false;
        }
        Ok(self.session.as_mut().expect("there is a session by now"))
    }

    fn render(
        &mut self,
        images: &[Given<'_>],
        cameras: Vec<(String, Camera)>,
        size: (u32, u32),
        moment: &Moment,
        values: &[String],
    ) -> Result<Frame, Failure> {
        let rendered = self.try_render(images, cameras, size, moment, values);
        if let Err(Failure::Device(_)) = &rendered {
            // The next frame opens a device again.
            self.session = None;
            *GPU.lock().unwrap_or_else(PoisonError::into_inner) = None;
        }
        rendered
    }

    fn try_render(
        &mut self,
        images: &[Given<'_>],
        cameras: Vec<(String, Camera)>,
        size: (u32, u32),
        moment: &Moment,
        values: &[String],
    ) -> Result<Frame, Failure> {
        let labels = values.iter().map(|name| self.label(name)).collect::<Result<Vec<_>, _>>()?;
        let session = self.prepare()?;
        for (name, camera) in cameras {
            let block = camera.data().map_err(|why| Failure::Image(format!("the camera `{name}`: {why}")))?;
            session.set_block(&name, block);
        }
        let mut fed = Vec::new();
        for Given { input, desc, bytes } in images {
            session.gpu().check_fits(*desc)?;
            fed.push(session.feed(input, *desc, bytes)?);
        }
        let first = fed.iter().find(|image| !image.desc.volume);
        let size = first.map_or(Size::new(size.0, size.1), |image| image.desc.size);
        session.number_next(moment.number);
        session.render(size, &fed, FrameStep { time: moment.time, dt: moment.dt, reset: moment.reset })?;
        let mut outputs = Vec::new();
        for output in session.plan().outputs.clone() {
            let texels = session.output(&output.name)?;
            outputs.push((output, texels));
        }
        let mut read = Vec::new();
        for label in &labels {
            read.push(session.value(label)?);
        }
        let outputs = outputs.into_iter().map(|(output, texels)| {
            let declared = self.graph.outputs.iter().find(|known| known.name == output.name);
            let rounding = declared.and_then(|declared| {
                let dither = self.dither.then(|| self.noise.seed(moment.number));
                Some(Rounding { bits: self.bits(declared)?, dither, keeps_alpha: declared.has_coverage })
            });
            Rendered::of(output, texels, self.encoding, rounding.as_ref())
        });
        Ok((outputs.collect::<Result<_, _>>()?, read))
    }

    /// `node.port` of a value; `result` is the port of a bare node.
    fn label(&self, name: &str) -> Result<String, Failure> {
        let (node, port) = name.rsplit_once('.').unwrap_or((name, "result"));
        let Some((_, found)) = self.graph.node(node) else {
            let names = self.graph.nodes.iter().map(|node| node.name.as_str());
            let meant = did_you_mean(node, names).map_or(String::new(), |meant| format!(": {meant}"));
            return Err(Failure::Parameter(format!("no node is called `{node}`{meant}")));
        };
        let ports: Vec<&str> = found.kind().outputs().iter().map(|output| &*output.name).collect();
        match ports.contains(&port) {
            true => Ok(format!("{node}.{port}")),
            false => {
                Err(Failure::Parameter(format!("`{node}` has no output `{port}`; it has `{}`", ports.join("`, `"))))
            }
        }
    }

    fn measure(&self, images: Vec<String>, tiers_only: bool, frames: u32) -> Result<String, Failure> {
        let checker = Checker::new(&self.source.document, &self.registry, &self.source.files);
        let mut tiers = Vec::new();
        for tier in checker.tiers() {
            let (graph, _) = checker.check(Some(&tier), &self.sets)?;
            tiers.push((tier, graph));
        }
        let measured = Measured {
            name: self.source.name.clone(),
            graph: self.graph.clone(),
            tier: self.tier.clone(),
            tiers,
            facts: self.facts.clone(),
        };
        measure::report(&open(self.adapter.as_deref())?, &self.registry, measured, images, tiers_only, frames)
    }
}

fn check(
    source: &Source,
    registry: &Registry,
    tier: Option<&str>,
    sets: &[(String, String)],
) -> Result<(Graph, Diagnostics), Failure> {
    Ok(Checker::new(&source.document, registry, &source.files).check(tier, sets)?)
}

/// The device of that name, opened once.
fn open(adapter: Option<&str>) -> Result<Gpu, Failure> {
    let mut known = GPU.lock().unwrap_or_else(PoisonError::into_inner);
    if let Some((_, gpu)) = known.as_ref().filter(|(name, _)| name.as_deref() == adapter) {
        return Ok(gpu.clone());
    }
    let mut gpu = Gpu::open(&Opening { adapter: adapter.map(str::to_owned), validation: false })?;
    // As the program does: lavapipe runs draws faster.
    gpu.caps.prefer_fragment = gpu.is_processor();
    *known = Some((adapter.map(str::to_owned), gpu.clone()));
    Ok(gpu)
}
