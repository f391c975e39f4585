//! Codes in files: what decides them, and what the files say about them.

use std::fs;

use afterimage_media::{Picture, Pixels};

use super::{Folder, save_exact};

const SIZE: (u32, u32) = (256, 128);

/// A ramp over the middle of the range, alike in all channels, with alpha 1.
fn ramp() -> Vec<f32> {
    let count = SIZE.0 * SIZE.1;
    let at = |pixel: u32| 0.15 + 0.7 * pixel as f32 / count as f32;
    (0..count).flat_map(|pixel| [at(pixel), at(pixel), at(pixel), 1.0]).collect()
}

/// A folder with the ramp, and a pipeline that gives it out through these nodes, the last of which is `last`.
fn folder(test: &str, nodes: &str, last: &str) -> Folder {
    let folder = Folder::new(test);
    save_exact(&folder.file("ramp.exr"), &Picture::new(SIZE.0, SIZE.1, Pixels::Float(ramp())));
    let text =
        format!("Pipeline(inputs: {{ \"in\": Encoded }}, nodes: {{ {nodes} }}, outputs: {{ \"out\": \"{last}\" }})");
    folder.with("p.ron", text.as_bytes());
    folder
}

const DITHERED: &str = "\"display\": Dither(source: \"in\", bits: 8, seed: 3, format: Rgba8Unorm)";

/// The codes of the file, and its largest code.
fn codes(folder: &Folder, options: &str) -> (Vec<u16>, f64) {
    folder.run(&format!("render p.ron ramp.exr -o out.png{options}")).good();
    let file = std::io::BufReader::new(fs::File::open(folder.file("out.png")).expect("the picture was written"));
    let mut reader = png::Decoder::new(file).read_info().expect("a PNG");
    let mut bytes = vec![0; reader.output_buffer_size().expect("a size")];
    let info = reader.next_frame(&mut bytes).expect("whole pixels");
    assert_eq!(info.color_type, png::ColorType::Rgb, "alpha is 1 everywhere");
    match info.bit_depth {
        png::BitDepth::Eight => (bytes.iter().map(|byte| u16::from(*byte)).collect(), 255.0),
        _ => (bytes.as_chunks::<2>().0.iter().map(|pair| u16::from_be_bytes(*pair)).collect(), 65535.0),
    }
}

/// The variance of the error against the ramp, and the largest error, in codes.
fn error((codes, last): &(Vec<u16>, f64)) -> (f64, f64) {
    let ramp = ramp();
    let values = ramp.as_chunks::<4>().0.iter().flat_map(|pixel| &pixel[..3]);
    let errors: Vec<f64> = values.zip(codes).map(|(v, code)| f64::from(*code) - f64::from(*v) * last).collect();
    let mean = errors.iter().sum::<f64>() / errors.len() as f64;
    let variance = errors.iter().map(|error| (error - mean).powi(2)).sum::<f64>() / errors.len() as f64;
    (variance, errors.iter().fold(0.0, |worst, error| error.abs().max(worst)))
}

/// Triangular noise of two codes' width that is added once has this variance together with rounding.
const DITHERED_ONCE: f64 = 0.25;
const ROUNDED: f64 = 1.0 / 12.0;

#[test]
#[cfg_attr(no_gpu, ignore = "AFTERIMAGE_NO_GPU is set")]
fn a_file_is_quantized_once_whatever_the_pipeline_does() {
    let plain = "\"display\": FilmGrain(source: \"in\", amount: 0.0)";
    let twice = "\"first\": Dither(source: \"in\"), \"display\": Dither(source: \"first\", seed: 9)";
    for (test, nodes) in [("quantize-last", DITHERED), ("quantize-none", plain), ("quantize-twice", twice)] {
        let folder = folder(test, nodes, "display");
        for (options, variance) in [
            ("", DITHERED_ONCE),
            (" --exact", DITHERED_ONCE),
            (" --no-dither", ROUNDED),
            (" --no-dither --exact", ROUNDED),
        ] {
            let found = codes(&folder, options);
            assert_eq!(found.1, 255.0);
            let (found, worst) = error(&found);
            assert!((found - variance).abs() < 0.01, "{test}{options}: the variance is {found}");
            assert!(worst <= if variance == ROUNDED { 0.57 } else { 1.57 }, "{test}{options}: {worst} codes");
        }
    }
}

#[test]
#[cfg_attr(no_gpu, ignore = "AFTERIMAGE_NO_GPU is set")]
fn sixteen_bits_are_sixteen_bits_of_data_behind_a_dither_too() {
    let folder = folder("quantize-deep", DITHERED, "display");
    for options in [" --depth 16", " --depth 16 --no-dither", " --depth 16 --exact"] {
        let found = codes(&folder, options);
        assert_eq!(found.1, 65535.0, "{options}");
        let (variance, worst) = error(&found);
        // f32 in a texture and in the file: half a code and the rounding of the numbers.
        assert!(worst <= 0.51 && (variance - ROUNDED).abs() < 0.01, "{options}: {variance}, {worst}");
    }
}

