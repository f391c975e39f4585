//! Pixels of plans without a device: random graphs of kinds whose functions are known in closed form, evaluated node by
//! node, against their plans, which an executor on the CPU runs.

mod executor;
mod kinds;
mod reference;

use std::fmt::Write as _;

use afterimage_generators::Rng;
use afterimage_graph::check::{CheckOptions, Facts, Graph, check};
use afterimage_graph::document::parse;
use afterimage_graph::node::Registry;
use afterimage_graph::prelude::*;
use afterimage_plan::{Caps, HostImageDesc, HostInputs, Options, Plan, PlanRequest, Requirement, plan, verify};

use super::model::variants;
use super::support::all_formats;
use super::sweep;
use executor::Executor;
use reference::image::Image;
use reference::sanitize::sanitized;

/// What is near the border depends on whether warps are fused: places beyond it are moved to it once, or at each warp.
/// No node moves it further than two pixels inward.
const SIZE: Size = Size { width: 40, height: 32, depth: 1 };
const BORDER: usize = 14;
const MAX_NODES: usize = 7;
const FRAMES: usize = 5;

/// Where a node reads an image.
#[derive(Clone, Copy)]
enum Wire {
    Picture,
    /// Of a node, an output, so many frames ago.
    Node(usize, usize, usize),
}

struct RandomNode {
    kind: &'static str,
    source: Wire,
    other: Option<Wire>,
    is_off: bool,
}

struct RandomGraph {
    nodes: Vec<RandomNode>,
    shown: Vec<usize>,
}

impl RandomGraph {
    fn new(seed: u64) -> Self {
        const ALL: &[&str] =
            &["Darker", "Sum", "Sum", "Right", "Below", "Raw", "Soft", "Slide", "Slide", "Mirror", "Fringe", "Pair"];
        const WARPS: &[&str] = &["Slide", "Mirror", "Fringe"];
        const PASTS: &[&str] = &["Sum", "Below", "Darker"];
        // Of three graphs, one has all kinds, one has chains of warps, and one reads images of several ages.
        let kinds = [ALL, WARPS, PASTS][seed as usize % 3];
        let mut rng = Rng::new(seed);
        let count = 3 + rng.below(MAX_NODES - 2);
        // The past of one node is read more often than that of the others, at several ages.
        let (remembered, mut nodes) = (rng.below(count), Vec::<RandomNode>::new());
        for at in 0..count {
            let kind = kinds[rng.below(kinds.len())];
            let source = Self::earlier(&nodes, &mut rng);
            let is_off = at != remembered && rng.per_cent(8);
            let other = matches!(kind, "Sum" | "Below").then(|| match rng.below(5) {
                0..3 => Wire::Node(remembered, 0, 1 + rng.below(3)),
                _ => Self::earlier(&nodes, &mut rng),
            });
            nodes.push(RandomNode { kind, source, other, is_off });
        }
        Self { nodes, shown: vec![count - 1, rng.below(count)] }
    }

    /// Mostly the last node.
    fn earlier(nodes: &[RandomNode], rng: &mut Rng) -> Wire {
        let at = if rng.per_cent(75) { nodes.len() } else { rng.below(nodes.len() + 1) };
        let Some(node) = at.checked_sub(1) else { return Wire::Picture };
        Wire::Node(node, if nodes[node].kind == "Pair" { rng.below(2) } else { 0 }, 0)
    }

    fn name(&self, wire: Wire) -> String {
        let Wire::Node(node, output, frames) = wire else { return "in".into() };
        let port = ["result", "turned"][output];
        let age = if frames == 0 { String::new() } else { format!("@previous:{frames}") };
        if self.nodes[node].kind == "Pair" { format!("n{node}.{port}{age}") } else { format!("n{node}{age}") }
    }

    fn text(&self) -> String {
        let (mut nodes, mut set, mut outputs) = (String::new(), String::new(), String::new());
        for (at, node) in self.nodes.iter().enumerate() {
            let other = node.other.map(|wire| format!(", other: \"{}\"", self.name(wire))).unwrap_or_default();
            let source = self.name(node.source);
            write!(nodes, "\"n{at}\": {}(source: \"{source}\"{other}), ", node.kind).expect("it grows");
            if node.is_off {
                write!(set, "\"n{at}\": Off, ").expect("it grows");
            }
        }
        for (at, node) in self.shown.iter().enumerate() {
            write!(outputs, "\"shown{at}\": \"{}\", ", self.name(Wire::Node(*node, 0, 0))).expect("it grows");
        }
        format!("Pipeline(inputs: {{\"in\": Color}}, nodes: {{{nodes}}}, set: {{{set}}}, outputs: {{{outputs}}})")
    }

    fn graph(&self) -> Graph {
        let document = parse("pixels.ron", &self.text()).unwrap_or_else(|errors| panic!("{errors}"));
        let registry = Registry::new(&[kinds::KINDS]).expect("no two kinds share a name");
        check(&document, &registry, &CheckOptions::default()).unwrap_or_else(|errors| panic!("{errors}")).0
    }

