//! The most expensive pipelines: what a limit refuses, and that what it accepts costs work in proportion to its size.

use afterimage_generators::{BOMBS, Bomb};
use afterimage_graph::check::limits::{MAX_FACTS, MAX_INPUTS, MAX_NODES, MAX_OUTPUTS, MAX_TIERS};
use afterimage_graph::check::{CheckOptions, Facts, Graph, check};
use afterimage_graph::diagnostic::Diagnostics;
use afterimage_graph::document::parse;
use afterimage_graph::node::{NodeKind, Origin, Registry};
use afterimage_graph::prelude::*;
use afterimage_plan::limits::{MAX_COMPUTED, MAX_COMPUTED_BYTES, MAX_PASSES, MAX_TABLE_BYTES};
use afterimage_plan::{
    Caps, HostImageDesc, HostInputs, Options, Plan, PlanError, PlanRequest, Requirement, plan, plan_without_tables,
    verify,
};

use super::support::all_formats;
use super::sweep;

static COPY: Shader = Shader::new("hold.wgsl", "fn hold(source: vec4f) -> vec4f { return source; }");

node_kind! {
    /// Holds tables.
    pub struct Hold {
        /// MiB of images.
        pub images: i32 = 0 => within(0.0..=1000.0);
        /// MiB of buffers.
        pub buffers: i32 = 0 => within(0.0..=1000.0);
        /// Computed images of 2 MiB.
        pub computed: i32 = 0 => within(0.0..=1000.0), replans();
        /// Bytes of a buffer.
        pub bytes: i32 = 0 => within(0.0..=1000.0);
    }

    const INPUTS: &'static [Input] = &[Input::image("source", "An image.")];
    const OUTPUTS: &'static [Output] = &[Output::image("result", OutputState::same("source"), "An image.")];
}

impl Node for Hold {
    fn record(&self, pass: &mut Recorder<'_>) {
        let mebibyte = ImageDesc::new(Size::new(512, 256));
        for number in 0..self.images {
            pass.constant(&format!("table{number}"), mebibyte, vec![number as u8; 1 << 20]);
        }
        for number in 0..self.buffers {
            let bytes = vec![number as u8; 1 << 20];
            pass.add_buffer(&format!("buffer{number}"), 1 << 20, BufferLife::Constant(bytes.into()));
        }
        for number in 0..self.computed {
            let desc = ImageDesc::new(Size::new(512, 512));
            pass.computed(&format!("computed{number}"), desc, || vec![number as u8; 2 << 20]);
        }
        if self.bytes > 0 {
            let bytes = vec![1; self.bytes as usize];
            pass.add_buffer("bytes", bytes.len() as u64, BufferLife::Constant(bytes.into()));
        }
        let source = pass.image("source");
        let desc = pass.desc(source);
        pass.function(&COPY, "hold").write("result", desc);
    }
}

fn bomb(name: &str, size: usize) -> Bomb {
    let (_, make) =
        BOMBS.iter().find(|(known, _)| *known == name).unwrap_or_else(|| panic!("no bomb is called {name}"));
    make(size)
}

fn checked(bomb: &Bomb) -> Result<Graph, Diagnostics> {
    let registry = Registry::new(&[afterimage_nodes::ALL]).expect("no two kinds share a name");
    let options = CheckOptions { loader: bomb, ..CheckOptions::default() };
    parse("bomb.ron", &bomb.text).and_then(|document| check(&document, &registry, &options)).map(|(graph, _)| graph)
}

fn accepted(name: &str, size: usize) -> Graph {
    checked(&bomb(name, size)).unwrap_or_else(|errors| panic!("{name} {size}: {errors}"))
}

fn planned(graph: &Graph) -> Result<Plan, PlanError> {
    plan(graph, &request(graph))
}

fn request(graph: &Graph) -> PlanRequest<'static> {
    let size = Size::new(3840, 2160);
    let given = HostImageDesc { desc: ImageDesc::new(size), finite: false };
    PlanRequest {
        given: HostInputs {
            inputs: graph.inputs.iter().map(|input| (input.name.clone(), given)).collect(),
            ..HostInputs::none(size)
        },
        facts: Facts::default(),
        caps: Caps { fast_workgroup_memory: true, ..all_formats() },
        options: Options::default(),
        dynamic: Default::default(),
        requirement: &Requirement::typical,
    }
}