#[test]
#[cfg_attr(no_gpu, ignore = "AFTERIMAGE_NO_GPU is set")]
fn the_noise_of_a_file_is_that_of_the_node() {
    use crate::support::gpu::{Picture as Image, Run, graph};
    let folder = folder("quantize-node", DITHERED, "display");
    let found = codes(&folder, " --exact").0;
    let values = ramp();
    let at = |x: u32, y: u32| values.as_chunks::<4>().0[(y * SIZE.0 + x) as usize];
    let text = format!(
        "Pipeline(inputs: {{ \"in\": Encoded }}, nodes: {{ {DITHERED} }}, outputs: {{ \"out\": \"display\" }})"
    );
    let shown = Run::new(&graph(&text)).exact().frame(&[("in", &Image::new(SIZE.0, SIZE.1, at))]).remove(0);
    let node = shown.pixels.iter().flat_map(|pixel| pixel[..3].iter().map(|value| (value * 255.0).round() as u16));
    let differences = node.zip(&found).filter(|(node, file)| node != *file).count();
    // A value that lies on the border of two codes may fall to either side of it.
    assert!(differences <= 5, "{differences} of {} codes", found.len());
}

#[test]
#[cfg_attr(no_gpu, ignore = "AFTERIMAGE_NO_GPU is set")]
fn a_depth_that_replaces_the_pipelines_is_said() {
    let folder = folder("quantize-said", "\"display\": Dither(source: \"in\", bits: 10)", "display");
    let said = |options: &str| folder.run(&format!("render p.ron ramp.exr -o out.png{options}"));
    let outcome = said("");
    assert!(
        outcome.err.contains("`display` dithers to 10 bits; the file has 8, and its depth decides"),
        "{}",
        outcome.err
    );
    assert_eq!(said(" --depth 8").err, "", "the user chose it");
}

#[test]
fn a_format_that_loses_codes_is_refused() {
    let check = |node: &str| folder("quantize-format", &format!("\"display\": {node}"), "display").run("check p.ron");
    check("Dither(source: \"in\", bits: 10, format: Rgba8Unorm)")
        .fails_saying(1, &["`display` cannot use its parameters", "`Rgba8Unorm` does not keep codes of 10 bits"]);
    check("Dither(source: \"in\", bits: 12, format: Rgba16Float)")
        .fails_saying(1, &["`Rgba16Float` does not keep codes of 12 bits"]);
    check("Dither(source: \"in\", bits: 12, format: Rgba32Float)").good();
    check("Dither(source: \"in\", bits: 12)").good();
}

/// The names and the data of the chunks of a PNG.
fn chunks(file: &[u8]) -> Vec<(String, Vec<u8>)> {
    let mut found = Vec::new();
    let mut rest = &file[8..];
    while rest.len() >= 12 {
        let length = u32::from_be_bytes(std::array::from_fn(|i| rest[i])) as usize;
        found.push((String::from_utf8_lossy(&rest[4..8]).into_owned(), rest[8..8 + length].to_vec()));
        rest = &rest[12 + length..];
    }
    found
}

#[test]
#[cfg_attr(no_gpu, ignore = "AFTERIMAGE_NO_GPU is set")]
fn a_png_states_what_encode_did() {
    let folder = Folder::new("labels");
    save_exact(&folder.file("room.exr"), &super::room(16, 9));
    let cases = [
        ("Srgb", "Rec709", Some([1, 13, 0, 1]), "sRGB"),
        ("Srgb", "DisplayP3", Some([12, 13, 0, 1]), "iCCP"),
        ("Pq", "Rec2020", Some([9, 16, 0, 1]), "mDCV"),
        ("Hlg", "Rec2020", Some([9, 18, 0, 1]), "cLLI"),
        ("Linear", "Rec709", Some([1, 8, 0, 1]), "gAMA"),
        ("Gamma, gamma: 2.4", "DisplayP3", None, "cHRM"),
    ];
    for (transfer, primaries, cicp, other) in cases {
        let text = format!(
            "Pipeline(inputs: {{ \"scene\": Color }}, nodes: {{ \"exposed\": Exposure(source: \"scene\"), \
             \"mapped\": ToneMap(source: \"exposed\"), \
             \"out\": Encode(source: \"mapped\", primaries: {primaries}, transfer: {transfer}) }}, \
             outputs: {{ \"out\": \"out\" }})"
        );
        folder.with("p.ron", text.as_bytes());
        folder.run("render p.ron room.exr -o out.png").good();
        let chunks = chunks(&fs::read(folder.file("out.png")).expect("the picture was written"));
        let data = |name: &str| chunks.iter().find(|(found, _)| found == name).map(|(_, data)| data.clone());
        assert_eq!(data("cICP"), cicp.map(Vec::from), "{transfer}, {primaries}");
        assert!(data(other).is_some(), "{transfer}, {primaries}: no {other}");
        assert_eq!(data("sRGB").is_some(), other == "sRGB", "{transfer}, {primaries}");
    }
}

#[test]
#[cfg_attr(no_gpu, ignore = "AFTERIMAGE_NO_GPU is set")]
fn a_jpeg_is_written_and_alpha_follows_the_option() {
    let folder = folder("formats", DITHERED, "display");
    folder.run("render p.ron ramp.exr -o out.jpg --quality 80").good();
    assert_eq!(fs::read(folder.file("out.jpg")).expect("the picture was written")[..3], [0xff, 0xd8, 0xff]);
    folder.run("render p.ron ramp.exr -o out.png --alpha keep").good();
    let header = chunks(&fs::read(folder.file("out.png")).expect("the picture was written")).remove(0).1;
    assert_eq!(header[8..10], [8, 6], "eight bits, RGBA");
    folder.run("render p.ron ramp.exr -o out.jpg --depth 16").fails(1, "error: a JPEG has 8 bits, not 16");
}
