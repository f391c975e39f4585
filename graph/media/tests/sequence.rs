//! Frame numbers in names.

use std::fs;

use super::{Folder, message_and_hint};
use afterimage_media::sequence::{FrameFiles, Input, Pattern, StandIn, parse_frames};
use afterimage_media::*;

/// A folder with empty files `shot.NNNN.exr`.
fn shots(test: &str, frames: &[u32]) -> Folder {
    let folder = Folder::new(test);
    frames.iter().for_each(|frame| drop(folder.with(&format!("shot.{frame:04}.exr"), b"")));
    folder
}

fn find(folder: &Folder, name: &str, frames: Option<&str>) -> Result<Input, FileError> {
    Input::find(folder.file(name).to_str().unwrap(), frames)
}

fn numbers(input: &Input) -> Vec<u32> {
    input.sources().into_iter().filter_map(|(frame, _)| frame).collect()
}

#[test]
fn patterns_make_names() {
    let at = |pattern: &str, frame| Pattern::parse(pattern).unwrap().unwrap().at(frame).to_str().unwrap().to_owned();
    assert_eq!(at("a/shot.####.exr", 7), "a/shot.0007.exr");
    assert_eq!(at("shot.####.exr", 123_456), "shot.123456.exr");
    assert_eq!(at("shot_#.png", 42), "shot_42.png");
    assert_eq!(at("%04d.exr", 42), "0042.exr");
    assert_eq!(at("shot.%d.exr", 42), "shot.42.exr");
    for plain in ["shot.exr", "100%.png", "50%x.png", ""] {
        assert_eq!(Pattern::parse(plain), Ok(None), "{plain}");
    }
}

#[test]
fn ranges_are_parsed_or_explained() {
    assert_eq!(parse_frames("--frames", "1-5").unwrap(), [1, 2, 3, 4, 5]);
    assert_eq!(parse_frames("--frames", "1-10x4").unwrap(), [1, 5, 9]);
    assert_eq!(parse_frames("--frames", "7, 10-12,3").unwrap(), [7, 10, 11, 12, 3]);
    let hint = "write `1-96`, `1-96x2` for every second one, `7`, or several of these with commas";
    let table = [
        ("", "`` is not a range", hint),
        ("1-", "`1-` is not a range", hint),
        ("a-b", "`a-b` is not a range", hint),
        ("-5", "`-5` is not a range", hint),
        ("1-+5", "`1-+5` is not a range", hint),
        ("1-9x0", "a step of 0 never ends", hint),
        ("1-5,3", "frame 3 is named twice", hint),
        ("0-4000000000", "these are more than 1000000 frames", hint),
        ("9-1", "`9-1` runs backwards", "write `1-9`"),
    ];
    for (text, message, hint) in table {
        assert_eq!(
            message_and_hint(&parse_frames("--frames", text).unwrap_err()),
            format!("{message}; {hint}"),
            "{text}"
        );
    }
}

#[test]
fn frames_are_found_in_the_order_of_their_numbers() {
    let folder = shots("found", &[9, 10, 11, 8]);
    folder.with("shot.09.exr", b"");
    folder.with("shot.00012.exr", b"");
    folder.with("shot.0012.exr.part", b"");
    let input = find(&folder, "shot.####.exr", None).unwrap();
    assert_eq!(numbers(&input), [8, 9, 10, 11]);
    assert_eq!(input.sources()[0].1, Source::file(folder.file("shot.0008.exr")));
    assert_eq!(numbers(&find(&folder, "shot.%04d.exr", Some("8-10x2")).unwrap()), [8, 10]);
    folder.with("shot.99999.exr", b"");
    let wide = find(&folder, "shot.####.exr", Some("99999")).unwrap();
    assert_eq!(wide.sources()[0].1.path, folder.file("shot.99999.exr"));
}

