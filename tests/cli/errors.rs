//! Errors of the command line, each with its message and its exit status: 1 for an error of the input, 2 for one of the
//! machine.

use std::io::Read as _;
use std::process::Stdio;

use super::{Folder, room, save};

fn folder(test: &str) -> Folder {
    let folder = Folder::new(test);
    save(&folder.file("room.exr"), &room(12, 8));
    folder
}

#[test]
#[cfg_attr(no_gpu, ignore = "AFTERIMAGE_NO_GPU is set")]
fn errors_are_reported_with_a_hint() {
    let folder = folder("errors");
    folder.with("notes.txt", b"room.exr is the good one");
    let table = [
        (
            "render {glare} rom.exr -o out.png",
            "error: rom.exr: there is no such file\n  hint: check the spelling; names are relative to the folder you are in",
        ),
        (
            "render {glare} room.exr -o out.xyz",
            "error: `out.xyz` ends in none of `.png`, `.jpg`, `.tif` and `.exr`\n  hint: `.png`, `.jpg` and `.tif` take \
             an encoded output, `.exr` a linear one",
        ),
        ("render {glare} room.exr -o out.png --depth 12", "error: a PNG has 8 or 16 bits, not 12"),
        (
            "render {glare} room.exr -o out.exr",
            "error: the pipeline has no linear output for this file; it has `display` (Encoded)\n  hint: write to a `.png` file, or add \
             an output before the `Encode` node",
        ),
        (
            "render {glare} room.exr -o out.png --output final",
            "error: the pipeline has no output `final`\n  hint: it has `display` (Encoded)",
        ),
        (
            "render {glare} room.exr -o nowhere/out.png",
            "error: nowhere/out.png: the folder of this output does not exist\n  hint: create the folder first",
        ),
        (
            "render {glare} -o out.png",
            "error: the pipeline needs an image for its input `scene`\n  hint: name a file after the pipeline, or `--input scene=FILE`",
        ),
        (
            "render {glare} -o out.png --input seen=room.exr",
            "error: the pipeline has no input `seen`\n  hint: it has `scene`",
        ),
        (
            "render {glare} -o out.png --input room.exr",
            "error: `--input room.exr` has no `=`\n  hint: write `--input name=value`",
        ),
        (
            "render {glare} room.exr#depth -o out.png",
            "error: room.exr: it has no layer or channel `depth`\n  hint: it has `A`, `B`, `G`, `R`",
        ),
        (
            "render {glare} notes.txt -o out.png",
            "error: notes.txt: this is not an image that this program knows\n  hint: EXR, Radiance HDR, PNG, JPEG, TIFF and DPX files are read; convert \
             it to one of them",
        ),
        (
            "render {glare} . -o out.png",
            "error: .: this is a folder, not an image\n  hint: name a file; a sequence in a folder is written `folder/shot.####.exr`",
        ),
    ];
    for (line, words) in table {
        folder.run(line).fails(1, words);
    }
    assert_eq!(folder.names(), ["notes.txt", "room.exr"]);
}

