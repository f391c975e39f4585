//! The cost of the built-in pipelines, counted in their plans and in the code of their passes, and a hash of what their
//! files set. `AFTERIMAGE_BLESS=1` writes `golden/prices.txt` again, so that a commit shows the price of what it
//! changes.

mod memory;
mod operations;

use std::fmt::Write as _;

use afterimage_base::hash::fnv1a;
use afterimage_graph::check::{Checker, Facts, Graph, GraphNode};
use afterimage_graph::document::parse;
use afterimage_graph::image::{ImageDesc, Size};
use afterimage_graph::node::Registry;
use afterimage_pipelines::{BuiltIn, PIPELINES};
use afterimage_plan::{Caps, HostImageDesc, HostInputs, Memory, Options, Plan, PlanRequest, Requirement, plan};

use super::support::all_formats;
use operations::operations;

const FRAME: Size = Size { width: 3840, height: 2160, depth: 1 };

/// A size of which every halving down to 29x16 is of odd sides, and the pipelines that are counted at it, too.
const ODD: Size = Size { width: 3839, height: 2159, depth: 1 };
const AT_ODD: [&str; 2] = ["lynx", "tsushima"];

/// Figures may differ by this share of the known ones.
const TOLERANCE: f64 = 0.02;

const HEAD: &str =
    "# Each built-in pipeline and tier at 3840x2160, or at a size that is written, with the scene's color alone: MB
# that passes read and write, passes, batches, operations a pixel, MiB of placed memory, hash of all values.
";

/// The figures of a pipeline, in the order of the file.
struct Prices {
    name: String,
    figures: [f64; 5],
    values: String,
    memory: Option<Memory>,
}

impl Prices {
    fn new(name: String, graph: &Graph, size: Size) -> Self {
        let image = HostImageDesc { desc: ImageDesc::new(size), finite: false };
        let request = PlanRequest {
            given: HostInputs::all(size, graph.inputs.iter().filter(|input| !input.optional), image),
            facts: Facts::default(),
            caps: Caps { fast_workgroup_memory: true, ..all_formats() },
            options: Options::default(),
            dynamic: Default::default(),
            requirement: &Requirement::typical,
        };
        let plan = plan(graph, &request).unwrap_or_else(|error| panic!("{name}: {error}"));
        // Tables are not filled in every frame.
        let passes = (0..plan.passes.len()).filter(|pass| !plan.runs_on_change(*pass));
        let operations: f64 = passes.clone().map(|pass| operations_of(&plan, pass)).sum();
        let figures = [
            plan.bytes_moved() as f64 / 1e6,
            passes.count() as f64,
            plan.batches.len() as f64,
            operations / size.texels() as f64,
            plan.memory.placed as f64 / (1 << 20) as f64,
        ];
        Self { name, figures, values: values(graph), memory: Some(plan.memory) }
    }

    fn line(&self) -> String {
        let [megabytes, passes, batches, operations, memory] = self.figures;
        format!(
            "{:<26}{megabytes:>9.1}{passes:>5}{batches:>5}{operations:>9.1}{memory:>8.1} {}",
            self.name, self.values
        )
    }

    fn parse(line: &str) -> Option<Self> {
        let mut words: Vec<&str> = line.split_whitespace().collect();
        let values = words.pop()?.to_owned();
        let figures = words.split_off(words.len().checked_sub(5)?);
        let figures: Vec<f64> = figures.into_iter().map(|figure| figure.parse().ok()).collect::<Option<_>>()?;
        Some(Self { name: words.join(" "), figures: figures.try_into().ok()?, values, memory: None })
    }

    /// True if no figure is higher or lower than the known one, and no value has changed.
    fn is_as_known(&self, known: &Self) -> bool {
        let mut pairs = self.figures.iter().zip(known.figures);
        self.name == known.name
            && self.values == known.values
            && pairs.all(|(new, old)| (new - old).abs() <= (TOLERANCE * old).max(0.051))
    }
}

