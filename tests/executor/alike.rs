//! Passes whose shaders are alike and whose images are not, and shaders of strangers.

use afterimage::offline::Session;
use afterimage_gpu::{FrameKind, FrameStep, InputImage, Texels, input_image};
use afterimage_graph::check::Facts;
use afterimage_graph::image::Size;
use afterimage_graph::node::folder_kind_of;
use afterimage_plan::Options;

use super::without_features;
use crate::support::gpu::{Picture, Run, graph, graph_with};

/// Where the device cannot filter 32-bit floats, the layout of a pass depends on what it reads. The text of a shader
/// that filters nothing does not.
#[test]
#[cfg_attr(no_gpu, ignore = "AFTERIMAGE_NO_GPU is set")]
fn equal_shaders_of_images_that_are_sampled_in_different_ways_have_pipelines_of_their_own() {
    let gpu = without_features();
    let text = r#"Pipeline(
        inputs: { "in": Color }, nodes: { "lit": Exposure(source: "in", stops: 1.0) }, outputs: { "lit": "lit" },
    )"#;
    let mut session = Session::new(&gpu, graph(text), Facts::default(), Options::default());
    let pixels: Vec<[f32; 4]> = (0..12).map(|at| [at as f32 / 8.0, 0.25, 3.0, 1.0]).collect();
    let both = [Texels::from_floats_as_half(4, 3, &pixels), Texels::from_floats(4, 3, &pixels)];
    let [half, full] = both.map(|texels| {
        let image = input_image(&gpu, "in", texels.desc, &texels.bytes).unwrap_or_else(|error| panic!("{error}"));
        let step = FrameStep { time: 0.0, dt: 0.1, kind: FrameKind::Cut };
        let drawn = session.render(Size::new(4, 3), &[InputImage { finite: true, ..image }], step);
        drawn.unwrap_or_else(|error| panic!("{error}"));
        let shaders: Vec<String> = (0..session.plan().passes.len())
            .map(|pass| {
                session.plan().compose(pass, Default::default()).unwrap_or_else(|error| panic!("{error:?}")).source
            })
            .collect();
        let modes: Vec<_> = session.plan().images.iter().map(|image| image.sample_mode).collect();
        let lit = session.output("lit").unwrap_or_else(|error| panic!("{error}"));
        (shaders, modes, Picture::of(&lit).pixels)
    });
    assert_eq!(half.0, full.0, "this test is about equal shaders");
    assert_ne!(half.1, full.1, "this test is about different images");
    assert_eq!(half.2, full.2);
    assert_eq!(half.2[3], [0.75, 0.5, 6.0, 1.0]);
}

/// An index beyond the end of an array takes its last number: wgpu checks shaders of folders, which may do anything.
#[test]
#[cfg_attr(no_gpu, ignore = "AFTERIMAGE_NO_GPU is set")]
fn a_shader_of_a_folder_does_not_read_beyond_an_array() {
    let declaration = r#"Kind(
        name: "Pick", doc: "Picks a number of a list.",
        parameters: { "index": Int(doc: "Which.", default: 0, within: (0, 1000000)) },
        inputs: { "source": Image(doc: "A picture.") },
        outputs: { "result": Image(doc: "The number.", state: Same("source"), function: "pick") },
    )"#;
    let shader = "struct Pick { index: i32 }
        fn pick(source: vec4f, params: Pick) -> vec4f {
            var list = array<f32, 4>(source.x, 2.0, 3.0, 4.0 * source.y);
            return vec4f(list[params.index], source.x, source.y, 1.0);
        }";
    let kind = folder_kind_of(("node.ron", declaration), &[("pick.wgsl", shader)]);
    let kind = kind.unwrap_or_else(|errors| panic!("{errors}"));
    let picture = Picture::new(4, 4, |x, y| [1.0 + x as f32, 0.5 + y as f32, 0.0, 1.0]);
    for (index, wanted) in [(0, [1.0, 4.0]), (1, [2.0, 2.0]), (4, [2.0, 14.0]), (77, [2.0, 14.0]), (4099, [2.0, 14.0])]
    {
        let text = format!(
            r#"Pipeline(inputs: {{ "in": Color }}, nodes: {{ "one": Pick(source: "in", index: {index}) }},
            outputs: {{ "one": "one" }})"#
        );
        let graph = graph_with(&text, std::slice::from_ref(&kind));
        let [found] = Run::new(&graph).exact().frame(&[("in", &picture)]).try_into().expect("one output");
        assert_eq!([found.at(0, 0)[0], found.at(3, 3)[0]], wanted, "index {index}");
    }
}