#[test]
#[cfg_attr(no_gpu, ignore = "AFTERIMAGE_NO_GPU is set")]
fn facts_tiers_and_parameters_are_checked() {
    let folder = folder("facts");
    folder.run("render {caracal} room.exr -o out.png --fact emisive=false").fails_saying(1, &["emisive", "`emissive`"]);
    folder.run("stress {caracal} --fact emisive=false").fails_saying(1, &["emisive", "`emissive`"]);
    folder.run("stress caracal --fact emisive=false").fails_saying(1, &["emisive", "`emissive`"]);
    folder.run("view {caracal} --fact emisive=false").fails_saying(1, &["emisive", "`emissive`"]);
    folder.run("view caracal --fact emisive=false").fails_saying(1, &["emisive", "`emissive`"]);
    folder.run("view caracal --input seen=room.exr").fails_saying(1, &["the pipeline has no input `seen`", "`scene`"]);
    folder.run("view caracal --input scene=rom.exr").fails_saying(1, &["rom.exr: there is no such file"]);
    folder.run("view rom.exr").fails_saying(1, &["rom.exr: there is no such file"]);
    folder.run("render {caracal} room.exr -o out.png --fact emissive=often").fails_saying(1, &["emissive", "often"]);
    folder.run("render {glare} room.exr -o out.png --fact lamps=false").fails_saying(1, &["lamps"]);
    folder.run("render {caracal} room.exr -o out.png --fact emissive=0").fails(
        1,
        "error: `--fact emissive=0`: this fact is `true` or `false`, not a number\n  hint: write `--fact emissive=false`",
    );
    let dim = "Pipeline(inputs: { \"scene\": Color }, outputs: { \"light\": \"lit\" }, nodes: { \"lit\": Exposure(source: \
               \"scene\", stops: 1.0, when: \"illuminance < 10 and moon\") })";
    folder.with("dim.ron", dim.as_bytes());
    for (fact, words) in [
        ("illuminance=true", "`--fact illuminance=true`: this fact is a number"),
        ("moon=1", "write `--fact moon=true`"),
        ("illuminance=inf", "a fact is `true`, `false` or a number"),
        ("lux=3", "no `when` of this pipeline uses the fact `lux`\n  hint: it uses `illuminance` and `moon`"),
        ("moon", "`--fact moon` has no `=`\n  hint: write `--fact name=value`"),
    ] {
        folder.run(&format!("check dim.ron --fact {fact}")).fails_saying(1, &[words]);
    }
    let skipped = |facts: &str| folder.run(&format!("plan dim.ron {facts}")).good().contains("does not hold");
    assert!(!skipped("--fact illuminance=9 --fact moon=true") && skipped("--fact illuminance=11 --fact moon=true"));
    std::fs::remove_file(folder.file("dim.ron")).expect("it was written");
    folder.run("check grade --fact lux=3").fails_saying(1, &["it uses no facts"]);
    let declared = "Pipeline(inputs: { \"scene\": Color }, nodes: {}, outputs: { \"light\": \"scene\" }, \
                    facts: { \"lamps\": \"lamps are on\" })";
    folder.with("declared.ron", declared.as_bytes());
    let notes = folder.run("render declared.ron room.exr -o light.exr --fact lamps=false").notes();
    assert!(notes.contains("no `when` of this pipeline reads the fact `lamps`"), "{notes}");
    folder.run("render declared.ron room.exr -o light.exr --fact lamp=false").fails_saying(1, &["the fact `lamp`"]);
    for name in ["declared.ron", "light.exr"] {
        std::fs::remove_file(folder.file(name)).expect("it was written");
    }
    folder.run("render {tsushima} room.exr -o out.png --tier cheap").fails_saying(1, &["no tier `cheap`", "low"]);
    folder.run("render {glare} room.exr -o out.png --set lit.strenth=1").fails_saying(1, &["strenth", "strength"]);
    folder.run("render {glare} room.exr -o out.png --set lit.strength=9").fails_saying(1, &["strength", "8"]);
    folder.run("render {glare} {lynx} -o out.png").fails_saying(1, &["is a pipeline, not an image"]);
    folder.run("render nothing.ron room.exr -o out.png").fails_saying(1, &["cannot read the pipeline `nothing.ron`"]);
    assert_eq!(folder.names(), ["room.exr"]);
}

#[test]
fn a_file_in_the_place_of_the_pipeline_is_named() {
    let folder = folder("swapped");
    folder.with("look.cube", b"LUT_3D_SIZE 2\n");
    folder.with("reshade.ini", b"[Bloom.fx]\nTechniques=Bloom\n");
    folder.with("blue.wgsl", b"fn blue() {}\n");
    for (line, words) in [
        ("render room.exr -o out.png", "`room.exr` is an image, not a pipeline\n  hint: the pipeline comes first"),
        ("render exposur room.exr -o out.png", "there is no pipeline `exposur`\n  hint: did you mean `exposure`?"),
        (
            "render mine room.exr -o out.png",
            "there is no pipeline `mine`\n  hint: name a .ron file, or one of the built-in",
        ),
        ("pipelines exposur", "there is no built-in pipeline `exposur`"),
        ("stress room.exr --quick", "`room.exr` is an image, not a pipeline"),
        ("plan room.exr", "`room.exr` is an image, not a pipeline"),
        ("check look.cube", "`look.cube` is a color file, not a pipeline"),
        ("check reshade.ini", "`reshade.ini` is a preset or a shader of another program, not a pipeline"),
        ("check blue.wgsl", "`blue.wgsl` is a shader, not a pipeline"),
        ("nodes Exposre", "no node kind is called `Exposre`, and none is about that\n  hint: did you mean `Exposure`?"),
        ("nodes zebra", "hint: `afterimage nodes` lists them all"),
    ] {
        folder.run(line).fails_saying(1, &[words]);
    }
    assert!(!folder.file("out.png").exists());
}

#[test]
#[cfg_attr(no_gpu, ignore = "AFTERIMAGE_NO_GPU is set")]
fn an_unknown_adapter_is_reported_with_those_there_are() {
    let folder = folder("adapter");
    let outcome = folder.run("render {glare} room.exr -o out.png --adapter Voodoo2");
    outcome.fails_saying(1, &["error: no graphics adapter called `Voodoo2`: there are `"]);
}

