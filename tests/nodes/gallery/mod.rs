//! The pictures of `graph/docs/effects.md`: what kinds do to the built-in scene.

mod depth;
mod edges;
mod kinds;
mod lens;
mod look;
mod paint;
mod sheet;

use afterimage_graph::check::{CheckOptions, Graph, NoFiles, check};
use afterimage_graph::document::parse;
use afterimage_graph::image::Size;
use afterimage_graph::node::{Camera, NodeKind, Registry};
use afterimage_media::Encoding;

use self::sheet::{Crop, sheet};
use crate::support::docs;
use crate::support::gpu::{Picture, Run, SLICES};

/// A panel: two images of a pipeline, without a kind and with it.
struct Panel {
    kind: &'static str,
    /// The nodes that it adds to the pipeline. Two of them, `KIND-0` and `KIND-1`, are the images.
    nodes: String,
    crop: Crop,
}

/// Nodes that expose light by these stops, map and encode it.
fn shown(name: &str, light: &str, stops: f32) -> String {
    format!(
        "\"{name}-exposed\": Exposure(source: \"{light}\", stops: {stops:?}), \
         \"{name}-mapped\": ToneMap(source: \"{name}-exposed\"), \"{name}\": Encode(source: \"{name}-mapped\"),\n"
    )
}

impl Panel {
    /// Two images of light before exposure, and nodes that make them.
    fn of_light(kind: &'static str, nodes: &str, before: &str, after: &str, stops: f32, crop: Crop) -> Self {
        let both = shown(&format!("{kind}-0"), before, stops) + &shown(&format!("{kind}-1"), after, stops);
        Self { kind, nodes: nodes.to_owned() + &both, crop }
    }

    /// A kind that changes light, with these wires besides the source.
    fn light(
        (kind, parameters): (&'static str, &'static str),
        (source, wires): (&str, &str),
        stops: f32,
        crop: Crop,
    ) -> Self {
        let node = format!("\"{kind}\": {kind}(source: \"{source}\", {wires} {parameters}),\n");
        Self::of_light(kind, &node, source, kind, stops, crop)
    }

    /// A kind whose light is added to an image, this share of it: what is shown without it, the image, and its source.
    fn added(
        (kind, parameters): (&'static str, &'static str),
        [before, base, source]: [&str; 3],
        share: f32,
        stops: f32,
        crop: Crop,
    ) -> Self {
        let nodes = format!(
            "\"{kind}\": {kind}(source: \"{source}\", {parameters}), \"{kind}-added\": Composite(base: \"{base}\", \
             bloom: \"{kind}\", blend: Add, strength: {share:?}),\n"
        );
        Self::of_light(kind, &nodes, before, &format!("{kind}-added"), stops, crop)
    }

    /// A kind that changes an encoded image of this light.
    fn encoded((kind, parameters): (&'static str, &'static str), light: &str, stops: f32, crop: Crop) -> Self {
        let before = format!("{kind}-0");
        let node = format!("\"{kind}-1\": {kind}(source: \"{before}\", {parameters}),\n");
        Self { kind, nodes: shown(&before, light, stops) + &node, crop }
    }

    /// A kind that changes an image for a display: linear, of this scene.
    fn display((kind, parameters): (&'static str, &'static str), scene: &str, stops: f32, crop: Crop) -> Self {
        let nodes = format!(
            "\"{kind}\": {kind}(source: \"{kind}-0-mapped\", {parameters}), \"{kind}-1\": Encode(source: \"{kind}\"),\n"
        );
        Self { kind, nodes: nodes + &shown(&format!("{kind}-0"), scene, stops), crop }
    }
}

