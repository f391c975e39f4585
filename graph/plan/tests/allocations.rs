//! New values of dynamic parameters allocate nothing, from the check of the value to the bytes of the uniforms.
//!
//! This is a binary of its own, because it has its own allocator.
#![allow(missing_docs, clippy::print_stdout, reason = "a test binary has no outside")]

use std::alloc::{GlobalAlloc, Layout, System};
use std::cell::Cell;
use std::collections::{BTreeMap, BTreeSet};

use afterimage_graph::check::{CheckOptions, Facts, Graph, ParameterId, check};
use afterimage_graph::document::parse;
use afterimage_graph::image::{Format, ImageDesc, Size};
use afterimage_graph::node::Registry;
use afterimage_graph::value::Value;
use afterimage_pipelines::{BuiltIn, PIPELINES};
use afterimage_plan::{Caps, Given, GivenImage, Options, PlanCache, PlanRequest, Planned, Requirement};

/// Counts what its own thread allocates.
struct Counting;

thread_local! {
    static ALLOCATIONS: Cell<usize> = const { Cell::new(0) };
}

fn count() {
    // A thread that ends has no counter any more.
    let _ = ALLOCATIONS.try_with(|allocations| allocations.set(allocations.get() + 1));
}

#[allow(unsafe_code, reason = "an allocator is unsafe by its trait; this one only counts")]
// SAFETY: all calls go to the allocator of the system with the same arguments.
unsafe impl GlobalAlloc for Counting {
    unsafe fn alloc(&self, layout: Layout) -> *mut u8 {
        count();
        // SAFETY: the caller keeps the contract of `alloc`.
        unsafe { System.alloc(layout) }
    }

    unsafe fn dealloc(&self, pointer: *mut u8, layout: Layout) {
        // SAFETY: the caller keeps the contract of `dealloc`, and the memory comes from the same allocator.
        unsafe { System.dealloc(pointer, layout) }
    }

    unsafe fn realloc(&self, pointer: *mut u8, layout: Layout, size: usize) -> *mut u8 {
        count();
        // SAFETY: the caller keeps the contract of `realloc`, and the memory comes from the same allocator.
        unsafe { System.realloc(pointer, layout, size) }
    }
}

#[global_allocator]
static COUNTING: Counting = Counting;

const FRAME: Size = Size { width: 640, height: 360, depth: 1 };

fn graph_of(name: &str, text: &str) -> Graph {
    let registry = Registry::new(&[afterimage_nodes::ALL]).expect("no two kinds share a name");
    let document = parse(&format!("{name}.ron"), text).unwrap_or_else(|errors| panic!("{errors}"));
    let options = CheckOptions { loader: &BuiltIn, ..CheckOptions::default() };
    check(&document, &registry, &options).unwrap_or_else(|errors| panic!("{errors}")).0
}

fn planned(graph: &Graph, dynamic: BTreeSet<ParameterId>) -> Planned {
    let mut facts = Facts::default();
    graph.facts().into_iter().for_each(|(name, _)| facts.set(name, true));
    let given = GivenImage { desc: ImageDesc::new(FRAME), finite: false };
    let request = PlanRequest {
        given: Given::everything(FRAME, graph.inputs.iter(), given),
        facts,
        caps: Caps { storage: Format::ALL.into(), ..Caps::default() },
        options: Options::default(),
        dynamic,
        requirement: &Requirement::typical,
    };
    Planned::new(graph, &request).unwrap_or_else(|error| panic!("{error}"))
}

/// Parameters of these kinds allocate: their nodes read a file again.
const ALLOCATING: &[&str] = &["ColorLut"];

/// What changes of a parameter have cost: the most allocations, and how many uniforms have got other bytes.
#[derive(Clone, Copy, Default)]
struct Cost {
    allocations: usize,
    writes: usize,
}

/// Changes a parameter to and fro, and counts in all but the first two changes, which may keep what they allocate.
fn cost(cache: &mut PlanCache, planned: &mut Planned, parameter: ParameterId, values: &[Value; 2]) -> Option<Cost> {
    let (mut cost, mut bytes) = (Cost::default(), planned.plan.uniform_buffer());
    for (round, value) in [0, 1, 0, 1].into_iter().map(|at| values[at].clone()).enumerate() {
        let before = ALLOCATIONS.get();
        cache.set(parameter, value).ok()?;
        let mut write = |offset: u64, new: &[u8]| {
            let old = &mut bytes[offset as usize..][..new.len()];
            cost.writes += usize::from(*old != *new);
            old.copy_from_slice(new);
        };
        let instance = &cache.graph().nodes[parameter.node].instance;
        planned.dynamic.uniforms(parameter.node, instance, &mut write).ok()?;
        if round >= 2 {
            cost.allocations = cost.allocations.max(ALLOCATIONS.get() - before);
        }
    }
    Some(cost)
}

#[test]
fn new_values_of_dynamic_parameters_allocate_nothing() {
    let mut costs: BTreeMap<(String, String), Cost> = BTreeMap::new();
    for (name, text) in PIPELINES {
        let graph = graph_of(name, text);
        let live: BTreeSet<_> = graph.parameters().filter(|id| !graph.declaration(*id).replan).collect();
        let mut planned = planned(&graph, live.clone());
        for parameter in live {
            let declaration = graph.declaration(parameter);
            let Some(values) = declaration.lowest().zip(declaration.middle()).map(<[Value; 2]>::from) else { continue };
            let mut cache = PlanCache::new(graph.clone());
            let Some(found) = cost(&mut cache, &mut planned, parameter, &values) else { continue };
            let kind = graph.nodes[parameter.node].kind().name().to_owned();
            let most = costs.entry((kind, declaration.name.to_string())).or_default();
            most.allocations = most.allocations.max(found.allocations);
            most.writes += found.writes;
        }
    }
    for ((kind, parameter), Cost { allocations, writes }) in &costs {
        println!("{kind}.{parameter}: {allocations} allocations, {writes} writes");
    }
    let allocating: BTreeSet<&str> =
        costs.iter().filter(|(_, cost)| cost.allocations > 0).map(|((kind, _), _)| kind.as_str()).collect();
    // These also show that the counter counts.
    assert_eq!(allocating.into_iter().collect::<Vec<_>>(), ALLOCATING);
    let moved = costs.values().filter(|cost| cost.writes > 0).count();
    assert!(moved > 100, "{moved} parameters have changed uniforms");
}
