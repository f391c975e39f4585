//! Cameras for inputs of the type `Camera`: from JSON files, from what EXR files state, or that of the built-in scene.

use std::path::Path;

use afterimage_graph::check::{Graph, GraphInput};
use afterimage_graph::image::Size;
use afterimage_graph::node::{BlockData, CAMERA, Camera, Matrix, TypedKind};
use afterimage_media::{CameraMatrices, ImageFormat, Source, read_camera, read_text};
use afterimage_nodes::DemoScene;
use serde::Deserialize;

use crate::failure::Failure;

/// The most bytes of a camera.
const MAX_BYTES: u64 = 1 << 20;

/// A file of a camera. Matrices are lists of rows; other members are ignored.
#[derive(Clone, Deserialize)]
pub(crate) struct CameraFile {
    view: Matrix,
    projection: Matrix,
    previous_view: Option<Matrix>,
    previous_projection: Option<Matrix>,
    #[serde(default)]
    jitter: [f32; 2],
    previous_jitter: Option<[f32; 2]>,
}

impl CameraFile {
    /// Reads a JSON file, or the camera that an EXR file states.
    pub(crate) fn read(source: &Source) -> Result<Self, Failure> {
        let path = &source.path;
        let is_exr = ImageFormat::of_name(path) == Some(ImageFormat::Exr);
        let file = if is_exr { Self::from(read_camera(source)?) } else { Self::read_json(path)? };
        file.data(None).map_err(|why| Failure::unreadable(format!("{}: this is no camera: {why}", path.display())))?;
        Ok(file)
    }

    fn read_json(path: &Path) -> Result<Self, Failure> {
        let wrong = |why: &dyn std::fmt::Display| {
            Failure::unreadable(format!("{}: this is no camera: {why}", path.display())).hint(
                "write `{ \"view\": [[..4 numbers..], ..4 rows..], \"projection\": [..] }`; `previous_view`, \
                 `previous_projection`, `jitter` and `previous_jitter` may follow",
            )
        };
        let text = read_text(path, MAX_BYTES)?;
        serde_json::from_str(&text).map_err(|error| wrong(&error))
    }

    /// The block. What the file does not state of the frame before is as in `before`, or as in this frame.
    pub(crate) fn data(&self, before: Option<&Self>) -> Result<BlockData, String> {
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

impl From<CameraMatrices> for CameraFile {
    fn from(CameraMatrices { view, projection }: CameraMatrices) -> Self {
        Self {
            view,
            projection,
            previous_view: None,
            previous_projection: None,
            jitter: [0.0; 2],
            previous_jitter: None,
        }
    }
}

/// The columns of a matrix from its rows.
fn columns(rows: Matrix) -> Matrix {
    std::array::from_fn(|column| rows.map(|row| row[column]))
}

/// True if an input takes a camera.
pub(crate) fn is_camera(input: &GraphInput) -> bool {
    input.block.is_some_and(|block| *block == CAMERA)
}

/// True if an input gets the camera of the built-in scene if no file gives another: the eye's, and not a light's.
pub(crate) fn is_eye(input: &GraphInput) -> bool {
    is_camera(input) && input.name == EYE
}

/// The name of the input that is the camera of the picture.
const EYE: &str = "camera";

/// The built-in scene in a graph.
pub(crate) fn scene(graph: &Graph) -> Option<DemoScene> {
    let node = graph.nodes.iter().find(|node| node.kind().name() == DemoScene::KIND)?;
    DemoScene::from_values(node.instance.values())
}

/// The camera of the built-in scene, for an image of this size.
pub(crate) fn scene_camera(scene: &DemoScene, size: Size) -> BlockData {
    scene.camera(size).data().expect("the scene's camera has finite matrices with inverses")
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
        let file: CameraFile = serde_json::from_str(TEXT).expect("it is a camera");
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
        let Ok(file) = serde_json::from_slice::<CameraFile>(text) else { return };
        if file.data(None).is_ok() {
            file.data(Some(plain)).expect("it was accepted");
            plain.data(Some(&file)).expect("it was accepted");
        }
    }

    #[test]
    fn a_camera_with_any_byte_or_number_changed_is_refused_or_one() {
        let plain: CameraFile = serde_json::from_str(TEXT).expect("it is a camera");
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

    #[test]
    fn the_camera_of_the_scene_sees_what_its_depth_says() {
        let size = Size::new(640, 360);
        let scene = DemoScene { walk: 0.3, step: 0.1, jitter: [0.5, 0.0], ..DemoScene::default() };
        let data = scene_camera(&scene, size);
        let before = scene_camera(&DemoScene { walk: 0.2, ..scene }, size);
        let near = |a: Option<Vec<f32>>, b: Option<Vec<f32>>| {
            let (a, b) = (a.expect("a member"), b.expect("a member"));
            a.iter().zip(&b).all(|(a, b)| (a - b).abs() < 1e-5)
        };
        assert!(near(data.get("previous_view"), before.get("view")));
        assert!(!near(data.get("previous_view"), data.get("view")));
        assert_eq!(data.get("jitter"), Some(vec![0.5, 0.0]));
    }
}
