//! Random pipelines of the built-in kinds, at odd sizes, show the same bits in three frames as planned, with their nodes
//! in another order and under other names, and without fusion, sharing of memory and overlap; all with 32-bit images.
//! Kinds that need a file or a host's samples, volumes, draws or blocks are not among them.

use std::collections::BTreeSet;
use std::sync::Arc;

use afterimage_generators::Rng;
use afterimage_graph::check::{CheckOptions, Graph, NoFiles, check};
use afterimage_graph::document::parse;
use afterimage_graph::image::{ColorState, ImageDesc};
use afterimage_graph::node::{Input, NodeKind, Pass, PortType, Registry, WarpPart};
use afterimage_graph::value::{Param, Type};
use afterimage_plan::{Alias, Caps, HostImageDesc, HostInputs, Options, Plan, PlanRequest, Requirement};

use super::{bits, lively};
use crate::support::gpu::{Picture, Run, registry};
use crate::support::player::Player;
use crate::support::sweep;

/// The random pipelines of a whole sweep, and of a short one.
const ALL: u64 = 500;
const FEW: u64 = 2;
/// The sides of pictures: odd ones, halves that are odd, and a single row.
const SIZES: [(u32, u32); 6] = [(53, 37), (33, 19), (17, 13), (65, 5), (7, 31), (9, 1)];
/// The inputs of the host: type, name and color state.
const INPUTS: [(&str, &str, ColorState); 4] = [
    ("Color", "light", ColorState::Scene),
    ("DisplayLinear", "shown", ColorState::DisplayLinear),
    ("Encoded", "coded", ColorState::Encoded),
    ("Data", "data", ColorState::Data),
];
/// Attempts to add a node to a pipeline.
const ATTEMPTS: usize = 40;

/// The sources of wires. `<3>` stands for the name of the fourth node.
#[derive(Clone)]
struct Wire {
    text: String,
    ty: PortType,
    state: Option<ColorState>,
    content: Option<String>,
}

struct Random {
    /// The values of nodes, with `<3>` for names.
    nodes: Vec<String>,
    kinds: BTreeSet<String>,
    wires: Vec<Wire>,
}

impl Random {
    fn new(seed: u64, registry: &Registry) -> Self {
        let mut rng = Rng::new(seed);
        let input = |(_, name, state): &(&str, &str, ColorState)| Wire {
            text: (*name).to_owned(),
            ty: PortType::Image,
            state: Some(*state),
            content: None,
        };
        let wires = INPUTS.iter().map(input).collect();
        let mut made = Self { nodes: Vec::new(), kinds: BTreeSet::new(), wires };
        let kinds: Vec<&NodeKind> = registry.iter().collect();
        let wanted = 4 + rng.below(9);
        for _ in 0..ATTEMPTS {
            if made.nodes.len() < wanted {
                let kind = kinds[rng.below(kinds.len())];
                made.add(kind, &mut rng, registry);
            }
        }
        made
    }

    /// Adds a node of the kind, if something fits its ports and the pipeline can still be planned.
    fn add(&mut self, kind: &NodeKind, rng: &mut Rng, registry: &Registry) {
        let mut fields = Vec::new();
        for port in kind.inputs() {
            if port.optional && rng.per_cent(60) {
                continue;
            }
            match self.wire(port, rng) {
                Some(wire) => fields.push(format!("{}: \"{wire}\"", port.name)),
                None if port.optional => {}
                None => return,
            }
        }
        for param in kind.params() {
            if rng.per_cent(35) {
                fields.extend(value(param, rng).map(|value| format!("{}: {value}", param.name)));
            }
        }
        self.nodes.push(format!("{}({})", kind.name(), fields.join(", ")));
        let number = self.nodes.len() - 1;
        let before = self.wires.len();
        for output in kind.outputs() {
            let (text, content) =
                (format!("<{number}>.{}", output.name), output.content.as_ref().map(|c| c.to_string()));
            self.wires.push(Wire { text, ty: output.ty, state: None, content });
        }
        let graph = self.graph(&self.in_order(), &plain, registry).filter(plans);
        let Some(graph) = graph else {
            self.nodes.pop();
            self.wires.truncate(before);
            return;
        };
        let node = graph.nodes.iter().find(|node| node.name == plain(number)).expect("it was added");
        for (wire, state) in self.wires[before..].iter_mut().zip(&node.states) {
            wire.state = *state;
        }
        self.kinds.insert(kind.name().to_owned());
    }

