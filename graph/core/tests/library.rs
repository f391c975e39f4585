//! Every function of the shaders' library can be called by a kind from a folder.

use std::collections::BTreeMap;
use std::fmt::Write as _;
use std::path::Path;

use afterimage_graph::node::folder_kind;

/// What no author calls: what counts the steps of loops, reads one sample of several, which folders do not take, or
/// belongs to passes by rows.
const INTERNAL: &[&str] = &[
    "begin_steps",
    "is_last_step",
    "were_steps_cut",
    "texel_sample",
    "is_sample_known",
    "note_light",
    "halves_put",
    "halves_take",
    "halves_across",
    "halves_down",
];

/// A value of an argument's type. Structs are named by the file that declares them.
fn value(ty: &str, structs: &BTreeMap<String, String>) -> String {
    match ty {
        "texture_2d<f32>" => "source".to_owned(),
        "texture_3d<f32>" => "cube".to_owned(),
        "sampler" => "source_sampler".to_owned(),
        "Point" => "at".to_owned(),
        "Invocation" => "invocation".to_owned(),
        _ => match structs.get(ty) {
            Some(file) => format!("afterimage::{file}::{ty}()"),
            None => format!("{ty}()"),
        },
    }
}

/// Name and types of the arguments of each function.
fn functions(text: &str) -> Vec<(String, Vec<String>)> {
    let mut found = Vec::new();
    for part in text.split("\nfn ").skip(1) {
        let (name, rest) = part.split_once('(').unwrap();
        let args = rest.split_once(')').unwrap().0.split(',').map(str::trim);
        let types = args.filter_map(|arg| arg.split_once(": ")).map(|(_, ty)| ty.to_owned()).collect();
        found.push((name.to_owned(), types));
    }
    found
}

#[test]
fn each_function_of_the_library_can_be_called_from_a_folder() {
    let folder = Path::new(env!("CARGO_MANIFEST_DIR")).join("../../shaders/lib");
    let (mut called, mut refused) = (0, String::new());
    let files = std::fs::read_dir(folder).unwrap().map(|entry| entry.unwrap().path());
    let files = files
        .map(|path| (path.file_stem().unwrap().to_string_lossy().into_owned(), std::fs::read_to_string(path).unwrap()));
    let files: Vec<(String, String)> = files.collect();
    let declared = files.iter().flat_map(|(file, text)| text.split("\nstruct ").skip(1).map(move |part| (file, part)));
    let structs = declared.map(|(file, part)| (part.split_once(' ').unwrap().0.to_owned(), file.clone())).collect();
    for (library, text) in &files {
        for (name, types) in functions(text) {
            if INTERNAL.contains(&&*name) {
                continue;
            }
            let mut args: Vec<String> = types.iter().map(|ty| value(ty, &structs)).collect();
            if let Some(at) = args.windows(2).position(|pair| pair == ["cube", "source_sampler"]) {
                args[at + 1] = "cube_sampler".to_owned();
            }
            let reads = |input: &str| args.iter().any(|arg| arg == input);
            let workgroup = if reads("invocation") { ", workgroup: (16, 16)" } else { "" };
            let volume = if reads("cube") { r#", "cube": Volume(doc: "A volume.")"# } else { "" };
            let declaration = format!(
                r#"Kind(
    name: "Caller",
    doc: "Calls a function of the library.",
    inputs: {{ "source": Image(doc: "A picture."){volume} }},
    outputs: {{ "result": Image(doc: "A picture.", state: Same("source"){workgroup}) }},
)"#
            );
            let source = if reads("source") { "source: texture_2d<f32>" } else { "source: vec4f" };
            let sampler = if reads("source_sampler") { ", source_sampler: sampler" } else { "" };
            let cube = if reads("cube") { ", cube: texture_3d<f32>, cube_sampler: sampler" } else { "" };
            let invocation = if reads("invocation") { ", invocation: Invocation" } else { "" };
            let args = args.join(", ");
            let call = format!(
                "import afterimage::workgroup::Invocation;\n\
                 fn caller({source}{sampler}, at: Point{cube}{invocation}) -> vec4f {{\n\
                 _ = afterimage::{library}::{name}({args});\n    return vec4f(1.0);\n}}"
            );
            called += 1;
            if let Err(reported) = folder_kind(("node.ron", &declaration), ("caller.wgsl", &call)) {
                writeln!(refused, "{library}: {name}\n{reported}").unwrap();
            }
        }
    }
    assert!(called > 100, "{called}");
    assert!(refused.is_empty(), "{refused}");
}
