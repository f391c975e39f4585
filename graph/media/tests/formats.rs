//! The bytes decide the format, and what is no image says so.

use afterimage_base::color::{Chromaticities, Colorimetry};

use super::{Folder, message_and_hint, picture, read_layer};
use afterimage_media::*;

fn hdr(lines: &str, pixels: &[u8]) -> Vec<u8> {
    [lines.as_bytes(), pixels].concat()
}

#[test]
fn a_wrong_extension_does_not_matter() {
    let folder = Folder::new("extension");
    let bytes = encode(&picture(3, 5), &Encoding::EXR).unwrap();
    let path = folder.with("actually-exr.png", &bytes);
    assert_eq!(read(&Source::file(path)).unwrap().height, 5);
}

#[test]
fn radiance_numbers_are_exact() {
    let folder = Folder::new("radiance");
    // A mantissa of 128 with exponent 129 is 128/256 · 2¹ = 1.
    let pixels = [128, 64, 255, 129, 1, 0, 0, 136, 7, 8, 9, 0];
    for signature in ["#?RADIANCE", "#?RGBE"] {
        let header = format!("{signature}\nFORMAT=32-bit_rle_rgbe\nPRIMARIES=0 0 0 0 0 0 0 0\n\n-Y 1 +X 3\n");
        let picture = folder.read(&hdr(&header, &pixels)).unwrap();
        assert_eq!(picture.pixel(0, 0), [1.0, 0.5, 255.0 / 128.0, 1.0]);
        assert_eq!(picture.pixel(1, 0), [1.0, 0.0, 0.0, 1.0]);
        assert_eq!(picture.pixel(2, 0), [0.0, 0.0, 0.0, 1.0]);
        assert!(picture.notes.is_empty());
    }
}

#[test]
fn radiance_headers_are_heeded() {
    let folder = Folder::new("radiance-header");
    let header = "#?RADIANCE\nFORMAT=32-bit_rle_rgbe\nEXPOSURE=5\nEXPOSURE=0.5\nCOLORCORR=2 1 1\nPIXASPECT=0.5\n\
                  PRIMARIES=.708 .292 .170 .797 .131 .046 .3127 .3290\n\n-Y 1 +X 1\n";
    let picture = folder.read(&hdr(header, &[128, 0, 0, 129])).unwrap();
    // The exposures multiply to 2.5, and the first channel is also divided by 2.
    assert!((picture.pixel(0, 0)[0] - 1.660491 / 5.0).abs() < 1e-5);
    assert!((picture.pixel(0, 0)[1] + 0.124550 / 5.0).abs() < 1e-5);
    assert_eq!(picture.meta.image.pixel_aspect, 2.0);
    assert_eq!(picture.stated, Some(Colorimetry::linear(Chromaticities::REC2020)));
    assert!(picture.notes.is_empty());
    let dark = "#?RADIANCE\nFORMAT=32-bit_rle_rgbe\nEXPOSURE=0\n\n-Y 1 +X 1\n";
    let picture = folder.read(&hdr(dark, &[128, 0, 0, 129])).unwrap();
    assert_eq!(picture.pixel(0, 0)[0], 1.0);
    assert_eq!(picture.notes, ["`EXPOSURE` or `COLORCORR` of its header is no usable number and is not applied"]);
    let xyze = "#?RADIANCE\nFORMAT=32-bit_rle_xyze\n\n-Y 1 +X 1\n";
    let error = folder.read(&hdr(xyze, &[128, 0, 0, 129])).unwrap_err();
    assert_eq!(error.kind, ErrorKind::Unsupported);
}

#[test]
fn what_is_no_image_says_so() {
    let folder = Folder::new("no-image");
    let message = |bytes: &[u8]| message_and_hint(&folder.read(bytes).unwrap_err());
    let formats = match (cfg!(feature = "jxl"), cfg!(feature = "avif")) {
        (false, false) => "TIFF and DPX",
        (true, false) => "TIFF, DPX and JPEG XL",
        (false, true) => "TIFF, DPX and AVIF",
        (true, true) => "TIFF, DPX, JPEG XL and AVIF",
    };
    let known = format!("EXR, Radiance HDR, PNG, JPEG, {formats} files are read; convert it to one of them");
    assert_eq!(message(b"GIF89a and so on"), "this is a GIF; convert its frames: `ffmpeg -i IN.gif frame.%04d.png`");
    assert_eq!(message(b"hello"), format!("this is not an image that this program knows; {known}"));
    assert_eq!(message(b""), "the file is empty; copy or render it again");
    assert_eq!(
        message(b"v/1\x01"),
        "the file ends too early; it was cut short or is still being written; copy or render it again"
    );
}

#[test]
fn what_is_not_there_says_so() {
    let folder = Folder::new("missing");
    let error = read(&Source::file(folder.file("nothing.exr"))).unwrap_err();
    assert_eq!((error.kind, error.exit()), (ErrorKind::Missing, 1));
    let shown = error.to_string();
    assert!(shown.ends_with(
        "nothing.exr: there is no such file\n  hint: check the spelling; names are relative to \
         the folder you are in"
    ));
    let error = read(&Source::file(&folder.0)).unwrap_err();
    assert_eq!(error.message, "this is a folder, not an image");
}

#[test]
fn only_exr_has_layers() {
    let folder = Folder::new("no-layers");
    let path = folder.with("a.hdr", b"#?RADIANCE\n\n-Y 1 +X 1\n\0\0\0\0");
    assert_eq!(
        message_and_hint(&read_layer(&path, "diffuse").unwrap_err()),
        "only EXR files have layers, so `#diffuse` means nothing here; \
         leave out what follows the file's name"
    );
}
