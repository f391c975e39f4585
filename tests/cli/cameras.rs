//! Cameras of the command line.

use afterimage_media::{Picture, Pixels, Source, read};

use super::{Folder, save_exact};

const FAR: &str = "Pipeline(inputs: { \"depth\": Depth, \"camera\": Camera }, \
                   nodes: { \"far\": LinearDepth(depth: \"depth\", camera: \"camera\") }, outputs: { \"far\": \"far\" })";

/// A projection with the near plane, of this distance, at 1 and an infinite far plane.
fn camera(near: f32) -> String {
    let view = "[[1, 0, 0, 0], [0, 1, 0, 0], [0, 0, 1, -3], [0, 0, 0, 1]]";
    let projection = format!("[[1, 0, 0, 0], [0, 1, 0, 0], [0, 0, 0, {near}], [0, 0, -1, 0]]");
    format!("{{ \"view\": {view}, \"projection\": {projection}, \"near\": {near} }}")
}

fn folder(test: &str) -> Folder {
    let folder = Folder::new(test);
    folder.with("far.ron", FAR.as_bytes());
    let pixels = (0..8 * 4).flat_map(|_| [0.25, 0.0, 0.0, 1.0]).collect();
    let depth = Picture::new(8, 4, Pixels::Float(pixels));
    for frame in [1, 2] {
        save_exact(&folder.file(&format!("depth.{frame:04}.exr")), &depth);
        folder.with(&format!("camera.{frame:04}.json"), camera(frame as f32).as_bytes());
    }
    folder
}

fn first_number(folder: &Folder, name: &str) -> f32 {
    read(&Source::file(folder.file(name))).expect("the picture was written").pixels.to_f32()[0]
}

#[test]
#[cfg_attr(no_gpu, ignore = "AFTERIMAGE_NO_GPU is set")]
fn each_frame_has_the_camera_of_its_file() {
    let folder = folder("cameras");
    folder.run("render far.ron depth.####.exr --input camera=camera.####.json -o far.####.exr --depth 32").good();
    assert_eq!(["far.0001.exr", "far.0002.exr"].map(|name| first_number(&folder, name)), [4.0, 8.0]);
    // The camera may come first, and one file may be that of all frames.
    let line = "render far.ron --input camera=camera.0002.json --input depth=depth.####.exr -o still.####.exr";
    folder.run(line).good();
    assert_eq!(["still.0001.exr", "still.0002.exr"].map(|name| first_number(&folder, name)), [8.0, 8.0]);
    folder.run("render far.ron depth.####.exr --input camera=camera.0002.json -o still.####.exr").good();
    assert_eq!(["still.0001.exr", "still.0002.exr"].map(|name| first_number(&folder, name)), [8.0, 8.0]);
}

/// `worldToCamera` and `worldToNDC` of [`camera`], and its near plane, as the OpenEXR standard has them.
fn stated(near: f32) -> Picture {
    let mut picture = Picture::new(8, 4, Pixels::Float(vec![0.5; 8 * 4 * 4]));
    let own = &mut picture.meta.layer;
    let along_z = [1.0, 0.0, 0.0, 0.0, 0.0, 1.0, 0.0, 0.0, 0.0, 0.0, -1.0, 0.0, 0.0, 0.0, 3.0, 1.0];
    own.world_to_camera = Some(along_z);
    own.world_to_normalized_device =
        Some([0.5, 0.0, 0.0, 0.0, 0.0, -0.5, 0.0, 0.0, -0.5, -0.5, 0.0, -1.0, 1.5, 1.5, 0.0, 3.0]);
    own.near_clip_plane = Some(near);
    picture
}

#[test]
#[cfg_attr(no_gpu, ignore = "AFTERIMAGE_NO_GPU is set")]
fn an_exr_file_states_its_camera() {
    let folder = folder("stated-cameras");
    for frame in [1, 2] {
        save_exact(&folder.file(&format!("shot.{frame:04}.exr")), &stated(frame as f32));
    }
    folder.run("render far.ron depth.####.exr --input camera=shot.####.exr -o far.####.exr --depth 32").good();
    assert_eq!(["far.0001.exr", "far.0002.exr"].map(|name| first_number(&folder, name)), [4.0, 8.0]);
    let line = "render far.ron depth.0001.exr -o far.exr --input camera=";
    folder.run(&format!("{line}depth.0001.exr")).fails_saying(1, &["depth.0001.exr", "`worldToCamera`", ".json"]);
    let mut flat = stated(1.0);
    flat.meta.layer.world_to_camera = Some([0.0; 16]);
    save_exact(&folder.file("flat.exr"), &flat);
    folder.run(&format!("{line}flat.exr")).fails_saying(1, &["flat.exr", "are no camera"]);
    folder.run(&format!("{line}far.ron.exr")).fails_saying(1, &["far.ron.exr", "no such file"]);
}

#[test]
fn a_camera_that_is_missing_or_broken_is_an_error() {
    let folder = folder("broken-cameras");
    let missing = "error: the pipeline needs a camera for its input `camera`\n  \
                   hint: name a JSON file with its matrices, or an EXR file that states them: `--input camera=FILE`";
    folder.run("render far.ron depth.0001.exr -o far.exr").fails(1, missing);
    folder.with("text.json", b"view");
    folder.with("flat.json", camera(0.0).as_bytes());
    folder.with("half.json", b"{ \"view\": [[1, 0, 0, 0]] }");
    for (name, why) in [("text", "line 1"), ("flat", "has no inverse"), ("half", "line 1"), ("none", "no such file")] {
        let line = format!("render far.ron depth.0001.exr --input camera={name}.json -o far.exr");
        folder.run(&line).fails_saying(1, &[&format!("{name}.json"), why]);
    }
}

#[test]
#[cfg_attr(no_gpu, ignore = "AFTERIMAGE_NO_GPU is set")]
fn the_built_in_scene_brings_its_camera() {
    let folder = Folder::new("scene-camera");
    let text = "Pipeline(inputs: { \"camera\": Camera }, nodes: { \"scene\": DemoScene(walk: 0.5), \
                \"far\": LinearDepth(depth: \"scene.projected\", camera: \"camera\") }, \
                outputs: { \"far\": \"far\", \"depth\": \"scene.depth\" })";
    folder.with("scene.ron", text.as_bytes());
    folder.run("render scene.ron --size 16x9 --output far=far.exr --output depth=depth.exr --depth 32").good();
    let [far, depth] = ["far.exr", "depth.exr"].map(|name| first_number(&folder, name));
    assert!((far / depth - 1.0).abs() < 1e-4 && far > 0.5, "{far} and {depth}");
}
