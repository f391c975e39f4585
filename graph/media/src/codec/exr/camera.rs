//! The camera that a file states for its image.

use std::io::{Read, Seek};

use exr::meta::header::LayerAttributes;
use glam::{DMat4, DVec3, DVec4};

use super::read::{Opened, open};
use super::select::choose;
use super::unsupported;
use crate::codec::CodecError;

/// The near plane of a file that states none, in its units.
const NEAR: f64 = 0.1;
/// The far plane of an orthographic camera whose file states none.
const FAR: f64 = 1000.0;

/// The camera of an image. Matrices are lists of rows, for columns of coordinates.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct CameraMatrices {
    /// From the world to the camera, which looks along -z with y up.
    pub view: [[f32; 4]; 4],
    /// From the camera to clip space: x and y from -1 to 1 with y up. Depth is 1 at the near plane, and 0 at the far
    /// plane or, with a perspective, infinitely far away.
    pub projection: [[f32; 4]; 4],
}

/// The camera of the chosen layer's part.
pub(crate) fn camera(reader: impl Read + Seek, layer: Option<&str>) -> Result<CameraMatrices, CodecError> {
    let Opened { headers, .. } = open(reader)?;
    let part = choose(&headers, layer)?.part;
    of_attributes(&headers[part].own_attributes)
}

/// `worldToCamera` and `worldToNDC` of the OpenEXR standard: for rows of coordinates, with a camera that looks along
/// +z, and with x and y from 0 at the upper left to 1 at the lower right of the display window.
pub(crate) fn of_attributes(stated: &LayerAttributes) -> Result<CameraMatrices, CodecError> {
    let (Some(to_camera), Some(to_ndc)) = (stated.world_to_camera, stated.world_to_normalized_device) else {
        return Err(unsupported("it states no camera: `worldToCamera` or `worldToNDC` is missing")
            .hint("write the camera into a JSON file: `--input camera=FILE.json`"));
    };
    let wrong = || unsupported("its `worldToCamera` and `worldToNDC` are no camera");
    // A matrix for rows, read as columns, is the matrix for columns.
    let [to_camera, to_ndc] = [to_camera, to_ndc].map(|rows| DMat4::from_cols_array(&rows.map(f64::from)));
    let from_camera = to_camera.inverse();
    if !(from_camera.is_finite() && to_ndc.is_finite()) {
        return Err(wrong());
    }
    let to_ndc = to_ndc * from_camera;
    let depth = to_ndc.row(3);
    let is_perspective = depth.z.abs() > depth.w.abs();
    // Some renderers write cameras that look along -z: what lies in front has a positive divisor.
    let turn = DMat4::from_scale(DVec3::new(1.0, 1.0, if is_perspective && depth.z < 0.0 { 1.0 } else { -1.0 }));
    let to_ndc = to_ndc * turn;
    let divisor = if is_perspective { -to_ndc.row(3).z } else { to_ndc.row(3).w };
    let [across, down, divided] = [0, 1, 3].map(|row| to_ndc.row(row) / divisor);
    let near = stated.near_clip_plane.map_or(NEAR, f64::from);
    let far = stated.far_clip_plane.map_or(FAR, f64::from);
    let depth = match is_perspective {
        true => DVec4::new(0.0, 0.0, 0.0, near),
        false => DVec4::new(0.0, 0.0, 1.0, far) / (far - near),
    };
    let projection = [2.0 * across - divided, divided - 2.0 * down, depth, divided];
    let view = [0, 1, 2, 3].map(|row| (turn * to_camera).row(row));
    let camera = CameraMatrices { view: view.map(numbers), projection: projection.map(numbers) };
    let all = [camera.view, camera.projection];
    if all.as_flattened().as_flattened().iter().all(|number| number.is_finite()) { Ok(camera) } else { Err(wrong()) }
}

fn numbers(row: DVec4) -> [f32; 4] {
    row.as_vec4().to_array()
}