    fn wire(&self, port: &Input, rng: &mut Rng) -> Option<String> {
        let fits = |wire: &&Wire| {
            wire.ty == port.ty
                && (port.states.is_empty() || wire.state.is_some_and(|state| port.states.contains(&state)))
                && (port.content.is_none() || port.content.as_ref().map(|c| c.to_string()) == wire.content)
        };
        let all: Vec<&Wire> = self.wires.iter().filter(fits).collect();
        let recent = &all[all.len().saturating_sub(4)..];
        let wire = rng.one_of(recent)?;
        let is_past = wire.text.starts_with('<') && wire.ty == PortType::Image && rng.per_cent(12);
        Some(if is_past { format!("{}@previous", wire.text) } else { wire.text.clone() })
    }

    fn in_order(&self) -> Vec<usize> {
        (0..self.nodes.len()).collect()
    }

    /// The text with the nodes in that order and under those names. All images that no other node reads are outputs.
    fn text(&self, order: &[usize], name: &dyn Fn(usize) -> String) -> String {
        let body: String = order.iter().map(|at| format!("        \"<{at}>\": {},\n", self.nodes[*at])).collect();
        let is_shown = |wire: &&Wire| {
            let is_read = self.nodes.iter().any(|node| node.contains(&format!("\"{}\"", wire.text)));
            wire.text.starts_with('<') && wire.ty == PortType::Image && !is_read
        };
        let shown = self.wires.iter().filter(is_shown).enumerate();
        let outputs: String = shown.map(|(at, wire)| format!("        \"out{at}\": \"{}\",\n", wire.text)).collect();
        let used = INPUTS.iter().filter(|(_, input, _)| body.contains(&format!("\"{input}\"")));
        let inputs: String = used.map(|(ty, input, _)| format!("        \"{input}\": {ty},\n")).collect();
        let mut text = format!(
            "Pipeline(\n    inputs: {{\n{inputs}    }},\n    nodes: {{\n{body}    }},\n    outputs: {{\n{outputs}    }},\n)\n"
        );
        for at in 0..self.nodes.len() {
            text = text.replace(&format!("<{at}>"), &name(at));
        }
        text
    }

    fn graph(&self, order: &[usize], name: &dyn Fn(usize) -> String, registry: &Registry) -> Option<Graph> {
        let document = parse("random.ron", &self.text(order, name)).ok()?;
        let options = CheckOptions { tier: None, sets: Vec::new(), loader: &NoFiles };
        Some(check(&document, registry, &options).ok()?.0)
    }
}

fn plain(at: usize) -> String {
    format!("n{at}")
}

/// A name that is sorted elsewhere.
fn renamed(at: usize) -> String {
    format!("{}_{}", ["zeta", "alpha", "mid"][at % 3], 99 - at)
}

fn value(param: &Param, rng: &mut Rng) -> Option<String> {
    let (low, high) = param.usual.or(param.domain).unwrap_or((0.0, 1.0));
    let mut number = || low + (high - low) * rng.below(17) as f64 / 16.0;
    match param.ty {
        Type::Bool => Some((number() > 0.5 * (low + high)).to_string()),
        Type::Int => Some((number().round() as i64).to_string()),
        Type::Float => Some(format!("{:?}", number())),
        Type::Vector(n) => {
            let numbers: Vec<String> = (0..n).map(|_| format!("{:?}", number())).collect();
            Some(format!("({})", numbers.join(", ")))
        }
        Type::Choice(all) => Some(all[rng.below(all.len())].name.to_owned()),
        Type::Text | Type::File => None,
    }
}

/// True if the graph can be planned at an odd size.
fn plans(graph: &Graph) -> bool {
    let size = afterimage_graph::image::Size::new(53, 37);
    let given = HostImageDesc { desc: ImageDesc::new(size), finite: false };
    let inputs = graph.inputs.iter().map(|input| (input.name.clone(), given)).collect();
    let request = PlanRequest {
        given: HostInputs { inputs, ..HostInputs::none(size) },
        facts: Default::default(),
        caps: Caps::default(),
        options: Options::default(),
        dynamic: Default::default(),
        requirement: &Requirement::typical,
    };
    afterimage_plan::plan_without_tables(graph, &request).is_ok()
}

