//! Node kinds in folders, given with `--nodes` or beside the pipeline.

use std::fs;

use afterimage_media::{Picture, Pixels, Source, read};

use super::{Folder, save};

const NODE: &str = r#"Kind(
    name: "Posterize",
    doc: "Quantizes each channel to a few levels.",
    inputs: { "source": Image(doc: "The image.", accepts: [Scene]) },
    outputs: { "result": Image(doc: "The quantized image.", state: Same("source")) },
    parameters: { "levels": Float(doc: "Levels of each channel.", default: 4.0, within: (2.0, 256.0)) },
)"#;

/// Imports a file of the folder, which imports another one.
const POSTERIZE: &str = "import super::steps::steps;

struct Posterize { levels: f32 }

fn posterize(source: vec4f, params: Posterize) -> vec4f {
    return vec4f(steps(source.rgb, params.levels), source.a);
}
";
const STEPS: &str = "import super::nearest::nearest;

fn steps(color: vec3f, levels: f32) -> vec3f { return nearest(color * (levels - 1.0)) / (levels - 1.0); }
";
const NEAREST: &str = "fn nearest(color: vec3f) -> vec3f { return floor(color + 0.5); }\n";

const PIPELINE: &str = r#"Pipeline(
    inputs: { "scene": Color },
    nodes: { "levels": Posterize(source: "scene", levels: 3.0) },
    outputs: { "out": "levels" },
)"#;

/// A folder with the pipeline and `kinds/posterize`, which has these files beside its `node.ron`.
fn with_files(test: &str, files: &[(&str, &str)]) -> Folder {
    let folder = Folder::new(test);
    fs::create_dir_all(folder.file("kinds/posterize")).expect("a temporary folder");
    folder.with("pipeline.ron", PIPELINE.as_bytes());
    folder.with("kinds/posterize/node.ron", NODE.as_bytes());
    for (name, text) in files {
        folder.with(&format!("kinds/posterize/{name}"), text.as_bytes());
    }
    folder
}

#[test]
#[cfg_attr(no_gpu, ignore = "AFTERIMAGE_NO_GPU is set")]
fn the_shader_of_a_folder_imports_its_other_files() {
    let files = [("nearest.wesl", NEAREST), ("posterize.wesl", POSTERIZE), ("steps.wgsl", STEPS)];
    let folder = with_files("imports", &files);
    let colors = [[0.2, 0.3, 0.8, 1.0], [0.0, 0.74, 0.76, 0.5]];
    save(&folder.file("in.exr"), &Picture::new(2, 1, Pixels::Float(colors.as_flattened().to_vec())));
    for nodes in ["kinds", "kinds/posterize"] {
        folder.run(&format!("render pipeline.ron in.exr -o out.exr --nodes {nodes}")).good();
        let picture = read(&Source::file(folder.file("out.exr"))).expect("the picture was written");
        assert_eq!(picture.pixels.to_f32(), [0.0, 0.5, 1.0, 1.0, 0.0, 0.5, 1.0, 0.5], "{nodes}");
        fs::remove_file(folder.file("out.exr")).expect("it was written");
    }
}

#[test]
fn errors_name_the_file_of_the_folder_that_they_are_in() {
    let check = |test: &str, files: &[(&str, &str)]| with_files(test, files).run("check pipeline.ron --nodes kinds");
    let others = [("nearest.wgsl", NEAREST), ("steps.wgsl", STEPS)];
    check("unnamed", &others).fails_saying(
        1,
        &["no file of the folder is called `posterize.wgsl`", "node.ron:2:11", "other files are for imports"],
    );
    let alone = [("posterize.wgsl", POSTERIZE), ("steps.wgsl", STEPS)];
    check("missing", &alone).fails_saying(1, &["no shared file is called `super::nearest`", "posterize", "steps.wgsl"]);
    let broken = STEPS.replace("return nearest", "return nothing");
    let files = [("nearest.wgsl", NEAREST), ("posterize.wgsl", POSTERIZE), ("steps.wgsl", broken.as_str())];
    check("broken", &files).fails_saying(1, &["steps.wgsl", "nothing"]);
    check("empty", &[])
        .fails_saying(1, &["has no `.wgsl` or `.wesl` file beside its `node.ron`", "`posterize.wgsl` for `Posterize`"]);
}

