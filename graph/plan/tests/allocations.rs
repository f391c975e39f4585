//! New values of dynamic parameters allocate nothing, from the check of the value to the bytes of the uniforms.
//!
//! This is a binary of its own, because it has its own allocator.
#![allow(missing_docs, clippy::print_stdout, reason = "a test binary has no outside")]

use std::alloc::{GlobalAlloc, Layout, System};
use std::cell::Cell;
use std::collections::{BTreeMap, BTreeSet};
use std::sync::Arc;

use afterimage_graph::check::{CheckOptions, Facts, Graph, Loader, ParameterId, check};
use afterimage_graph::document::parse;
use afterimage_graph::image::{Format, ImageDesc, Size};
use afterimage_graph::node::{Origin, Registry};
use afterimage_graph::value::Value;
use afterimage_pipelines::{BuiltIn, PIPELINES};
use afterimage_plan::{Caps, HostImageDesc, HostInputs, Options, Plan, PlanCache, PlanRequest, Planned, Requirement};

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
    let given = HostImageDesc { desc: ImageDesc::new(FRAME), finite: false };
    let request = PlanRequest {
        given: HostInputs::all(FRAME, graph.inputs.iter(), given),
        facts,
        caps: Caps { storage: Format::ALL.into(), ..Caps::default() },
        options: Options::default(),
        dynamic,
        requirement: &Requirement::typical,
    };
    Planned::new(graph, &request).unwrap_or_else(|error| panic!("{error}"))
}

/// What changes of a parameter have cost: the most allocations, and how many uniforms have got other bytes.
#[derive(Clone, Copy, Default)]
struct Cost {
    allocations: usize,
    writes: usize,
    /// Whether it allocates more than its kind may.
    too_many: bool,
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

/// Allocations of a pass of a kind in a folder, at most: it is recorded again from its declaration.
const MAX_OF_FOLDERS: usize = 8;

/// Whether a node is of a kind in a folder.
/// The kernels of a node whose kind is in a folder; 0 of another one.
fn kernels_in_folder(plan: &Plan, node: &str) -> usize {
    let kernels = plan.passes.iter().flat_map(|planned| &planned.pass.kernels);
    kernels.filter(|kernel| kernel.node == node && kernel.shader.is_untrusted()).count()
}

#[test]
fn new_values_of_dynamic_parameters_allocate_nothing_and_little_in_folders() {
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
            let allowed = MAX_OF_FOLDERS * kernels_in_folder(&planned.plan, &graph.nodes[parameter.node].name);
            most.allocations = most.allocations.max(found.allocations);
            most.too_many |= found.allocations > allowed;
            most.writes += found.writes;
        }
    }
    for ((kind, parameter), Cost { allocations, writes, .. }) in &costs {
        println!("{kind}.{parameter}: {allocations} allocations, {writes} writes");
    }
    let allocating: Vec<_> = costs.iter().filter(|(_, cost)| cost.too_many).map(|(name, _)| name).collect();
    assert_eq!(allocating, Vec::<&(String, String)>::new());
    let moved = costs.values().filter(|cost| cost.writes > 0).count();
    assert!(moved > 100, "{moved} parameters have changed uniforms");
}

/// A file of a `ColorLut`, whatever its path.
struct File(&'static str);

impl Loader for File {
    fn load(&self, _: &str) -> Result<Arc<[u8]>, String> {
        Ok(self.0.as_bytes().into())
    }
}

const CURVE: &str = "LUT_1D_SIZE 2\n0 0 0\n0.5 0.75 1\n";
const CUBE: &str = "LUT_3D_SIZE 2\n0 0 0\n1 0 0\n0 1 0\n1 1 0\n0 0 0.5\n1 0 0.5\n0 1 0.5\n1 1 0.5\n";
const STEPS: &str = r#"<ProcessList id="a" compCLFversion="3"><Matrix inBitDepth="32f" outBitDepth="32f">
    <Array dim="3 3">2 0 0 0 2 0 0 0 2</Array></Matrix></ProcessList>"#;

fn graded(file: &'static str, parameters: &str) -> Graph {
    let text = format!(
        r#"Pipeline(inputs: {{ "scene": Color }}, nodes: {{
            "exposed": Exposure(source: "scene", stops: 1.0),
            "look": ColorLut(source: "exposed", file: "look", {parameters}),
        }}, outputs: {{ "display": "look" }})"#
    );
    let registry = Registry::new(&[afterimage_nodes::ALL]).expect("no two kinds share a name");
    let document = parse("look.ron", &text).unwrap_or_else(|errors| panic!("{errors}"));
    let options = CheckOptions { loader: &File(file), ..CheckOptions::default() };
    check(&document, &registry, &options).unwrap_or_else(|errors| panic!("{errors}")).0
}

fn planned_to_set(graph: &Graph, name: &str) -> (Planned, ParameterId, [Value; 2]) {
    let parameter = graph.parameter(name).unwrap_or_else(|error| panic!("{error}"));
    let declaration = graph.declaration(parameter);
    let values = declaration.lowest().zip(declaration.middle()).expect("a number with a domain").into();
    (planned(graph, [parameter].into()), parameter, values)
}

/// Its file is read once, whatever it holds and however it is used.
#[test]
fn new_values_of_a_color_lut_do_not_read_its_file_again() {
    let looks = [
        (CURVE, "", "strength"),
        (CUBE, "", "strength"),
        (CUBE, "precision: Fast, interpolation: Trilinear", "strength"),
        (CUBE, "shaper: Log2", "high"),
        (CUBE, "from: Srgb, to: Srgb", "strength"),
        (CUBE, "from: AcesCct", "strength"),
        (STEPS, "", "strength"),
        (STEPS, "from: Srgb", "strength"),
    ];
    for (file, parameters, name) in looks {
        let graph = graded(file, parameters);
        let (mut planned, parameter, values) = planned_to_set(&graph, &format!("look.{name}"));
        let mut cache = PlanCache::new(graph);
        let cost = cost(&mut cache, &mut planned, parameter, &values).expect("its changes need no plan");
        assert_eq!((cost.allocations, cost.writes), (0, 4), "{parameters} {name} of {file}");
    }
}

/// While another thread reads the graph, a new value makes a copy of it: the counter counts.
#[test]
fn a_value_of_a_graph_that_is_in_use_allocates() {
    let graph = graded(CUBE, "");
    let (_, parameter, [value, _]) = planned_to_set(&graph, "look.strength");
    let mut cache = PlanCache::new(graph);
    let in_use = cache.shared_graph();
    let before = ALLOCATIONS.get();
    cache.set(parameter, value).unwrap_or_else(|why| panic!("{why}"));
    assert!(ALLOCATIONS.get() > before + in_use.nodes.len());
}

/// What was read belongs to the bytes: a file that is loaded again under its name has another table.
#[test]
fn a_file_that_is_loaded_again_is_read_again() {
    const OTHER: &str = "LUT_3D_SIZE 2\n0 0 0\n1 0 0\n0 1 0\n1 1 0\n0 0 0.25\n1 0 0.25\n0 1 0.25\n1 1 0.25\n";
    let table = |file| {
        let (planned, ..) = planned_to_set(&graded(file, ""), "look.strength");
        let constants = planned.plan.images.iter().filter_map(|image| match &image.origin {
            Origin::Constant(bytes) => Some(bytes.to_vec()),
            _ => None,
        });
        constants.collect::<Vec<_>>()
    };
    let [first, again, other] = [CUBE, CUBE, OTHER].map(table);
    assert_eq!((first.len(), &first), (1, &again));
    assert_ne!(first, other);
}
