//! One row for each built-in kind: nodes to run, and the image that a CPU reference makes of the same input, or pixels
//! with known values. A kind without a row, and without tests of its own in [`COMPARED`] or `node_folders`, fails a
//! test; so does an output that neither a row nor the file in [`READ_ELSEWHERE`] reads.

mod camera;
mod color;
mod lens;
mod samples;
mod shadow;
mod surface;
mod volume;

use std::collections::BTreeSet;
use std::path::Path;

use afterimage_graph::check::{Graph, Source};
use afterimage_graph::node::Camera;

use super::color::{SIZES, tolerance};
use crate::node_folders;
use crate::reference::image::Image;
use crate::support::gpu::{Picture, Run, gpu};
use crate::support::harness::{Nodes, Tolerance, assert_close, image};

/// Nodes from the input `scene` to the node `result`, and their CPU reference.
struct Reference {
    kind: &'static str,
    /// The state of `scene`.
    state: &'static str,
    nodes: String,
    scene: fn([u32; 2]) -> Picture,
    /// An input `data` of numbers that are not light.
    data: Option<fn([u32; 2]) -> Picture>,
    /// An input `volume`, whose slices lie one below the other.
    volume: Option<fn([u32; 2]) -> Picture>,
    /// An input `camera`.
    camera: Option<Camera>,
    expected: Box<dyn Fn(&Image) -> Image>,
    tolerance: Tolerance,
}

impl Reference {
    fn new(
        (kind, state): (&'static str, &'static str),
        nodes: &str,
        scene: fn([u32; 2]) -> Picture,
        tolerance: Tolerance,
        expected: impl Fn(&Image) -> Image + 'static,
    ) -> Self {
        Self {
            kind,
            state,
            nodes: nodes.to_owned(),
            scene,
            data: None,
            volume: None,
            camera: None,
            expected: Box::new(expected),
            tolerance,
        }
    }

    /// With an input `data` of numbers that are not light.
    fn with_data(self, data: fn([u32; 2]) -> Picture) -> Self {
        Self { data: Some(data), ..self }
    }

    /// With an input `volume`.
    fn with_volume(self, volume: fn([u32; 2]) -> Picture) -> Self {
        Self { volume: Some(volume), ..self }
    }

    /// With an input `camera`.
    fn with_camera(self, camera: Camera) -> Self {
        Self { camera: Some(camera), ..self }
    }

    /// The names and states of its inputs.
    fn inputs(&self) -> Vec<(&'static str, &'static str)> {
        let data = self.data.map(|_| ("data", "Data"));
        let volume = self.volume.map(|_| ("volume", "Color(volume: true)"));
        [Some(("scene", self.state)), data, volume].into_iter().flatten().collect()
    }

    fn nodes<'a>(&'a self, inputs: &'a [(&'a str, &'a str)]) -> Nodes<'a> {
        Nodes::new(&self.nodes, inputs).camera(self.camera.as_ref())
    }
}

/// Every row with a CPU reference.
fn references() -> Vec<Reference> {
    let rows = [
        color::placed_colors(),
        camera::camera_kinds(),
        surface::surface_kinds(),
        lens::sharpness_kinds(),
        lens::lens_kinds(),
        lens::warp_kinds(),
        samples::sample_kinds(),
        shadow::shadow_kinds(),
        volume::volume_kinds(),
    ];
    rows.into_iter().flatten().collect()
}

/// The kinds that have no row here, because tests of their own compare them with CPU references at many parameters.
const COMPARED: [&str; 31] = [
    // bloom/
    "Composite",
    "Downsample",
    "Extract",
    "Gaussian",
    "GaussianPyramid",
    "Upsample",
    // color/
    "Aces2Output",
    "Brightness",
    "Cdl",
    "ColorBalance",
    "ColorLut",
    "Contrast",
    "Dither",
    "Eetf",
    "Encode",
    "Exposure",
    "LiftGammaGain",
    "ReferenceGamutCompress",
    "Saturation",
    "ToneMap",
    "WhiteBalance",
    // local.rs
    "GridBlur",
    "GridBuild",
    "LocalToneMap",
    "LogGaussian",
    "Purkinje",
    "PurkinjeSimple",
    // metering.rs
    "Adapt",
    "AutoExposure",
    "Histogram",
    "MeanLuminance",
];