#[test]
fn kinds_share_the_files_of_a_folder_beside_them() {
    let posterize = POSTERIZE.replace("super::", "package::lib::");
    let folder = with_files("shared", &[("posterize.wgsl", &posterize)]);
    fs::create_dir_all(folder.file("kinds/lib")).expect("a temporary folder");
    folder.with("kinds/lib/steps.wgsl", STEPS.as_bytes());
    folder.with("kinds/lib/nearest.wgsl", NEAREST.as_bytes());
    folder.run("check pipeline.ron --nodes kinds").good();
    let alone = folder.run("check pipeline.ron --nodes kinds/posterize");
    alone.fails_saying(1, &["no shared file is called `package::lib::steps`"]);
    folder.run("check pipeline.ron --nodes kinds/posterize --allow kinds/lib").good();
    // A file of the kind has another path than the shared one of its name.
    folder.with("kinds/posterize/nearest.wgsl", b"fn other() {}\n");
    folder.run("check pipeline.ron --nodes kinds").good();
    folder.with("kinds/lib/nearest.wgsl", NEAREST.replace("floor", "flor").as_bytes());
    folder.run("check pipeline.ron --nodes kinds").fails_saying(1, &["kinds/lib/nearest.wgsl:1", "flor"]);
}

#[test]
fn kinds_beside_a_pipeline_need_no_option_and_may_be_named_too() {
    let files = [("posterize.wgsl", POSTERIZE), ("steps.wgsl", STEPS), ("nearest.wgsl", NEAREST)];
    let folder = with_files("beside", &files);
    folder.run("check pipeline.ron").fails_saying(1, &["no node kind is called `Posterize`"]);
    for place in ["kinds/own.ron", "kinds/posterize/own.ron"] {
        folder.with(place, PIPELINE.as_bytes());
        for nodes in ["", " --nodes kinds", " --nodes kinds/posterize", " --nodes kinds/posterize/../posterize"] {
            folder.run(&format!("check {place}{nodes}")).good();
        }
        folder.run(&format!("check {place} --json")).good();
        folder.run(&format!("plan {place}")).good();
    }
    // Each file has the kinds of its own folder.
    folder.run("check kinds/own.ron pipeline.ron").fails_saying(1, &["--> pipeline.ron", "1 of 2 pipelines"]);
}

#[cfg(unix)]
#[test]
fn a_shared_file_that_leads_out_of_the_folder_needs_permission() {
    let posterize = POSTERIZE.replace("super::", "package::lib::");
    let folder = with_files("shared-link", &[("posterize.wgsl", &posterize)]);
    fs::create_dir_all(folder.file("kinds/lib")).expect("a temporary folder");
    fs::create_dir_all(folder.file("elsewhere")).expect("a temporary folder");
    folder.with("kinds/lib/steps.wgsl", STEPS.as_bytes());
    folder.with("elsewhere/nearest.wgsl", NEAREST.as_bytes());
    std::os::unix::fs::symlink(folder.file("elsewhere/nearest.wgsl"), folder.file("kinds/lib/nearest.wgsl")).unwrap();
    let line = "check pipeline.ron --nodes kinds";
    folder.run(line).fails_saying(1, &["cannot read the shader", "--allow", "elsewhere"]);
    folder.run(&format!("{line} --allow elsewhere")).good();
}

#[test]
fn stress_says_what_makes_a_kind_reachable() {
    let folder = with_files("lost", &[("posterize.wgsl", POSTERIZE), ("steps.wgsl", STEPS), ("nearest.wgsl", NEAREST)]);
    fs::create_dir_all(folder.file("kinds/lost")).expect("a temporary folder");
    let port = "\"clue\": Value(doc: \"A number.\", content: \"clue\")";
    let node = NODE.replace("Posterize", "Lost").replace("inputs: { ", &format!("inputs: {{ {port}, "));
    folder.with("kinds/lost/node.ron", node.as_bytes());
    let shader =
        POSTERIZE.replace("import super::steps::steps;\n", "").replace("posterize(source", "lost(clue: f32, source");
    let shader = shader
        .replace("Posterize", "Lost")
        .replace("steps(source.rgb, params.levels)", "source.rgb * clue * params.levels");
    folder.with("kinds/lost/lost.wgsl", shader.as_bytes());
    let why =
        "nothing makes its input `clue`: register a kind that has an output of the type Value and the content `clue`";
    folder
        .run("stress --kind Lost --nodes kinds")
        .fails_saying(1, &["`Lost` does not run with all of its inputs", why]);
    let conflict = r#"Pipeline(
        inputs: { "scene": Color },
        nodes: { "mean": MeanLuminance(source: "scene"), "lost": Lost(source: "scene", clue: "mean") },
        outputs: { "out": "lost" },
    )"#;
    folder.with("conflict.ron", conflict.as_bytes());
    let parts =
        ["`clue` of `Lost` accepts `clue`, but `mean` is `mean-luminance`", "wire it to a node that gives `clue`"];
    folder.run("check conflict.ron --nodes kinds").fails_saying(1, &parts);
}
