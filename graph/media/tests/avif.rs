//! AVIF: boxes, by their names and bytes.

use afterimage_base::color::{Chromaticities, Colorimetry, Decimal, Transfer};

use afterimage_media::*;

/// The content of the first box of that name.
fn content<'a>(file: &'a [u8], name: &[u8; 4]) -> Option<&'a [u8]> {
    let at = file.windows(4).position(|window| window == name)?;
    let length = u32::from_be_bytes(file[at - 4..at].try_into().unwrap()) as usize;
    Some(&file[at + 4..at - 4 + length])
}

fn encoded(color: Colorimetry) -> Result<Vec<u8>, CodecError> {
    let values: Vec<f32> = (0..64 * 32 * 4).map(|i| (i % 97) as f32 / 160.0).collect();
    encode_avif((64, 32), EncodedPixels::Float(&values), &AvifOptions { color, speed: 10, ..AvifOptions::default() })
}

#[test]
fn an_avif_has_ten_bits_and_states_its_colors() {
    let spaces = [(Chromaticities::REC709, 1, 1), (Chromaticities::DISPLAY_P3, 12, 1), (Chromaticities::REC2020, 9, 9)];
    for (primaries, code, matrix) in spaces {
        for (transfer, transfer_code) in
            [(Transfer::Srgb, 13), (Transfer::Linear, 8), (Transfer::Pq, 16), (Transfer::Hlg, 18)]
        {
            let color = Colorimetry::new(primaries, transfer).nits(203.0, 1000.0);
            let file = encoded(color).unwrap();
            assert_eq!(file[4..12], *b"ftypavif");
            // Code points of 16 bits, then full range.
            let colr = [&b"nclx"[..], &[0, code, 0, transfer_code, 0, matrix, 0x80]].concat();
            // sRGB with the defaults may be left to the AV1 payload.
            let is_default = (code, transfer_code) == (1, 13);
            assert!(content(&file, b"colr").map_or(is_default, |found| found == colr), "{code}, {transfer_code}");
            assert_eq!(content(&file, b"pixi"), Some(&[0, 0, 0, 0, 3, 10, 10, 10][..]));
            let is_hdr = color.is_hdr();
            assert_eq!([content(&file, b"mdcv").is_some(), content(&file, b"clli").is_some()], [is_hdr; 2]);
        }
    }
}

#[test]
fn colors_without_code_points_are_refused() {
    let gamma = Colorimetry::new(Chromaticities::REC709, Transfer::Gamma(Decimal::new(2.4)));
    let wide = Colorimetry::new(Chromaticities::ACES_CG, Transfer::Linear);
    assert!([gamma, wide].iter().all(|color| encoded(*color).unwrap_err().kind == ErrorKind::Unsupported));
}
