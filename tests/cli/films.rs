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
        save(&folder.file(&format!("shot.{frame}.exr")), &room(16, 10));
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
    save(&folder.file("odd.1.exr"), &room(16, 9));
    folder.run("render grade.ron odd.#.exr -o a.mp4 --video hevc --output display").fails(
        1,
        "error: a.mp4: hevc has even sides, and frames are 16x9\n  hint: `--crop 0,0,16x8` leaves a column or a row \
         out; a `.mov` of `--video prores` has any size",
    );
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

/// Programs by the names of `ffmpeg` and `ffprobe`: one notes its words, and hands on its input, or the frames of a
/// film; with a file `short` it ends well after a part, and says what is there. The other says what a film is.
#[cfg(unix)]
const PROGRAMS: [(&str, &str); 2] = [
    (
        "ffmpeg",
        "#!/bin/sh\n[ \"$1\" = -version ] && exit\ncase \"$*\" in *rawvideo*) exec cat film.raw;; esac\n\
         printf '%s\\n' \"$@\" > words\nfor last; do :; done\ncat > all\n\
         if [ -e short ]; then head -c 1000 all; cat short >&2; else cat all; fi > \"${last#file:}\"\n",
    ),
    (
        "ffprobe",
        "#!/bin/sh\n[ \"$1\" = -version ] && exit\nfor last; do :; done\n\
         case \"$*\" in *packet=*in.mov) cat film.times;; \
         *packet=*) LC_ALL=C grep -aoP '\\x1f\\x43\\xb6\\x75' \"${last#file:}\" | sed 's/.*/0,K__/';; \
         *'-select_streams a'*) echo pcm_s16le;; *) cat film.stated;; esac\n",
    ),
];

/// Runs a line with these programs. Returns what it says, and the words for `ffmpeg`.
#[cfg(unix)]
fn with_programs(folder: &Folder, line: &str) -> (Outcome, Vec<String>) {
    for (name, text) in PROGRAMS {
        folder.with(&format!("{name}.text"), text.as_bytes());
        // A program that this process writes could still be open in a child of another test, and not be started.
        let copy = format!("mkdir -p programs && cp {name}.text programs/{name} && chmod 755 programs/{name}");
        let made = std::process::Command::new("sh").current_dir(&folder.0).args(["-c", &copy]).status();
        assert!(made.expect("a shell").success());
    }
    let path = format!("{}:/usr/bin:/bin", folder.file("programs").display());
    let output = folder.command(line).env("PATH", path).output().expect("the program starts");
    let words = std::fs::read_to_string(folder.file("words")).unwrap_or_default();
    (Outcome::of(&output), words.lines().map(str::to_owned).collect())
}

/// The word after an option.
#[cfg(unix)]
fn after<'a>(words: &'a [String], option: &str) -> &'a str {
    let at = words.iter().position(|word| word == option);
    at.map_or("", |at| words[at + 1].as_str())
}

/// The frames in a stream for `ffmpeg`, and their times in nanoseconds: each is behind the mark of its cluster.
#[cfg(unix)]
fn frames(folder: &Folder, film: &str) -> Vec<(u64, Vec<u8>)> {
    let stream = std::fs::read(folder.file(film)).expect("a film");
    let clusters = stream.windows(4).enumerate().filter(|(_, mark)| *mark == [0x1f, 0x43, 0xb6, 0x75]);
    let starts: Vec<usize> = clusters.map(|(at, _)| at).collect();
    let ends = starts.iter().skip(1).copied().chain([stream.len()]);
    let cluster = |(start, end): (&usize, usize)| {
        let time = stream[start + 21..start + 29].try_into().expect("eight bytes");
        (u64::from_be_bytes(time), stream[start + 42..end].to_vec())
    };
    starts.iter().zip(ends).map(cluster).collect()
}

