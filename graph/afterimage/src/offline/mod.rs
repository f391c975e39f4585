//! Pipelines without a renderer: images in the memory of the processor come in, and others go out.
//!
//! ```no_run
//! use afterimage::host::{ImageDesc, Size};
//! use afterimage::offline::{OfflineImage, Offline, OfflineFrame};
//!
//! # fn run(halves: &[u8]) -> Result<(), afterimage::Error> {
//! let mut look = Offline::open("tsushima")?;
//! look.set_tier(Some("low"))?;
//! look.set("lit.strength", "0.02")?;
//! // Four half floats for each pixel, linear Rec.709.
//! let scene = OfflineImage { input: "scene", desc: ImageDesc::new(Size::new(1920, 1080)), bytes: halves };
//! let rendered = look.render(&OfflineFrame { images: &[scene], values: &["metered"], ..OfflineFrame::default() })?;
//! let codes: &[u8] = rendered.outputs[0].data.bytes();
//! # let _ = codes;
//! # Ok(())
//! # }
//! ```

mod device;
mod govern;
mod pixel_data;
#[doc(hidden)] // For the program.
pub mod quantize;

use afterimage_gpu::{FrameStep, Gpu};
use afterimage_graph::check::{Fact, Facts, Graph, GraphOutput};
use afterimage_graph::color::Transfer;
use afterimage_graph::diagnostic::{Diagnostics, did_you_mean};
use afterimage_graph::document::Claim;
use afterimage_graph::image::{ColorState, ImageDesc, Size};
use afterimage_graph::node::{Camera, Registry};
use afterimage_plan::Options;

pub use pixel_data::{ComponentType, Encoding, PixelData, RenderedImage, format_of};

use crate::error::Error;
use crate::governor::Governor;
#[doc(hidden)] // For the program, measurements and tests.
pub use crate::session::faults::LutErrors;
#[doc(hidden)] // For the program, measurements and tests.
pub use crate::session::{FrameInputs, Session, faults, metering, timing};
use crate::snapshot::{Snapshot, files_of};
use crate::source::Source;
use pixel_data::Rounding;
use quantize::{EncodedFile, Noise, unquantized};

/// A pipeline that renders images in the memory of the processor, with the pixels that the program has in a sequence,
/// bit for bit. One image alone has no baked LUTs there: see [`Options::one_frame`].
///
/// No device is opened before the first frame. All pipelines of a process share it; after it is lost, the next frame
/// opens another one.
pub struct Offline {
    name: String,
    snapshot: Snapshot,
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
    governor: Option<Governor>,
}

/// An image for an input.
#[derive(Clone, Copy, Debug)]
pub struct OfflineImage<'a> {
    /// The name of the input.
    pub input: &'a str,
    /// Size and format.
    pub desc: ImageDesc,
    /// The texels, row by row without gaps.
    pub bytes: &'a [u8],
}

/// A frame to render.
#[derive(Clone, Copy, Debug)]
pub struct OfflineFrame<'a> {
    /// The images of the inputs.
    pub images: &'a [OfflineImage<'a>],
    /// The cameras of inputs.
    pub cameras: &'a [(&'a str, Camera)],
    /// The size of the frame if there are no images; it is that of the first image otherwise.
    pub size: Size,
    /// The number of the frame, from which noise is made.
    pub number: u32,
    /// The position in time. By default the frame is a first one: nothing of earlier frames has an effect.
    pub step: FrameStep,
    /// The values to read back: `node.port`, or `node` for its port `result`.
    pub values: &'a [&'a str],
}

impl Default for OfflineFrame<'_> {
    fn default() -> Self {
        let (size, step) = (Size::new(1920, 1080), FrameStep::FIRST);
        Self { images: &[], cameras: &[], size, number: 0, step, values: &[] }
    }
}

/// The results of a frame.
pub struct Rendered {
    /// The outputs, in the order of the pipeline.
    pub outputs: Vec<RenderedImage>,
    /// Four numbers for each requested value, such as the exposure of a meter; `None` if the frame has none, as that of
    /// a node that is skipped.
    pub values: Vec<Option<[f32; 4]>>,
}

/// The size of a frame with these images: that of the first one that is no volume; `None` without any.
#[doc(hidden)] // For the program.
pub fn frame_size(mut images: impl Iterator<Item = ImageDesc>) -> Option<Size> {
    images.find(|desc| !desc.volume).map(|desc| desc.size)
}

