//! Names of inputs and outputs, folders of images, and files that are read as bytes and as text.

use std::path::Path;

use super::{Folder, message_and_hint};
use afterimage_media::sequence::{Input, Pattern, is_numbered, parse_frames};
use afterimage_media::*;

#[test]
fn numbered_names_are_told_from_names_with_layers_and_percents() {
    let folder = Folder::new("names-numbered");
    let literal = folder.with("take#3.png", b"");
    let table = [
        ("shot.exr", false),
        ("shot.####.exr", true),
        ("shot.#.exr", true),
        ("shot.%d.exr", true),
        ("shot.%03d.exr", true),
        ("shot.%3d.exr", true),
        ("100%.png", false),
        ("100%x.png", false),
        ("shot.exr#Z", false),
        ("shot.SXR#left.R", false),
        ("shot.mxr#Z", false),
        ("shot.hdr#Z", false),
        ("shot.png#Z", false),
        ("shot.dpx#Z", false),
        ("shot.webp#Z", false),
        ("shot.mov#Z", false),
        ("shot.##.exr#Z", true),
        ("shot.exr##", true),
        ("day##/shot.png", false),
        ("day##/shot.#.png", false),
        ("day#/shot.#.png", true),
        (literal.to_str().unwrap(), false),
    ];
    for (name, expected) in table {
        assert_eq!(is_numbered(name), expected, "{name}");
    }
}

#[test]
fn a_layer_is_what_follows_the_last_ending() {
    let table = [
        ("a.exr#R", "a.exr", Some("R")),
        ("a.b.png#c.d", "a.b.png", Some("c.d")),
        ("a.HDR#x", "a.HDR", Some("x")),
        ("a.sxr#left", "a.sxr", Some("left")),
        ("a.mxr#left", "a.mxr", Some("left")),
        ("a.exr", "a.exr", None),
    ];
    for (name, file, layer) in table {
        let expected = Source { path: file.into(), layer: layer.map(str::to_owned) };
        assert_eq!(Input::find(name, None), Ok(Input::Single(expected)), "{name}");
    }
}

#[test]
fn numbers_have_as_many_digits_as_the_placeholder() {
    let at = |name: &str, frame| Pattern::parse(name).map(|found| found.map(|pattern| pattern.at(frame)));
    let table = [
        ("a.%3d.png", 7, "a.007.png"),
        ("a.%03d.png", 7, "a.007.png"),
        ("a.%012d.png", 7, "a.000000000007.png"),
        ("a%b.%d.png", 12, "a%b.12.png"),
        ("x/a#.png", 123, "x/a123.png"),
        ("##", 5, "05"),
        ("dir#/a.##.png", 5, "dir#/a.05.png"),
    ];
    for (name, frame, expected) in table {
        assert_eq!(at(name, frame), Ok(Some(expected.into())), "{name}");
    }
    for name in ["a#b#.png", "a#.%d.png", "%d#.png", "%d%d"] {
        assert!(at(name, 1).unwrap_err().message.contains("more than one placeholder"), "{name}");
    }
    for name in ["##/a.png", "%d/a.#.png"] {
        assert_eq!(at(name, 1).unwrap_err().message, "a folder cannot be numbered", "{name}");
    }
    let folder = Folder::new("names-digits");
    std::fs::create_dir(folder.file("day##")).unwrap();
    let inside = folder.file("day##/a.##.png");
    assert_eq!(at(inside.to_str().unwrap(), 3), Ok(Some(folder.file("day##/a.03.png"))), "the folder is there");
}

#[test]
fn ranges_have_steps_and_an_end() {
    let frames = |text| parse_frames("--frames", text).map_err(|error| error.message);
    assert_eq!(frames("1-10:4"), Ok(vec![1, 5, 9]));
    assert_eq!(frames(" 3 , 5-5 "), Ok(vec![3, 5]));
    assert_eq!(frames("0"), Ok(vec![0]));
    assert_eq!(frames("1-1000000").map(|frames| frames.len()), Ok(1_000_000));
    assert_eq!(frames("1-1000001"), Err("these are more than 1000000 frames".to_owned()));
    assert_eq!(frames("1-1000000,1000001").unwrap_err(), "these are more than 1000000 frames");
    for text in ["1x2x3", "+1", "1-2-3", "1:", "4294967296"] {
        assert!(frames(text).unwrap_err().ends_with("is not a range"), "{text}");
    }
    assert_eq!(frames("1,2,1").unwrap_err(), "frame 1 is named twice");
}

