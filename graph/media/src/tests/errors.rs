//! Errors of the system in the user's words, and the limits of memory.

use std::io;
use std::path::Path;

use afterimage_base::color::{Chromaticities, Transfer};
use half::f16;

use crate::codec::cicp::Cicp;
use crate::codec::limits::{MAX_BYTES, check_size, filled, zeroed};
use crate::{Budget, CodecError, ErrorKind, FileError, Metadata, Picture, Pixels, catch_panic};

/// What went wrong, the class and exit status of reading, and of writing, and how the messages begin.
#[test]
fn errors_of_the_system_are_the_user_s_or_the_machine_s() {
    use ErrorKind::{Broken, Machine, Missing, Naming, Unreadable};
    use io::ErrorKind as Io;
    let table = [
        (Io::NotFound, Missing, "there is no such file", Missing, "the folder of this output does not exist"),
        (Io::PermissionDenied, Unreadable, "you may not read", Machine, "this program may not write here"),
        (Io::IsADirectory, Unreadable, "this is a folder", Naming, "the output is a folder"),
        (Io::NotADirectory, Missing, "a part of this name is a file", Naming, "a part of this name is a file"),
        (Io::InvalidFilename, Missing, "the file system refuses", Naming, "the file system refuses"),
        (Io::InvalidInput, Missing, "the file system refuses", Naming, "the file system refuses"),
        (Io::StorageFull, Machine, "reading failed", Machine, "the disk is full"),
        (Io::QuotaExceeded, Machine, "reading failed", Machine, "the disk is full"),
        (Io::ReadOnlyFilesystem, Machine, "reading failed", Machine, "this program may not write here"),
        (Io::UnexpectedEof, Broken, "the file ends too early", Machine, "writing failed"),
        (Io::TimedOut, Machine, "reading failed", Machine, "writing failed"),
    ];
    let path = Path::new("a/file");
    for (kind, reading, read_message, writing, write_message) in table {
        let error = io::Error::from(kind);
        let checks = [
            (FileError::reading(path, &error), reading, read_message),
            (FileError::writing(path, &error), writing, write_message),
        ];
        for (found, class, message) in checks {
            assert_eq!((found.kind, found.path.as_path()), (class, path), "{kind:?}");
            assert!(found.message.starts_with(message), "{kind:?}: {}", found.message);
            assert_eq!(found.exit(), if class == Machine { 2 } else { 1 }, "{kind:?}");
            let shown = format!("a/file: {}", found.message);
            let hint = found.hint.as_ref().map_or(String::new(), |hint| format!("\n  hint: {hint}"));
            assert_eq!(found.to_string(), shown + &hint);
        }
    }
    #[cfg(unix)]
    for error in [FileError::reading, FileError::writing].map(|of| of(path, &io::Error::from_raw_os_error(libc::ELOOP)))
    {
        assert_eq!(error.message, "its links lead in a circle");
    }
}

#[test]
fn errors_of_a_decoder_s_reader_are_about_the_file() {
    use io::ErrorKind as Io;
    let table = [
        (Io::UnexpectedEof, ErrorKind::Broken, "the file ends too early"),
        (Io::FileTooLarge, ErrorKind::Broken, "the file is damaged: its header is too long"),
        (Io::InvalidInput, ErrorKind::Broken, "the file is damaged: it points outside itself"),
        (Io::InvalidData, ErrorKind::Broken, "the file is damaged: it points outside itself"),
        (Io::TimedOut, ErrorKind::Machine, "reading failed: timed out"),
    ];
    for (kind, class, message) in table {
        let error = CodecError::reading(&io::Error::from(kind));
        assert_eq!((error.kind, error.message.as_str()), (class, message));
    }
    let broken = CodecError::broken("of ours");
    assert_eq!(broken.to_string(), "the file is damaged: of ours\n  hint: copy or render it again");
    assert_eq!(CodecError::new(ErrorKind::Naming, "alone").to_string(), "alone");
}