#[test]
fn numbers_that_the_pattern_does_not_write_are_named() {
    let folder = shots("others", &[1, 2]);
    let others = ["shot.1.exr", "shot.00003.exr", "shot.-0004.exr", "shot.+0005.exr", "shot.0006.EXR", "Shot.0007.exr"];
    let large = ["shot.4294967296.exr", "shot.99999999999999999999.exr"];
    for name in others.into_iter().chain(large).chain(["shot.0008.exr.part", "shot.0009a.exr", "shots.0010.exr"]) {
        folder.with(name, b"");
    }
    let mut expected: Vec<&str> = others.into_iter().chain(large).collect();
    expected.sort_unstable();
    let other_numbers = |name: &str| sequence::other_numbers(folder.file(name).to_str().unwrap());
    assert_eq!(other_numbers("shot.####.exr"), expected);
    assert_eq!(other_numbers("shot.####.exr#diffuse"), expected);
    assert_eq!(other_numbers("shot.0001.exr"), Vec::<String>::new());
    assert_eq!(other_numbers("nothing.####.exr"), Vec::<String>::new());
    let error = find(&folder, "shot.##########.exr", None).unwrap_err();
    assert_eq!(
        message_and_hint(&error),
        "no file fits this pattern; `Shot.0007.exr` is there: a `#` stands for each digit of a number"
    );
    folder.with("shot.0004.exr", b"");
    let error = find(&folder, "shot.####.exr", None).unwrap_err();
    assert_eq!(
        message_and_hint(&error),
        "frame 3 is missing; `shot.00003.exr` is there, and this pattern writes numbers in another way: rename it"
    );
}

#[test]
fn the_first_missing_frame_is_named() {
    let folder = shots("gaps", &[1, 2, 4, 7]);
    let error = find(&folder, "shot.####.exr", None).unwrap_err();
    assert_eq!(error.path, folder.file("shot.0003.exr"));
    assert_eq!(message_and_hint(&error), "frame 3 is missing; render it, or choose others, for example `--frames 1-2`");
    let error = find(&folder, "shot.####.exr", Some("2-9x2")).unwrap_err();
    assert_eq!(error.path, folder.file("shot.0006.exr"));
    assert_eq!(error.exit(), 1);
    let stepped = shots("stepped", &[10, 12, 14]);
    assert_eq!(
        message_and_hint(&find(&stepped, "shot.####.exr", None).unwrap_err()),
        "frame 11 is missing; to take every frame that is there, add `--frames 10-14x2`"
    );
}

#[test]
fn a_layer_is_not_a_placeholder() {
    let folder = shots("layer", &[1, 2]);
    let input = find(&folder, "shot.####.exr#diffuse.R", None).unwrap();
    let path = folder.file("shot.0002.exr");
    let source = Source { path, layer: Some("diffuse.R".to_owned()) };
    assert_eq!(input.sources()[1], (Some(2), source));
    let input = find(&folder, "shot.0001.exr#Z", None).unwrap();
    assert_eq!(input.sources()[0].1.layer.as_deref(), Some("Z"));
    let input = find(&folder, "shot.0001.EXR#Z", None).unwrap();
    assert_eq!(input.sources()[0].1.path, folder.file("shot.0001.EXR"));
    let literal = folder.with("take#3.exr", b"");
    let input = find(&folder, "take#3.exr", None).unwrap();
    assert_eq!(input.sources(), [(None, Source::file(literal))]);
}

#[test]
fn outputs_match_inputs_or_say_why_not() {
    let folder = shots("outputs", &[1, 2]);
    let many = find(&folder, "shot.####.exr", None).unwrap();
    let one = find(&folder, "shot.0001.exr", None).unwrap();
    let names = |input: &Input, output| input.outputs(output).map_err(|error| message_and_hint(&error));
    assert_eq!(names(&one, "out.png"), Ok(vec!["out.png".into()]));
    assert_eq!(names(&many, "o/out.###.png"), Ok(vec!["o/out.001.png".into(), "o/out.002.png".into()]));
    assert_eq!(
        names(&many, "o.v2/out.png").unwrap_err(),
        "2 frames cannot go into one file; number the output, for example `o.v2/out.####.png`"
    );
    assert_eq!(
        names(&one, "out.%04d.png").unwrap_err(),
        "the output is numbered, but the input is a single image; \
         leave the placeholder out, or give a sequence as input"
    );
    assert_eq!(
        names(&many, "out.##.##.png").unwrap_err(),
        "the name has more than one placeholder; keep one run of `#`, or one `%04d`"
    );
    assert_eq!(
        names(&many, "out.####.mov").unwrap_err(),
        "a film has all of its frames in one file; leave the placeholder out"
    );
    assert_eq!(
        names(&many, "day.##/out.png").unwrap_err(),
        "a folder cannot be numbered; put the placeholder into the name of the file"
    );
}

