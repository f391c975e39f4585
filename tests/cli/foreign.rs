//! Formats that are not read, and films where images are read: in each place one sentence, and the way to get in.

use super::{Folder, room, save};

const PIPELINE: &str = r#"Pipeline(
    inputs: { "scene": Color, "mask": Mask(optional: true) },
    nodes: { "exposed": Exposure(source: "scene"), "gray": Saturation(source: "exposed", amount: 0.0),
             "within": Mix(source: "exposed", other: "gray", mask: "mask") },
    outputs: { "light": "within" },
)"#;

/// An ending, the start of such a file, its name for users, and a part of the way.
const FORMATS: [(&str, &[u8], &str, &str); 6] = [
    ("webp", b"RIFF\0\0\0\0WEBPVP8 ", "a WebP", "`ffmpeg -i IN.webp OUT.png`"),
    ("psd", b"8BPS\0\x01", "a file of Photoshop", "`magick 'IN.psd[0]' OUT.png`"),
    ("heic", b"\0\0\0\x1cftypheic\0\0\0\0", "a HEIF", "`heif-dec IN.heic OUT.png`"),
    ("gif", b"GIF89a", "a GIF", "`ffmpeg -i IN.gif frame.%04d.png`"),
    ("raw", b"\x01\x02\x03\x04", "a raw file of a camera", "`darktable-cli IN.raw OUT.exr`"),
    ("cin", b"\x80\x2a\x5f\xd7", "a Cineon file", "`oiiotool IN.cin -d uint10 -o OUT.dpx`"),
];

fn folder(test: &str) -> Folder {
    let folder = Folder::new(test);
    folder.with("p.ron", PIPELINE.as_bytes());
    save(&folder.file("in.exr"), &room(16, 9));
    folder
}

#[test]
#[cfg_attr(no_gpu, ignore = "AFTERIMAGE_NO_GPU is set")]
fn a_format_that_is_not_read_has_a_way_in_wherever_it_is_given() {
    let folder = folder("foreign");
    for (ending, start, what, way) in FORMATS {
        folder.with(&format!("a.{ending}"), start);
        folder.with(&format!("s.1.{ending}"), start);
        for place in [
            "render p.ron FILE -o out.exr",
            "render p.ron in.exr --input mask=FILE -o out.exr",
            "render p.ron FILE#layer -o out.exr",
            "render p.ron s.#.ENDING -o out.#.exr",
            "info FILE",
            "measure p.ron FILE",
            "check FILE",
            "plan FILE",
            "render FILE in.exr -o out.exr",
        ] {
            let line = place.replace("FILE", &format!("a.{ending}")).replace("ENDING", ending);
            folder.run(&line).fails_saying(1, &[what, way]);
        }
        folder
            .run(&format!("render p.ron in.exr -o out.{ending}"))
            .fails_saying(1, &[&format!("`out.{ending}` would be {what}, which is not written"), "oiiotool"]);
    }
}

#[test]
#[cfg_attr(no_gpu, ignore = "AFTERIMAGE_NO_GPU is set")]
fn a_film_has_a_way_in_wherever_it_is_no_film() {
    let folder = folder("foreign-films");
    folder.with("a.mov", b"\0\0\0\x14ftypqt  ");
    for (line, message) in [
        ("render p.ron a.mov#layer -o out.#.exr", "only EXR files have layers"),
        ("info a.mov#layer", "only EXR files have layers"),
        ("measure p.ron a.mov", "this is a film"),
        ("check a.mov", "`a.mov` is a film, not a pipeline"),
        ("render p.ron a.####.mov -o out.#.exr", "a film has all of its frames in one file"),
        ("render p.ron in.exr -o out.####.mov", "a film has all of its frames in one file"),
        ("pipelines lynx --write a.mov", "`a.mov` is no name of a pipeline"),
    ] {
        folder.run(line).fails_saying(1, &[message, "hint: "]);
    }
}
