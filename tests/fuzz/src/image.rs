//! Images: refused with words, or whole.

use std::io::Cursor;

use afterimage_media::Budget;
use afterimage_media::codec::decode;

/// Memory that decoding may take; the images of the corpus need far less.
const BUDGET: Budget = Budget(64 << 20);

/// True if the bytes are an image.
pub(crate) fn survives(bytes: &[u8]) -> bool {
    match decode(Cursor::new(bytes), None, BUDGET) {
        Ok(picture) => {
            let pixels = picture.width as usize * picture.height as usize;
            assert!(pixels > 0);
            assert_eq!(picture.pixels.len(), pixels * 4);
            assert!((pixels * 4 * picture.pixels.bytes_per_channel()) as u64 <= BUDGET.0);
            true
        }
        Err(error) => {
            assert!(!error.message.is_empty());
            false
        }
    }
}