#[test]
fn inputs_that_make_no_sense_say_so() {
    let folder = shots("senseless", &[1]);
    assert_eq!(
        message_and_hint(&find(&folder, "shot.0001.exr", Some("1-5")).unwrap_err()),
        "`--frames` needs a numbered input; \
         put a placeholder into the name, for example `shot.####.exr`"
    );
    assert_eq!(
        message_and_hint(&find(&folder, "other.####.exr", None).unwrap_err()),
        "no file fits this pattern; check the folder, and that there is a `#` for each digit"
    );
    let error = find(&folder, "nowhere/shot.####.exr", None).unwrap_err();
    assert_eq!(error.message, "there is no such folder");
}

#[cfg(unix)]
#[test]
fn a_frame_that_is_no_file_is_not_missing() {
    use std::os::unix::fs::symlink;
    let folder = shots("no-files", &[1]);
    fs::create_dir(folder.file("shot.0002.exr")).unwrap();
    symlink("shot.0003.exr", folder.file("shot.0003.exr")).unwrap();
    symlink("/dev/null", folder.file("shot.0004.exr")).unwrap();
    symlink("nowhere", folder.file("shot.0005.exr")).unwrap();
    let message = |frames| find(&folder, "shot.####.exr", Some(frames)).unwrap_err().message;
    assert_eq!(message("1-2"), "it is a folder");
    assert_eq!(message("1,3"), "its links lead in a circle");
    assert_eq!(message("4"), "this is a pipe or a device, not a file");
    assert_eq!(message("5"), "frame 5 is missing");
}

#[test]
fn a_placeholder_has_digits_for_a_name() {
    let longest = Pattern::parse(&"#".repeat(255)).unwrap().unwrap();
    assert_eq!(longest.at(7).to_str().unwrap().len(), 255);
    for name in ["#".repeat(65_536), "#".repeat(256) + ".png", "%999d.png".to_owned()] {
        let error = Pattern::parse(&name).unwrap_err();
        assert!(error.message.ends_with("digits, and at most 255 are written"), "{}", error.message);
        assert!(error.path.to_str().unwrap().len() <= 63);
    }
}

#[test]
fn the_option_with_the_frames_is_named() {
    assert_eq!(parse_frames("--cut", "a").unwrap_err().path, std::path::Path::new("--cut a"));
}

/// Twenty thousand frames, each of which may be missing, take one look into the folder: what is gone later is found.
#[test]
fn a_folder_is_read_once_for_all_frames() {
    let folder = shots("once", &[3, 7]);
    let path = |frame: u32| folder.file(&format!("shot.{frame:04}.exr"));
    let files = FrameFiles::new(folder.file("shot.####.exr#Z").to_str().unwrap()).unwrap();
    let found = |frame| files.find_filled(frame, StandIn::Before).map(|(source, is_own)| (source.path, is_own));
    assert_eq!(found(3), Some((path(3), true)));
    fs::remove_file(path(3)).unwrap();
    fs::remove_file(path(7)).unwrap();
    assert_eq!((found(2), found(6), found(7)), (None, Some((path(3), false)), Some((path(7), true))));
    assert_eq!(
        (found(8), [2, 3, 5, 8].map(|frame| files.spans(frame))),
        (Some((path(7), false)), [false, true, true, false])
    );
    let any = |frame| files.find_filled(frame, StandIn::Any).map(|(source, is_own)| (source.path, is_own));
    assert_eq!((any(2), any(6)), (Some((path(3), false)), Some((path(3), false))));
    assert_eq!(files.find(7), None, "it is gone");
    fs::write(path(7), "").unwrap();
    assert_eq!(files.find(7), Some(Source { path: path(7), layer: Some("Z".to_owned()) }));
}

#[test]
fn frames_too_far_apart_are_told_and_no_option_that_was_not_given() {
    let folder = shots("far", &[0]);
    folder.with("shot.4294967295.exr", b"");
    let name = folder.file("shot.####.exr");
    let error = Input::find_filled(name.to_str().unwrap(), None, StandIn::Before).unwrap_err();
    assert_eq!(error.path, name);
    let message = "frames 0 to 4294967295 are on disk, and from one to the other are more than 1000000";
    assert_eq!(message_and_hint(&error), format!("{message}; choose some of them with `--frames`"));
}

#[test]
fn messages_are_of_one_line_whatever_a_name_holds() {
    let error = Input::find("a\nb\u{202e}/shot.####.exr", Some("1\u{1b}[8m")).unwrap_err().to_string();
    assert_eq!(error.lines().count(), 2, "{error}");
    assert!(error.contains("1\\u001b[8m") && !error.contains(['\u{1b}', '\u{202e}']), "{error}");
}