/// A picture of the documentation, and the pipeline that makes its panels.
struct Page {
    file: &'static str,
    size: Size,
    inputs: &'static str,
    /// The nodes that panels share.
    nodes: String,
    panels: Vec<Panel>,
    own: Vec<NodeKind>,
    blocks: Vec<(&'static str, Camera)>,
    images: Vec<(&'static str, Picture)>,
    /// The slices of a volume.
    slices: u32,
}

impl Page {
    fn new(file: &'static str, size: Size) -> Self {
        let (nodes, panels, own) = (String::new(), Vec::new(), Vec::new());
        Self { file, size, inputs: "", nodes, panels, own, blocks: Vec::new(), images: Vec::new(), slices: SLICES }
    }

    fn graph(&self, outputs: &str) -> Graph {
        let nodes: String = self.panels.iter().map(|panel| panel.nodes.as_str()).collect();
        let (inputs, shared) = (self.inputs, &self.nodes);
        let text = format!("Pipeline(inputs: {{ {inputs} }}, nodes: {{ {shared} {nodes} }}, outputs: {{ {outputs} }})");
        let registry = Registry::new(&[afterimage_nodes::ALL, &self.own]).expect("no two kinds share a name");
        let document = parse("gallery.ron", &text).unwrap_or_else(|errors| panic!("{errors}"));
        let options = CheckOptions { tier: None, sets: Vec::new(), loader: &NoFiles };
        check(&document, &registry, &options).unwrap_or_else(|errors| panic!("{errors}")).0
    }

    /// The encoded frames of all panels, without and with the kind.
    fn frames(&self) -> Vec<[Picture; 2]> {
        let outputs = |panel: &Panel| [0, 1].map(|i| format!("\"{0}-{i}\": \"{0}-{i}\", ", panel.kind)).concat();
        let graph = self.graph(&self.panels.iter().map(outputs).collect::<String>());
        let mut run = Run::new(&graph);
        (run.size, run.slices, run.time) = (self.size, self.slices, 1.0);
        let run = self.blocks.iter().fold(run, |run, (name, camera)| run.block(name, camera));
        let images: Vec<(&str, &Picture)> = self.images.iter().map(|(name, image)| (*name, image)).collect();
        let mut found = run.frame(&images).into_iter();
        std::iter::from_fn(|| Some([found.next()?, found.next()?])).collect()
    }

    /// Draws the panels, looks at them, and writes the picture if pictures are written.
    fn draw(self) {
        let frames = self.frames();
        assert_eq!(frames.len(), self.panels.len());
        for (panel, [before, after]) in self.panels.iter().zip(&frames) {
            let is_shown = |picture: &Picture| picture.pixels.iter().flatten().all(|x| (-1e-3..=1.001).contains(x));
            assert!(is_shown(before) && is_shown(after), "{} has numbers that no display has", panel.kind);
            assert!(changed(before, after) > 0.01, "{} changes {} of the frame", panel.kind, changed(before, after));
        }
        if docs::are_written() {
            let shown = |(panel, frames): (&Panel, &[Picture; 2])| {
                let halves = frames.each_ref().map(|frame| panel.crop.shown(frame));
                let changed = changed(&halves[0], &halves[1]);
                assert!(changed > 0.05, "{} changes {changed} of its panel", panel.kind);
                halves
            };
            let halves: Vec<[Picture; 2]> = self.panels.iter().zip(&frames).map(shown).collect();
            // Without a dither, which would be most of the file.
            let options = Encoding { quality: 78, dither: None, ..Encoding::JPEG };
            docs::write(self.file, &sheet(&halves), &options);
        }
    }
}

/// The share of pixels that differ by more than a code of eight bits.
fn changed(a: &Picture, b: &Picture) -> f64 {
    let differs = |(a, b): &(&[f32; 4], &[f32; 4])| (0..3).any(|c| (a[c] - b[c]).abs() > 1.0 / 255.0);
    a.pixels.iter().zip(&b.pixels).filter(differs).count() as f64 / a.pixels.len() as f64
}

/// That of the pictures, or a small one.
fn size(width: u32) -> Size {
    let width = if docs::are_written() { width } else { 64 };
    Size::new(width, width * 9 / 16)
}

#[test]
#[cfg_attr(no_gpu, ignore = "AFTERIMAGE_NO_GPU is set")]
fn the_picture_of_depth_is_drawn() {
    depth::page().draw();
}

#[test]
#[cfg_attr(no_gpu, ignore = "AFTERIMAGE_NO_GPU is set")]
fn the_picture_of_edges_is_drawn() {
    edges::page().draw();
}

#[test]
#[cfg_attr(no_gpu, ignore = "AFTERIMAGE_NO_GPU is set")]
fn the_picture_of_lenses_is_drawn() {
    lens::page().draw();
}

#[test]
#[cfg_attr(no_gpu, ignore = "AFTERIMAGE_NO_GPU is set")]
fn the_picture_of_looks_is_drawn() {
    look::page().draw();
}

#[test]
#[cfg_attr(no_gpu, ignore = "AFTERIMAGE_NO_GPU is set")]
fn the_picture_of_paint_is_drawn() {
    paint::page().draw();
}
