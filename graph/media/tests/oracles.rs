//! Files for outside readers, in every format and with every label: `tests/oracles.sh` lets OpenEXR, libpng and
//! LittleCMS read them.

use std::fmt::Write as _;
use std::path::PathBuf;
use std::time::Duration;

use afterimage_base::color::{Chromaticities, Colorimetry, Decimal, Transfer};

use super::Folder;
use afterimage_media::*;

const SPACES: [(&str, Chromaticities); 5] = [
    ("Rec709", Chromaticities::REC709),
    ("DisplayP3", Chromaticities::DISPLAY_P3),
    ("Rec2020", Chromaticities::REC2020),
    ("AcesCg", Chromaticities::ACES_CG),
    ("AcesAp0", Chromaticities::ACES_AP0),
];

const TRANSFERS: [(&str, Transfer); 6] = [
    ("Srgb", Transfer::Srgb),
    ("Linear", Transfer::Linear),
    ("Gamma2.2", Transfer::Gamma(Decimal::new(2.2))),
    ("Gamma2.6", Transfer::Gamma(Decimal::new(2.6))),
    ("Pq", Transfer::Pq),
    ("Hlg", Transfer::Hlg),
];

/// A file: its name, and its bytes if its format states these colors.
type Made = (String, Option<Vec<u8>>);

fn files(codes: &[u8]) -> Vec<Made> {
    let size = (codes.len() as u32 / 4, 1);
    let numbers: Vec<f32> = codes.iter().map(|code| f32::from(*code) / 255.0).collect();
    let mut made = Vec::new();
    for (space, primaries) in SPACES {
        for (curve, transfer) in TRANSFERS {
            let color = Colorimetry::new(primaries, transfer);
            let color = Some(if color.is_hdr() { color.nits(203.0, 1000.0) } else { color });
            for bits in [8, 16] {
                let options =
                    Encoding { bits, alpha: Alpha::Drop, premultiplied: false, dither: None, color, ..Encoding::PNG };
                let bytes = encode((size, Samples::Float(&numbers)), &options).ok();
                made.push((format!("{space}-{curve}-{bits}.png"), bytes));
            }
            let options = Encoding { quality: 100, dither: None, color, ..Encoding::JPEG };
            made.push((format!("{space}-{curve}.jpg"), encode((size, Samples::Float(&numbers)), &options).ok()));
        }
        // Codes of Rec.709, converted.
        let color = Some(Colorimetry::linear(Chromaticities::REC709).nits(203.0, 1000.0));
        let options = Encoding { bits: 32, color, primaries: Some(primaries), scene: true, ..Encoding::EXR };
        let picture = Picture::new(size.0, 1, Pixels::Float(numbers.clone()));
        made.push((format!("{space}-Converted.exr"), encode(&picture, &options).ok()));
        for (bits, name) in [(16, "half"), (32, "float")] {
            let color = Some(Colorimetry::linear(primaries).nits(203.0, 1000.0));
            let mut picture = Picture::new(size.0, 1, Pixels::Float(numbers.clone()));
            picture.meta.layer.screen_window_width = -1.0;
            let options = Encoding { bits, color, ..Encoding::EXR };
            let name = format!("{space}-{name}.exr");
            made.push((name, encode(&picture, &options).ok()));
        }
    }
    made
}

/// The files go into the folder of the variable `AFTERIMAGE_ORACLES`, where a list says which codes they hold. Without
/// it they are made, and made again at once instead of more than a second later.
#[test]
fn files_of_every_label_are_equal_whenever_they_are_made() {
    let codes: Vec<u8> =
        (0..27_u8).flat_map(|at| [at % 3 * 90 + 40, at / 3 % 3 * 90 + 40, at / 9 * 90 + 40, 255]).collect();
    let first = files(&codes);
    let asked = std::env::var_os("AFTERIMAGE_ORACLES").map(PathBuf::from);
    if asked.is_some() {
        std::thread::sleep(Duration::from_millis(1100));
    }
    let again = files(&codes);
    let temporary = Folder::new("oracles");
    let folder = asked.unwrap_or_else(|| temporary.0.clone());
    let (mut list, mut count) = (String::new(), 0);
    for ((name, bytes), (_, other)) in first.iter().zip(&again) {
        assert!(bytes == other, "{name} differs when it is made again");
        let Some(bytes) = bytes else { continue };
        std::fs::write(folder.join(name), bytes).unwrap();
        writeln!(list, "{name}").unwrap();
        count += 1;
    }
    let codes: Vec<String> = codes.iter().map(u8::to_string).collect();
    std::fs::write(folder.join("codes.txt"), codes.join(" ")).unwrap();
    std::fs::write(folder.join("files.txt"), list).unwrap();
    // PQ and HLG need a code for their primaries in a PNG, and no JPEG has them.
    assert_eq!(count, 5 * (4 * 3 + 3) + 3 * 2 * 2, "{count} files");
}