#[test]
fn memory_is_counted_to_the_byte() {
    // Four channels: 25 pixels of 4 × 1 bytes.
    assert_eq!(Budget(100).check((5, 5), 1, 0), Ok(()));
    assert_eq!(Budget(207).check((5, 5), 2, 7), Ok(()));
    let error = Budget(100).check((5, 5), 1, 1).unwrap_err();
    assert_eq!(error.message, "the image is too large: 5×5 pixels need 101 bytes");
    assert_eq!(error.hint.as_deref(), Some("decoding may take 100 bytes; `--memory SIZE` changes the limit"));
    assert!(Budget(u64::MAX - 1).check((5, 5), 1, u64::MAX).is_err(), "sums do not wrap");
    for (bytes, rows) in [(4, 4096), (2, 8192), (1, 16384)] {
        assert_eq!(65536 * rows * 4 * bytes, MAX_BYTES);
        assert_eq!(check_size((65536, rows), bytes), Ok(()));
        let error = check_size((65536, rows + 1), bytes).unwrap_err();
        assert_eq!(error.hint.as_deref(), Some("a picture may take at most 4 GiB in memory"));
    }
    for error in [filled(1 << 58, 1_u8).unwrap_err(), zeroed::<u8>(1 << 58).unwrap_err()] {
        assert_eq!(error.kind, ErrorKind::TooLarge);
        assert_eq!(error.message, "the image is too large: this machine has no 274877906944 MiB free");
    }
    assert_eq!((filled(3, 7_u16), zeroed::<u16>(2)), (Ok(vec![7; 3]), Ok(vec![0; 2])));
}

#[test]
fn a_panic_has_its_words() {
    assert_eq!(catch_panic(|| -> u8 { panic!("plain") }), Err("plain".to_owned()));
    assert_eq!(catch_panic(|| -> u8 { panic!("of {}", 3) }), Err("of 3".to_owned()));
    assert_eq!(catch_panic(|| -> u8 { std::panic::panic_any(7) }), Err("no reason is given".to_owned()));
    assert_eq!(catch_panic(|| catch_panic(|| -> u8 { panic!("inner") })), Ok(Err("inner".to_owned())));
}

/// ITU-T H.273, tables 2 and 3.
#[test]
fn code_points_mean_what_the_standard_says() {
    let primaries =
        [(1, Some(Chromaticities::REC709)), (9, Some(Chromaticities::REC2020)), (12, Some(Chromaticities::DISPLAY_P3))];
    for video in [1, 6, 14, 15] {
        let code = Cicp { primaries: 9, transfer: video };
        assert_eq!(code.meaning(), Some((Chromaticities::REC2020, Transfer::Srgb)), "shown as browsers do");
    }
    let transfers = [
        (4, Some(Transfer::Gamma(2.2.into()))),
        (5, Some(Transfer::Gamma(2.8.into()))),
        (8, Some(Transfer::Linear)),
        (13, Some(Transfer::Srgb)),
        (16, Some(Transfer::Pq)),
        (18, Some(Transfer::Hlg)),
    ];
    for (primary, color) in primaries.into_iter().chain([0, 2, 4, 8, 10, 13].map(|code| (code, None))) {
        for (code, transfer) in transfers.into_iter().chain([0, 2, 7, 11, 17, 19].map(|code| (code, None))) {
            let found = Cicp { primaries: primary, transfer: code };
            assert_eq!(found.meaning(), color.zip(transfer), "{primary} {code}");
            if let Some((color, transfer)) = color.zip(transfer) {
                assert_eq!(Cicp::of(&color, transfer), Some(found));
            }
        }
    }
    assert_eq!(Cicp::of(&Chromaticities::ACES_CG, Transfer::Srgb), None);
    assert_eq!(Cicp::of(&Chromaticities::REC709, Transfer::Gamma(2.4.into())), None);
}

#[test]
fn a_picture_has_its_numbers_in_rows() {
    let numbers: Vec<f32> = (0..24_u8).map(f32::from).collect();
    let halves = Pixels::Half(numbers.iter().map(|number| f16::from_f32(*number)).collect());
    for (pixels, bytes) in [(halves, 2), (Pixels::Float(numbers.clone()), 4)] {
        let picture = Picture::new(3, 2, pixels);
        assert_eq!(picture.pixel(2, 1), [20.0, 21.0, 22.0, 23.0]);
        assert_eq!(picture.pixel(1, 0), [4.0, 5.0, 6.0, 7.0]);
        assert_eq!((picture.pixels.len(), picture.pixels.is_empty()), (24, false));
        assert_eq!((picture.pixels.to_f32(), picture.bytes().len()), (numbers.clone(), 24 * bytes));
        let desc = picture.desc();
        assert_eq!((desc.size.width, desc.size.height), (3, 2));
        assert_eq!(desc.format.bytes() as usize, 4 * bytes);
        let window = picture.meta.image.display_window;
        assert_eq!((window.position.0, window.position.1, window.size.0, window.size.1), (0, 0, 3, 2));
    }
    assert!(Pixels::Float(Vec::new()).is_empty());
    let mut meta = Metadata::of_size(1, 1);
    meta.set_text("name", "ÿĀ");
    let written = meta.layer.other.values().next().cloned();
    assert_eq!(written, Some(exr::meta::attribute::AttributeValue::Text("ÿ?".into())), "Latin-1 ends at 255");
}
