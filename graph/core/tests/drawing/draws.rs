//! Ranges and blends of drawing passes: what is said of those that do not fit.

use afterimage_graph::node::{
    Arg, Blend, BufferLife, DrawPass, DrawRange, IndirectDraws, Recorder, Subresource, VertexFormat, WriteMask,
};

use super::{CLEAR, SHADER, desc, draw, image, recorded, said};

const FORMATS: &[VertexFormat] = &[VertexFormat::Float32x3, VertexFormat::Uint32];

/// A draw of six vertices of 16 bytes, which are also three instances, by nine indices of which the third triangle is
/// the farthest.
fn indexed<'r, 'a>(pass: &'r mut Recorder<'a>) -> DrawPass<'r, 'a> {
    let indices = [0_u32, 1, 2, 3, 4, 5, 6, 7, 8].into_iter().flat_map(u32::to_le_bytes).collect::<Vec<u8>>();
    let indices = pass.constant_buffer("indices", indices);
    plain(pass).indices(indices)
}

fn plain<'r, 'a>(pass: &'r mut Recorder<'a>) -> DrawPass<'r, 'a> {
    let vertices = pass.add_buffer("vertices", 6 * 16, BufferLife::Frame);
    let color = image(pass, "color", desc());
    pass.draw(&SHADER, "corner").fragment("plain").color(color, CLEAR).vertices(vertices, FORMATS)
}

fn range(first: u32, count: u32) -> DrawRange {
    DrawRange { first, ..DrawRange::new(count, 1) }
}

#[test]
fn ranges_are_within_the_buffers() {
    let one = DrawRange::new(3, 1);
    let cases: Vec<(String, &str)> = vec![
        (said(|pass| plain(pass).record_ranges([range(0, 3), range(3, 3)])), ""),
        (
            said(|pass| plain(pass).record_ranges([range(0, 3), range(4, 3)])),
            "the drawing pass `corner` reads 112 bytes of the buffer `canvas.vertices`, which has 96",
        ),
        (said(|pass| plain(pass).record_ranges([])), "draws no range: use `clear`"),
        (said(|pass| plain(pass).record_ranges([one, range(0, 0)])), "draws 0 vertices of 1 instances"),
        (
            said(|pass| plain(pass).record_ranges([DrawRange { base_vertex: 1, ..one }])),
            "has a base vertex of 1, but no indices",
        ),
        (said(|pass| indexed(pass).record_ranges([range(0, 3), range(3, 3)])), ""),
        (
            said(|pass| indexed(pass).record_ranges([range(6, 3)])),
            "reads 144 bytes of the buffer `canvas.vertices`, which has 96",
        ),
        (said(|pass| indexed(pass).record_ranges([DrawRange { base_vertex: -3, ..range(6, 3) }])), ""),
        (said(|pass| indexed(pass).record_ranges([DrawRange { base_vertex: -1, ..one }])), "draws the vertex -1"),
        (
            said(|pass| indexed(pass).record_ranges([DrawRange { base_vertex: -9, ..range(7, 3) }])),
            "reads 40 bytes of the buffer `canvas.indices`, which has 36",
        ),
        (
            said(|pass| draw(pass, desc()).record_ranges([range(u32::MAX, 3)])),
            "draws up to the vertex 4294967298 and the instance 1",
        ),
    ];
    for (said, wanted) in cases {
        assert!(said.contains(wanted) && wanted.is_empty() == said.is_empty(), "{said:?} is not {wanted:?}");
    }
    let instanced = |first_instance, instances| {
        said(move |pass| {
            let moves = pass.add_buffer("moves", 3 * 16, BufferLife::Frame);
            let color = image(pass, "color", desc());
            let draw = pass.draw(&SHADER, "corner").fragment("plain").color(color, CLEAR).instances(moves, FORMATS);
            draw.record_ranges([DrawRange { first_instance, ..DrawRange::new(3, instances) }]);
        })
    };
    assert_eq!(instanced(1, 2), "");
    let wanted = "reads 64 bytes of the buffer `canvas.moves`, which has 48";
    assert!(instanced(2, 2).contains(wanted), "{:?} is not {wanted:?}", instanced(2, 2));
}

