//! Several outputs of one pipeline, each in its file.

use afterimage_media::{Source, read};

use super::{Folder, room, save};

fn folder(test: &str) -> Folder {
    let folder = Folder::new(test);
    save(&folder.file("room.exr"), &room(12, 8));
    folder
}

#[test]
#[cfg_attr(no_gpu, ignore = "AFTERIMAGE_NO_GPU is set")]
fn an_sdr_and_an_hdr_image_come_from_one_run() {
    let folder = folder("two-outputs");
    folder.run("render {hdr} room.exr --output sdr=sdr.png --output hdr=hdr.png --depth 16").good();
    assert_eq!(folder.names(), ["hdr.png", "room.exr", "sdr.png"]);
    folder.run("render {hdr} room.exr -o same.png --output hdr=again.png").good();
    let pixels = |name: &str| read(&Source::file(folder.file(name))).expect("a picture").pixels.to_f32();
    assert_eq!(pixels("again.png").len(), 12 * 8 * 4);
    assert_ne!(pixels("same.png"), pixels("again.png"), "the first output that fits is the SDR image");
    let shown = folder.run("plan {hdr}").good();
    assert!(shown.contains("  hdr  Encoded: Pq, Rec2020, white at 203 cd/m2, peak at 1000 cd/m2"), "{shown}");
}

#[test]
#[cfg_attr(no_gpu, ignore = "AFTERIMAGE_NO_GPU is set")]
fn every_frame_of_a_sequence_has_all_files() {
    let folder = folder("two-sequences");
    for frame in [1, 2] {
        save(&folder.file(&format!("shot.{frame:04}.exr")), &room(12, 8));
    }
    folder.run("render {hdr} shot.####.exr --output sdr=sdr.##.png --output hdr=hdr.##.png").good();
    let made = ["hdr.01.png", "hdr.02.png", "room.exr", "sdr.01.png", "sdr.02.png", "shot.0001.exr", "shot.0002.exr"];
    assert_eq!(folder.names(), made);
}

#[test]
#[cfg_attr(no_gpu, ignore = "AFTERIMAGE_NO_GPU is set")]
fn what_cannot_be_written_is_said_before_anything_is_rendered() {
    let folder = folder("no-outputs");
    let table = [
        ("render {hdr} room.exr", "error: no file to write\n  hint: name it: `-o out.png`"),
        (
            "render {hdr} room.exr --output hdr",
            "error: no file is named for the output `hdr`\n  hint: write `--output hdr=FILE` for each output",
        ),
        (
            "render {hdr} room.exr --output sdr=a.png --output hdr=a.png",
            "error: two outputs go to the file `a.png`\n  hint: name a file for each",
        ),
        (
            "render {hdr} room.exr --output sdr=a.png --output sdr=b.png",
            "error: two files are named for the output `sdr`\n  hint: name one",
        ),
        (
            "render {hdr} room.exr --output sdr=a.png --output hdr=b.gif",
            "error: `b.gif` ends in none of `.png`, `.jpg`, `.avif` and `.exr`\n  hint: `.png`, `.jpg` and `.avif` take an \
             encoded output, `.exr` a linear one",
        ),
        (
            "render {hdr} room.exr --output sdr=a.png --output final=b.png",
            "error: the pipeline has no output `final`\n  hint: it has `sdr` (Encoded), `hdr` (Encoded)",
        ),
    ];
    for (line, words) in table {
        folder.run(line).fails(1, words);
    }
    assert_eq!(folder.names(), ["room.exr"]);
}
