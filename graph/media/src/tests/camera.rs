//! Cameras that EXR files state, compared with where points lie in the image.

use exr::meta::header::LayerAttributes;
use glam::{DMat4, DVec3, DVec4};

use crate::codec::{CameraMatrices, of_attributes};

/// A matrix for columns of coordinates as the standard stores it.
fn stored(matrix: DMat4) -> [f32; 16] {
    matrix.to_cols_array().map(|number| number as f32)
}

fn matrix(rows: [[f32; 4]; 4]) -> DMat4 {
    DMat4::from_cols_array_2d(&rows.map(|row| row.map(f64::from))).transpose()
}

/// Attributes of a camera at a place, turned about y, whose axis z looks forward (1) or back (-1).
fn attributes(ndc_of_camera: DMat4, forward: f64) -> LayerAttributes {
    let to_camera = DMat4::from_scale(DVec3::new(1.0, 1.0, forward))
        * (DMat4::from_rotation_y(0.4) * DMat4::from_translation(DVec3::new(-2.0, -1.5, 3.0)));
    let ndc = ndc_of_camera * DMat4::from_scale(DVec3::new(1.0, 1.0, forward)) * to_camera;
    let (world_to_camera, world_to_normalized_device) = (Some(stored(to_camera)), Some(stored(ndc)));
    let (near_clip_plane, far_clip_plane) = (Some(0.5), Some(20.0));
    LayerAttributes {
        world_to_camera,
        world_to_normalized_device,
        near_clip_plane,
        far_clip_plane,
        ..LayerAttributes::default()
    }
}

/// NDC of a camera that looks along +z: (0, 0) at the upper left, and the middle of the view off the image's.
fn perspective() -> DMat4 {
    DMat4::from_cols(
        DVec4::new(0.8, 0.0, 0.0, 0.0),
        DVec4::new(0.0, -1.4, 0.0, 0.0),
        DVec4::new(0.45, 0.55, 0.0, 1.0),
        DVec4::ZERO,
    )
}

fn orthographic() -> DMat4 {
    DMat4::from_cols(
        DVec4::new(0.1, 0.0, 0.0, 0.0),
        DVec4::new(0.0, -0.2, 0.0, 0.0),
        DVec4::ZERO,
        DVec4::new(0.5, 0.5, 0.0, 1.0),
    )
}

/// Points of the world lie where the file states, in front of a camera that looks along -z.
fn check(stated: &LayerAttributes, depth_at: impl Fn(f64) -> f64) {
    let CameraMatrices { view, projection } = of_attributes(stated).unwrap_or_else(|error| panic!("{error}"));
    let to_ndc = stated.world_to_normalized_device.expect("the test states it").map(f64::from);
    for place in [[2.0, 1.5, 2.0], [4.0, 1.0, 6.0], [-1.0, 2.5, 9.0]] {
        let place = DVec3::from(place).extend(1.0);
        // A row of coordinates times the stored matrix.
        let [x, y, _, w] =
            [0, 1, 2, 3].map(|column| (0..4).map(|row| place[row] * to_ndc[4 * row + column]).sum::<f64>());
        let seen = matrix(view) * place;
        let clip = matrix(projection) * seen;
        assert!(clip.w > 0.0, "{place} lies in front");
        let found = [clip.x / clip.w / 2.0 + 0.5, 0.5 - clip.y / clip.w / 2.0, clip.z / clip.w];
        let expected = [x / w, y / w, depth_at(-seen.z)];
        let is_near = found.iter().zip(expected).all(|(found, expected)| (found - expected).abs() < 1e-5);
        assert!(is_near && seen.z < 0.0, "{place}: {found:?} is not {expected:?}");
    }
}

#[test]
fn points_lie_where_the_file_says() {
    for forward in [1.0, -1.0] {
        check(&attributes(perspective(), forward), |distance| 0.5 / distance);
    }
    check(&attributes(perspective() * 7.0, 1.0), |distance| 0.5 / distance);
    check(&attributes(orthographic(), 1.0), |distance| (20.0 - distance) / 19.5);
}

/// 0.1 and, without a perspective, 1000.
#[test]
fn planes_that_are_not_stated_have_their_defaults() {
    let bare = |stated: LayerAttributes| LayerAttributes { near_clip_plane: None, far_clip_plane: None, ..stated };
    check(&bare(attributes(perspective(), 1.0)), |distance| 0.1 / distance);
    check(&bare(attributes(orthographic(), 1.0)), |distance| (1000.0 - distance) / 999.9);
    let wrong = LayerAttributes { world_to_camera: None, ..attributes(perspective(), 1.0) };
    let error = of_attributes(&wrong).unwrap_err();
    assert!(error.message.contains("`worldToCamera` or `worldToNDC` is missing"), "{error}");
    assert!(error.hint.unwrap().contains("`--input camera=FILE.json`"));
}

#[test]
fn files_that_state_no_camera_are_refused() {
    let whole = attributes(perspective(), 1.0);
    let cases = [
        LayerAttributes { world_to_camera: None, ..whole.clone() },
        LayerAttributes { world_to_normalized_device: None, ..whole.clone() },
        LayerAttributes { world_to_camera: Some([0.0; 16]), ..whole.clone() },
        LayerAttributes { world_to_normalized_device: Some([0.0; 16]), ..whole.clone() },
        LayerAttributes { world_to_normalized_device: Some([f32::NAN; 16]), ..whole.clone() },
        LayerAttributes { near_clip_plane: Some(f32::INFINITY), ..whole },
    ];
    for case in cases {
        assert!(of_attributes(&case).is_err(), "{case:?}");
    }
}