    /// The outputs of some frames, node by node.
    fn frames(&self, pictures: &[Image]) -> Vec<Vec<(String, Image)>> {
        // For each frame the images of each node.
        let mut all: Vec<Vec<Vec<Image>>> = Vec::new();
        for picture in pictures {
            let picture = sanitized(picture);
            let black = picture.map(|_| [0.0; 4]);
            let mut made: Vec<Vec<Image>> = Vec::new();
            for node in &self.nodes {
                let image = |wire: Wire| match wire {
                    Wire::Picture => &picture,
                    Wire::Node(node, output, 0) => &made[node][output],
                    Wire::Node(node, output, frames) => {
                        all.len().checked_sub(frames).map_or(&black, |frame| &all[frame][node][output])
                    }
                };
                let source = image(node.source);
                made.push(match (node.is_off, node.kind) {
                    (true, "Below") => vec![node.other.map_or(source, image).clone()],
                    (true, _) => vec![source.clone(); 2],
                    (false, _) => kinds::node(node.kind, source, node.other.map(image)),
                });
            }
            all.push(made);
        }
        let shown = |made: &Vec<Vec<Image>>| {
            let shown = self.shown.iter().enumerate();
            shown.map(|(at, node)| (format!("shown{at}"), made[*node][0].clone())).collect()
        };
        all.iter().map(shown).collect()
    }
}

/// A picture with numbers that are not finite and negative ones.
fn picture(frame: usize) -> Image {
    Image::new(SIZE.width as usize, SIZE.height as usize, |x, y| {
        [0, 1, 2, 3].map(|channel| match (x * 5 + y * 3 + channel * 11 + frame) % 23 {
            0 => f64::NAN,
            1 => f64::INFINITY,
            2 => f64::NEG_INFINITY,
            _ => ((x * 7 + y * 13 + frame * 29 + channel * 17) % 64) as f64 / 16.0 - 0.5,
        })
    })
}

fn planned(graph: &Graph, caps: Caps, options: Options) -> Plan {
    let image = HostImageDesc { desc: ImageDesc::new(SIZE), finite: false };
    let given = HostInputs { inputs: [("in".to_owned(), image)].into(), ..HostInputs::none(SIZE) };
    let (facts, dynamic, requirement) = (Facts::default(), Default::default(), &Requirement::typical);
    let request = PlanRequest { given, facts, caps, options, dynamic, requirement };
    let plan = plan(graph, &request).unwrap_or_else(|error| panic!("{error}"));
    assert_eq!(verify(&plan), Ok(()), "{}", plan.to_text());
    plan
}

/// The first pixel that differs in a frame, away from the border.
fn difference(found: &[(String, Image)], wanted: &[(String, Image)]) -> Option<String> {
    for ((name, found), (other, wanted)) in found.iter().zip(wanted) {
        assert_eq!((name, found.width, found.height), (other, wanted.width, wanted.height));
        for y in BORDER..found.height - BORDER {
            for x in BORDER..found.width - BORDER {
                let [found, wanted] = [found, wanted].map(|image| image.texel(x as i64, y as i64));
                let is_near = |(a, b): (&f64, &f64)| (a - b).abs() <= 1e-9 * b.abs().max(1.0);
                if !found.iter().zip(&wanted).all(is_near) {
                    return Some(format!("`{name}` at {x}, {y}: {found:?} is not {wanted:?}"));
                }
            }
        }
    }
    None
}

#[test]
fn plans_make_the_pixels_of_their_graphs() {
    let pictures: Vec<Image> = (0..FRAMES).map(picture).collect();
    let (mut warps, mut sanitized, mut aliased) = (0, 0, 0);
    for seed in 0..sweep::cases(900) {
        let random = RandomGraph::new(seed);
        let (graph, wanted) = (random.graph(), random.frames(&pictures));
        let drawn = Caps { prefer_fragment: true, ..Caps::default() };
        let computed = variants().map(|(name, options)| (name, options, all_formats()));
        // One way with each graph, and the one with the most changes always.
        let rotated = computed[1 + seed as usize % (computed.len() - 1)].clone();
        for (name, options, caps) in [computed[0].clone(), rotated, ("drawn", Options::default(), drawn)] {
            let plan = planned(&graph, caps, options);
            let found = Executor::frames(&plan, &pictures);
            for (frame, (found, wanted)) in found.iter().zip(&wanted).enumerate() {
                if let Some(difference) = difference(found, wanted) {
                    panic!("graph {seed}, {name}, frame {frame}: {difference}\n{}\n{}", random.text(), plan.to_text());
                }
            }
            let taps = |pass: &afterimage_graph::node::Pass| pass.kernels.iter().filter(|k| k.warp.is_some()).count();
            warps += plan.work().filter(|pass| taps(pass) > 2 && pass.nodes.len() > 1).count();
            sanitized += plan.work().filter(|pass| pass.label == "sanitize").count();
            aliased += plan.batches.iter().map(|batch| batch.aliasing.len()).sum::<usize>();
        }
    }
    assert!(
        warps > 20 && sanitized > 20 && aliased > 20,
        "{warps} fused warps, {sanitized} copies, {aliased} barriers"
    );
}