/// A hash of what the file of a pipeline, those that it extends and a tier set: the values of all parameters, and the
/// options and wires of nodes.
fn values(graph: &Graph) -> String {
    let mut text = String::new();
    for node in &graph.nodes {
        let GraphNode { name, wires, off, format, bake, every, .. } = node;
        let (kind, values) = (node.kind().name(), node.instance.values());
        writeln!(text, "{name} {kind} {wires:?} {off} {format:?} {bake:?} {every} {values:?}").expect("a string grows");
    }
    format!("{:08x}", fnv1a(text.as_bytes()) as u32)
}

/// The operations of all invocations of a pass.
fn operations_of(plan: &Plan, pass: usize) -> f64 {
    let composed = plan.compose(pass, Default::default()).unwrap_or_else(|error| panic!("{error}"));
    let module = composed.validate().unwrap_or_else(|error| panic!("{error}"));
    let invocations = [plan.passes[pass].workgroups, composed.workgroup].into_iter().flatten().map(f64::from);
    invocations.product::<f64>() * operations(&module, &composed.compute) as f64
}

/// Every pipeline as written, and at each of its tiers.
fn all() -> Vec<Prices> {
    let registry = Registry::new(&[afterimage_nodes::ALL]).expect("no two kinds share a name");
    let mut all = Vec::new();
    for (name, text) in PIPELINES {
        let document = parse(name, text).unwrap_or_else(|errors| panic!("{errors}"));
        let checker = Checker::new(&document, &registry, &BuiltIn);
        let tiers = checker.tiers();
        for tier in std::iter::once(None).chain(tiers.iter().map(|tier| Some(tier.as_str()))) {
            let (graph, _) = checker.check(tier, &[]).unwrap_or_else(|errors| panic!("{errors}"));
            all.push(Prices::new(format!("{name} {}", tier.unwrap_or("as written")), &graph, FRAME));
            if tier.is_none() && AT_ODD.contains(name) {
                all.push(Prices::new(format!("{name} at {ODD}"), &graph, ODD));
            }
        }
    }
    all
}

#[test]
fn no_pipeline_costs_more_than_is_known() {
    let path = concat!(env!("CARGO_MANIFEST_DIR"), "/tests/golden/prices.txt");
    let prices = all();
    let blesses = std::env::var_os("AFTERIMAGE_BLESS").is_some();
    memory::compare(&prices, blesses);
    if blesses {
        let lines: String = prices.iter().map(|row| row.line() + "\n").collect();
        std::fs::write(path, HEAD.to_owned() + &lines).unwrap_or_else(|error| panic!("{path}: {error}"));
    }
    let known = std::fs::read_to_string(path).unwrap_or_else(|error| panic!("{path}: {error}"));
    let known: Vec<Prices> = known.lines().filter_map(Prices::parse).collect();
    let mut changed = String::new();
    for row in &prices {
        let old = known.iter().find(|known| known.name == row.name);
        if !old.is_some_and(|old| row.is_as_known(old)) {
            let old = old.map(Prices::line).unwrap_or_default();
            writeln!(changed, "- {old}\n+ {}", row.line()).expect("a string grows");
        }
    }
    assert!(changed.is_empty(), "prices differ: if this is meant, set AFTERIMAGE_BLESS=1\n{HEAD}{changed}");
    assert_eq!(known.len(), prices.len(), "prices.txt names other pipelines: set AFTERIMAGE_BLESS=1");
}

#[test]
fn a_price_that_differs_by_more_than_the_tolerance_is_noticed() {
    let figures = |operations| [200.0, 12.0, 9.0, operations, 37.5];
    let with = |operations, values: &str| {
        let (name, values) = ("lynx low".to_owned(), values.to_owned());
        Prices { name, figures: figures(operations), values, memory: None }
    };
    let of = |operations| with(operations, "0123abcd");
    let known = Prices::parse(&of(500.0).line()).expect("a line can be read");
    assert!([490.1, 500.0, 509.9].into_iter().all(|operations| of(operations).is_as_known(&known)));
    assert!([489.0, 511.0].into_iter().all(|operations| !of(operations).is_as_known(&known)));
    assert!(!with(500.0, "0123abce").is_as_known(&known));
}
