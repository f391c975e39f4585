//! The host block of cameras.

use glam::DMat4;

use super::block::{BlockData, BlockField, FieldType, HostBlock};

const IDENTITY: &[f32] = &[1.0, 0.0, 0.0, 0.0, 0.0, 1.0, 0.0, 0.0, 0.0, 0.0, 1.0, 0.0, 0.0, 0.0, 0.0, 1.0];

/// A matrix whose columns are these, as `glam`'s `to_cols_array_2d` gives them.
pub type Matrix = [[f32; 4]; 4];

/// The block of a camera, of the host's eye or of a light. Its struct and the functions that read it are in the shader
/// library's `camera`.
pub static CAMERA: HostBlock = HostBlock {
    name: "Camera",
    doc: "A camera: where it stands, how it projects, and where it stood in the frame before.",
    fields: &[
        matrix("view", "From the world to the camera, which looks along -z with y upwards."),
        matrix("projection", "From the camera to clip space, without jitter; depth from 0 to 1, in either direction."),
        matrix("inverse_view", "From the camera to the world."),
        matrix("inverse_projection", "From clip space to the camera."),
        matrix("previous_view", "`view` of the frame before."),
        matrix("previous_projection", "`projection` of the frame before."),
        pair("jitter", "How far this frame's samples lie from the centers of pixels, in pixels, y downwards."),
        pair("previous_jitter", "`jitter` of the frame before."),
    ],
};

const fn matrix(name: &'static str, doc: &'static str) -> BlockField {
    BlockField { name, ty: FieldType::Matrix4, doc, default: IDENTITY }
}

const fn pair(name: &'static str, doc: &'static str) -> BlockField {
    BlockField { name, ty: FieldType::Vector2, doc, default: &[0.0; 2] }
}

/// A camera of the host, for inputs of the type `Camera`.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Camera {
    /// From the world to the camera, which looks along -z with y upwards.
    pub view: Matrix,
    /// From the camera to clip space, without jitter. Depth is from 0 to 1, with the near plane at either end; the far
    /// plane may be infinitely far. Perspective or orthographic.
    pub projection: Matrix,
    /// `view` of the frame before; the same as `view` in a first frame.
    pub previous_view: Matrix,
    /// `projection` of the frame before.
    pub previous_projection: Matrix,
    /// Offset of this frame's samples from the centers of pixels, in pixels, y downwards.
    pub jitter: [f32; 2],
    /// `jitter` of the frame before.
    pub previous_jitter: [f32; 2],
}

impl Camera {
    /// A camera that did not move, without jitter.
    pub const fn still(view: Matrix, projection: Matrix) -> Self {
        let none = [0.0; 2];
        Self {
            view,
            projection,
            previous_view: view,
            previous_projection: projection,
            jitter: none,
            previous_jitter: none,
        }
    }

    /// The block.
    ///
    /// # Errors
    /// A number that is not finite, a matrix that is transposed, or one without an inverse: a sentence.
    pub fn data(&self) -> Result<BlockData, String> {
        let mut data = BlockData::new(&CAMERA);
        self.write(&mut data)?;
        Ok(data)
    }

    /// Writes the camera into a block of an earlier frame, which allocates nothing.
    ///
    /// # Errors
    /// As [`data`](Self::data), also if it is no block of a camera. Members before the wrong one are written.
    pub fn write(&self, data: &mut BlockData) -> Result<(), String> {
        let matrices = [
            ("view", self.view),
            ("projection", self.projection),
            ("previous_view", self.previous_view),
            ("previous_projection", self.previous_projection),
        ];
        for (name, matrix) in &matrices {
            check_columns(name, matrix)?;
            data.set(name, matrix.as_flattened())?;
        }
        for (name, matrix) in [("inverse_view", self.view), ("inverse_projection", self.projection)] {
            let inverse = inverse(&matrix);
            let set = data.set(name, inverse.as_flattened());
            set.map_err(|_| format!("`Camera.{}` has no inverse", name.trim_start_matches("inverse_")))?;
        }
        data.set("jitter", &self.jitter)?;
        data.set("previous_jitter", &self.previous_jitter)
    }
}

/// A view has the last row 0 0 0 1; so has an orthographic projection, and a perspective one 0 0 -1 0. A matrix that
/// has this as its last column is transposed.
fn check_columns(name: &str, matrix: &Matrix) -> Result<(), String> {
    let is_view = name.ends_with("view");
    let row @ [a, b, c, d] = matrix.map(|column| column[3]);
    if is_last_row(row, is_view) || !row.iter().all(|number| number.is_finite()) {
        return Ok(());
    }
    let wanted = if is_view { "0 0 0 1" } else { "0 0 -1 0 or 0 0 0 1" };
    if is_last_row(matrix[3], is_view) {
        return Err(format!(
            "`Camera.{name}` is transposed: its last row is {a} {b} {c} {d}, and its last column is what the last row \
             must be, {wanted}"
        ));
    }
    match is_view && [a, b, c] != [0.0; 3] {
        true => Err(format!("`Camera.{name}` is no view: its last row is {a} {b} {c} {d}, not {wanted}")),
        false => Ok(()),
    }
}

/// Returns whether these numbers are the last row of a view, or else of a projection.
fn is_last_row(row: [f32; 4], is_view: bool) -> bool {
    let is = |wanted: [f32; 4]| row.iter().zip(wanted).all(|(is, wanted)| (is - wanted).abs() < 1e-3);
    is([0.0, 0.0, 0.0, 1.0]) || !is_view && is([0.0, 0.0, -1.0, 0.0])
}

fn inverse(matrix: &Matrix) -> Matrix {
    let wide = matrix.map(|column| column.map(f64::from));
    DMat4::from_cols_array_2d(&wide).inverse().to_cols_array_2d().map(|column| column.map(|number| number as f32))
}
