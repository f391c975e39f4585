//! Sequences with gaps, and with frames of other sizes.

use std::fs;

use afterimage_media::{Encoding, Picture, Pixels, Samples, Source, encode, read};

use super::{Folder, room, save};

/// Frames of one light each: `shot.0001.exr` has 1, `shot.0002.exr` 2.
fn shot(test: &str, frames: &[u32]) -> Folder {
    let folder = Folder::new(test);
    for frame in frames {
        lit(&folder, *frame, (6, 4));
    }
    let pipeline = "Pipeline(inputs: { \"scene\": Color }, nodes: { \"same\": Exposure(source: \"scene\", stops: 1.0) }, \
                    outputs: { \"light\": \"same\" })";
    folder.with("twice.ron", pipeline.as_bytes());
    folder
}

fn lit(folder: &Folder, frame: u32, (width, height): (u32, u32)) {
    let mut picture = room(width, height);
    picture.pixels = Pixels::Float(vec![frame as f32; (width * height * 4) as usize]);
    save(&folder.file(&format!("shot.{frame:04}.exr")), &picture);
}

/// Red of the middle pixel of each frame, and the size.
fn made(folder: &Folder, frames: std::ops::RangeInclusive<u32>) -> Vec<(f32, u32, u32)> {
    let read = |frame: u32| read(&Source::file(folder.file(&format!("out.{frame:04}.exr")))).expect("it was written");
    let pictures = frames.map(read);
    pictures.map(|made| (made.pixel(made.width / 2, made.height / 2)[0], made.width, made.height)).collect()
}

#[test]
#[cfg_attr(no_gpu, ignore = "AFTERIMAGE_NO_GPU is set")]
fn a_frame_before_or_black_takes_the_place_of_a_missing_one() {
    let folder = shot("gaps", &[1, 2, 5]);
    let run = "render twice.ron shot.####.exr -o out.####.exr";
    folder.run(run).fails_saying(1, &["shot.0003.exr: frame 3 is missing"]);
    let notes = folder.run(&format!("{run} --missing hold")).notes();
    assert!(
        notes.contains("note: frames 3-4 of input `scene` are missing: the frame before takes their place"),
        "{notes}"
    );
    let lights = |folder: &Folder, last| made(folder, 1..=last).iter().map(|(light, ..)| *light).collect::<Vec<_>>();
    assert_eq!(lights(&folder, 5), [2.0, 4.0, 4.0, 4.0, 10.0]);
    let notes = folder.run(&format!("{run} --missing black --frames 1-6")).notes();
    assert!(notes.contains("note: frames 3-4,6 of input `scene` are missing: black takes their place"), "{notes}");
    assert_eq!(lights(&folder, 6), [2.0, 4.0, 0.0, 0.0, 10.0, 0.0]);
    folder.run(&format!("{run} --missing hold --frames 0-2")).fails_saying(
        1,
        &["error: shot.0000.exr: frame 0 is missing\n  hint: no frame before it can take its place; `"],
    );
}

#[test]
#[cfg_attr(no_gpu, ignore = "AFTERIMAGE_NO_GPU is set")]
fn black_takes_the_place_of_frames_before_the_first() {
    let folder = shot("gaps-before", &[1, 2, 3, 4]);
    let name = |frame: u32| folder.file(&format!("shot.{frame:04}.exr"));
    fs::rename(name(4), folder.file("over.0002.exr")).expect("a file");
    let lights = |frames| made(&folder, frames).iter().map(|(light, ..)| *light).collect::<Vec<_>>();
    folder.run("render twice.ron shot.####.exr -o out.####.exr --missing black --frames 0-2").good();
    assert_eq!(lights(0..=2), [0.0, 2.0, 4.0]);
    let pipeline = "Pipeline(inputs: { \"a\": Color, \"b\": Color }, nodes: { \"over\": Exposure(source: \"b\"), \
                    \"same\": Exposure(source: \"a\") }, outputs: { \"same\": \"same\", \"over\": \"over\" })";
    folder.with("two.ron", pipeline.as_bytes());
    let run = "render two.ron shot.####.exr --input b=over.####.exr --output over=out.####.exr";
    folder.run(&format!("{run} --missing black")).good();
    assert_eq!(lights(1..=3), [0.0, 4.0, 0.0]);
    folder.run(run).fails_saying(1, &["input `b` has no frame 1\n  hint: ", "`--missing black`"]);
    folder
        .run(&format!("{run} --input b=shot.####.exr"))
        .fails(1, "error: `--input b=` is there twice\n  hint: name one value");
}

/// A chunk after a gap follows from the same frames as the whole.
#[test]
#[cfg_attr(no_gpu, ignore = "AFTERIMAGE_NO_GPU is set")]
fn a_chunk_after_a_gap_has_the_pixels_of_the_whole() {
    let folder = shot("gaps-chunks", &[1, 2, 5, 6]);
    let options = "shot.####.exr --missing hold";
    folder.run(&format!("render exposure {options} -o whole.#.png")).good();
    folder.run(&format!("meter exposure {options} -o all.meter")).good();
    folder.run(&format!("render exposure {options} -o part.#.png --meter all.meter --frames 4-6")).good();
    for frame in 4..=6 {
        let bytes = |name: &str| fs::read(folder.file(&format!("{name}.{frame}.png"))).expect("it was written");
        assert!(bytes("whole") == bytes("part"), "frame {frame}");
    }
}