#[test]
fn a_pipeline_at_a_limit_is_accepted_and_one_beyond_is_refused() {
    // A bomb, the largest size that is accepted, and the error of the next one.
    let limits = [
        ("points", MAX_NODES, "too-many-nodes"),
        ("inputs", MAX_INPUTS, "too-many-inputs"),
        ("inner-inputs", MAX_INPUTS, "too-many-inputs"),
        ("outputs", MAX_OUTPUTS, "too-many-outputs"),
        ("outputs-of-one", MAX_OUTPUTS, "too-many-outputs"),
        ("inner-outputs", MAX_OUTPUTS, "too-many-outputs"),
        ("tiers", MAX_TIERS, "too-many-tiers"),
        ("facts", MAX_FACTS - 1, "too-many-facts"),
        ("nested-names", 8, "long-name"),
        ("nested-labels", 8, "long-name"),
        ("nested-conditions", 3, "long-condition"),
    ];
    for (name, most, code) in limits {
        accepted(name, most);
        let errors = checked(&bomb(name, most + 1)).expect_err(name);
        let codes: Vec<&str> = errors.iter().map(|error| error.code).collect();
        assert!(codes.contains(&code), "{name}: {errors}");
    }
}

#[test]
fn a_file_counts_as_often_as_it_is_used() {
    for (name, size, code) in [
        ("nested", 4 * MAX_NODES, "too-many-nodes"),
        ("nested-facts", 1000, "too-many-facts"),
        ("nested-tiers", 1000, "too-many-tiers"),
        ("nested-comments", 1000, "too-much-text"),
        ("extends", 12_000, "too-much-text"),
    ] {
        let errors = checked(&bomb(name, size)).expect_err(name);
        assert!(errors.iter().any(|error| error.code == code), "{name}: {errors}");
        let of_limits = errors.iter().filter(|error| error.code == code).count();
        assert_eq!(of_limits, 1, "{name}: {errors}");
    }
    accepted("nested", MAX_NODES / 2);
    accepted("nested-comments", 100);
}

/// A plan that is only looked at is refused for the same reasons.
#[test]
fn a_plan_of_too_many_passes_or_too_large_tables_is_refused_with_the_node() {
    let error = planned(&accepted("pyramids", MAX_NODES)).expect_err("a pyramid has many passes");
    let PlanError::TooManyPasses(node) = &error else { panic!("{error}") };
    assert!(error.to_string().contains(&format!("`{node}` have more than {MAX_PASSES} passes")), "{error}");
    let refused = |name, size| {
        let graph = accepted(name, size);
        let error = planned(&graph).expect_err(name);
        assert_eq!(plan_without_tables(&graph, &request(&graph)).as_ref(), Err(&error), "{name}");
        error
    };
    let error = refused("transforms", MAX_COMPUTED + 1);
    assert_eq!(error, PlanError::TooManyTables(format!("n{MAX_COMPUTED}")));
    assert!(planned(&accepted("transforms", MAX_COMPUTED)).is_ok());
}

#[test]
fn a_plan_without_tables_is_the_same_but_for_the_texels_that_nodes_compute() {
    let blank = |plan: Plan| -> (Vec<u64>, Plan) {
        let (mut sums, mut plan) = (Vec::new(), plan);
        for image in &mut plan.images {
            if let Origin::Constant(bytes) = &mut image.origin {
                sums.push(bytes.iter().map(|byte| u64::from(*byte)).sum());
                *bytes = vec![0; bytes.len()].into();
            }
        }
        (sums, plan)
    };
    let graph = accepted("transforms", 1);
    let (with, without) = (planned(&graph), plan_without_tables(&graph, &request(&graph)));
    let (with, without) = (blank(with.expect("one table")), blank(without.expect("one table")));
    assert!(with.0.len() == 1 && with.0[0] > 0, "{:?}", with.0);
    assert_eq!(without.0, [0]);
    assert_eq!(with.1, without.1);
}

/// The graph of a text with nodes that hold tables.
fn holding(text: &str) -> Graph {
    let registry = Registry::new(&[&[NodeKind::of::<Hold>()]]).expect("it is one kind");
    let checked = parse("hold.ron", text).and_then(|document| check(&document, &registry, &CheckOptions::default()));
    checked.unwrap_or_else(|errors| panic!("{errors}")).0
}

#[test]
fn tables_that_nodes_compute_are_refused_beyond_their_limit() {
    let computing = |count: u64| {
        let node = format!("\"n\": Hold(source: \"in\", computed: {count})");
        holding(&format!("Pipeline(inputs: {{\"in\": Color}}, nodes: {{{node}}}, outputs: {{\"out\": \"n\"}})"))
    };
    let most = MAX_COMPUTED_BYTES / (2 << 20);
    assert!(planned(&computing(most)).is_ok());
    let (node, bytes) = ("n".to_owned(), MAX_COMPUTED_BYTES + (2 << 20));
    let error = PlanError::TooLargeTables { node, bytes, limit: MAX_COMPUTED_BYTES };
    let graph = computing(most + 1);
    assert_eq!(planned(&graph).as_ref(), Err(&error));
    assert_eq!(plan_without_tables(&graph, &request(&graph)).as_ref(), Err(&error));
}

