//! The plans of the built-in pipelines.

use afterimage_graph::check::Facts;
use afterimage_graph::image::Format;
use afterimage_plan::{Caps, Options, verify};

use super::planned::{all_formats, built_in, pipelines, plan_images};

/// The files in the folder: a new one is tested without being named here.
fn files() -> Vec<String> {
    let entries = std::fs::read_dir(pipelines()).expect("the repository has pipelines");
    let names = entries.map(|entry| entry.expect("a folder can be listed").file_name());
    let names = names.map(|name| name.into_string().expect("names are UTF-8"));
    let names: Vec<String> = names.filter(|name| name.ends_with(".ron")).collect();
    assert!(names.len() >= 6, "only {names:?}");
    names
}

#[test]
fn every_plan_is_verified_and_equal_when_made_again() {
    for name in files() {
        let graph = built_in(&name);
        for caps in [Caps::default(), all_formats()] {
            for serial in [false, true] {
                let options = Options { serial, ..Options::default() };
                let plan = || plan_images(&graph, Format::Rgba32Float, Facts::default(), caps.clone(), options);
                verify(&plan()).unwrap_or_else(|faults| panic!("{name}: {faults:?}"));
                assert_eq!(plan().hash(), plan().hash(), "{name}");
            }
        }
    }
}
