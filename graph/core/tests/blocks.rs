//! The numbers of host blocks, and facts: where they lie, and what is refused.

use afterimage_graph::check::Fact;
use afterimage_graph::node::{BlockData, BlockField, CAMERA, Camera, FieldType, HostBlock};

/// A block with a member of each type, after members that end at another alignment.
static MIXED: HostBlock = HostBlock {
    name: "Mixed",
    doc: "One member of each type.",
    fields: &[
        field("one", FieldType::Float, &[1.5]),
        field("two", FieldType::Vector2, &[2.0, 2.5]),
        field("three", FieldType::Vector3, &[3.0, 3.25, 3.5]),
        field("last", FieldType::Float, &[4.0]),
        field("half", FieldType::Float, &[5.0]),
        field("four", FieldType::Vector4, &[6.0, 6.25, 6.5, 6.75]),
        field("matrix", FieldType::Matrix4, &[7.0; 16]),
        field("end", FieldType::Vector2, &[8.0, 8.5]),
    ],
};

/// Where WGSL puts the members (sections 14.4.1 and 14.4.2 of the specification).
const OFFSETS: [usize; 8] = [0, 8, 16, 28, 32, 48, 64, 128];

const fn field(name: &'static str, ty: FieldType, default: &'static [f32]) -> BlockField {
    BlockField { name, ty, doc: "Numbers.", default }
}

/// The numbers of a member, read from the bytes.
fn at(data: &BlockData, offset: usize, count: usize) -> Vec<f32> {
    let bytes = &data.bytes()[offset..offset + 4 * count];
    bytes.chunks(4).map(|word| f32::from_le_bytes(word.try_into().expect("four bytes"))).collect()
}

#[test]
fn members_lie_where_a_shader_reads_them() {
    let data = BlockData::new(&MIXED);
    assert_eq!((MIXED.bytes(), data.bytes().len()), (144, 144));
    assert!(MIXED.layout().map(|(offset, _)| offset).eq(OFFSETS));
    for (field, offset) in MIXED.fields.iter().zip(OFFSETS) {
        assert_eq!(at(&data, offset, field.default.len()), field.default, "{}", field.name);
    }
}

#[test]
fn a_member_that_is_set_changes_and_no_other() {
    for (number, (field, offset)) in MIXED.fields.iter().zip(OFFSETS).enumerate() {
        let mut data = BlockData::new(&MIXED);
        let numbers: Vec<f32> = (0..field.ty.numbers()).map(|at| -0.5 - at as f32 - 20.0 * number as f32).collect();
        data.set(field.name, &numbers).expect("they are finite");
        assert_eq!(at(&data, offset, numbers.len()), numbers, "{}", field.name);
        for other in MIXED.fields {
            let expected = if other.name == field.name { numbers.as_slice() } else { other.default };
            assert_eq!(data.get(other.name).as_deref(), Some(expected), "{} after {}", other.name, field.name);
        }
    }
    assert_eq!(BlockData::new(&MIXED).get("none"), None);
}

#[test]
fn what_a_member_does_not_take_changes_nothing() {
    let mut data = BlockData::new(&MIXED);
    for (name, numbers, parts) in [
        ("on", vec![1.0], ["`Mixed` has no member `on`", "one, two, three, last, half, four, matrix, end"]),
        ("three", vec![1.0; 4], ["`Mixed.three` takes 3 numbers", "not 4"]),
        ("four", vec![1.0; 3], ["`Mixed.four` takes 4 numbers", "not 3"]),
        ("two", vec![0.0, f32::NAN], ["`Mixed.two` takes finite numbers", "not NaN"]),
        ("matrix", [vec![0.0; 15], vec![f32::INFINITY]].concat(), ["`Mixed.matrix` takes finite numbers", "not inf"]),
    ] {
        let error = data.set(name, &numbers).expect_err(name);
        assert!(parts.iter().all(|part| error.contains(part)), "{error}");
        assert_eq!(data, BlockData::new(&MIXED), "{name}");
    }
}

