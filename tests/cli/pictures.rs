//! Pictures that the program makes.

use std::fs;

use afterimage_media::{Source, read};

use super::{Folder, Outcome, room, save};

/// Width, height and RGB bytes of a PNG.
fn png(path: &std::path::Path) -> (u32, u32, Vec<[u8; 3]>) {
    let file = std::io::BufReader::new(fs::File::open(path).expect("the picture was written"));
    let mut reader = png::Decoder::new(file).read_info().expect("a PNG");
    let mut bytes = vec![0; reader.output_buffer_size().expect("a size")];
    let info = reader.next_frame(&mut bytes).expect("whole pixels");
    let channels = info.color_type.samples();
    assert_eq!(info.bit_depth, png::BitDepth::Eight);
    let pixels = bytes[..info.buffer_size()].chunks_exact(channels).map(|pixel| [pixel[0], pixel[1], pixel[2]]);
    (info.width, info.height, pixels.collect())
}

#[test]
#[cfg_attr(no_gpu, ignore = "AFTERIMAGE_NO_GPU is set")]
fn demo_writes_the_scene_every_pipeline_and_a_page() {
    let folder = Folder::new("demo");
    let run = folder.run("demo --size 64x36 --time 0.5");
    let (notes, printed) = (run.err.clone(), run.good());
    let names = |printed: &str| printed.lines().map(str::to_owned).collect::<Vec<_>>();
    let shown = fs::read_dir(super::built_in("lynx").with_file_name("")).expect("the built-in pipelines");
    let shown =
        shown.map(|entry| entry.expect("an entry").path()).filter(|path| path.extension().is_some_and(|e| e == "ron"));
    let shown =
        shown.map(|path| path.with_extension("png").file_name().map(|name| name.to_string_lossy().into_owned()));
    let more = ["scene.exr", "index.html"].map(|name| Some(name.to_owned()));
    for name in &shown.chain(more).flatten().collect::<Vec<_>>() {
        let path = folder.file("out").join(name);
        assert!(names(&printed).iter().any(|line| line.ends_with(name)), "{printed}");
        assert!(path.is_file(), "{name}");
    }
    let page = fs::read_to_string(folder.file("out/index.html")).expect("a page");
    let commands: Vec<&str> = notes.lines().filter_map(|line| line.strip_prefix("  ")).collect();
    assert_eq!(commands.len(), 3, "{notes}");
    for line in commands {
        let (program, words) = line.split_once(' ').expect("a command has words");
        assert!(fs::exists(program).is_ok_and(|is_there| is_there), "{line}: the program as it was called");
        assert!(!words.starts_with("render") || page.contains(line), "{line}");
        if !words.starts_with("view ") {
            folder.run(words).good();
        }
    }
    assert!(folder.file("tsushima.png").is_file() && folder.file("my.ron").is_file(), "{notes}");
    for image in page.split("src=\"").skip(1).filter_map(|rest| rest.split('"').next()) {
        assert!(folder.file("out").join(image).is_file(), "{image}");
    }
    let scene = read(&Source::file(folder.file("out/scene.exr"))).expect("a scene");
    assert_eq!((scene.width, scene.height), (64, 36));
    let brightest = scene.pixels.to_f32().into_iter().fold(0.0, f32::max);
    assert!(brightest > 10.0, "a scene worth processing has lights: {brightest}");
    let (width, height, pixels) = png(&folder.file("out/lynx.png"));
    assert_eq!((width, height), (64, 36));
    let (dark, light) = (pixels.iter().flatten().min(), pixels.iter().flatten().max());
    assert!(dark < Some(&60) && light > Some(&200), "{dark:?} to {light:?}");
    let text = "Pipeline(inputs: {}, nodes: { \"scene\": DemoScene(time: 0.5) }, outputs: { \"scene\": \"scene\" })";
    folder.with("scene.ron", text.as_bytes());
    folder.run("render scene.ron --size 64x36 -o own.exr").good();
    assert_eq!(scene.pixels.to_f32(), floats(&folder, "own.exr"), "at that time");
}