#[test]
fn ranges_in_a_buffer_are_in_it_and_written_before() {
    let indirect = |offset: u64, ranges: u32, life: BufferLife, has_indices: bool| {
        said(move |pass| {
            let buffer = pass.add_buffer("ranges", 48, life);
            let draw = if has_indices { indexed(pass) } else { plain(pass) };
            draw.record_indirect(IndirectDraws { buffer, offset, ranges });
        })
    };
    let kept = BufferLife::Persistent;
    let cases: Vec<(String, &str)> = vec![
        (indirect(0, 3, kept.clone(), false), ""),
        (indirect(8, 2, kept.clone(), true), ""),
        (indirect(12, 2, kept.clone(), true), "reads 52 bytes of the buffer `canvas.ranges`, which has 48"),
        (indirect(4, 3, kept.clone(), false), "reads 52 bytes of the buffer `canvas.ranges`, which has 48"),
        (
            indirect(6, 1, kept.clone(), false),
            "reads ranges from byte 6 of the buffer `canvas.ranges`, which is not a multiple of 4",
        ),
        (indirect(0, 0, kept, false), "draws no range: use `clear`"),
        (indirect(u64::MAX - 3, 1, BufferLife::Zeroed, false), "of the buffer `canvas.ranges`, which has 48"),
        (
            indirect(0, 1, BufferLife::Frame, false),
            "reads ranges of the buffer `canvas.ranges`, but no pass before has written it",
        ),
    ];
    for (said, wanted) in cases {
        assert!(said.contains(wanted) && wanted.is_empty() == said.is_empty(), "{said:?} is not {wanted:?}");
    }
}

#[test]
fn a_blend_belongs_to_the_attachment_before_it() {
    let message = "the drawing pass `alone` has no attachment for color yet";
    assert_eq!(said(|pass| pass.draw(&SHADER, "alone").fragment("plain").blend(Blend::ADD).record(3, 1)), message);
    assert_eq!(
        said(|pass| pass.draw(&SHADER, "alone").fragment("plain").writes(WriteMask::COLOR).record(3, 1)),
        message
    );
}

#[test]
fn a_draw_reads_the_image_or_the_level_that_it_is_given() {
    let described = recorded(|pass| {
        let (whole, part) = (image(pass, "whole", desc()), image(pass, "part", desc().with_levels(3)));
        for image in [Subresource::from(whole), part.level(0)] {
            pass.clear("first").color(image, CLEAR).record();
        }
        pass.clear("second").color(part.level(2), CLEAR).record();
        for (label, part) in [("of_whole", None), ("of_part", Some(part.level(2)))] {
            let color = image(pass, label, desc());
            let draw = pass.draw(&SHADER, "alone").fragment("see").label(label).color(color, CLEAR);
            match part {
                None => draw.image("seen", whole).record(3, 1),
                Some(part) => draw.level("seen", part).record(3, 1),
            }
        }
    });
    let described = described.unwrap_or_else(|error| panic!("{error}"));
    let seen = |label: &str| {
        let pass = described.passes.iter().find(|pass| pass.label == label).expect("it is recorded");
        pass.kernels.iter().flat_map(|kernel| &kernel.args).find(|arg| arg.name == "seen").expect("it reads it").value
    };
    let Arg::Texture(whole) = seen("of_whole") else { panic!("{:?} is no image", seen("of_whole")) };
    let Arg::Level(part) = seen("of_part") else { panic!("{:?} is no level", seen("of_part")) };
    assert!(part.image != whole && (part.level, part.layer) == (2, 0), "{part:?}");
}
