//! Shaders of folders: refused at the author's line, or they become one valid module with others.

use std::sync::OnceLock;

use afterimage_wgsl::{
    ArgType, Instance, Library, Linker, Reflection, SampleMode, Shader, ShaderError, limits, validate,
};

use crate::hostile::{Kernel, pair};

/// The line between a shader and the file `shared.wgsl` that it may import.
pub const SECOND_FILE: &str = "\n//// shared.wgsl\n";

/// Functions of a shader that are called.
const MAX_CALLS: usize = 6;

/// The text of both files of a kernel.
pub(crate) fn text(kernel: &Kernel) -> String {
    format!("{}{SECOND_FILE}{}", kernel.text, kernel.shared)
}

/// True if the text is a shader that a folder may hold.
pub(crate) fn survives(text: &str) -> bool {
    let shader = shader("kind.wgsl", text);
    match shader.reflect() {
        Ok(reflection) => {
            links(&shader, reflection);
            true
        }
        Err(error) => {
            is_placed(text, &error);
            false
        }
    }
}

fn shader(name: &str, text: &str) -> Shader {
    let (own, shared) = text.split_once(SECOND_FILE).unwrap_or((text, ""));
    let library = Library::of_files([("shared.wgsl".to_owned(), shared.to_owned())], []);
    Shader::untrusted(name.to_owned(), own.to_owned()).with_loaded_library(library)
}

/// The error is at a line of one of the author's files.
fn is_placed(text: &str, error: &ShaderError) {
    assert!(!error.message.is_empty());
    let (own, shared) = text.split_once(SECOND_FILE).unwrap_or((text, ""));
    let file = match error.file.as_str() {
        "kind.wgsl" => own,
        "shared.wgsl" => shared,
        _ => panic!("the error is not in a file of the author: {error}"),
    };
    let lines = file.split('\n').count();
    assert!((1..=lines).contains(&(error.line as usize)), "the file has {lines} lines: {error}");
}

/// A shader with names of its own, which no other file may change.
fn neighbor() -> &'static (Shader, String) {
    static NEIGHBOR: OnceLock<(Shader, String)> = OnceLock::new();
    NEIGHBOR.get_or_init(|| {
        let [_, kernel] = pair(0).hostile;
        (shader("neighbor.wgsl", &text(&kernel)), kernel.function)
    })
}

/// What is accepted is valid beside a neighbor, too.
fn links(shader: &Shader, reflection: &Reflection) {
    let (neighbor, last) = neighbor();
    let mut linker = Linker::new(SampleMode::Sanitized);
    let of_pixels =
        reflection.functions.iter().filter(|function| matches!(function.args[..], [(_, ArgType::Floats(4))]));
    let names = of_pixels.take(MAX_CALLS).map(|function| (shader, &function.name)).chain([(neighbor, last)]);
    let mut calls = String::new();
    for (file, name) in names {
        let instance = linker.add(file.source(), &[]).unwrap_or_else(|error| panic!("accepted, but: {error}"));
        let function = linker.name(instance, name);
        let before = linker.before_call(limits::LOOP_STEPS).unwrap_or_default();
        calls += &format!("    {before}\n    kernel = {function}(kernel);\n");
    }
    let code = format!(
        "@group(0) @binding(0) var image0: texture_2d<f32>;
fn run(at: Point) -> vec4f {{
    var kernel = sanitize_texel(image0, at.pixel, 1u);
{calls}    return kernel;
}}
@fragment
fn fragment(@builtin(position) at: vec4f) -> @location(0) vec4f {{ return run(Point(vec2i(at.xy), at.xy, at.xy)); }}"
    );
    let linked = linker.link(code, &[(Instance::GENERATED, "fragment")]);
    let linked = linked.unwrap_or_else(|error| panic!("accepted, but: {error}"));
    validate(&linked.text, &linked.map).unwrap_or_else(|error| panic!("accepted, but: {error}"));
}
