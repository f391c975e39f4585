//! What hosts bring of their own: a task pool, tools that read labels, subscribers of spans.

use std::cell::RefCell;
use std::collections::BTreeMap;
use std::sync::{Arc, Mutex};

use afterimage_gpu::Task;
use afterimage_graph::check::Facts;
use afterimage_nodes::Curve;
use tracing::span::{Attributes, Id, Record};
use tracing::{Event, Metadata, Subscriber};

use super::{Host, assert_same, fresh};
use crate::support::gpu::changed;

/// Tasks that a host has been given and has not run.
type Tasks = Arc<Mutex<Vec<Task>>>;

fn collecting(host: &mut Host) -> Tasks {
    let tasks = Tasks::default();
    let given = tasks.clone();
    host.post.set_task_pool(Arc::new(move |task| given.lock().unwrap().push(task)));
    tasks
}

#[test]
#[cfg_attr(no_gpu, ignore = "AFTERIMAGE_NO_GPU is set")]
fn plans_are_made_in_the_pool_of_the_host_when_it_likes() {
    let mut host = Host::new(changed("caracal.ron", None, &[]));
    let tasks = collecting(&mut host);
    // A first frame waits for its plan, also if no task helps it.
    let lit = host.shown();
    tasks.lock().unwrap().clear();
    host.post.set_fact("emissive", false);
    assert_same(&host.shown(), &lit);
    let task = tasks.lock().unwrap().pop().expect("a plan is to be made");
    // Threads of engines have small stacks.
    let thread = std::thread::Builder::new().stack_size(2 << 20).spawn(task).unwrap();
    thread.join().expect("the task does not panic");
    host.frame().unwrap();
    assert!(!host.post.is_changing());
    let mut dark = Host::new(changed("caracal.ron", None, &[]));
    dark.post.set_fact("emissive", false);
    let dark = dark.shown();
    assert!(dark != lit);
    assert_same(&host.shown(), &dark);
}

#[test]
#[cfg_attr(no_gpu, ignore = "AFTERIMAGE_NO_GPU is set")]
fn a_task_that_the_pool_drops_is_reported_once_and_the_old_plan_renders_on() {
    let mut host = Host::new(changed("caracal.ron", None, &[]));
    let tasks = collecting(&mut host);
    let before = host.shown();
    host.post.set_fact("emissive", false);
    host.frame().unwrap();
    tasks.lock().unwrap().clear();
    let errors: Vec<String> = (0..3).filter_map(|_| host.frame().err()).map(|error| error.to_string()).collect();
    assert_eq!(errors, ["the task pool of the host has dropped the task that makes the next plan"]);
    assert_same(&host.shown(), &before);
}

/// What was begun before a change comes in after it, and must not pass for what was asked last.
#[test]
#[cfg_attr(no_gpu, ignore = "AFTERIMAGE_NO_GPU is set")]
fn a_plan_that_comes_in_late_does_not_replace_a_later_change() {
    let run = |tasks: &Tasks| tasks.lock().unwrap().drain(..).for_each(|task| task());
    let settle = |host: &mut Host, tasks: &Tasks| {
        for _ in 0..6 {
            run(tasks);
            host.frame().unwrap();
        }
        assert!(!host.post.is_changing());
    };
    let mut host = Host::new(changed("lynx.ron", None, &[]));
    let tasks = collecting(&mut host);
    let curve = host.post.parameter::<Curve>("mapped.curve").unwrap();
    host.frame().unwrap();
    for wanted in [Curve::Reinhard, Curve::Hable] {
        host.post.set(curve, wanted).unwrap();
        host.frame().unwrap();
    }
    settle(&mut host, &tasks);
    assert_same(&host.shown(), &fresh("lynx.ron", None, &[("mapped.curve", "Hable")]));
    // Another pipeline, while the plan of a fact is being made, and a parameter that both have.
    let mut host = Host::new(changed("caracal.ron", None, &[]));
    let tasks = collecting(&mut host);
    let strength = host.post.parameter::<f32>("lit.strength").unwrap();
    host.frame().unwrap();
    host.post.set_fact("emissive", false);
    host.frame().unwrap();
    host.post.change(changed("lynx.ron", None, &[]));
    host.post.set_facts(Facts::default());
    for value in [0.1, 0.5] {
        host.post.set(strength, value).unwrap();
        host.frame().unwrap();
    }
    settle(&mut host, &tasks);
    assert_same(&host.shown(), &fresh("lynx.ron", None, &[("lit.strength", "0.5")]));
}

#[test]
#[cfg_attr(no_gpu, ignore = "AFTERIMAGE_NO_GPU is set")]
fn passes_with_labels_compute_the_same() {
    let mut host = Host::new(changed("lynx.ron", None, &[]));
    host.post.label_passes(true);
    assert_same(&host.shown(), &fresh("lynx.ron", None, &[]));
    host.post.label_passes(false);
    assert_same(&host.shown(), &fresh("lynx.ron", None, &[]));
}

thread_local! {
    /// The spans of the framework on this thread, by their names.
    static SPANS: RefCell<BTreeMap<&'static str, usize>> = RefCell::default();
}

/// Counts spans. It is the subscriber of all threads, because `tracing` remembers for each span of the code whether
/// anybody listens.
struct Counted;

impl Subscriber for Counted {
    fn enabled(&self, metadata: &Metadata<'_>) -> bool {
        metadata.is_span() && metadata.name().starts_with("afterimage::")
    }

    fn new_span(&self, span: &Attributes<'_>) -> Id {
        SPANS.with_borrow_mut(|spans| *spans.entry(span.metadata().name()).or_default() += 1);
        Id::from_u64(1)
    }

    fn record(&self, _: &Id, _: &Record<'_>) {}
    fn record_follows_from(&self, _: &Id, _: &Id) {}
    fn event(&self, _: &Event<'_>) {}
    fn enter(&self, _: &Id) {}
    fn exit(&self, _: &Id) {}
}

#[test]
#[cfg_attr(no_gpu, ignore = "AFTERIMAGE_NO_GPU is set")]
fn frames_and_plans_are_spans() {
    let mut host = Host::new(changed("caracal.ron", None, &[]));
    // Tasks are done at once, on this thread.
    host.post.set_task_pool(Arc::new(|task| task()));
    tracing::subscriber::set_global_default(Counted).expect("no other test has one");
    SPANS.take();
    host.frame().unwrap();
    host.post.set_fact("emissive", false);
    host.frame().unwrap();
    host.frame().unwrap();
    let wanted = [
        ("afterimage::compile", 2),
        ("afterimage::frame", 3),
        ("afterimage::load", 2),
        ("afterimage::plan", 1),
        ("afterimage::prepare", 1),
    ];
    assert_eq!(SPANS.take(), BTreeMap::from(wanted));
}
