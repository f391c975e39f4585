//! A node kind without Rust: a folder with a `node.ron` that declares it and a `.wgsl` file with its functions. Other
//! `.wgsl` files of the folder are for imports.
//!
//! ```ron
//! Kind(
//!     name: "Posterize",
//!     doc: "Leaves only a few levels of each colour.",
//!     inputs: {
//!         "source": Image(doc: "The picture after the tone curve.", accepts: [DisplayLinear]),
//!     },
//!     outputs: {
//!         "result": Image(doc: "The picture in levels.", state: Same("source")),
//!     },
//!     parameters: {
//!         "levels": Float(doc: "Levels of each channel.", default: 4.0, within: (2.0, 256.0), usually: (2.0, 16.0)),
//!     },
//! )
//! ```
//!
//! * `inputs` are of type `Image`, `Volume` or `Value`. `accepts` lists the color states that fit (any, if it is left
//!   out). With `optional: true`, a port may stay unwired; then it reads as zero.
//! * `outputs` are of type `Image`. `state` is `Same("input")` or a color state, `function` the kernel function (the
//!   kind's name in snake case, if it is left out), `size` one of `Same`, `Half`, `Double` (of the first image input,
//!   or of the frame) and `Fixed(256, 256)`. `fallback` is what readers get when the node is off: an input, `Zero` or
//!   `Absent`. For the first output it is the first image input, if it is left out, and `Zero` for the others.
//! * `parameters` are of type `Bool`, `Int`, `Float`, `Vector2`, `Vector3` or `Vector4`. Each needs `doc` and
//!   `default`, numbers need `within`, and `usually`, `unit` and `neutral` are optional. They go by name into the
//!   struct of the function's argument `params`.

mod agree;
mod declaration;
mod fields;
mod limits;
mod read;

use declaration::{Declaration, SizeRule};

use super::contract::{contract, snake, stem};
use std::sync::Arc;

use super::kind::{DynNode, Kind, NodeKind};
use super::ports::{Input, Output, PortType};
use super::recorder::Recorder;
use super::resource::ImageId;
use crate::document;
use afterimage_base::Shared;
use afterimage_base::diagnostic::{Diagnostic, Diagnostics, Sources};
use afterimage_base::image::{ImageDesc, Size};
use afterimage_base::value::{Param, Value};
use afterimage_wgsl::{ArgType, Library, Shader};

/// Makes a node kind of the text of a `node.ron` and the text of its shader, each with its file's name in front.
///
/// The kind and its texts are freed with the last handle. It has passed the [`contract`] of node kinds.
///
/// # Errors
/// All errors of both files, each at its location.
pub fn folder_kind(declaration: (&str, &str), shader: (&str, &str)) -> Result<NodeKind, Diagnostics> {
    folder_kind_of(declaration, &[shader])
}

/// The same for a folder with several `.wgsl` files. The one with the kind's name in snake case is its shader; that one
/// and the others may import the others.
///
/// # Errors
/// All errors of the declaration and the shader, each at its location; no file with the kind's name.
pub fn folder_kind_of(declaration: (&str, &str), files: &[(&str, &str)]) -> Result<NodeKind, Diagnostics> {
    let without_mark = |(file, text): (&'_ str, &'_ str)| (file.to_owned(), document::without_mark(text).to_owned());
    let (declaration, mut files) =
        (without_mark(declaration), files.iter().copied().map(without_mark).collect::<Vec<_>>());
    let mut sources = Sources::default();
    let file = sources.insert(&declaration.0, &declaration.1);
    files.iter().for_each(|(file, text)| _ = sources.insert(file, text));
    let mut diagnostics = Diagnostics::new(sources);
    let parsed = document::read_tree(&file, &declaration.1);
    parsed.errors.into_iter().for_each(|error| diagnostics.push(error));
    let declared = read::declaration(parsed.tree, &mut diagnostics);
    limits::check(declared.as_ref(), files.len(), &mut diagnostics);
    let Some(own) = shader_of(declared.as_ref(), &files, &mut diagnostics) else { return Err(diagnostics.sorted()) };
    let (name, text) = files.remove(own);
    let shader = Arc::new(Shader::untrusted(name, text).with_loaded_library(Library::of_files(files)));
    match (shader.reflect(), &declared) {
        // What was not understood in the declaration would look like an error in the shader.
        (Ok(reflection), Some(declared)) if !diagnostics.has_errors() => {
            agree::look(declared, &shader, reflection, &mut diagnostics);
        }
        (Ok(_), _) => {}
        (Err(error), _) => shader.report(&error, &mut diagnostics),
    }
    match declared {
        Some(declared) if !diagnostics.has_errors() => contracted(declared, shader.clone(), diagnostics),
        _ => Err(diagnostics.sorted()),
    }
}

