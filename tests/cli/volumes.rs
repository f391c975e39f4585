//! Volumes from images whose slices lie one below the other.

use afterimage_media::{Picture, Pixels, Source, read};

use super::{Folder, save_exact};

/// Fog whose froxels each end a meter farther than the one before.
const FOGGY: &str = "Pipeline(inputs: { \"fog\": Color(volume: true), \"in\": Color, \"depth\": Depth }, nodes: { \
                     \"foggy\": VolumetricComposite(source: \"in\", depth: \"depth\", volume: \"fog\", \
                     slices: Linear, near: 0.0, far: 4.0) }, outputs: { \"foggy\": \"foggy\" })";
/// Meters, one for each column.
const FAR: [f32; 6] = [0.0, 0.5, 1.0, 2.75, 4.0, 1000.0];

fn picture(width: u32, height: u32, pixel: impl Fn(u32, u32) -> [f32; 4]) -> Picture {
    let places = (0..height).flat_map(|y| (0..width).map(move |x| (x, y)));
    Picture::new(width, height, Pixels::Float(places.flat_map(|(x, y)| pixel(x, y)).collect()))
}

/// A scene, its depth, and a volume of 3 x 2 x 4 froxels: a meter of fog gives one of red light and takes an eighth.
fn folder(test: &str) -> Folder {
    let folder = Folder::new(test);
    folder.with("foggy.ron", FOGGY.as_bytes());
    save_exact(&folder.file("scene.exr"), &picture(6, 2, |_, _| [16.0, 4.0, 2.0, 1.0]));
    save_exact(&folder.file("depth.exr"), &picture(6, 2, |x, _| [FAR[x as usize], 0.0, 0.0, 1.0]));
    let fog = picture(3, 8, |_, y| {
        let meters = (y / 2 + 1) as f32;
        [meters, 0.0, 0.0, 1.0 - 0.125 * meters]
    });
    save_exact(&folder.file("fog.exr"), &fog);
    folder
}

#[test]
#[cfg_attr(no_gpu, ignore = "AFTERIMAGE_NO_GPU is set")]
fn a_volume_comes_from_an_image_of_its_slices() {
    let folder = folder("volume");
    let given = "--input depth=depth.exr --input fog=fog.exr --slices 4";
    folder.run(&format!("render foggy.ron scene.exr {given} -o out.exr --depth 32")).good();
    let found = read(&Source::file(folder.file("out.exr"))).expect("a picture");
    // The volume comes first in the pipeline, and has another size.
    assert_eq!((found.width, found.height), (6, 2));
    let pixels = found.pixels.to_f32();
    for (index, pixel) in pixels.chunks_exact(4).enumerate() {
        // Where nothing was drawn, at 0, is behind all fog.
        let meters = Some(FAR[index % 6]).filter(|far| *far > 0.0).unwrap_or(f32::INFINITY).min(4.0);
        let passed = 1.0 - 0.125 * meters;
        let wanted = [16.0 * passed + meters, 4.0 * passed, 2.0 * passed];
        let is_near = (0..3).all(|channel| (pixel[channel] - wanted[channel]).abs() < 2e-3 * wanted[channel]);
        assert!(is_near, "{meters} m: {pixel:?} instead of {wanted:?}");
    }
    // A part is made in bands, with the whole volume.
    folder.run(&format!("render foggy.ron scene.exr {given} -o part.exr --depth 32 --crop 0,0,6x2")).good();
    let part = read(&Source::file(folder.file("part.exr"))).expect("a picture");
    assert_eq!(part.pixels, found.pixels);
}

#[test]
#[cfg_attr(no_gpu, ignore = "AFTERIMAGE_NO_GPU is set")]
fn slices_that_are_missing_do_not_divide_or_have_no_volume_are_errors() {
    let folder = folder("no-volume");
    let given = "render foggy.ron scene.exr --input depth=depth.exr --input fog=fog.exr -o out.exr";
    folder.run(given).fails_saying(
        1,
        &[
            "error: input `fog` is a volume, and the image does not say how deep",
            "hint: state the number of slices, which lie one below the other: `--slices 64`",
        ],
    );
    folder.run(&format!("{given} --slices 3")).fails_saying(
        1,
        &[
            "error: input `fog`: the image has 8 rows, which 3 slices do not divide",
            "hint: all slices have the same number of rows",
        ],
    );
    folder.run(&format!("{given} --slices 0")).fails_saying(1, &["0 is not in 1..=2048"]);
    folder
        .run("render {lynx} scene.exr --slices 4 -o out.png")
        .fails_saying(1, &["error: `--slices` is for images of volumes, and none is given"]);
    assert_eq!(folder.names(), ["depth.exr", "fog.exr", "foggy.ron", "scene.exr"]);
}

#[test]
#[cfg_attr(no_gpu, ignore = "AFTERIMAGE_NO_GPU is set")]
fn a_pipeline_whose_only_image_is_a_volume_renders_at_any_size() {
    let folder = folder("only-volume");
    let text = "Pipeline(inputs: { \"fog\": Color(volume: true) }, nodes: { \"scene\": DemoScene(samples: 1), \"foggy\": \
                VolumetricComposite(source: \"scene\", depth: \"scene.depth\", volume: \"fog\", slices: Linear, near: 0.0, \
                far: 0.4) }, outputs: { \"clear\": \"scene\", \"foggy\": \"foggy\" })";
    folder.with("made-up.ron", text.as_bytes());
    // Fog that is the same at all distances, even at the camera.
    save_exact(&folder.file("fog.exr"), &picture(3, 8, |_, _| [0.5, 0.25, 0.125, 0.5]));
    let fog = "made-up.ron --input fog=fog.exr --slices 4 --depth 32";
    folder.run(&format!("render {fog} --size 31x17 --output clear=clear.exr --output foggy=foggy.exr")).good();
    let [clear, foggy] =
        ["clear.exr", "foggy.exr"].map(|name| read(&Source::file(folder.file(name))).expect("a picture"));
    assert_eq!((foggy.width, foggy.height), (31, 17));
    let (clear, foggy) = (clear.pixels.to_f32(), foggy.pixels.to_f32());
    for (before, after) in clear.chunks_exact(4).zip(foggy.chunks_exact(4)) {
        for (channel, fog) in [0.5, 0.25, 0.125].into_iter().enumerate() {
            let wanted = 0.5 * before[channel] + fog;
            assert!((after[channel] - wanted).abs() < 2e-3 * wanted, "{before:?}: {after:?}");
        }
    }
}