/// The codes are those of ITU-T H.273, and HDR in an `.mp4` is HEVC.
#[test]
#[cfg(unix)]
#[cfg_attr(no_gpu, ignore = "AFTERIMAGE_NO_GPU is set")]
fn colors_choose_the_codec_and_its_codes() {
    let folder = folder("film-colors");
    for (encoding, codec, codes) in [
        ("Srgb", "libx264", ["1", "13", "1"]),
        ("Gamma, gamma: 2.4", "libx264", ["1", "1", "1"]),
        ("Pq, primaries: Rec2020", "libx265", ["9", "16", "9"]),
        ("Hlg, primaries: Rec2020", "libx265", ["9", "18", "9"]),
    ] {
        folder.with("color.ron", GRADE.replace("Srgb", encoding).as_bytes());
        let (outcome, words) =
            with_programs(&folder, "render color.ron shot.#.exr -o out.mp4 --fps 25 --output display");
        outcome.good();
        let found = ["-color_primaries", "-color_trc", "-colorspace"].map(|option| after(&words, option));
        assert_eq!((after(&words, "-c:v"), found, after(&words, "-f")), (codec, codes, "matroska"), "{encoding}");
        assert_eq!(after(&words, "-color_range"), "tv");
        let frames = frames(&folder, "out.mp4");
        assert_eq!(frames.iter().map(|(time, _)| *time).collect::<Vec<_>>(), [0, 40_000_000], "{encoding}");
        // Three planes of two bytes.
        assert!(frames.iter().all(|(_, frame)| frame.len() == 16 * 10 * 3 * 2), "{encoding}");
    }
}

/// Frames 2 and 3 of four at 23.976 a second, in 8 bits; `1:a?` is its sound, if it has any.
#[test]
#[cfg(unix)]
#[cfg_attr(no_gpu, ignore = "AFTERIMAGE_NO_GPU is set")]
fn a_part_of_a_film_has_its_times_and_its_sound() {
    let folder = folder("film-part");
    folder.with("in.mov", b"\0\0\0\x14ftypqt  ");
    folder.with(
        "film.stated",
        b"codec_name=prores\nwidth=16\nheight=10\nsample_aspect_ratio=4:3\npix_fmt=yuv422p\ncolor_range=tv\n\
          color_space=bt709\ncolor_transfer=bt709\ncolor_primaries=bt709\nfield_order=progressive\n\
          time_base=1/24000\nTAG:timecode=01:00:00:00\nstart_time=0.000000\n",
    );
    folder.with("film.times", b"0,K__\n2002,___\n1001,___\n3003,___\n");
    // Black, middle gray, white, black, without a color.
    let film = [16, 126, 235, 16].map(|luma| [[luma; 160], [128; 160], [128; 160]]);
    folder.with("film.raw", film.as_flattened().as_flattened());
    let (outcome, words) = with_programs(&folder, "render grade.ron in.mov -o out.mp4 --frames 2-3 --output display");
    let said = outcome.notes();
    assert!(said.contains("the sound is encoded as AAC"), "{said}");
    for (option, wanted) in [
        ("-ss", "0.041708"),
        ("-t", "0.083417"),
        ("-timecode", "01:00:00:01"),
        ("-c:a", "aac"),
        ("-enc_time_base", "1/24000"),
        ("-video_track_timescale", "24000"),
        ("-itsoffset", "0.000000"),
    ] {
        assert_eq!(after(&words, option), wanted, "{option} of {words:?}");
    }
    assert!(words.iter().any(|word| word.contains("setsar=4/3")) && words.contains(&"1:a?".to_owned()), "{words:?}");
    let found = frames(&folder, "out.mp4");
    assert_eq!(found.iter().map(|(time, _)| *time).collect::<Vec<_>>(), [0, 41_708_333]);
    let luma = |frame: &[u8]| u16::from_le_bytes([frame[0], frame[1]]);
    let [gray, white] = [0, 1].map(|at| luma(&found[at].1));
    assert!((300..700).contains(&gray) && white > gray + 100, "{gray} and {white}");
}

/// A version of `ffmpeg` ends well on a full disk.
#[test]
#[cfg(unix)]
#[cfg_attr(no_gpu, ignore = "AFTERIMAGE_NO_GPU is set")]
fn a_film_without_an_end_replaces_nothing() {
    let folder = folder("film-short");
    for (said, error) in [
        ("Error writing trailer of a.mov: No space left on device", "out.mov: the disk is full\n  hint: make room"),
        ("", "out.mov: the film was written, but has 1 of 2 frames"),
    ] {
        folder.with("out.mov", b"the film that was there");
        folder.with("short", said.as_bytes());
        let (outcome, _) = with_programs(&folder, "render grade.ron shot.#.exr -o out.mov --json out.json");
        outcome.fails_saying(2, &[error]);
        assert_eq!(std::fs::read(folder.file("out.mov")).expect("a file"), b"the film that was there");
        let json = std::fs::read_to_string(folder.file("out.json")).expect("a report");
        let words = error.split('\n').next().unwrap_or_default();
        assert!(json.contains(&format!("\"failure\": \"{words}")) && json.contains("\"unwritten\": 2"), "{json}");
        assert!(!json.contains("\"good\": 2") && !json.contains("\"outcome\": \"good\""), "{json}");
    }
}
