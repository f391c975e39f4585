//! Color spaces of files, and how EXR files are packed.

use std::path::Path;

use afterimage_media::{Encoding, Picture, Pixels, Samples, write_image};
use exr::prelude::{FlatSamples, read_first_flat_layer_from_file};

use super::{Folder, save_exact};

/// Red light of 1, and white.
fn lights(folder: &Folder) {
    save_exact(
        &folder.file("in.exr"),
        &Picture::new(2, 1, Pixels::Float(vec![1.0, 0.0, 0.0, 1.0, 1.0, 1.0, 1.0, 1.0])),
    );
    let pipeline = "Pipeline(inputs: { \"scene\": Color }, nodes: { \"same\": Exposure(source: \"scene\", stops: 1.0) }, \
                    outputs: { \"light\": \"same\" })";
    folder.with("twice.ron", pipeline.as_bytes());
}

/// Red, green and blue of the first pixel as another reader finds them, and the attributes of the file.
fn stored(path: &Path) -> ([f32; 3], String) {
    let layer = read_first_flat_layer_from_file(path).expect("it was written").layer_data;
    let first = |name: &str| {
        let channel = layer.channel_data.list.iter().find(|channel| channel.name.to_string() == name);
        match &channel.expect("the file has it").sample_data {
            FlatSamples::F16(values) => values[0].to_f32(),
            FlatSamples::F32(values) => values[0],
            FlatSamples::U32(values) => values[0] as f32,
        }
    };
    (["R", "G", "B"].map(first), format!("{:?} {:?}", layer.encoding.compression, layer.attributes.other))
}

#[track_caller]
fn assert_near(found: [f32; 3], expected: [f32; 3]) {
    let off = found.iter().zip(expected).map(|(a, b)| (a - b).abs()).fold(0.0, f32::max);
    assert!(off < 1e-5, "{found:?} is not {expected:?}");
}

/// Twice the published columns of red.
#[test]
#[cfg_attr(no_gpu, ignore = "AFTERIMAGE_NO_GPU is set")]
fn an_output_has_the_space_that_is_asked_for() {
    let folder = Folder::new("spaces-output");
    lights(&folder);
    let run = "render twice.ron in.exr -o out.exr --depth 32 --output-space";
    folder.run(&format!("{run} acescg --compression zips")).good();
    let (red, attributes) = stored(&folder.file("out.exr"));
    assert_near(red, [1.226194, 0.140388, 0.041232]);
    assert!(attributes.contains("ZIP1") && attributes.contains("lin_ap1_scene"), "{attributes}");
    folder.run(&format!("{run} ACES2065-1")).good();
    assert_near(stored(&folder.file("out.exr")).0, [0.879266, 0.179552, 0.035082]);
    folder.run("render twice.ron in.exr -o out.exr --output-space ACES2065-1 --compression none").good();
    let (_, attributes) = stored(&folder.file("out.exr"));
    assert!(attributes.contains("acesImageContainerFlag") && attributes.contains("lin_ap0_scene"), "{attributes}");
    let text = folder.run("info out.exr").good();
    assert!(text.contains("(half), none, rows") && text.contains("color: Linear, Ap0, by `chromaticities`"), "{text}");
    folder
        .run("render exposure in.exr -o out.png --output-space P3")
        .fails(1, "error: `--output-space` is for EXR files, and none is written\n  hint: leave it out");
}

#[test]
#[cfg_attr(no_gpu, ignore = "AFTERIMAGE_NO_GPU is set")]
fn an_input_has_the_space_that_is_named() {
    let folder = Folder::new("spaces-input");
    lights(&folder);
    let run = "--exact --depth 32 -o out.exr --input-space";
    folder.run(&format!("render twice.ron in.exr {run} ACEScg")).good();
    assert_near(stored(&folder.file("out.exr")).0, [3.410102, -0.260513, -0.048007]);
    folder.run(&format!("render twice.ron in.exr {run} Rec2020 --input-space scene=rec709")).good();
    assert_near(stored(&folder.file("out.exr")).0, [2.0, 0.0, 0.0]);
    let half = Samples::Byte(&[51, 51, 51, 255]);
    write_image(&folder.file("in.png"), ((1, 1), half), &Encoding::PNG).expect("it can be written");
    folder.run(&format!("render twice.ron in.png {run} Rec709")).good();
    assert!((stored(&folder.file("out.exr")).0[0] - 0.4).abs() < 1e-3);
    folder.run(&format!("render twice.ron in.exr {run} sRGB")).fails_saying(1, &["holds linear light, and not sRGB"]);
    folder
        .run(&format!("render twice.ron in.exr {run} albedo=P3"))
        .fails(1, "error: `--input-space`: the pipeline has no input `albedo`\n  hint: it has `scene`");
}
