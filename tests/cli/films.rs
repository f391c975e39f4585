//! Films as far as they go without `ffmpeg`, which these tests take away, and pipes. `tests/oracles.sh` lets others
//! judge what is read and written with it.

use std::io::Write as _;
use std::process::Stdio;

use super::{Folder, Outcome, room, save};

const GRADE: &str = r#"Pipeline(
    inputs: { "scene": Color },
    nodes: { "mapped": ToneMap(source: "exposed"), "exposed": Exposure(source: "scene"),
             "display": Encode(source: "mapped", transfer: Srgb) },
    outputs: { "display": "display", "light": "exposed" },
)"#;

fn folder(test: &str) -> Folder {
    let folder = Folder::new(test);
    folder.with("grade.ron", GRADE.as_bytes());
    for frame in 1..=2 {
        save(&folder.file(&format!("shot.{frame}.exr")), &room(16, 9));
    }
    folder
}

const LOOK: &str = r#"Pipeline(inputs: { "scene": DisplayLinear }, outputs: { "display": "look" },
    nodes: { "look": ColorLut(source: "scene", file: "FILE", from: Srgb) },
)"#;

#[test]
fn a_film_without_ffmpeg_is_refused_before_a_frame_is_rendered() {
    let folder = folder("no-ffmpeg");
    folder.with("in.mov", b"\0\0\0\x14ftypqt  ");
    let before = folder.names();
    for (line, file, program) in [
        ("render grade.ron shot.#.exr -o out.mov", "out.mov", "ffmpeg"),
        ("render grade.ron in.mov -o out.#.png", "in.mov", "ffprobe"),
        ("meter exposure in.mov -o out.meter", "in.mov", "ffprobe"),
        ("info in.mov", "in.mov", "ffprobe"),
    ] {
        let output = folder.command(line).env("PATH", &folder.0).output().expect("the program starts");
        Outcome::of(&output).fails(
            2,
            &format!(
                "error: {file}: a film needs the program `{program}`, and there is none on the PATH\n  hint: install \
                 `ffmpeg`, from 5.1 on; or use numbered images: `frame.####.png`"
            ),
        );
    }
    assert_eq!(folder.names(), before);
}

#[test]
fn options_that_no_film_can_have_are_refused() {
    let folder = folder("film-options");
    for (options, error) in [
        ("-o a.png --frames 1 --video prores", "`--video` is for films, and none is written"),
        (
            "-o a.mov --video vp9",
            "`--video vp9` is no codec here\n  hint: there are prores, prores4444, h264, hevc, ffv1",
        ),
        ("-o a.mp4 --video prores", "prores is no codec of `a.mp4`\n  hint: its files are .mov"),
        ("-o a.avi", "no codec here writes `a.avi`\n  hint: films are written as .mov, .mp4 and .mkv"),
        ("-o a.mov --depth 16", "a film of prores has 10 bits"),
        ("-o a.mov --skip-existing", "`--skip-existing` is for numbered images, and `a.mov` is one film"),
        ("-o a.mov --output light", "output `light` is Exposed, and this file holds encoded pictures"),
    ] {
        folder.run(&format!("render grade.ron shot.#.exr {options}")).fails_saying(1, &[error]);
    }
    folder
        .run("render grade.ron shot.1.exr -o a.mov")
        .fails_saying(1, &["`a.mov` is a film, which is made of frames, and here is one image"]);
    folder.run("job grade.ron shot.#.exr -o a.mov").fails_saying(1, &["`a.mov` is a film, which one task writes"]);
    folder.run("render grade.ron shot.#.exr -o -").fails_saying(1, &["standard output takes one image"]);
    folder.run("render grade.ron shot.1.exr -o - --openjd").fails_saying(1, &["`--openjd` prints to standard output"]);
    folder.run("render grade.ron missing.mov -o a.mov").fails_saying(1, &["missing.mov: there is no such file"]);
}