#[test]
#[cfg_attr(no_gpu, ignore = "AFTERIMAGE_NO_GPU is set")]
#[cfg(target_os = "linux")]
fn no_adapter_is_the_machines_fault_and_names_the_package() {
    let folder = folder("no-adapter");
    let mut command = folder.command("render {glare} room.exr -o out.png");
    command.env("VK_DRIVER_FILES", "/nonexistent").env("VK_ICD_FILENAMES", "/nonexistent");
    let outcome = super::Outcome::of(&command.output().expect("the program starts"));
    outcome.fails_saying(2, &["no graphics adapter", "apt-get install mesa-vulkan-drivers"]);
    assert!(!folder.file("out.png").exists());
}

#[test]
#[cfg_attr(no_gpu, ignore = "AFTERIMAGE_NO_GPU is set")]
#[cfg(target_os = "linux")]
fn a_driver_that_does_not_fit_is_not_called_missing() {
    let folder = folder("no-memory");
    let program = folder.command("render {glare} room.exr -o out.png");
    let mut limited = std::process::Command::new("sh");
    limited.args(["-c", "ulimit -v 170000; exec \"$0\" \"$@\""]).arg(program.get_program()).args(program.get_args());
    limited.current_dir(folder.file(".")).stdin(Stdio::null());
    let outcome = super::Outcome::of(&limited.output().expect("the program starts"));
    outcome.fails_saying(2, &["its driver may need more memory", "no more than 166 MiB of memory (`ulimit -v`)"]);
}

#[test]
#[cfg_attr(no_gpu, ignore = "AFTERIMAGE_NO_GPU is set")]
#[cfg(target_os = "linux")]
fn a_device_that_takes_no_more_is_the_machines_fault() {
    let folder = folder("full");
    std::os::unix::fs::symlink("/dev/full", folder.file("out.png")).expect("a link");
    let outcome = folder.run("render {glare} room.exr -o out.png");
    outcome.fails(2, "error: out.png: this device or pipe takes no more: No space left on device (os error 28)");
}

#[test]
#[cfg_attr(no_gpu, ignore = "AFTERIMAGE_NO_GPU is set")]
fn a_failure_leaves_the_old_picture_alone() {
    let folder = folder("old");
    folder.with("out.png", b"the picture of yesterday");
    let mut cut = std::fs::read(folder.file("room.exr")).expect("a picture");
    cut.truncate(cut.len() - 20);
    folder.with("cut.exr", &cut);
    folder.run("render {glare} cut.exr -o out.png").fails_saying(1, &["cut.exr"]);
    assert_eq!(std::fs::read(folder.file("out.png")).expect("still there"), b"the picture of yesterday");
    assert_eq!(folder.names(), ["cut.exr", "out.png", "room.exr"]);
}

#[test]
#[cfg_attr(no_gpu, ignore = "AFTERIMAGE_NO_GPU is set")]
fn a_reader_that_goes_away_is_no_failure() {
    let folder = Folder::new("pipe");
    for line in ["nodes", "plan {tsushima} --format json", "plan {tsushima} --format svg"] {
        let mut child = folder.command(line).stdout(Stdio::piped()).stderr(Stdio::piped()).spawn().expect("it starts");
        // Reads one byte and hangs up, as `head` does.
        let mut out = child.stdout.take().expect("a pipe");
        out.read_exact(&mut [0]).expect("it speaks");
        drop(out);
        let outcome = super::Outcome::of(&child.wait_with_output().expect("it ends"));
        assert_eq!((outcome.status, outcome.err.as_str()), (Some(0), ""), "{line}");
    }
}

#[test]
#[cfg_attr(no_gpu, ignore = "AFTERIMAGE_NO_GPU is set")]
fn a_broken_pipeline_is_reported_with_its_location() {
    let folder = folder("pipeline");
    folder.with("bad.ron", b"Pipeline(\n    inputs: { \"scene\": Color },\n    nodes: { \"a\": Blurr(source: \"scene\") },\n    outputs: { \"display\": \"a\" },\n)");
    let outcome = folder.run("check bad.ron");
    outcome.fails_saying(1, &["error[unknown-kind]", "Blurr", "bad.ron:3"]);
    folder.run("render bad.ron room.exr -o out.png").fails_saying(1, &["Blurr", "bad.ron:3"]);
    assert!(!folder.file("out.png").exists());
}

