//! Variables of the environment, versions, manual pages and help.

use super::{Folder, Outcome, room, save};

fn version_of(package: &str) -> String {
    let lock = std::fs::read_to_string(concat!(env!("CARGO_MANIFEST_DIR"), "/../Cargo.lock")).expect("a lock file");
    let after = lock.split(&format!("name = \"{package}\"\nversion = \"")).nth(1).expect("the package is used");
    after.split('"').next().expect("a version").to_owned()
}

#[test]
fn the_long_version_names_the_libraries_that_are_built() {
    let folder = Folder::new("version");
    let long = folder.run("--version").good();
    assert!(long.contains(&format!("wgpu {}, naga {}", version_of("wgpu"), version_of("naga"))), "{long}");
    assert_eq!(folder.run("-V").good().lines().collect::<Vec<_>>(), [long.lines().next().expect("a line")]);
}

#[test]
fn each_command_has_a_manual_page() {
    let folder = Folder::new("man");
    folder.run("man pages/man1").good();
    let page = |name: &str| std::fs::read_to_string(folder.file("pages/man1").join(name)).expect(name);
    assert!(page("afterimage.1").contains(".TH afterimage 1"));
    let render = page("afterimage-render.1");
    assert!(render.contains("AFTERIMAGE_ADAPTER") && render.contains("skip\\-existing"), "{render}");
    folder.with("file", b"");
    folder.run("man file").fails_saying(2, &["file: "]);
}

#[test]
fn options_stand_under_headings() {
    let help = Folder::new("headings").run("render --help").good();
    for heading in ["Input files:", "Sequences:", "Output files:", "Pipeline:", "Machine:"] {
        assert_eq!(help.lines().filter(|line| *line == heading).count(), 1, "{heading}\n{help}");
    }
}

#[test]
#[cfg_attr(no_gpu, ignore = "AFTERIMAGE_NO_GPU is set")]
fn variables_stand_for_options_of_all_runs() {
    let folder = Folder::new("variables");
    save(&folder.file("room.exr"), &room(16, 8));
    let light = "Pipeline(inputs: { \"scene\": Color }, nodes: {}, outputs: { \"light\": \"scene\" })";
    folder.with("light.ron", light.as_bytes());
    let run = |line: &str, variable: &str, value: &str| {
        Outcome::of(&folder.command(line).env(variable, value).output().expect("it starts"))
    };
    let png = "render {glare} room.exr -o out.png";
    run(png, "AFTERIMAGE_ADAPTER", "Voodoo2").fails_saying(1, &["no graphics adapter called `Voodoo2`"]);
    run(png, "AFTERIMAGE_MEMORY", "1K").fails_saying(1, &["`--memory SIZE` changes the limit"]);
    run(png, "AFTERIMAGE_GPU_MEMORY", "16K").fails_saying(1, &["`--gpu-memory SIZE` allows more"]);
    run(&format!("{png} --gpu-memory 1G"), "AFTERIMAGE_GPU_MEMORY", "16K").good();
    run(png, "AFTERIMAGE_REQUIRE_GPU", "0").good();
    // An empty one is none.
    let names = ["ADAPTER", "MEMORY", "GPU_MEMORY", "REQUIRE_GPU", "OUTPUT_SPACE", "NODES"];
    let mut command = folder.command(png);
    command.envs(names.map(|name| (format!("AFTERIMAGE_{name}"), "")));
    Outcome::of(&command.output().expect("it starts")).good();
    // Of no use for a PNG, and no mistake either.
    run(png, "AFTERIMAGE_OUTPUT_SPACE", "ACEScg").good();
    run("render light.ron room.exr -o a.exr", "AFTERIMAGE_OUTPUT_SPACE", "ACEScg").good();
    save(&folder.file("shot.1.exr"), &room(16, 8));
    let job = run("job light.ron shot.#.exr -o a.#.exr", "AFTERIMAGE_OUTPUT_SPACE", "ACEScg").good();
    let job: serde_json::Value = serde_json::from_str(&job).expect("it is JSON");
    assert_eq!(job["jobEnvironments"][0]["variables"]["AFTERIMAGE_OUTPUT_SPACE"], "ACEScg");
    folder.run("render light.ron room.exr -o b.exr --output-space ACEScg").good();
    let [a, b] = ["a.exr", "b.exr"].map(|name| std::fs::read(folder.file(name)).expect("it is written"));
    assert!(a == b, "the space of the variable is that of the option");
}

#[test]
#[cfg_attr(no_gpu, ignore = "AFTERIMAGE_NO_GPU is set")]
fn a_jpeg_is_an_input() {
    let folder = Folder::new("jpeg");
    save(&folder.file("room.exr"), &room(64, 32));
    folder.run("render {lynx} room.exr -o a.jpg --quality 100").good();
    let light = "Pipeline(inputs: { \"shown\": DisplayLinear }, nodes: { \"e\": Encode(source: \"shown\") }, outputs: \
                 { \"picture\": \"e\" })";
    folder.with("again.ron", light.as_bytes());
    folder.run("render again.ron a.jpg -o b.jpg --quality 100 --no-dither").good();
    let [a, b] = ["a.jpg", "b.jpg"].map(|name| {
        let source = afterimage_media::Source::file(folder.file(name));
        afterimage_media::read(&source).expect("it is a picture").pixels.to_f32()
    });
    let worst = a.iter().zip(&b).map(|(a, b)| (a - b).abs()).fold(0.0, f32::max);
    assert!(worst < 0.03 && a.iter().any(|value| *value > 0.3), "{worst}");
    let told = folder.run("info a.jpg").good();
    assert!(told.contains("JPEG") && told.contains("ICC profile"), "{told}");
}