impl Offline {
    /// Opens a pipeline: a file, the name of a built-in pipeline, or another [`Source`].
    ///
    /// # Errors
    /// As for [`Post::open`](crate::Post::open).
    pub fn open(source: impl Into<Source>) -> Result<Self, Error> {
        let source = source.into();
        let snapshot = Snapshot::read(&source, files_of(&source))?;
        let (graph, _) = snapshot.check(source.tier.as_deref(), &[])?;
        Ok(Self {
            name: source.name(),
            snapshot,
            tier: source.tier,
            sets: Vec::new(),
            facts: Facts::default(),
            outputs: Vec::new(),
            encoding: Encoding::default(),
            dither: true,
            adapter: None,
            graph,
            session: None,
            noise: Noise::default(),
            is_changed: false,
            governor: None,
        })
    }

    /// The name of the built-in pipeline, the path of the file, or the name of the text.
    pub fn name(&self) -> &str {
        &self.name
    }

    /// The checked pipeline at the present tier, with the present values.
    pub fn graph(&self) -> &Graph {
        &self.graph
    }

    /// The node kinds that the pipeline may use.
    pub fn registry(&self) -> &Registry {
        self.snapshot.registry()
    }

    /// The facts that were stated.
    pub fn facts(&self) -> &Facts {
        &self.facts
    }

    /// The present tier; `None` for the values that the file has without one.
    pub fn tier(&self) -> Option<&str> {
        self.tier.as_deref()
    }

    /// The names of the tiers, inherited ones first.
    pub fn tiers(&self) -> Vec<String> {
        self.snapshot.tiers()
    }

    /// The pipeline's claim for a tier: [`Snapshot::claim`].
    pub fn claim(&self, tier: &str) -> Option<&Claim> {
        self.snapshot.claim(tier)
    }

    /// The pipeline at another tier, with the present values.
    ///
    /// # Errors
    /// There is no such tier, or a value does not fit it.
    pub fn graph_at(&self, tier: Option<&str>) -> Result<Graph, Error> {
        Ok(self.snapshot.check(tier, &self.sets)?.0)
    }

    /// The warnings about the pipeline as it is.
    ///
    /// # Errors
    /// A file that an override names cannot be read any more.
    pub fn warnings(&self) -> Result<Diagnostics, Error> {
        Ok(self.snapshot.check(self.tier(), &self.sets)?.1)
    }

    /// The outputs that are rendered, in the order of the pipeline.
    pub fn outputs(&self) -> impl Iterator<Item = &GraphOutput> {
        self.graph.outputs.iter().filter(|output| self.renders(output))
    }

    fn renders(&self, output: &GraphOutput) -> bool {
        self.outputs.is_empty() || self.outputs.contains(&output.name)
    }

    /// Renders these outputs only; all of them without any.
    ///
    /// # Errors
    /// The pipeline has no such output; the text lists those that it has.
    pub fn set_outputs(&mut self, outputs: Vec<String>) -> Result<(), Error> {
        let known: Vec<&str> = self.graph.outputs.iter().map(|output| output.name.as_str()).collect();
        if let Some(name) = outputs.iter().find(|name| !known.contains(&name.as_str())) {
            let known = known.join("`, `");
            return Err(Error::Name(format!("the pipeline has no output `{name}`; it has `{known}`")));
        }
        (self.outputs, self.is_changed) = (outputs, true);
        Ok(())
    }

    /// Sets the components of outputs for a display.
    pub fn set_encoding(&mut self, encoding: Encoding) {
        (self.encoding, self.is_changed) = (encoding, true);
    }

    /// Switches the noise of 8-bit codes where the pipeline has a `Dither`; it is on by default.
    pub fn set_dither(&mut self, dither: bool) {
        self.dither = dither;
    }

    /// A part of the name of the graphics adapter that renders from now on.
    pub fn set_adapter(&mut self, adapter: Option<String>) {
        (self.adapter, self.session) = (adapter, None);
    }