/// Tables of images and of buffers count together, over all nodes, to the last byte.
#[test]
fn tables_are_refused_beyond_their_limit() {
    let held = |nodes: &[(i32, i32, i32)]| {
        let node = |(at, (images, buffers, bytes)): (usize, &(i32, i32, i32))| {
            let source = if at == 0 { "in".to_owned() } else { format!("n{}", at - 1) };
            format!("\"n{at}\": Hold(source: \"{source}\", images: {images}, buffers: {buffers}, bytes: {bytes}), ")
        };
        let text: String = nodes.iter().enumerate().map(node).collect();
        let outputs = format!("\"out\": \"n{}\"", nodes.len() - 1);
        let text = format!("Pipeline(inputs: {{\"in\": Color}}, nodes: {{{text}}}, outputs: {{{outputs}}})");
        planned(&holding(&text))
    };
    let most = (MAX_TABLE_BYTES >> 20) as i32;
    assert!(held(&[(most / 2, most / 2, 0)]).is_ok());
    assert!(held(&[(most / 4, most / 4, 0), (most / 2, 0, 0)]).is_ok());
    for (nodes, node, bytes) in [
        (vec![(most, 0, 1)], "n0", MAX_TABLE_BYTES + 1),
        (vec![(0, most, 4)], "n0", MAX_TABLE_BYTES + 4),
        (vec![(most / 2, 0, 0), (most / 4, most / 4, 8)], "n1", MAX_TABLE_BYTES + 8),
    ] {
        let error = held(&nodes).expect_err("it is too much");
        assert_eq!(error, PlanError::TooLargeTables { node: node.into(), bytes, limit: MAX_TABLE_BYTES });
    }
}

/// Chains are cut into passes of a bounded size, so that no name, label or kernel is copied for each node after it.
#[test]
fn a_chain_of_thousands_of_points_is_cut_into_passes_of_a_bounded_size() {
    let nodes = 5000;
    let plan = planned(&accepted("points", nodes)).unwrap_or_else(|error| panic!("{error}"));
    let kernels: Vec<usize> = plan.work().map(|pass| pass.kernels.len()).collect();
    assert_eq!(kernels.iter().sum::<usize>(), nodes);
    assert!(kernels.iter().all(|count| *count <= 24), "{kernels:?}");
    let names: usize = plan.savings.fused.iter().map(|fused| fused.nodes.len()).sum();
    assert!(names <= 24 * nodes, "{names} names of fused nodes");
    assert_eq!(verify(&plan), Ok(()));
}

#[test]
fn every_bomb_of_a_moderate_size_is_planned_and_verified_or_refused() {
    let (mut plans, size) = (0, sweep::cases(200) as usize);
    for (name, _) in BOMBS {
        match checked(&bomb(name, size)) {
            Ok(graph) => {
                let plan = planned(&graph);
                if let Ok(plan) = &plan {
                    assert_eq!(verify(plan), Ok(()), "{name}");
                    plans += 1;
                }
                assert!(plan.is_ok() || *name == "transforms", "{name}");
            }
            Err(errors) => assert!(errors.iter().any(|error| !error.code.is_empty()), "{name}"),
        }
    }
    assert!(plans >= 18, "only {plans} bombs are planned");
}

/// A hint compares a name with all others, so a text with thousands of errors has a bounded number of them.
#[test]
fn only_the_first_errors_have_hints() {
    for name in ["inner-inputs", "unknown-names", "unknown-fields", "unknown-outputs", "unknown-facts", "unknown-kinds"]
    {
        let errors = checked(&bomb(name, 2000)).expect_err(name);
        let hints = errors.iter().filter(|error| error.help.as_ref().is_some_and(|help| help.contains("did you mean")));
        assert!(errors.len() > 1500, "{name} has {} errors", errors.len());
        assert!((1..=100).contains(&hints.count()), "{name}");
    }
}

#[test]
fn a_frame_has_at_most_the_memory_that_the_device_may_give() {
    let graph = accepted("points", 4);
    let memory = planned(&graph).expect("all memory is allowed").memory;
    let given = request(&graph).given.inputs.values().map(|image| image.desc.bytes()).sum::<u64>();
    let bytes = memory.placed + memory.kept + given;
    assert!(given > 0 && memory.kept > 0, "{memory:?}");
    let with = |max_memory: u64| {
        let mut request = request(&graph);
        request.caps.max_memory = max_memory;
        plan(&graph, &request).map(|_| ())
    };
    assert_eq!(with(bytes), Ok(()));
    assert_eq!(with(bytes - 1), Err(PlanError::TooMuchMemory { bytes, limit: bytes - 1 }));
}
