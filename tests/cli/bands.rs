//! Pictures that are larger than the device, or than the memory for them.

use afterimage_media::{Encoding, Source, read, write_image};

use super::{Folder, room};

#[test]
#[cfg_attr(no_gpu, ignore = "AFTERIMAGE_NO_GPU is set")]
fn a_share_of_the_size_is_the_picture_of_scaled_images() {
    let folder = Folder::new("scale");
    write_image(&folder.file("in.exr"), &room(91, 50), &Encoding::EXR).expect("it can be written");
    let picture = read(&Source::file(folder.file("in.exr"))).expect("it is a picture");
    write_image(&folder.file("small.exr"), &picture.scaled(23, 13), &Encoding::EXR).expect("it can be written");
    folder.run("render tsushima in.exr -o share.png --scale 25%").good();
    folder.run("render tsushima small.exr -o small.png").good();
    let bytes = |name: &str| std::fs::read(folder.file(name)).expect("it is written");
    assert!(bytes("share.png") == bytes("small.png"));
    folder.run("render tsushima in.exr -o share.png --scale 2").fails_saying(1, &["at most 1, such as 0.5 or 25%"]);
}

#[test]
#[cfg_attr(no_gpu, ignore = "AFTERIMAGE_NO_GPU is set")]
fn a_picture_has_the_same_pixels_in_bands() {
    let folder = Folder::new("bands");
    write_image(&folder.file("tall.exr"), &room(203, 3001), &Encoding::EXR).expect("it can be written");
    let light = "Pipeline(inputs: { \"scene\": Color }, outputs: { \"light\": \"lit\" }, nodes: { \
                 \"wide\": Gaussian(source: \"scene\", sigma: 9.0), \
                 \"lit\": Composite(base: \"scene\", bloom: \"wide\", blend: Mix, strength: 0.3) })";
    std::fs::write(folder.file("light.ron"), light).expect("it can be written");
    let bytes = |name: &str| std::fs::read(folder.file(name)).expect("it is written");
    let picture = |name: &str| read(&Source::file(folder.file(name))).expect("it is a picture").pixels;
    folder.run("render tsushima tall.exr -o whole.png").good();
    let notes = folder.run("render tsushima tall.exr -o banded.png --gpu-memory 20M").notes();
    assert!(notes.contains("image exceeds the memory limit") && notes.contains("bands in 3 sweeps"), "{notes}");
    assert_eq!(picture("banded.png"), picture("whole.png"));
    // Neither the file nor the picture fits: both are read and written row by row.
    let line = "render tsushima tall.exr -o streamed.png --gpu-memory 20M --memory 50M --json report.json";
    folder.run(line).good();
    assert_eq!(picture("streamed.png"), picture("whole.png"));
    folder.run("render tsushima tall.exr -o whole.jpg").good();
    folder.run("render tsushima tall.exr -o rows.jpg --gpu-memory 20M --memory 50M").good();
    assert!(bytes("rows.jpg") == bytes("whole.jpg"));
    let report = std::fs::read_to_string(folder.file("report.json")).expect("it is written");
    assert!(report.contains("\"outcome\": \"good\""), "{report}");
    for options in ["", "--compression dwab --depth 32 --output-space ACEScg", "--crop 3,500,100x1200"] {
        folder.run(format!("render light.ron tall.exr -o whole.exr {options}").trim_end()).good();
        let line = format!("render light.ron tall.exr -o rows.exr --gpu-memory 20M --memory 51M {options}");
        folder.run(line.trim_end()).good();
        assert!(bytes("rows.exr") == bytes("whole.exr"), "{options}");
    }
    // The noise of eight bits begins at the corner of the file.
    folder.run("render tsushima tall.exr -o whole.png --depth 16").good();
    folder.run("render tsushima tall.exr -o part.png --depth 16 --crop 11,600,40x77").good();
    let part = read(&Source::file(folder.file("part.png"))).expect("it is a picture");
    let whole = read(&Source::file(folder.file("whole.png"))).expect("it is a picture");
    assert_eq!((part.width, part.height), (40, 77));
    assert!((0..77).all(|y| (0..40).all(|x| part.pixel(x, y) == whole.pixel(x + 11, y + 600))));
    let beyond = folder.run("render tsushima tall.exr -o part.png --crop 11,600,193x77");
    beyond.fails_saying(1, &["`--crop` is a part beyond the 203x3001 pixels of the picture"]);
    folder.run("render tsushima tall.exr -o none.png --gpu-memory 1M").fails_saying(1, &["may take at most 1.0 MiB"]);
}

/// Memory of a sweep is freed before the next one.
#[test]
#[cfg_attr(no_gpu, ignore = "AFTERIMAGE_NO_GPU is set")]
fn a_picture_in_bands_takes_no_more_memory_than_it_may() {
    let folder = Folder::new("band-memory");
    write_image(&folder.file("wide.exr"), &room(803, 3001), &Encoding::EXR).expect("it can be written");
    let notes = folder.run("render tsushima wide.exr -o out.png --gpu-memory 64M").notes();
    let taken = notes.split(" sweeps, with ").nth(1).and_then(|rest| rest.split(' ').next()).expect("it is said");
    assert!(taken.parse::<u32>().is_ok_and(|taken| (16..=64).contains(&taken)), "{notes}");
}

#[test]
#[cfg_attr(no_gpu, ignore = "AFTERIMAGE_NO_GPU is set")]
fn the_memory_of_the_host_bounds_the_rows_of_bands() {
    let folder = Folder::new("host");
    write_image(&folder.file("tall.exr"), &room(203, 3001), &Encoding::EXR).expect("it can be written");
    let picture = |name: &str| read(&Source::file(folder.file(name))).expect("it is a picture").pixels;
    folder.run("render tsushima tall.exr -o whole.png").good();
    // The decoder has 48 MiB for itself. Two are left for rows of the file, which has 4.6; the device has enough.
    let notes = folder.run("render tsushima tall.exr -o rows.png --memory 50M").notes();
    assert!(notes.contains("bands in 3 sweeps"), "{notes}");
    assert_eq!(picture("rows.png"), picture("whole.png"));
    let refused = folder.run("render tsushima tall.exr -o rows.png --memory 49216K");
    refused
        .fails_saying(1, &["the rows of a band take", "but may take at most 0.1 MiB", "`--memory SIZE` allows more"]);
}
