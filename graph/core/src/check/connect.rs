//! Wires: from `"node.port@previous:2"` to the source that is meant.

use super::Source;
use super::draft::{DraftGraph, Feed, Named, Scope, Wire, input_type};
use super::limits::{MAX_DEPTH, MAX_PREVIOUS};
use super::reports::Reports;
use crate::document::{InputEntry, OutputEntry};
use crate::node::PortType;
use afterimage_base::diagnostic::{Diagnostic, Spanned, list, quote};
use afterimage_base::image::ColorState;

/// The parts of a wire's text.
pub(super) struct WireText<'a> {
    pub(super) node: &'a str,
    pub(super) port: Option<&'a str>,
    pub(super) previous: u32,
}

/// A wire followed to its source.
#[derive(Clone, Copy)]
struct Found {
    source: Option<Source>,
    declared: Option<ColorState>,
}

/// Follows the wires of a graph to their sources.
pub(super) struct Connector<'b> {
    pub(super) drafted: &'b mut DraftGraph,
    pub(super) reports: &'b mut Reports,
}

impl Connector<'_> {
    /// Finds the source of every wire.
    pub(super) fn connect(&mut self) {
        for node in 0..self.drafted.nodes.len() {
            let scope = self.drafted.nodes[node].scope;
            for port in 0..self.drafted.nodes[node].wire_texts.len() {
                let text = self.drafted.nodes[node].wire_texts[port].clone();
                self.drafted.nodes[node].wires[port] = text.and_then(|text| self.connected(scope, &text));
            }
        }
        for (scope, text) in std::mem::take(&mut self.drafted.wires_elsewhere) {
            let wire = self.connected(scope, &text);
            self.drafted.sources_elsewhere.extend(wire.and_then(|wire| wire.source));
        }
        for output in self.drafted.scopes[0].outputs.clone() {
            let wire = self.connected(0, &output.source);
            self.drafted.outputs.push((output, wire));
        }
        // The outputs of inner pipelines are checked even if nothing reads them.
        for scope in 1..self.drafted.scopes.len() {
            for output in self.drafted.scopes[scope].outputs.clone() {
                self.connected(scope, &output.source);
            }
        }
        self.report_no_outputs();
        for scope in 1..self.drafted.scopes.len() {
            self.connect_inputs(scope);
        }
    }

    /// Finds what is wired to the inputs of an inner pipeline.
    fn connect_inputs(&mut self, inner: usize) {
        let Scope { parent, inputs, .. } = &self.drafted.scopes[inner];
        let parent = parent.unwrap_or(0);
        let wired = inputs.iter().filter_map(|(input, feed)| match feed {
            Feed::Wire(text) => Some((input.clone(), text.clone())),
            _ => None,
        });
        for (input, text) in wired.collect::<Vec<(InputEntry, Spanned<String>)>>() {
            let wire = self.connected(parent, &text);
            self.drafted.inner_wires.extend(wire.map(|wire| (inner, input, wire)));
        }
    }

    fn report_no_outputs(&mut self) {
        let top = &self.drafted.scopes[0];
        if top.outputs.is_empty() && !self.reports.diagnostics.has_errors() {
            let diagnostic = Diagnostic::error("no-outputs", "the pipeline has no outputs").at(&top.name.location, "");
            self.reports
                .push(diagnostic.help("add `outputs: { \"display\": \"node\" }` with the node that makes the picture"));
        }
    }

    /// The wire of a text; `None` once its error has been reported.
    fn connected(&mut self, scope: usize, text: &Spanned<String>) -> Option<Wire> {
        let found = self.follow(scope, text, 0)?;
        self.check_previous(found.source, text)?;
        Some(Wire { source: found.source, location: text.location.clone(), declared: found.declared })
    }

    fn follow(&mut self, scope: usize, text: &Spanned<String>, depth: usize) -> Option<Found> {
        let wire = match WireText::parse(&text.value) {
            Ok(wire) => wire,
            Err((message, help)) => {
                self.reports.push(Diagnostic::error("bad-wire", message).at(&text.location, "").help(help));
                return None;
            }
        };
        if depth > 2 * MAX_DEPTH + 2 {
            let message = format!("the wire {} leads through pipelines back to itself", quote(&text.value));
            self.reports.push(
                Diagnostic::error("cycle", message)
                    .at(&text.location, "")
                    .help("wire it to a node that makes an image"),
            );
            return None;
        }
        let found = match self.drafted.scopes[scope].names.get(wire.node).copied() {
            Some(Named::Broken) => return None,
            Some(Named::Node(node)) => self.node_output(node, &wire, text)?,
            Some(Named::Input(input)) => self.input(scope, input, &wire, text, depth)?,
            Some(Named::Scope(inner)) => self.inner_output(inner, &wire, text, depth)?,
            None => {
                self.report_unknown(scope, &wire, text);
                return None;
            }
        };
        self.at_earlier_frame(found, wire.previous, text)
    }

    fn report_unknown(&mut self, scope: usize, wire: &WireText<'_>, text: &Spanned<String>) {
        if self.drafted.scopes[scope].is_partial {
            return;
        }
        let message = format!("no input or node is called {}", quote(wire.node));
        let diagnostic = Diagnostic::error("unknown-name", message).at(&text.location, "");
        if self.reports.are_many() {
            return self.reports.push(diagnostic);
        }
        let names: Vec<&str> = self.drafted.scopes[scope].names.keys().map(String::as_str).collect();
        let help = match names.as_slice() {
            [] => "the pipeline has neither inputs nor nodes".into(),
            names => format!("there are {}", list(names.iter().copied(), 12)),
        };
        let diagnostic = diagnostic.help(help).did_you_mean(wire.node, names);
        self.reports.push(diagnostic);
    }

    fn node_output(&mut self, node: usize, wire: &WireText<'_>, text: &Spanned<String>) -> Option<Found> {
        let outputs = self.drafted.nodes[node].kind.outputs();
        let output = match wire.port {
            None => Some(0),
            Some(port) => outputs.iter().position(|output| output.name == port),
        };
        let Some(output) = output else {
            let kind = &self.drafted.nodes[node].kind;
            let names = || outputs.iter().map(|output| &*output.name);
            let message = format!("{} has no output {}", quote(kind.name()), quote(wire.port.unwrap_or_default()));
            let diagnostic = Diagnostic::error("unknown-output", message)
                .at(&text.location, "")
                .also(&self.drafted.nodes[node].kind_location, "the node is of this kind")
                .help(format!("its outputs are {}", list(names(), 8)));
            self.reports.push(self.reports.with_nearest(diagnostic, wire.port.unwrap_or_default(), names()));
            return None;
        };
        Some(Found { source: Some(Source::Node { node, output, previous: 0 }), declared: None })
    }

    fn input(
        &mut self,
        scope: usize,
        input: usize,
        wire: &WireText<'_>,
        text: &Spanned<String>,
        depth: usize,
    ) -> Option<Found> {
        if let Some(port) = wire.port {
            let message = format!("{} is an input and has no output {}", quote(wire.node), quote(port));
            let help = format!("write `\"{}\"`", wire.node);
            self.reports.push(Diagnostic::error("unknown-output", message).at(&text.location, "").help(help));
            return None;
        }
        let (entry, feed) = &self.drafted.scopes[scope].inputs[input];
        // A block has no color state, and a wire with one carries an image.
        let declared = (input_type(entry) == PortType::Image).then_some(entry.state);
        match feed {
            Feed::Host(host) => Some(Found { source: Some(Source::Input(*host)), declared: None }),
            Feed::Absent => Some(Found { source: None, declared }),
            Feed::Wire(outer) => {
                let (outer, parent) = (outer.clone(), self.drafted.scopes[scope].parent.unwrap_or(0));
                let found = self.follow(parent, &outer, depth + 1)?;
                Some(Found { declared, ..found })
            }
        }
    }

    fn inner_output(
        &mut self,
        inner: usize,
        wire: &WireText<'_>,
        text: &Spanned<String>,
        depth: usize,
    ) -> Option<Found> {
        let Scope { outputs, is_partial, names, .. } = &self.drafted.scopes[inner];
        let output = match wire.port {
            None => outputs.first(),
            Some(port) => outputs.iter().find(|output| output.name.value == port),
        };
        let Some(OutputEntry { source: inside, .. }) = output.cloned() else {
            // It may be in what is lost of a file that is broken.
            if *is_partial || wire.port.is_some_and(|port| matches!(names.get(port), Some(Named::Broken))) {
                return None;
            }
            let names: Vec<&str> = outputs.iter().map(|output| output.name.value.as_str()).collect();
            let help = format!("its outputs are {}", list(names.iter().copied(), 8));
            let message =
                format!("the pipeline {} has no output {}", quote(wire.node), quote(wire.port.unwrap_or("display")));
            let diagnostic = Diagnostic::error("unknown-output", message).at(&text.location, "");
            let diagnostic = if names.is_empty() { diagnostic } else { diagnostic.help(help) };
            self.reports.push(self.reports.with_nearest(
                diagnostic,
                wire.port.unwrap_or_default(),
                names.iter().copied(),
            ));
            return None;
        };
        self.follow(inner, &inside, depth + 1)
    }

    /// The same source, `frames` earlier.
    fn at_earlier_frame(&mut self, found: Found, frames: u32, text: &Spanned<String>) -> Option<Found> {
        let source = match found.source {
            Some(Source::Node { node, output, previous }) if frames + previous <= MAX_PREVIOUS => {
                Source::Node { node, output, previous: previous + frames }
            }
            source if frames == 0 => return Some(Found { source, ..found }),
            None => return Some(found),
            Some(source) => {
                let diagnostic = match source {
                    Source::Input(_) => Diagnostic::error("bad-previous", "an input has no previous frame")
                        .help("only what a node makes is kept: put a node between"),
                    Source::Node { .. } => too_far_back(),
                };
                self.reports.push(diagnostic.at(&text.location, ""));
                return None;
            }
        };
        Some(Found { source: Some(source), ..found })
    }

    /// Only images are kept from frame to frame.
    fn check_previous(&mut self, source: Option<Source>, text: &Spanned<String>) -> Option<()> {
        let Some(source @ Source::Node { node, previous: 1.., .. }) = source else { return Some(()) };
        let ty = self.drafted.port_type(source);
        if matches!(ty, PortType::Image | PortType::Volume) {
            return Some(());
        }
        let message = format!("{} is a {}, which is not kept from frame to frame", quote(&text.value), ty.name());
        let diagnostic = Diagnostic::error("bad-previous", message)
            .at(&text.location, "")
            .also(&self.drafted.nodes[node].kind_location, format!("this gives a {}", ty.name()))
            .help("only images have a previous frame; kinds that adapt keep what they need by themselves");
        self.reports.push(diagnostic);
        None
    }
}

