//! No output replaces a file of its own run.

use std::collections::BTreeMap;
use std::fs;

use super::{Folder, room, save};

const NODE: &str = r#"Kind(
    name: "Glow",
    doc: "Brightens.",
    inputs: { "source": Image(doc: "The image.", accepts: [Encoded]) },
    outputs: { "result": Image(doc: "The image.", state: Same("source")) },
)"#;
const SHADER: &str = "fn glow(source: vec4f) -> vec4f { return source; }\n";

const PIPELINE: &str = r#"Pipeline(
    inputs: { "scene": Encoded },
    nodes: { "glow": Glow(source: "scene") },
    outputs: { "display": "glow", "same": "scene" },
)"#;

fn folder(test: &str) -> Folder {
    let folder = Folder::new(test);
    fs::create_dir_all(folder.file("kinds/glow")).expect("a temporary folder");
    folder.with("kinds/glow/node.ron", NODE.as_bytes());
    folder.with("kinds/glow/glow.wgsl", SHADER.as_bytes());
    folder.with("p.ron", PIPELINE.as_bytes());
    folder.with("base.ron", b"Pipeline(extends: \"p.ron\")");
    save(&folder.file("room.exr"), &room(12, 8));
    for frame in 1..=2 {
        save(&folder.file(&format!("shot.{frame}.exr")), &room(12, 8));
    }
    folder
}

/// The bytes of the files whose loss would be one.
fn contents(folder: &Folder) -> BTreeMap<&'static str, Vec<u8>> {
    let names =
        ["p.ron", "base.ron", "room.exr", "shot.1.exr", "shot.2.exr", "kinds/glow/node.ron", "kinds/glow/glow.wgsl"];
    names.map(|name| (name, fs::read(folder.file(name)).expect("it is still there"))).into()
}

/// That each command is refused with these words, before anything is written.
fn refused(folder: &Folder, table: &[(&str, &str)]) {
    let (names, before) = (folder.names(), contents(folder));
    for (line, words) in table {
        folder.run(&format!("{line} --nodes kinds")).fails_saying(1, &[words]);
        assert_eq!(folder.names(), names, "{line}");
        assert_eq!(contents(folder), before, "{line}");
    }
}

#[test]
fn a_report_does_not_replace_what_is_rendered() {
    let folder = folder("own-inputs");
    refused(
        &folder,
        &[
            ("render p.ron room.exr -o out.png --json ./room.exr", "./room.exr: this is the image of input `scene`"),
            (
                "render p.ron shot.#.exr -o out.#.png --json shot.2.exr",
                "shot.2.exr: this is the image of input `scene`",
            ),
            ("render p.ron shot.1.exr -o out.png --json kinds/glow/glow.wgsl", "this is a file of a node kind"),
            ("render p.ron room.exr -o out.png --json kinds/glow/node.ron", "this is a file of a node kind"),
            ("render base.ron room.exr -o out.png --json p.ron", "p.ron: this is a file that the pipeline uses"),
            (
                "render p.ron room.exr -o out.png --json ./out.png",
                "two outputs go to one file: `out.png` and `./out.png`",
            ),
            ("render p.ron shot.#.exr -o out.#.png --json out.2.png", "two outputs go to the file `out.2.png`"),
            ("stress p.ron --quick --json kinds/glow/node.ron", "this is a file of a node kind"),
        ],
    );
}

#[test]
fn two_outputs_are_two_files() {
    let folder = folder("own-outputs");
    let line = |second: &str| format!("render p.ron room.exr --output display=t.png --output same={second}");
    for second in ["t.png", "./t.png", "kinds/../t.png"] {
        refused(&folder, &[(&line(second), "two outputs go to")]);
    }
    #[cfg(target_os = "linux")]
    {
        folder.link("link.png", "t.png");
        refused(&folder, &[(&line("link.png"), "two outputs go to one file: `t.png` and `link.png`")]);
    }
}

#[test]
#[cfg_attr(no_gpu, ignore = "AFTERIMAGE_NO_GPU is set")]
fn figures_do_not_replace_what_is_measured() {
    let folder = folder("own-figures");
    folder.with("room-b.png", b"");
    refused(
        &folder,
        &[
            ("measure p.ron room.exr --json room.exr", "room.exr: this is an image that is measured"),
            ("measure p.ron shot.#.exr --frames 1-2 --json shot.2.exr", "this is an image that is measured"),
            ("measure p.ron room.exr --json f.json --plot f.svg --plot ./f.svg", "two outputs go to one file"),
            ("measure p.ron room.exr room-b.png --error-image .", "an output may replace an image that is measured"),
            ("tune p.ron room.exr --error 1 -o room.exr", "this is an image that is measured"),
            ("tune p.ron room.exr --error 1 -o t.ron --state ./t.ron", "two outputs go to one file"),
            ("tune p.ron room.exr --error 1 --state kinds/glow/glow.wgsl", "this is a file of a node kind"),
            ("bench p.ron --size 16x16 --frames 1 --json kinds/glow/glow.wgsl", "this is a file of a node kind"),
        ],
    );
}

#[test]
#[cfg(target_os = "linux")]
#[cfg_attr(no_gpu, ignore = "AFTERIMAGE_NO_GPU is set")]
fn a_link_to_no_file_gets_one_and_hard_links_are_parted() {
    let folder = folder("own-links");
    folder.link("dangling.png", "new.png");
    folder.run("render p.ron room.exr -o dangling.png --nodes kinds").good();
    assert!(folder.file("dangling.png").is_symlink() && folder.file("new.png").is_file());
    let room = fs::read(folder.file("room.exr")).expect("a picture");
    fs::hard_link(folder.file("room.exr"), folder.file("hard.png")).expect("a link");
    folder.run("render p.ron room.exr -o hard.png --nodes kinds").good();
    assert!(fs::read(folder.file("room.exr")).expect("a picture") == room);
    assert!(fs::read(folder.file("hard.png")).expect("a picture") != room);
}