#[test]
fn gaps_are_told_with_what_is_there() {
    let folder = Folder::new("names-gaps");
    for frame in [3, 6, 9, 15] {
        folder.with(&format!("a.{frame}.png"), b"");
    }
    let error = Input::find(folder.file("a.#.png").to_str().unwrap(), None).unwrap_err();
    assert_eq!(message_and_hint(&error), "frame 4 is missing; render it, or choose others, for example `--frames 3-3`");
    let error = Input::find(folder.file("a.#.png").to_str().unwrap(), Some("3,5")).unwrap_err();
    assert_eq!(message_and_hint(&error), "frame 5 is missing; render it, or choose other frames with `--frames`");
    let frames = Pattern::parse(folder.file("a.#.png").to_str().unwrap()).unwrap().unwrap().frames();
    assert_eq!(frames.unwrap(), [3, 6, 9, 15]);
    let two_digits = Pattern::parse(folder.file("a.##.png").to_str().unwrap()).unwrap().unwrap().frames();
    assert_eq!(two_digits.unwrap(), [15], "only names that the pattern would write");
}

#[test]
fn an_output_that_is_not_numbered_is_shown_numbered() {
    let sequence = Input::Sequence(vec![(1, Source::file("a")), (2, Source::file("b"))]);
    for (output, example) in [("out.png", "out.####.png"), ("v1.2/out", "v1.2/out.####"), ("a.b.exr", "a.b.####.exr")] {
        let error = sequence.outputs(output).unwrap_err();
        assert_eq!(error.hint, Some(format!("number the output, for example `{example}`")));
        assert_eq!((error.kind, error.path.to_str()), (ErrorKind::Naming, Some(output)));
    }
}

#[test]
fn the_images_of_a_folder_are_sorted_and_nothing_else_is_listed() {
    let folder = Folder::new("names-images");
    for name in ["b.exr", "a.PNG", "c.hdr", "d.txt", "png", "e.png.part"] {
        folder.with(name, b"");
    }
    std::fs::create_dir(folder.file("f.exr")).unwrap();
    let found = images_in(&folder.0).unwrap();
    assert_eq!(found, ["a.PNG", "b.exr", "c.hdr"].map(|name| folder.file(name)));
    let empty = images_in(&folder.file("f.exr")).unwrap_err();
    assert_eq!((empty.kind, empty.path.as_path()), (ErrorKind::Missing, folder.file("f.exr").as_path()));
    assert!(empty.message.contains("`.exr`, `.hdr` or `.png`"), "{empty}");
    assert_eq!(images_in(&folder.file("no")).unwrap_err().message, "there is no such file");
}

#[test]
fn a_file_is_read_up_to_its_limit_and_a_text_must_be_text() {
    let folder = Folder::new("names-bytes");
    let path = folder.with("text", "eins\nzwei\n".as_bytes());
    assert_eq!(read_bytes(&path, 10).unwrap(), b"eins\nzwei\n");
    assert_eq!(read_text(&path, 10).unwrap(), "eins\nzwei\n");
    let large = read_bytes(&path, 9).unwrap_err();
    assert_eq!(
        (large.kind, large.message.as_str()),
        (ErrorKind::TooLarge, "the file has 10 bytes, and at most 9 bytes are read")
    );
    for (bytes, line) in [(&b"\xff"[..], 1), (b"a\nb\xffc\nd", 2), (b"a\n\n\n\xc3", 4)] {
        let error = read_text(&folder.with("bytes", bytes), 100).unwrap_err();
        assert_eq!((error.kind, error.message), (ErrorKind::Broken, format!("line {line} is not text in UTF-8")));
    }
    assert_eq!(read_bytes(Path::new(""), 9).unwrap_err().message, "it is a folder");
    assert_eq!(read_bytes(&folder.0, 9).unwrap_err().message, "it is a folder");
    assert_eq!(read_bytes(&folder.file("no"), 9).unwrap_err().kind, ErrorKind::Missing);
    assert_eq!(read_bytes(&path.join("in"), 9).unwrap_err().message, "a part of this name is a file, not a folder");
}

#[cfg(unix)]
#[test]
fn real_paths_have_no_links_also_of_files_that_are_not_there_yet() {
    let folder = Folder::new("names-real");
    let root = std::fs::canonicalize(&folder.0).unwrap();
    std::fs::create_dir(folder.file("real")).unwrap();
    std::os::unix::fs::symlink("real", folder.file("link")).unwrap();
    std::os::unix::fs::symlink("link/new", folder.file("to-new")).unwrap();
    assert_eq!(real_path(&folder.file("link")).unwrap(), root.join("real"));
    assert_eq!(real_path(Path::new("")).unwrap(), std::fs::canonicalize(".").unwrap());
    assert_eq!(real_output_path(&folder.file("link/a.png")).unwrap(), root.join("real/a.png"));
    assert_eq!(real_output_path(&folder.file("to-new")).unwrap(), root.join("real/new"));
    assert_eq!(real_output_path(Path::new("new.png")).unwrap(), std::fs::canonicalize(".").unwrap().join("new.png"));
    let missing = real_output_path(&folder.file("no/a.png")).unwrap_err();
    assert_eq!((missing.kind, missing.hint.as_deref()), (ErrorKind::Missing, Some("create the folder first")));
    assert_eq!(real_path(&folder.file("no")).unwrap_err().kind, ErrorKind::Missing);
}