#[test]
#[cfg_attr(no_gpu, ignore = "AFTERIMAGE_NO_GPU is set")]
fn other_programs_can_be_before_and_after() {
    let folder = folder("pipes");
    folder.run("render grade.ron shot.1.exr -o file.png").good();
    folder.run("render grade.ron shot.1.exr -o file.exr --drop-layers").good();
    let image = std::fs::read(folder.file("shot.1.exr")).expect("an image");
    for (line, file) in [
        ("render grade.ron - -o -", "file.png"),
        ("render grade.ron - -o - --output light", "file.exr"),
        ("render grade.ron shot.#.exr --frames 1 -o -", "file.png"),
    ] {
        let mut command = folder.command(line);
        let command = command.stdin(Stdio::piped()).stdout(Stdio::piped()).stderr(Stdio::piped());
        let mut child = command.spawn().expect("the program starts");
        // The program may not read it.
        let _ = child.stdin.take().expect("a pipe").write_all(&image);
        let output = child.wait_with_output().expect("the program ends");
        assert!(output.status.success(), "{line}: {}", String::from_utf8_lossy(&output.stderr));
        assert!(output.stdout == std::fs::read(folder.file(file)).expect("a file"), "{line}");
    }
    assert!(!folder.file("-").exists());
    folder.run("render grade.ron - -o out.png").fails_saying(1, &["error: standard input: the file is empty"]);
}

/// Every format that people bring, wherever it is given.
#[test]
fn a_file_of_another_format_is_told_the_way_in() {
    let folder = folder("foreign");
    for (name, bytes, what, way) in [
        ("a.mp4", &b"\0\0\0\x20ftypisom"[..], "a film", "-o out.mov`"),
        ("a.webp", b"RIFF\0\0\0\0WEBP", "a WebP", "`ffmpeg -i IN.webp OUT.png`"),
        ("a.jxl", b"\xff\x0a\0\0", "a JPEG XL", "`djxl IN.jxl OUT.png`"),
        ("a.avif", b"\0\0\0\x1cftypavif", "an AVIF", "`avifdec --depth 16 IN.avif OUT.png`"),
        ("a.cin", b"\x80\x2a\x5f\xd7\0\0", "a Cineon file", "`oiiotool IN.cin -d uint10 -o OUT.dpx`"),
        ("a.psd", b"8BPS\0\x01\0\0", "a file of Photoshop", "`magick 'IN.psd[0]' OUT.png`"),
        ("a.raw", b"\x01\0\x03\x04", "a raw file of a camera", "`darktable-cli IN.raw OUT.exr`"),
    ] {
        folder.with(name, bytes);
        folder.with("any.exr", bytes);
        if what != "a film" {
            folder.run(&format!("info {name}")).fails_saying(1, &[&format!("{name}: this is {what}"), way]);
        }
        folder.run(&format!("check {name}")).fails_saying(1, &[&format!("`{name}` is {what}, not a pipeline")]);
        if what != "a film" {
            let of_input = folder.run(&format!("render grade.ron {name} -o out.png"));
            of_input.fails_saying(1, &[&format!("{name}: this is {what}"), way]);
            folder.run(&format!("check {name}")).fails_saying(1, &[way]);
            let of_output = folder.run(&format!("render grade.ron shot.1.exr -o {name}"));
            of_output.fails_saying(1, &[&format!("`{name}` would be {what}, which is not written"), "convert it"]);
        }
        folder.with("look.ron", LOOK.replace("FILE", name).as_bytes());
        folder
            .run("check look.ron")
            .fails_saying(1, &[&format!("`{name}`: the file is neither a table"), "are converted"]);
        if name != "a.raw" {
            folder.run("info any.exr").fails_saying(1, &[&format!("any.exr: this is {what}"), way]);
        }
    }
    for name in ["a.dpx", "a.hdr"] {
        let of_output = folder.run(&format!("render grade.ron shot.1.exr -o {name}"));
        of_output.fails_saying(1, &[&format!("`{name}` would be a "), "file, which is not written", "convert it"]);
    }
}