/// Outputs that no row reads, and of other kinds those beside the first: the file that tests them, and how it
/// reads them.
const READ_ELSEWHERE: [(&str, &str, &str, &str); 13] = [
    ("AutoExposure", "range", "nodes/metering/range.rs", "auto.range"),
    ("DemoScene", "result", "nodes/taa.rs", "\\\"f{i}\\\""),
    ("DemoScene", "motion", "nodes/taa.rs", "f{i}.motion"),
    ("DemoScene", "normal", "nodes/shadow_rays.rs", "room.normal"),
    ("Downsample", "coarsest", "nodes/bloom/downsample.rs", "mips.coarsest"),
    ("Extract", "peaks", "nodes/bloom/fireflies.rs", "bright.peaks"),
    ("Gtao", "occlusion", "nodes/occlusion.rs", "ao.occlusion"),
    ("Histogram", "brightest", "nodes/metering.rs", "h.brightest"),
    ("ShadowMask", "shadow", "nodes/shadow.rs", "mask.shadow"),
    ("Ssao", "occlusion", "nodes/occlusion.rs", "ao.occlusion"),
    ("Ssgi", "light", "node_folders/indirect.rs", "result.light"),
    ("Ssr", "reflection", "node_folders/reflections.rs", "result.reflection"),
    ("Taa", "exposure", "nodes/taa.rs", "taa.exposure"),
];

/// Outputs without a test, and why.
const UNTESTED: [(&str, &str, &str); 1] =
    [("DemoScene", "albedo", "paints of the scene that nothing else states; the gallery shows them")];

/// Pixels with known values, of nodes without inputs.
struct Vector {
    kind: &'static str,
    nodes: &'static str,
    frame: [u32; 2],
    pixels: &'static [([u32; 2], [f64; 4])],
    tolerance: Tolerance,
}

/// Depths of the built-in scene where rays hit planes of the room. The camera's position, its target and the planes are
/// numbers of the scene; the depths follow from the intersection of a ray with a plane.
const VECTORS: &[Vector] = &[
    Vector {
        kind: "DemoScene",
        nodes: "\"room\": DemoScene() -> room.depth",
        frame: [640, 360],
        pixels: &DEPTHS,
        tolerance: tolerance(0.0, 1e-5, "divisions in f32"),
    },
    Vector {
        kind: "DemoScene",
        nodes: "\"room\": DemoScene() -> room.projected",
        frame: [640, 360],
        pixels: &[
            (DEPTHS[0].0, [0.1 / DEPTHS[0].1[0], 0.0, 0.0, 1.0]),
            (DEPTHS[2].0, [0.1 / DEPTHS[2].1[0], 0.0, 0.0, 1.0]),
        ],
        tolerance: tolerance(0.0, 1e-5, "divisions in f32"),
    },
];

/// In order: the floor twice, the ceiling, the left and the right wall.
const DEPTHS: [([u32; 2], [f64; 4]); 5] = [
    ([320, 359], [3.8363649822244215, 0.0, 0.0, 1.0]),
    ([100, 350], [4.04903551600751, 0.0, 0.0, 1.0]),
    ([320, 5], [6.153237707082026, 0.0, 0.0, 1.0]),
    ([5, 100], [6.321097773706614, 0.0, 0.0, 1.0]),
    ([635, 100], [4.079100914540608, 0.0, 0.0, 1.0]),
];

#[test]
fn every_kind_has_a_cpu_reference_or_a_vector() {
    let rows = references().into_iter().map(|row| row.kind).chain(VECTORS.iter().map(|row| row.kind));
    let covered: BTreeSet<&str> = rows.chain(COMPARED).chain(node_folders::TESTED).collect();
    let kinds: BTreeSet<&str> = afterimage_nodes::ALL.iter().map(|kind| kind.name()).collect();
    let missing: Vec<&&str> = kinds.difference(&covered).collect();
    assert!(missing.is_empty(), "no CPU reference and no vector: {missing:?}");
    let unknown: Vec<&&str> = covered.difference(&kinds).collect();
    assert!(unknown.is_empty(), "no such kinds: {unknown:?}");
}

/// The outputs of kinds that a graph reads.
fn outputs_read(graph: &Graph) -> BTreeSet<(String, String)> {
    let wires = graph.nodes.iter().flat_map(|node| &node.wires).flatten();
    let sources = wires.chain(graph.outputs.iter().map(|output| &output.source));
    let read = sources.filter_map(|source| match source {
        Source::Input(_) => None,
        Source::Node { node, output, .. } => {
            let kind = graph.nodes[*node].kind();
            Some((kind.name().to_owned(), kind.outputs()[*output].name.to_string()))
        }
    });
    read.collect()
}