    /// Sets `node.parameter` to a value as a pipeline file writes it, or switches a node: `On` or `Off`.
    ///
    /// # Errors
    /// There is no such parameter, or it cannot have that value. Nothing is changed.
    pub fn set(&mut self, name: &str, value: &str) -> Result<(), Error> {
        let mut sets: Vec<_> = self.sets.iter().filter(|(known, _)| known != name).cloned().collect();
        sets.push((name.to_owned(), value.to_owned()));
        self.change(self.tier.clone(), sets)
    }

    /// Makes a parameter or a node what it is in the file.
    ///
    /// # Errors
    /// Without that value, the others are wrong. Nothing is changed.
    pub fn unset(&mut self, name: &str) -> Result<(), Error> {
        let sets = self.sets.iter().filter(|(known, _)| known != name).cloned().collect();
        self.change(self.tier.clone(), sets)
    }

    /// Changes to a tier; `None` for the values that the file has without one. A [budget](Self::govern) ends.
    ///
    /// # Errors
    /// There is no such tier: the text lists those that there are. The present tier stays.
    pub fn set_tier(&mut self, tier: Option<&str>) -> Result<(), Error> {
        self.change(tier.map(str::to_owned), self.sets.clone())?;
        self.governor = None;
        Ok(())
    }

    fn change(&mut self, tier: Option<String>, sets: Vec<(String, String)>) -> Result<(), Error> {
        let (graph, _) = self.snapshot.check(tier.as_deref(), &sets)?;
        (self.graph, self.tier, self.sets, self.is_changed) = (graph, tier, sets, true);
        Ok(())
    }

    /// States a fact.
    ///
    /// # Errors
    /// No condition of the pipeline asks for it.
    pub fn set_fact(&mut self, name: &str, fact: impl Into<Fact>) -> Result<(), Error> {
        let known = self.graph.facts();
        if !known.iter().any(|(known, _)| known == name) {
            let names = known.iter().map(|(name, _)| name.as_str());
            let meant = did_you_mean(name, names).unwrap_or_else(|| "it uses none".to_owned());
            return Err(Error::Name(format!("no `when` of this pipeline uses the fact `{name}`: {meant}")));
        }
        self.facts.set(name, fact);
        if let Some(session) = &mut self.session {
            session.post().set_facts(self.facts.clone());
        }
        Ok(())
    }

    /// The device. Opens it if this has not happened.
    ///
    /// # Errors
    /// There is none, or none of that name.
    pub fn gpu(&self) -> Result<Gpu, Error> {
        Ok(device::open(self.adapter.as_deref())?)
    }

    /// Renders a frame, and waits for it.
    ///
    /// # Errors
    /// An image or a camera is missing or does not fit, no node has a value of that name, the pipeline cannot be
    /// planned at this size, or the device fails.
    pub fn render(&mut self, frame: &OfflineFrame<'_>) -> Result<Rendered, Error> {
        let rendered = self.try_render(frame);
        if rendered.as_ref().is_err_and(Error::is_of_device) {
            self.session = None;
            device::forget();
        }
        rendered
    }

    /// A value of the last frame: `node.port`, or `node` for its port `result`. `None` without a frame, and where the
    /// frame has none, as that of a node that is skipped.
    ///
    /// # Errors
    /// No node has such a value, or the device is lost.
    pub fn value(&self, name: &str) -> Result<Option<[f32; 4]>, Error> {
        let label = self.label(name)?;
        Ok(self.session.as_ref().map_or(Ok(None), |session| session.value(&label))?)
    }

    fn try_render(&mut self, frame: &OfflineFrame<'_>) -> Result<Rendered, Error> {
        let labels = frame.values.iter().map(|name| self.label(name)).collect::<Result<Vec<_>, _>>()?;
        self.check_inputs(frame)?;
        let session = self.prepare()?;
        for (name, camera) in frame.cameras {
            let block = camera.data().map_err(|why| Error::Image(format!("the camera `{name}`: {why}")))?;
            session.set_block(name, block);
        }
        let mut fed = Vec::new();
        for OfflineImage { input, desc, bytes } in frame.images {
            fed.push(session.feed(input, *desc, bytes)?);
        }
        let size = frame_size(fed.iter().map(|image| image.desc)).unwrap_or(frame.size);
        session.number_next(frame.number);
        session.render(size, &fed, frame.step)?;
        let texels = session.outputs()?;
        let values = labels.iter().map(|label| session.value(label)).collect::<Result<_, _>>()?;
        let plan = session.plan().clone();
        let outputs = plan.outputs.iter().zip(texels).map(|(output, texels)| {
            let declared = self.graph.outputs.iter().find(|known| known.name == output.name);
            let rounding = declared.and_then(|declared| {
                let dither = self.dither.then(|| self.noise.seed(frame.number));
                Some(Rounding { bits: self.bits(declared)?, dither, keeps_alpha: declared.has_coverage })
            });
            RenderedImage::of(output, texels, self.encoding, rounding.as_ref())
        });
        Ok(Rendered { outputs: outputs.collect::<Result<_, _>>()?, values })
    }

