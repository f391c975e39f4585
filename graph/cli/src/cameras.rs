//! Cameras for inputs of the type `Camera`: from JSON files, from what EXR files state, or that of the built-in scene.

use afterimage_graph::check::{Graph, GraphInput};
use afterimage_graph::image::Size;
use afterimage_graph::node::{BlockData, CAMERA, CameraFile, TypedKind};
use afterimage_media::{CameraMatrices, ImageFormat, Source, read_camera, read_text};
use afterimage_nodes::DemoScene;

use crate::failure::Failure;

/// The most bytes of a camera.
const MAX_BYTES: u64 = 1 << 20;

/// Reads a JSON file, or the camera that an EXR file states.
pub(crate) fn read_camera_file(source: &Source) -> Result<CameraFile, Failure> {
    let path = &source.path;
    let wrong = |why: &str| Failure::unreadable(format!("{}: this is no camera: {why}", path.display()));
    let is_exr = ImageFormat::of_name(path) == Some(ImageFormat::Exr);
    let file = if is_exr {
        let CameraMatrices { view, projection } = read_camera(source)?;
        CameraFile::still(view, projection)
    } else {
        CameraFile::from_json(read_text(path, MAX_BYTES)?.as_bytes())
            .map_err(|why| wrong(&why).hint(CameraFile::FORMAT))?
    };
    file.data(None).map_err(|why| wrong(&why))?;
    Ok(file)
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
