//! A node kind without Rust: a folder with a `node.ron` that declares it and a `.wgsl` file with its functions. Other
//! `.wgsl` files of the folder are for imports.
//!
//! ```ron
//! Kind(
//!     name: "Posterize",
//!     doc: "Leaves only a few levels of each color.",
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
//! * `inputs` are of type `Image`, `Pyramid`, `Volume`, `Table` or `Value`. `accepts` lists the color states that fit
//!   (any, if it is left out), `content` names what other numbers are. With `optional: true`, a port may stay unwired;
//!   then it reads as zero.
//! * `images` are made by functions, too, and only read by those after them. They are of type `Image` or `Pyramid`,
//!   with the fields of an output except for `doc`, `state` and `fallback`, and with a `format`.
//! * `outputs` are of type `Image` or `Pyramid`. `state` is `Same("input")` or a color state, `function` the kernel
//!   function (of the first output the kind's name in snake case, if it is left out; of `images` followed by their
//!   name), `size` one
//!   of `Same`, `Half`, `Double` (of the first image input, or of the frame) and `Fixed(256, 256)`. `fallback` is what
//!   readers get when the node is off: an input, `Zero` or `Absent`. For the first output it is the first input of its
//!   type, if it is left out, and `Zero` for the others.
//! * The arguments of a function read the inputs, images and earlier outputs of the same names. `reads` names others:
//!   `reads: { "wide": "across", "low": Level("levels", 3) }`.
//! * A pyramid is made from fine to coarse, `down: "source", levels: 6`, where the argument `source` is the image above
//!   the level, or level by level, `each: "levels"`. `up: "levels"` makes an image from coarse to fine, where the
//!   argument `levels` is the level and `coarser` what was made of the coarser ones.
//! * `workgroup: (16, 16)` of an image lets the invocations of a workgroup of that size share memory: the function may
//!   use `var<workgroup>`, `workgroupBarrier` and atomics, and take `invocation: Invocation`
//!   (`import afterimage::workgroup::Invocation;`).
//! * `parameters` are of type `Bool`, `Int`, `Float`, `Vector2`, `Vector3` or `Vector4`. Each needs `doc` and
//!   `default`, numbers need `within`, and `usually`, `unit` and `neutral` are optional. `logarithmic: true` gives its
//!   slider steps of equal ratio. They go by name into the struct of the function's argument `params`.
//!   `when: { "mode": [1, 2], "mask": true }` declares that a parameter has no effect unless `mode` is 1 or 2 and the
//!   optional input `mask` is wired; `unless` states values without effect.
//! * A node whose parameters with a `neutral` value all have it is skipped, and readers of its first output get the
//!   fallback.
//! * `of_color: true` promises that red, green and blue of a pixel follow from those of the same pixel alone, and that
//!   alpha stays: `bake` can put a table in the place of the node.

mod agree;
mod declaration;
mod fields;
mod images;
mod limits;
mod ports;
mod read;
mod record;
mod sources;

use declaration::Declaration;
use record::{FolderNode, FolderPasses};

use super::contract::{contract, snake, stem};
use std::any::Any;
use std::sync::Arc;

use super::invariants::Invariants;
use super::kind::{Kind, Node, NodeKind};
use super::ports::{Input, Output};
use crate::document;
use afterimage_base::diagnostic::{Diagnostic, Diagnostics, Sources};
use afterimage_base::value::{Param, Value};
use afterimage_wgsl::{Library, Shader};

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
/// and the others may import from the others, as in `import super::steps::step;`.
///
/// # Errors
/// All errors of the declaration and the shader, each at its location; no file with the kind's name.
pub fn folder_kind_of(declaration: (&str, &str), files: &[(&str, &str)]) -> Result<NodeKind, Diagnostics> {
    folder_kind_sharing(declaration, files, &[])
}

/// The same for a folder with files that it shares with other kinds: all may import from those of `library`, as in
/// `import package::lib::steps::step;`.
///
/// # Errors
/// The same. Errors in a file of `library` that nothing imports are not found.
pub fn folder_kind_sharing(
    declaration: (&str, &str),
    files: &[(&str, &str)],
    library: &[(&str, &str)],
) -> Result<NodeKind, Diagnostics> {
    let without_mark = |(file, text): (&'_ str, &'_ str)| (file.to_owned(), document::without_mark(text).to_owned());
    let texts = |files: &[(&str, &str)]| files.iter().copied().map(without_mark).collect::<Vec<_>>();
    let (declaration, mut files, library) = (without_mark(declaration), texts(files), texts(library));
    let mut sources = Sources::default();
    let file = sources.insert(&declaration.0, &declaration.1);
    files.iter().chain(&library).for_each(|(file, text)| _ = sources.insert(file, text));
    let mut diagnostics = Diagnostics::new(sources);
    let parsed = document::read_tree(&file, &declaration.1);
    parsed.errors.into_iter().for_each(|error| diagnostics.push(error));
    let declared = read::declaration(parsed.tree, &mut diagnostics);
    limits::check(declared.as_ref(), files.len() + library.len(), &mut diagnostics);
    let Some(own) = shader_of(declared.as_ref(), &files, &mut diagnostics) else { return Err(diagnostics.sorted()) };
    let (name, text) = files.remove(own);
    let library = Library::of_files(files, library);
    let mut shader = Shader::untrusted(name, text).with_loaded_library(library);
    if declared.iter().flat_map(|declared| &declared.made).any(|made| made.shape.workgroup().is_some()) {
        shader = shader.with_workgroups();
    }
    let shader = Arc::new(shader);
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

/// Index of the kind's shader: the only file, or the one with its name.
fn shader_of(
    declared: Option<&Declaration>,
    files: &[(String, String)],
    diagnostics: &mut Diagnostics,
) -> Option<usize> {
    if files.len() == 1 {
        return Some(0);
    }
    let name = &declared?.name;
    let expected = snake(&name.value);
    let found = files.iter().position(|(file, _)| stem(file) == expected);
    if found.is_none() {
        let message = format!("no file of the folder is called `{expected}.wgsl`");
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
    let Err(violations) = contract(std::slice::from_ref(&kind)) else { return Ok(kind) };
    for violation in violations {
        diagnostics.push(Diagnostic::error("contract", violation).at(&location, ""));
    }
    Err(diagnostics.sorted())
}

/// A kind that was read from a folder.
struct FolderKind {
    name: String,
    doc: String,
    params: Arc<[Param]>,
    of_color: bool,
    passes: Arc<FolderPasses>,
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
        &self.passes.inputs
    }
    fn outputs(&self) -> &[Output] {
        &self.passes.outputs
    }
    fn invariants(&self) -> Invariants {
        Invariants { of_color: self.of_color, ..Invariants::NONE }
    }
    fn instantiate(&self, values: &[Value]) -> Arc<dyn Node> {
        Arc::new(FolderNode::new(self.passes.clone(), self.params.clone(), values))
    }
    fn set(&self, node: &mut dyn Node, index: usize, value: &Value) -> bool {
        let node: &mut dyn Any = node;
        node.downcast_mut::<FolderNode>().expect("the kind has made the node").set(index, value);
        true
    }
}

impl FolderKind {
    fn new(declared: Declaration, shader: Arc<Shader>) -> Self {
        let passes = Arc::new(FolderPasses::new(&declared, shader));
        let params = declared.params.into_iter().map(|(param, _)| param).collect();
        Self { name: declared.name.value, doc: declared.doc, params, of_color: declared.of_color, passes }
    }
}