/// Which of the files is the kind's shader: the only one, or the one with its name.
fn shader_of(
    declared: Option<&Declaration>,
    files: &[(String, String)],
    diagnostics: &mut Diagnostics,
) -> Option<usize> {
    if files.len() == 1 {
        return Some(0);
    }
    let name = &declared?.name;
    let wanted = snake(&name.value);
    let found = files.iter().position(|(file, _)| stem(file) == wanted);
    if found.is_none() {
        let message = format!("no file of the folder is called `{wanted}.wgsl`");
        let help = "the shader of a kind has the kind's name in snake case; other files are for imports";
        diagnostics.push(Diagnostic::error("file-name", message).at(&name.location, "").help(help));
    }
    found
}

/// The kind, if it keeps the contract of all kinds.
fn contracted(
    declared: Declaration,
    shader: Arc<Shader>,
    mut diagnostics: Diagnostics,
) -> Result<NodeKind, Diagnostics> {
    let location = declared.name.location.clone();
    let kind = NodeKind::new(Arc::new(FolderKind::new(declared, shader)));
    let Err(complaints) = contract(std::slice::from_ref(&kind)) else { return Ok(kind) };
    for complaint in complaints {
        diagnostics.push(Diagnostic::error("contract", complaint).at(&location, ""));
    }
    Err(diagnostics.sorted())
}

/// A kind that was read from a folder.
struct FolderKind {
    name: String,
    doc: String,
    params: Vec<Param>,
    node: Arc<FolderNode>,
}

/// Its node. All nodes are one, since its passes do not depend on the parameters: they are numbers in uniforms.
struct FolderNode {
    inputs: Vec<Input>,
    outputs: Vec<Output>,
    made: Vec<(Shared<str>, SizeRule)>,
    shader: Arc<Shader>,
}

impl Kind for FolderKind {
    fn name(&self) -> &str {
        &self.name
    }
    fn doc(&self) -> &str {
        &self.doc
    }
    fn params(&self) -> &[Param] {
        &self.params
    }
    fn inputs(&self) -> &[Input] {
        &self.node.inputs
    }
    fn outputs(&self) -> &[Output] {
        &self.node.outputs
    }
    fn instantiate(&self, _: &[Value]) -> Arc<dyn DynNode> {
        self.node.clone()
    }
}

impl DynNode for FolderNode {
    fn record(&self, pass: &mut Recorder<'_>) {
        let first = self.inputs.iter().find(|port| port.ty == PortType::Image && pass.wired(&port.name));
        let size = match first.map(|port| pass.image(&port.name)) {
            Some(image) => pass.desc(image).size,
            None => pass.frame_size(),
        };
        for (output, (function, rule)) in self.outputs.iter().zip(&self.made) {
            if pass.wanted(&output.name) {
                self.record_output(&output.name, function, ImageDesc::new(rule.of(size)), pass);
            }
        }
    }
}

impl FolderKind {
    fn new(declared: Declaration, shader: Arc<Shader>) -> Self {
        let made = declared.outputs.iter().map(|output| (output.function.value.clone().into(), output.size)).collect();
        let outputs: Vec<Output> = declared.outputs.into_iter().map(|output| output.port).collect();
        let inputs: Vec<Input> = declared.inputs.into_iter().map(|(port, _)| port).collect();
        let params: Vec<Param> = declared.params.into_iter().map(|(param, _)| param).collect();
        let node = Arc::new(FolderNode { inputs, outputs, made, shader });
        Self { name: declared.name.value, doc: declared.doc, params, node }
    }
}

impl FolderNode {
    fn record_output(&self, output: &str, function: &Shared<str>, desc: ImageDesc, pass: &mut Recorder<'_>) {
        let reflection = self.shader.reflect().expect("the shader was read before the kind was made");
        let args = &reflection.function(function).expect("the function was found before the kind was made").args;
        let textures = args.iter().filter(|(_, ty)| matches!(ty, ArgType::Texture | ArgType::Volume));
        let ports = textures.filter_map(|(name, _)| self.inputs.iter().find(|port| port.name == *name));
        let images: Vec<_> = ports.map(|port| (port.name.clone(), black_or(port, pass))).collect();
        let call = pass.function(self.shader.clone(), function.clone());
        images.into_iter().fold(call, |call, (port, image)| call.read(port, image)).write(output, desc);
    }
}

/// The image at a port; one black texel where nothing arrives.
fn black_or(port: &Input, pass: &mut Recorder<'_>) -> ImageId {
    if pass.wired(&port.name) {
        return pass.image(&port.name);
    }
    let black = ImageDesc { volume: port.ty == PortType::Volume, ..ImageDesc::new(Size::new(1, 1)) };
    pass.constant("black", black, vec![0; black.bytes() as usize])
}
