//! Modules that see rows of images.

use afterimage_wgsl::{BandedModule, banded};

#[test]
fn a_read_in_the_position_of_another_read_is_rewritten_too() {
    let source = "fn twice(t: texture_2d<f32>) -> vec4f {
        return textureLoad(t, vec2i(textureLoad(t, vec2i(1, 2), 0).xy), 0);
    }";
    let (sizes, workgroups) = (&[[64, 64]][..], [1, 64, 1]);
    let module = BandedModule { entry: "compute", sizes, stored: &[], workgroups, rows: 1, first_counter: 0 };
    let text: String = banded(source, &module).expect("it can be done in bands").split_whitespace().collect();
    let wanted = "bands_load(t,vec2i(vec2i(bands_load(t,vec2i(vec2i(1,2)),0).xy)),0)";
    assert!(text.contains(wanted), "{text}");
}
