//! Numbered pictures.

use afterimage_media::{Source, read};

use super::{Folder, room, save};

/// A folder with `shot.0001.exr` and so on, each twice as bright as the one before.
fn shot(test: &str, frames: &[u32]) -> Folder {
    let folder = Folder::new(test);
    for frame in frames {
        let mut picture = room(12, 8);
        let brighter = picture.pixels.to_f32().iter().map(|x| x * 2_f32.powi(*frame as i32)).collect();
        picture.pixels = afterimage_media::Pixels::Float(brighter);
        save(&folder.file(&format!("shot.{frame:04}.exr")), &picture);
    }
    let pipeline = "Pipeline(inputs: { \"scene\": Color }, nodes: { \"same\": Exposure(source: \"scene\", stops: 2.0) }, \
                    outputs: { \"light\": \"same\" })";
    folder.with("four.ron", pipeline.as_bytes());
    folder
}

fn made(folder: &Folder) -> Vec<String> {
    folder.names().into_iter().filter(|name| name.starts_with("out")).collect()
}

fn first_number(folder: &Folder, name: &str) -> f32 {
    read(&Source::file(folder.file(name))).expect("the frame was written").pixels.to_f32()[0]
}

#[test]
#[cfg_attr(no_gpu, ignore = "AFTERIMAGE_NO_GPU is set")]
fn every_frame_is_rendered_and_none_is_mixed_up() {
    let folder = shot("all", &[1, 2, 3, 4]);
    folder.run("render four.ron shot.####.exr -o out.####.exr").good();
    assert_eq!(made(&folder), ["out.0001.exr", "out.0002.exr", "out.0003.exr", "out.0004.exr"]);
    for (frame, power) in [(1, 2.0), (2, 4.0), (3, 8.0), (4, 16.0)] {
        let found = first_number(&folder, &format!("out.{frame:04}.exr"));
        assert!((found - 0.05 * 4.0 * power).abs() < 1e-2 * power, "frame {frame}: {found}");
    }
}

#[test]
#[cfg_attr(no_gpu, ignore = "AFTERIMAGE_NO_GPU is set")]
fn a_range_takes_some_frames() {
    let folder = shot("range", &[1, 2, 3, 4]);
    folder.run("render four.ron shot.%04d.exr -o out.##.exr --frames 1-4x2").good();
    assert_eq!(made(&folder), ["out.01.exr", "out.03.exr"]);
    folder.run("render four.ron shot.####.exr -o outer.####.exr --frames 4,2").good();
    assert_eq!(made(&folder), ["out.01.exr", "out.03.exr", "outer.0002.exr", "outer.0004.exr"]);
}

#[test]
#[cfg_attr(no_gpu, ignore = "AFTERIMAGE_NO_GPU is set")]
fn what_is_wrong_with_a_sequence_is_said_before_anything_is_rendered() {
    let folder = shot("gap", &[1, 2, 4]);
    let gap =
        "error: shot.0003.exr: frame 3 is missing\n  hint: render it, or choose others, for example `--frames 1-2`";
    folder.run("render four.ron shot.####.exr -o out.####.exr").fails(1, gap);
    let table = [
        (
            "shot.####.exr -o out.####.exr --frames 2-5",
            "error: shot.0003.exr: frame 3 is missing\n  hint: render it, or choose other frames with `--frames`",
        ),
        (
            "shot.####.exr -o out.####.exr --frames 5-2",
            "error: --frames 5-2: `5-2` runs backwards\n  hint: write `2-5`",
        ),
        (
            "shot.####.exr -o out.exr --frames 1-2",
            "error: out.exr: 2 frames cannot go into one file\n  hint: number the output, for example `out.####.exr`",
        ),
        (
            "shot.0001.exr -o out.####.exr",
            "error: out.####.exr: the output is numbered, but the input is a single image\n  hint: leave the placeholder out, or give a \
             sequence as input",
        ),
        (
            "shot.####.exr -o out.####.exr --frames 1-2 --cut 2-1",
            "error: --cut 2-1: `2-1` runs backwards\n  hint: write `1-2`",
        ),
        (
            "take.####.exr -o out.####.exr",
            "error: take.####.exr: no file fits this pattern\n  hint: check the folder, and that there is a `#` for each digit",
        ),
    ];
    for (arguments, words) in table {
        folder.run(&format!("render four.ron {arguments}")).fails(1, words);
    }
    assert_eq!(made(&folder), Vec::<String>::new());
}

