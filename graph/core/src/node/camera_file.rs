//! Files of cameras, as JSON.

use serde::Deserialize;

use super::block::BlockData;
use super::camera::{Camera, Matrix};

/// A file of a camera. Matrices are lists of rows; other members are ignored.
#[derive(Clone, Deserialize)]
pub struct CameraFile {
    view: Matrix,
    projection: Matrix,
    previous_view: Option<Matrix>,
    previous_projection: Option<Matrix>,
    #[serde(default)]
    jitter: [f32; 2],
    previous_jitter: Option<[f32; 2]>,
}

impl CameraFile {
    /// The format, for people.
    pub const FORMAT: &str = "write `{ \"view\": [[..4 numbers..], ..4 rows..], \"projection\": [..] }`; \
                              `previous_view`, `previous_projection`, `jitter` and `previous_jitter` may follow";

    /// Reads JSON.
    ///
    /// # Errors
    /// The text is no JSON, or has no matrices.
    pub fn from_json(text: &[u8]) -> Result<Self, String> {
        serde_json::from_slice(text).map_err(|error| error.to_string())
    }

    /// A camera by the rows of its matrices alone.
    pub fn still(view: Matrix, projection: Matrix) -> Self {
        let jitter = [0.0; 2];
        Self { view, projection, previous_view: None, previous_projection: None, jitter, previous_jitter: None }
    }

    /// The block. What the file does not state of the frame before is as in `before`, or as in this frame.
    ///
    /// # Errors
    /// A matrix has no inverse, or numbers that are not finite.
    pub fn data(&self, before: Option<&Self>) -> Result<BlockData, String> {
        let before = before.unwrap_or(self);
        let camera = Camera {
            view: columns(self.view),
            projection: columns(self.projection),
            previous_view: columns(self.previous_view.unwrap_or(before.view)),
            previous_projection: columns(self.previous_projection.unwrap_or(before.projection)),
            jitter: self.jitter,
            previous_jitter: self.previous_jitter.unwrap_or(before.jitter),
        };
        camera.data()
    }
}

/// The columns of a matrix from its rows.
fn columns(rows: Matrix) -> Matrix {
    std::array::from_fn(|column| rows.map(|row| row[column]))
}

#[cfg(test)]
mod tests {
    use super::*;

    const TEXT: &str = r#"{
        "view": [[1, 0, 0, 5], [0, 1, 0, 6], [0, 0, 1, 7], [0, 0, 0, 1]],
        "projection": [[2, 0, 0, 0], [0, 3, 0, 0], [0, 0, 0, 0.1], [0, 0, -1, 0]],
        "jitter": [0.25, -0.5], "lens_mm": 35
    }"#;

    #[test]
    fn rows_become_columns_and_the_frame_before_is_the_file_before() {
        let file: CameraFile = CameraFile::from_json(TEXT.as_bytes()).expect("it is a camera");
        let data = file.data(None).expect("its matrices have inverses");
        assert_eq!(data.get("view").expect("a member")[12..], [5.0, 6.0, 7.0, 1.0]);
        assert_eq!(data.get("previous_view"), data.get("view"));
        assert_eq!(data.get("projection").expect("a member")[11], -1.0);
        assert_eq!(data.get("previous_jitter"), Some(vec![0.25, -0.5]));
        let mut before = file.clone();
        before.view[0][3] = 4.0;
        before.jitter = [0.0, 0.125];
        let data = file.data(Some(&before)).expect("its matrices have inverses");
        assert_eq!(data.get("previous_view").expect("a member")[12], 4.0);
        assert_eq!(data.get("jitter"), Some(vec![0.25, -0.5]));
        assert_eq!(data.get("previous_jitter"), Some(vec![0.0, 0.125]));
    }

    /// Whatever stands in a file, it is refused, or it is a camera beside any other.
    fn examine(text: &[u8], plain: &CameraFile) {
        let Ok(file) = CameraFile::from_json(text) else { return };
        if file.data(None).is_ok() {
            file.data(Some(plain)).expect("it was accepted");
            plain.data(Some(&file)).expect("it was accepted");
        }
    }

    #[test]
    fn a_camera_with_any_byte_or_number_changed_is_refused_or_one() {
        let plain: CameraFile = CameraFile::from_json(TEXT.as_bytes()).expect("it is a camera");
        let mut seed = 1_u32;
        for at in 0..TEXT.len() {
            for _ in 0..8 {
                seed = seed.wrapping_mul(1_664_525).wrapping_add(1_013_904_223);
                let mut text = TEXT.as_bytes().to_vec();
                text[at] = (seed >> 24) as u8;
                examine(&text, &plain);
            }
        }
        for (at, digit) in TEXT.match_indices(|c: char| c.is_ascii_digit()) {
            for number in ["1e39", "-1e38", "1e-46", "1e999", "null", "[]", "4294967296"] {
                examine([&TEXT[..at], number, &TEXT[at + digit.len()..]].concat().as_bytes(), &plain);
            }
        }
    }
}
