//! A node kind without Rust: a folder with a `node.ron` that declares it and a `.wgsl` that draws it.
//!
//! ```ron
//! Kind(
//!     name: "Posterize",
//!     doc: "Leaves only a few levels of each colour.",
//!     inputs: {
//!         "source": Image(doc: "The picture after the tone curve.", states: [DisplayLinear]),
//!     },
//!     outputs: {
//!         "result": Image(doc: "The picture in levels.", gives: Same("source")),
//!     },
//!     parameters: {
//!         "levels": Float(doc: "Levels of each channel.", default: 4.0, within: (2.0, 256.0), usually: (2.0, 16.0)),
//!     },
//! )
//! ```
//!
//! * `inputs` are of type `Image`, `Volume` or `Value`; `states` says which image states fit (any, if it is left out), `optional: true` lets
//!   a port stay unwired, and then it reads as zero.
//! * `outputs` are of type `Image`. `gives` is `Same("input")` or a state, `function` the kernel function (the kind's name in snake case, if it
//!   is left out), `size` one of `Same`, `Half`, `Double` (of the first image input, or of the frame) and `Fixed(256, 256)`.
//! * `parameters` are of type `Bool`, `Int`, `Float`, `Vector2`, `Vector3` or `Vector4`; each needs `doc` and `default`, numbers need `within`,
//!   and `usually`, `unit` and `neutral` may be given. They go into the struct of the function's `params` argument by name.
//! * `bypass` is what stands in for the node when it is off: an input, `Zero` or `Absent`; the first input that fits, if it is left out.

mod agree;
mod read;

use super::contract::contract;
use super::kind::{Arrivals, Kind, NodeKind};
use super::resource::ImageId;
use super::ports::{Fallback, Input, Output, PortType};
use super::recorder::Recorder;
use crate::document;
use afterimage_base::diagnostic::{Diagnostic, Diagnostics, Place, Sources, Spanned};
use afterimage_base::image::{ImageDesc, Size};
use afterimage_base::value::{Param, Value};
use afterimage_wgsl::{ArgType, Shader};

/// Makes a node kind of the text of a `node.ron` and the text of its shader, each with its file's name in front.
///
/// The kind lives as long as the program: its texts are never freed. It has passed the [`contract`] of node kinds.
///
/// # Errors
/// All mistakes of both files, each at its place.
pub fn folder_kind(declaration: (&str, &str), shader: (&str, &str)) -> Result<NodeKind, Diagnostics> {
    let [declaration, shader] = [declaration, shader].map(|(file, text)| (file, document::without_mark(text)));
    let mut sources = Sources::default();
    let file = sources.insert(declaration.0, declaration.1);
    sources.insert(shader.0, shader.1);
    let mut diagnostics = Diagnostics::new(sources);
    let shader: &'static Shader = Box::leak(Box::new(Shader::new(leak(shader.0), leak(shader.1))));
    let parsed = document::read_tree(&file, declaration.1);
    parsed.errors.into_iter().for_each(|error| diagnostics.push(error));
    let declared = read::declaration(parsed.tree, &mut diagnostics);
    match (shader.reflect(), &declared) {
        // What was not understood in the declaration would look like a mistake in the shader.
        (Ok(reflection), Some(declared)) if !diagnostics.has_errors() => {
            agree::look(declared, shader, reflection, &mut diagnostics);
        }
        (Ok(_), _) => {}
        (Err(error), _) => shader.report(&error, &mut diagnostics),
    }
    match declared {
        Some(declared) if !diagnostics.has_errors() => contracted(declared, shader, diagnostics),
        _ => Err(diagnostics.sorted()),
    }
}

/// The kind, if it keeps the contract of all kinds.
fn contracted(
    declared: Declaration,
    shader: &'static Shader,
    mut diagnostics: Diagnostics,
) -> Result<NodeKind, Diagnostics> {
    let place = declared.name.place.clone();
    let kind = NodeKind::new(Box::leak(Box::new(FolderKind::new(declared, shader))));
    let Err(complaints) = contract(&[kind]) else { return Ok(kind) };
    for complaint in complaints {
        diagnostics.push(Diagnostic::error("contract", complaint).at(&place, ""));
    }
    Err(diagnostics.sorted())
}

/// Text for as long as the program runs.
fn leak(text: &str) -> &'static str {
    Box::leak(text.to_owned().into_boxed_str())
}