/// A driver on the processor works a dispatch off in an order that its number of threads makes, and Mesa's reads it
/// from here. With other drivers these are runs of their own.
#[test]
#[cfg_attr(no_gpu, ignore = "AFTERIMAGE_NO_GPU is set")]
fn the_number_of_threads_does_not_show() {
    let folder = Folder::new("threads");
    save(&folder.file("room.exr"), &room(331, 187));
    let picture = |threads: &str| {
        let mut command = folder.command("render {tsushima} room.exr -o room.png");
        Outcome::of(&command.env("LP_NUM_THREADS", threads).output().expect("the program starts")).good();
        png(&folder.file("room.png"))
    };
    let one = picture("0");
    for threads in ["1", "2", "7"] {
        assert!(one == picture(threads), "with {threads} threads the picture has other bits");
    }
}

#[test]
#[cfg_attr(no_gpu, ignore = "AFTERIMAGE_NO_GPU is set")]
fn an_exr_becomes_a_png() {
    let folder = Folder::new("png");
    save(&folder.file("room.exr"), &room(61, 33));
    assert_eq!(folder.run("render {glare} room.exr -o room.png").good(), "");
    let (width, height, pixels) = png(&folder.file("room.png"));
    assert_eq!((width, height), (61, 33));
    let at = |x: usize, y: usize| pixels[y * 61 + x];
    assert!(at(30, 16).iter().all(|code| *code > 240), "the lamp is white: {:?}", at(30, 16));
    let [r, g, b] = at(10, 30);
    assert!(r > g && g > b && b > 40 && r < 160, "the wall is warm and dim: {:?}", at(10, 30));
    assert!(at(55, 30)[1] > g + 20, "light grows to the right: {:?}", at(55, 30));
    assert_eq!(folder.names(), ["room.exr", "room.png"]);
}

#[test]
#[cfg_attr(no_gpu, ignore = "AFTERIMAGE_NO_GPU is set")]
fn a_linear_output_becomes_an_exr_and_can_be_read_again() {
    let folder = Folder::new("exr");
    save(&folder.file("room.exr"), &room(20, 10));
    let pipeline = "Pipeline(inputs: { \"scene\": Color }, nodes: { \"bright\": Exposure(source: \"scene\", stops: 1.0) }, \
                    outputs: { \"light\": \"bright\" })";
    folder.with("twice.ron", pipeline.as_bytes());
    folder.run("render twice.ron room.exr -o twice.exr --depth 32").good();
    folder.run("render twice.ron room.exr -o half.exr --set bright.stops=-1").good();
    let (before, after) = (room(20, 10).pixels.to_f32(), floats(&folder, "twice.exr"));
    for (x, y) in before.chunks(4).zip(after.chunks(4)) {
        assert!((0..3).all(|c| (2.0 * x[c] - y[c]).abs() < 0.002 * x[c]), "{x:?} {y:?}");
        assert_eq!(y[3], 1.0);
    }
    let darker = floats(&folder, "half.exr");
    assert!((darker[0] - before[0] / 2.0).abs() < 1e-4, "{} {}", darker[0], before[0]);
}

fn floats(folder: &Folder, name: &str) -> Vec<f32> {
    read(&Source::file(folder.file(name))).expect("the picture was written").pixels.to_f32()
}

#[test]
#[cfg_attr(no_gpu, ignore = "AFTERIMAGE_NO_GPU is set")]
fn drawing_and_dispatching_give_the_same_picture() {
    let folder = Folder::new("stages");
    save(&folder.file("room.exr"), &room(61, 33));
    folder.run("render {lynx} room.exr -o dispatched.png --no-dither").good();
    folder.run("render {lynx} room.exr -o drawn.png --no-dither --plan draws=on,fuse=off,alias=none").good();
    let (dispatched, drawn) = (png(&folder.file("dispatched.png")).2, png(&folder.file("drawn.png")).2);
    let differences = dispatched.as_flattened().iter().zip(drawn.as_flattened()).map(|(a, b)| a.abs_diff(*b));
    assert!(differences.max() <= Some(1));
    assert!(dispatched.as_flattened().iter().any(|code| *code > 100));
}