/// Three frames of a moving picture: the second is a cut.
fn film(player: &mut Player, plan: &Arc<Plan>, graph: &Graph, scenes: &[Picture]) -> Vec<Vec<u32>> {
    player.executor.load(plan.clone()).unwrap_or_else(|error| panic!("{error}"));
    player.executor.reset();
    player.executor.count_from(0);
    let mut shown = Vec::new();
    for (frame, scene) in scenes.iter().enumerate() {
        let inputs: Vec<(&str, &Picture)> = graph.inputs.iter().map(|input| (input.name.as_str(), scene)).collect();
        player.frame(&inputs, 0.1, frame == 1);
        shown.extend(plan.outputs.iter().map(|output| bits(&player.output(&output.name))));
    }
    shown
}

fn planned(player: &Player, graph: &Graph, options: Options, scene: &Picture) -> Arc<Plan> {
    let mut run = Run::new(graph);
    run.options = options;
    let inputs: Vec<(&str, &Picture)> = graph.inputs.iter().map(|input| (input.name.as_str(), scene)).collect();
    let plan = run.plan(&player.gpu, &inputs);
    assert_eq!(afterimage_plan::verify(&plan), Ok(()));
    Arc::new(plan)
}

/// True if the pass is made of several warps.
fn has_joined_warps(pass: &Pass) -> bool {
    let places = pass.kernels.iter().filter(|kernel| kernel.warp == Some(WarpPart::Place));
    places.map(|kernel| &kernel.node).collect::<BTreeSet<_>>().len() > 1
}

/// The largest difference of two films, as a share of the number or of 1.
fn worst(a: &[Vec<u32>], b: &[Vec<u32>]) -> f32 {
    let pairs = a.iter().flatten().zip(b.iter().flatten()).map(|(a, b)| (f32::from_bits(*a), f32::from_bits(*b)));
    pairs.map(|(a, b)| (a - b).abs() / a.abs().max(1.0)).fold(0.0, f32::max)
}

#[test]
#[cfg_attr(no_gpu, ignore = "AFTERIMAGE_NO_GPU is set")]
#[expect(clippy::print_stdout, reason = "`tests/sweeps.sh` quotes the figures")]
fn random_pipelines_show_the_same_in_every_way() {
    let registry = registry();
    let mut kinds = BTreeSet::new();
    let (mut different, mut joined) = (Vec::new(), 0);
    for seed in 0..if sweep::is_whole() { ALL } else { FEW } {
        let random = Random::new(seed, &registry);
        let Some(graph) = random.graph(&random.in_order(), &plain, &registry) else { continue };
        let (width, height) = SIZES[seed as usize % SIZES.len()];
        let base = lively(width, height);
        let scenes = [1.0_f32, 0.25, 3.0]
            .map(|light| Picture::new(width, height, |x, y| base.at(x, y).map(|channel| channel * light)));
        let mut player = Player::new();
        let exact = Options { exact: true, ..Options::default() };
        let plan = planned(&player, &graph, exact, &scenes[0]);
        let wanted = film(&mut player, &plan, &graph, &scenes);
        let mut order = random.in_order();
        let mut rng = Rng::new(seed + 1000);
        (1..order.len()).rev().for_each(|at| order.swap(at, rng.below(at + 1)));
        let other = random.graph(&order, &renamed, &registry).expect("names and order mean nothing");
        // Neighboring warps that become one filter once instead of twice, which is what they are for.
        let fuse = plan.passes.iter().any(|planned| has_joined_warps(&planned.pass));
        joined += usize::from(fuse);
        let plain_options = Options { alias: Alias::None, serial: true, fuse, ..exact };
        let ways = [("in another order and renamed", &other, exact), ("one by one", &graph, plain_options)];
        for (way, graph, options) in ways {
            let plan = planned(&player, graph, options, &scenes[0]);
            let seen = film(&mut player, &plan, graph, &scenes);
            if seen != wanted {
                let names = Vec::from_iter(random.kinds.iter().map(String::as_str)).join(", ");
                different.push(format!("seed {seed} {way}: {} ({names})", worst(&wanted, &seen)));
            }
        }
        kinds.extend(random.kinds);
    }
    println!("{} kinds; {joined} pipelines with joined warps", kinds.len());
    assert!(kinds.len() >= if sweep::is_whole() { 45 } else { 10 }, "{kinds:?}");
    assert!(different.is_empty(), "{}", different.join("\n"));
}