#[test]
fn every_output_of_every_kind_is_read_by_a_test() {
    let elsewhere = READ_ELSEWHERE.iter().map(|(kind, output, ..)| (*kind, *output));
    let listed: Vec<(&str, &str)> =
        elsewhere.chain(UNTESTED.iter().map(|(kind, output, _)| (*kind, *output))).collect();
    let mut covered: BTreeSet<(String, String)> =
        listed.iter().map(|(kind, output)| ((*kind).to_owned(), (*output).to_owned())).collect();
    for row in references() {
        covered.extend(outputs_read(&row.nodes(&row.inputs()).graph()));
    }
    for row in VECTORS {
        covered.extend(outputs_read(&Nodes::new(row.nodes, &[]).graph()));
    }
    let mut known = BTreeSet::new();
    for kind in afterimage_nodes::ALL {
        let has_tests = COMPARED.contains(&kind.name()) || node_folders::TESTED.contains(&kind.name());
        known.extend(kind.outputs().iter().map(|output| (kind.name().to_owned(), output.name.to_string())));
        covered.extend(has_tests.then(|| (kind.name().to_owned(), kind.main_output().to_owned())));
    }
    let missing: Vec<_> = known.difference(&covered).collect();
    assert!(missing.is_empty(), "no test reads these outputs: {missing:?}");
    let unknown: Vec<_> = covered.difference(&known).filter(|(kind, _)| kind != "ShowValue").collect();
    assert!(unknown.is_empty(), "no such outputs: {unknown:?}");
    for (kind, output, file, read) in READ_ELSEWHERE {
        let text = std::fs::read_to_string(Path::new(env!("CARGO_MANIFEST_DIR")).join(file)).unwrap();
        assert!(text.contains(read), "{file} reads no `{output}` of `{kind}` as {read}");
    }
}

/// Fails unless a node of the kind runs: a skipped one proves nothing.
fn assert_runs(kind: &str, run: &Run<'_>, pictures: &[(&str, &Picture)]) {
    let plan = run.plan(&gpu(), pictures);
    let is_of_kind =
        |name: &String| run.graph.nodes.iter().any(|node| node.name == *name && node.kind().name() == kind);
    let runs = plan.passes.iter().any(|pass| pass.pass.nodes.iter().any(is_of_kind));
    assert!(runs, "no pass runs a node of the kind {kind}");
}

#[test]
#[cfg_attr(no_gpu, ignore = "AFTERIMAGE_NO_GPU is set")]
fn every_kind_with_a_cpu_reference_equals_it() {
    for row in references() {
        let inputs = row.inputs();
        let nodes = row.nodes(&inputs);
        for size in SIZES {
            let made = [Some(row.scene), row.data, row.volume].into_iter().flatten();
            let pictures: Vec<Picture> = made.map(|picture| picture(size)).collect();
            let given: Vec<&Picture> = pictures.iter().collect();
            // The pyramid of a picture of a few pixels has one level, and no pass joins it.
            if size[0] > 3 {
                let graph = nodes.graph();
                let run = Run::new(&graph).camera(row.camera.as_ref());
                assert_runs(row.kind, &run, &nodes.named(&given));
            }
            let expected = (row.expected)(&image(&pictures[0]));
            assert_close(&format!("{} at {size:?}", row.kind), &nodes.exact(&given), &expected, &row.tolerance);
        }
    }
}

#[test]
#[cfg_attr(no_gpu, ignore = "AFTERIMAGE_NO_GPU is set")]
fn every_kind_with_a_vector_has_its_values() {
    for row in VECTORS {
        let graph = Nodes::new(row.nodes, &[]).graph();
        let mut run = Run::new(&graph).exact();
        run.size = afterimage_graph::image::Size::new(row.frame[0], row.frame[1]);
        assert_runs(row.kind, &run, &[]);
        let found = run.frame(&[]).remove(0);
        for ([x, y], expected) in row.pixels {
            let found = Picture::new(1, 1, |_, _| found.at(*x, *y));
            let expected = Image::new(1, 1, |_, _| *expected);
            assert_close(&format!("{} at ({x}, {y})", row.kind), &found, &expected, &row.tolerance);
        }
    }
}
