//! `--window`: pictures whose data window is not the display window.

use afterimage_media::{Budget, Encoding, ReadOptions, Source, read_within, write_image};

use super::{Folder, room};

#[test]
#[cfg_attr(no_gpu, ignore = "AFTERIMAGE_NO_GPU is set")]
fn overscan_is_kept_from_file_to_file() {
    let folder = Folder::new("overscan");
    let mut picture = room(24, 16);
    picture.meta.image.display_window.size.0 = 20;
    picture.meta.image.display_window.size.1 = 12;
    picture.meta.layer.layer_position.0 = -2;
    picture.meta.layer.layer_position.1 = -2;
    picture.meta.data_size = Some((24, 16));
    write_image(&folder.file("over.exr"), &picture, &Encoding::EXR).expect("it can be written");
    let light = "Pipeline(inputs: { \"scene\": Color }, nodes: { \"e\": Exposure(source: \"scene\", stops: 1.0) }, \
                 outputs: { \"light\": \"e\" })";
    folder.with("light.ron", light.as_bytes());
    let whole = ReadOptions { data_window: true, ..Budget(1 << 30).into() };
    let read = |name: &str| read_within(&Source::file(folder.file(name)), whole).expect("it is a picture");
    folder.run("render light.ron over.exr -o kept.exr --window data --drop-layers").good();
    let (before, after) = (read("over.exr"), read("kept.exr"));
    assert_eq!((after.width, after.height), (24, 16));
    assert_eq!(after.meta.image.display_window, before.meta.image.display_window);
    assert_eq!(after.meta.layer.layer_position, before.meta.layer.layer_position);
    assert!((after.pixel(3, 3)[0] - 2.0 * before.pixel(3, 3)[0]).abs() < 1e-3);
    let notes = folder.run("render light.ron over.exr -o shown.exr").notes();
    assert!(notes.contains("pixels outside the display window are left out"), "{notes}");
    assert_eq!((read("shown.exr").width, read("shown.exr").height), (20, 12));
    folder.run("render light.ron over.exr -o layers.exr --window data").good();
    assert_eq!(read("layers.exr").meta.layer.layer_position, before.meta.layer.layer_position);
}