    /// Refuses a frame without an image or a camera that the pipeline needs, an image for no input, and one with other
    /// bytes than its description says.
    fn check_inputs(&self, frame: &OfflineFrame<'_>) -> Result<(), Error> {
        let images = frame.images.iter().map(|image| image.input);
        let given: Vec<&str> = images.chain(frame.cameras.iter().map(|(name, _)| *name)).collect();
        let known: Vec<&str> = self.graph.inputs.iter().map(|input| input.name.as_str()).collect();
        if let Some(name) = given.iter().find(|name| !known.contains(name)) {
            return Err(Error::Image(format!("the pipeline has no input `{name}`; it has `{}`", known.join("`, `"))));
        }
        let mut needed = self.graph.inputs.iter().filter(|input| !input.optional);
        if let Some(input) = needed.find(|input| !given.contains(&input.name.as_str())) {
            let what = if input.block.is_some() { "a camera" } else { "an image" };
            return Err(Error::Image(format!("the pipeline needs {what} for its input `{}`", input.name)));
        }
        for OfflineImage { input, desc, bytes } in frame.images {
            let wanted = desc.size.texels() * desc.format.bytes();
            if wanted != bytes.len() as u64 {
                let bytes = bytes.len();
                return Err(Error::Image(format!("`{input}` has {bytes} bytes, not the {wanted} of its size")));
            }
        }
        Ok(())
    }

    /// Makes the session render the graph as it is: the outputs that are wanted, rounded here and not by the pipeline.
    fn prepare(&mut self) -> Result<&mut Session, Error> {
        if self.session.is_none() || self.is_changed {
            let mut graph = self.graph.clone();
            graph.outputs.retain(|output| self.renders(output));
            let encoded = graph.outputs.iter().filter_map(|output| {
                let bits = self.bits(output)?;
                Some(EncodedFile { source: output.source, bits })
            });
            let encoded: Vec<EncodedFile> = encoded.collect();
            let rounded_here = unquantized(graph, &encoded, true);
            self.noise = rounded_here.noise;
            match &mut self.session {
                Some(session) => session.change(rounded_here.graph, Options::default()),
                None => {
                    let facts = self.facts.clone();
                    self.session = Some(Session::new(&self.gpu()?, rounded_here.graph, facts, Options::default()));
                }
            }
            self.is_changed = false;
        }
        Ok(self.session.as_mut().expect("there is a session by now"))
    }

    /// The bits of an output for a display; `None` for linear color and data.
    fn bits(&self, output: &GraphOutput) -> Option<u32> {
        let color = self.graph.colors().at(output.source);
        let is_hdr = color.is_some_and(|color| matches!(color.colorimetry.transfer, Transfer::Pq | Transfer::Hlg));
        (output.state == ColorState::Encoded).then(|| self.encoding.bits(is_hdr))
    }

    /// `node.port` of a value; `result` is the port of a bare node.
    fn label(&self, name: &str) -> Result<String, Error> {
        let (node, port) = name.rsplit_once('.').unwrap_or((name, "result"));
        let Some((_, found)) = self.graph.node(node) else {
            let names = self.graph.nodes.iter().map(|node| node.name.as_str());
            let meant = did_you_mean(node, names).map_or(String::new(), |meant| format!(": {meant}"));
            return Err(Error::Name(format!("no node is called `{node}`{meant}")));
        };
        let ports: Vec<&str> = found.kind().outputs().iter().map(|output| &*output.name).collect();
        match ports.contains(&port) {
            true => Ok(format!("{node}.{port}")),
            false => Err(Error::Name(format!("`{node}` has no output `{port}`; it has `{}`", ports.join("`, `")))),
        }
    }
}