#[test]
fn a_camera_is_a_block_with_the_inverses_of_its_matrices() {
    let view = [[0.0, 1.0, 0.0, 0.0], [-1.0, 0.0, 0.0, 0.0], [0.0, 0.0, 1.0, 0.0], [3.0, -2.0, 5.0, 1.0]];
    let projection = [[2.0, 0.0, 0.0, 0.0], [0.0, 4.0, 0.0, 0.0], [0.0, 0.0, 0.0, -1.0], [0.0, 0.0, 0.5, 0.0]];
    let data = Camera::still(view, projection).data().expect("its matrices have inverses");
    assert_eq!(data.bytes().len(), CAMERA.bytes());
    assert_eq!(data.get("view").as_deref(), Some(view.as_flattened()));
    assert_eq!(data.get("projection").as_deref(), Some(projection.as_flattened()));
    let singular = [[1.0, 0.0, 0.0, 0.0]; 4];
    assert!(Camera::still(singular, projection).data().is_err());
    assert!(Camera::still(view, singular).data().is_err());
}

#[test]
fn a_camera_is_written_into_the_block_of_an_earlier_frame() {
    let scaled = |by: f32| [[by, 0.0, 0.0, 0.0], [0.0, by, 0.0, 0.0], [0.0, 0.0, by, 0.0], [0.0, 0.0, 0.0, 1.0]];
    let earlier = Camera { jitter: [0.25, -0.5], ..Camera::still(scaled(2.0), scaled(3.0)) };
    let later = Camera {
        previous_view: earlier.view,
        previous_jitter: earlier.jitter,
        ..Camera::still(scaled(4.0), scaled(5.0))
    };
    let mut data = earlier.data().expect("its matrices have inverses");
    later.write(&mut data).expect("its matrices have inverses");
    assert_eq!(data, later.data().expect("as above"));
    assert_ne!(data, earlier.data().expect("as above"));
    assert!(later.write(&mut BlockData::new(&MIXED)).is_err_and(|error| error.contains("`Mixed`")));
    assert!(Camera::still(scaled(0.0), scaled(1.0)).write(&mut data).is_err_and(|error| error.contains("Camera.view")));
}

#[test]
fn facts_are_shown_as_files_write_them() {
    let shown = [Fact::from(true), Fact::from(false), Fact::from(0.5), Fact::from(2.0), Fact::from(-1e-7)];
    assert_eq!(shown.map(|fact| fact.to_string()), ["true", "false", "0.5", "2.0", "-1e-7"]);
}

#[test]
fn a_transposed_matrix_of_a_camera_is_named() {
    let view = [[1.0, 0.0, 0.0, 0.0], [0.0, 0.8, 0.6, 0.0], [0.0, -0.6, 0.8, 0.0], [0.5, -1.0, -3.0, 1.0]];
    let [near, wide] = [-0.101, 1.2];
    let perspective = [[wide, 0.0, 0.0, 0.0], [0.0, 2.1, 0.0, 0.0], [0.1, 0.2, -1.01, -1.0], [0.0, 0.0, near, 0.0]];
    let reversed = [[wide, 0.0, 0.0, 0.0], [0.0, 2.1, 0.0, 0.0], [0.0, 0.0, 0.0, -1.0], [0.0, 0.0, 0.1, 0.0]];
    let orthographic = [[0.1, 0.0, 0.0, 0.0], [0.0, 0.2, 0.0, 0.0], [0.0, 0.0, -0.01, 0.0], [0.3, 0.1, -0.001, 1.0]];
    let transposed =
        |matrix: [[f32; 4]; 4]| [0, 1, 2, 3].map(|row| [0, 1, 2, 3].map(|column: usize| matrix[column][row]));
    for projection in [perspective, reversed, orthographic] {
        assert!(Camera::still(view, projection).data().is_ok());
        let error = Camera::still(view, transposed(projection)).data().unwrap_err();
        assert!(error.starts_with("`Camera.projection` is transposed"), "{error}");
        let error = Camera::still(transposed(view), projection).data().unwrap_err();
        assert!(error.starts_with("`Camera.view` is transposed: its last row is 0.5 -1 -3 1"), "{error}");
        let earlier = Camera { previous_view: transposed(view), ..Camera::still(view, projection) };
        assert!(earlier.data().unwrap_err().starts_with("`Camera.previous_view` is transposed"));
        // Rows of a projection are no view.
        let error = Camera::still(perspective, projection).data().unwrap_err();
        assert!(error.starts_with("`Camera.view` is no view"), "{error}");
    }
}