#[test]
#[cfg_attr(no_gpu, ignore = "AFTERIMAGE_NO_GPU is set")]
fn options_that_would_change_nothing_are_refused() {
    let folder = folder("idle");
    let table = [
        (
            "render {glare} room.exr -o out.png --size 3x3",
            "error: `--size` is for pipelines without an input image; here the output has the size of the input\n  hint: leave it out, \
             or scale the input",
        ),
        (
            "render {glare} room.exr -o out.png --frames 1-3",
            "error: `--frames` needs a numbered input\n  hint: put a placeholder into the name, for example `shot.####.exr`",
        ),
    ];
    for (line, words) in table {
        folder.run(line).fails(1, words);
    }
    for fps in ["0", "-24", "NaN", "inf", "1e-40"] {
        let outcome = folder.run(&format!("render {{glare}} room.exr -o out.png --fps={fps}"));
        outcome.fails_saying(1, &["frames per second are a number above 0"]);
    }
    assert_eq!(folder.names(), ["room.exr"]);
}

#[test]
#[cfg_attr(no_gpu, ignore = "AFTERIMAGE_NO_GPU is set")]
fn a_picture_does_not_take_the_place_of_its_input() {
    let folder = folder("overwrite");
    let light = "Pipeline(inputs: { \"scene\": Color }, nodes: {}, outputs: { \"light\": \"scene\" })";
    folder.with("light.ron", light.as_bytes());
    let before = std::fs::read(folder.file("room.exr")).expect("a picture");
    let outcome = folder.run("render light.ron room.exr -o ./room.exr");
    outcome
        .fails(1, "error: ./room.exr: this is the image of input `scene`\n  hint: choose another name for the output");
    assert_eq!(std::fs::read(folder.file("room.exr")).expect("still there"), before);
}

#[test]
#[cfg_attr(no_gpu, ignore = "AFTERIMAGE_NO_GPU is set")]
#[cfg(target_os = "linux")]
fn a_result_that_cannot_be_printed_is_no_success() {
    let folder = Folder::new("unsaid");
    for line in ["nodes", "plan {lynx}", "check {lynx}"] {
        let full = std::fs::File::options().write(true).open("/dev/full").expect("the device of a full disk");
        let output = folder.command(line).stdout(full).output().expect("the program starts");
        super::Outcome::of(&output)
            .fails(2, "error: standard output: the disk is full\n  hint: make room; no file was left half written");
    }
}

#[test]
#[cfg_attr(no_gpu, ignore = "AFTERIMAGE_NO_GPU is set")]
#[cfg(target_os = "linux")]
fn a_pipe_is_no_image() {
    let folder = Folder::new("stream");
    folder
        .run("render {glare} /dev/zero -o out.png")
        .fails(1, "error: /dev/zero: this is a pipe or a device, not a file\n  hint: save it to a file first");
}

#[test]
#[cfg_attr(no_gpu, ignore = "AFTERIMAGE_NO_GPU is set")]
fn files_that_are_no_text_are_reported() {
    let folder = folder("no-text");
    folder.with("latin.ron", b"Pipeline(\n    // gr\xf6\xdfer\n)");
    folder.with("lut.ron", b"Pipeline(\n    inputs: { \"scene\": DisplayLinear },\n    nodes: { \"a\": ColorLut(source: \"scene\", file: \"none.cube\") },\n    outputs: { \"display\": \"a\" },\n)");
    folder.run("check latin.ron").fails_saying(
        1,
        &["error: cannot read the pipeline `latin.ron`: line 2 is not text in UTF-8\n  hint: save the file in that encoding"],
    );
    folder.run("check .").fails_saying(1, &["error: cannot read the pipeline `.`: it is a folder"]);
    folder.run("check none.ron").fails_saying(1, &["`none.ron`: there is no such file"]);
    folder.run("check lut.ron").fails_saying(1, &["cannot read `none.cube`: there is no such file", "lut.ron:3"]);
}

#[test]
#[cfg_attr(no_gpu, ignore = "AFTERIMAGE_NO_GPU is set")]
fn the_memory_of_a_plan_is_limited_before_it_runs() {
    let folder = Folder::new("plan-memory");
    folder.with("p.ron", br#"Pipeline(inputs: { "scene": Encoded }, nodes: {}, outputs: { "display": "scene" })"#);
    save(&folder.file("room.exr"), &room(64, 64));
    let line = "render p.ron room.exr -o out.png --gpu-memory";
    folder.run(&format!("{line} 1K")).fails_saying(1, &["may take at most 0.0 MiB", "`--gpu-memory SIZE` allows more"]);
    assert!(!folder.file("out.png").exists());
    folder.run(&format!("{line} 16M")).good();
}