fn too_far_back() -> Diagnostic {
    Diagnostic::error("bad-previous", format!("the wire reaches back more than {MAX_PREVIOUS} frames"))
        .help(format!("every frame that is kept costs a whole image; the limit is {MAX_PREVIOUS}"))
}

const EXPECTED_FORM: &str = "a wire is `\"node\"`, `\"node.port\"`, `\"node@previous\"` or `\"node.port@previous:2\"`";

impl<'a> WireText<'a> {
    pub(super) fn parse(text: &'a str) -> Result<Self, (String, String)> {
        let wrong = |message: String| Err((message, EXPECTED_FORM.to_owned()));
        let (path, time) = text.split_once('@').map_or((text, None), |(path, time)| (path, Some(time)));
        let (node, port) = path.split_once('.').map_or((path, None), |(node, port)| (node, Some(port)));
        if text.is_empty() {
            return wrong("the wire is empty".into());
        }
        if node.is_empty() || port == Some("") {
            return wrong(format!("a name is missing in {}", quote(text)));
        }
        if node.contains('/') {
            return wrong(format!("{} looks into a pipeline: only its outputs can be read", quote(text)));
        }
        let previous = match time {
            None => 0,
            Some("previous") => 1,
            Some(time) => match time.strip_prefix("previous:").map(str::parse) {
                Some(Ok(frames)) if (1..=MAX_PREVIOUS).contains(&frames) => frames,
                Some(Ok(_) | Err(_)) => {
                    return wrong(format!("the number of frames in {} is not 1 to {MAX_PREVIOUS}", quote(text)));
                }
                None => return wrong(format!("unknown time {}; only `previous` is supported", quote(time))),
            },
        };
        Ok(Self { node, port, previous })
    }
}