#[test]
#[cfg_attr(no_gpu, ignore = "AFTERIMAGE_NO_GPU is set")]
fn frames_before_a_broken_one_are_whole() {
    let folder = shot("broken", &[1, 2, 3]);
    folder.with("shot.0003.exr", b"");
    let said = "frames: 2 good, 0 skipped, 1 failed; 0 repaired\n\
                error: shot.0003.exr: the file is empty\n  hint: copy or render it again";
    folder.run("render four.ron shot.####.exr -o out.####.exr").fails(1, said);
    for name in made(&folder) {
        assert!(first_number(&folder, &name) > 0.0, "{name}");
    }
    assert!(!made(&folder).iter().any(|name| name.contains("0003")), "{:?}", folder.names());
    assert!(!folder.names().iter().any(|name| name.ends_with(".part")), "{:?}", folder.names());
}

#[test]
#[cfg_attr(no_gpu, ignore = "AFTERIMAGE_NO_GPU is set")]
fn a_pipeline_without_inputs_makes_the_frames_that_are_asked_for() {
    let folder = Folder::new("made-up");
    let pipeline = "Pipeline(inputs: {}, nodes: { \"scene\": DemoScene(), \"lit\": Exposure(source: \"scene\"), \
                    \"mapped\": ToneMap(source: \"lit\"), \"film\": FilmGrain(source: \"mapped\", amount: 1.0) }, \
                    outputs: { \"light\": \"film\" })";
    folder.with("scene.ron", pipeline.as_bytes());
    folder.run("render scene.ron -o out.##.exr --frames 1,48 --size 32x18").good();
    assert_eq!(made(&folder), ["out.01.exr", "out.48.exr"]);
    let frame = |name: &str| read(&Source::file(folder.file(name))).expect("it was written").pixels.to_f32();
    assert!(frame("out.01.exr") != frame("out.48.exr"), "each frame has grain of its own");
    folder.run("render scene.ron -o out.##.exr").fails(
        1,
        "error: out.##.exr: the output is numbered, but no frames are named\n  hint: name them, for example `--frames 1-48`",
    );
    folder.run("render scene.ron -o out.exr --frames 1-2").fails(
        1,
        "error: out.exr: frames need a numbered output\n  hint: write `out.####.png`, or leave `--frames` out",
    );
}

#[test]
#[cfg_attr(no_gpu, ignore = "AFTERIMAGE_NO_GPU is set")]
fn a_layer_of_a_still_is_that_of_all_frames() {
    let folder = shot("still", &[1, 2, 3]);
    save(&folder.file("still.exr"), &room(12, 8));
    let pipeline = "Pipeline(inputs: { \"scene\": Color, \"other\": Color }, nodes: { \"sum\": \
                    Composite(base: \"scene\", bloom: \"other\", strength: 1.0) }, outputs: { \"light\": \"sum\" })";
    folder.with("sum.ron", pipeline.as_bytes());
    let single = "render sum.ron shot.0002.exr --input other=still.exr -o single.exr";
    folder.run(single).good();
    let line = "render sum.ron shot.####.exr --input other=still.exr#R --frames 2-3 -o out.####.exr";
    folder.run(line).good();
    assert_eq!(made(&folder), ["out.0002.exr", "out.0003.exr"]);
    // The still can be the first of the inputs.
    folder.run("render sum.ron still.exr --input other=shot.####.exr --frames 2 -o outer.####.exr").good();
    assert_eq!(first_number(&folder, "outer.0002.exr"), first_number(&folder, "single.exr"));
}

#[test]
#[cfg_attr(no_gpu, ignore = "AFTERIMAGE_NO_GPU is set")]
fn what_is_the_same_of_all_frames_is_said_once() {
    let folder = Folder::new("notes");
    let covers = "Pipeline(inputs: { \"scene\": Encoded }, nodes: {}, outputs: { \"display\": Output(source: \"scene\", \
                  alpha: Coverage) })";
    folder.with("covers.ron", covers.as_bytes());
    for frame in 1..=4 {
        let mut picture = room(12, 8);
        picture.pixels = afterimage_media::Pixels::Float([1.0, 1.0, 1.0, 0.5].repeat(12 * 8));
        save(&folder.file(&format!("shot.{frame}.exr")), &picture);
    }
    let notes = folder.run("render covers.ron shot.#.exr -o out.#.png").notes();
    let lines: Vec<&str> = notes.lines().filter(|line| line.starts_with("note: ")).collect();
    assert!(lines.len() == 1 && lines[0].contains("light that is brighter than its alpha holds is cut"), "{notes}");
}