#[test]
fn every_known_signature_is_named() {
    let folder = Folder::new("names-signatures");
    let table: [(&[u8], &str); 14] = [
        (b"GIF89a", "this is a GIF"),
        (b"\x80\x2a\x5f\xd7", "this is a Cineon file"),
        (b"\0\0\0\x14ftypqt  ", "this is a film"),
        (b"\0\0\0\x20ftypisom\0\0\x02\0", "this is a film"),
        (b"\x1a\x45\xdf\xa3\x01\0", "this is a film"),
        (b"RIFF\0\0\0\0WEBPVP8 ", "this is a WebP"),
        (b"\xff\x0a....", "this is a JPEG XL"),
        (b"\0\0\0\x0cJXL \r\n\x87\n", "this is a JPEG XL"),
        (b"\0\0\0\x1cftypavif\0\0\0\0", "this is an AVIF"),
        (b"\0\0\0\x1cftypheic\0\0\0\0", "this is a HEIF"),
        (b"8BPS\0\x01", "this is a file of Photoshop"),
        (b"\0\0\0\x18ftypcrx \0\0\0\x01", "this is a raw file of a camera"),
        (b"FUJIFILMCCD-RAW 0201", "this is a raw file of a camera"),
        (b"II*.", "this is not an image that this program knows"),
    ];
    for (bytes, message) in table {
        let error = folder.read(bytes).unwrap_err();
        // These few bytes are then a file that ends too early.
        let is_read =
            cfg!(feature = "avif") && message.ends_with("AVIF") || cfg!(feature = "jxl") && message.ends_with("XL");
        if is_read {
            assert_eq!(error.kind, ErrorKind::Broken, "{message}");
        } else {
            assert_eq!((error.kind, error.message.as_str()), (ErrorKind::Unsupported, message));
        }
    }
    let layer = match Input::find(&format!("{}#Z", folder.with("a.psd", b"8BPS\0\x01").display()), None).unwrap() {
        Input::Single(source) => source,
        Input::Sequence(_) => panic!("one file has a layer"),
    };
    assert_eq!(
        (&*read(&layer).unwrap_err().message, layer.layer.as_deref()),
        ("this is a file of Photoshop", Some("Z"))
    );
    let raw = read(&Source::file(folder.with("shot.raw", b"\x01\x02\x03\x04"))).unwrap_err();
    assert_eq!(raw.message, "this is a raw file of a camera, by its name");
    assert!(raw.hint.is_some_and(|way| way.contains("darktable-cli")));
    let source = Source::file(folder.with("short", b"\x89PNG\r\n\x1a"));
    assert_eq!(read(&source).unwrap_err().kind, ErrorKind::Unsupported, "one byte of the signature is missing");
}

#[test]
fn written_files_are_the_encoded_ones() {
    let folder = Folder::new("names-written");
    let bytes = [1, 2, 3, 255];
    let pixels = Samples::Byte(&bytes);
    let (png, jpeg) = (Encoding::PNG, Encoding::JPEG);
    write_image(&folder.file("a.png"), ((1, 1), pixels), &png).unwrap();
    write_image(&folder.file("a.jpg"), ((1, 1), pixels), &jpeg).unwrap();
    let (picture, exr) = (super::picture(2, 2), Encoding::EXR);
    write_image(&folder.file("a.exr"), &picture, &exr).unwrap();
    assert_eq!(std::fs::read(folder.file("a.png")).unwrap(), encode(((1, 1), pixels), &png).unwrap());
    assert_eq!(std::fs::read(folder.file("a.jpg")).unwrap(), encode(((1, 1), pixels), &jpeg).unwrap());
    assert_eq!(std::fs::read(folder.file("a.exr")).unwrap(), encode(&picture, &exr).unwrap());
    let nowhere = folder.file("no/a.png");
    let wide = write_image(&nowhere, ((70_000, 1), pixels), &png).unwrap_err();
    assert_eq!((wide.kind, wide.path), (ErrorKind::TooLarge, nowhere), "the path is that of the file");
}