#[test]
#[cfg_attr(no_gpu, ignore = "AFTERIMAGE_NO_GPU is set")]
fn a_frame_of_another_size_is_told_and_can_be_scaled() {
    let folder = shot("sizes", &[1, 3]);
    lit(&folder, 2, (12, 12));
    let run = "render twice.ron shot.####.exr -o out.####.exr";
    folder
        .run(&format!("{run} --keep-going"))
        .fails_saying(1, &["shot.0002.exr: this frame has 12x12 pixels, and the first one has 6x4", "`--resize fit`"]);
    let notes = folder.run(&format!("{run} --resize fit")).notes();
    assert!(notes.contains("note: shot.0002.exr: 12x12 pixels are scaled into 6x4"), "{notes}");
    assert_eq!(made(&folder, 1..=3), [(2.0, 6, 4), (4.0, 6, 4), (6.0, 6, 4)]);
    // A square in the middle of black.
    let fitted = read(&Source::file(folder.file("out.0002.exr"))).expect("it was written");
    let row: Vec<f32> = (0..6).map(|x| fitted.pixel(x, 1)[0]).collect();
    assert_eq!(row, [0.0, 4.0, 4.0, 4.0, 4.0, 0.0]);
}

/// Half files, other files, and files of other pictures are no results.
#[test]
#[cfg_attr(no_gpu, ignore = "AFTERIMAGE_NO_GPU is set")]
fn only_whole_files_of_the_picture_are_left_as_they_are() {
    let frames: Vec<u32> = (1..=13).collect();
    let folder = shot("gaps-existing", &frames);
    let mut wide = room(6, 4);
    wide.meta.image.pixel_aspect = 2.0;
    save(&folder.file("shot.0001.exr"), &wide);
    save(&folder.file("shot.1.exr"), &wide);
    let pipeline = "Pipeline(inputs: { \"scene\": Color }, nodes: { \"same\": Exposure(source: \"scene\", stops: 1.0), \
                    \"mapped\": ToneMap(source: \"same\"), \"shown\": Encode(source: \"mapped\") }, \
                    outputs: { \"light\": \"same\", \"a\": \"shown\", \"b\": \"shown\" })";
    folder.with("three.ron", pipeline.as_bytes());
    let run = "render three.ron shot.####.exr --output light=o.####.exr --output a=o.####.png --output b=o.####.jpg";
    let notes = folder.run(run).notes();
    assert!(notes.contains("note: `shot.1.exr` is no frame of `shot.####.exr`"), "{notes}");
    assert!(notes.contains("note: the pixels of the image are 2 times as wide as high"), "{notes}");
    let name = |frame: u32, ending: &str| format!("o.{frame:04}.{ending}");
    let bytes = |frame: u32, ending: &str| fs::read(folder.file(&name(frame, ending))).expect("it was written");
    let all = || frames.iter().flat_map(|frame| ["exr", "png", "jpg"].map(|ending| bytes(*frame, ending)));
    let before: Vec<Vec<u8>> = all().collect();
    let cut = |frame: u32, ending: &str, less: usize| {
        let whole = bytes(frame, ending);
        (frame, ending.to_owned(), whole[..whole.len() - less].to_vec())
    };
    let half = |frame: u32, ending: &str| cut(frame, ending, bytes(frame, ending).len() / 2);
    let exr = |size: (u32, u32), bits: u32| {
        let pixels = Pixels::Float(vec![1.0; (4 * size.0 * size.1) as usize]);
        encode(&Picture::new(size.0, size.1, pixels), &Encoding { bits, ..Encoding::EXR }).expect("a file")
    };
    let small = encode(((5, 4), Samples::Byte(&[9; 80])), &Encoding::PNG).expect("a file");
    let damaged = [
        half(1, "jpg"),
        cut(2, "jpg", 2),
        (3, "jpg".to_owned(), vec![0; 900]),
        (4, "jpg".to_owned(), b"hello".to_vec()),
        (5, "jpg".to_owned(), bytes(5, "png")),
        cut(6, "png", 4),
        half(7, "png"),
        (8, "png".to_owned(), small),
        half(9, "exr"),
        cut(10, "exr", 1),
        (11, "exr".to_owned(), exr((6, 5), 16)),
        (12, "exr".to_owned(), exr((6, 4), 32)),
    ];
    for (frame, ending, bytes) in damaged {
        folder.with(&name(frame, &ending), &bytes);
    }
    let notes = folder.run(&format!("{run} --skip-existing")).notes();
    assert!(notes.contains("frames: 12 good, 1 skipped, 0 failed"), "{notes}");
    assert!(all().eq(before), "each file is there again");
}
