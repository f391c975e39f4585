//! Orientation of the rows of a file: the one that EXIF states, and the axes of a Radiance file.

use super::picture::{Picture, Pixels};

/// The orientations of EXIF, 1 to 8; that of 1 changes nothing.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(super) struct Orientation(u8);

/// The tag of the orientation in the first directory.
const TAG: u16 = 0x0112;

impl Orientation {
    /// Rows from the top, pixels from the left.
    pub(super) const UPRIGHT: Self = Self(1);

    /// The orientation that an EXIF block states, from its TIFF header on: `None` for an upright picture, and for a
    /// block that states none or is broken.
    pub(super) fn of_exif(exif: &[u8]) -> Option<Self> {
        let is_little = match exif.get(..4)? {
            b"II*\0" => true,
            b"MM\0*" => false,
            _ => return None,
        };
        let short = |at: usize| -> Option<u16> {
            let bytes = exif.get(at..at.checked_add(2)?)?.try_into().ok()?;
            Some(if is_little { u16::from_le_bytes(bytes) } else { u16::from_be_bytes(bytes) })
        };
        let long = |at: usize| -> Option<usize> {
            let (first, second) = (usize::from(short(at)?), usize::from(short(at.checked_add(2)?)?));
            Some(if is_little { first | second << 16 } else { first << 16 | second })
        };
        let directory = long(4)?;
        let entries = usize::from(short(directory)?);
        // An entry has a tag, a type, a count and a value in four bytes.
        let mut entries = (0..entries).filter_map(|index| directory.checked_add(2 + 12 * index));
        let stated = short(entries.find(|at| short(*at) == Some(TAG))?.checked_add(8)?)?;
        Self::of_code(stated)
    }

    /// The orientation of a code of EXIF and TIFF; `None` for an upright picture.
    pub(super) fn of_code(code: u16) -> Option<Self> {
        (2..=8).contains(&code).then_some(Self(code as u8))
    }

    /// The orientation of a file whose rows follow each other along the first axis, and the pixels of a row along the
    /// second: `-Y` and `+X` for a picture whose rows begin at the top and whose pixels begin at the left. `None` for
    /// other words.
    pub(super) fn of_axes(rows: &str, pixels: &str) -> Option<Self> {
        const AXES: [(&str, &str); 8] = [
            ("-Y", "+X"),
            ("-Y", "-X"),
            ("+Y", "-X"),
            ("+Y", "+X"),
            ("+X", "-Y"),
            ("-X", "-Y"),
            ("-X", "+Y"),
            ("+X", "+Y"),
        ];
        let index = AXES.iter().position(|axes| *axes == (rows, pixels))?;
        Some(Self(index as u8 + 1))
    }

    /// The size of the upright picture.
    pub(super) fn size(self, width: u32, height: u32) -> (u32, u32) {
        if self.is_turned() { (height, width) } else { (width, height) }
    }

    pub(super) fn upright(self, picture: Picture) -> Picture {
        let [columns, rows] = [picture.width, picture.height].map(|side| side as usize);
        let (width, height) = self.size(picture.width, picture.height);
        let pixels = match &picture.pixels {
            Pixels::Half(halves) => Pixels::Half(self.turned(halves, columns, rows)),
            Pixels::Float(floats) => Pixels::Float(self.turned(floats, columns, rows)),
        };
        let Picture { stated, notes, .. } = picture;
        Picture { stated, notes, ..Picture::new(width, height, pixels) }
    }

    pub(super) fn note(self) -> String {
        format!("it is turned upright, as its EXIF orientation {} states", self.0)
    }

    /// True if rows of the file are columns of the picture.
    fn is_turned(self) -> bool {
        self.0 >= 5
    }

    fn turned<T: Copy>(self, pixels: &[T], width: usize, height: usize) -> Vec<T> {
        let mirrors_columns = matches!(self.0, 2 | 3 | 7 | 8);
        let mirrors_rows = matches!(self.0, 3 | 4 | 6 | 7);
        let (columns, rows) = if self.is_turned() { (height, width) } else { (width, height) };
        let mut upright = Vec::with_capacity(pixels.len());
        for y in 0..rows {
            for x in 0..columns {
                let (column, row) = if self.is_turned() { (y, x) } else { (x, y) };
                let column = if mirrors_columns { width - 1 - column } else { column };
                let row = if mirrors_rows { height - 1 - row } else { row };
                let at = 4 * (row * width + column);
                upright.extend_from_slice(&pixels[at..at + 4]);
            }
        }
        upright
    }
}