#[test]
#[cfg_attr(no_gpu, ignore = "AFTERIMAGE_NO_GPU is set")]
fn nothing_but_nan_gives_a_black_picture() {
    let folder = Folder::new("nan");
    let mut picture = room(16, 16);
    picture.pixels = afterimage_media::Pixels::Float(vec![f32::NAN; 16 * 16 * 4]);
    save(&folder.file("nan.exr"), &picture);
    folder.run("render {glare} nan.exr -o black.png --no-dither").good();
    assert_eq!(png(&folder.file("black.png")).2, [[0; 3]; 256]);
}

#[test]
#[cfg_attr(no_gpu, ignore = "AFTERIMAGE_NO_GPU is set")]
fn a_pipeline_without_inputs_renders_at_any_size() {
    let folder = Folder::new("source");
    let text = "Pipeline(inputs: {}, nodes: { \"scene\": DemoScene() }, outputs: { \"scene\": \"scene\", \"depth\": \"scene.depth\" })";
    folder.with("scene.ron", text.as_bytes());
    folder.run("render scene.ron --size 31x17 -o depth.exr --output depth --depth 32").good();
    let depth = read(&Source::file(folder.file("depth.exr"))).expect("the picture was written");
    assert_eq!((depth.width, depth.height), (31, 17));
    let far = depth.pixels.to_f32().chunks(4).map(|pixel| pixel[0]).fold(0.0, f32::max);
    assert!(far > 1.0 && far <= 1000.0, "{far}");
}

#[test]
#[cfg_attr(no_gpu, ignore = "AFTERIMAGE_NO_GPU is set")]
fn a_good_run_prints_nothing_foreign_and_a_card_can_be_required() {
    let folder = Folder::new("quiet");
    save(&folder.file("room.exr"), &room(12, 8));
    assert_eq!(folder.run("render grade room.exr -o room.png").notes(), "");
    let required = folder.run("render grade room.exr -o required.png --require-gpu");
    match required.status {
        Some(0) => assert!(folder.file("required.png").exists()),
        _ => required.fails_saying(2, &["`--require-gpu`: the only adapter is the processor"]),
    }
}

/// Layers belong to a color, which numbers of another meaning are not.
#[test]
#[cfg_attr(no_gpu, ignore = "AFTERIMAGE_NO_GPU is set")]
fn data_are_written_without_the_layers_of_the_picture() {
    use exr::prelude::{AnyChannel, AnyChannels, FlatSamples, Image, WritableImage};
    let folder = Folder::new("data-layers");
    let channel = |name: &str| AnyChannel::new(name, FlatSamples::F32(vec![0.5; 24]));
    let channels = AnyChannels::sort(["B", "G", "R", "Z"].map(channel).into_iter().collect());
    Image::from_channels((6, 4), channels).write().to_file(folder.file("in.exr")).expect("it can be written");
    for (ty, has_depth) in [("Color", true), ("Data", false)] {
        let text = format!("Pipeline(inputs: {{ \"in\": {ty} }}, nodes: {{}}, outputs: {{ \"out\": \"in\" }})");
        folder.with("same.ron", text.as_bytes());
        folder.run("render same.ron in.exr -o out.exr").good();
        let written = afterimage_media::read_description(&Source::file(folder.file("out.exr")));
        let parts = written.expect("it was written").parts;
        let mut channels = parts.iter().flat_map(|part| &part.channels);
        assert_eq!(channels.any(|channel| channel.name == "Z"), has_depth, "{ty}");
        let told = folder.run("render same.ron in.exr -o -").err;
        assert_eq!(told.contains("standard output takes the picture alone"), has_depth, "{told}");
    }
}
