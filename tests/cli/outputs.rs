//! Several outputs of one pipeline, each in its file.

use afterimage_media::{ImageFormat, Picture, Pixels, Source, read};

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
    folder.run("render {hdr} room.exr --output sdr=sdr.png --output hdr=hdr.png").good();
    assert_eq!(folder.names(), ["hdr.png", "room.exr", "sdr.png"]);
    folder.run("render {hdr} room.exr -o same.png --output hdr=again.png").good();
    let pixels = |name: &str| read(&Source::file(folder.file(name))).expect("a picture").pixels.to_f32();
    assert_eq!(pixels("again.png").len(), 12 * 8 * 4);
    assert_ne!(pixels("same.png"), pixels("again.png"), "the first output that fits is the SDR image");
    assert_eq!(["sdr.png", "hdr.png", "again.png"].map(|name| header(&folder, name).0), [8, 16, 16]);
    folder.run("render {hdr} room.exr --output hdr=eight.png --depth 8").good();
    assert_eq!(header(&folder, "eight.png").0, 8);
    let shown = folder.run("plan {hdr}").good();
    assert!(shown.contains("  hdr  Encoded: Pq, Rec2020, white at 203 cd/m2, peak at 1000 cd/m2"), "{shown}");
}

#[test]
#[cfg_attr(no_gpu, ignore = "AFTERIMAGE_NO_GPU is set")]
fn a_jpeg_has_the_hdr_output_as_its_gain_map() {
    let folder = folder("gain-map");
    folder.run("render {hdr} room.exr -o photo.jpg --gain-map hdr").good();
    folder.run("render {hdr} room.exr -o plain.jpg --output hdr=hdr.png").good();
    let pixels = |name: &str| read(&Source::file(folder.file(name))).expect("a picture").pixels.to_f32();
    assert_eq!(pixels("photo.jpg"), pixels("plain.jpg"), "other readers see the SDR output");
    let note = "its gain map is not applied";
    assert_eq!(
        ["photo.jpg", "plain.jpg"].map(|name| folder.run(&format!("info {name}")).good().contains(note)),
        [true, false]
    );
    for (options, error) in [
        ("-o a.png --gain-map hdr", "`--gain-map` is for JPEG files, and none is written"),
        ("-o a.jpg --gain-map sdr", "output `sdr` is not PQ, and a gain map leads to an HDR image"),
        ("-o a.jpg --gain-map none", "the pipeline has no output `none`"),
        ("-o a.jpg --gain-map hdr --crop 0,0,4x4", "--crop"),
    ] {
        folder.run(&format!("render {{hdr}} room.exr {options}")).fails_saying(1, &[error]);
    }
    assert!(!folder.file("a.jpg").exists());
}

/// The bits of a channel of a PNG, and whether it has alpha.
fn header(folder: &Folder, name: &str) -> (u8, bool) {
    let file = std::io::BufReader::new(std::fs::File::open(folder.file(name)).expect("the picture was written"));
    let reader = png::Decoder::new(file).read_info().expect("a PNG");
    (reader.info().bit_depth as u8, reader.info().color_type == png::ColorType::Rgba)
}

#[test]
#[cfg_attr(no_gpu, ignore = "AFTERIMAGE_NO_GPU is set")]
fn only_the_passes_of_the_outputs_that_are_written_run() {
    let folder = folder("needed");
    let passes = |outputs: &str| {
        let notes = folder.run(&format!("render {{hdr}} room.exr {outputs} --timings")).notes();
        // A processor times no passes.
        assert!(!notes.contains("\\n"), "{notes}");
        let timed = notes.lines().filter_map(|line| line.split_once(" ms on the GPU: "));
        let untimed = notes.lines().filter_map(|line| line.split_once("not timed: "));
        timed.chain(untimed).map(|(_, label)| label.to_owned()).collect::<Vec<_>>()
    };
    let both = passes("--output sdr=sdr.png --output hdr=hdr.png");
    let one = passes("--output sdr=sdr.png");
    assert!(both.iter().any(|label| label.contains("encode_pq")), "{both:?}");
    assert!(!one.is_empty() && !one.iter().any(|label| label.contains("encode_pq")), "{one:?}");
}

