//! Planning time: the longest pipeline from its text to its plan, and random graphs of up to 10 000 nodes.
#![allow(missing_docs, unreachable_pub, reason = "a benchmark exports nothing")]

use std::hint::black_box;
use std::path::Path;
use std::sync::Arc;

use afterimage_generators::Recipe;
use afterimage_graph::check::{CheckOptions, Facts, Graph, Loader, check};
use afterimage_graph::document::parse;
use afterimage_graph::image::{Format, ImageDesc, Size};
use afterimage_graph::node::Registry;
use afterimage_plan::{Caps, HostImageDesc, HostInputs, Options, Plan, PlanRequest, Requirement, plan};
use criterion::{BenchmarkId, Criterion, Throughput, criterion_group, criterion_main};

const FOUR_K: Size = Size { width: 3840, height: 2160, depth: 1 };

struct Files;

impl Loader for Files {
    fn load(&self, path: &str) -> Result<Arc<[u8]>, String> {
        std::fs::read(path).map(Into::into).map_err(|error| error.to_string())
    }
}

fn checked(path: &Path, text: &str, registry: &Registry) -> Graph {
    let path = path.to_string_lossy();
    let document = parse(&path, text).unwrap_or_else(|errors| panic!("{errors:?}"));
    let options = CheckOptions { loader: &Files, ..CheckOptions::default() };
    check(&document, registry, &options).unwrap_or_else(|errors| panic!("{errors:?}")).0
}

/// The plan at 4K; images that are finite need no sanitizing pass.
fn planned(graph: &Graph, finite: bool) -> Plan {
    let given = HostImageDesc { desc: ImageDesc::new(FOUR_K), finite };
    let required = graph.inputs.iter().filter(|input| !input.optional);
    let request = PlanRequest {
        given: HostInputs::all(FOUR_K, required, given),
        facts: Facts::default(),
        caps: Caps { storage: Format::ALL.into(), ..Caps::default() },
        options: Options::default(),
        dynamic: Default::default(),
        requirement: &Requirement::typical,
    };
    plan(graph, &request).unwrap_or_else(|error| panic!("{error}"))
}

fn pipeline(criterion: &mut Criterion) {
    let path = Path::new(env!("CARGO_MANIFEST_DIR")).join("../../pipelines/tsushima.ron");
    let text = std::fs::read_to_string(&path).expect("the pipeline is in its place");
    let registry = Registry::new(&[afterimage_nodes::ALL]).expect("no two kinds share a name");
    let mut group = criterion.benchmark_group("tsushima");
    group.bench_function("text to plan", |bencher| {
        bencher.iter(|| planned(&checked(&path, black_box(&text), &registry), false));
    });
    let graph = checked(&path, &text, &registry);
    group.bench_function("graph to plan", |bencher| bencher.iter(|| planned(black_box(&graph), false)));
    group.finish();
}

fn random_graphs(criterion: &mut Criterion) {
    let mut group = criterion.benchmark_group("random graph to plan");
    group.sample_size(20);
    for nodes in [100, 1000, 10_000] {
        let graph = Recipe { seed: 1, nodes, histories: 3, off: 5 }.graph();
        group.throughput(Throughput::Elements(nodes as u64));
        group.bench_with_input(BenchmarkId::from_parameter(nodes), &graph, |bencher, graph| {
            bencher.iter(|| planned(black_box(graph), true));
        });
    }
    group.finish();
}

criterion_group!(benches, pipeline, random_graphs);
criterion_main!(benches);