/// What a `node.ron` says, with the places that mistakes in the shader point back to.
struct Declaration {
    name: Spanned<String>,
    doc: String,
    inputs: Vec<(Input, Place)>,
    outputs: Vec<DeclaredOutput>,
    params: Vec<(Param, Place)>,
    bypass: Fallback,
}

/// An output and how it is made.
struct DeclaredOutput {
    port: Output,
    function: Spanned<String>,
    size: SizeRule,
}

/// A kind that was read from a folder.
struct FolderKind {
    name: &'static str,
    doc: &'static str,
    params: &'static [Param],
    inputs: &'static [Input],
    outputs: &'static [Output],
    made: Vec<(&'static str, SizeRule)>,
    bypass: Fallback,
    shader: &'static Shader,
}

/// The size of an output.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
enum SizeRule {
    Same,
    Half,
    Double,
    Fixed(u32, u32),
}

impl SizeRule {
    fn of(self, size: Size) -> Size {
        match self {
            Self::Same => size,
            Self::Half => size.half(),
            Self::Double => Size::new(size.width.saturating_mul(2), size.height.saturating_mul(2)),
            Self::Fixed(width, height) => Size::new(width, height),
        }
    }
}

impl Kind for FolderKind {
    fn name(&self) -> &'static str {
        self.name
    }
    fn doc(&self) -> &'static str {
        self.doc
    }
    fn params(&self) -> &'static [Param] {
        self.params
    }
    fn inputs(&self) -> &'static [Input] {
        self.inputs
    }
    fn outputs(&self) -> &'static [Output] {
        self.outputs
    }
    fn fallback(&self) -> Fallback {
        self.bypass
    }
    fn identity(&self, _: &[Value], _: &Arrivals) -> Option<Fallback> {
        None
    }
    fn verify(&self, _: &[Value]) -> Result<(), String> {
        Ok(())
    }
    fn record(&self, _: &[Value], pass: &mut Recorder<'_>) {
        let first = self.inputs.iter().find(|port| port.ty == PortType::Image && pass.wired(port.name));
        let size = match first.map(|port| pass.image(port.name)) {
            Some(image) => pass.desc(image).size,
            None => pass.frame_size(),
        };
        for (output, (function, rule)) in self.outputs.iter().zip(&self.made) {
            if pass.wanted(output.name) {
                self.record_output(output.name, function, ImageDesc::new(rule.of(size)), pass);
            }
        }
    }
}

impl FolderKind {
    fn new(declared: Declaration, shader: &'static Shader) -> Self {
        let made = declared.outputs.iter().map(|output| (leak(&output.function.value), output.size)).collect();
        let outputs: Vec<Output> = declared.outputs.into_iter().map(|output| output.port).collect();
        let inputs: Vec<Input> = declared.inputs.into_iter().map(|(port, _)| port).collect();
        let params: Vec<Param> = declared.params.into_iter().map(|(param, _)| param).collect();
        Self {
            name: leak(&declared.name.value),
            doc: leak(&declared.doc),
            params: params.leak(),
            inputs: inputs.leak(),
            outputs: outputs.leak(),
            made,
            bypass: declared.bypass,
            shader,
        }
    }

    fn record_output(&self, output: &str, function: &'static str, desc: ImageDesc, pass: &mut Recorder<'_>) {
        let reflection = self.shader.reflect().expect("the shader was read before the kind was made");
        let args = &reflection.function(function).expect("the function was found before the kind was made").args;
        let textures = args.iter().filter(|(_, ty)| matches!(ty, ArgType::Texture | ArgType::Volume));
        let ports = textures.filter_map(|(name, _)| self.inputs.iter().find(|port| port.name == name));
        let images: Vec<_> = ports.map(|port| (port.name, black_or(port, pass))).collect();
        let call = pass.function(self.shader, function);
        images.into_iter().fold(call, |call, (port, image)| call.read(port, image)).write(output, desc);
    }
}

/// The image at a port; one black texel where nothing arrives.
fn black_or(port: &Input, pass: &mut Recorder<'_>) -> ImageId {
    if pass.wired(port.name) {
        return pass.image(port.name);
    }
    let black = ImageDesc { volume: port.ty == PortType::Volume, ..ImageDesc::new(Size::new(1, 1)) };
    pass.constant("black", black, vec![0; black.bytes() as usize])
}