#[test]
#[cfg_attr(no_gpu, ignore = "AFTERIMAGE_NO_GPU is set")]
fn alpha_is_a_mask_unless_it_is_declared_as_coverage() {
    let folder = folder("coverage");
    let mut masked = room(12, 8);
    let mut pixels = masked.pixels.to_f32();
    // Light that is not covered is cut in a PNG, with a note.
    pixels.chunks_mut(4).step_by(2).for_each(|pixel| pixel.fill(0.0));
    masked.pixels = Pixels::Float(pixels);
    save(&folder.file("masked.exr"), &masked);
    folder.run("render {caracal} masked.exr -o mask.png").good();
    assert!(!header(&folder, "mask.png").1);
    let pipeline = |output: &str| {
        format!("Pipeline(inputs: {{ \"scene\": Encoded }}, nodes: {{}}, outputs: {{ \"display\": {output} }})")
    };
    folder.with("opaque.ron", pipeline("\"scene\"").as_bytes());
    folder.with("covers.ron", pipeline("Output(source: \"scene\", alpha: Coverage)").as_bytes());
    let said = "note: `opaque.png` is opaque: the alpha of `masked.exr` may be a mask";
    assert!(folder.run("render opaque.ron masked.exr -o opaque.png").notes().contains(said));
    assert!(!folder.run("render covers.ron masked.exr -o covers.png").notes().contains("note"));
    assert!(!folder.run("render opaque.ron masked.exr -o kept.png --alpha keep").notes().contains("note"));
    assert!(!folder.run("render opaque.ron room.exr -o room.png").notes().contains("note"), "its alpha is 1");
    let names = ["opaque.png", "covers.png", "kept.png"];
    assert_eq!(names.map(|name| header(&folder, name).1), [false, true, true]);
    let pixels = names.map(|name| read(&Source::file(folder.file(name))).expect("a picture").pixels.to_f32());
    let colors = |all: &[f32]| all.chunks(4).map(|pixel| pixel[..3].to_vec()).collect::<Vec<_>>();
    assert_eq!(colors(&pixels[0]), colors(&pixels[1]), "colors do not depend on alpha");
    assert_eq!(pixels[1], pixels[2]);
    masked.pixels = Pixels::Float([1.0, 1.0, 1.0, 0.5].repeat(12 * 8));
    save(&folder.file("bright.exr"), &masked);
    let notes = folder.run("render covers.ron bright.exr -o bright.png").notes();
    assert!(notes.contains("note: light that is brighter than its alpha holds is cut"), "{notes}");
}

/// The color of the first pixel, without its alpha in it.
fn color(picture: Picture) -> [f32; 3] {
    let values = picture.pixels.to_f32();
    [0, 1, 2].map(|channel| values[channel] / values[3])
}

/// A pixel that is half covered has the color of a whole one if a curve sees light that is not multiplied by alpha, and
/// a warning says so where it does not.
#[test]
#[cfg_attr(no_gpu, ignore = "AFTERIMAGE_NO_GPU is set")]
fn a_curve_of_covered_light_gets_a_warning() {
    let folder = folder("covered-curve");
    for alpha in [1.0_f32, 0.5] {
        let pixel = [0.6 * alpha, 0.3 * alpha, 0.1 * alpha, alpha];
        save(&folder.file(&format!("{alpha:?}.exr")), &Picture::new(4, 4, Pixels::Float(pixel.repeat(16))));
    }
    let pipeline = |curve: &str, output: &str| {
        format!(
            "Pipeline(inputs: {{ \"scene\": Color }}, nodes: {{ \"exposed\": Exposure(source: \"scene\"), {curve} }}, \
             outputs: {{ \"display\": {output} }})"
        )
    };
    let bare = "\"mapped\": ToneMap(source: \"exposed\"), \"encoded\": Encode(source: \"mapped\")";
    let straight = "\"straight\": Unpremultiply(source: \"exposed\"), \"mapped\": ToneMap(source: \"straight\"), \
                    \"covered\": Premultiply(source: \"mapped\"), \"encoded\": Encode(source: \"covered\")";
    let output = "Output(source: \"encoded\", alpha: Coverage)";
    let shown = |curve: &str, output: &str| {
        folder.with("look.ron", pipeline(curve, output).as_bytes());
        let notes =
            ["1.0", "0.5"].map(|alpha| folder.run(&format!("render look.ron {alpha}.exr -o {alpha}.png")).notes());
        let pixels = ["1.0.png", "0.5.png"].map(|name| read(&Source::file(folder.file(name))).expect("a picture"));
        (notes.concat().contains("covered-curve"), pixels.map(color))
    };
    let (is_told, [whole, half]) = shown(straight, output);
    assert!(!is_told);
    assert!(std::iter::zip(&whole, &half).all(|(a, b)| (a - b).abs() < 1.5 / 255.0), "{whole:?} {half:?}");
    let (is_told, [whole, half]) = shown(bare, output);
    assert!(is_told);
    assert!(std::iter::zip(&whole, &half).any(|(a, b)| (a - b).abs() > 8.0 / 255.0), "{whole:?} {half:?}");
    assert!(!shown(bare, "\"encoded\"").0, "alpha may be a mask");
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
            "render {hdr} room.exr --output a.png",
            "error: no file is named for the output `a.png`\n  hint: `-o a.png` names the file; `--output` names an \
             output of the pipeline",
        ),
        ("render {hdr} room.exr -o .", "error: `.` is a folder\n  hint: name the file: `folder/out.png`"),
        (
            "render {hdr} room.exr --output sdr=a.png --output hdr=a.png",
            "error: a.png: two outputs go to this file\n  hint: name a file for each",
        ),
        (
            "render {hdr} room.exr --output sdr=a.png --output sdr=b.png",
            "error: two files are named for the output `sdr`\n  hint: name one",
        ),
        (
            "render {hdr} room.exr --output sdr=a.png --output hdr=b.xyz",
            "error: `b.xyz` ends in none of `.png`, `.jpg`, `.tif` and `.exr`\n  hint: `.png`, `.jpg` and `.tif` take \
             an encoded output, `.exr` a linear one",
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

/// Each format has the depths that it says, and files of another depth are made again.
#[test]
#[cfg_attr(no_gpu, ignore = "AFTERIMAGE_NO_GPU is set")]
fn files_are_known_by_their_format_and_their_depth() {
    let folder = folder("depths");
    save(&folder.file("shot.1.exr"), &room(12, 8));
    let text = "Pipeline(inputs: { \"scene\": Color }, nodes: { \"lit\": Exposure(source: \"scene\"), \"mapped\": \
                ToneMap(source: \"lit\"), \"shown\": Encode(source: \"mapped\") }, outputs: { \"display\": \"shown\", \
                \"light\": \"lit\" })";
    folder.with("two.ron", text.as_bytes());
    for format in [ImageFormat::Exr, ImageFormat::Png, ImageFormat::Tiff, ImageFormat::Jpeg] {
        let line = format!("render two.ron shot.#.exr -o out.#.{}", format.endings()[0]);
        let depths = format.depths();
        for depth in [8, 10, 16, 32] {
            let outcome = folder.run(&format!("{line} --depth {depth}"));
            if !depths.contains(&depth) {
                let known: Vec<String> = depths.iter().map(u32::to_string).collect();
                let said = format!("{} has {} bits, not {depth}", format.name(), known.join(" or "));
                outcome.fails_saying(1, &[&said]);
                continue;
            }
            outcome.good();
            for other in depths {
                let notes = folder.run(&format!("{line} --depth {other} --skip-existing")).notes();
                let wanted = if *other == depth { "0 good, 1 skipped" } else { "1 good, 0 skipped" };
                assert!(notes.contains(wanted), "{line}: {depth}, then {other}: {notes}");
                folder.run(&format!("{line} --depth {depth}")).good();
            }
        }
    }
    // Floats in TIFF are light, as those in EXR.
    let light = |name: &str| {
        folder.run(&format!("render two.ron room.exr -o {name} --depth 32")).good();
        read(&Source::file(folder.file(name))).expect("a picture").pixel(6, 4)
    };
    assert_eq!(light("light.tif"), light("light.exr"));
    assert!(light("light.tif")[0] > 30.0);
    let sizes = [20, 60, 95].map(|quality| {
        folder.run(&format!("render two.ron room.exr -o out.jpg --quality {quality}")).good();
        std::fs::read(folder.file("out.jpg")).expect("a picture").len()
    });
    assert!(sizes.is_sorted_by(|a, b| a < b), "{sizes:?}");
}
